//! Poses that a tracker computes from signals: coplanar coils, and coils that hardly determine a pose.

use super::prelude::*;
use nalgebra::{DMatrix, Rotation3};
use std::f64::consts::TAU;
use trackwright_field::generator::reading::{LEVER_MM, read_axis};
use trackwright_field::generator::{Coil, Generator, MIN_COILS};
use trackwright_geometry::volume::Volume;

const POSITION: Quantity = Quantity::new(
    "position that is read, mm",
    20.0,
    "the signals' norm over what a mm least determined changes them by",
    "1 mm",
);

const DIRECTION: Quantity =
    Quantity { name: "axis that is read, rad", scale: "1 mm at the lever of 100 mm", ..POSITION };

const SIGNALS: Quantity = Quantity::new(
    "signals of the pose that is read",
    20.0,
    "what a move by the distance from the generator changes the signals by, over their norm",
    "the signals' norm",
);

pub(super) fn family(extent: Extent) -> Family {
    let count = extent.of(40, 8);
    let at = |k: usize| 120.0 * k as f64 - 120.0;
    let grid = (0..9).map(|k| vertical([at(k / 3), at(k % 3), 0.0]));
    let five = Generator::planar_nine().coils.into_iter().take(5);
    let generators = [
        ("nine coplanar dipoles of nine directions, in the cube", Generator::planar_nine()),
        ("eight coplanar loops, all vertical, in the cube", Generator::anser()),
        ("nine coplanar dipoles, all vertical, in the cube", generator(grid)),
        ("five coplanar dipoles, in the cube", generator(five)),
    ];
    let rings = [1, 3, 5, 6, 7, 8, 10, 13].map(|exponent| {
        (format!("a ring, two coils moved by 1e-{exponent} of its radius"), exponent)
    });
    Family::new(
        "readings",
        "Signals of another pose as those of a disturbed field: the pose that is read has to \
            be that one, or there is none. Where the signals hardly determine the pose it is as far \
            off as their round-off moves it. Of five coils several poses have the same signals: they \
            are compared instead.",
        &[POSITION, DIRECTION, SIGNALS],
    )
    .with(generators, move |_, generator| {
        let mut sequence = Sequence::new(5);
        let bounds = Volume::AuroraCube.bounds();
        let mut rows: Vec<_> = (0..count)
            .flat_map(|_| {
                let (p, n) = (sequence.point_in(&bounds), sequence.axis());
                let turn = UnitQuaternion::from_scaled_axis(sequence.vector() * 0.05);
                rows(generator, (&p, &n), (&(p + sequence.vector() * 5.0), &(turn * n)))
            })
            .collect();
        // Where no pose is read comes last, whichever place it was.
        rows.sort_by_key(|row| row.quantity);
        Ok(rows)
    })
    .with(rings, |_, &exponent| Ok(ring(exponent)))
}

/// On its axis a ring of vertical dipoles has two patterns to show two shifts and two turns; two coils
/// that are not on it add two.
fn ring(exponent: i32) -> Vec<Row> {
    let moved = 100.0 * 10.0_f64.powi(-exponent);
    let coil = |k: usize| {
        let turn = Rotation3::from_axis_angle(&Vector3::z_axis(), k as f64 * TAU / 8.0);
        let shift = moved * [0.0, 1.0, 0.0, 0.7, 0.0, 0.0, 0.0, 0.0][k];
        let at = turn * Vector3::new(100.0 + shift, 0.0, 0.3 * shift);
        vertical(at.into())
    };
    let ring = generator((0..8).map(coil));
    let (p, n) = (Point3::new(0.0, 0.0, -200.0), Vector3::z_axis());
    // Farther off the signals may be nearest to those of a pose on the other side of the axis.
    let shift = Vector3::new(0.4, -0.3, 0.2) * (0.01 * moved);
    let mut rows = rows(&ring, (&p, &n), (&(p + shift), &n));
    // Singular values fall with the coil's move; below 1e-7 the generator is refused.
    if exponent >= 10 {
        let is_refused = ring.check_determines(&Volume::AuroraCube).is_err();
        rows.push(must("the generator is refused", is_refused));
    }
    rows
}

fn vertical(at: [f64; 3]) -> Coil {
    Coil::Dipole { at_mm: at.into(), moment: Vector3::z() }
}

fn generator(coils: impl Iterator<Item = Coil>) -> Generator {
    Generator { name: "of the battery".to_owned(), coils: coils.collect() }
}

/// Position and axis of a sensor.
type At<'a> = (&'a Point3<f64>, &'a Unit<Vector3<f64>>);

/// A sensor at `p` along `n` whose signals are those at `other_p` along `other_n`.
fn rows(generator: &Generator, (p, n): At<'_>, (other_p, other_n): At<'_>) -> Vec<Row> {
    let signals: Vec<f64> =
        generator.coils.iter().map(|coil| coil.field(other_p).dot(other_n)).collect();
    let disturbance: Vec<Vector3<f64>> = generator
        .coils
        .iter()
        .zip(&signals)
        .map(|(coil, signal)| n.into_inner() * (signal - coil.field(p).dot(n)))
        .collect();
    let Ok(reading) = read_axis(generator, p, n, &disturbance) else {
        return vec![must("the right pose, or none", true)];
    };
    let jacobian = jacobian(generator, other_p, other_n);
    let norm = signals.iter().map(|s| s * s).sum::<f64>().sqrt();
    if generator.coils.len() == MIN_COILS {
        let read = generator.coils.iter().map(|c| c.field(&reading.position_mm).dot(&reading.axis));
        let squares = read.zip(&signals).map(|(read, signal)| (read - signal).powi(2));
        let condition = jacobian.norm() * other_p.coords.norm() / norm;
        return vec![SIGNALS.row(condition, squares.sum::<f64>().sqrt(), norm)];
    }
    let condition = norm / jacobian.singular_values().min();
    let turned = (reading.axis.as_ref() - other_n.as_ref()).norm();
    vec![
        DIRECTION.row(condition, turned, 1.0 / LEVER_MM),
        POSITION.row(condition, (reading.position_mm - other_p).norm(), 1.0),
    ]
}

/// Of the signals by position in mm and by turns in mm at the lever.
fn jacobian(generator: &Generator, p: &Point3<f64>, n: &Unit<Vector3<f64>>) -> DMatrix<f64> {
    let tangent = trackwright_geometry::rotation::perpendicular(n);
    let turns = [tangent.into_inner(), n.cross(&tangent)];
    DMatrix::from_fn(generator.coils.len(), 5, |i, j| {
        let (field, gradient) = generator.coils[i].field_and_gradient(p);
        match j {
            0..3 => n.dot(&gradient.column(j)),
            _ => turns[j - 3].dot(&field) / LEVER_MM,
        }
    })
}
