//! Products and triangular solves in blocks of columns, on all cores. Blocks do not depend on the number
//! of cores, so that neither do the digits.

use faer::linalg::matmul::matmul;
use faer::linalg::matmul::triangular::{BlockStructure, matmul as triangular_matmul};
use faer::linalg::triangular_solve::solve_lower_triangular_in_place;
use faer::{Accum, Mat, MatMut, MatRef, Par};

/// Columns that one core works on at a time.
const BLOCK: usize = 64;

/// `L⁻¹ X`, in place.
pub(super) fn solve_lower(lower: MatRef<f64>, x: MatMut<f64>) {
    each_block(x, 0, &|block, _| {
        solve_lower_triangular_in_place(lower, block, Par::Seq);
    });
}

/// `C - V' V`, in place, the lower triangle; what is above it is not meant to be read.
pub(super) fn less_gram(c: MatMut<f64>, v: MatRef<f64>) {
    each_block(c, 0, &|block, first| {
        let below = block.subrows_mut(first, v.ncols() - first);
        let (rows, columns) = (v.subcols(first, v.ncols() - first), below.ncols());
        let own = v.subcols(first, columns);
        matmul(below, Accum::Add, rows.transpose(), own, -1.0, Par::Seq);
    });
}

/// `L X` of a lower triangle.
pub(super) fn lower_times(lower: MatRef<f64>, x: MatRef<f64>) -> Mat<f64> {
    let mut product = Mat::zeros(lower.nrows(), x.ncols());
    each_block(product.as_mut(), 0, &|block, first| {
        let own = x.subcols(first, block.ncols());
        triangular_matmul(
            block,
            BlockStructure::Rectangular,
            Accum::Replace,
            lower,
            BlockStructure::TriangularLower,
            own,
            BlockStructure::Rectangular,
            1.0,
            Par::Seq,
        );
    });
    product
}

/// Calls `work` with each block of columns and the index of the block's first column.
fn each_block(x: MatMut<f64>, first: usize, work: &(impl Fn(MatMut<f64>, usize) + Sync)) {
    let columns = x.ncols();
    if columns <= BLOCK {
        work(x, first);
        return;
    }
    let half = columns.div_ceil(2 * BLOCK) * BLOCK;
    let (left, right) = x.split_at_col_mut(half.min(columns));
    rayon::join(|| each_block(left, first, work), || each_block(right, first + half, work));
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random_models::Seeded;

    fn random(rows: usize, columns: usize) -> Mat<f64> {
        let mut random = Seeded::new(7);
        Mat::from_fn(rows, columns, |_, _| random.normal())
    }

    /// Far from singular.
    fn lower(n: usize) -> Mat<f64> {
        let all = random(n, n);
        Mat::from_fn(n, n, |i, j| match i.cmp(&j) {
            std::cmp::Ordering::Less => 0.0,
            std::cmp::Ordering::Equal => 3.0,
            std::cmp::Ordering::Greater => all[(i, j)] / n as f64,
        })
    }

    #[test]
    fn blocks_give_what_whole_matrices_give() {
        for (n, columns) in [(1, 1), (5, 64), (40, 65), (90, 300)] {
            let (l, x) = (lower(n), random(n, columns));
            let product = lower_times(l.as_ref(), x.as_ref());
            assert!((&product - &l * &x).norm_max() < 1e-12);
            let mut solved = product;
            solve_lower(l.as_ref(), solved.as_mut());
            assert!((&solved - &x).norm_max() < 1e-12);
            let c = random(columns, columns);
            let mut found = c.clone();
            less_gram(found.as_mut(), x.as_ref());
            let whole = &c - x.transpose() * &x;
            for j in 0..columns {
                for i in j..columns {
                    assert!((found[(i, j)] - whole[(i, j)]).abs() < 1e-11);
                }
            }
        }
    }

    #[test]
    fn blocks_do_not_depend_on_the_number_of_cores() {
        let (l, x) = (lower(70), random(70, 400));
        let on = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
            let pool = pool.build().unwrap();
            pool.install(|| lower_times(l.as_ref(), x.as_ref()))
        };
        assert_eq!(on(1), on(3));
    }
}
