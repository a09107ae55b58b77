//! Anderson's mixing: a linear fixed-point iteration that converges as GMRES does.
//!
//! Of the last steps that combination is taken whose residuals `g(x) − x` cancel best (Anderson, J. ACM
//! 12(4), 1965; Walker and Ni, SIAM J. Numerical Analysis 49(4), 2011: equivalent to GMRES for linear `g`).

use nalgebra::{DMatrix, DVector};

/// Steps that are remembered.
const WINDOW: usize = 16;

/// Part of a residual's square that counts as round-off in the normal equations. Any combination is a
/// valid next iterate, so that an inexact one costs rounds, not correctness.
const ROUND_OFF: f64 = 1e-12;

/// The memory of one iteration.
#[derive(Debug, Default)]
pub struct Mixing {
    /// `g` and residual of the iterate before.
    last: Option<[DVector<f64>; 2]>,
    /// Their changes, the latest last.
    changes: Vec<[DVector<f64>; 2]>,
}

impl Mixing {
    /// The iterate after `x`, from its image `g`.
    pub fn next(&mut self, x: &DVector<f64>, g: &DVector<f64>) -> DVector<f64> {
        let residual = g - x;
        if let Some([last_g, last_residual]) = &self.last {
            if self.changes.len() == WINDOW {
                self.changes.remove(0);
            }
            self.changes.push([g - last_g, &residual - last_residual]);
        }
        self.last = Some([g.clone(), residual.clone()]);
        let norms: Vec<f64> = self.changes.iter().map(|[_, change]| change.norm()).collect();
        let used: Vec<usize> = (0..norms.len()).filter(|&k| norms[k] > 0.0).collect();
        let unit = |k: usize| &self.changes[used[k]][1] / norms[used[k]];
        let units: Vec<DVector<f64>> = (0..used.len()).map(unit).collect();
        let mut gram = DMatrix::from_fn(units.len(), units.len(), |i, j| units[i].dot(&units[j]));
        for k in 0..units.len() {
            gram[(k, k)] += ROUND_OFF;
        }
        let right = DVector::from_fn(units.len(), |k, _| units[k].dot(&residual));
        let mut next = g.clone();
        if let Some(factor) = gram.cholesky() {
            let weights = factor.solve(&right);
            for (k, weight) in weights.iter().enumerate() {
                next.axpy(-weight / norms[used[k]], &self.changes[used[k]][0], 1.0);
            }
        }
        next
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slow_iterations_converge_in_few_rounds() {
        // A contraction by 0.999 at worst, which by itself takes 20,000 rounds to 1e-9.
        let slopes = [0.999, 0.99, -0.9, 0.8, 0.5, -0.3, 0.999_9, 0.1];
        let image = |x: &DVector<f64>| DVector::from_fn(8, |k, _| slopes[k] * x[k] + 1.0);
        let mut mixing = Mixing::default();
        let mut x = DVector::zeros(8);
        let mut rounds = 0;
        while (image(&x) - &x).norm() > 1e-9 * x.norm() {
            x = mixing.next(&x, &image(&x));
            rounds += 1;
            assert!(rounds < 20, "{}", (image(&x) - &x).norm());
        }
        for (k, slope) in slopes.iter().enumerate() {
            assert!((x[k] * (1.0 - slope) - 1.0).abs() < 1e-4, "{k} {}", x[k]);
        }
    }

    #[test]
    fn a_fixed_point_stays() {
        let x = DVector::from_element(3, 2.0);
        let mut mixing = Mixing::default();
        for _ in 0..3 {
            assert_eq!(mixing.next(&x, &x), x);
        }
    }
}
