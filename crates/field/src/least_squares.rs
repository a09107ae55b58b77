//! Least squares of least norm for tall design matrices that arrive row by row.
//!
//! Blocks of rows update an upper triangle by Householder QR (tall-skinny QR), so memory
//! is that of the unknowns, and the SVD of the triangle has exactly the singular values of the
//! design matrix, never their squares. Systems that determine all their unknowns are solved by
//! back substitution; only the others need the decomposition.

use super::qr_update::{Block, ROW_UNIT, Scratch, qr_update};
use super::singular::{Dense, Extremes, UpperTriangle, extremes};
use faer::{Mat, MatMut};
use std::slice::ChunksExactMut;

/// Number of right-hand sides: the six values of a sensor's error.
pub const VALUES: usize = 6;

/// Rows that can be pushed side by side.
pub const LANES: usize = ROW_UNIT;

/// Rows gathered at least before the triangle is updated; more where there are more unknowns, so that
/// an update never has fewer rows than unknowns. With 256, 512, 1,024 and 2,048 a fit of order 4 took
/// 0.38, 0.36, 0.33 and 0.34 s of one core for 100,000 samples, and one of order 6 the same with
/// all.
const BLOCK_ROWS: usize = 1024;

/// How close to the cutoff the smallest singular value may be, relative to it, before the full
/// decomposition decides.
const NEAR_CUTOFF: f64 = 1e-6;

/// `A x ≈ b` for six right-hand sides, built up row by row.
pub struct LeastSquares {
    unknowns: usize,
    /// Rows of `[A | b]` that are not in the triangle yet, column after column.
    pending: Vec<f64>,
    pending_rows: usize,
    /// Of all rows before those.
    triangle: Option<Mat<f64>>,
    rows: usize,
    row: Vec<f64>,
    scratch: Scratch,
}

/// Rows of a least-squares system reduced to an equivalent triangle: systems over
/// disjoint rows are put together from their triangles.
#[derive(Clone, Debug)]
pub struct Triangle {
    unknowns: usize,
    rows: usize,
    /// `Qᵀ [A | b]`, with at most as many rows as columns.
    reduced: Mat<f64>,
    /// Whether `reduced` is square and upper triangular; else it holds the rows themselves.
    is_triangular: bool,
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
    pub residual_sum_of_squares: [f64; VALUES],
}

/// The solution and what it depends on.
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

/// Rows side by side, filled column by column: the unknowns in order, then the values.
pub struct Lanes<'a> {
    columns: ChunksExactMut<'a, f64>,
    at: usize,
}

impl Lanes<'_> {
    /// The next column's entries, one a row.
    #[inline(always)]
    pub fn push(&mut self, entries: &[f64; LANES]) {
        if let Some(column) = self.columns.next() {
            column[self.at..self.at + LANES].copy_from_slice(entries);
        }
    }
}

impl LeastSquares {
    /// A system without rows.
    pub fn new(unknowns: usize) -> Self {
        Self {
            unknowns,
            pending: Vec::new(),
            pending_rows: 0,
            triangle: None,
            rows: 0,
            row: Vec::new(),
            scratch: Scratch::default(),
        }
    }

    pub fn rows(&self) -> usize {
        self.rows
    }

    /// Adds a row: `fill` appends the row's entries for each unknown, in order.
    pub fn push(&mut self, fill: impl FnOnce(&mut Vec<f64>), values: [f64; VALUES]) {
        let mut row = std::mem::take(&mut self.row);
        row.clear();
        fill(&mut row);
        row.extend(values);
        debug_assert_eq!(row.len(), self.width(), "a row has one entry an unknown");
        self.push_lanes(1, |lanes| {
            for &entry in &row {
                let mut entries = [0.0; LANES];
                entries[0] = entry;
                lanes.push(&entries);
            }
        });
        self.row = row;
    }

    /// Adds the first `count` of [`LANES`] rows side by side.
    pub fn push_lanes(&mut self, count: usize, fill: impl FnOnce(&mut Lanes<'_>)) {
        debug_assert!(count <= LANES);
        if self.pending_rows + count > self.capacity() {
            self.reduce();
        }
        let stride = self.stride();
        if self.pending.is_empty() {
            self.pending = vec![0.0; stride * self.width()];
        }
        fill(&mut Lanes { columns: self.pending.chunks_exact_mut(stride), at: self.pending_rows });
        self.pending_rows += count;
        self.rows += count;
    }

    /// Adds the rows that another system's triangle stands for.
    pub fn push_triangle(&mut self, other: &Triangle) {
        debug_assert_eq!(self.unknowns, other.unknowns, "parts of one system");
        let width = self.width();
        if !other.is_triangular {
            for i in 0..other.reduced.nrows() {
                self.push(
                    |row| row.extend((0..other.unknowns).map(|j| other.reduced[(i, j)])),
                    std::array::from_fn(|k| other.reduced[(i, other.unknowns + k)]),
                );
            }
            return;
        }
        self.rows += other.rows;
        let Some(triangle) = &mut self.triangle else {
            self.triangle = Some(other.reduced.clone());
            return;
        };
        let mut rows = Mat::zeros(width.next_multiple_of(ROW_UNIT), width);
        rows.get_mut(..width, ..).copy_from(&other.reduced);
        let leads: Vec<_> = (0..width).collect();
        let block = Block { rows: rows.as_mut(), leads: Some(&leads) };
        qr_update(triangle.as_mut(), block, &mut self.scratch);
    }

    /// The triangle of all rows.
    pub fn into_triangle(mut self) -> Triangle {
        let is_triangular = self.triangle.is_some() || self.pending_rows > self.width();
        let reduced = if is_triangular {
            self.reduce();
            self.triangle.unwrap_or_else(|| Mat::zeros(0, 0))
        } else {
            let stride = self.stride();
            Mat::from_fn(self.pending_rows, self.width(), |i, j| self.pending[j * stride + i])
        };
        Triangle { unknowns: self.unknowns, rows: self.rows, reduced, is_triangular }
    }

    /// [`Triangle::solve`] of all rows.
    ///
    /// # Errors
    /// [`NoConvergence`], which finite input is not known to cause.
    pub fn solve(self, rcond: f64, ridge: f64) -> Result<Solution, NoConvergence> {
        self.into_triangle().solve(rcond, ridge)
    }

    fn width(&self) -> usize {
        self.unknowns + VALUES
    }

    /// Rows that are gathered before the triangle is updated.
    fn capacity(&self) -> usize {
        BLOCK_ROWS.max(self.width().next_multiple_of(ROW_UNIT))
    }

    /// From column to column: room for lanes that are not rows, and never a power of two, which
    /// would put whole rows into one set of the cache.
    fn stride(&self) -> usize {
        self.capacity() + ROW_UNIT
    }

    /// Updates the triangle with the pending rows.
    fn reduce(&mut self) {
        let (width, stride) = (self.width(), self.stride());
        let rows = self.pending_rows.next_multiple_of(ROW_UNIT);
        if rows == 0 {
            return;
        }
        for column in self.pending.chunks_exact_mut(stride) {
            column[self.pending_rows..rows].fill(0.0);
        }
        let pending =
            MatMut::from_column_major_slice_with_stride_mut(&mut self.pending, rows, width, stride);
        let triangle = self.triangle.get_or_insert_with(|| Mat::zeros(width, width));
        let block = Block { rows: pending, leads: None };
        qr_update(triangle.as_mut(), block, &mut self.scratch);
        self.pending_rows = 0;
    }
}

impl Triangle {
    /// The triangle of the rows of all parts; `None` without any.
    pub fn merged<'a>(parts: impl IntoIterator<Item = &'a Self>) -> Option<Self> {
        let mut parts = parts.into_iter();
        let first = parts.next()?;
        let Some(second) = parts.next() else {
            return Some(first.clone());
        };
        let mut sum = LeastSquares::new(first.unknowns);
        for part in [first, second].into_iter().chain(parts) {
            sum.push_triangle(part);
        }
        Some(sum.into_triangle())
    }

    /// A system of rows that stand for `count` rows of a design matrix; no more than the unknowns
    /// and values together.
    pub(super) fn from_rows(unknowns: usize, count: usize, reduced: Mat<f64>) -> Self {
        debug_assert_eq!(reduced.ncols(), unknowns + VALUES);
        debug_assert!(reduced.nrows() <= unknowns + VALUES);
        Self { unknowns, rows: count, reduced, is_triangular: false }
    }

    /// Rows equivalent to all rows: unknowns, then values.
    pub(super) fn reduced(&self) -> &Mat<f64> {
        &self.reduced
    }

    /// Rows of the design matrix.
    pub fn rows(&self) -> usize {
        self.rows
    }

    /// Columns of the design matrix.
    pub fn unknowns(&self) -> usize {
        self.unknowns
    }

    /// The solution of [`Decomposition::solve`], by back substitution where all unknowns are
    /// determined, which is most of the time saved; the rank and the condition are the same.
    ///
    /// # Errors
    /// [`NoConvergence`], which finite input is not known to cause.
    pub fn solve(&self, rcond: f64, ridge: f64) -> Result<Solution, NoConvergence> {
        match self.solve_determined(rcond, ridge) {
            Some(solution) => Ok(solution),
            None => Ok(self.decompose()?.solve(rcond, ridge)),
        }
    }

    /// `None` where the rank is not certainly full.
    fn solve_determined(&self, rcond: f64, ridge: f64) -> Option<Solution> {
        let p = self.unknowns;
        if !self.is_triangular || p == 0 {
            return None;
        }
        let found = determined(&Dense::leading(&self.reduced, p), rcond, |i| self.reduced[(i, i)])?;
        let damped = (ridge > 0.0).then(|| self.damped(ridge * found.largest));
        let reduced = damped.as_ref().unwrap_or(&self.reduced);
        let triangle = Dense::leading(reduced, p);
        let mut unknowns = vec![[0.0; VALUES]; p];
        for k in 0..VALUES {
            let mut x: Vec<_> = (0..p).map(|i| reduced[(i, p + k)]).collect();
            triangle.solve(&mut x);
            for (unknown, x) in unknowns.iter_mut().zip(x) {
                unknown[k] = x;
            }
        }
        Some(Solution { unknowns, rank: p, condition: found.largest / found.smallest })
    }

    /// The triangle with a row more for each unknown, `damping` times it and 0.
    fn damped(&self, damping: f64) -> Mat<f64> {
        let p = self.unknowns;
        let mut triangle = self.reduced.clone();
        let mut rows = Mat::zeros(p.next_multiple_of(ROW_UNIT), p + VALUES);
        for i in 0..p {
            rows[(i, i)] = damping;
        }
        let leads: Vec<_> = (0..p).collect();
        let block = Block { rows: rows.as_mut(), leads: Some(&leads) };
        qr_update(triangle.as_mut(), block, &mut Scratch::default());
        triangle
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
                residual_sum_of_squares: [0.0; VALUES],
            });
        }
        let svd = a.thin_svd().map_err(|_| NoConvergence { rows: self.rows, unknowns: p })?;
        // Of fewer rows than unknowns, the values beyond are round-off of the reduction.
        let kept = svd.S().dim().min(self.rows);
        let u = svd.U().get(.., ..kept);
        let rotated = u.transpose() * b;
        let missed = b - u * &rotated;
        let residual_sum_of_squares = std::array::from_fn(|k| {
            let below = (used..rows).map(|i| self.reduced[(i, p + k)].powi(2));
            let outside = (0..used).map(|i| missed[(i, k)].powi(2));
            below.chain(outside).sum()
        });
        Ok(Decomposition {
            unknowns: p,
            rows: self.rows,
            singular_values: svd.S().column_vector().iter().take(kept).copied().collect(),
            v: svd.V().get(.., ..kept).to_owned(),
            rotated,
            residual_sum_of_squares,
        })
    }
}

impl Decomposition {
    /// Singular values above `rcond` times the largest.
    pub fn rank(&self, rcond: f64) -> usize {
        let largest = self.largest();
        self.singular_values.iter().filter(|&&s| s > rcond * largest).count()
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
            let gain = if i < rank { s / (s * s + damping * damping) } else { 0.0 };
            for k in 0..VALUES {
                damped[(i, k)] *= gain;
            }
        }
        let x = &self.v * damped;
        Solution {
            unknowns: (0..self.unknowns).map(|i| std::array::from_fn(|k| x[(i, k)])).collect(),
            rank,
            condition: match rank {
                0 => 0.0,
                rank => largest / self.singular_values[rank - 1],
            },
        }
    }
}

/// The extreme singular values of a triangle, where the smallest is certainly above `rcond` times
/// the largest.
pub(super) fn determined(
    triangle: &impl UpperTriangle,
    rcond: f64,
    diagonal: impl Fn(usize) -> f64,
) -> Option<Extremes> {
    // The smallest singular value is below, the largest above every entry of the diagonal.
    let sizes = (0..triangle.len()).map(|i| diagonal(i).abs());
    let (least, most) = sizes
        .fold((f64::INFINITY, 0.0_f64), |(least, most), size| (least.min(size), most.max(size)));
    if least.partial_cmp(&(rcond * most)) != Some(std::cmp::Ordering::Greater) {
        return None;
    }
    extremes(triangle).filter(|e| e.smallest > rcond * e.largest * (1.0 + NEAR_CUTOFF))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random_models::Seeded;

    /// A matrix with known solution, of seeded numbers.
    fn problem(rows: usize, unknowns: usize) -> (Vec<Vec<f64>>, Vec<[f64; VALUES]>) {
        let mut seeded = Seeded::new(1);
        let mut next = || seeded.uniform() - 0.5;
        let a = (0..rows).map(|_| (0..unknowns).map(|_| next()).collect()).collect();
        let x = (0..unknowns).map(|_| std::array::from_fn(|_| next())).collect();
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
        let (a, x) = problem(3 * BLOCK_ROWS + 17, 20);
        let found = system(&a, &x).solve(1e-10, 0.0).unwrap();
        assert_eq!(found.rank, 20);
        for (f, x) in found.unknowns.iter().zip(&x) {
            for k in 0..VALUES {
                assert!((f[k] - x[k]).abs() < 1e-13);
            }
        }
    }

    #[test]
    fn few_rows_give_the_least_norm_solution() {
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
    fn a_zero_column_lowers_the_rank() {
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
    fn merged_triangles_are_that_of_all_rows() {
        let (a, x) = problem(300, 12);
        let whole = system(&a, &x).into_triangle().decompose().unwrap();
        let parts: Vec<_> = a.chunks(70).map(|rows| system(rows, &x).into_triangle()).collect();
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
    fn residual_sum_of_squares_is_that_of_residuals() {
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
        assert!((d.residual_sum_of_squares[3] - squares).abs() < 1e-12 * squares, "{x:?}");
    }

    #[test]
    fn no_rows_solve_to_nothing() {
        let found = LeastSquares::new(3).solve(1e-10, 0.0).unwrap();
        assert_eq!((found.rank, found.unknowns), (0, vec![[0.0; 6]; 3]));
    }
}
