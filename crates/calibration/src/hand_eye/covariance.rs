//! How far the answer is to be believed: a sandwich over poses.
//!
//! A distorted field shifts all sensors of a pose together, and residuals are not normal, so the
//! curvature alone would promise too much. With `g` the gradient of a pose's part of the cost and
//! `H` the curvature of the whole, the covariance is `H⁻¹ Ω H⁻¹` with `Ω` that of `Σ g` (Huber 1967;
//! over clusters: Liang & Zeger 1986), with the usual factor for few clusters. Poses in the order in
//! which they were recorded are near each other, and the field distorts them alike: `Ω` is that of
//! neighbours which are not independent (`calibration/long_run.rs`). What the room does alike
//! everywhere is in the answer itself, and no residual shows it.

use super::PairedReading;
use super::solve::{Solved, scatter_matrix, scatter_vector, whitened_slopes};
use crate::long_run::{LongRun, long_run_along};
use crate::robust::Loss;
use nalgebra::{DMatrix, DVector, SMatrix};
use std::collections::BTreeMap;

/// Of small changes of all unknowns; `None` where the curvature is not positive.
pub(super) fn covariance(
    readings: &[PairedReading],
    solved: &Solved,
    loss: Loss,
) -> Option<LongRun> {
    let unknowns = solved.frames.unknowns();
    let mut curvature = DMatrix::zeros(unknowns, unknowns);
    let mut of_weights = DMatrix::zeros(unknowns, unknowns);
    let mut gradients: BTreeMap<usize, DVector<f64>> = BTreeMap::new();
    for (reading, sigma) in readings.iter().zip(&solved.sigmas) {
        let residual = solved.frames.residual(reading);
        let slopes = whitened_slopes(solved.frames.slopes(reading, &residual), sigma);
        let r = residual.whitened(sigma);
        let s = r.norm();
        let weight = loss.weight(s);
        // ρ bends along the residual by ρ'' and across it by ρ' / s.
        let along = if s > 0.0 { (loss.curvature(s) - weight) / (s * s) } else { 0.0 };
        let bend = SMatrix::<f64, 6, 6>::identity() * weight + r * r.transpose() * along;
        let full = slopes.transpose() * bend * slopes;
        scatter_matrix(&mut curvature, reading.sensor, &full);
        let straight = slopes.transpose() * slopes * weight;
        scatter_matrix(&mut of_weights, reading.sensor, &straight);
        let gradient = gradients.entry(reading.pose).or_insert_with(|| DVector::zeros(unknowns));
        scatter_vector(gradient, reading.sensor, &(slopes.transpose() * r * weight));
    }
    // By number of the pose, which is the order of recording.
    let scores = DMatrix::from_columns(&gradients.into_values().collect::<Vec<_>>());
    let found = long_run_along(&scores, &(&scores * scores.transpose()), &of_weights);
    // A loss that is not convex can bend the wrong way where many readings are far.
    let inverse = inverse(&curvature).or_else(|| inverse(&of_weights))?;
    let (clusters, values) = (scores.ncols() as f64, 6.0 * readings.len() as f64);
    let factor = clusters / (clusters - 1.0) * (values - 1.0) / (values - unknowns as f64).max(1.0);
    Some(LongRun { covariance: &inverse * found.covariance * &inverse * factor, ..found })
}

/// Of a positive definite matrix, its rows and columns divided by the root of the diagonal first.
fn inverse(matrix: &DMatrix<f64>) -> Option<DMatrix<f64>> {
    let lengths = matrix.diagonal().map(f64::sqrt);
    let divided = |m: &DMatrix<f64>| {
        DMatrix::from_fn(m.nrows(), m.ncols(), |i, j| m[(i, j)] / (lengths[i] * lengths[j]))
    };
    Some(divided(&divided(matrix).cholesky()?.inverse()))
}
