//! Pivot calibration: where a tool's tip is, from poses in which it rested in one point.
//!
//! Every pose gives `R t + p = c` for the tip `t` in the tool's frame and the point `c` that it
//! rests in: least squares over all of them. What a recording cannot answer is refused, for
//! one of three reasons. Readings of a recording are not independent of their neighbours:
//! the sum of
//! their errors is not that of independent terms (`calibration/long_run.rs`): a reading's error `e`
//! moves the tip by `A (R − R̄)ᵀ e`, with `A` the inverse of `Σ (R − R̄)ᵀ (R − R̄)`, and the pivot by
//! `R̄` times that and `e / n`. What changes during the recording, as a sensor that slips on its tool,
//! shows in its quarters, each taken as a recording of its own.

mod section;
#[cfg(test)]
mod tests;

use super::long_run::{EffectiveSize, long_run};
use super::orientation_range::orientation_range_rad;
use super::robust::largest_std_dev;
use nalgebra::{DMatrix, DVector, Matrix3, Matrix6, Point3, Vector3};
use statrs::distribution::{ContinuousCDF, FisherSnedecor};
use trackwright_geometry::pose::Pose;

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
    /// Poses and range as SlicerIGT requires them.
    pub const MIN_POSES: usize = 10;
    pub const MIN_RANGE_DEG: f64 = 15.0;
    /// A tool that only spins has 0 about some axis; one swung through the least range some 4°.
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
    /// Standard error of the tip along the direction in which it is known least.
    pub tip_std_error_mm: f64,
    /// Of the tip (tool frame), then of the pivot (tracker frame), mm².
    pub covariance_mm2: Matrix6<f64>,
    /// Their effective number, neighbours not being independent.
    pub effective_size: EffectiveSize,
    /// Whether parts of the recording agree; `None` where a quarter by itself does not determine the
    /// tip, so that a slow drift cannot be distinguished from the tool's motion, or is too short.
    pub quarters: Option<Quarters>,
    pub orientation_range_rad: f64,
}

impl Pivot {
    /// The RMS of a single component of the residuals.
    pub fn rms_component_mm(&self) -> f64 {
        self.rms_mm / 3.0_f64.sqrt()
    }

    /// Standard error of the pivot along the direction in which it is known least.
    pub fn pivot_std_error_mm(&self) -> f64 {
        largest_std_dev(&self.covariance_mm2.fixed_view::<3, 3>(3, 3).into_owned())
    }

    /// Half the 95 % intervals of tip and pivot; `None` where the recording is too short.
    pub fn half_widths_mm(&self) -> Option<[Vector3<f64>; 2]> {
        let student = self.effective_size.student_975()?;
        let half = self.covariance_mm2.diagonal().map(|v| student * v.sqrt());
        Some([half.fixed_rows::<3>(0).into_owned(), half.fixed_rows::<3>(3).into_owned()])
    }
}

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
         about least, expected at least {needed_deg:.1}°), and where the tip is along that axis is not determined; \
         swing the tool in two directions"
    )]
    OneAxis { found_deg: f64, needed_deg: f64 },
    #[error(
        "too large an error: the tip is {rms_mm:.3} mm RMS from the point that it should have rested in, expected at \
         most {allowed_mm:.3} mm; keep the tip in its place, and the tool in the tracker's volume"
    )]
    TooLargeError { rms_mm: f64, allowed_mm: f64 },
}

/// The tip of a tool from poses (`tracker_from_tool`) around one point.
pub fn pivot(poses: &[Pose], limits: &PivotLimits) -> Result<Pivot, PivotError> {
    // Two poses leave a line of tips, whatever is allowed.
    let needed = limits.min_poses.max(3);
    if poses.len() < needed {
        return Err(PivotError::TooFewPoses { found: poses.len(), needed });
    }
    let orientation_range_rad = orientation_range_rad(poses);
    if orientation_range_rad < limits.min_range_rad {
        return Err(PivotError::TooSmallRange {
            found_deg: orientation_range_rad.to_degrees(),
            needed_deg: limits.min_range_rad.to_degrees(),
        });
    }
    let one_axis = |least_turn_rad: f64| PivotError::OneAxis {
        found_deg: least_turn_rad.to_degrees(),
        needed_deg: limits.min_turn_rad.to_degrees(),
    };
    let fit = Fit::of(poses).ok_or(one_axis(0.0))?;
    if fit.least_turn_rad() < limits.min_turn_rad.max(f64::EPSILON) {
        return Err(one_axis(fit.least_turn_rad()));
    }
    let residuals: Vec<Vector3<f64>> = poses.iter().map(|pose| fit.residual_mm(pose)).collect();
    let squares: f64 = residuals.iter().map(Vector3::norm_squared).sum();
    let worst_mm = residuals.iter().map(|off| off.norm()).fold(0.0, f64::max);
    let rms_mm = (squares / poses.len() as f64).sqrt();
    // Also where something is not finite.
    if rms_mm.is_nan() || rms_mm > limits.max_rms_mm {
        return Err(PivotError::TooLargeError { rms_mm, allowed_mm: limits.max_rms_mm });
    }
    let precision = precision_of(poses, &fit);
    Ok(Pivot {
        poses: poses.len(),
        tip_in_tool: fit.tip.into(),
        pivot_in_tracker: fit.pivot.into(),
        rms_mm,
        worst_mm,
        tip_std_error_mm: largest_std_dev(&precision.of_tip_mm2()),
        covariance_mm2: precision.covariance_mm2,
        effective_size: precision.effective_size,
        quarters: quarters(poses, limits.min_turn_rad),
        orientation_range_rad,
    })
}

/// Least squares over poses, whatever they can answer.
struct Fit {
    count: f64,
    mean_rotation: Matrix3<f64>,
    tip: Vector3<f64>,
    pivot: Vector3<f64>,
    /// Of the turns `R − R̄` below each other, with their right singular vectors.
    singular_values: Vector3<f64>,
    axes: Matrix3<f64>,
}

impl Fit {
    /// `None` where nothing is turned, or something is not finite.
    fn of(poses: &[Pose]) -> Option<Self> {
        let count = poses.len() as f64;
        let mean_rotation = poses.iter().map(rotation).sum::<Matrix3<f64>>() / count;
        let mean_at = poses.iter().map(at).sum::<Vector3<f64>>() / count;
        // Without the pivot, which the means give: `(R − R̄) t = −(p − p̄)`.
        let rows = 3 * poses.len();
        let mut rotations = DMatrix::zeros(rows, 3);
        let mut translations = DVector::zeros(rows);
        for (i, pose) in poses.iter().enumerate() {
            rotations.fixed_view_mut::<3, 3>(3 * i, 0).copy_from(&(rotation(pose) - mean_rotation));
            translations.fixed_rows_mut::<3>(3 * i).copy_from(&(mean_at - at(pose)));
        }
        let svd = rotations.svd(true, true);
        // Nothing is left out: the least singular value is judged by those who use the answer.
        let tip = svd.solve(&translations, 0.0).ok()?;
        let tip = Vector3::new(tip[0], tip[1], tip[2]);
        let axes = svd.v_t.as_ref()?.transpose();
        Some(Self {
            count,
            mean_rotation,
            tip,
            pivot: mean_rotation * tip + mean_at,
            singular_values: Vector3::from_fn(|k, _| svd.singular_values[k]),
            axes: axes.fixed_view::<3, 3>(0, 0).into_owned(),
        })
    }

    /// RMS turn about the axis that the tool turned about least.
    fn least_turn_rad(&self) -> f64 {
        self.singular_values.min() / self.count.sqrt()
    }

    /// The inverse of `Σ (R − R̄)ᵀ (R − R̄)`.
    fn inverse(&self) -> Matrix3<f64> {
        let squares = self.singular_values.map(|s| (s * s).recip());
        self.axes * Matrix3::from_diagonal(&squares) * self.axes.transpose()
    }

    /// From the pivot to where a pose puts the tip.
    fn residual_mm(&self, pose: &Pose) -> Vector3<f64> {
        pose.rotation * self.tip + at(pose) - self.pivot
    }
}

fn rotation(pose: &Pose) -> Matrix3<f64> {
    *pose.rotation.to_rotation_matrix().matrix()
}

fn at(pose: &Pose) -> Vector3<f64> {
    pose.translation.vector
}

const QUARTERS: usize = 4;

/// Chance of quarters that differ as much although nothing changes, at or above which they agree.
const AGREEMENT: f64 = 0.01;

/// The tips of a recording's quarters, each found by itself.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Quarters {
    pub apart_mm: f64,
    /// Standard error of the difference of those two along the direction in which it is largest, by
    /// what happens within the two quarters.
    pub expected_mm: f64,
    pub has_drift: bool,
}

struct Precision {
    pub covariance_mm2: Matrix6<f64>,
    pub effective_size: EffectiveSize,
}

impl Precision {
    pub fn of_tip_mm2(&self) -> Matrix3<f64> {
        self.covariance_mm2.fixed_view::<3, 3>(0, 0).into_owned()
    }
}

/// Of a fit of poses that determine it.
fn precision_of(poses: &[Pose], fit: &Fit) -> Precision {
    let residuals: Vec<Vector3<f64>> = poses.iter().map(|pose| fit.residual_mm(pose)).collect();
    let inverse = fit.inverse();
    let mut influences = DMatrix::zeros(6, poses.len());
    for ((pose, residual), mut column) in
        poses.iter().zip(&residuals).zip(influences.column_iter_mut())
    {
        let turn = rotation(pose) - fit.mean_rotation;
        let of_tip = inverse * turn.transpose() * residual;
        column.fixed_rows_mut::<3>(0).copy_from(&of_tip);
        column
            .fixed_rows_mut::<3>(3)
            .copy_from(&(fit.mean_rotation * of_tip - residual / fit.count));
    }
    let independent = independent_mm2(fit, &residuals);
    let independent = DMatrix::from_fn(6, 6, |i, j| independent[(i, j)]);
    let found = long_run(&influences, &independent);
    Precision {
        covariance_mm2: Matrix6::from_fn(|i, j| found.covariance[(i, j)]),
        effective_size: found.effective_size,
    }
}

/// `None` where a quarter does not determine the tip, or is too short to determine how well.
fn quarters(poses: &[Pose], min_turn_rad: f64) -> Option<Quarters> {
    let part = |k: usize| &poses[k * poses.len() / QUARTERS..(k + 1) * poses.len() / QUARTERS];
    if part(0).len() < PivotLimits::MIN_POSES {
        return None;
    }
    let (mut tips, mut freedom) = (Vec::new(), usize::MAX);
    for k in 0..QUARTERS {
        let fit = Fit::of(part(k)).filter(|fit| fit.least_turn_rad() >= min_turn_rad)?;
        let precision = precision_of(part(k), &fit);
        freedom = freedom.min(precision.effective_size.freedom?);
        let covariance_mm2 = precision.of_tip_mm2();
        tips.push((fit.tip, covariance_mm2, covariance_mm2.try_inverse()?));
    }
    let information: Matrix3<f64> = tips.iter().map(|(_, _, weight)| weight).sum();
    let weighted: Vector3<f64> = tips.iter().map(|(tip, _, weight)| weight * tip).sum();
    let mean = information.try_inverse()? * weighted;
    let squares: f64 =
        tips.iter().map(|(tip, _, weight)| (tip - mean).dot(&(weight * (tip - mean)))).sum();
    let pairs = (0..QUARTERS).flat_map(|a| (0..a).map(move |b| (a, b)));
    let apart = |(a, b): (usize, usize)| ((tips[a].0 - tips[b].0).norm(), a, b);
    let (apart_mm, a, b) = pairs.map(apart).max_by(|x, y| x.0.total_cmp(&y.0))?;
    let differences = 3.0 * (QUARTERS - 1) as f64;
    // The covariances themselves are known to so many degrees of freedom only.
    let by_chance = FisherSnedecor::new(differences, freedom as f64).ok()?;
    let ratio = squares / differences;
    ratio.is_finite().then(|| Quarters {
        apart_mm,
        expected_mm: largest_std_dev(&(tips[a].1 + tips[b].1)),
        has_drift: by_chance.sf(ratio) < AGREEMENT,
    })
}

fn independent_mm2(fit: &Fit, residuals: &[Vector3<f64>]) -> Matrix6<f64> {
    let squares: f64 = residuals.iter().map(Vector3::norm_squared).sum();
    // Three components a pose, less those of tip and pivot.
    let variance_mm2 = squares / (3.0 * fit.count - 6.0);
    let inverse = fit.inverse();
    let to_pivot = fit.mean_rotation * inverse;
    let of_pivot = to_pivot * fit.mean_rotation.transpose() + Matrix3::identity() / fit.count;
    let mut covariance = Matrix6::zeros();
    for (row, column, block) in
        [(0, 0, inverse), (3, 0, to_pivot), (0, 3, to_pivot.transpose()), (3, 3, of_pivot)]
    {
        covariance.fixed_view_mut::<3, 3>(row, column).copy_from(&(block * variance_mm2));
    }
    covariance
}
