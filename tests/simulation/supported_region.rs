//! The region in which the model of a room is valid.

use crate::support::studies::default_in_polynomials;
use nalgebra::{Unit, Vector3};
use trackwright_field::Environment;
use trackwright_simulation::supported_region::*;
use trackwright_task::Task;

fn room() -> std::sync::Arc<Environment> {
    default_in_polynomials().environment
}

fn region(environment: &Environment, count: usize) -> SupportedRegion {
    let axis = Unit::new_normalize(Vector3::new(0.3, -0.5, 0.8));
    supported_region(environment, &axis, count, &Task::default()).unwrap()
}

#[test]
fn region_fraction_is_the_share_of_supported_points() {
    let room = room();
    let found = region(&room, 17);
    let support = room.fit_validity.as_ref().unwrap();
    let own = *room.model.bounds();
    // Halton points: 2,000 of them give a share to about 1 %.
    let halton = |mut i: usize, base: usize| {
        let (mut part, mut value) = (1.0, 0.0);
        while i > 0 {
            part /= base as f64;
            value += part * (i % base) as f64;
            i /= base;
        }
        value
    };
    let points = 2000;
    let supported = (1..=points)
        .filter(|&i| {
            let unit = Vector3::new(halton(i, 2), halton(i, 3), halton(i, 5));
            let at = own.min_mm + own.size_mm().component_mul(&unit);
            support.is_valid(&at, &found.axis)
        })
        .count();
    let share = supported as f64 / points as f64;
    // Beside that the surface is linear between points a sixteenth of the box apart.
    assert!((found.fraction - share).abs() < 0.03, "{} {share}", found.fraction);
    assert!((0.05..=1.0).contains(&found.fraction), "{}", found.fraction);
    assert_eq!(found.evaluations, 17 * 17 * 17);
}

#[test]
fn leverage_on_the_surface_is_the_samples_maximum() {
    let room = room();
    let found = region(&room, 33);
    let support = room.fit_validity.as_ref().unwrap();
    let positions = &found.surface.positions_mm;
    assert!(positions.len() > 100, "{}", positions.len());
    let mut shares: Vec<f64> = positions
        .iter()
        .map(|at| support.leverage_share(&room.model.bounds().clamp(at), &found.axis))
        .collect();
    shares.sort_by(f64::total_cmp);
    // Linear between points of the lattice, while leverage grows with a power.
    let (low, high) = (shares[shares.len() / 20], shares[shares.len() * 19 / 20]);
    assert!(low > 0.8 && high < 1.1, "{low} {high}");
}

#[test]
fn a_room_without_validity_has_no_supported_region() {
    let mut room = (*room()).clone();
    (room.fit_validity, room.process) = (None, None);
    let none = supported_region(&room, &Vector3::z_axis(), 9, &Task::default());
    let message = none.unwrap_err().to_string();
    assert!(message.contains("no model validity"), "{message}");
}
