//! Spin calibration: which way a tool's shaft points, from poses in which the tool was turned about it.
//!
//! The shaft's direction `u` in the tool's frame stays one direction in the tracker's: minimised is
//! `Σ |R_i u − R_j u|²` over all pairs of poses, which is `Σ |(R_iᵀ R_j − I) u|²`. The answer is the
//! right singular vector of the mean rotation with the largest singular value, and the left one is
//! the direction in the tracker's frame. SlicerIGT (IGSIO's spin calibration) sums over successive
//! poses only, which between samples of a 40th of a second leaves little but noise.
//!
//! The tip's frame, the direction of the shaft and the refusals are SlicerIGT's.

use super::long_run::{EffectiveSize, long_run};
use super::orientation_range::orientation_range_rad;
use super::robust::largest_std_dev;
use nalgebra::{DMatrix, DVector, Matrix3, Point3, Unit, Vector3};
use trackwright_geometry::pose::{Pose, pose_from_parts, quaternion_from_matrix};
use trackwright_geometry::svd3::svd3;

/// What a recording has to have.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpinLimits {
    pub min_poses: usize,
    /// Largest angle between any two poses, at least.
    pub min_range_rad: f64,
    /// RMS turn about the shaft, at least.
    pub min_turn_rad: f64,
    /// RMS angle between the shaft and its mean direction in the tracker's frame, at most.
    pub max_rms_rad: f64,
}

impl SpinLimits {
    /// Poses and range as SlicerIGT requires them, of a spin as of a pivot.
    pub const MIN_POSES: usize = 10;
    pub const MIN_RANGE_DEG: f64 = 15.0;
    /// As of a pivot: one pose that is turned among many that are not is no spin.
    pub const MIN_TURN_DEG: f64 = 2.0;
    /// SlicerIGT leaves out what is off by more than 0.05 of the shaft's length, which is 2.9°.
    pub const MAX_RMS_DEG: f64 = 3.0;
}

impl Default for SpinLimits {
    fn default() -> Self {
        Self {
            min_poses: Self::MIN_POSES,
            min_range_rad: Self::MIN_RANGE_DEG.to_radians(),
            min_turn_rad: Self::MIN_TURN_DEG.to_radians(),
            max_rms_rad: Self::MAX_RMS_DEG.to_radians(),
        }
    }
}

/// Which way the shaft points, and what the poses leave.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spin {
    pub poses: usize,
    /// Tool frame; which of the two directions along the shaft it is, only a tip determines.
    pub shaft_in_tool: Unit<Vector3<f64>>,
    pub shaft_in_tracker: Unit<Vector3<f64>>,
    pub rms_rad: f64,
    pub worst_rad: f64,
    /// Of `shaft_in_tool`, tool frame, of rank two.
    pub covariance: Matrix3<f64>,
    /// Their effective number, neighbours not being independent.
    pub effective_size: EffectiveSize,
    /// Standard error along the direction in which the shaft is known least.
    pub std_error_rad: f64,
    pub turn_rad: f64,
    pub orientation_range_rad: f64,
}

#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum SpinError {
    #[error("too few poses: {found}, expected at least {needed}")]
    TooFewPoses { found: usize, needed: usize },
    #[error(
        "too little variation: no two poses differ by more than {found_deg:.1}°, expected at least {needed_deg:.1}°; \
         turn the tool about its shaft, best by whole turns (a 5-DOF sensor along the shaft never sees that)"
    )]
    TooSmallRange { found_deg: f64, needed_deg: f64 },
    #[error(
        "too little variation: the tool was turned by {found_deg:.2}° RMS, expected at least {needed_deg:.1}°; turn it \
         about its shaft all the time that is recorded, best by whole turns"
    )]
    TooLittleTurn { found_deg: f64, needed_deg: f64 },
    #[error(
        "too large an error: the shaft's direction is {rms_deg:.2}° RMS from where it points on average, expected at \
         most {allowed_deg:.2}°; turn the tool about its shaft alone, and hold the shaft still meanwhile"
    )]
    TooLargeError { rms_deg: f64, allowed_deg: f64 },
}

/// The shaft of a tool from poses (`tracker_from_tool`) in which it was turned about it.
pub fn spin(poses: &[Pose], limits: &SpinLimits) -> Result<Spin, SpinError> {
    // Two poses have an axis, whatever was turned: nothing is left over to judge it by.
    let needed = limits.min_poses.max(3);
    if poses.len() < needed {
        return Err(SpinError::TooFewPoses { found: poses.len(), needed });
    }
    let orientation_range_rad = orientation_range_rad(poses);
    if orientation_range_rad < limits.min_range_rad {
        return Err(SpinError::TooSmallRange {
            found_deg: orientation_range_rad.to_degrees(),
            needed_deg: limits.min_range_rad.to_degrees(),
        });
    }
    let count = poses.len() as f64;
    let sum: Matrix3<f64> =
        poses.iter().map(|pose| pose.rotation.to_rotation_matrix().into_inner()).sum();
    // `Σ (R − R̄)ᵀ (R − R̄) / n = I − R̄ᵀ R̄`, whose least eigenvalue is of the largest value here.
    let mean = svd3(&(sum / count));
    let [largest, second, third] = mean.singular_values.into();
    // A turn about the shaft moves both directions across it alike.
    let turn_rad = (1.0 - second * second).max(0.0).sqrt();
    if turn_rad < limits.min_turn_rad.max(f64::EPSILON.sqrt()) {
        return Err(SpinError::TooLittleTurn {
            found_deg: turn_rad.to_degrees(),
            needed_deg: limits.min_turn_rad.to_degrees(),
        });
    }
    let sign = f64::copysign(1.0, mean.v.column(0)[mean.v.column(0).iamax()]);
    let [shaft, there] = [mean.v, mean.u].map(|m| Unit::new_normalize(m.column(0) * sign));

    let (mut squares, mut worst_rad) = (0.0, 0.0_f64);
    for pose in poses {
        let seen = pose.rotation * shaft;
        let off_rad = there.cross(&seen).norm().atan2(there.dot(&seen));
        squares += off_rad * off_rad;
        worst_rad = worst_rad.max(off_rad);
    }
    let rms_rad = (squares / count).sqrt();
    // Also where something is not finite.
    if rms_rad.is_nan() || rms_rad > limits.max_rms_rad {
        return Err(SpinError::TooLargeError {
            rms_deg: rms_rad.to_degrees(),
            allowed_deg: limits.max_rms_rad.to_degrees(),
        });
    }
    // Two components a pose, less those of the two directions.
    let variance = squares / (2.0 * count - 4.0) / count;
    let across: Vec<(usize, f64)> =
        [(1, second), (2, third)].map(|(k, value)| (k, largest * largest - value * value)).into();
    // What a pose's residual moves the shaft by, along both directions across it.
    let influences = DMatrix::from_fn(2, poses.len(), |row, pose| {
        let (k, information) = across[row];
        let rotation = &poses[pose].rotation;
        let residual = rotation * shaft.into_inner() - there.into_inner();
        let along =
            rotation * mean.v.column(k).into_owned() - mean.u.column(k) * mean.singular_values[k];
        along.dot(&residual) / (count * information)
    });
    let independent = DVector::from_fn(2, |row, _| variance / across[row].1);
    let found = long_run(&influences, &DMatrix::from_diagonal(&independent));
    let axes = mean.v.fixed_columns::<2>(1);
    let covariance = axes * found.covariance.fixed_view::<2, 2>(0, 0) * axes.transpose();
    Ok(Spin {
        poses: poses.len(),
        shaft_in_tool: shaft,
        shaft_in_tracker: there,
        rms_rad,
        worst_rad,
        covariance,
        effective_size: found.effective_size,
        std_error_rad: largest_std_dev(&covariance),
        turn_rad,
        orientation_range_rad,
    })
}

/// How many standard errors the tip has to be along the shaft to distinguish its directions.
const SURE: f64 = 3.0;

impl Spin {
    /// Half the 95 % interval along the direction in which the shaft is known least; `None` where the
    /// recording is too short.
    pub fn half_width_rad(&self) -> Option<f64> {
        Some(self.effective_size.student_975()? * self.std_error_rad)
    }

    /// With the shaft pointing from the tool's origin towards its tip; `None` where the tip lies so
    /// near beside the origin that this could be either direction.
    pub fn towards(&self, tip_in_tool: &Point3<f64>, tip_std_error_mm: f64) -> Option<Self> {
        let along_mm = self.shaft_in_tool.dot(&tip_in_tool.coords);
        let by_shaft_mm = tip_in_tool.coords.norm() * self.std_error_rad;
        let sure = along_mm.abs() > SURE * tip_std_error_mm.hypot(by_shaft_mm);
        let turned = match along_mm < 0.0 {
            true => [-self.shaft_in_tool, -self.shaft_in_tracker],
            false => [self.shaft_in_tool, self.shaft_in_tracker],
        };
        let [shaft_in_tool, shaft_in_tracker] = turned;
        sure.then_some(Self { shaft_in_tool, shaft_in_tracker, ..*self })
    }
}

/// Shafts nearer to the tool's x take its y instead: SlicerIGT's, in degrees.
const NEAR_X_DEG: f64 = 20.0;

/// `tool_from_tip`, as SlicerIGT has it: the origin in the tip, z along the shaft towards the tip and
/// out of it, x the tool's own as nearly as can be (its y where the shaft is nearly along x).
pub fn tool_from_tip(tip_in_tool: &Point3<f64>, towards_tip: &Unit<Vector3<f64>>) -> Pose {
    let is_near_x = towards_tip.x.abs() > NEAR_X_DEG.to_radians().cos();
    let start = if is_near_x { Vector3::y() } else { Vector3::x() };
    let z = towards_tip.into_inner();
    let x = (start - z * z.dot(&start)).normalize();
    let turn = quaternion_from_matrix(&Matrix3::from_columns(&[x, z.cross(&x), z]));
    pose_from_parts(tip_in_tool.coords, turn)
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::UnitQuaternion;
    use proptest::prelude::*;
    use std::f64::consts::{PI, TAU};
    use trackwright_field::random_models::Seeded;
    use trackwright_geometry::rotation::exp_vector;

    /// No axis of any frame.
    fn shaft() -> Unit<Vector3<f64>> {
        Unit::new_normalize(Vector3::new(0.2, -0.5, 0.8))
    }

    /// Where the tool stands in the tracker, and a turn about its shaft.
    fn spun(turn_rad: f64) -> Pose {
        let stands = exp_vector(&Vector3::new(0.9, -1.7, 0.4));
        let turn = UnitQuaternion::from_axis_angle(&shaft(), turn_rad);
        pose_from_parts(Vector3::new(20.0, 30.0, -300.0), stands * turn)
    }

    fn turned_by(count: usize, sweep_rad: f64) -> Vec<Pose> {
        (0..count).map(|i| spun(sweep_rad * i as f64 / (count - 1) as f64)).collect()
    }

    fn off_rad(found: &Spin) -> f64 {
        let cosine = found.shaft_in_tool.dot(&shaft());
        found.shaft_in_tool.cross(&shaft()).norm().atan2(cosine)
    }

    #[test]
    fn an_exact_turn_gives_the_shaft() {
        for sweep_deg in [16.0_f64, 90.0, 360.0, 1000.0] {
            let poses = turned_by(40, sweep_deg.to_radians());
            let found = spin(&poses, &SpinLimits::default()).unwrap();
            // Round-off over 1 − σ², which is 0.006 for the shortest turn.
            assert!(off_rad(&found) < 1e-12, "{sweep_deg}: {}", off_rad(&found));
            let there = poses[7].rotation * shaft();
            assert!((there.into_inner() - found.shaft_in_tracker.into_inner()).norm() < 1e-12);
            assert!(
                found.rms_rad < 1e-12 && found.worst_rad < 1e-12 && found.std_error_rad < 1e-12
            );
        }
        // Over whole turns every direction across the shaft is as often here as there.
        let whole: Vec<Pose> = (0..36).map(|i| spun(TAU / 36.0 * f64::from(i))).collect();
        let found = spin(&whole, &SpinLimits::default()).unwrap();
        assert!((found.turn_rad - 1.0).abs() < 1e-12);
        assert!((found.orientation_range_rad - PI).abs() < 1e-7);
    }

    #[test]
    fn a_coning_shaft_is_off_by_its_half_angle() {
        // The tool turns about an axis of the tracker, and twice as far about its shaft: the shaft is
        // anywhere on a cone about the first, whose middle is what it points along on average.
        let half_rad = 1.5_f64.to_radians();
        let tilt = exp_vector(&(Vector3::x() * half_rad));
        let poses: Vec<Pose> = (0..72)
            .map(|i| {
                let turn = TAU / 36.0 * f64::from(i);
                let about = |angle: f64| exp_vector(&(Vector3::z() * angle));
                pose_from_parts(Vector3::zeros(), about(turn) * tilt * about(2.0 * turn))
            })
            .collect();
        let found = spin(&poses, &SpinLimits::default()).unwrap();
        assert!(found.shaft_in_tool.cross(&Vector3::z()).norm() < 1e-12);
        assert!(found.shaft_in_tracker.cross(&Vector3::z()).norm() < 1e-12);
        for angle in [found.rms_rad, found.worst_rad] {
            assert!((angle - half_rad).abs() < 1e-12, "{angle}");
        }
    }

    #[test]
    fn each_insufficient_recording_is_refused() {
        let limits = SpinLimits::default();
        let refused = |poses: &[Pose]| spin(poses, &limits).unwrap_err();
        let few = refused(&turned_by(9, 3.0));
        assert_eq!(few, SpinError::TooFewPoses { found: 9, needed: 10 });
        let still = refused(&turned_by(50, 0.2));
        let SpinError::TooSmallRange { found_deg, .. } = still else {
            panic!("{still}");
        };
        assert!((found_deg - 0.2_f64.to_degrees()).abs() < 1e-9);
        // One pose of a thousand is turned.
        let mut hardly = vec![spun(0.0); 999];
        hardly.push(spun(1.0));
        assert!(matches!(refused(&hardly), SpinError::TooLittleTurn { .. }));
        // Swung in two directions, as for a pivot.
        let swung: Vec<Pose> = (0..60)
            .map(|i| {
                let (s, c) = (f64::from(i) * 2.4).sin_cos();
                let turn = exp_vector(&(Vector3::new(s, c, 0.0) * 0.5));
                pose_from_parts(Vector3::zeros(), turn)
            })
            .collect();
        let error = refused(&swung);
        let SpinError::TooLargeError { rms_deg, .. } = error else {
            panic!("{error}");
        };
        // Axes of swings lie across z: what lies there too moves by 0.5 rad times the sine between.
        let expected_deg = (0.5 / 2.0_f64.sqrt()).to_degrees();
        assert!((rms_deg - expected_deg).abs() < 1.0, "{rms_deg}");
        let lenient = SpinLimits { max_rms_rad: 1.0, min_poses: 0, ..limits };
        assert!(spin(&swung, &lenient).is_ok());
        let none = SpinError::TooFewPoses { found: 2, needed: 3 };
        assert_eq!(spin(&swung[..2], &lenient), Err(none));
    }

    #[test]
    fn the_covariance_is_what_noise_does_to_the_shaft() {
        const RUNS: usize = 600;
        let mut noise = Seeded::new(11);
        // Less than a turn, so that both directions across the shaft are known differently well by
        // chance only, and a noise that a quarter of the limit is made of.
        let exact = turned_by(50, 2.0);
        let (mut measured, mut stated, mut rms) = (Matrix3::zeros(), Matrix3::zeros(), 0.0);
        for _ in 0..RUNS {
            let poses: Vec<Pose> = exact.iter().map(|p| noise.around(p, 0.0, 0.01)).collect();
            let found = spin(&poses, &SpinLimits::default()).unwrap();
            let off = found.shaft_in_tool.into_inner() - shaft().into_inner();
            measured += off * off.transpose() / RUNS as f64;
            stated += found.covariance / RUNS as f64;
            rms += found.rms_rad / RUNS as f64;
        }
        // Of a variance from 600 runs the standard deviation is √(2/600) of it; four of them, for the
        // largest of three entries, in the plane across the shaft.
        let allowed = 4.0 * (2.0 / RUNS as f64).sqrt() * stated.amax();
        assert!((measured - stated).amax() < allowed, "{measured} {stated}");
        assert!((stated * shaft().into_inner()).norm() < 1e-3 * stated.amax());
        // Two components a pose, of which four numbers are fitted to a hundred.
        let expected_rad = 0.01 * (2.0 * 96.0_f64 / 100.0).sqrt();
        assert!((rms / expected_rad - 1.0).abs() < 0.02, "{rms}");
    }

    #[test]
    fn intervals_hold_for_a_hand_that_drifts() {
        const RUNS: usize = 200;
        for correlation in [0.0, 0.8, 0.95] {
            let mut noise = Seeded::new(12);
            let exact = turned_by(600, 8.0 * TAU);
            let across = shaft().cross(&Vector3::x()).normalize();
            let across = [across, shaft().cross(&across)];
            let (mut within, mut simple) = (0_u32, 0_u32);
            for _ in 0..RUNS {
                let drift = noise.autocorrelated(exact.len(), correlation);
                let poses: Vec<Pose> = exact
                    .iter()
                    .zip(&drift)
                    .map(|(pose, turn)| {
                        let rotation = exp_vector(&(turn * 0.01)) * pose.rotation;
                        pose_from_parts(pose.translation.vector, rotation)
                    })
                    .collect();
                let found = spin(&poses, &SpinLimits::default()).unwrap();
                let off = found.shaft_in_tool.into_inner() - shaft().into_inner();
                let student = found.effective_size.student_975().unwrap();
                for axis in &across {
                    let std_error = axis.dot(&(found.covariance * axis)).sqrt();
                    within += u32::from(axis.dot(&off).abs() < student * std_error);
                    // Whole turns: (2 · 0.01²)/2 a component, over as many poses.
                    let independent = 0.01 / (exact.len() as f64).sqrt();
                    simple += u32::from(axis.dot(&off).abs() < 1.96 * independent);
                }
            }
            let [within, simple] = [within, simple].map(|n| f64::from(n) / (2 * RUNS) as f64);
            // Of 400 the standard deviation of a part of 0.95 is 0.011; four of them.
            assert!(within > 0.95 - 0.044, "{correlation}: {within}");
            assert!(correlation == 0.0 || simple < 0.9, "{correlation}: {simple}");
        }
    }

    #[test]
    fn the_shaft_points_to_the_tip() {
        let found = spin(&turned_by(30, 3.0), &SpinLimits::default()).unwrap();
        let tip = |mm: f64| Point3::from(shaft().into_inner() * mm);
        let forward = found.towards(&tip(150.0), 1.0).unwrap();
        let back = found.towards(&tip(-150.0), 1.0).unwrap();
        assert_eq!(forward.shaft_in_tool, -back.shaft_in_tool);
        assert_eq!(forward.shaft_in_tracker, -back.shaft_in_tracker);
        assert!(forward.shaft_in_tool.dot(&shaft()) > 0.0);
        assert_eq!(found.towards(&tip(2.9), 1.0), None);
        assert_eq!(found.towards(&Point3::origin(), 0.0), None);
    }

    #[test]
    fn the_tip_frame_has_z_along_the_shaft() {
        let tip = Point3::new(1.0, -2.0, 150.0);
        for (towards, near) in [
            (Vector3::new(0.1, 0.2, 0.9), Vector3::x()),
            (Vector3::new(0.3, 0.0, -0.9), Vector3::x()),
            (Vector3::new(-0.95, 0.1, 0.1), Vector3::y()),
        ] {
            let towards = Unit::new_normalize(towards);
            let frame = tool_from_tip(&tip, &towards);
            assert_eq!(frame * Point3::origin(), tip);
            assert!((frame * Vector3::z() - towards.into_inner()).norm() < 1e-14);
            let x = frame * Vector3::x();
            // In the plane of the shaft and the tool's axis, and on that axis' side.
            assert!(x.dot(&near) > 0.9 && x.dot(&towards.cross(&near)).abs() < 1e-14);
            assert!((x.cross(&(frame * Vector3::y())) - towards.into_inner()).norm() < 1e-14);
        }
    }

    proptest! {
        /// Neither where the tracker's frame is nor which poses come first matters; a tool's frame
        /// that is turned turns the shaft with it.
        #[test]
        fn the_shaft_depends_on_the_tools_frame_alone(
            turn in prop::array::uniform3(-3.0..3.0_f64),
            own in prop::array::uniform3(-3.0..3.0_f64),
        ) {
            let mut noise = Seeded::new(5);
            let poses: Vec<Pose> = turned_by(30, 4.0)
                .iter()
                .map(|p| noise.around(p, 1.0, 0.01))
                .collect();
            let [turn, own] = [turn, own].map(|v| exp_vector(&v.into()));
            let other: Vec<Pose> = poses
                .iter()
                .rev()
                .map(|p| pose_from_parts(p.translation.vector, turn * p.rotation * own))
                .collect();
            let [a, b] = [poses, other].map(|p| spin(&p, &SpinLimits::default()).unwrap());
            let moved = own.inverse() * a.shaft_in_tool;
            prop_assert!(moved.cross(&b.shaft_in_tool).norm() < 1e-12);
            let moved = turn * a.shaft_in_tracker;
            prop_assert!(moved.cross(&b.shaft_in_tracker).norm() < 1e-12);
            prop_assert!((a.rms_rad - b.rms_rad).abs() < 1e-12);
            prop_assert!((a.std_error_rad - b.std_error_rad).abs() < 1e-12);
        }
    }
}
