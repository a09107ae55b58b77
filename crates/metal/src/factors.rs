//! LU factors of a large dense complex matrix, by blocks of columns, so that they can be cancelled.
//!
//! Right-looking, with partial pivoting in each block of columns (Golub and Van Loan, Matrix Computations,
//! section 3.6). Blocks are updated on all threads, each by one of them: the factors do not depend on how
//! many there are.

use faer::linalg::matmul::matmul;
use faer::linalg::triangular_solve::{
    solve_unit_lower_triangular_in_place, solve_upper_triangular_in_place,
};
use faer::{Accum, Mat, MatMut, Par, c64};
use rayon::prelude::*;
use trackwright_task::{Cancelled, Task};

/// Columns of a block: one of 4,000 rows is updated in some milliseconds. 64 take half as long again, 256 a
/// tenth less.
const BLOCK: usize = 128;

const ZERO: c64 = c64::new(0.0, 0.0);
const ONE: c64 = c64::new(1.0, 0.0);

/// `P A = L U` of a square matrix.
#[derive(Clone, Debug)]
pub struct Factors {
    size: usize,
    /// `L` below the diagonal, without its ones, and `U`.
    blocks: Vec<Mat<c64>>,
    /// The row of `A` that each row of `P A` is.
    rows: Vec<usize>,
}

impl Factors {
    /// Factors of the matrix of `entry(row, column)`; `None` where a pivot is below round-off of 1.
    ///
    /// # Errors
    /// [`Cancelled`].
    pub fn new(
        size: usize,
        entry: impl Fn(usize, usize) -> c64 + Sync,
        task: &Task,
    ) -> Result<Option<Self>, Cancelled> {
        let count = size.div_ceil(BLOCK);
        let mut blocks: Vec<Mat<c64>> = (0..count)
            .into_par_iter()
            .map(|k| {
                let first = k * BLOCK;
                let block = Mat::from_fn(size, BLOCK.min(size - first), |i, j| entry(i, first + j));
                if task.cancel.is_cancelled() { Err(Cancelled) } else { Ok(block) }
            })
            .collect::<Result<_, _>>()?;
        let mut rows: Vec<usize> = (0..size).collect();
        for k in 0..count {
            // What is left to do falls with the square of what is left of the matrix.
            let left = (1.0 - k as f64 / count as f64).powi(3);
            task.step(((1.0 - left) * size as f64) as usize, size)?;
            let Some(order) = factor_block(&mut blocks[k], k * BLOCK) else { return Ok(None) };
            let before: Vec<usize> = rows[k * BLOCK..].to_vec();
            for (row, from) in rows[k * BLOCK..].iter_mut().zip(&order) {
                *row = before[*from];
            }
            let (done, rest) = blocks.split_at_mut(k);
            let (own, rest) = rest.split_at_mut(1);
            let own = &own[0];
            done.par_iter_mut().for_each(|block| permute(block.as_mut(), k * BLOCK, &order));
            rest.par_iter_mut().try_for_each(|block| {
                if task.cancel.is_cancelled() {
                    return Err(Cancelled);
                }
                permute(block.as_mut(), k * BLOCK, &order);
                let (_, active) = block.as_mut().split_at_row_mut(k * BLOCK);
                let (mut upper, below) = active.split_at_row_mut(own.ncols());
                let lower = own.as_ref().subrows(k * BLOCK, size - k * BLOCK);
                let (corner, lower) = lower.split_at_row(own.ncols());
                solve_unit_lower_triangular_in_place(corner, upper.as_mut(), Par::Seq);
                matmul(below, Accum::Add, lower, upper.as_ref(), -ONE, Par::Seq);
                Ok(())
            })?;
        }
        task.step(1, 1)?;
        Ok(Some(Self { size, blocks, rows }))
    }

    /// `A⁻¹` times some columns, but for its rows before `from`.
    pub fn solve(&self, right: &Mat<c64>, from: usize) -> Mat<c64> {
        let mut x = Mat::from_fn(self.size, right.ncols(), |i, j| right[(self.rows[i], j)]);
        for (k, block) in self.blocks.iter().enumerate() {
            let (first, width) = (k * BLOCK, block.ncols());
            let (_, rest) = x.as_mut().split_at_row_mut(first);
            let (mut own, below) = rest.split_at_row_mut(width);
            let lower = block.as_ref().subrows(first, self.size - first);
            let (corner, lower) = lower.split_at_row(width);
            solve_unit_lower_triangular_in_place(corner, own.as_mut(), Par::Seq);
            matmul(below, Accum::Add, lower, own.as_ref(), -ONE, Par::Seq);
        }
        // Blocks that hold none of the rows are left as they are.
        let unused = from / BLOCK;
        for (k, block) in self.blocks.iter().enumerate().skip(unused).rev() {
            let (first, width) = (k * BLOCK, block.ncols());
            let (above, rest) = x.as_mut().split_at_row_mut(first);
            let (_, above) = above.split_at_row_mut(unused * BLOCK);
            let (mut own, _) = rest.split_at_row_mut(width);
            let (upper, rest) = block.as_ref().split_at_row(first);
            let (_, upper) = upper.split_at_row(unused * BLOCK);
            let corner = rest.subrows(0, width);
            solve_upper_triangular_in_place(corner, own.as_mut(), Par::Seq);
            matmul(above, Accum::Add, upper, own.as_ref(), -ONE, Par::Seq);
        }
        x.subrows(from, self.size - from).to_owned()
    }
}

/// Factors the rows from `first` on of a block, and returns where each of them was; `None` where a pivot is
/// none.
fn factor_block(block: &mut Mat<c64>, first: usize) -> Option<Vec<usize>> {
    let active = block.as_ref().subrows(first, block.nrows() - first);
    let factors = active.partial_piv_lu();
    let (lower, upper) = (factors.L(), factors.U());
    let width = block.ncols();
    if !(0..width).all(|k| upper[(k, k)].norm() > f64::EPSILON) {
        return None;
    }
    for j in 0..width {
        for i in 0..lower.nrows() {
            block[(first + i, j)] = if i <= j { upper[(i, j)] } else { lower[(i, j)] };
        }
    }
    Some(factors.P().arrays().0.to_vec())
}

fn permute(block: MatMut<'_, c64>, first: usize, order: &[usize]) {
    let (_, active) = block.split_at_row_mut(first);
    let mut before = vec![ZERO; order.len()];
    for column in active.col_iter_mut() {
        for (before, value) in before.iter_mut().zip(column.as_ref().iter()) {
            *before = *value;
        }
        for (value, from) in column.iter_mut().zip(order) {
            *value = before[*from];
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::Mutex;

    /// A matrix without pattern, and far from one whose pivots are on the diagonal.
    fn entry(i: usize, j: usize) -> c64 {
        let turn = 1.3 * i as f64 + 0.4 + 2.7 * (j * j) as f64;
        c64::new(turn.sin() + f64::from(u8::from(i == j + 1)), (2.1 * turn).cos())
    }

    #[test]
    fn solutions_leave_no_residual() {
        for size in [1, 5, BLOCK, BLOCK + 1, 3 * BLOCK - 7] {
            let factors = Factors::new(size, entry, &Task::default()).unwrap().unwrap();
            let matrix = Mat::from_fn(size, size, entry);
            let right =
                Mat::from_fn(size, 3, |i, j| c64::new((0.7 * i as f64 - j as f64).cos(), 0.0));
            let found = factors.solve(&right, 0);
            let last = factors.solve(&right, size / 2);
            assert!(last == found.as_ref().subrows(size / 2, size - size / 2));
            // Backward stable: a residual of round-off times matrix and solution.
            let bound = 1e-14 * size as f64 * matrix.norm_max() * found.norm_max();
            let residual = (&matrix * &found - &right).norm_max();
            assert!(residual <= bound, "{size}: {residual:e} {bound:e}");
        }
    }

    #[test]
    fn a_matrix_without_rank_has_no_factors() {
        let found = Factors::new(90, |i, _| c64::new(i as f64, 0.0), &Task::default()).unwrap();
        assert!(found.is_none());
        assert!(
            Factors::new(90, |_, _| c64::new(f64::NAN, 0.0), &Task::default()).unwrap().is_none()
        );
    }

    #[test]
    fn progress_rises_until_it_is_cancelled() {
        let reported = std::sync::Arc::new(Mutex::new(Vec::new()));
        let parts = reported.clone();
        let task = Task::with_progress(move |part| parts.lock().unwrap().push(part));
        assert!(Factors::new(5 * BLOCK, entry, &task).unwrap().is_some());
        let parts = reported.lock().unwrap().clone();
        assert!(parts.len() == 6 && parts.is_sorted() && parts[5] == 1.0, "{parts:?}");
        task.cancel.cancel();
        assert!(matches!(Factors::new(5 * BLOCK, entry, &task), Err(Cancelled)));
    }
}
