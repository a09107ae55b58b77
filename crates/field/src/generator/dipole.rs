//! A magnetic dipole: its field and the derivatives of what a coil measures of it.

use nalgebra::{Matrix3, Point3, Vector3};

/// A dipole with a moment, in the tracker frame.
///
/// What a coil of axis `n` measures is `f(r) = n·B = 3 (n·r)(m·r) / r⁵ − n·m / r³`, `r = p − at`,
/// which is symmetric in `n` and `m`. The derivatives below are those of `f`.
#[derive(Clone, Copy, Debug)]
pub struct Dipole {
    at_mm: Point3<f64>,
    moment: Vector3<f64>,
}

impl Dipole {
    /// A dipole at a position in mm with a moment.
    #[inline]
    pub fn new(at_mm: &Point3<f64>, moment: &Vector3<f64>) -> Self {
        Self { at_mm: *at_mm, moment: *moment }
    }

    /// The field at a point of the tracker frame.
    #[inline]
    pub fn field(&self, p: &Point3<f64>) -> Vector3<f64> {
        let r = p - self.at_mm;
        let inverse2 = 1.0 / r.norm_squared();
        let inverse3 = inverse2 * inverse2.sqrt();
        (r * (3.0 * self.moment.dot(&r) * inverse2) - self.moment) * inverse3
    }

    /// Field and gradient `∂B_i/∂p_j`.
    #[inline]
    pub fn field_and_gradient(&self, p: &Point3<f64>) -> (Vector3<f64>, Matrix3<f64>) {
        let (m, r) = (self.moment, p - self.at_mm);
        let inverse2 = 1.0 / r.norm_squared();
        let inverse3 = inverse2 * inverse2.sqrt();
        let along = m.dot(&r) * inverse2;
        let field = (r * (3.0 * along) - m) * inverse3;
        let scale = 3.0 * inverse3 * inverse2;
        let diagonal = m.dot(&r) * scale;
        let radial = r * (-5.0 * along * scale);
        let entry = |i: usize, j: usize| (r[i] * m[j] + m[i] * r[j]) * scale + radial[i] * r[j];
        let (xy, xz, yz) = (entry(0, 1), entry(0, 2), entry(1, 2));
        let gradient = Matrix3::new(
            entry(0, 0) + diagonal,
            xy,
            xz,
            xy,
            entry(1, 1) + diagonal,
            yz,
            xz,
            yz,
            entry(2, 2) + diagonal,
        );
        (field, gradient)
    }

    /// Field and the gradient of `n·B` with respect to `p`.
    #[inline]
    pub fn field_and_signal_gradient(
        &self,
        p: &Point3<f64>,
        n: &Vector3<f64>,
    ) -> (Vector3<f64>, Vector3<f64>) {
        let (m, r) = (&self.moment, p - self.at_mm);
        let inverse2 = 1.0 / r.norm_squared();
        let inverse3 = inverse2 * inverse2.sqrt();
        let (along_n, along_m) = (n.dot(&r), m.dot(&r));
        let field = (r * (3.0 * along_m * inverse2) - m) * inverse3;
        let radial = n.dot(m) - 5.0 * along_n * along_m * inverse2;
        let gradient = n * along_m + m * along_n + r * radial;
        (field, gradient * (3.0 * inverse2 * inverse3))
    }

    /// Gradient of `n·B` with respect to `p`.
    #[inline]
    pub fn signal_gradient(&self, p: &Point3<f64>, n: &Vector3<f64>) -> Vector3<f64> {
        self.field_and_signal_gradient(p, n).1
    }

    /// Second derivatives of `n·B` with respect to `p`.
    pub fn signal_hessian(&self, p: &Point3<f64>, n: &Vector3<f64>) -> Matrix3<f64> {
        let (m, r) = (&self.moment, p - self.at_mm);
        let inverse2 = 1.0 / r.norm_squared();
        let scale = 3.0 * inverse2 * inverse2 * inverse2.sqrt();
        let (along_n, along_m, both) = (n.dot(&r), m.dot(&r), n.dot(m));
        let cross = n * along_m + m * along_n;
        let product = along_n * along_m * inverse2;
        let symmetric = |a: &Vector3<f64>, b: &Vector3<f64>| a * b.transpose() + b * a.transpose();
        let radial = (35.0 * product - 5.0 * both) * inverse2;
        (symmetric(n, m) - symmetric(&cross, &r) * (5.0 * inverse2)
            + Matrix3::from_diagonal_element(both - 5.0 * product)
            + r * r.transpose() * radial)
            * scale
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn derivatives_of_the_signal_are_differences() {
        let dipole = Dipole::new(&Point3::new(10.0, -40.0, 5.0), &Vector3::new(0.4, -0.7, 0.5));
        let n = Vector3::new(-0.3, 0.2, 0.9);
        let p = Point3::new(80.0, 30.0, -120.0);
        let h = 1e-2;
        let gradient = dipole.signal_gradient(&p, &n);
        let hessian = dipole.signal_hessian(&p, &n);
        assert!((dipole.field_and_gradient(&p).1 * n - gradient).norm() < 1e-14 * gradient.norm());
        for j in 0..3 {
            let mut step = Vector3::zeros();
            step[j] = h;
            let difference =
                (n.dot(&dipole.field(&(p + step))) - n.dot(&dipole.field(&(p - step)))) / (2.0 * h);
            assert!((difference - gradient[j]).abs() < 1e-6 * gradient.norm());
            let difference = (dipole.signal_gradient(&(p + step), &n)
                - dipole.signal_gradient(&(p - step), &n))
                / (2.0 * h);
            assert!((difference - hessian.column(j)).norm() < 1e-6 * hessian.norm());
        }
    }
}
