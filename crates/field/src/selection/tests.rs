//! Selection against what is known: data whose order is known, fits done one by one, groups.

use super::cross_validation::{self, Problem, Split};
use super::folds::Folds;
use super::*;
use crate::evaluation::OutsidePolicy;
use crate::fit::{FitError, FitMethod, fit};
use crate::random_models::Seeded;
use crate::samples::{PoseError, Sample, SampleSet};
use nalgebra::{Point3, Unit, Vector3};
use std::sync::{Arc, Mutex};
use trackwright_geometry::bounds::Bounds;
use trackwright_geometry::directions::DirectionSet;
use trackwright_task::{CancelToken, Cancelled, Task};

/// Numbers from -1 to 1 that are the same each time.
struct Random(Seeded);

impl Random {
    fn new(seed: u64) -> Self {
        Self(Seeded::new(seed))
    }

    fn vector(&mut self) -> Vector3<f64> {
        Vector3::from_fn(|_, _| 2.0 * self.0.uniform() - 1.0)
    }

    fn position(&mut self) -> Point3<f64> {
        Point3::from(self.vector() * 100.0)
    }
}

/// Samples at scattered poses; `error` gives position and rotation errors there.
fn samples(
    count: usize,
    random: &mut Random,
    mut error: impl FnMut(&Point3<f64>, &mut Random) -> Vector3<f64>,
) -> SampleSet {
    let samples = (0..count)
        .map(|_| {
            let position_mm = random.position();
            Sample::new(
                position_mm,
                Unit::new_normalize(random.vector()),
                PoseError {
                    position_mm: error(&position_mm, random),
                    rotation_rad: error(&position_mm, random) * 0.01,
                },
            )
        })
        .collect();
    SampleSet { samples, has_rotations: true, ambiguous: 0 }
}

/// A polynomial with every product of powers up to 2, and noise of 0.05 mm.
fn quadratic(count: usize) -> SampleSet {
    samples(count, &mut Random::new(3), |p, random| {
        let u = p.coords / 100.0;
        let field = Vector3::new(
            u.x * u.x * u.y - u.z,
            u.y * u.z * u.z + 0.3 * u.x,
            u.x * u.x * u.y * u.y * u.z * u.z + 1.0,
        );
        field + random.vector() * 0.05
    })
}

fn settings(set: &SampleSet, orders: &[usize], sets: &[DirectionSet]) -> SelectSettings {
    SelectSettings {
        orders: orders.to_vec(),
        direction_sets: sets.to_vec(),
        ..SelectSettings::for_samples(set)
    }
}

fn run(
    set: &SampleSet,
    groups: Option<&[usize]>,
    settings: &SelectSettings,
) -> Result<Selection, SelectError> {
    select(set, groups, settings, &Task::default())
}

#[test]
fn a_noisy_polynomial_of_order_two_is_recognised() {
    let set = quadratic(600);
    let tried = settings(&set, &[0, 1, 2, 3, 4], &[DirectionSet::One, DirectionSet::Six]);
    let found = run(&set, None, &tried).unwrap();
    let best = found.best().candidate;
    assert_eq!((best.order, best.directions), (2, DirectionSet::One));
    // Uniform noise of ±0.05 mm an axis has an RMS of 0.05 mm, and 27 coefficients of 480 rows add
    // about 3 % to it.
    let rms = found.best().by_row.unwrap().position_rms_mm;
    assert!((0.045..0.06).contains(&rms), "{rms}");
}

#[test]
fn pure_noise_is_not_corrected() {
    let set = samples(400, &mut Random::new(5), |_, random| random.vector());
    let tried = settings(&set, &[0, 1, 2, 3], &[DirectionSet::One, DirectionSet::Six]);
    let found = run(&set, None, &tried).unwrap();
    assert_eq!(found.best().candidate.order, 0);
    assert_eq!(found.best().candidate.coefficients(), 0);
}

#[test]
fn groups_are_not_predicted_by_neighbours() {
    // Each of 60 places has an error of its own that is independent of the other places, and
    // was measured eight times.
    let mut random = Random::new(11);
    let places: Vec<_> = (0..60).map(|_| (random.position(), random.vector())).collect();
    let groups: Vec<usize> = (0..480).map(|i| i % 60).collect();
    let samples = groups
        .iter()
        .map(|&place| {
            Sample::new(
                places[place].0 + random.vector() * 0.01,
                Vector3::z_axis(),
                PoseError {
                    position_mm: places[place].1 + random.vector() * 0.01,
                    rotation_rad: Vector3::zeros(),
                },
            )
        })
        .collect();
    let set = SampleSet { samples, has_rotations: false, ambiguous: 0 };
    let tried = settings(&set, &[0, 1, 2], &[DirectionSet::One]);
    let found = run(&set, Some(&groups), &tried).unwrap();
    assert_eq!(found.groups, Some(60));
    assert_eq!(found.best().candidate.order, 0);
    let uncorrected = found.table[0].by_row.unwrap().position_rms_mm;
    let order_two = found
        .table
        .iter()
        .find(|row| row.candidate.order == 2 && row.candidate.ridge == 0.0)
        .unwrap();
    assert!(order_two.by_row.unwrap().position_rms_mm < 0.9 * uncorrected);
    assert!(order_two.by_group.unwrap().position_rms_mm > 1.2 * uncorrected);
    // Row by row the leak decides.
    let leaking = run(&set, None, &tried).unwrap();
    assert!(leaking.best().candidate.order > 0);
}

/// Scores of one candidate by fits done one by one, each from its samples.
fn one_by_one(set: &SampleSet, tried: &SelectSettings, candidate: &Candidate) -> Scores {
    let bounds = Bounds::around(set.samples.iter().map(|s| s.position_mm)).unwrap();
    let folds = Folds::of_rows(set.samples.len(), tried.folds, tried.seed);
    let (mut position, mut rotation, mut max) = (0.0, 0.0, 0.0_f64);
    for held_out in &folds.rows {
        let mut rest = set.clone();
        let mut row = 0..;
        rest.samples.retain(|_| !held_out.contains(&row.next().unwrap()));
        let model = fit(&rest, &tried.fit_settings(candidate), Some(bounds)).unwrap().model;
        for &row in held_out {
            let s = &set.samples[row];
            let e = model.evaluate(&s.position_mm, &s.axis, OutsidePolicy::Clamp);
            let left = (s.error.position_mm - e.error.position_mm).norm();
            position += left * left;
            max = max.max(left);
            rotation += (s.error.rotation_rad - e.error.rotation_rad).norm_squared();
        }
    }
    let n = set.samples.len() as f64;
    Scores {
        position_rms_mm: (position / n).sqrt(),
        position_max_mm: max,
        angle_rms_rad: Some((rotation / n).sqrt()),
    }
}

#[test]
fn every_score_is_that_of_fits_done_one_by_one() {
    let set = quadratic(120);
    for method in [FitMethod::PerDirection, FitMethod::Joint] {
        let tried = SelectSettings {
            ridges: vec![0.0, 1e-3, 0.1],
            folds: 3,
            method,
            ..settings(&set, &[0, 1, 2], &[DirectionSet::One, DirectionSet::Six])
        };
        let found = run(&set, None, &tried).unwrap();
        for row in &found.table {
            let exact = one_by_one(&set, &tried, &row.candidate);
            let close = |a: f64, b: f64, what: &str| {
                // Condition numbers here are below 1e4, so round-off stays below 1e-11.
                assert!((a - b).abs() <= 1e-10 * b, "{what} {:?}: {a} {b}", row.candidate);
            };
            close(row.by_row.unwrap().position_rms_mm, exact.position_rms_mm, "RMS");
            close(row.by_row.unwrap().position_max_mm, exact.position_max_mm, "max");
            let angles = (row.by_row.unwrap().angle_rms_rad, exact.angle_rms_rad);
            close(angles.0.unwrap(), angles.1.unwrap(), "angle");
        }
    }
}

#[test]
fn the_number_of_threads_changes_no_bit() {
    let set = quadratic(300);
    let groups: Vec<usize> = (0..300).map(|i| i / 10).collect();
    let tried = settings(&set, &[0, 1, 2, 3], &[DirectionSet::One, DirectionSet::Six]);
    let with = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        pool.unwrap().install(|| run(&set, Some(&groups), &tried).unwrap())
    };
    assert_eq!(with(1), with(4));
}

#[test]
fn undetermined_models_are_not_chosen() {
    // Order 2 has 27 coefficients, and 30 rows in 3 folds leave 20 to fit.
    let set = quadratic(30);
    let tried = SelectSettings { folds: 3, ..settings(&set, &[0, 1, 2], &[DirectionSet::One]) };
    let found = run(&set, None, &tried).unwrap();
    for row in &found.table {
        assert_eq!(row.is_determined, row.candidate.order < 2);
    }
    assert!(found.best().candidate.order < 2);
    // Where nothing else is tried, it is what there is.
    let only = SelectSettings { orders: vec![2], ..tried };
    assert_eq!(run(&set, None, &only).unwrap().best().candidate.order, 2);
}

/// All axes along two directions of twelve.
fn two_directions(count: usize) -> SampleSet {
    let mut random = Random::new(17);
    let mut set = samples(count, &mut random, |p, random| p.coords / 100.0 + random.vector() * 0.1);
    let known = DirectionSet::Twelve.directions();
    for (i, sample) in set.samples.iter_mut().enumerate() {
        sample.axis = known[i % 2];
    }
    set
}

#[test]
fn mostly_under_sampled_models_are_refused() {
    let set = two_directions(200);
    let tried = settings(&set, &[0, 1], &[DirectionSet::One, DirectionSet::Twelve]);
    let found = run(&set, None, &tried).unwrap();
    for row in &found.table {
        let is_of_twelve = row.candidate.directions == DirectionSet::Twelve;
        assert_eq!(row.is_under_sampled(), is_of_twelve, "{row:?}");
        // All held-out rows are judged by the two orientations that are sampled.
        assert!(row.is_determined);
    }
    assert_eq!(found.best().candidate.directions, DirectionSet::One);
    let only = settings(&set, &[1], &[DirectionSet::Twelve]);
    let found = run(&set, None, &only).unwrap();
    assert!(found.best().is_under_sampled() && found.best().under_sampled == 10);
}

/// Three sensors in each of 60 poses, with offsets of their own along X.
fn sensors_in_poses() -> (SampleSet, Vec<usize>, Vec<usize>) {
    const OFFSETS_MM: [f64; 3] = [-2.0, 0.0, 2.0];
    let mut random = Random::new(23);
    let mut set = samples(180, &mut random, |p, random| p.coords / 100.0 + random.vector() * 0.1);
    let sensors: Vec<usize> = (0..180).map(|row| row % 3).collect();
    let poses: Vec<usize> = (0..180).map(|row| row / 3).collect();
    for (row, &sensor) in sensors.iter().enumerate() {
        let pose = set.samples[3 * poses[row]].position_mm;
        let sample = &mut set.samples[row];
        sample.position_mm = pose + random.vector() * 10.0;
        sample.error.position_mm = sample.position_mm.coords / 100.0
            + Vector3::x() * OFFSETS_MM[sensor]
            + random.vector() * 0.1;
    }
    (set, sensors, poses)
}

#[test]
fn poses_and_sensors_are_both_held_out() {
    let (set, sensors, poses) = sensors_in_poses();
    let tried = settings(&set, &[0, 1], &[DirectionSet::One]);
    let by = |deciding| {
        let hold_outs = HoldOuts {
            groups: Some(&poses),
            sensors: Some(&sensors),
            deciding,
            ..HoldOuts::default()
        };
        select_by(&set, &hold_outs, &tried, &Task::default()).unwrap()
    };
    let found = by(None);
    assert_eq!(found.decided_by, HoldOutBy::Groups);
    let counts: Vec<_> = found.hold_outs.iter().map(|h| (h.by, h.folds, h.count)).collect();
    assert_eq!(
        counts,
        [(HoldOutBy::Rows, 5, 180), (HoldOutBy::Groups, 5, 60), (HoldOutBy::Sensors, 3, 3)]
    );
    let best = found.best();
    let [poses_mm, sensors_mm] = [HoldOutBy::Groups, HoldOutBy::Sensors]
        .map(|by| best.held_out_by(by).unwrap().position_rms_mm);
    // Offsets of ±2 mm have an RMS of 1.63; a sensor that was left out is off by 1.5 times its own.
    assert!((1.55..1.75).contains(&poses_mm), "{poses_mm}");
    assert!((2.35..2.6).contains(&sensors_mm), "{sensors_mm}");
    assert_eq!(*best.deciding(), best.by_group.unwrap());
    // Their standard deviation is 2 mm, with two degrees of freedom.
    let spread = found.sensors.unwrap();
    assert!((spread.position_std_dev_mm()[0] - 2.0).abs() < 0.1, "{spread:?}");
    assert!(spread.position_std_dev_mm()[1] < 0.1, "{spread:?}");
    assert_eq!(spread.degrees_of_freedom, 2);
    for deciding in [HoldOutBy::Rows, HoldOutBy::Sensors] {
        let found = by(Some(deciding));
        assert_eq!(found.decided_by, deciding);
        let best = found.best();
        assert_eq!(best.deciding(), best.held_out_by(deciding).unwrap());
    }
}

#[test]
fn residuals_score_as_their_candidate_does() {
    let (set, sensors, _) = sensors_in_poses();
    let tried = settings(&set, &[1], &[DirectionSet::Six]);
    let hold_outs = HoldOuts {
        sensors: Some(&sensors),
        deciding: Some(HoldOutBy::Sensors),
        ..HoldOuts::default()
    };
    let found = select_by(&set, &hold_outs, &tried, &Task::default()).unwrap();
    let folds = Folds::of_groups(&sensors, 3, 3, tried.seed);
    let bounds = Bounds::around(set.samples.iter().map(|s| s.position_mm)).unwrap();
    let (problem, split) = (Problem::without_places(&set, bounds), Split::new(&set, folds.clone()));
    let task = Task::default();
    for row in found.table.iter().take(3) {
        let left = cross_validation::residuals(&problem, &row.candidate, &split, &tried, &task);
        let scores = scoring::of_residuals(&left.unwrap(), &folds);
        let (a, b) = (scores.overall.position_rms_mm, row.deciding().position_rms_mm);
        // Each ridge is solved from the same decomposition; sums are taken in another order.
        assert!((a - b).abs() < 1e-12 * b, "{a} {b}");
    }
}

#[test]
fn single_sensors_are_refused_only_if_requested() {
    let (set, _, poses) = sensors_in_poses();
    let tried = settings(&set, &[0, 1], &[DirectionSet::One]);
    let one = vec![4; 180];
    let by = |sensors, groups, deciding| {
        let hold_outs =
            HoldOuts { groups, sensors, deciding, has_few_groups: true, only_deciding: false };
        select_by(&set, &hold_outs, &tried, &Task::default())
    };
    let found = by(Some(one.as_slice()), Some(poses.as_slice()), None).unwrap();
    assert_eq!((found.hold_outs.len(), found.sensors), (2, None));
    let refused = |sensors, groups, deciding| by(sensors, groups, Some(deciding)).unwrap_err();
    assert_eq!(refused(Some(one.as_slice()), None, HoldOutBy::Sensors), SelectError::FewSensors(1));
    assert_eq!(refused(None, None, HoldOutBy::Sensors), SelectError::NothingToHoldOut("sensors"));
    assert_eq!(refused(None, None, HoldOutBy::Groups), SelectError::NothingToHoldOut("groups"));
    assert_eq!(
        refused(None, Some(one.as_slice()), HoldOutBy::Groups),
        SelectError::FewerGroupsThanFolds { groups: 1, folds: 2 }
    );
}

#[test]
fn joint_models_beyond_the_rows_are_left_out() {
    let set = quadratic(100);
    let tried = SelectSettings {
        method: FitMethod::Joint,
        ..settings(&set, &[0, 1, 2], &[DirectionSet::Six])
    };
    let found = run(&set, None, &tried).unwrap();
    assert_eq!(found.left_out, [(2, DirectionSet::Six)]);
    assert!(found.table.iter().all(|row| row.candidate.order < 2));
}

#[test]
fn what_cannot_be_selected_states_why() {
    let set = quadratic(20);
    let good = settings(&set, &[0, 1], &[DirectionSet::One]);
    let error = |change: &dyn Fn(&mut SelectSettings)| {
        let mut wrong = good.clone();
        change(&mut wrong);
        run(&set, None, &wrong).unwrap_err()
    };
    assert_eq!(error(&|s| s.folds = 1), SelectError::Folds(1));
    assert_eq!(error(&|s| s.folds = 21), SelectError::FewerRowsThanFolds { rows: 20, folds: 21 });
    assert_eq!(error(&|s| s.orders.clear()), SelectError::NothingToTry("orders"));
    assert_eq!(error(&|s| s.ridges.clear()), SelectError::NothingToTry("ridges"));
    assert_eq!(error(&|s| s.orders.push(13)), FitError::Order(13).into());
    assert_eq!(error(&|s| s.ridges.push(-0.1)), FitError::Ridge(-0.1).into());
    assert!(matches!(error(&|s| s.ridges.push(f64::NAN)), SelectError::Fit(FitError::Ridge(_))));
    assert_eq!(error(&|s| s.rcond = 1.0), FitError::Rcond(1.0).into());
    let groups: Vec<usize> = (0..20).map(|i| i / 7).collect();
    assert_eq!(
        run(&set, Some(&groups), &good),
        Err(SelectError::FewerGroupsThanFolds { groups: 3, folds: 5 })
    );
    assert_eq!(
        run(&set, Some(&groups[1..]), &good),
        Err(SelectError::GroupCount { found: 19, expected: 20 })
    );
    let mut flat = set.clone();
    flat.has_rotations = false;
    let many = settings(&set, &[1], &[DirectionSet::Six]);
    assert_eq!(run(&flat, None, &many), Err(FitError::NeedsOneDirection(6).into()));
    let mut wrong = set.clone();
    wrong.samples[7].error.position_mm.y = f64::INFINITY;
    assert_eq!(run(&wrong, None, &good), Err(SelectError::NotFinite(7)));
    wrong.samples.clear();
    assert_eq!(run(&wrong, None, &good), Err(SelectError::NoSamples));
}

#[test]
fn selection_reports_progress_and_stops() {
    let set = quadratic(60);
    let tried = settings(&set, &[0, 1, 2], &[DirectionSet::One, DirectionSet::Six]);
    let token = CancelToken::default();
    token.cancel();
    assert_eq!(
        select(&set, None, &tried, &Task::cancelled_by(token)),
        Err(SelectError::Cancelled(Cancelled))
    );
    let received = Arc::new(Mutex::new(Vec::new()));
    let task = Task::with_progress({
        let received = received.clone();
        move |part| received.lock().unwrap().push(part)
    });
    select(&set, None, &tried, &task).unwrap();
    let most = received.lock().unwrap().iter().copied().fold(0.0, f64::max);
    assert!((most - 1.0).abs() < 1e-9, "{most}");
}
