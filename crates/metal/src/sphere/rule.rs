//! Points on the unit sphere whose weighted sum integrates spherical harmonics exactly.

use nalgebra::{Unit, Vector3};
use std::f64::consts::{PI, TAU};

/// Steps in which Newton's method reaches round-off from the start that is used.
const NEWTON_STEPS: usize = 6;

/// Directions and weights that integrate over the unit sphere; the weights add up to 4π. Exact for
/// harmonics up to `degree`: Gauss's points along z, even steps around it.
pub fn spherical_rule(degree: usize) -> Vec<(Unit<Vector3<f64>>, f64)> {
    let around = degree + 1;
    let step = TAU / around as f64;
    let mut rule = Vec::with_capacity(around * (degree / 2 + 1));
    for (z, weight) in gauss_legendre(degree / 2 + 1) {
        let across = ((1.0 - z) * (1.0 + z)).sqrt();
        for k in 0..around {
            let (sine, cosine) = ((k as f64 + 0.5) * step).sin_cos();
            let direction = Vector3::new(across * cosine, across * sine, z);
            rule.push((Unit::new_normalize(direction), weight * step));
        }
    }
    rule
}

/// Nodes in −1 to 1 and weights of Gauss's rule, by Newton's method on the Legendre polynomial.
fn gauss_legendre(count: usize) -> Vec<(f64, f64)> {
    let n = count as f64;
    (0..count)
        .map(|k| {
            let mut x = (PI * (k as f64 + 0.75) / (n + 0.5)).cos();
            let mut slope = 1.0;
            for _ in 0..NEWTON_STEPS {
                let (mut before, mut p) = (0.0, 1.0);
                for j in 0..count {
                    let j = j as f64;
                    (before, p) = (p, ((2.0 * j + 1.0) * x * p - j * before) / (j + 1.0));
                }
                slope = n * (x * p - before) / (x * x - 1.0);
                x -= p / slope;
            }
            (x, 2.0 / ((1.0 - x * x) * slope * slope))
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn polynomials_are_integrated_exactly() {
        for degree in [1, 6, 13, 40] {
            let rule = spherical_rule(degree);
            let whole: f64 = rule.iter().map(|(_, weight)| weight).sum();
            assert!((whole - 4.0 * PI).abs() < 1e-12);
            // ∫ (n·u)^k is 4π / (k + 1) for even k.
            let u = Vector3::new(0.48, -0.6, 0.64);
            for power in (0..=degree).step_by(2) {
                let found: f64 = rule.iter().map(|(n, w)| w * n.dot(&u).powi(power as i32)).sum();
                let expected = 4.0 * PI / (power + 1) as f64;
                assert!((found - expected).abs() < 1e-12, "{degree} {power}");
            }
        }
    }
}
