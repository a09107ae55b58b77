//! Covariance of the field between two sensor poses.

use super::kernel_columns::PointColumns;
use super::row::Row;
use crate::field_point::FieldPoint;
use faer::Mat;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

/// One length scale of a field.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct KernelScale {
    /// Length of the Matérn 5/2 kernel in position, mm.
    pub length_mm: f64,
    /// Sine of the angle between axes at which the covariance falls to `exp(-1/2)`; infinite where
    /// the axis does not matter.
    pub axis_sine: f64,
    /// The same for the second axis of 6-DOF sensors.
    #[serde(default = "infinite")]
    pub x_axis_sine: f64,
    /// Part of the variance.
    pub variance: f64,
}

fn infinite() -> f64 {
    f64::INFINITY
}

/// `k` of the process of unit amplitude, and the noise of a row beside it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Kernel {
    pub scales: [KernelScale; 2],
    /// Variance of a row's noise, and of what changes from row to row.
    pub nugget: f64,
}

impl Kernel {
    /// Covariance of the process between two sensor poses, without noise.
    pub fn covariance(&self, a: &FieldPoint, b: &FieldPoint) -> f64 {
        let distance_mm = (a.position_mm - b.position_mm).norm();
        let [sine_squared, x_sine_squared] =
            a.cosines(b).map(|cosine| (1.0 - cosine * cosine).max(0.0));
        let scale = |scale: &KernelScale| {
            let of_axis = sine_squared / (scale.axis_sine * scale.axis_sine);
            let of_x_axis = x_sine_squared / (scale.x_axis_sine * scale.x_axis_sine);
            let turn = 0.5 * (of_axis + of_x_axis);
            scale.variance * matern(distance_mm / scale.length_mm, turn)
        };
        self.scales.iter().map(scale).sum()
    }

    /// Variance of the process at any pose.
    pub fn variance(&self) -> f64 {
        self.scales.iter().map(|scale| scale.variance).sum()
    }

    /// Covariances between each of `a` (rows) and each of `b` (columns).
    pub fn matrix(&self, a: &[FieldPoint], b: &[FieldPoint]) -> Mat<f64> {
        let rows = PointColumns::of(a);
        let columns: Vec<Vec<f64>> =
            b.par_iter().map(|b| rows.matern(&self.scales, 0, b)).collect();
        Mat::from_fn(a.len(), b.len(), |i, j| columns[j][i])
    }

    /// Covariances among points, the lower triangle: what a Cholesky factor is made of. The upper one is
    /// zero.
    pub fn lower_triangle(&self, points: &[FieldPoint]) -> Mat<f64> {
        let rows = PointColumns::of(points);
        lower_from(points.len(), |j| rows.matern(&self.scales, j, &points[j]))
    }

    /// Covariances among rows with their noise, the lower triangle.
    pub(super) fn of_rows(&self, rows: &[Row]) -> Mat<f64> {
        let points: Vec<_> = rows.iter().map(|row| row.point).collect();
        let mut matrix = self.lower_triangle(&points);
        for (i, row) in rows.iter().enumerate() {
            matrix[(i, i)] += self.nugget * row.noise_factor;
        }
        matrix
    }
}

/// A lower triangle of `n` columns, each of which begins at the diagonal.
pub(super) fn lower_from(n: usize, column: impl Fn(usize) -> Vec<f64> + Sync + Send) -> Mat<f64> {
    let columns: Vec<_> = (0..n).into_par_iter().map(column).collect();
    Mat::from_fn(n, n, |i, j| match i.checked_sub(j) {
        Some(below) => columns[j][below],
        None => 0.0,
    })
}

/// Matérn 5/2 correlation at a distance over the length, times `exp(-turn)`.
pub(super) fn matern(distance: f64, turn: f64) -> f64 {
    let t = 5.0_f64.sqrt() * distance;
    (1.0 + t + t * t / 3.0) * (-t - turn).exp()
}
