//! Pivot calibration: where a tool's tip is, from poses in which it rested in one point.
//!
//! Every pose says `R t + p = c` for the tip `t` in the tool's frame and the point `c` that it rests
//! in: least squares over all of them (DOMAIN 3.5). What a recording cannot answer is refused, for
//! one of three reasons.

use super::orientation_range::orientation_range_rad;
use crate::geometry::pose::Pose;
use nalgebra::{DMatrix, DVector, Matrix3, Point3, Vector3};

/// What a recording has to have.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PivotLimits {
    pub min_poses: usize,
    /// Largest angle between any two poses, at least.
    pub min_range_rad: f64,
    /// RMS turn about the axis that the tool turned about least, at least.
    pub min_turn_rad: f64,
    /// RMS distance of the tip from the point that it rested in, at most.
    pub max_rms_mm: f64,
}

impl PivotLimits {
    /// Poses and range as SlicerIGT asks for them.
    pub const MIN_POSES: usize = 10;
    pub const MIN_RANGE_DEG: f64 = 15.0;
    /// A tool that only spins has a turn of 0 about some axis; one that is swung through the least
    /// range has some 4°.
    pub const MIN_TURN_DEG: f64 = 2.0;
    /// Far above that of a good recording (below 1 mm), and below that of one where the tip slid.
    pub const MAX_RMS_MM: f64 = 5.0;
}

impl Default for PivotLimits {
    fn default() -> Self {
        Self {
            min_poses: Self::MIN_POSES,
            min_range_rad: Self::MIN_RANGE_DEG.to_radians(),
            min_turn_rad: Self::MIN_TURN_DEG.to_radians(),
            max_rms_mm: Self::MAX_RMS_MM,
        }
    }
}

/// Where the tip is, and what the poses leave.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pivot {
    pub poses: usize,
    /// Tool frame.
    pub tip_in_tool: Point3<f64>,
    /// The point that the tip rested in, tracker frame.
    pub pivot_in_tracker: Point3<f64>,
    /// RMS distance of the tip from the pivot.
    pub rms_mm: f64,
    /// Largest distance of the tip from the pivot.
    pub worst_mm: f64,
    /// Standard error of the tip along the direction in which it is known least, for residuals that
    /// are independent from pose to pose.
    pub tip_std_error_mm: f64,
    /// Largest angle between any two poses.
    pub orientation_range_rad: f64,
}

impl Pivot {
    /// The RMS of a single component of the residuals.
    pub fn rms_component_mm(&self) -> f64 {
        self.rms_mm / 3.0_f64.sqrt()
    }
}

/// Why a recording gives no tip.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum PivotError {
    #[error("too few poses: {found}, expected at least {needed}")]
    TooFewPoses { found: usize, needed: usize },
    #[error(
        "too little variation: no two poses differ by more than {found_deg:.1}°, expected at least {needed_deg:.1}°; \
         swing the tool farther around its tip"
    )]
    TooSmallRange { found_deg: f64, needed_deg: f64 },
    #[error(
        "too little variation: the tool turned about one axis only ({found_deg:.2}° RMS about the one that it turned \
         about least, expected at least {needed_deg:.1}°), and where the tip is along that axis nobody can tell; \
         swing the tool in two directions"
    )]
    OneAxis { found_deg: f64, needed_deg: f64 },
    #[error(
        "too large an error: the tip is {rms_mm:.3} mm RMS from the point that it should have rested in, expected at \
         most {allowed_mm:.3} mm; keep the tip in its place, and the tool in the tracker's volume"
    )]
    TooLargeError { rms_mm: f64, allowed_mm: f64 },
}

/// The tip of a tool from poses around one point; each pose is `tracker_from_tool`.
///
/// # Errors
/// Too few poses, too little variation of their orientations, too large an error.
pub fn pivot(poses: &[Pose], limits: &PivotLimits) -> Result<Pivot, PivotError> {
    // Two poses leave a line of tips, whatever is allowed.
    let needed = limits.min_poses.max(3);
    if poses.len() < needed {
        return Err(PivotError::TooFewPoses {
            found: poses.len(),
            needed,
        });
    }
    let orientation_range_rad = orientation_range_rad(poses);
    if orientation_range_rad < limits.min_range_rad {
        return Err(PivotError::TooSmallRange {
            found_deg: orientation_range_rad.to_degrees(),
            needed_deg: limits.min_range_rad.to_degrees(),
        });
    }
    let count = poses.len() as f64;
    let rotations: Vec<Matrix3<f64>> = poses
        .iter()
        .map(|pose| *pose.rotation.to_rotation_matrix().matrix())
        .collect();
    let mean_rotation = rotations.iter().sum::<Matrix3<f64>>() / count;
    let mean_at = poses.iter().map(at).sum::<Vector3<f64>>() / count;

    // Without the pivot, which the means give: `(R − R̄) t = −(p − p̄)`.
    let rows = 3 * poses.len();
    let mut turns = DMatrix::zeros(rows, 3);
    let mut shifts = DVector::zeros(rows);
    for (i, (rotation, pose)) in rotations.iter().zip(poses).enumerate() {
        turns
            .fixed_view_mut::<3, 3>(3 * i, 0)
            .copy_from(&(rotation - mean_rotation));
        shifts
            .fixed_rows_mut::<3>(3 * i)
            .copy_from(&(mean_at - at(pose)));
    }
    let svd = turns.svd(true, true);
    let least = svd.singular_values.min();
    let least_turn_rad = least / count.sqrt();
    let one_axis = PivotError::OneAxis {
        found_deg: least_turn_rad.to_degrees(),
        needed_deg: limits.min_turn_rad.to_degrees(),
    };
    if least_turn_rad < limits.min_turn_rad.max(f64::EPSILON) {
        return Err(one_axis);
    }
    // Nothing is left out: the least singular value was judged above.
    let tip = svd.solve(&shifts, 0.0).map_err(|_| one_axis)?;
    let tip = Vector3::new(tip[0], tip[1], tip[2]);
    let pivot = mean_rotation * tip + mean_at;

    let (mut squares, mut worst_mm) = (0.0, 0.0_f64);
    for pose in poses {
        let off_mm = (pose.rotation * tip + at(pose) - pivot).norm();
        squares += off_mm * off_mm;
        worst_mm = worst_mm.max(off_mm);
    }
    let rms_mm = (squares / count).sqrt();
    // Also where something is not finite.
    if rms_mm.is_nan() || rms_mm > limits.max_rms_mm {
        return Err(PivotError::TooLargeError {
            rms_mm,
            allowed_mm: limits.max_rms_mm,
        });
    }
    let free = (rows - 6) as f64;
    Ok(Pivot {
        poses: poses.len(),
        tip_in_tool: tip.into(),
        pivot_in_tracker: pivot.into(),
        rms_mm,
        worst_mm,
        tip_std_error_mm: (squares / free).sqrt() / least,
        orientation_range_rad,
    })
}

fn at(pose: &Pose) -> Vector3<f64> {
    pose.translation.vector
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::pose::pose_from_parts;
    use nalgebra::UnitQuaternion;
    use proptest::prelude::*;

    const TIP: [f64; 3] = [-14.0, 394.0, -7.0];
    const PIVOT: [f64; 3] = [80.0, -30.0, -310.0];

    /// The pose that has the tip in the pivot, turned by a vector.
    fn pose(turn: Vector3<f64>) -> Pose {
        let rotation = UnitQuaternion::from_scaled_axis(turn);
        pose_from_parts(
            Vector3::from(PIVOT) - rotation * Vector3::from(TIP),
            rotation,
        )
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
    fn an_exact_recording_gives_tip_and_pivot_to_round_off() {
        let found = pivot(&cone(12, 0.5), &PivotLimits::default()).unwrap();
        // Positions of half a metre in a double, amplified by the turns' 0.3.
        assert!((found.tip_in_tool - Point3::from(TIP)).norm() < 1e-11);
        assert!((found.pivot_in_tracker - Point3::from(PIVOT)).norm() < 1e-11);
        assert!(found.rms_mm < 1e-12 && found.worst_mm < 1e-11);
        assert_eq!(found.poses, 12);
    }

    #[test]
    fn too_few_poses_are_refused_and_three_are_the_least_that_can_answer() {
        let refused = pivot(&cone(9, 0.5), &PivotLimits::default());
        let expected = PivotError::TooFewPoses {
            found: 9,
            needed: 10,
        };
        assert_eq!(refused, Err(expected));
        let limits = PivotLimits {
            min_poses: 0,
            ..PivotLimits::default()
        };
        assert!(pivot(&cone(3, 0.5), &limits).is_ok());
        let needed = PivotError::TooFewPoses {
            found: 2,
            needed: 3,
        };
        assert_eq!(pivot(&cone(2, 0.5), &limits), Err(needed));
    }

    #[test]
    fn a_tool_that_hardly_turns_and_one_that_only_spins_are_refused_for_their_reasons() {
        let still = pivot(&cone(50, 0.05), &PivotLimits::default()).unwrap_err();
        let PivotError::TooSmallRange { found_deg, .. } = still else {
            panic!("{still}");
        };
        assert!(found_deg < 0.1_f64.to_degrees() + 1e-9);
        let spinning: Vec<Pose> = (0..50)
            .map(|i| pose(Vector3::y() * (0.1 * f64::from(i))))
            .collect();
        let spun = pivot(&spinning, &PivotLimits::default()).unwrap_err();
        let PivotError::OneAxis { found_deg, .. } = spun else {
            panic!("{spun}");
        };
        assert!(found_deg < 1e-6);
    }

    #[test]
    fn a_tip_that_slid_is_refused_with_how_far_and_allowed_where_that_is_said() {
        let mut poses = cone(20, 0.4);
        for (i, pose) in poses.iter_mut().enumerate() {
            pose.translation.vector.x += if i % 2 == 0 { 10.0 } else { -10.0 };
        }
        let refused = pivot(&poses, &PivotLimits::default()).unwrap_err();
        let PivotError::TooLargeError { rms_mm, .. } = refused else {
            panic!("{refused}");
        };
        let limits = PivotLimits {
            max_rms_mm: 20.0,
            ..PivotLimits::default()
        };
        assert_eq!(pivot(&poses, &limits).unwrap().rms_mm, rms_mm);
    }

    #[test]
    fn the_standard_error_is_what_noise_does_to_the_tip() {
        use rand_chacha::ChaCha8Rng;
        use rand_chacha::rand_core::{Rng, SeedableRng};
        const RUNS: usize = 400;
        let mut random = ChaCha8Rng::seed_from_u64(4);
        let mut uniform = || f64::from(random.next_u32()) / f64::from(u32::MAX) - 0.5;
        let (mut worst, mut told) = (Matrix3::zeros(), 0.0);
        for _ in 0..RUNS {
            let mut poses = cone(60, 0.4);
            for pose in &mut poses {
                pose.translation.vector += Vector3::new(uniform(), uniform(), uniform());
            }
            let found = pivot(&poses, &PivotLimits::default()).unwrap();
            let off = found.tip_in_tool - Point3::from(TIP);
            worst += off * off.transpose() / RUNS as f64;
            told += found.tip_std_error_mm / RUNS as f64;
        }
        let measured = worst.symmetric_eigenvalues().max().sqrt();
        // The standard deviation of a spread from 400 runs is 1/√800 of it; three of them.
        assert!(
            (measured / told - 1.0).abs() < 3.0 / 800.0_f64.sqrt(),
            "{measured} {told}"
        );
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
}
