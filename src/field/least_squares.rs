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

/// Rows of a least-squares system reduced to the triangle that says the same: systems over
/// disjoint rows are put together from their triangles.
#[derive(Clone, Debug)]
pub struct Triangle {
    unknowns: usize,
    rows: usize,
    /// `Qᵀ [A | b]`, with at most as many rows as columns.
    reduced: Mat<f64>,
}

/// The singular value decomposition of a system: every ridge and every cutoff is cheap from here.
#[derive(Clone, Debug)]
pub struct Decomposition {
    unknowns: usize,
    /// Rows of the design matrix.
    pub rows: usize,
    /// Of the design matrix, descending; as many as rows or unknowns, whichever are fewer.
    pub singular_values: Vec<f64>,
    /// Right singular vectors, a column each.
    pub v: Mat<f64>,
    /// `Uᵀ b`.
    rotated: Mat<f64>,
    /// What no solution can reach, squared and summed over the rows, one a value.
    pub unreachable_squares: [f64; VALUES],
}

/// The solution and what it hangs on.
#[derive(Clone, Debug, PartialEq)]
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

    /// The triangle of all rows.
    pub fn into_triangle(mut self) -> Triangle {
        self.fold();
        let width = self.width();
        Triangle {
            unknowns: self.unknowns,
            rows: self.rows,
            reduced: self.triangle.unwrap_or_else(|| Mat::zeros(0, width)),
        }
    }

    /// [`Triangle::decompose`] and [`Decomposition::solve`] in one.
    ///
    /// # Errors
    /// [`NoConvergence`], which finite input is not known to cause.
    pub fn solve(self, rcond: f64, ridge: f64) -> Result<Solution, NoConvergence> {
        Ok(self.into_triangle().decompose()?.solve(rcond, ridge))
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
        self.triangle = Some(reduced(stacked));
    }
}

impl Triangle {
    /// The triangle of the rows of all parts; `None` without any.
    pub fn merged<'a>(parts: impl IntoIterator<Item = &'a Self>) -> Option<Self> {
        let mut parts = parts.into_iter();
        let first = parts.next()?.clone();
        Some(parts.fold(first, |sum, part| {
            debug_assert_eq!(sum.unknowns, part.unknowns, "parts of one system");
            let top = sum.reduced.nrows();
            let stacked =
                Mat::from_fn(
                    top + part.reduced.nrows(),
                    sum.reduced.ncols(),
                    |i, j| match i.checked_sub(top) {
                        None => sum.reduced[(i, j)],
                        Some(i) => part.reduced[(i, j)],
                    },
                );
            Self {
                unknowns: sum.unknowns,
                rows: sum.rows + part.rows,
                reduced: reduced(stacked),
            }
        }))
    }

    /// Rows of the design matrix.
    pub fn rows(&self) -> usize {
        self.rows
    }

    /// # Errors
    /// [`NoConvergence`], which finite input is not known to cause.
    pub fn decompose(&self) -> Result<Decomposition, NoConvergence> {
        let p = self.unknowns;
        let rows = self.reduced.nrows();
        let upper = rows.min(p);
        // Rows below the unknowns hold zeros for them, or the system was never reduced.
        let below_is_zero = (upper..rows).all(|i| (0..p).all(|j| self.reduced[(i, j)] == 0.0));
        let used = if below_is_zero { upper } else { rows };
        let a = self.reduced.submatrix(0, 0, used, p);
        let b = self.reduced.submatrix(0, p, used, VALUES);
        if used == 0 {
            return Ok(Decomposition {
                unknowns: p,
                rows: self.rows,
                singular_values: Vec::new(),
                v: Mat::zeros(p, 0),
                rotated: Mat::zeros(0, VALUES),
                unreachable_squares: [0.0; VALUES],
            });
        }
        let svd = a.thin_svd().map_err(|_| NoConvergence {
            rows: self.rows,
            unknowns: p,
        })?;
        let rotated = svd.U().transpose() * b;
        let missed = b - svd.U() * &rotated;
        let unreachable_squares = std::array::from_fn(|k| {
            let below = (used..rows).map(|i| self.reduced[(i, p + k)].powi(2));
            let beside = (0..used).map(|i| missed[(i, k)].powi(2));
            below.chain(beside).sum()
        });
        Ok(Decomposition {
            unknowns: p,
            rows: self.rows,
            singular_values: svd.S().column_vector().iter().copied().collect(),
            v: svd.V().to_owned(),
            rotated,
            unreachable_squares,
        })
    }
}

impl Decomposition {
    /// Singular values above `rcond` times the largest.
    pub fn rank(&self, rcond: f64) -> usize {
        let largest = self.largest();
        self.singular_values
            .iter()
            .filter(|&&s| s > rcond * largest)
            .count()
    }

    /// Largest singular value; 0 where there is none.
    pub fn largest(&self) -> f64 {
        self.singular_values.iter().copied().fold(0.0, f64::max)
    }

    /// The solution of least norm. Singular values at or below `rcond` times the largest count as
    /// zero; `ridge` (times the largest) damps all of them, as in `‖A c − e‖² + (ridge s)² ‖c‖²`.
    pub fn solve(&self, rcond: f64, ridge: f64) -> Solution {
        let largest = self.largest();
        let damping = ridge * largest;
        let rank = self.rank(rcond);
        let mut damped = self.rotated.clone();
        for (i, &s) in self.singular_values.iter().enumerate() {
            let gain = if i < rank {
                s / (s * s + damping * damping)
            } else {
                0.0
            };
            for k in 0..VALUES {
                damped[(i, k)] *= gain;
            }
        }
        let x = &self.v * damped;
        Solution {
            unknowns: (0..self.unknowns)
                .map(|i| std::array::from_fn(|k| x[(i, k)]))
                .collect(),
            rank,
            condition: match rank {
                0 => 0.0,
                rank => largest / self.singular_values[rank - 1],
            },
        }
    }
}

/// A stack of rows as a triangle; a wide one has nothing to gain.
fn reduced(stacked: Mat<f64>) -> Mat<f64> {
    if stacked.nrows() <= stacked.ncols() {
        stacked
    } else {
        stacked.qr().thin_R().to_owned()
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
    fn triangles_of_parts_make_the_triangle_of_all_rows() {
        let (a, x) = problem(300, 12);
        let whole = system(&a, &x).into_triangle().decompose().unwrap();
        let parts: Vec<_> = a
            .chunks(70)
            .map(|rows| system(rows, &x).into_triangle())
            .collect();
        let merged = Triangle::merged(&parts).unwrap();
        assert_eq!(merged.rows(), 300);
        let merged = merged.decompose().unwrap();
        for (m, w) in merged.singular_values.iter().zip(&whole.singular_values) {
            assert!((m - w).abs() < 1e-13 * whole.largest());
        }
        let (m, w) = (merged.solve(1e-10, 0.0), whole.solve(1e-10, 0.0));
        for (m, w) in m.unknowns.iter().zip(&w.unknowns) {
            assert!((m[0] - w[0]).abs() < 1e-13);
        }
    }

    #[test]
    fn what_no_solution_reaches_is_the_sum_of_squared_residuals() {
        let (a, x) = problem(50, 4);
        let mut ls = LeastSquares::new(4);
        for (i, row) in a.iter().enumerate() {
            ls.push(|out| out.extend(row), [(i % 7) as f64; VALUES]);
        }
        let d = ls.into_triangle().decompose().unwrap();
        let found = d.solve(1e-10, 0.0);
        let squares: f64 = a
            .iter()
            .enumerate()
            .map(|(i, row)| {
                let model: f64 = row.iter().zip(&found.unknowns).map(|(r, u)| r * u[3]).sum();
                ((i % 7) as f64 - model).powi(2)
            })
            .sum();
        assert!(
            (d.unreachable_squares[3] - squares).abs() < 1e-12 * squares,
            "{x:?}"
        );
    }

    #[test]
    fn no_rows_solve_to_nothing() {
        let found = LeastSquares::new(3).solve(1e-10, 0.0).unwrap();
        assert_eq!((found.rank, found.unknowns), (0, vec![[0.0; 6]; 3]));
    }
}
