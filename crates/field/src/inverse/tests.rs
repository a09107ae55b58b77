//! Distort, then compensate; maps that fold; readings that have no answer.

use super::*;
use crate::bernstein::coefficient_count;
use crate::computed::FieldSource;
use crate::gaussian::{GaussianField, Kriging};
use crate::generator::Generator;
use crate::harmonic::HarmonicModel;
use crate::harmonic::solid_harmonics::terms;
use crate::random_models::{Seeded, random_model, room};
use crate::samples::{MapKind, PoseError, Sample, SampleSet};
use nalgebra::{Point3, Unit, UnitQuaternion, Vector3};
use proptest::prelude::*;
use std::sync::Arc;
use trackwright_geometry::bounds::Bounds;
use trackwright_geometry::directions::Weighting;
use trackwright_geometry::pose::distances;

const SETS: [(DirectionSet, Weighting); 8] = [
    (DirectionSet::One, Weighting::Area),
    (DirectionSet::Six, Weighting::Area),
    (DirectionSet::Twelve, Weighting::Area),
    (DirectionSet::Fourteen, Weighting::Area),
    (DirectionSet::TwentySix, Weighting::Area),
    (DirectionSet::TwentySix, Weighting::Gnomonic),
    (DirectionSet::FortyTwo, Weighting::Area),
    (DirectionSet::FortyTwo, Weighting::Gnomonic),
];

fn undone(model: &DistortionModel, poses: &[Pose], outside: OutsidePolicy) -> Vec<Undistorted> {
    let measured: Vec<_> = poses.iter().map(|p| model.distort(p, outside).0).collect();
    undistort(model, &measured, outside, &Task::default()).unwrap()
}

/// Counts what converged; each such is the pose itself.
#[track_caller]
fn count_right(poses: &[Pose], found: &[Undistorted]) -> usize {
    let mut converged = 0;
    for (pose, found) in poses.iter().zip(found) {
        assert_eq!(found.pose.is_some(), found.state.has_answer());
        if found.state == InverseState::Converged {
            converged += 1;
            let (mm, rad) = distances(pose, &found.pose.unwrap());
            assert!(mm < 1e-9 && rad < 1e-12, "{mm:e} mm, {rad:e} rad: {found:?}");
            assert!(found.residual_mm < 1e-9 && found.residual_rad < 1e-12);
        }
    }
    converged
}

fn poses(count: usize, margin: f64, seed: u64) -> Vec<Pose> {
    let mut seeded = Seeded::new(seed);
    (0..count).map(|_| seeded.pose(&room(), margin)).collect()
}

#[test]
fn undistort_inverts_distort() {
    for (k, (set, weighting)) in SETS.into_iter().enumerate() {
        for order in 1..=6 {
            // Slopes of some n σ / size: 6 · 1 / 450 and 1.6 · 0.005 radians a radian.
            let model = random_model(order, set, weighting, [1.0, 0.005], (10 * k + order) as u64);
            let poses = poses(40, 0.0, order as u64);
            let found = undone(&model, &poses, OutsidePolicy::Clamp);
            let converged = count_right(&poses, &found);
            // A jump of weights may come to lie beside an axis, with a chance of some 1e-4.
            let least = if weighting == Weighting::Area { 39 } else { 40 };
            assert!(converged >= least, "{set:?} {weighting:?} {order}: {converged}");
        }
    }
}

/// Models that are no polynomials: a process of drawn samples, and coils with weak harmonics.
fn computed_models() -> [DistortionModel; 2] {
    let mut seeded = Seeded::new(8);
    let samples = (0..200).map(|_| {
        let pose = seeded.pose(&room(), 0.0);
        let p: Point3<f64> = pose.translation.vector.into();
        let wave = |k: f64| (p.x / 170.0 + k).sin() * (p.z / 210.0 - k).cos();
        Sample::new(
            p,
            pose.rotation * Vector3::z_axis(),
            PoseError {
                position_mm: Vector3::new(wave(0.0), wave(1.0), wave(2.0)) * 2.0,
                rotation_rad: Vector3::new(wave(3.0), wave(4.0), wave(5.0)) * 0.01,
            },
        )
    });
    let samples = SampleSet { samples: samples.collect(), has_rotations: true, ambiguous: 0 };
    let process = GaussianField::fit(&samples, None, &Task::default()).unwrap();
    let kriging = Kriging::new(Arc::new(process), &Task::default()).unwrap();
    let generator = Generator::planar_nine();
    let count = generator.coils.len() * terms(3);
    let coefficients = (0..count).map(|i| 1e-12 * (1.7 * i as f64).sin());
    let center_mm = Point3::new(0.0, 0.0, -300.0);
    let harmonic =
        HarmonicModel::new(generator, center_mm, 433.0, 3, coefficients.collect()).unwrap();
    [FieldSource::Kriging(Arc::new(kriging)), FieldSource::Harmonic(Arc::new(harmonic))]
        .map(|source| DistortionModel::of_source(source, MapKind::Distortion, room()))
}

#[test]
fn undistort_inverts_computed_models() {
    for model in computed_models() {
        let poses = poses(40, 0.0, 5);
        let moved: f64 = poses
            .iter()
            .map(|pose| distances(pose, &model.distort(pose, OutsidePolicy::Clamp).0).0)
            .fold(0.0, f64::max);
        assert!(moved > 0.1, "{:?}: {moved}", model.kind());
        let found = undone(&model, &poses, OutsidePolicy::Clamp);
        let converged = count_right(&poses, &found);
        assert_eq!(converged, 40, "{:?}: {found:?}", model.kind());
    }
}

#[test]
fn computed_derivatives_are_differences() {
    for model in computed_models() {
        for pose in poses(10, 0.0, 9) {
            let p: Point3<f64> = pose.translation.vector.into();
            let n = pose.rotation * Vector3::z_axis();
            let there = model.evaluate_with_jacobian(&p, &n, OutsidePolicy::Clamp);
            let at = |p: &Point3<f64>| model.evaluate(p, &n, OutsidePolicy::Clamp).error;
            let h = 0.01;
            for k in 0..3 {
                let step = Vector3::ith(k, h);
                let change =
                    (at(&(p + step)).position_mm - at(&(p - step)).position_mm) / (2.0 * h);
                let found = there.by_position.fixed_view::<3, 1>(0, k);
                assert!((change - found).norm() < 1e-6, "{:?}: {change} {found}", model.kind());
            }
            assert!((there.by_axis * n.as_ref()).norm() < 1e-9);
        }
    }
}

#[test]
fn strong_fields_are_inverted_or_flagged() {
    for (k, (set, weighting)) in SETS.into_iter().enumerate() {
        for order in [1, 3] {
            let mut converged = 0;
            for (size_mm, size_rad) in [(10.0, 0.1), (40.0, 0.3), (150.0, 1.0)] {
                let model = random_model(order, set, weighting, [size_mm, size_rad], 90 + k as u64);
                let poses = poses(30, 0.0, order as u64);
                let found = undone(&model, &poses, OutsidePolicy::Clamp);
                converged += count_right(&poses, &found);
            }
            assert!(converged >= 20, "{set:?} {weighting:?} {order}: {converged}");
        }
    }
}

#[test]
fn positions_outside_follow_the_policy() {
    for (set, weighting) in SETS {
        let model = random_model(2, set, weighting, [2.0, 0.01], 4);
        let poses = poses(60, 0.2, 8);
        for outside in [OutsidePolicy::Clamp, OutsidePolicy::Extrapolate, OutsidePolicy::Reject] {
            let found = undone(&model, &poses, outside);
            let mut inside = 0;
            for (pose, found) in poses.iter().zip(&found) {
                let is_inside = model.bounds().contains(&pose.translation.vector.into());
                inside += usize::from(is_inside);
                assert_eq!(found.is_inside, is_inside);
                let is_left_out = !is_inside && outside == OutsidePolicy::Reject;
                assert_eq!(found.state == InverseState::Rejected, is_left_out);
            }
            assert!((1..poses.len()).contains(&inside));
            let expected = match outside {
                OutsidePolicy::Reject => inside,
                _ => poses.len(),
            };
            assert!(count_right(&poses, &found) + 1 >= expected, "{set:?} {outside:?}");
        }
    }
}

#[test]
fn order_zero_gives_the_reading_itself() {
    let model = DistortionModel::zero(room(), MapKind::Distortion);
    let poses = poses(5, 0.5, 1);
    let found = undone(&model, &poses, OutsidePolicy::Clamp);
    assert_eq!(count_right(&poses, &found), 5);
    assert!(found.iter().all(|f| f.evaluations == 1 && f.residual_mm == 0.0));
}

/// `x -> x + e(x)` on a box of 100 mm, nothing else changes; coefficients along x.
fn along_x(coefficients: &[f64]) -> DistortionModel {
    let order = coefficients.len() - 1;
    let mut net = vec![[0.0; 6]; coefficient_count(order)];
    for (index, c) in net.iter_mut().enumerate() {
        c[0] = coefficients[index / (order + 1).pow(2)];
    }
    DistortionModel::of_position(order, Bounds::from(([0.0; 3], [100.0; 3])), net).unwrap()
}

/// `x + e(x)` rises to x = 30, falls to 70 and rises again.
fn folding_map() -> DistortionModel {
    // With t = x / 100, (x + e)' = 6 (t - 0.3)(t - 0.7), so e = 100 (2 t³ - 3 t² + 0.26 t), whose Bernstein
    // coefficients of order 3 are c1 = a/3, c2 = (2 a + b)/3, c3 = a + b + c.
    let (a, b, c) = (26.0, -300.0, 200.0);
    along_x(&[0.0, a / 3.0, (2.0 * a + b) / 3.0, a + b + c])
}

/// What the fold reads at x, and its slope.
fn folded(x: f64) -> (f64, f64) {
    let t = x / 100.0;
    (100.0 * (2.0 * t * t * t - 3.0 * t * t + 1.26 * t), 6.0 * (t - 0.3) * (t - 0.7))
}

#[test]
fn folded_readings_are_flagged_and_no_others() {
    let model = folding_map();
    // Extremes of the fold: readings between them come from three positions.
    let (top, bottom) = (folded(30.0).0, folded(70.0).0);
    assert!(bottom < top);
    let mut certain = 0;
    for i in 0..=250 {
        let x = 0.4 * f64::from(i);
        let pose = Pose::translation(x, 40.0, 60.0);
        let found = undone(&model, &[pose], OutsidePolicy::Clamp)[0];
        let reading = folded(x).0;
        // Beside the extremes themselves two of the three are one.
        if (reading - top).abs().min((reading - bottom).abs()) < 1e-3 {
            continue;
        }
        let is_folded = (bottom..top).contains(&reading);
        let is_second =
            matches!(found.state, InverseState::Ambiguous(Ambiguity::SecondPreimage { .. }));
        assert_eq!(is_second, is_folded, "x = {x}: {found:?}");
        // All three are known.
        for other in found.others.into_iter().map(|other| other.filter(|_| is_second)) {
            let back = other.map(|other| folded(other.translation.vector.x).0);
            assert!(back.map_or(!is_second, |back| (back - reading).abs() < 1e-6), "{x} {found:?}");
        }
        // A search that crosses the fold on its way to the only answer reports it.
        let is_on_the_way =
            matches!(found.state, InverseState::Ambiguous(Ambiguity::FoldOnTheWay { .. }));
        certain += usize::from(found.state == InverseState::Converged);
        assert!(is_second || is_on_the_way || found.state == InverseState::Converged);
        let answer = found.pose.unwrap().translation.vector;
        let (back, slope) = folded(answer.x);
        assert!((back - reading).abs() < 1e-9, "no answer to its reading: {answer}");
        assert!(slope > 0.0, "an answer on the sheet that runs backwards: {answer}");
    }
    // Some 48 of the 251 come from one position only.
    assert!(certain > 24, "{certain}");
}

#[test]
fn on_a_crease_every_answer_is_flagged() {
    let model = folding_map();
    for x in [30.0, 70.0, 30.0 + 1e-7, 70.0 - 1e-7] {
        let pose = Pose::translation(x, 40.0, 60.0);
        let found = undone(&model, &[pose], OutsidePolicy::Clamp)[0];
        assert_ne!(found.state, InverseState::Converged, "{x}: {found:?}");
        assert_ne!(found.state, InverseState::NotConverged, "{x}: {found:?}");
    }
}

#[test]
fn a_map_that_turns_space_inside_out_has_no_answer() {
    // x + e = 50 - x / 2, everywhere, and nothing beyond the box: extrapolated it is the only
    // answer, and the Jacobian there is negative.
    let model = along_x(&[50.0, -100.0]);
    let pose = Pose::translation(20.0, 40.0, 60.0);
    let found = undone(&model, &[pose], OutsidePolicy::Extrapolate)[0];
    assert!(
        matches!(found.state, InverseState::Folded { determinant } if (determinant + 0.5).abs() < 1e-12),
        "{found:?}"
    );
    assert!(found.pose.is_none());
}

#[test]
fn a_reading_that_no_pose_has_is_not_answered() {
    // x + e(x) = 50 + 2 (x - 50)² / 100: nothing reads less than 50.
    let model = along_x(&[100.0, -50.0, 0.0]);
    let reading = Pose::translation(20.0, 40.0, 60.0);
    for outside in [OutsidePolicy::Extrapolate, OutsidePolicy::Clamp] {
        let found = undistort(&model, &[reading], outside, &Task::default()).unwrap()[0];
        // Clamped, the positions beyond the box read as they are but for the error at its side:
        // x + 100 for x < 0.
        match outside {
            OutsidePolicy::Clamp => {
                let answer = found.pose.unwrap().translation.vector;
                assert!((answer.x + 80.0).abs() < 1e-9, "{found:?}");
            }
            _ => assert!(found.pose.is_none(), "{found:?}"),
        }
    }
}

#[test]
fn readings_that_are_nan_have_no_answer() {
    let model = random_model(2, DirectionSet::Fourteen, Weighting::Area, [1.0, 0.01], 3);
    let poses = poses(20, 0.0, 2);
    let mut measured: Vec<_> =
        poses.iter().map(|p| model.distort(p, OutsidePolicy::Clamp).0).collect();
    measured[3].translation.vector.x = f64::NAN;
    measured[7].translation.vector.z = f64::INFINITY;
    measured[11].rotation =
        UnitQuaternion::new_unchecked(nalgebra::Quaternion::new(f64::NAN, 0.0, 0.0, 0.0));
    let found = undistort(&model, &measured, OutsidePolicy::Clamp, &Task::default()).unwrap();
    for i in [3, 7, 11] {
        assert_eq!(found[i].state, InverseState::NotConverged);
        assert!(found[i].pose.is_none() && !found[i].is_inside);
    }
    assert_eq!(found.iter().filter(|f| f.state == InverseState::Converged).count(), 17);
}

#[test]
fn far_coordinates_come_back_to_round_off() {
    let far = Bounds::from(([1e6; 3], [1e6 + 500.0; 3]));
    let near = random_model(2, DirectionSet::Fourteen, Weighting::Area, [1.0, 0.01], 3);
    let model = near.with_coefficients(2, far, near.coefficients().to_vec()).unwrap();
    let mut seeded = Seeded::new(6);
    let poses: Vec<_> = (0..30).map(|_| seeded.pose(&far, 0.0)).collect();
    for (pose, found) in poses.iter().zip(undone(&model, &poses, OutsidePolicy::Clamp)) {
        assert_eq!(found.state, InverseState::Converged);
        // A coordinate has half an epsilon of 1.7e6 mm; eight roundings, three axes.
        let (mm, rad) = distances(pose, &found.pose.unwrap());
        assert!(mm < 8.0 * 1.7e6 * f64::EPSILON && rad < 1e-12, "{mm:e} {rad:e}");
    }
}

#[test]
fn only_jumps_of_area_weights_are_flagged() {
    let set = DirectionSet::FortyTwo;
    // Icosahedron corner to edge middle: the triangles on both sides are unlike.
    let mut flagged = [0; 2];
    for (kind, weighting) in [Weighting::Area, Weighting::Gnomonic].into_iter().enumerate() {
        let model = random_model(2, set, weighting, [2.0, 0.01], 12);
        for triangle in set.triangles() {
            let [a, b] = [0, 1].map(|k| set.directions()[triangle[k]].into_inner());
            for (part, beside) in [(0.3, 0.0), (0.5, 1e-9), (0.6, -1e-9), (0.4, 1e-7)] {
                let across = a.cross(&b).normalize() * beside;
                let axis = Unit::new_normalize(a * (1.0 - part) + b * part + across);
                let turn = UnitQuaternion::rotation_between(&Vector3::z_axis(), &axis);
                let pose = Pose::from_parts(
                    Point3::new(10.0, 20.0, -300.0).into(),
                    turn.unwrap_or_else(UnitQuaternion::identity),
                );
                let found = undone(&model, &[pose], OutsidePolicy::Clamp);
                count_right(&[pose], &found);
                flagged[kind] += usize::from(found[0].state != InverseState::Converged);
            }
        }
    }
    assert!(flagged[0] > 0, "no jump was met");
    assert_eq!(flagged[1], 0);
}

#[test]
fn answers_do_not_depend_on_the_number_of_threads() {
    let model = random_model(3, DirectionSet::Fourteen, Weighting::Area, [30.0, 0.3], 3);
    let measured = poses(2 * CHUNK + 100, 0.1, 5);
    let by = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            undistort(&model, &measured, OutsidePolicy::Clamp, &Task::default()).unwrap()
        })
    };
    assert_eq!(by(1), by(3));
}

#[test]
fn cancelled_work_stops() {
    let model = random_model(2, DirectionSet::Six, Weighting::Area, [1.0, 0.01], 3);
    let task = Task::default();
    task.cancel.cancel();
    let found = undistort(&model, &poses(10, 0.0, 1), OutsidePolicy::Clamp, &task);
    assert_eq!(found, Err(Cancelled));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    #[test]
    fn whatever_converges_reads_as_the_reading(
        seed in 0_u64..1000,
        order in 1_usize..=4,
        set in 0_usize..SETS.len(),
        size in 0.0..60.0_f64,
    ) {
        let (directions, weighting) = SETS[set];
        let model = random_model(order, directions, weighting, [size, 0.005 * size], seed);
        // Readings that need not come from any pose.
        let measured = poses(8, 0.3, seed);
        for outside in [OutsidePolicy::Clamp, OutsidePolicy::Extrapolate] {
            let found = undistort(&model, &measured, outside, &Task::default()).unwrap();
            for (reading, found) in measured.iter().zip(found) {
                let Some(pose) = found.pose else { continue };
                let (mm, rad) = distances(reading, &model.distort(&pose, outside).0);
                // What was left of the equations, and the round-off of distorting once more.
                let (left_mm, left_rad) = (2.0 * found.residual_mm, 4.0 * found.residual_rad);
                prop_assert!(mm < left_mm + 1e-9, "{:e} {:?}", mm, found);
                prop_assert!(rad < left_rad + 1e-11, "{:e} {:?}", rad, found);
            }
        }
    }

    #[test]
    fn a_sensors_roll_changes_no_axis_and_no_position(seed in 0_u64..1000, roll in -3.0..3.0_f64) {
        let model = random_model(2, DirectionSet::Fourteen, Weighting::Area, [5.0, 0.05], seed);
        let pose = poses(1, 0.0, seed)[0];
        let rolled = pose * UnitQuaternion::from_axis_angle(&Vector3::z_axis(), roll);
        let found = undistort(&model, &[pose, rolled], OutsidePolicy::Clamp, &Task::default()).unwrap();
        if let (Some(a), Some(b)) = (found[0].pose, found[1].pose) {
            prop_assert!((a.translation.vector - b.translation.vector).norm() < 1e-9);
            let (_, roll_back) = distances(&a, &b);
            prop_assert!((roll_back - roll.abs()).abs() < 1e-12);
        }
    }
}
