//! How large a room's field is from place to place: a log-polynomial of position.

use nalgebra::{DMatrix, DVector, Point3};
use serde::{Deserialize, Serialize};
use trackwright_geometry::bounds::Bounds;
use trackwright_geometry::limits::length_above_zero_problem;

/// Terms of a polynomial of degree 2 in three variables.
pub const TERMS: usize = 10;

/// Weight of the prior on each coefficient, in rows: it keeps a polynomial of few rows flat. A third
/// of a row is too little in rooms of 20, thirty flatten rooms of 600 (found in rooms of an
/// independent tracker).
const PRIOR: f64 = 3.0;

/// Squared residuals count as no more than this many times their expectation: one outlier must not
/// bend the polynomial.
const MOST_RATIO: f64 = 25.0;

/// Outside the box the polynomial keeps its value at this many half edges from the middle.
const FARTHEST: f64 = 1.0;

/// `s(p)`: the root of the variance over that of unit amplitude.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Amplitude {
    pub center_mm: [f64; 3],
    /// Half the edges of the measurements' box.
    pub half_mm: [f64; 3],
    /// Coefficients of the logarithm of the variance.
    pub log_variance: [f64; TERMS],
}

impl Amplitude {
    /// The same everywhere.
    pub fn flat(bounds: &Bounds) -> Self {
        Self {
            center_mm: bounds.center_mm().coords.into(),
            // A table in one plane has a box without thickness.
            half_mm: bounds.size_mm().map(|edge| (0.5 * edge).max(1.0)).into(),
            log_variance: [0.0; TERMS],
        }
    }

    /// `s(p)`.
    pub fn at(&self, position_mm: &Point3<f64>) -> f64 {
        let terms = self.terms(position_mm);
        let log: f64 = terms.iter().zip(&self.log_variance).map(|(term, c)| term * c).sum();
        (0.5 * log).exp()
    }

    /// Legendre products of degree 2.
    fn terms(&self, position_mm: &Point3<f64>) -> [f64; TERMS] {
        let [x, y, z] = [0, 1, 2].map(|k| {
            let u = (position_mm[k] - self.center_mm[k]) / self.half_mm[k];
            u.clamp(-FARTHEST, FARTHEST)
        });
        let second = |u: f64| 1.5 * u * u - 0.5;
        [1.0, x, y, z, second(x), second(y), second(z), x * y, y * z, z * x]
    }

    /// The amplitude after a regression of squared residuals, each over what this amplitude expects,
    /// with the constant left where it is: the kernel's business. Gamma likelihood of `dof` degrees
    /// of freedom a row, logarithmic link, Fisher scoring.
    pub(super) fn updated(&self, ratios: &[(Point3<f64>, f64)], dof: f64) -> Self {
        let terms: Vec<_> = ratios.iter().map(|(p, _)| self.terms(p)).collect();
        let mean =
            ratios.iter().map(|(_, r)| r.min(MOST_RATIO)).sum::<f64>() / ratios.len().max(1) as f64;
        let mut change = [0.0; TERMS];
        change[0] = mean.max(f64::MIN_POSITIVE).ln();
        for _ in 0..30 {
            let mut gradient = DVector::<f64>::zeros(TERMS);
            let mut information = DMatrix::<f64>::zeros(TERMS, TERMS);
            for (terms, (_, ratio)) in terms.iter().zip(ratios) {
                let log: f64 = terms.iter().zip(&change).map(|(t, c)| t * c).sum();
                let excess = (ratio * (-log).exp()).min(MOST_RATIO) - 1.0;
                for a in 0..TERMS {
                    gradient[a] += 0.5 * dof * terms[a] * excess;
                    for b in 0..TERMS {
                        information[(a, b)] += 0.5 * dof * terms[a] * terms[b];
                    }
                }
            }
            for a in 1..TERMS {
                gradient[a] -= PRIOR * (change[a] + self.log_variance[a]);
                information[(a, a)] += PRIOR;
            }
            information[(0, 0)] += f64::EPSILON;
            let Some(factor) = information.cholesky() else {
                break;
            };
            let step = factor.solve(&gradient);
            let length = step.norm();
            let part = if length > 1.0 { 1.0 / length } else { 1.0 };
            for a in 0..TERMS {
                change[a] += part * step[a];
            }
            if length < 1e-4 {
                break;
            }
        }
        let mut log_variance = self.log_variance;
        for (sum, by) in log_variance.iter_mut().zip(change).skip(1) {
            *sum += by;
        }
        Self { log_variance, ..*self }
    }

    /// The first number that cannot be.
    pub fn problem(&self) -> Option<(&'static str, f64)> {
        let half = self.half_mm.iter();
        let half = half.copied().find(|h| length_above_zero_problem(*h).is_some());
        half.map(|h| ("amplitude.half_mm", h)).or_else(|| {
            let beyond = |values: &[f64], most: f64| {
                values.iter().copied().find(|v| v.is_nan() || v.abs() > most)
            };
            let center = beyond(&self.center_mm, 1e6).map(|v| ("amplitude.center_mm", v));
            // Of an exponent: fields that differ by more than e¹⁵ from place to place are none.
            center
                .or_else(|| beyond(&self.log_variance, 30.0).map(|v| ("amplitude.log_variance", v)))
        })
    }
}
