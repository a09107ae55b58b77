//! What is counted once, what is missing, and where to go next.

use super::*;
use proptest::prelude::*;
use trackwright_simulation::Sensor;

fn cube() -> Coverage {
    Coverage::new(CoveragePlan { volume: Volume::AuroraCube, directions: DirectionSet::Six })
}

fn turned(at: [f64; 3], axis: Vector3<f64>) -> Pose {
    Sensor::five_dof("", at, Unit::new_normalize(axis)).body_from_sensor()
}

#[test]
fn repeated_samples_add_nothing() {
    let mut coverage = cube();
    let at = [1.0, 1.0, -299.0];
    assert!(coverage.add(&turned(at, Vector3::z())));
    assert!(!coverage.add(&turned([3.0, 2.0, -295.0], Vector3::new(0.1, 0.0, 1.0))));
    assert!(coverage.add(&turned(at, Vector3::x())));
    assert!(coverage.add(&turned([20.0, 1.0, -299.0], Vector3::z())));
    assert!(!coverage.add(&turned([0.0, 0.0, 10.0], Vector3::z())));
    let summary = coverage.summary();
    assert_eq!((summary.samples, summary.distinct, summary.outside), (5, 3, 1));
    assert_eq!((summary.cells, summary.cells_sampled), (1000, 1));
    let cell = coverage.cells().find(|cell| cell.samples > 0).unwrap();
    assert_eq!((cell.samples, cell.turned), (3, 2.0 / 6.0));
    assert!((cell.center_mm - Point3::new(25.0, 25.0, -275.0)).norm() < 1e-9);
}

#[test]
fn only_what_is_in_the_volume_counts_and_has_cells() {
    let mut coverage = Coverage::new(CoveragePlan {
        volume: Volume::AuroraDome,
        directions: DirectionSet::Fourteen,
    });
    let cells = coverage.cells().count() as f64;
    let of_box = coverage.cells.len() as f64;
    let bounds = Volume::AuroraDome.bounds();
    let part = Volume::AuroraDome.volume_mm3() / bounds.size_mm().product();
    // Cells of which half is inside: to a few in a hundred.
    assert!((cells / of_box - part).abs() < 0.03, "{} {part}", cells / of_box);
    let corner = bounds.min_mm + Vector3::repeat(1.0);
    assert!(!coverage.add(&turned(corner.into(), Vector3::z())));
    assert_eq!(coverage.summary().outside, 1);
}

#[test]
fn going_where_it_points_samples_every_cell_once() {
    let mut coverage = cube();
    let mut gone = 0;
    while let Some(next) = coverage.next_mm() {
        assert!(coverage.add(&turned(next.into(), Vector3::y())), "{next} was there");
        gone += 1;
        if gone == 9 {
            // The middle first, and then the corners: what a hand has to reach for.
            let corners = coverage.cells().filter(|cell| {
                let from_middle = cell.center_mm - Point3::new(0.0, 0.0, -300.0);
                cell.samples > 0 && from_middle.iter().all(|v| v.abs() > 200.0)
            });
            assert_eq!(corners.count(), 8);
        }
    }
    assert_eq!(gone, 1000);
    let summary = coverage.summary();
    assert_eq!(summary.cells_sampled, summary.cells);
    // All of one turn: the others are what is missing, and nothing can be fitted at them.
    assert_eq!(summary.least_direction().unwrap().1, 0);
    assert_eq!(summary.highest_order(), None);
}

#[test]
fn the_sparsest_orientation_decides_the_order() {
    let mut coverage = cube();
    for direction in DirectionSet::Six.directions() {
        for (x, y) in (0..6).flat_map(|x| (0..6).map(move |y| (x, y))) {
            let at = [f64::from(x) * 50.0 - 130.0, f64::from(y) * 50.0 - 130.0, -300.0];
            assert!(coverage.add(&turned(at, direction.into_inner())));
        }
    }
    // 36 each: 27 unknowns of order 2, 64 of order 3.
    let summary = coverage.summary();
    assert_eq!(summary.highest_order(), Some(2));
    assert_eq!(summary.samples_per_unknown(2), 36.0 / 27.0);
}

#[test]
fn flat_volumes_and_bad_numbers_are_harmless() {
    let flat = Bounds::from(([0.0, 0.0, -5.0], [1e7, 10.0, -5.0]));
    let mut coverage = Coverage::new(CoveragePlan {
        volume: Volume::Box(flat),
        directions: DirectionSet::FortyTwo,
    });
    assert_eq!(coverage.counts, [12, 1, 1]);
    assert!(coverage.add(&turned([5e6, 5.0, -5.0], Vector3::z())));
    for bad in [f64::NAN, f64::INFINITY, 1e300] {
        assert!(!coverage.add(&turned([bad, 5.0, -5.0], Vector3::z())));
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 64, failure_persistence: None, ..ProptestConfig::default() })]
    #[test]
    fn counts_are_those_of_their_sums_in_any_order(
        samples in prop::collection::vec(
            (prop::array::uniform3(-300.0..300.0f64), prop::array::uniform3(-1.0..1.0f64)), 1..60)
    ) {
        let poses: Vec<_> = (samples.iter())
            .filter(|(_, axis)| Vector3::from(*axis).norm() > 1e-3)
            .map(|(at, axis)| turned([at[0], at[1], at[2] - 300.0], Vector3::from(*axis)))
            .collect();
        let of = |poses: &mut dyn Iterator<Item = &Pose>| {
            let mut coverage = cube();
            let added = poses.filter(|pose| coverage.add(pose)).count() as u64;
            (coverage.summary(), added)
        };
        let (forth, added) = of(&mut poses.iter());
        let (back, _) = of(&mut poses.iter().rev());
        prop_assert_eq!(&forth, &back);
        prop_assert_eq!(forth.distinct, added);
        let by_direction: u64 = forth.by_direction.iter().map(|(_, n)| n).sum();
        prop_assert_eq!(by_direction, forth.distinct);
    }
}
