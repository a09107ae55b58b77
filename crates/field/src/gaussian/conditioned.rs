//! A process given rows: their covariance factored once, then evaluated at any poses.

use super::amplitude::Amplitude;
use super::column_blocks::solve_lower;
use super::field::Row;
use super::fit::{GaussianError, factored, scaled};
use super::hyper_parameters::errors_of;
use super::kernel::{FieldPoint, Kernel};
use faer::Mat;
use faer::linalg::solvers::{Llt, Solve};

/// Of unit amplitude; the rows are divided by theirs.
pub(super) struct Conditioned {
    pub kernel: Kernel,
    points: Vec<FieldPoint>,
    factor: Llt<f64>,
    weights: Mat<f64>,
}

impl Conditioned {
    /// # Errors
    /// [`GaussianError::NotPositiveDefinite`].
    pub fn new(
        mut kernel: Kernel,
        rows: &[Row],
        amplitude: &Amplitude,
    ) -> Result<Self, GaussianError> {
        let rows = scaled(rows, amplitude);
        let factor = factored(&mut kernel, &rows)?;
        Ok(Self {
            kernel,
            weights: factor.solve(&errors_of(&rows)),
            factor,
            points: rows.iter().map(|row| row.point).collect(),
        })
    }

    pub fn rows(&self) -> usize {
        self.points.len()
    }

    /// The mean, a row a pose, and `V = L⁻¹ K(rows, at)`: `V' V` is the covariance that the rows explain.
    pub fn at(&self, at: &[FieldPoint]) -> (Mat<f64>, Mat<f64>) {
        let across = self.kernel.matrix(&self.points, at);
        let mean = across.transpose() * &self.weights;
        let mut explained = across;
        solve_lower(self.factor.L(), explained.as_mut());
        (mean, explained)
    }
}
