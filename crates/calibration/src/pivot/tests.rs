//! Simulated recordings whose tip is known.

use super::*;
use nalgebra::UnitQuaternion;
use proptest::prelude::*;
use trackwright_field::random_models::Seeded;
use trackwright_geometry::pose::pose_from_parts;

const TIP: [f64; 3] = [-14.0, 394.0, -7.0];
const PIVOT: [f64; 3] = [80.0, -30.0, -310.0];

/// The pose that has the tip in the pivot, turned by a vector.
fn pose(turn: Vector3<f64>) -> Pose {
    let rotation = UnitQuaternion::from_scaled_axis(turn);
    pose_from_parts(Vector3::from(PIVOT) - rotation * Vector3::from(TIP), rotation)
}

/// A cone of half an angle around where the tool stands.
fn cone(count: usize, half_rad: f64) -> Vec<Pose> {
    (0..count)
        .map(|i| {
            let (s, c) = (i as f64 * 2.4).sin_cos();
            pose(Vector3::new(c, 0.3, s).normalize() * half_rad)
        })
        .collect()
}

#[test]
fn an_exact_recording_gives_tip_and_pivot() {
    let found = pivot(&cone(12, 0.5), &PivotLimits::default()).unwrap();
    // Positions of half a metre in a double, amplified by the turns' 0.3.
    assert!((found.tip_in_tool - Point3::from(TIP)).norm() < 1e-11);
    assert!((found.pivot_in_tracker - Point3::from(PIVOT)).norm() < 1e-11);
    assert!(found.rms_mm < 1e-12 && found.worst_mm < 1e-11);
    assert_eq!(found.poses, 12);
}

#[test]
fn too_few_poses_are_refused() {
    let refused = pivot(&cone(9, 0.5), &PivotLimits::default());
    let expected = PivotError::TooFewPoses { found: 9, needed: 10 };
    assert_eq!(refused, Err(expected));
    let limits = PivotLimits { min_poses: 0, ..PivotLimits::default() };
    assert!(pivot(&cone(3, 0.5), &limits).is_ok());
    let needed = PivotError::TooFewPoses { found: 2, needed: 3 };
    assert_eq!(pivot(&cone(2, 0.5), &limits), Err(needed));
}

#[test]
fn still_and_spinning_tools_are_refused() {
    let still = pivot(&cone(50, 0.05), &PivotLimits::default()).unwrap_err();
    let PivotError::TooSmallRange { found_deg, .. } = still else {
        panic!("{still}");
    };
    assert!(found_deg < 0.1_f64.to_degrees() + 1e-9);
    let spinning: Vec<Pose> = (0..50).map(|i| pose(Vector3::y() * (0.1 * f64::from(i)))).collect();
    let spun = pivot(&spinning, &PivotLimits::default()).unwrap_err();
    let PivotError::OneAxis { found_deg, .. } = spun else {
        panic!("{spun}");
    };
    assert!(found_deg < 1e-6);
}

#[test]
fn a_tip_that_slid_is_refused_unless_allowed() {
    let mut poses = cone(20, 0.4);
    for (i, pose) in poses.iter_mut().enumerate() {
        pose.translation.vector.x += if i % 2 == 0 { 10.0 } else { -10.0 };
    }
    let refused = pivot(&poses, &PivotLimits::default()).unwrap_err();
    let PivotError::TooLargeError { rms_mm, .. } = refused else {
        panic!("{refused}");
    };
    let limits = PivotLimits { max_rms_mm: 20.0, ..PivotLimits::default() };
    assert_eq!(pivot(&poses, &limits).unwrap().rms_mm, rms_mm);
}

#[test]
fn the_standard_error_is_what_noise_does_to_the_tip() {
    use rand_chacha::ChaCha8Rng;
    use rand_chacha::rand_core::{Rng, SeedableRng};
    const RUNS: usize = 400;
    let mut random = ChaCha8Rng::seed_from_u64(4);
    let mut uniform = || f64::from(random.next_u32()) / f64::from(u32::MAX) - 0.5;
    let (mut worst, mut stated) = (Matrix3::zeros(), 0.0);
    for _ in 0..RUNS {
        let mut poses = cone(60, 0.4);
        for pose in &mut poses {
            pose.translation.vector += Vector3::new(uniform(), uniform(), uniform());
        }
        let found = pivot(&poses, &PivotLimits::default()).unwrap();
        let off = found.tip_in_tool - Point3::from(TIP);
        worst += off * off.transpose() / RUNS as f64;
        stated += found.tip_std_error_mm / RUNS as f64;
    }
    let measured = worst.symmetric_eigenvalues().max().sqrt();
    // The standard deviation of a spread from 400 runs is 1/√800 of it; three of them.
    assert!((measured / stated - 1.0).abs() < 3.0 / 800.0_f64.sqrt(), "{measured} {stated}");
}

/// A hand that swings the tool around in so many poses a round, and to and fro more slowly.
fn swung(count: usize, poses_a_round: f64, errors_mm: &[Vector3<f64>]) -> Vec<Pose> {
    (0..count)
        .map(|i| {
            let (s, c) = (std::f64::consts::TAU * i as f64 / poses_a_round).sin_cos();
            let slow = (std::f64::consts::TAU * i as f64 / poses_a_round / 7.0).sin();
            let mut pose = pose(Vector3::new(c, 0.3 * slow, s) * 0.4);
            pose.translation.vector += errors_mm[i];
            pose
        })
        .collect()
}

/// Of simulated recordings: the part of the components of tip and pivot within the 95 % intervals,
/// the same for intervals that take readings for independent, and the mean tip error that is stated
/// over the RMS of the true one (both along the worst direction).
struct Coverage {
    stated: f64,
    as_independent: f64,
    size: f64,
    /// Recordings whose quarters are found to differ.
    drifts: usize,
}

const RUNS: usize = 200;

fn coverage(count: usize, mut errors_mm: impl FnMut(usize) -> Vec<Vector3<f64>>) -> Coverage {
    let (mut within, mut simple, mut drifts) = (0, 0, 0);
    let (mut true_mm2, mut stated_mm) = (Matrix3::zeros(), 0.0);
    for run in 0..RUNS {
        let poses = swung(count, 80.0, &errors_mm(run));
        let found = pivot(&poses, &PivotLimits::default()).unwrap();
        let fit = Fit::of(&poses).unwrap();
        let residuals: Vec<_> = poses.iter().map(|p| fit.residual_mm(p)).collect();
        let independent = independent_mm2(&fit, &residuals).diagonal();
        let halves = found.half_widths_mm().unwrap();
        let off = found.tip_in_tool - Point3::from(TIP);
        let offs = [off, found.pivot_in_tracker - Point3::from(PIVOT)];
        for (which, (off, half)) in offs.iter().zip(halves).enumerate() {
            for k in 0..3 {
                within += usize::from(off[k].abs() < half[k]);
                let half_mm = 1.96 * independent[3 * which + k].sqrt();
                simple += usize::from(off[k].abs() < half_mm);
            }
        }
        true_mm2 += off * off.transpose() / RUNS as f64;
        drifts += usize::from(found.quarters.is_some_and(|q| q.has_drift));
        stated_mm += found.tip_std_error_mm / RUNS as f64;
    }
    let part = |count: usize| count as f64 / (6 * RUNS) as f64;
    Coverage {
        stated: part(within),
        as_independent: part(simple),
        size: stated_mm / largest_std_dev(&true_mm2),
        drifts,
    }
}

/// A part of `6 RUNS` components, of which a recording's are as good as three independent ones, has a
/// standard deviation of `√(0.95 · 0.05 / (3 RUNS))`: four of them.
const ALLOWED: f64 = 0.036;

#[test]
fn intervals_hold_for_independent_readings() {
    let mut noise = Seeded::new(31);
    let found = coverage(800, |_| noise.autocorrelated(800, 0.0));
    assert!((found.stated - 0.95).abs() < ALLOWED, "{}", found.stated);
    // One in a hundred by chance: two of 200, and three standard deviations.
    assert!(found.drifts <= 6, "{}", found.drifts);
    // As before: both hold, and are as large to within 5 % (1/√(2 RUNS) of it by chance).
    assert!((found.as_independent - 0.95).abs() < ALLOWED);
    assert!((found.size - 1.0).abs() < 0.05 + 2.0 / (2.0 * RUNS as f64).sqrt(), "{}", found.size);
}

#[test]
fn intervals_hold_for_autocorrelated_readings() {
    // What intervals for independent readings held for is the upper end of each range.
    for (correlation, simple) in [(0.5, 0.85), (0.8, 0.65), (0.95, 0.55)] {
        let mut noise = Seeded::new(32);
        let found = coverage(800, |_| noise.autocorrelated(800, correlation));
        let Coverage { stated, as_independent, size, .. } = found;
        assert!(stated > 0.95 - ALLOWED, "{correlation}: {stated}");
        assert!(as_independent < simple, "{correlation}: {as_independent}");
        assert!((0.8..1.35).contains(&size), "{correlation}: {size}");
    }
}

#[test]
fn intervals_hold_for_slow_drift_beneath_noise() {
    let mut noise = Seeded::new(33);
    let found = coverage(800, |_| {
        let mut errors = noise.autocorrelated(800, 0.0);
        let [swing, phase] = [noise.normal_vector(), noise.normal_vector() * 3.0];
        for (i, error) in errors.iter_mut().enumerate() {
            let along = 4.0 * i as f64 / 800.0;
            *error += swing.zip_map(&phase, |swing, phase| 0.5 * swing * (along + phase).sin());
        }
        errors
    });
    assert!(found.stated > 0.95 - ALLOWED, "{}", found.stated);
    assert!(found.as_independent < 0.85, "{}", found.as_independent);
}

#[test]
fn a_sensor_that_slips_shows_in_the_quarters() {
    let mut noise = Seeded::new(34);
    let errors: Vec<_> = noise.autocorrelated(800, 0.0).iter().map(|e| e * 0.1).collect();
    let still = pivot(&swung(800, 80.0, &errors), &PivotLimits::default()).unwrap();
    assert!(!still.quarters.unwrap().has_drift, "{still:?}");
    let mut slipped = swung(800, 80.0, &errors);
    for pose in &mut slipped[400..] {
        *pose *= Pose::translation(0.0, 1.5, 0.0);
    }
    let found = pivot(&slipped, &PivotLimits::default()).unwrap();
    let quarters = found.quarters.unwrap();
    assert!(quarters.has_drift, "{quarters:?}");
    assert!((quarters.apart_mm - 1.5).abs() < 0.2, "{quarters:?}");
    // The mean of the two places is off by half the slip from either.
    assert!((0.2..1.5).contains(&found.tip_std_error_mm), "{found:?}");
}

#[test]
fn what_a_short_recording_cannot_determine_is_open() {
    let mut noise = Seeded::new(35);
    // One slow swing: a quarter of it is about one axis.
    let errors = noise.autocorrelated(800, 0.0);
    let once = pivot(&swung(800, 1600.0, &errors), &PivotLimits::default());
    assert_eq!(once.unwrap().quarters, None);
    // Eleven poses are fewer than twelve independent ones.
    let limits = PivotLimits { min_poses: 3, ..PivotLimits::default() };
    let few = pivot(&cone(11, 0.5), &limits).unwrap();
    assert_eq!((few.effective_size.freedom, few.half_widths_mm()), (None, None));
}

proptest! {
    /// Where the tracker's frame is does not matter to the tip, and moves the pivot with it.
    #[test]
    fn the_tip_does_not_depend_on_the_trackers_frame(
        turn in prop::array::uniform3(-3.0..3.0_f64),
        shift in prop::array::uniform3(-2000.0..2000.0_f64),
    ) {
        let moved = pose_from_parts(shift.into(), UnitQuaternion::from_scaled_axis(turn.into()));
        let mut poses = cone(30, 0.4);
        for (i, pose) in poses.iter_mut().enumerate() {
            pose.translation.vector.z += (i as f64).sin();
        }
        let other: Vec<Pose> = poses.iter().map(|pose| moved * pose).collect();
        let [a, b] = [poses, other].map(|p| pivot(&p, &PivotLimits::default()).unwrap());
        prop_assert!((a.tip_in_tool - b.tip_in_tool).norm() < 1e-8);
        prop_assert!((moved * a.pivot_in_tracker - b.pivot_in_tracker).norm() < 1e-8);
        prop_assert!((a.rms_mm - b.rms_mm).abs() < 1e-9);
    }
}
