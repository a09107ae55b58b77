//! How well measurements determine the coefficients of a harmonic model.

use super::model::HarmonicModel;
use super::solid_harmonics::{MAX_TERMS, gradients, terms};
use crate::generator::reading::{LEVER_MM, Orientation, ReadingError, for_rows};
use faer::Mat;
use nalgebra::{Matrix5, Point3, SMatrix, Unit, Vector3, Vector5};

/// Posterior covariance of the coefficients for rows with unit noise, as its factor: with `L` lower
/// triangular and `D` the norms of the columns it is `D⁻¹ L⁻ᵀ L⁻¹ D⁻¹`. Times the variance of the
/// rows it is the covariance.
///
/// The prior is the ridge's: scaled coefficients of standard deviation `1 / (ridge · s_max)`.
#[derive(Clone, Debug)]
pub struct CoefficientCovariance {
    factor: Mat<f64>,
    norms: Vec<f64>,
}

impl CoefficientCovariance {
    pub(super) fn new(factor: Mat<f64>, norms: Vec<f64>) -> Self {
        Self { factor, norms }
    }

    /// Number of coefficients.
    pub fn len(&self) -> usize {
        self.norms.len()
    }

    /// Whether there are no coefficients.
    pub fn is_empty(&self) -> bool {
        self.norms.is_empty()
    }

    /// `L`, lower triangular, of the scaled coefficients.
    pub fn factor(&self) -> &Mat<f64> {
        &self.factor
    }

    /// `D`: a coefficient times its norm is the scaled one.
    pub fn norms(&self) -> &[f64] {
        &self.norms
    }

    /// Coefficients drawn about a mean: `mean + noise_mm · D⁻¹ L⁻ᵀ z` for independent standard
    /// normal `z`.
    ///
    /// # Panics
    /// If `mean` or `z` have another length than the coefficients.
    pub fn draw(&self, mean: &[f64], noise_mm: f64, z: &[f64]) -> Vec<f64> {
        assert!(mean.len() == self.len() && z.len() == self.len());
        let mut x = Mat::from_fn(z.len(), 1, |k, _| z[k]);
        self.factor.transpose().solve_upper_triangular_in_place(x.as_mut());
        let scaled = mean.iter().zip(&self.norms).enumerate();
        scaled.map(|(k, (mean, norm))| mean + noise_mm * x[(k, 0)] / norm).collect()
    }

    /// Covariance of the error of a sensor with one axis, for rows with unit noise, to first order:
    /// three of the position in mm, two of the axis along `tangents` in mm at [`LEVER_MM`].
    ///
    /// # Errors
    /// [`ReadingError::RankLoss`] and [`ReadingError::NotFinite`].
    ///
    /// # Panics
    /// If the covariance is of another model's coefficients.
    pub fn axis_error_covariance(
        &self,
        model: &HarmonicModel,
        position: &Point3<f64>,
        axis: &Unit<Vector3<f64>>,
    ) -> Result<AxisErrorCovariance, ReadingError> {
        assert_eq!(model.coefficients.len(), self.len(), "of this model");
        let mut normal = Matrix5::zeros();
        let mut rows = Vec::with_capacity(model.generator.coils.len());
        for_rows::<1, 2, 5, _>(&model.generator, position, axis, |_, _, _, row| {
            let row = Vector5::from(*row);
            normal += row * row.transpose();
            rows.push(row);
        });
        if !normal.iter().all(|v| v.is_finite()) {
            return Err(ReadingError::NotFinite);
        }
        let cholesky =
            normal.cholesky().ok_or(ReadingError::RankLoss { column: 4, unknowns: 5 })?;
        let mut at = [Vector3::zeros(); MAX_TERMS];
        let x = (position - model.center_mm) / model.scale_mm;
        gradients(model.degree, &x, &mut at);
        let each = terms(model.degree);
        let maps: Vec<_> = rows.iter().map(|row| cholesky.solve(row)).collect();
        let mut x = Mat::from_fn(self.len(), 5, |k, d| {
            maps[k / each][d] * axis.dot(&at[k % each]) / self.norms[k]
        });
        self.factor.solve_lower_triangular_in_place(x.as_mut());
        let product = x.transpose() * &x;
        Ok(AxisErrorCovariance {
            matrix_mm2: SMatrix::from_fn(|i, j| product[(i, j)]),
            tangents: axis.rotation_axes(),
        })
    }
}

/// Covariance of the error of a sensor with one axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AxisErrorCovariance {
    /// Position, then rotations about `tangents` times the lever.
    pub matrix_mm2: Matrix5<f64>,
    pub tangents: [Vector3<f64>; 2],
}

impl AxisErrorCovariance {
    /// Covariance of the rotation vector in rad².
    pub fn rotation_rad2(&self) -> nalgebra::Matrix3<f64> {
        let [a, b] = self.tangents;
        let tangents = nalgebra::Matrix3x2::from_columns(&[a, b]) / LEVER_MM;
        tangents * self.matrix_mm2.fixed_view::<2, 2>(3, 3) * tangents.transpose()
    }
}

#[cfg(test)]
mod tests {
    use super::super::fit::tests::room_a;
    use super::super::fit::{HarmonicFitSettings, fit};
    use super::*;
    use crate::generator::Generator;
    use trackwright_task::Task;

    #[test]
    fn the_covariance_is_that_of_draws() {
        let mut set = room_a("fit");
        set.measurements.truncate(200);
        let settings = HarmonicFitSettings::new(2);
        let generator = Generator::planar_nine();
        let fitted = fit(&Task::default(), &generator, &set, &settings).unwrap();
        let (model, covariance) = (&fitted.model, &fitted.covariance);
        let position = Point3::new(40.0, -60.0, -240.0);
        let axis = Unit::new_normalize(Vector3::new(0.2, 0.5, -0.6));
        let stated = covariance.axis_error_covariance(model, &position, &axis).unwrap();
        // Columns of the factor one by one are draws whose squares sum up to the covariance. The
        // noise is small enough for the error to be linear and large enough for its digits.
        let noise_mm = 1e-3;
        let center = model.axis_error_at(&position, &axis).unwrap();
        let (mut sum, mut turns) = (nalgebra::Matrix3::zeros(), nalgebra::Matrix3::zeros());
        for k in 0..covariance.len() {
            let mut z = vec![0.0; covariance.len()];
            z[k] = 1.0;
            let drawn = covariance.draw(model.coefficients(), noise_mm, &z);
            let drawn = model.with_coefficients(drawn).unwrap();
            let error = drawn.linear_axis_error_at(&position, &axis).unwrap();
            let linear = model.linear_axis_error_at(&position, &axis).unwrap();
            let moved = (error.position_mm - linear.position_mm) / noise_mm;
            sum += moved * moved.transpose();
            let turned = (error.rotation_rad - linear.rotation_rad) / noise_mm;
            turns += turned * turned.transpose();
        }
        assert!(center.position_mm.norm() > 0.0);
        let positions = stated.matrix_mm2.fixed_view::<3, 3>(0, 0);
        assert!((sum - positions).norm() < 1e-6 * sum.norm());
        assert!((turns - stated.rotation_rad2()).norm() < 1e-6 * turns.norm());
    }
}
