//! A closed form to start from, over all sensors at once, that outliers hardly bias.
//!
//! Rotations: `R_A = R_Y R_B R_X` is linear in the nine numbers of `R_Y` and of each `R_Xᵀ`, and the
//! Kronecker products `M = Σ R_B ⊗ R_A` have them as their first singular vectors (Shah, *Solving the
//! robot-world/hand-eye calibration problem using the Kronecker product*, J. Mechanisms Robotics
//! 5(3), 2013; here one `M` a sensor side by side, with `R_Y` in common). Then positions by linear
//! least squares. Each is done a few times over, with readings weighted by what they were off.

use super::PairedReading;
use super::solve::Frames;
use crate::robust::median;
use nalgebra::{DMatrix, DVector, Matrix3, SMatrix, SVector, UnitQuaternion, Vector3};
use trackwright_geometry::pose::{Pose, pose_from_parts};
use trackwright_geometry::rotation::rotation_angle_rad;
use trackwright_geometry::svd3::svd3;

/// Rounds of reweighting: each takes the pull of an outlier down by about its distance in scales.
const ROUNDS: usize = 8;

/// A weight of `1 / (1 + (off / median)²)`.
fn weights_of(off: &[f64]) -> Vec<f64> {
    let middle = median(&mut off.to_vec()).unwrap_or(0.0).max(1e-12);
    off.iter().map(|d| 1.0 / (1.0 + (d / middle).powi(2))).collect()
}

/// `None` where there is no answer.
pub(super) fn start(readings: &[PairedReading], sensors: usize) -> Option<Frames> {
    let (y, x) = reweighted(
        readings,
        |weights| solve_rotations(readings, sensors, weights),
        |(y, x), r| {
            let expected = y * r.reference_from_body.rotation * x[r.sensor];
            rotation_angle_rad(&(expected.inverse() * r.tracker_from_sensor.rotation))
        },
    )?;
    reweighted(
        readings,
        |weights| solve_translations(readings, &y, &x, weights),
        |found, r| found.residual(r).position_mm.norm(),
    )
}

/// Solves some times over, with readings weighted by what they were off before.
fn reweighted<T>(
    readings: &[PairedReading],
    solve: impl Fn(&[f64]) -> Option<T>,
    off: impl Fn(&T, &PairedReading) -> f64,
) -> Option<T> {
    let mut weights = vec![1.0; readings.len()];
    let mut found = None;
    for _ in 0..ROUNDS {
        let now = solve(&weights)?;
        weights = weights_of(&readings.iter().map(|r| off(&now, r)).collect::<Vec<_>>());
        found = Some(now);
    }
    found
}

type Rotations = (UnitQuaternion<f64>, Vec<UnitQuaternion<f64>>);

/// The rotations of `Y` and of each `X`.
fn solve_rotations(
    readings: &[PairedReading],
    sensors: usize,
    weights: &[f64],
) -> Option<Rotations> {
    let mut products = vec![SMatrix::<f64, 9, 9>::zeros(); sensors];
    let mut totals = vec![0.0; sensors];
    for (reading, weight) in readings.iter().zip(weights) {
        let matrix = |pose: &Pose| pose.rotation.to_rotation_matrix().into_inner();
        let b = matrix(&reading.reference_from_body);
        let a = matrix(&reading.tracker_from_sensor);
        products[reading.sensor] += b.kronecker(&a) * *weight;
        totals[reading.sensor] += *weight;
    }
    // vec(R_Y): the first left singular vector of [M_1 … M_K], each by the root of its weight.
    let squares: SMatrix<f64, 9, 9> = products
        .iter()
        .zip(&totals)
        .filter(|(_, total)| **total > 0.0)
        .map(|(m, total)| m * m.transpose() / *total)
        .sum();
    let eigen = squares.symmetric_eigen();
    let first = eigen.eigenvalues.imax();
    let y: SVector<f64, 9> = eigen.eigenvectors.column(first).into_owned();
    let matrix = |v: &SVector<f64, 9>| Matrix3::from_column_slice(v.as_slice());
    let y_matrix = matrix(&y);
    // A singular vector has either sign; a rotation has one.
    let sign = y_matrix.determinant().signum();
    let tracker_from_reference = nearest_rotation(&(y_matrix * sign))?;
    let x = products.iter().map(|m| {
        let x_transposed = matrix(&(m.transpose() * y * sign));
        nearest_rotation(&x_transposed.transpose())
    });
    Some((tracker_from_reference, x.collect::<Option<Vec<_>>>()?))
}

fn nearest_rotation(matrix: &Matrix3<f64>) -> Option<UnitQuaternion<f64>> {
    let is_finite = matrix.iter().all(|v| v.is_finite());
    // `best_rotation` is of Σ q q'ᵀ, the transpose of what takes q to q'.
    is_finite.then(|| svd3(&matrix.transpose()).best_rotation())
}

/// The translations of `Y` and of each `X`: `R_Y R_B t_X + t_Y = t_A − R_Y t_B`.
fn solve_translations(
    readings: &[PairedReading],
    y: &UnitQuaternion<f64>,
    x: &[UnitQuaternion<f64>],
    weights: &[f64],
) -> Option<Frames> {
    let unknowns = 3 + 3 * x.len();
    let mut normal = DMatrix::<f64>::zeros(unknowns, unknowns);
    let mut right = DVector::<f64>::zeros(unknowns);
    for (reading, &weight) in readings.iter().zip(weights) {
        let at = |pose: &Pose| pose.translation.vector;
        let turn = (y * reading.reference_from_body.rotation).to_rotation_matrix().into_inner();
        let shift: Vector3<f64> =
            at(&reading.tracker_from_sensor) - y * at(&reading.reference_from_body);
        let k = 3 + 3 * reading.sensor;
        let mut add = |row: usize, column: usize, block: Matrix3<f64>| {
            let mut view = normal.fixed_view_mut::<3, 3>(row, column);
            view += block * weight;
        };
        add(0, 0, Matrix3::identity());
        add(k, k, Matrix3::identity());
        add(0, k, turn);
        add(k, 0, turn.transpose());
        let mut rows = right.fixed_rows_mut::<3>(0);
        rows += shift * weight;
        let mut rows = right.fixed_rows_mut::<3>(k);
        rows += turn.transpose() * shift * weight;
    }
    let translations = normal.cholesky()?.solve(&right);
    let part = |first: usize| translations.fixed_rows::<3>(first).into_owned();
    Some(Frames {
        y: pose_from_parts(part(0), *y),
        x: x.iter().enumerate().map(|(k, turn)| pose_from_parts(part(3 + 3 * k), *turn)).collect(),
    })
}
