//! What a least-squares solution is compared with: the same system solved in [`High`] numbers.

use super::case::{Quantity, Row};
use crate::high::High;
use crate::high_linear::{
    HighMatrix, least_squares, norm, reduce, svd, to_f64, truncated_least_squares,
};
use crate::references;

/// Perturbation theory of least squares: an error of the matrix by epsilon moves the solution by
/// condition times epsilon of itself, and by the squared condition of what it cannot reach
/// (Björck, Numerical Methods for Least Squares Problems, 1996, section 1.4).
pub const SOLUTION: Quantity = Quantity::new(
    "solution, mm or rad",
    10.0,
    "largest singular value over the smallest kept, ridge included",
    "length of the solution, plus condition · length of the residual over the largest \
        singular value",
);

/// A system solved in high precision.
pub struct Reference {
    pub x: HighMatrix,
    pub rank: usize,
    pub unknowns: usize,
    pub condition: f64,
    /// What each value's error is relative to.
    pub scales: Vec<f64>,
    /// Largest singular value cut off over the smallest kept, where any is cut off.
    pub gap: Option<f64>,
    /// Triangle of the design matrix, or the matrix itself where that is wide.
    reduced: HighMatrix,
    is_plain: bool,
}

impl Reference {
    /// Least norm with a cutoff and a ridge, as `Decomposition::solve` has them.
    pub fn of(a: HighMatrix, b: HighMatrix, rcond: f64, ridge: f64) -> Self {
        let unknowns = a.ncols();
        let is_tall = a.nrows() >= unknowns;
        let reduced = if is_tall {
            reduce(a.clone(), HighMatrix::zeros(a.nrows(), 0)).r
        } else {
            a.transpose()
        };
        let singular = singular_values(&reduced);
        let largest = singular.first().copied().unwrap_or(0.0);
        // Singular values in f64 are good to epsilon of the largest: far from the cutoff that
        // decides which are kept, and close to it the exact ones are used.
        let is_full = is_tall && singular.last().is_some_and(|&s| s > 10.0 * rcond * largest);
        let damping = ridge * largest;
        let (x, rank, gap, smallest) = if is_full && ridge == 0.0 {
            let x = least_squares(&a, &b);
            (x, unknowns, None, singular.last().copied().unwrap_or(0.0))
        } else if ridge > 0.0 {
            let below = HighMatrix::from_diagonal_element(unknowns, unknowns, damping.into());
            let zeros = HighMatrix::zeros(unknowns, b.ncols());
            let x = least_squares(&stacked(&a, &below), &stacked(&b, &zeros));
            let kept = singular.iter().filter(|&&s| s > 10.0 * rcond * largest).count();
            (x, kept, None, singular.last().copied().unwrap_or(0.0).hypot(damping))
        } else {
            let t = truncated_least_squares(&a, &b, rcond);
            let kept = t.rank.checked_sub(1).and_then(|i| t.singular_values.get(i));
            let smallest = kept.map_or(0.0, High::to_f64);
            let cut = t.singular_values.get(t.rank).map_or(0.0, High::to_f64);
            (t.x, t.rank, Some(cut / smallest), smallest)
        };
        let condition = if rank == 0 { 1.0 } else { largest.hypot(damping) / smallest };
        let residual = &a * &x - b;
        let lengths = x.column_iter().zip(residual.column_iter());
        let scales = lengths
            .map(|(x, r)| {
                let residual_term =
                    if largest > 0.0 { condition * norm(&r).to_f64() / largest } else { 0.0 };
                norm(&x).to_f64() + residual_term
            })
            .collect();
        Self { x, rank, unknowns, condition, scales, gap, reduced, is_plain: ridge == 0.0 }
    }

    /// A row that states the rank and the gap where rank is missing.
    pub fn noted(&self, mut row: Row) -> Row {
        if let Some(gap) = self.gap {
            row.case = format!(" (rank {} of {}, gap {gap:.0e})", self.rank, self.unknowns);
        }
        row
    }

    /// Errors and scales of the six values, ready for [`Quantity::worst`].
    pub fn off_by(&self, found: &[[f64; 6]]) -> Vec<(f64, f64)> {
        let expected = self.x.column_iter().zip(&self.scales).enumerate();
        expected
            .map(|(k, (expected, &scale))| {
                let found: Vec<f64> = found.iter().map(|x| x[k]).collect();
                (references::distance(&found, &expected), scale)
            })
            .collect()
    }

    /// The condition number of a plain system of full rank, to all digits.
    pub fn exact_condition(&self, most_unknowns: usize) -> Option<High> {
        if !self.is_plain || self.gap.is_some() || self.unknowns > most_unknowns {
            return None;
        }
        let s = svd(&self.reduced).singular_values;
        Some(s.first()? / s.last()?)
    }
}

/// Descending, in `f64`.
pub fn singular_values(matrix: &HighMatrix) -> Vec<f64> {
    if matrix.is_empty() {
        return Vec::new();
    }
    // Entries beyond the range of f64's squares would be lost in it.
    match to_f64(matrix).singular_values() {
        Ok(values) => values,
        Err(_) => vec![f64::NAN],
    }
}

fn stacked(above: &HighMatrix, below: &HighMatrix) -> HighMatrix {
    let rows = above.nrows();
    HighMatrix::from_fn(rows + below.nrows(), above.ncols(), |i, j| match i.checked_sub(rows) {
        None => above[(i, j)].clone(),
        Some(i) => below[(i, j)].clone(),
    })
}
