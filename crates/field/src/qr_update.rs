//! Updates an upper triangle with rows: blocked Householder QR of a triangle stacked on a block.
//!
//! The reflectors have one entry in the triangle and the rest in the block, as in LAPACK's `tpqrt`,
//! so that an update costs `2 m n²` whatever the triangle holds already. Products of reflectors are
//! kept as `I - V T Vᵀ` (Schreiber & Van Loan, SIAM J. Sci. Stat. Comput. 10(1), 1989), and nearly
//! all arithmetic is products of matrices by faer. faer's own QR does not serve: it takes a column
//! that is dependent to `16 m ε` for zero, and rank and condition would no longer be those of the
//! design matrix.

use faer::linalg::matmul::matmul;
use faer::prelude::{Reborrow, ReborrowMut};
use faer::{Accum, Mat, MatMut, MatRef, Par};

/// Rows of a block come in multiples of this, the last ones padded with zeros: the widest vectors
/// hold eight numbers.
pub const ROW_UNIT: usize = 8;

/// Columns whose reflectors are found one by one and applied together.
const PANEL: usize = 8;

/// Columns that are updated in one piece where the work is shared among threads. The pieces do
/// not depend on the number of threads, so neither does the result.
const PIECE: usize = 128;

/// Products below this many multiplications are not shared among threads.
const MIN_SHARED: usize = 1 << 22;

/// Squared norms below this count as zero: their reciprocals would overflow.
const TINY_SQUARED: f64 = 1e-290;

/// A block of rows.
pub struct Block<'a> {
    /// A multiple of [`ROW_UNIT`] rows.
    pub rows: MatMut<'a, f64>,
    /// Where given, the first column that is not zero of each row, ascending: rows whose turn has
    /// not come cost nothing.
    pub leads: Option<&'a [usize]>,
}

/// Space that updates use again and again.
#[derive(Default)]
pub struct Scratch {
    product: Vec<f64>,
    turned: Vec<f64>,
}

/// Updates a triangle with a block by reflections that clear the block's first `triangle.nrows()`
/// columns. What is left of the block's other columns stays there; the cleared ones hold rubbish.
pub fn qr_update(mut triangle: MatMut<'_, f64>, block: Block<'_>, scratch: &mut Scratch) {
    let Block { mut rows, leads } = block;
    let (pivots, width) = (triangle.nrows(), triangle.ncols());
    debug_assert_eq!(rows.ncols(), width);
    debug_assert_eq!(rows.nrows() % ROW_UNIT, 0);
    let mut t = Mat::<f64>::zeros(PANEL, PANEL);
    for start in (0..pivots).step_by(PANEL) {
        let end = pivots.min(start + PANEL);
        let active = leads.map_or(rows.nrows(), |leads| {
            let started = leads.partition_point(|&lead| lead < end);
            rows.nrows().min(started.next_multiple_of(ROW_UNIT))
        });
        if active == 0 {
            continue;
        }
        let (panel, rest) = rows.rb_mut().get_mut(..active, ..).split_at_col_mut(end);
        let mut panel = panel.get_mut(.., start..);
        let (head, head_rest) = triangle.rb_mut().get_mut(start..end, ..).split_at_col_mut(end);
        let mut t = t.get_mut(..end - start, ..end - start);
        factor_panel(head.get_mut(.., start..), panel.rb_mut(), t.rb_mut());
        let reflectors = Reflectors { v: panel.rb(), t: t.rb() };
        reflectors.apply(head_rest, rest, scratch);
    }
}

/// `Qᵀ = I - [I; V] Tᵀ [I; V]ᵀ`.
#[derive(Clone, Copy)]
struct Reflectors<'a> {
    v: MatRef<'a, f64>,
    t: MatRef<'a, f64>,
}

impl Reflectors<'_> {
    /// Turns the columns of `[head; rows]`, shared among threads where there are many.
    fn apply(self, head: MatMut<'_, f64>, rows: MatMut<'_, f64>, scratch: &mut Scratch) {
        let columns = rows.ncols();
        if columns > PIECE && self.v.nrows() * self.v.ncols() * columns >= MIN_SHARED {
            let middle = (columns / 2).next_multiple_of(PIECE);
            let (head_a, head_b) = head.split_at_col_mut(middle);
            let (rows_a, rows_b) = rows.split_at_col_mut(middle);
            rayon::join(
                || self.apply(head_a, rows_a, scratch),
                || self.apply(head_b, rows_b, &mut Scratch::default()),
            );
        } else {
            self.apply_here(head, rows, scratch);
        }
    }

    fn apply_here(self, mut head: MatMut<'_, f64>, rows: MatMut<'_, f64>, scratch: &mut Scratch) {
        let (k, columns) = head.shape();
        if columns == 0 {
            return;
        }
        let mut product = matrix(&mut scratch.product, k, columns);
        product.copy_from(head.rb());
        matmul(product.rb_mut(), Accum::Add, self.v.transpose(), rows.rb(), 1.0, Par::Seq);
        let mut turned = matrix(&mut scratch.turned, k, columns);
        matmul(turned.rb_mut(), Accum::Replace, self.t.transpose(), product.rb(), 1.0, Par::Seq);
        head -= turned.rb();
        matmul(rows, Accum::Add, self.v, turned.rb(), -1.0, Par::Seq);
    }
}

/// A matrix in reused space.
fn matrix(space: &mut Vec<f64>, rows: usize, columns: usize) -> MatMut<'_, f64> {
    space.resize(space.len().max(rows * columns), 0.0);
    MatMut::from_column_major_slice_mut(&mut space[..rows * columns], rows, columns)
}

/// Clears a panel: its reflectors replace it, `t` becomes their upper triangle.
fn factor_panel(mut head: MatMut<'_, f64>, mut panel: MatMut<'_, f64>, mut t: MatMut<'_, f64>) {
    let k = panel.ncols();
    for j in 0..k {
        // Products of this column with reflectors before it, itself, and columns still to be turned.
        let mut products = [0.0; PANEL];
        let column = MatMut::from_column_major_slice_mut(&mut products[..k], k, 1);
        matmul(
            column,
            Accum::Replace,
            panel.rb().transpose(),
            panel.rb().subcols(j, 1),
            1.0,
            Par::Seq,
        );
        let (alpha, squared) = (head[(j, j)], products[j]);
        let (mut done, mut rest) = panel.rb_mut().split_at_col_mut(j + 1);
        let mut reflector = done.rb_mut().col_mut(j);
        if squared < TINY_SQUARED {
            // Nothing is reflected; the panel before may have left numbers in `t`.
            reflector.fill(0.0);
            t.rb_mut().col_mut(j).fill(0.0);
            continue;
        }
        let beta = -(alpha * alpha + squared).sqrt().copysign(alpha);
        let tau = (beta - alpha) / beta;
        let scale = 1.0 / (alpha - beta);
        head[(j, j)] = beta;
        reflector *= faer::Scale(scale);
        let mut gains = [0.0; PANEL];
        for l in j + 1..k {
            gains[l] = tau * (head[(j, l)] + scale * products[l]);
            head[(j, l)] -= gains[l];
        }
        let along = MatRef::from_row_major_slice(&gains[j + 1..k], 1, k - j - 1);
        matmul(rest.rb_mut(), Accum::Add, done.rb().subcols(j, 1), along, -1.0, Par::Seq);
        for i in 0..j {
            let sum: f64 = (i..j).map(|m| t[(i, m)] * scale * products[m]).sum();
            t[(i, j)] = -tau * sum;
        }
        t[(j, j)] = tau;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random_models::Seeded;

    fn numbers(rows: usize, columns: usize) -> Mat<f64> {
        let mut seeded = Seeded::new(1);
        Mat::from_fn(rows, columns, |_, _| seeded.uniform() - 0.5)
    }

    /// Largest difference between the Gram matrices: a triangle is right where they agree.
    fn gram_difference(a: &Mat<f64>, r: &Mat<f64>) -> f64 {
        (a.transpose() * a - r.transpose() * r).norm_max()
    }

    #[test]
    fn a_triangle_has_the_gram_matrix_of_its_rows() {
        for columns in [1, 7, 8, 9, 33, 70, 131] {
            let a = numbers(320, columns);
            let mut r = Mat::zeros(columns, columns);
            let mut scratch = Scratch::default();
            for start in [0, 160] {
                let mut part = a.get(start..start + 160, ..).to_owned();
                let block = Block { rows: part.as_mut(), leads: None };
                qr_update(r.as_mut(), block, &mut scratch);
            }
            for j in 0..columns {
                for i in j + 1..columns {
                    assert_eq!(r[(i, j)], 0.0);
                }
            }
            // 320 products below 1/4, each rounded some tens of times.
            assert!(gram_difference(&a, &r) < 320.0 * 64.0 * f64::EPSILON);
        }
    }

    #[test]
    fn leading_zeros_change_nothing() {
        let columns = 100;
        let mut a = numbers(240, columns);
        let leads: Vec<_> = (0..240).map(|i| i * columns / 240).collect();
        for (i, &lead) in leads.iter().enumerate() {
            for j in 0..lead {
                a[(i, j)] = 0.0;
            }
        }
        let triangle = |leads| {
            let (mut r, mut rows) = (Mat::zeros(columns, columns), a.clone());
            let block = Block { rows: rows.as_mut(), leads };
            qr_update(r.as_mut(), block, &mut Scratch::default());
            r
        };
        let (plain, late) = (triangle(None), triangle(Some(leads.as_slice())));
        assert!((&plain - &late).norm_max() < 1e-12);
        assert!(gram_difference(&a, &late) < 240.0 * 64.0 * f64::EPSILON);
    }

    #[test]
    fn what_pivots_do_not_clear_is_left_in_the_rows() {
        let (a, pivots) = (numbers(64, 40), 24);
        let (mut r, mut rows) = (Mat::zeros(pivots, 40), a.clone());
        let block = Block { rows: rows.as_mut(), leads: None };
        qr_update(r.as_mut(), block, &mut Scratch::default());
        let left = Mat::from_fn(64, 40, |i, j| if j < pivots { 0.0 } else { rows[(i, j)] });
        let both = r.transpose() * &r + left.transpose() * &left;
        assert!((a.transpose() * &a - both).norm_max() < 64.0 * 64.0 * f64::EPSILON);
    }

    #[test]
    fn zero_and_equal_columns_are_reduced() {
        let mut a = numbers(48, 20);
        for i in 0..48 {
            a[(i, 3)] = 0.0;
            a[(i, 12)] = 0.0;
            a[(i, 9)] = a[(i, 8)];
        }
        let (mut r, mut rows) = (Mat::zeros(20, 20), a.clone());
        let block = Block { rows: rows.as_mut(), leads: None };
        qr_update(r.as_mut(), block, &mut Scratch::default());
        for zero in [3, 12] {
            assert!((0..20).all(|j| r[(zero, j)] == 0.0));
        }
        assert!(r[(9, 9)].abs() < 1e-14);
        assert!(gram_difference(&a, &r) < 48.0 * 64.0 * f64::EPSILON);
    }
}
