//! Real spherical harmonics of even degrees, orthonormal: functions of a coil's axis that are the same
//! when the coil is turned round.

use crate::harmonic::solid_harmonics::{self, MAX_TERMS, gradients};
use nalgebra::Vector3;
use std::f64::consts::PI;

/// Highest degree.
pub const MAX_DEGREE: usize = 8;

/// Functions of the highest degree.
pub const MAX_FUNCTIONS: usize = functions(MAX_DEGREE);

/// Functions of the even degrees up to one.
pub const fn functions(degree: usize) -> usize {
    (degree + 1) * (degree + 2) / 2
}

/// Factors that make the harmonics of `solid_harmonics` orthonormal, in their order.
const NORMS: [f64; MAX_TERMS] = {
    let mut norms = [0.0; MAX_TERMS];
    let mut at = 0;
    let mut l = 1;
    while l <= solid_harmonics::MAX_DEGREE {
        let mut m = 0;
        while m <= l {
            // (2l + 1) / 4π · (l − m)! / (l + m)! · 2 · ((2m − 1)!!)², without the 2 for m = 0.
            let mut squared = (2 * l + 1) as f64 / (4.0 * PI);
            let mut k = l - m + 1;
            while k <= l + m {
                squared /= k as f64;
                k += 1;
            }
            let mut odd = 1;
            while odd < 2 * m {
                squared *= (odd * odd) as f64;
                odd += 2;
            }
            if m > 0 {
                squared *= 2.0;
            }
            let mut root = 1.0;
            let mut step = 0;
            while step < 60 {
                root = 0.5 * (root + squared / root);
                step += 1;
            }
            norms[at] = root;
            at += 1;
            if m > 0 {
                norms[at] = root;
                at += 1;
            }
            m += 1;
        }
        l += 1;
    }
    norms
};

/// Order in the axis of the highest degree, and one more.
const ORDERS: usize = MAX_DEGREE + 1;

/// Values for a unit axis, degree after degree, into the first [`functions`] of `out`: for each degree
/// `m = 0; m = 1 cos, sin; …`, by the recurrences of `solid_harmonics` on the unit sphere.
///
/// # Panics
/// If the degree is above [`MAX_DEGREE`] or the slice is too short.
#[inline(always)]
pub fn values(degree: usize, axis: &Vector3<f64>, out: &mut [f64]) {
    assert!(degree <= MAX_DEGREE, "degree {degree}");
    let out = &mut out[..functions(degree)];
    out[0] = 0.5 / PI.sqrt();
    // P_l^m and P_{l-1}^m of each m; (x + i y)^m.
    let (mut now, mut before) = ([0.0; ORDERS], [0.0; ORDERS]);
    let mut powers = [(1.0, 0.0); ORDERS];
    now[0] = 1.0;
    let mut at = 1;
    for l in 1..=degree {
        for m in 0..l {
            let next = STEP_UP[l][m] * axis.z * now[m] - STEP_BACK[l][m] * before[m];
            before[m] = now[m];
            now[m] = next;
        }
        now[l] = 1.0;
        let (re, im) = powers[l - 1];
        powers[l] = (axis.x * re - axis.y * im, axis.x * im + axis.y * re);
        if l % 2 == 0 {
            let norms = &NORMS[solid_harmonics::terms(l - 1)..];
            out[at] = norms[0] * now[0];
            at += 1;
            for m in 1..=l {
                let p = norms[2 * m - 1] * now[m];
                out[at] = p * powers[m].0;
                out[at + 1] = p * powers[m].1;
                at += 2;
            }
        }
    }
}

/// `(2l − 1) / (l − m)` and `(l + m − 1) / (l − m)`.
const STEP_UP: [[f64; ORDERS]; ORDERS] = steps(true);
const STEP_BACK: [[f64; ORDERS]; ORDERS] = steps(false);

const fn steps(is_up: bool) -> [[f64; ORDERS]; ORDERS] {
    let mut table = [[0.0; ORDERS]; ORDERS];
    let mut l = 1;
    while l < ORDERS {
        let mut m = 0;
        while m < l {
            let above = if is_up { 2 * l - 1 } else { l + m - 1 };
            table[l][m] = above as f64 / (l - m) as f64;
            m += 1;
        }
        l += 1;
    }
    table
}

/// Derivatives along the sphere for a unit axis, in the order of [`values`].
///
/// # Panics
/// As [`values`].
pub fn slopes(degree: usize, axis: &Vector3<f64>, out: &mut [Vector3<f64>]) {
    assert!(degree <= MAX_DEGREE, "degree {degree}");
    let out = &mut out[..functions(degree)];
    let mut solid = [Vector3::zeros(); MAX_TERMS];
    gradients(degree, axis, &mut solid);
    out[0] = Vector3::zeros();
    let mut at = 1;
    for l in (2..=degree).step_by(2) {
        let first = solid_harmonics::terms(l - 1);
        for k in first..first + 2 * l + 1 {
            out[at] = (solid[k] - axis * axis.dot(&solid[k])) * NORMS[k];
            at += 1;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn axis(i: usize) -> Vector3<f64> {
        let t = i as f64;
        Vector3::new((1.3 * t).sin(), (0.7 * t).cos(), (2.1 * t + 0.4).sin()).normalize()
    }

    fn at(n: &Vector3<f64>) -> [f64; MAX_FUNCTIONS] {
        let mut found = [0.0; MAX_FUNCTIONS];
        values(MAX_DEGREE, n, &mut found);
        found
    }

    fn slopes_at(n: &Vector3<f64>) -> [Vector3<f64>; MAX_FUNCTIONS] {
        let mut found = [Vector3::zeros(); MAX_FUNCTIONS];
        slopes(MAX_DEGREE, n, &mut found);
        found
    }

    /// Unsöld's theorem: the sums of squares of a degree are (2l + 1) / 4π and, of the slopes along
    /// any tangent, l (l + 1) (2l + 1) / 8π. No wrong normalisation has both at every axis.
    #[test]
    fn a_degrees_squares_have_unsoelds_sums() {
        for i in 0..50 {
            let n = axis(i);
            let (values, slopes) = (at(&n), slopes_at(&n));
            let tangent = n.cross(&axis(i + 7)).normalize();
            let mut first = 0;
            for l in (0..=MAX_DEGREE).step_by(2) {
                let count = (2 * l + 1) as f64;
                let of = first..first + 2 * l + 1;
                let sum: f64 = values[of.clone()].iter().map(|v| v * v).sum();
                let along: f64 = slopes[of].iter().map(|s| s.dot(&tangent).powi(2)).sum();
                assert!((sum - count / (4.0 * PI)).abs() < 1e-12, "{l}: {sum}");
                let expected = (l * (l + 1)) as f64 * count / (8.0 * PI);
                assert!((along - expected).abs() < 1e-10 * (1.0 + expected), "{l}: {along}");
                first += 2 * l + 1;
            }
        }
    }

    #[test]
    fn slopes_are_differences_and_values_are_even() {
        let n = axis(3);
        let tangent = n.cross(&axis(5)).normalize();
        let (here, slopes) = (at(&n), slopes_at(&n));
        let h: f64 = 1e-5;
        let (ahead, behind) =
            (at(&(n * h.cos() + tangent * h.sin())), at(&(n * h.cos() - tangent * h.sin())));
        let opposite = at(&-n);
        for k in 0..MAX_FUNCTIONS {
            let difference = (ahead[k] - behind[k]) / (2.0 * h);
            assert!((difference - slopes[k].dot(&tangent)).abs() < 1e-7);
            assert!((opposite[k] - here[k]).abs() < 1e-13);
        }
    }
}
