//! Agreement of recordings whose truth is known.

use crate::support::studies::{cancelled, default_design};
use nalgebra::{Point3, UnitQuaternion};
use std::sync::Arc;
use trackwright_calibration::agreement::judge::{bias, limits_of_agreement};
use trackwright_calibration::agreement::noise::Noise;
use trackwright_calibration::agreement::resampling::Sums;
use trackwright_calibration::agreement::*;
use trackwright_calibration::pivot::{PivotLimits, pivot};
use trackwright_field::Environment;
use trackwright_field::environment::Jitter;
use trackwright_field::random_models::{Seeded, random_model};
use trackwright_geometry::directions::{DirectionSet, Weighting};
use trackwright_geometry::pose::{Pose, pose_from_parts};
use trackwright_geometry::rotation::exp_vector;
use trackwright_simulation::{InputTrial, Mode, Scenario, run};
use trackwright_task::{CancelToken, Task};

type Vector = nalgebra::Vector3<f64>;

/// The built-in pointer, seen from the tracker, in a smooth room of some millimetres.
fn scenario(seed: u64) -> Scenario {
    let design = default_design();
    let model = random_model(2, DirectionSet::Six, Weighting::Area, [2.0, 0.01], seed);
    Scenario {
        environment: Arc::new(Environment {
            model,
            jitter: None,
            fit_validity: None,
            process: None,
            ..(*design.environment).clone()
        }),
        crf: None,
        crf_from_tool: pose_from_parts(Vector::new(0.0, 0.0, -300.0), UnitQuaternion::identity()),
        ..design
    }
}

fn true_poses(count: usize, seed: u64) -> Vec<Pose> {
    let mut seeded = Seeded::new(seed);
    (0..count)
        .map(|_| {
            let mut any = |size: f64| Vector::from_fn(|_, _| (seeded.uniform() - 0.5) * size);
            let at = Vector::new(0.0, 0.0, -300.0) + any(150.0);
            pose_from_parts(at, exp_vector(&any(1.0)))
        })
        .collect()
}

/// What the tracker would report according to the study.
fn read(scenario: &Scenario, poses: &[Pose]) -> Vec<Pose> {
    let given = poses.iter().map(|pose| InputTrial::at(*pose));
    let mut read = Vec::new();
    let mut log = |trial: &trackwright_simulation::Trial| read.push(trial.crf_from_tool_simulated);
    let mode = Mode::Input(given.collect());
    run(scenario, &mode, &CancelToken::default(), Some(&mut log)).unwrap();
    read
}

fn recorded(truth: &[Pose], measured: &[Pose]) -> Vec<RecordedPose> {
    let pairs = truth.iter().zip(measured).enumerate();
    pairs
        .map(|(group, (truth, measured))| RecordedPose {
            tracker_from_crf: None,
            crf_from_tool: *truth,
            crf_from_tool_measured: *measured,
            group,
        })
        .collect()
}

fn exact_rows(scenario: &Scenario, count: usize) -> Vec<AgreementRow> {
    let truth = true_poses(count, 11);
    let measured = read(scenario, &truth);
    paired_rows(scenario, &recorded(&truth, &measured), &Task::default()).unwrap()
}

fn quick() -> AgreementSettings {
    AgreementSettings { resamples: 400, ..AgreementSettings::default() }
}

fn judged(scenario: &Scenario, rows: Vec<AgreementRow>) -> Summary {
    agreement(scenario, rows, &quick(), &Task::default()).unwrap().summary
}

fn normal(seeded: &mut Seeded) -> Vector {
    Vector::from_fn(|_, _| seeded.normal())
}

#[test]
fn a_recording_as_predicted_is_explained_completely() {
    let scenario = scenario(1);
    let found = judged(&scenario, exact_rows(&scenario, 40));
    assert!(found.position_mm.measured.rms() > 0.5, "{found:?}");
    // Poses of half a metre, fitted once here and once there.
    assert!(found.position_mm.residual.max() < 1e-11, "{found:?}");
    for compared in [&found.position_mm, found.angle_deg.as_ref().unwrap()] {
        for figure in [compared.explained, compared.explained_of_variation, compared.slope] {
            let figure = figure.unwrap();
            assert!((figure.value - 1.0).abs() < 1e-12, "{figure:?}");
            assert!(figure.low.unwrap() > 1.0 - 1e-12 && figure.high.unwrap() < 1.0 + 1e-12);
        }
    }
    assert_eq!(found.verdict, Verdict::Explains);
    assert!(found.statement.contains("explains 100 %"), "{}", found.statement);
}

#[test]
fn a_constant_tip_error_is_found_with_its_interval() {
    let scenario = scenario(2);
    let mut seeded = Seeded::new(5);
    let added = Vector::new(0.4, -0.2, 0.1);
    let mut rows = exact_rows(&scenario, 80);
    for row in &mut rows {
        row.measured_mm += added + normal(&mut seeded) * 0.1;
    }
    let found = judged(&scenario, rows);
    let bias = found.position_mm.bias.unwrap();
    let half = bias.half_width.unwrap();
    for k in 0..3 {
        // One seed, within twice the 95 % interval, which is as wide as noise of 0.1 makes it.
        assert!((bias.mean[k] - added[k]).abs() < 2.0 * half[k], "{bias:?}");
        assert!((0.015..0.045).contains(&half[k]), "{bias:?}");
    }
    assert!(bias.p.unwrap() < 1e-9);
    assert!(found.statement.contains("same at all poses"), "{}", found.statement);
}

#[test]
fn figures_are_those_of_numpy_and_scipy() {
    // Thirty vectors of sines; explained, slope, t, F and Bland and Altman's limits were computed
    // from the textbook formulas with numpy 2.4.6 and scipy 1.17.1 (`t.ppf`, `f.sf`, `norm.ppf`).
    let pairs: Vec<(Vector, Vector)> = (0..30)
        .map(|i| {
            let i = f64::from(i);
            let m = Vector::new(
                (1.7 * i).sin() + 0.4,
                0.5 * (2.3 * i).cos(),
                0.3 * (0.9 * i * i).sin(),
            );
            let off = Vector::new(
                0.2 * (3.1 * i).sin() - 0.1,
                0.15 * (5.3 * i).cos(),
                0.1 * (2.2 * i * i).sin(),
            );
            (m, 0.8 * m + off)
        })
        .collect();
    let mut sums = Sums::default();
    for (m, p) in &pairs {
        sums += &Sums::of(m, p);
    }
    let near = |found: f64, expected: f64| {
        assert!((found / expected - 1.0).abs() < 1e-6, "{found} {expected}");
    };
    near(sums.explained().unwrap(), 0.894_645_532_125_836_4);
    near(sums.explained_of_variation().unwrap(), 0.915_494_313_198_180_3);
    near(sums.slope().unwrap(), 1.216_009_375_746_528_2);
    let bias = bias(&pairs, 30.0);
    let means = [0.175_312_68, 0.000_955_87, 0.002_092_01];
    let halves = [0.070_579_11, 0.047_556_2, 0.028_865_31];
    for k in 0..3 {
        assert!((bias.mean[k] - means[k]).abs() < 1e-8);
        assert!((bias.half_width.unwrap()[k] - halves[k]).abs() < 1e-8);
    }
    near(bias.p.unwrap(), 0.000_518_254_553_300_326_1);
    let limits = limits_of_agreement(&pairs, 30.0).unwrap();
    near(limits.bias.value, 0.164_923_052_282_753_06);
    near(limits.bias.high.unwrap() - limits.bias.value, 0.065_111_080_109_751_31);
    near(limits.lower.value, -0.176_837_190_646_212_73);
    near(limits.upper.value, 0.506_683_295_211_718_8);
    near(limits.upper.value - limits.upper.low.unwrap(), 0.112_530_360_261_358_2);
}

/// Three standard deviations of a part of 0.95 among 200 trials.
const OF_200: f64 = 3.0 * 0.0154;

#[test]
fn only_noise_of_the_stated_size_is_accepted() {
    let mut scenario = scenario(3);
    Arc::make_mut(&mut scenario.environment).jitter = Some(Jitter::uniform(0.3, 0.004));
    let exact = exact_rows(&scenario, 60);
    let noise = Noise::new(&scenario, 1.0, 0.0);
    let scatters: Vec<_> =
        exact.iter().map(|row| noise.at(row).unwrap().cholesky().unwrap().l()).collect();
    let mut seeded = Seeded::new(6);
    let (mut accepted, mut accepted_more, mut falsely_biased) = (0, 0, 0);
    for _ in 0..200 {
        for (size, count) in [(1.0, &mut accepted), (1.3, &mut accepted_more)] {
            let mut rows = exact.clone();
            for (row, scatter) in rows.iter_mut().zip(&scatters) {
                row.measured_mm += scatter * normal(&mut seeded) * size;
            }
            let settings = AgreementSettings { resamples: 200, ..quick() };
            let found = agreement(&scenario, rows, &settings, &Task::default()).unwrap();
            let check = found.summary.noise.unwrap();
            let [low, high] = check.accepted.unwrap();
            *count += usize::from((low..=high).contains(&check.normalised));
            if size == 1.0 {
                let p = found.summary.position_mm.bias.unwrap().p.unwrap();
                falsely_biased += usize::from(p < 0.05);
            }
        }
    }
    let part = |count: usize| count as f64 / 200.0;
    assert!(part(accepted) > 0.95 - OF_200, "{accepted}");
    // 1.69 times the variance, where noise of 180 components is within 1.21 of it.
    assert!(part(accepted_more) < 0.05, "{accepted_more}");
    assert!(part(falsely_biased) < 0.05 + OF_200, "{falsely_biased}");
}

#[test]
fn another_room_explains_nothing_and_is_called_so() {
    let (own, other) = (scenario(4), scenario(5));
    let truth = true_poses(60, 12);
    let measured = read(&own, &truth);
    let rows = paired_rows(&other, &recorded(&truth, &measured), &Task::default()).unwrap();
    let found = judged(&other, rows);
    assert!(found.position_mm.explained.unwrap().value < 0.0, "{found:?}");
    let is_refused =
        matches!(found.verdict, Verdict::WorseThanNothing | Verdict::NoBetterThanNothing);
    assert!(is_refused, "{}", found.statement);
    assert!(found.statement.contains("predicting no error at all"));
}

#[test]
fn correlated_noise_does_not_narrow_the_intervals() {
    const A: f64 = 0.8;
    let scenario = scenario(6);
    let exact = exact_rows(&scenario, 400);
    let mut seeded = Seeded::new(7);
    let (mut mean_held, mut part_held, mut naive_held, mut mean_effective) = (0, 0, 0, 0.0);
    for _ in 0..200 {
        let mut rows = exact.clone();
        let (mut error, mut noise) = (Vector::zeros(), Vector::zeros());
        for row in &mut rows {
            error = error * A + normal(&mut seeded);
            noise = noise * A + normal(&mut seeded) * 0.5;
            row.predicted_mm = error;
            row.measured_mm = error + noise;
            row.measured_rad = None;
        }
        let found = judged(&scenario, rows);
        mean_effective += found.effective / 200.0;
        let bias = found.position_mm.bias.unwrap();
        let half = bias.half_width.unwrap()[0];
        mean_held += usize::from(bias.mean[0].abs() < half);
        let as_if_independent = half * (found.effective / 400.0).sqrt();
        naive_held += usize::from(bias.mean[0].abs() < as_if_independent);
        let part = found.position_mm.explained.unwrap();
        // Squares of 1 and of 0.25 of them.
        let truth = 1.0 - 0.25 / 1.25;
        part_held += usize::from((part.low.unwrap()..=part.high.unwrap()).contains(&truth));
    }
    // (1 − a) / (1 + a) of 400 are 44.
    assert!((33.0..=60.0).contains(&mean_effective), "{mean_effective}");
    let part = |count: usize| f64::from(count as u32) / 200.0;
    let all = format!("{mean_held} {part_held} {naive_held}");
    // Blocks of a series with 44 effective poses are known to cover a few percent less than
    // stated; as if poses were independent it would be some half.
    assert!(part(mean_held) > 0.95 - 0.04 - OF_200, "{all}");
    assert!(part(part_held) > 0.95 - 0.04 - OF_200, "{all}");
    assert!(part(naive_held) < 0.65, "{all}");
}

#[test]
fn no_choice_of_axes_changes_the_summary() {
    let scenario = scenario(8);
    let mut seeded = Seeded::new(9);
    let mut rows = exact_rows(&scenario, 50);
    for row in &mut rows {
        row.measured_mm += normal(&mut seeded) * 0.7;
        row.measured_rad = row.measured_rad.map(|r| r + normal(&mut seeded) * 0.003);
    }
    let frame =
        pose_from_parts(Vector::new(700.0, -50.0, 90.0), exp_vector(&Vector::new(1.0, -0.4, 2.0)));
    let turned: Vec<AgreementRow> = rows
        .iter()
        .map(|row| AgreementRow {
            crf_from_tool: frame * row.crf_from_tool,
            measured_mm: frame.rotation * row.measured_mm,
            predicted_mm: frame.rotation * row.predicted_mm,
            measured_rad: row.measured_rad.map(|r| frame.rotation * r),
            predicted_rad: frame.rotation * row.predicted_rad,
            ..*row
        })
        .collect();
    for unknowns in [Unknowns::None, Unknowns::Registration, Unknowns::Pivot] {
        let settings = AgreementSettings { unknowns, ..quick() };
        let [a, b] = [&rows, &turned].map(|rows| {
            agreement(&scenario, rows.clone(), &settings, &Task::default()).unwrap().summary
        });
        let numbers = |s: &Summary| {
            let mut all = vec![s.effective, s.block];
            for compared in [&s.position_mm, s.angle_deg.as_ref().unwrap()] {
                for i in [compared.explained, compared.explained_of_variation, compared.slope] {
                    let i = i.unwrap();
                    all.extend([i.value, i.low.unwrap(), i.high.unwrap()]);
                }
                all.extend([compared.residual.rms(), compared.measured.p95()]);
                all.extend(compared.bias.map(|bias| bias.p.unwrap()));
            }
            all
        };
        for (a, b) in numbers(&a).into_iter().zip(numbers(&b)) {
            assert!((a - b).abs() < 1e-8 * a.abs().max(1.0), "{unknowns:?}: {a} {b}");
        }
        assert_eq!(a.verdict, b.verdict);
    }
}

#[test]
fn errors_absorbed_by_registration_are_not_residual() {
    let scenario = scenario(10);
    let mut rows = exact_rows(&scenario, 50);
    let tip = scenario.tool.judged_tip_in_body();
    let (shift, turn) = (Vector::new(1.0, 2.0, -0.5), Vector::new(0.01, -0.02, 0.005));
    let carried = Vector::new(0.3, -0.8, 0.1);
    for row in &mut rows {
        let at = (row.crf_from_tool * tip).coords;
        row.measured_mm += shift + turn.cross(&at) + row.crf_from_tool.rotation * carried;
    }
    let of = |unknowns| {
        let settings = AgreementSettings { unknowns, ..quick() };
        agreement(&scenario, rows.clone(), &settings, &Task::default()).unwrap().summary
    };
    assert!(of(Unknowns::None).position_mm.residual.rms() > 1.0);
    let registered = of(Unknowns::Registration);
    assert!(registered.position_mm.residual.max() < 1e-10, "{registered:?}");
    assert!(registered.position_mm.measured.rms() > 0.1);
    assert!(registered.position_mm.bias.is_none());
}

#[test]
fn a_pivot_in_a_distorted_room_is_explained_by_it() {
    let scenario = scenario(13);
    let (tip, rest) = (Point3::new(0.4, -0.3, -1.0), Point3::new(10.0, 20.0, -250.0));
    let mut seeded = Seeded::new(14);
    let truth: Vec<Pose> = (0..60)
        .map(|_| {
            let turn = exp_vector(&Vector::from_fn(|_, _| seeded.uniform() - 0.5));
            pose_from_parts(rest.coords - turn * tip.coords, turn)
        })
        .collect();
    let measured = read(&scenario, &truth);
    let limits = PivotLimits { max_rms_mm: 1e3, ..PivotLimits::default() };
    let found = pivot(&measured, &limits).unwrap();
    let (with_tip, rows) = pivot_rows(&scenario, &measured, &found, &Task::default()).unwrap();
    let settings = AgreementSettings { unknowns: Unknowns::Pivot, ..quick() };
    let judged = agreement(&with_tip, rows, &settings, &Task::default()).unwrap();
    let position = &judged.summary.position_mm;
    // What `pivot` leaves is what there is to explain; it took out a shift of the tip in the axes as
    // they were read, some 0.01 rad off.
    assert!((position.measured.rms() / found.rms_mm - 1.0).abs() < 0.02);
    assert!(found.rms_mm > 0.1, "{}", found.rms_mm);
    // Wherever the distorted poses put the tip, that shift is taken out; what is left is how near
    // the eighth step comes to the true poses.
    assert!(position.residual.max() < 1e-6, "{position:?}");
    assert!(judged.summary.angle_deg.is_none() && position.bias.is_none());
}

#[test]
fn unusable_recordings_are_refused_with_the_reason() {
    let scenario = scenario(15);
    let refused = |rows: Vec<AgreementRow>, settings: AgreementSettings| {
        agreement(&scenario, rows, &settings, &Task::default()).unwrap_err()
    };
    let rows = exact_rows(&scenario, 20);
    let mut huge = rows.clone();
    huge[3].measured_mm.x = 1e200;
    assert_eq!(refused(huge, quick()), AgreementError::NotFinite(3));
    let wrong = AgreementSettings { averaged: 0.0, ..quick() };
    assert!(refused(rows.clone(), wrong).to_string().contains("mean of"));
    let without_doubtful = AgreementSettings { keeps_unsupported: false, ..quick() };
    assert_eq!(refused(rows.clone(), without_doubtful), AgreementError::NoSupport);

    let mut truth = true_poses(20, 3);
    truth[4].translation.vector.x = f64::INFINITY;
    let rows = paired_rows(&scenario, &recorded(&truth, &truth), &Task::default());
    assert_eq!(rows, Err(AgreementError::NotFinite(4)));
    let mut single = scenario.clone();
    single.tool.sensors.truncate(1);
    let truth = true_poses(20, 3);
    let rows = paired_rows(&single, &recorded(&truth, &truth), &Task::default());
    assert!(matches!(rows, Err(AgreementError::FreeRotation { .. })), "{rows:?}");
    let stopped = paired_rows(&scenario, &recorded(&truth, &truth), &cancelled());
    assert!(stopped.is_err());
}

#[test]
fn rows_of_few_groups_count_at_most_once_per_group() {
    let scenario = scenario(16);
    let mut seeded = Seeded::new(17);
    let mut rows = exact_rows(&scenario, 60);
    for (index, row) in rows.iter_mut().enumerate() {
        row.measured_mm += normal(&mut seeded);
        row.group = index / 20;
    }
    let found = judged(&scenario, rows);
    assert!(found.effective <= 3.0);
    assert_eq!(found.verdict, Verdict::TooFewIndependent);
    assert!(found.position_mm.explained.unwrap().low.is_none());
    assert!(
        found.statement.contains("60 poses have an effective number of 3"),
        "{}",
        found.statement
    );
}

#[test]
fn noise_without_distortion_has_nothing_to_explain() {
    let mut scenario = scenario(18);
    Arc::make_mut(&mut scenario.environment).jitter = Some(Jitter::uniform(0.5, 0.01));
    let mut seeded = Seeded::new(19);
    let mut rows = exact_rows(&scenario, 60);
    for row in &mut rows {
        row.measured_mm = normal(&mut seeded) * 0.1;
        row.predicted_mm *= 0.01;
    }
    let found = judged(&scenario, rows);
    assert_eq!(found.verdict, Verdict::NothingToExplain, "{}", found.statement);
}
