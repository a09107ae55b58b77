//! The damped normal equations of the harmonics' coefficients, and their solution to the accuracy
//! of a QR decomposition.
//!
//! A measurement's rows are `W ⊗ g`, five combinations of the coils times one vector of slopes. So
//! a block of `AᵀA` is `Gᵀ diag(ω) G`, which costs a tenth of a QR of all rows. What squaring the
//! condition loses is given back by iterative refinement with the residuals of the rows themselves
//! (corrected seminormal equations; Björck, Linear Algebra and its Applications 88/89, 1987). Each
//! step gains `ε κ²`; with a ridge of 1e-6 the damped condition `κ` is at most 1e6, so three digits
//! or more. Where that is not enough the rows are put together and decomposed by QR.

use super::rows::{Harmonics, Maps, SolveError};
use faer::linalg::matmul::matmul;
use faer::linalg::solvers::Solve;
use faer::{Accum, Mat, MatRef, Par, Side};
use rayon::prelude::*;
use trackwright_task::{Cancelled, Task};

/// Measurements multiplied at a time: their scaled slopes of 80 terms stay in the cache.
const BLOCK: usize = 256;

/// Change of what the coefficients predict, relative to the right side, where refinement has ended.
const REFINED: f64 = 1e-12;

/// The same where a step no longer gains: a millionth of any noise. Only where columns are the same
/// to many digits is more lost, and QR used.
const REFINED_ENOUGH: f64 = 1e-8;

const MAX_REFINEMENTS: usize = 8;

/// Powers of a matrix by which its largest eigenvalue is found, and its relative change where that has ended.
const MAX_POWERS: usize = 500;
const POWER_SETTLED: f64 = 1e-15;

/// The least gain of a refinement step.
const MIN_GAIN: f64 = 0.3;

/// Rows of some measurements, with a weight each, in the leading terms of each coil.
pub(super) struct System<'a> {
    maps: &'a Maps,
    terms: usize,
    used: Vec<usize>,
    /// For each axis the slopes of the measurements used.
    slopes: Vec<Mat<f64>>,
    /// Their `y`.
    right: Vec<f64>,
}

/// A solution and what its covariance follows from.
pub(super) struct Solved {
    /// Coil after coil.
    pub(super) coefficients: Vec<f64>,
    /// Lower triangle of the damped normal matrix of the scaled columns.
    pub(super) factor: Mat<f64>,
    /// Squared norm of the damped, scaled coefficients.
    pub(super) penalty: f64,
}

/// Norms of the columns, and the damping that a ridge makes with them.
#[derive(Clone)]
pub(super) struct Scaling {
    pub(super) norms: Vec<f64>,
    /// `(ridge · s_max)²`.
    pub(super) damping: f64,
}

impl<'a> System<'a> {
    /// The rows of the measurements `used`, with the first `terms` of each coil.
    pub(super) fn new(
        harmonics: &Harmonics,
        maps: &'a Maps,
        terms: usize,
        used: Vec<usize>,
    ) -> Self {
        let slopes = harmonics.slopes.iter();
        Self {
            slopes: slopes
                .map(|all| Mat::from_fn(used.len(), terms, |row, k| all[(used[row], k)]))
                .collect(),
            right: used.iter().flat_map(|&m| maps.right(m)).copied().collect(),
            maps,
            terms,
            used,
        }
    }

    pub(super) fn used(&self) -> &[usize] {
        &self.used
    }

    /// Rows of one measurement.
    pub(super) fn dof(&self) -> usize {
        self.maps.dof
    }

    pub(super) fn unknowns(&self) -> usize {
        self.maps.coils * self.terms
    }

    /// For each axis `n·∇Y` of the measurements used.
    pub(super) fn slopes(&self) -> &[Mat<f64>] {
        &self.slopes
    }

    pub(super) fn maps(&self) -> &Maps {
        self.maps
    }

    /// `Aᵀ diag(w) A` with a weight for each measurement, both halves. The blocks of pairs of coils
    /// are independent, so that the result does not depend on the number of threads.
    pub(super) fn gram(&self, task: &Task, weights: &[f64]) -> Result<Mat<f64>, Cancelled> {
        let coils = self.maps.coils;
        let pairs: Vec<_> = (0..coils).flat_map(|i| (0..=i).map(move |j| (i, j))).collect();
        let blocks: Vec<_> = pairs
            .par_iter()
            .map(|&(i, j)| {
                task.step(0, 1)?;
                Ok(self.pair(i, j, weights))
            })
            .collect::<Result<_, Cancelled>>()?;
        let mut gram = Mat::zeros(self.unknowns(), self.unknowns());
        for (&(i, j), block) in pairs.iter().zip(&blocks) {
            let (i, j) = (i * self.terms, j * self.terms);
            for column in 0..self.terms {
                for row in 0..self.terms {
                    gram[(i + row, j + column)] = block[(row, column)];
                    gram[(j + column, i + row)] = block[(row, column)];
                }
            }
        }
        Ok(gram)
    }

    /// [`Self::gram`] where most weights are zero.
    pub(super) fn gram_of_some(&self, task: &Task, weights: &[f64]) -> Result<Mat<f64>, Cancelled> {
        let some: Vec<_> = (0..weights.len()).filter(|&k| weights[k] != 0.0).collect();
        let pick = |all: &Mat<f64>| Mat::from_fn(some.len(), self.terms, |k, t| all[(some[k], t)]);
        let part = Self {
            maps: self.maps,
            terms: self.terms,
            used: some.iter().map(|&k| self.used[k]).collect(),
            slopes: self.slopes.iter().map(pick).collect(),
            right: Vec::new(),
        };
        let weights: Vec<_> = some.iter().map(|&k| weights[k]).collect();
        part.gram(task, &weights)
    }

    /// The block of two coils.
    fn pair(&self, i: usize, j: usize, weights: &[f64]) -> Mat<f64> {
        let maps = self.maps;
        let signals = maps.signals();
        let mut sum = Mat::zeros(self.terms, self.terms);
        let mut scaled = Mat::zeros(BLOCK, self.terms);
        let mut omega = [0.0; BLOCK];
        for first in (0..self.used.len()).step_by(BLOCK) {
            let count = BLOCK.min(self.used.len() - first);
            for (a, left) in self.slopes.iter().enumerate() {
                let mut scaled = scaled.as_mut().subrows_mut(0, count);
                scaled.fill(0.0);
                for (b, right) in self.slopes.iter().enumerate() {
                    for (k, omega) in omega[..count].iter_mut().enumerate() {
                        let rows = maps.map(self.used[first + k]).chunks_exact(signals);
                        let (i, j) = (a * maps.coils + i, b * maps.coils + j);
                        let inner: f64 = rows.map(|row| row[i] * row[j]).sum();
                        *omega = inner * weights[first + k];
                    }
                    let right = right.as_ref().subrows(first, count);
                    for column in 0..self.terms {
                        let from = right.col(column);
                        let mut to = scaled.as_mut().col_mut(column);
                        for k in 0..count {
                            to[k] += omega[k] * from[k];
                        }
                    }
                }
                let left = left.as_ref().subrows(first, count);
                let scaled = scaled.as_ref();
                matmul(sum.as_mut(), Accum::Add, left.transpose(), scaled, 1.0, Par::Seq);
            }
        }
        sum
    }

    /// `y − A a`, measurement after measurement.
    pub(super) fn residuals(&self, coefficients: &[f64]) -> Vec<f64> {
        let (coils, dof) = (self.maps.coils, self.maps.dof);
        let coefficients = MatRef::from_column_major_slice(coefficients, self.terms, coils);
        let signals: Vec<_> = self.slopes.iter().map(|s| s * coefficients).collect();
        let mut out = self.right.clone();
        for (k, (&m, out)) in self.used.iter().zip(out.chunks_exact_mut(dof)).enumerate() {
            let rows = self.maps.map(m).chunks_exact(self.maps.signals());
            for (out, row) in out.iter_mut().zip(rows) {
                for (signals, row) in signals.iter().zip(row.chunks_exact(coils)) {
                    for (coil, w) in row.iter().enumerate() {
                        *out -= w * signals[(k, coil)];
                    }
                }
            }
        }
        out
    }

    /// `Aᵀ diag(w) x`, coil after coil.
    pub(super) fn adjoint(&self, x: &[f64], weights: &[f64]) -> Vec<f64> {
        let (coils, dof) = (self.maps.coils, self.maps.dof);
        let mut sum = Mat::<f64>::zeros(self.terms, coils);
        for (axis, slopes) in self.slopes.iter().enumerate() {
            let mut signals = Mat::<f64>::zeros(self.used.len(), coils);
            for (k, (&m, x)) in self.used.iter().zip(x.chunks_exact(dof)).enumerate() {
                let rows = self.maps.map(m).chunks_exact(self.maps.signals());
                for (row, x) in rows.zip(x) {
                    for (coil, w) in row[axis * coils..][..coils].iter().enumerate() {
                        signals[(k, coil)] += w * x * weights[k];
                    }
                }
            }
            sum += slopes.transpose() * signals;
        }
        (0..coils)
            .flat_map(|coil| (0..self.terms).map(move |k| (k, coil)))
            .map(|at| sum[at])
            .collect()
    }

    /// The least of `‖A a − y‖²_w + damping ‖a‖²` in scaled columns.
    pub(super) fn solve(
        &self,
        gram: &Mat<f64>,
        weights: &[f64],
        scaling: &Scaling,
    ) -> Result<Solved, SolveError> {
        match self.solve_normal(gram, weights, scaling) {
            Some(solved) => Ok(solved),
            None => self.solve_rows(weights, scaling),
        }
    }

    /// By Cholesky and refinement; `None` where that does not converge.
    fn solve_normal(&self, gram: &Mat<f64>, weights: &[f64], scaling: &Scaling) -> Option<Solved> {
        let norms = &scaling.norms;
        let unknowns = self.unknowns();
        let mut matrix =
            Mat::from_fn(unknowns, unknowns, |i, j| gram[(i, j)] / (norms[i] * norms[j]));
        for k in 0..unknowns {
            matrix[(k, k)] += scaling.damping;
        }
        let factor = matrix.llt(Side::Lower).ok()?;
        let right = norm(&self.right);
        let mut scaled = vec![0.0; unknowns];
        let mut before = f64::INFINITY;
        for _ in 0..MAX_REFINEMENTS {
            let coefficients = unscale(&scaled, norms);
            let gradient = self.adjoint(&self.residuals(&coefficients), weights);
            let gradient = Mat::from_fn(unknowns, 1, |k, _| {
                gradient[k] / norms[k] - scaling.damping * scaled[k]
            });
            let step = factor.solve(&gradient);
            for (k, value) in scaled.iter_mut().enumerate() {
                *value += step[(k, 0)];
            }
            // In the norm of the matrix: the change of the damped prediction.
            let change = (step.transpose() * &gradient)[(0, 0)].max(0.0).sqrt();
            let is_stuck = change > MIN_GAIN * before;
            if change <= REFINED * right || (is_stuck && change <= REFINED_ENOUGH * right) {
                return Some(Solved {
                    penalty: scaling.damping * norm(&scaled).powi(2),
                    coefficients: unscale(&scaled, norms),
                    factor: factor.L().to_owned(),
                });
            }
            if is_stuck || !change.is_finite() {
                return None;
            }
            before = change;
        }
        None
    }

    /// By QR of all rows with the damping below them.
    fn solve_rows(&self, weights: &[f64], scaling: &Scaling) -> Result<Solved, SolveError> {
        let (unknowns, dof) = (self.unknowns(), self.maps.dof);
        let rows = self.used.len() * dof;
        let damping = scaling.damping.sqrt();
        if damping == 0.0 && rows < unknowns {
            return Err(SolveError::NotDetermined);
        }
        let mut matrix = Mat::zeros(rows + unknowns, unknowns);
        let mut right = Mat::zeros(rows + unknowns, 1);
        for row in 0..rows {
            let k = row / dof;
            let weight = weights[k].sqrt();
            let map = &self.maps.map(self.used[k])[(row % dof) * self.maps.signals()..];
            right[(row, 0)] = weight * self.right[row];
            for column in 0..unknowns {
                let (coil, term) = (column / self.terms, column % self.terms);
                let axes = self.slopes.iter().zip(map[coil..].iter().step_by(self.maps.coils));
                let sum: f64 = axes.map(|(slopes, w)| w * slopes[(k, term)]).sum();
                matrix[(row, column)] = weight * sum / scaling.norms[column];
            }
        }
        for k in 0..unknowns {
            matrix[(rows + k, k)] = damping;
        }
        let qr = matrix.qr();
        let r = qr.thin_R();
        let largest = (0..unknowns).fold(0.0_f64, |m, k| m.max(r[(k, k)].abs()));
        let floor = largest * f64::EPSILON * unknowns as f64;
        if (0..unknowns).any(|k| r[(k, k)].abs() <= floor) || !largest.is_finite() {
            return Err(SolveError::NotDetermined);
        }
        let mut rotated = qr.compute_thin_Q().transpose() * right;
        r.solve_upper_triangular_in_place(rotated.as_mut());
        let scaled: Vec<_> = (0..unknowns).map(|k| rotated[(k, 0)]).collect();
        // The sign of a column is free; that of a Cholesky factor is positive on the diagonal.
        let factor = Mat::from_fn(unknowns, unknowns, |i, j| {
            if i < j { 0.0 } else { r[(j, i)] * r[(j, j)].signum() }
        });
        Ok(Solved {
            penalty: scaling.damping * norm(&scaled).powi(2),
            coefficients: unscale(&scaled, &scaling.norms),
            factor,
        })
    }
}

impl Scaling {
    /// Norms of the columns, and `(ridge · s_max)²` with the largest singular value of the columns
    /// scaled by them.
    pub(super) fn new(gram: &Mat<f64>, ridge: f64) -> Result<Self, SolveError> {
        let unknowns = gram.nrows();
        let norm = |k: usize| Some(gram[(k, k)].sqrt()).filter(|norm| *norm > 0.0);
        let norms: Vec<_> = (0..unknowns).map(|k| norm(k).unwrap_or(1.0)).collect();
        let scaled = Mat::from_fn(unknowns, unknowns, |i, j| gram[(i, j)] / (norms[i] * norms[j]));
        let largest = largest_eigenvalue(&scaled).ok_or(SolveError::NotDetermined)?;
        Ok(Self { norms, damping: ridge * ridge * largest })
    }
}

/// Of a symmetric matrix without negative eigenvalues, by power iteration: all of them would take as long as
/// the matrix itself. `None` of a matrix that is zero or not finite.
fn largest_eigenvalue(matrix: &Mat<f64>) -> Option<f64> {
    // No eigenvector of a symmetric arrangement of coils.
    let mut vector = Mat::from_fn(matrix.nrows(), 1, |k, _| 1.0 + 0.3 * (1.7 * k as f64).sin());
    let mut before = 0.0;
    for _ in 0..MAX_POWERS {
        let size = vector.norm_l2();
        vector *= faer::Scale(1.0 / size);
        let next = matrix * &vector;
        let value = (vector.transpose() * &next)[(0, 0)];
        if !(value.is_finite() && value > 0.0) {
            return None;
        }
        if (value - before).abs() <= POWER_SETTLED * value {
            return Some(value);
        }
        (before, vector) = (value, next);
    }
    let values = matrix.self_adjoint_eigenvalues(Side::Lower).ok()?;
    values.last().copied().filter(|value| value.is_finite() && *value > 0.0)
}

fn unscale(scaled: &[f64], norms: &[f64]) -> Vec<f64> {
    scaled.iter().zip(norms).map(|(a, norm)| a / norm).collect()
}

fn norm(values: &[f64]) -> f64 {
    values.iter().map(|v| v * v).sum::<f64>().sqrt()
}

#[cfg(test)]
mod tests {
    use super::super::fit::tests::room_a;
    use super::super::solid_harmonics::terms;
    use super::*;
    use crate::generator::Generator;

    fn parts(six: bool) -> (Harmonics, Maps) {
        let mut set = room_a("fit");
        set.measurements.truncate(120);
        if six {
            set.content = crate::samples::MeasurementContent::SixDof;
        }
        let (task, generator) = (Task::default(), Generator::planar_nine());
        (
            Harmonics::new(&set.measurements, set.content, 3),
            Maps::new(&task, &generator, &set.measurements, set.content).unwrap(),
        )
    }

    #[test]
    fn cholesky_with_refinement_is_qr() {
        for six in [false, true] {
            let (harmonics, maps) = parts(six);
            // Also with the leading terms only.
            for degree in [2, 3] {
                let used = (0..120).filter(|k| k % 7 != 3).collect();
                let system = System::new(&harmonics, &maps, terms(degree), used);
                let weights: Vec<_> =
                    (0..system.used().len()).map(|k| if k % 5 == 0 { 0.3 } else { 1.0 }).collect();
                let gram = system.gram(&Task::default(), &weights).unwrap();
                let scaling = Scaling::new(&gram, 1e-6).unwrap();
                let normal = system.solve_normal(&gram, &weights, &scaling).unwrap();
                let rows = system.solve_rows(&weights, &scaling).unwrap();
                let size = norm(&rows.coefficients);
                let gap: Vec<_> = normal
                    .coefficients
                    .iter()
                    .zip(&rows.coefficients)
                    .map(|(a, b)| a - b)
                    .collect();
                // The condition is at most 1e6.
                assert!(norm(&gap) < 1e-10 * size, "{}", norm(&gap) / size);
                let gap = (&normal.factor - &rows.factor).norm_l2();
                assert!(gap < 1e-8 * rows.factor.norm_l2(), "{gap}");
            }
        }
    }

    #[test]
    fn the_normal_matrix_is_that_of_the_rows() {
        for six in [false, true] {
            let (harmonics, maps) = parts(six);
            let system = System::new(&harmonics, &maps, terms(2), (0..120).collect());
            let weights = vec![1.0; 120];
            let gram = system.gram(&Task::default(), &weights).unwrap();
            let unknowns = system.unknowns();
            for column in [0, 5, unknowns - 1] {
                let mut unit = vec![0.0; unknowns];
                unit[column] = 1.0;
                let zero = system.residuals(&vec![0.0; unknowns]);
                let moved = system.residuals(&unit);
                let product: Vec<_> = zero.iter().zip(&moved).map(|(a, b)| a - b).collect();
                let expected = system.adjoint(&product, &weights);
                for (row, expected) in expected.iter().enumerate() {
                    let scale = (gram[(row, row)] * gram[(column, column)]).sqrt();
                    assert!((gram[(row, column)] - expected).abs() < 1e-12 * scale);
                }
            }
        }
    }

    #[test]
    fn the_largest_eigenvalue_is_that_of_all() {
        let (harmonics, maps) = parts(true);
        for degree in [1, 2, 3] {
            let system = System::new(&harmonics, &maps, terms(degree), (0..120).collect());
            let gram = system.gram(&Task::default(), &[1.0; 120]).unwrap();
            let all = gram.self_adjoint_eigenvalues(Side::Lower).unwrap();
            let found = largest_eigenvalue(&gram).unwrap();
            assert!((found / all.last().unwrap() - 1.0).abs() < 1e-10, "{found} {all:?}");
        }
        // Equal eigenvalues, and next to equal ones.
        let of = |values: [f64; 3]| Mat::from_fn(3, 3, |i, j| if i == j { values[i] } else { 0.0 });
        for values in [[2.0; 3], [2.0, 2.0 - 1e-9, 1.0], [0.0, 0.0, 1e-9]] {
            let found = largest_eigenvalue(&of(values)).unwrap();
            assert!((found / values[0].max(values[2]) - 1.0).abs() < 1e-9, "{found}");
        }
        for values in [[0.0; 3], [f64::NAN, 1.0, 1.0], [f64::INFINITY, 1.0, 1.0]] {
            assert_eq!(largest_eigenvalue(&of(values)), None);
        }
    }

    #[test]
    fn unknowns_without_rows_or_ridge_are_refused() {
        let (harmonics, maps) = parts(false);
        let system = System::new(&harmonics, &maps, terms(3), vec![0, 1, 2]);
        let weights = [1.0; 3];
        let gram = system.gram(&Task::default(), &weights).unwrap();
        let scaling = Scaling::new(&gram, 0.0).unwrap();
        assert_eq!(system.solve(&gram, &weights, &scaling).err(), Some(SolveError::NotDetermined));
        let scaling = Scaling::new(&gram, 1e-6).unwrap();
        let solved = system.solve(&gram, &weights, &scaling).unwrap();
        assert!(norm(&system.residuals(&solved.coefficients)) < 1e-3 * norm(&system.right));
    }
}
