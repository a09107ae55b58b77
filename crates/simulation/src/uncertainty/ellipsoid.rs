//! The ellipsoid that holds 95 % of a normal scatter.

use nalgebra::{Matrix3, Point3, Vector3};
use trackwright_geometry::svd3::svd3;

/// 95 % quantile of chi-squared with three degrees of freedom.
pub const CHI_SQUARED_95_OF_3: f64 = 7.814_727_903_251_179;

/// An ellipsoid, in CRF coordinates, mm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ellipsoid {
    pub center_in_crf: Point3<f64>,
    /// Semi-axes, longest first, perpendicular to each other, a right-handed set.
    pub semi_axes_in_crf_mm: [Vector3<f64>; 3],
}

impl Ellipsoid {
    /// Holds 95 % of a normal scatter with this covariance.
    pub fn of_95_percent(center_in_crf: Point3<f64>, covariance_mm2: &Matrix3<f64>) -> Self {
        // Of a covariance, the left singular vectors are the eigenvectors.
        let svd = svd3(covariance_mm2);
        let (a, b) = (svd.u.column(0).into_owned(), svd.u.column(1).into_owned());
        let length = |k: usize| (CHI_SQUARED_95_OF_3 * svd.singular_values[k]).sqrt();
        Self {
            center_in_crf,
            semi_axes_in_crf_mm: [a * length(0), b * length(1), a.cross(&b) * length(2)],
        }
    }

    /// Lengths of the semi-axes, longest first.
    pub fn lengths_mm(&self) -> [f64; 3] {
        self.semi_axes_in_crf_mm.map(|a| a.norm())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Rotation3;

    #[test]
    fn the_chi_squared_quantile_integrates_to_0_95() {
        // Of three degrees of freedom: erf(√(x/2)) − √(2x/π) e^(−x/2), integrated here from its
        // density √(x/2π) e^(−x/2) by Simpson's rule in √x, in which it is smooth.
        let end = CHI_SQUARED_95_OF_3.sqrt();
        let steps = 2000;
        let density = |y: f64| (2.0 / std::f64::consts::PI).sqrt() * y * y * (-0.5 * y * y).exp();
        let h = end / f64::from(steps);
        let sum: f64 = (0..=steps)
            .map(|i| {
                let weight = match i {
                    0 => 1.0,
                    i if i == steps => 1.0,
                    i if i % 2 == 1 => 4.0,
                    _ => 2.0,
                };
                weight * density(h * f64::from(i))
            })
            .sum();
        assert!((sum * h / 3.0 - 0.95).abs() < 1e-11);
    }

    #[test]
    fn semi_axes_are_scaled_eigenvectors_of_covariance() {
        let turn = Rotation3::from_euler_angles(0.3, -1.0, 2.0).into_inner();
        let variances = Vector3::new(4.0, 0.25, 1.0);
        let covariance = turn * Matrix3::from_diagonal(&variances) * turn.transpose();
        let e = Ellipsoid::of_95_percent(Point3::origin(), &covariance);
        let k = CHI_SQUARED_95_OF_3.sqrt();
        for (found, expected) in e.lengths_mm().into_iter().zip([2.0 * k, k, 0.5 * k]) {
            assert!((found - expected).abs() < 1e-13 * k, "{found} {expected}");
        }
        assert!(e.semi_axes_in_crf_mm[0].cross(&turn.column(0)).norm() < 1e-13 * k);
        assert!(Matrix3::from_columns(&e.semi_axes_in_crf_mm).determinant() > 0.0);
        let back: Matrix3<f64> =
            e.semi_axes_in_crf_mm.iter().map(|a| a * a.transpose() / CHI_SQUARED_95_OF_3).sum();
        assert!((back - covariance).norm() < 1e-13);
    }

    #[test]
    fn no_scatter_is_a_point() {
        let e = Ellipsoid::of_95_percent(Point3::new(1.0, 2.0, 3.0), &Matrix3::zeros());
        assert_eq!(e.lengths_mm(), [0.0; 3]);
    }
}
