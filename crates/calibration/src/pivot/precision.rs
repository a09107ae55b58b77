//! How well a recording knows its tip and pivot, with what its neighbouring readings have in common.
//!
//! A reading's error `e` moves the tip by `A (R − R̄)ᵀ e`, with `A` the inverse of
//! `Σ (R − R̄)ᵀ (R − R̄)`, and the pivot by `R̄` times that and `e / n`. The sum of these is not that of
//! independent terms (`calibration/long_run.rs`).
//!
//! What changes during the recording, as a sensor that slips on its tool, shows in its quarters, each
//! taken as a recording of its own.

use super::{Fit, PivotLimits, rotation};
use crate::long_run::{EffectiveSize, long_run};
use nalgebra::{DMatrix, Matrix3, Matrix6, Vector3};
use statrs::distribution::{ContinuousCDF, FisherSnedecor};
use trackwright_geometry::pose::Pose;

const QUARTERS: usize = 4;

/// Chance of quarters that differ as much although nothing changes, at or above which they agree.
const AGREEMENT: f64 = 0.01;

/// The tips of a recording's quarters, each found by itself.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Quarters {
    /// Largest distance between two of the tips.
    pub apart_mm: f64,
    /// Standard error of the difference of those two along the direction in which it is largest, by
    /// what happens within the two quarters.
    pub expected_mm: f64,
    /// The quarters differ by more than what happens within them explains.
    pub has_drift: bool,
}

pub(super) struct Precision {
    pub covariance_mm2: Matrix6<f64>,
    pub effective_size: EffectiveSize,
}

impl Precision {
    pub fn of_tip_mm2(&self) -> Matrix3<f64> {
        self.covariance_mm2.fixed_view::<3, 3>(0, 0).into_owned()
    }
}

/// Of a fit of poses that determine it.
pub(super) fn of(poses: &[Pose], fit: &Fit) -> Precision {
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

/// `None` where a quarter does not determine the tip, or is too short to tell how well.
pub(super) fn quarters(poses: &[Pose], min_turn_rad: f64) -> Option<Quarters> {
    let part = |k: usize| &poses[k * poses.len() / QUARTERS..(k + 1) * poses.len() / QUARTERS];
    if part(0).len() < PivotLimits::MIN_POSES {
        return None;
    }
    let (mut tips, mut freedom) = (Vec::new(), usize::MAX);
    for k in 0..QUARTERS {
        let fit = Fit::of(part(k)).filter(|fit| fit.least_turn_rad() >= min_turn_rad)?;
        let precision = of(part(k), &fit);
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
        expected_mm: worst_mm(&(tips[a].1 + tips[b].1)),
        has_drift: by_chance.sf(ratio) < AGREEMENT,
    })
}

impl Fit {
    /// Of `Σ (R − R̄)ᵀ (R − R̄)`.
    fn inverse(&self) -> Matrix3<f64> {
        let squares = self.singular_values.map(|s| (s * s).recip());
        self.axes * Matrix3::from_diagonal(&squares) * self.axes.transpose()
    }
}

/// Of tip and pivot, for readings that are independent of each other.
pub(super) fn independent_mm2(fit: &Fit, residuals: &[Vector3<f64>]) -> Matrix6<f64> {
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

/// Standard deviation along the direction in which it is largest.
pub(super) fn worst_mm(covariance_mm2: &Matrix3<f64>) -> f64 {
    covariance_mm2.symmetric_eigenvalues().max().max(0.0).sqrt()
}
