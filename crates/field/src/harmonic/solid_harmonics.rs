//! Gradients of the real solid harmonics, which every disturbance without sources is a sum of.
//!
//! `Y_{l,m,cos} = P_l^m A_m`, `Y_{l,m,sin} = P_l^m B_m`, `A_m + i B_m = (x + i y)^m`, `P_m^m = 1`,
//! `(l − m) P_l^m = (2l − 1) z P_{l−1}^m − (l + m − 1) r² P_{l−2}^m`: without normalisation, for
//! each `l` in the order `m = 0; m = 1 cos, sin; m = 2 cos, sin; …`.
//!
//! With `F_l^m = P_l^m (x + i y)^m` the derivatives are harmonics of one degree less (Hobson, The
//! Theory of Spherical and Ellipsoidal Harmonics, 1931, in this normalisation):
//! `∂z F_l^m = (l + m) F_{l−1}^m`, `(∂x + i ∂y) F_l^m = −(2m + 1) F_{l−1}^{m+1}`,
//! `(∂x − i ∂y) F_l^m = (l + m)(l + m − 1) / (2m − 1) F_{l−1}^{m−1}`.

use nalgebra::{SimdRealField, Vector3};

/// Highest degree. Gradients of a point are kept on the stack.
pub const MAX_DEGREE: usize = 10;

/// Gradients of the highest degree.
pub const MAX_TERMS: usize = terms(MAX_DEGREE);

const SIZE: usize = MAX_DEGREE + 2;

/// `(l + m)(l + m − 1) / (2m − 1) / 2`.
const LOWERED: [[f64; SIZE]; SIZE] = {
    let mut table = [[0.0; SIZE]; SIZE];
    let mut l = 1;
    while l < SIZE {
        let mut m = 1;
        while m <= l {
            table[l][m] = ((l + m) * (l + m - 1)) as f64 / (2 * (2 * m - 1)) as f64;
            m += 1;
        }
        l += 1;
    }
    table
};

/// Numbers a coil: `(degree + 1)² − 1`.
pub const fn terms(degree: usize) -> usize {
    (degree + 1) * (degree + 1) - 1
}

/// Gradients at `x` of all harmonics of degrees 1 to `degree`, into the first [`terms`] of `out`; of one
/// point, or of one in each lane.
///
/// # Panics
/// If the degree is above [`MAX_DEGREE`] or `out` is too short.
#[inline(always)]
pub fn gradients<T>(degree: usize, x: &Vector3<T>, out: &mut [Vector3<T>])
where
    T: SimdRealField<Element = f64> + Copy,
{
    assert!(degree <= MAX_DEGREE, "degree {degree}");
    let out = &mut out[..terms(degree)];
    let number = |value: f64| T::splat(value);
    // F of one degree less; above m = l they are zero.
    let mut before = [(number(0.0), number(0.0)); SIZE];
    let mut two_before = before;
    before[0].0 = number(1.0);
    let r2 = x.dot(x);
    let mut at = 0;
    for l in 1..=degree {
        let lf = l as f64;
        out[at] = Vector3::new(-before[1].0, -before[1].1, number(lf) * before[0].0);
        at += 1;
        for m in 1..=l {
            let mf = m as f64;
            let (raised, q) = (number(-0.5 * (2.0 * mf + 1.0)), number(LOWERED[l][m]));
            let along = number(lf + mf);
            let (up, same, down) = (before[m + 1], before[m], before[m - 1]);
            out[at] = Vector3::new(
                raised * up.0 + q * down.0,
                raised * up.1 - q * down.1,
                along * same.0,
            );
            out[at + 1] = Vector3::new(
                raised * up.1 + q * down.1,
                q * down.0 - raised * up.0,
                along * same.1,
            );
            at += 2;
        }
        if l == degree {
            break;
        }
        // The values of this degree, in place of those of two degrees less.
        for m in 0..l {
            let mf = m as f64;
            let inverse = 1.0 / (lf - mf);
            let a = number((2.0 * lf - 1.0) * inverse) * x.z;
            let b = number((lf + mf - 1.0) * inverse) * r2;
            let (one, two) = (before[m], two_before[m]);
            two_before[m] = (a * one.0 - b * two.0, a * one.1 - b * two.1);
        }
        let (re, im) = before[l - 1];
        two_before[l] = (x.x * re - x.y * im, x.x * im + x.y * re);
        std::mem::swap(&mut before, &mut two_before);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::generator::tests::{physics, vector};

    /// By the contract's own recurrence.
    fn values(degree: usize, x: &Vector3<f64>) -> Vec<f64> {
        let mut powers = vec![(1.0, 0.0)];
        for m in 0..degree {
            let (re, im) = powers[m];
            powers.push((x.x * re - x.y * im, x.x * im + x.y * re));
        }
        let legendre = |l: usize, m: usize| {
            let (mut before, mut p) = (0.0, 1.0);
            for l in m + 1..=l {
                let [lf, mf] = [l as f64, m as f64];
                let next = ((2.0 * lf - 1.0) * x.z * p
                    - (lf + mf - 1.0) * x.norm_squared() * before)
                    / (lf - mf);
                (before, p) = (p, next);
            }
            p
        };
        let mut all = Vec::new();
        for l in 1..=degree {
            all.push(legendre(l, 0));
            for (m, (re, im)) in powers.iter().enumerate().take(l + 1).skip(1) {
                all.extend([legendre(l, m) * re, legendre(l, m) * im]);
            }
        }
        all
    }

    fn points() -> [Vector3<f64>; 4] {
        [
            Vector3::zeros(),
            Vector3::new(0.3, -0.5, 0.7),
            Vector3::new(-0.9, 0.1, -0.2),
            Vector3::new(0.0, 0.0, -1.0),
        ]
    }

    #[test]
    fn gradients_are_the_worked_ones() {
        let golden = physics();
        let degree = golden["degree"].as_u64().unwrap() as usize;
        for case in golden["solid_harmonic_gradients"].as_array().unwrap() {
            let mut found = [Vector3::zeros(); MAX_TERMS];
            gradients(degree, &vector(&case["at"]), &mut found);
            let worked = case["gradients"].as_array().unwrap();
            assert_eq!(worked.len(), terms(degree));
            for (found, worked) in found.iter().zip(worked) {
                let worked = vector(worked);
                assert!((found - worked).norm() <= 1e-13 * worked.norm().max(1.0));
            }
        }
    }

    #[test]
    fn gradients_are_the_differences_of_values() {
        let h = 1e-5;
        for x in points() {
            let mut found = [Vector3::zeros(); MAX_TERMS];
            gradients(MAX_DEGREE, &x, &mut found);
            for j in 0..3 {
                let mut step = Vector3::zeros();
                step[j] = h;
                let (plus, minus) =
                    (values(MAX_DEGREE, &(x + step)), values(MAX_DEGREE, &(x - step)));
                for (found, (plus, minus)) in found.iter().zip(plus.iter().zip(&minus)) {
                    let slope = (plus - minus) / (2.0 * h);
                    // Third derivatives of degree 10 are up to 1e4 here, times h² / 6.
                    assert!((slope - found[j]).abs() < 1e-6 * found.norm().max(1.0));
                }
            }
        }
    }

    #[test]
    fn every_gradient_is_free_of_sources_and_curl() {
        let h = 1e-4;
        let at = |x: Vector3<f64>| {
            let mut out = [Vector3::zeros(); MAX_TERMS];
            gradients(6, &x, &mut out);
            out
        };
        for x in points() {
            let slopes = [Vector3::x(), Vector3::y(), Vector3::z()].map(|step| {
                let (plus, minus) = (at(x + step * h), at(x - step * h));
                move |k: usize| (plus[k] - minus[k]) / (2.0 * h)
            });
            for k in 0..terms(6) {
                let [dx, dy, dz] = [slopes[0](k), slopes[1](k), slopes[2](k)];
                let size = dx.norm() + dy.norm() + dz.norm() + 1.0;
                // Fourth derivatives of degree 6 are up to 2e3 here, times h² / 6.
                assert!((dx.x + dy.y + dz.z).abs() < 1e-5 * size);
                let curl = Vector3::new(dy.z - dz.y, dz.x - dx.z, dx.y - dy.x);
                assert!(curl.norm() < 1e-5 * size);
            }
        }
    }

    #[test]
    fn lower_degrees_come_first() {
        let x = Vector3::new(0.2, 0.4, -0.6);
        let [mut low, mut high] = [[Vector3::zeros(); MAX_TERMS]; 2];
        gradients(3, &x, &mut low);
        gradients(8, &x, &mut high);
        assert_eq!(low[..terms(3)], high[..terms(3)]);
    }
}
