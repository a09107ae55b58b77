//! Least squares of least norm for tall design matrices that arrive row by row.
//!
//! Blocks of rows are folded into an upper triangle by Householder QR (tall-skinny QR), so memory
//! is that of the unknowns, and the SVD of the triangle has exactly the singular values of the
//! design matrix, never their squares.

use faer::Mat;

/// Number of right-hand sides: the six values of a sensor's error.
const VALUES: usize = 6;

/// Rows that are gathered before they are folded in, in multiples of the unknowns. Below 1 the
/// triangle is refactored too often, above 4 nothing is gained (measured at 27 to 378 unknowns).
const BLOCK_PER_UNKNOWN: usize = 2;

/// Rows gathered at least, so that small problems are one factorisation.
const MIN_BLOCK_ROWS: usize = 2048;

/// `A x ≈ b` for six right-hand sides, built up row by row.
pub struct LeastSquares {
    unknowns: usize,
    /// Rows of `[A | b]`, row after row.
    pending: Vec<f64>,
    /// `R` of all rows folded in so far, with as many rows as are not known to be zero.
    triangle: Option<Mat<f64>>,
    rows: usize,
}

/// The solution and what it hangs on.
pub struct Solution {
    /// One set of six a unknown.
    pub unknowns: Vec<[f64; VALUES]>,
    pub rank: usize,
    /// Largest singular value over the smallest kept; 0 where nothing was kept.
    pub condition: f64,
}

/// A singular value decomposition that did not converge.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("the singular value decomposition of {rows} rows and {unknowns} unknowns did not converge")]
pub struct NoConvergence {
    pub rows: usize,
    pub unknowns: usize,
}

impl LeastSquares {
    pub fn new(unknowns: usize) -> Self {
        Self {
            unknowns,
            pending: Vec::new(),
            triangle: None,
            rows: 0,
        }
    }

    pub fn rows(&self) -> usize {
        self.rows
    }

    /// Adds a row: `fill` appends the row's entries for each unknown, in order.
    pub fn push(&mut self, fill: impl FnOnce(&mut Vec<f64>), values: [f64; VALUES]) {
        fill(&mut self.pending);
        self.pending.extend(values);
        self.rows += 1;
        debug_assert_eq!(
            self.pending.len() % self.width(),
            0,
            "a row has one entry an unknown"
        );
        let block = MIN_BLOCK_ROWS.max(BLOCK_PER_UNKNOWN * self.unknowns);
        if self.pending.len() >= block * self.width() {
            self.fold();
        }
    }

    /// The solution of least norm. Singular values at or below `rcond` times the largest count as
    /// zero; `ridge` (times the largest) damps all of them, as in `‖A c − e‖² + (ridge s)² ‖c‖²`.
    ///
    /// # Errors
    /// [`NoConvergence`], which finite input is not known to cause.
    pub fn solve(mut self, rcond: f64, ridge: f64) -> Result<Solution, NoConvergence> {
        self.fold();
        let p = self.unknowns;
        let zero = Solution {
            unknowns: vec![[0.0; VALUES]; p],
            rank: 0,
            condition: 0.0,
        };
        let Some(reduced) = &self.triangle else {
            return Ok(zero);
        };
        let rows = reduced.nrows().min(p);
        let a = reduced.submatrix(0, 0, rows, p);
        let b = reduced.submatrix(0, p, rows, VALUES);
        let svd = a.thin_svd().map_err(|_| NoConvergence {
            rows: self.rows,
            unknowns: p,
        })?;
        let s: Vec<f64> = svd.S().column_vector().iter().copied().collect();
        let largest = s.iter().copied().fold(0.0, f64::max);
        if largest == 0.0 {
            return Ok(zero);
        }
        let damping = ridge * largest;
        let kept: Vec<f64> = s.iter().copied().filter(|&v| v > rcond * largest).collect();
        let mut rotated = svd.U().transpose() * b;
        for (i, &value) in s.iter().enumerate() {
            let gain = if value > rcond * largest {
                value / (value * value + damping * damping)
            } else {
                0.0
            };
            for k in 0..VALUES {
                rotated[(i, k)] *= gain;
            }
        }
        let x = svd.V() * rotated;
        Ok(Solution {
            unknowns: (0..p).map(|i| std::array::from_fn(|k| x[(i, k)])).collect(),
            rank: kept.len(),
            condition: largest / kept.iter().copied().fold(f64::INFINITY, f64::min),
        })
    }

    fn width(&self) -> usize {
        self.unknowns + VALUES
    }

    /// Replaces the triangle and the pending rows by the triangle of both.
    fn fold(&mut self) {
        if self.pending.is_empty() {
            return;
        }
        let width = self.width();
        let new_rows = self.pending.len() / width;
        let old_rows = self.triangle.as_ref().map_or(0, Mat::nrows);
        let stacked = Mat::from_fn(old_rows + new_rows, width, |i, j| {
            if i >= old_rows {
                self.pending[(i - old_rows) * width + j]
            } else {
                self.triangle.as_ref().map_or(0.0, |t| t[(i, j)])
            }
        });
        self.pending.clear();
        // A wide stack has nothing to gain from QR: its SVD is as small as it gets.
        self.triangle = Some(if stacked.nrows() <= width {
            stacked
        } else {
            stacked.qr().thin_R().to_owned()
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A matrix with known solution, by a small linear congruential sequence.
    fn problem(rows: usize, unknowns: usize) -> (Vec<Vec<f64>>, Vec<[f64; VALUES]>) {
        let mut state = 1_u64;
        let mut next = move || {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1);
            (state >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
        };
        let a = (0..rows)
            .map(|_| (0..unknowns).map(|_| next()).collect())
            .collect();
        let x = (0..unknowns)
            .map(|_| std::array::from_fn(|_| next()))
            .collect();
        (a, x)
    }

    fn system(a: &[Vec<f64>], x: &[[f64; VALUES]]) -> LeastSquares {
        let mut ls = LeastSquares::new(x.len());
        for row in a {
            let b = std::array::from_fn(|k| row.iter().zip(x).map(|(r, x)| r * x[k]).sum());
            ls.push(|out| out.extend(row), b);
        }
        ls
    }

    #[test]
    fn recovers_a_solution_from_many_blocks_of_rows() {
        let (a, x) = problem(3 * MIN_BLOCK_ROWS + 17, 20);
        let found = system(&a, &x).solve(1e-10, 0.0).unwrap();
        assert_eq!(found.rank, 20);
        for (f, x) in found.unknowns.iter().zip(&x) {
            for k in 0..VALUES {
                assert!((f[k] - x[k]).abs() < 1e-13);
            }
        }
    }

    #[test]
    fn fewer_rows_than_unknowns_give_the_solution_of_least_norm() {
        let (a, x) = problem(5, 12);
        let found = system(&a, &x).solve(1e-10, 0.0).unwrap();
        assert_eq!(found.rank, 5);
        let residual = |row: &Vec<f64>, u: &[[f64; VALUES]]| -> f64 {
            row.iter().zip(u).map(|(r, u)| r * u[0]).sum()
        };
        for row in &a {
            assert!((residual(row, &found.unknowns) - residual(row, &x)).abs() < 1e-13);
        }
        let norm = |u: &[[f64; VALUES]]| u.iter().map(|u| u[0] * u[0]).sum::<f64>();
        assert!(norm(&found.unknowns) <= norm(&x));
    }

    #[test]
    fn a_column_of_zeros_lowers_the_rank_and_gets_nothing() {
        let (mut a, x) = problem(40, 6);
        for row in &mut a {
            row[2] = 0.0;
        }
        let found = system(&a, &x).solve(1e-10, 0.0).unwrap();
        assert_eq!(found.rank, 5);
        assert!(found.unknowns[2].iter().all(|v| v.abs() < 1e-14));
    }

    #[test]
    fn ridge_solves_the_damped_normal_equations() {
        let (a, x) = problem(30, 4);
        let ridge = 0.1;
        let found = system(&a, &x).solve(1e-10, ridge).unwrap();
        let m = nalgebra::DMatrix::from_fn(30, 4, |i, j| a[i][j]);
        let exact = nalgebra::DVector::from_fn(4, |i, _| x[i][0]);
        let s = m.clone().svd(false, false).singular_values.max();
        let normal = m.transpose() * &m + nalgebra::DMatrix::identity(4, 4) * (ridge * s).powi(2);
        let expected = normal.lu().solve(&(m.transpose() * (&m * exact))).unwrap();
        for i in 0..4 {
            assert!((found.unknowns[i][0] - expected[i]).abs() < 1e-13);
        }
    }

    #[test]
    fn no_rows_solve_to_nothing() {
        let found = LeastSquares::new(3).solve(1e-10, 0.0).unwrap();
        assert_eq!((found.rank, found.unknowns), (0, vec![[0.0; 6]; 3]));
    }
}
