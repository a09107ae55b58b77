//! What the order of a table's rows shows is named with its size, and nothing is where the order is only how a
//! grid was measured or a motion is stepped through.

use crate::rooms::tracker::{Random, Room, SensorPose};
use crate::rooms::{measurement, others};
use crate::support::studies::built_in;
use nalgebra::Vector3;
use trackwright_calibration::doubts::{PairedDoubts, PoseFrame, Suspicion};
use trackwright_field::samples::{Measurement, MeasurementContent};
use trackwright_project::builtin_names;
use trackwright_simulation::{CancelToken, Mode, Trial, run};

/// Of the simulated rooms; every second has wide coils and outliers.
const SEEDS: std::ops::Range<u64> = 0..4;

/// Rows of a path.
const ROWS: usize = 1_200;

/// Places along each edge of a grid, and axes at each.
const PLACES: usize = 5;
const AXES: usize = 8;

fn room(seed: u64) -> Room {
    Room::new(seed, seed % 2 == 1)
}

fn found(rows: &[Measurement], content: MeasurementContent) -> Vec<Suspicion> {
    PairedDoubts::of(rows, content, PoseFrame::Tracker)
}

/// Readings along a hand's path, so many rows late.
fn along_a_path(seed: u64, lag: f64) -> Vec<Suspicion> {
    let (room, mut random) = (room(seed), Random::new(seed));
    let path = others::poses(&room, "path", ROWS, &mut random);
    let late = |k: usize| -> Option<SensorPose> {
        let at = k as f64 - lag;
        let (before, part) = (at.floor(), at - at.floor());
        let [a, b] = [before, before + 1.0].map(|row| path.get(row as usize));
        let (a, b) = (a?, b?);
        let between = |a: &Vector3<f64>, b: &Vector3<f64>| a * (1.0 - part) + b * part;
        Some((between(&a.0, &b.0), between(&a.1, &b.1).normalize()))
    };
    let each = (3..ROWS - 3)
        .filter_map(|k| Some(measurement(&path[k], &room.measure(&late(k)?, &mut random)?)));
    found(&each.collect::<Vec<_>>(), MeasurementContent::FiveDof)
}

/// Readings anywhere in the volume, while metal answers more and more or the reference moves.
fn while_it_changes(
    seed: u64,
    gain: impl Fn(f64) -> f64,
    moved_mm: impl Fn(f64) -> f64,
) -> Vec<Suspicion> {
    let (room, mut random) = (room(seed), Random::new(seed));
    let poses = others::poses(&room, "box", ROWS, &mut random);
    let each = poses.iter().enumerate().filter_map(|(k, at)| {
        let t = k as f64 / ROWS as f64;
        let (p, n) = room.with_gain(gain(t)).measure(at, &mut random)?;
        Some(measurement(at, &(p + Vector3::z() * moved_mm(t), n)))
    });
    found(&each.collect::<Vec<_>>(), MeasurementContent::FiveDof)
}

#[test]
fn a_lag_along_a_path_is_named_in_rows() {
    for seed in SEEDS {
        assert_eq!(along_a_path(seed, 0.0), []);
        for lag in [-2.5, -1.0, 1.3, 2.0] {
            let found = along_a_path(seed, lag);
            let is_it = |s: &Suspicion| match s {
                Suspicion::Lag { rows, standard_error, .. } => {
                    (rows - lag).abs() < 4.0 * standard_error + 0.1
                }
                _ => false,
            };
            assert!(found.iter().any(is_it), "room {seed}, lag of {lag}: {found:?}");
        }
    }
}

#[test]
fn what_changes_with_time_is_named() {
    for seed in SEEDS {
        assert_eq!(while_it_changes(seed, |_| 1.0, |_| 0.0), []);
        let found = while_it_changes(seed, |_| 1.0, |t| 3.0 * t);
        let is_it = |s: &Suspicion| matches!(s, Suspicion::Drift { of_field: false, .. });
        assert!(found.iter().any(is_it), "room {seed}, moved: {found:?}");
        let found = while_it_changes(seed, |t| 0.3 + 1.4 * t, |_| 0.0);
        let is_it = |s: &Suspicion| matches!(s, Suspicion::Drift { of_field: true, .. });
        assert!(found.iter().any(is_it), "room {seed}, grown: {found:?}");
    }
}

/// The four coordinates of a grid's row, the outermost first, and whether every second line goes back.
fn grid_rows(order: [usize; 4], goes_back: bool) -> Vec<[usize; 4]> {
    let sizes = [PLACES, PLACES, PLACES, AXES];
    let count: usize = sizes.iter().product();
    let row = |index: usize| {
        let (mut left, mut at) = (index, [0; 4]);
        for &k in order.iter().rev() {
            let step = left % sizes[k];
            left /= sizes[k];
            at[k] = if goes_back && left % 2 == 1 { sizes[k] - 1 - step } else { step };
        }
        at
    };
    (0..count).map(row).collect()
}

#[test]
fn a_grid_measured_in_any_order_shows_no_change() {
    let mut orders = Vec::new();
    for code in 0..256_usize {
        let order = [code % 4, code / 4 % 4, code / 16 % 4, code / 64];
        if (0..4).all(|k| order.contains(&k)) {
            orders.push(order);
        }
    }
    assert_eq!(orders.len(), 24);
    for seed in SEEDS.take(2) {
        let (room, mut random) = (room(seed), Random::new(seed));
        let axes: Vec<Vector3<f64>> = (0..AXES).map(|_| random.direction()).collect();
        let mut reading = |[x, y, z, axis]: [usize; 4]| {
            let part = Vector3::new(x, y, z).map(|k| k as f64 / (PLACES - 1) as f64);
            let at = (room.min_mm + (room.max_mm - room.min_mm).component_mul(&part), axes[axis]);
            Some(measurement(&at, &room.measure(&at, &mut random)?))
        };
        let places = grid_rows([0, 1, 2, 3], false);
        let readings: Vec<_> = places.iter().map(|at| reading(*at)).collect();
        let of =
            |[x, y, z, axis]: [usize; 4]| readings[((x * PLACES + y) * PLACES + z) * AXES + axis];
        for order in &orders {
            for goes_back in [false, true] {
                let rows: Vec<Measurement> =
                    grid_rows(*order, goes_back).into_iter().filter_map(of).collect();
                let found = found(&rows, MeasurementContent::FiveDof);
                assert_eq!(found, [], "room {seed}, {order:?}, goes back: {goes_back}");
            }
        }
    }
}

#[test]
fn a_motion_stepped_through_shows_no_change() {
    for name in builtin_names() {
        let mut scenario = built_in(name);
        if let Some(crf) = scenario.crf.take() {
            scenario.crf_from_tool = crf.tracker_from_crf * scenario.crf_from_tool;
        }
        let mut trials: Vec<Measurement> = Vec::new();
        let mut visit = |trial: &Trial| {
            trials.push(Measurement {
                tracker_from_ideal: trial.crf_from_tool,
                tracker_from_measured: trial.crf_from_tool_simulated,
            });
        };
        run(&scenario, &Mode::Motion, &CancelToken::default(), Some(&mut visit)).unwrap();
        for every in [1, 2, 3, 7] {
            let rows: Vec<Measurement> = trials.iter().step_by(every).copied().collect();
            let found = found(&rows, MeasurementContent::SixDof);
            let of_order =
                |s: &&Suspicion| matches!(s, Suspicion::Lag { .. } | Suspicion::Drift { .. });
            assert_eq!(found.iter().find(of_order), None, "{name}, every {every}");
        }
    }
}
