//! Folds rows into an upper triangle: blocked Householder QR of a triangle stacked on a block.
//!
//! The reflectors have one entry in the triangle and the rest in the block, as in LAPACK's `tpqrt`,
//! so that a fold costs `2 m n²` whatever the triangle holds already. Products of reflectors are
//! kept as `I - V T Vᵀ` (Schreiber & Van Loan, SIAM J. Sci. Stat. Comput. 10(1), 1989), panels are
//! split in two until the [`LEAF`] (Elmroth & Gustavson, IBM J. Res. Dev. 44(4), 2000), and nearly
//! all arithmetic is products of matrices.

use faer::linalg::matmul::matmul;
use faer::prelude::{Reborrow, ReborrowMut};
use faer::{Accum, Mat, MatMut, Par};
use pulp::{Simd, WithSimd};
use std::array;

/// Rows of a block come in multiples of this, the last ones padded with zeros: the widest vectors
/// hold eight numbers.
pub const ROW_UNIT: usize = 8;

/// Columns whose reflectors are found one by one: with 256 rows they fill half of a core's
/// nearest cache, and their sums the registers of the narrowest vectors that matter.
const LEAF: usize = 8;

/// Columns of a panel. With 16, 24, 32 and 48 a fit of order 4 took 0.33, 0.36, 0.36 and 0.38 s of
/// one core for 100,000 samples, and one of order 6 the same with all.
const PANEL: usize = 16;

/// Columns that are updated in one piece where the work is shared among threads. The pieces do
/// not depend on the number of threads, so neither does the result.
const PIECE: usize = 128;

/// Products below this many multiplications are not shared among threads.
const MIN_SHARED: usize = 1 << 22;

/// Squared norms below this count as zero: their reciprocals would overflow.
const TINY_SQUARED: f64 = 1e-290;

/// A block of rows to be folded.
pub struct Block<'a> {
    /// A multiple of [`ROW_UNIT`] rows.
    pub rows: MatMut<'a, f64>,
    /// Where given, the first column that is not zero of each row, ascending: rows whose turn has
    /// not come cost nothing.
    pub leads: Option<&'a [usize]>,
}

/// Space that folds use again and again.
#[derive(Default)]
pub struct Scratch {
    product: Vec<f64>,
    turned: Vec<f64>,
}

/// Folds a block into a triangle by reflections that clear the block's first `triangle.nrows()`
/// columns. What is left of the block's other columns stays there; the cleared ones hold rubbish.
pub fn fold(mut triangle: MatMut<'_, f64>, block: Block<'_>, scratch: &mut Scratch) {
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
        factor_panel(head.get_mut(.., start..), panel.rb_mut(), t.rb_mut(), scratch);
        let reflectors = Reflectors { v: panel.rb(), t: t.rb() };
        reflectors.apply(head_rest, rest, scratch);
    }
}

/// `Qᵀ = I - [I; V] Tᵀ [I; V]ᵀ`.
#[derive(Clone, Copy)]
struct Reflectors<'a> {
    v: faer::MatRef<'a, f64>,
    t: faer::MatRef<'a, f64>,
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
fn factor_panel(
    head: MatMut<'_, f64>,
    panel: MatMut<'_, f64>,
    t: MatMut<'_, f64>,
    scratch: &mut Scratch,
) {
    let k = panel.ncols();
    if k <= LEAF {
        factor_leaf(head, panel, t);
        return;
    }
    let left = (k / 2).next_multiple_of(LEAF);
    let (head_top, head_bottom) = head.split_at_row_mut(left);
    let (head_left, head_right) = head_top.split_at_col_mut(left);
    let (mut v_left, mut v_right) = panel.split_at_col_mut(left);
    let (t_top, t_bottom) = t.split_at_row_mut(left);
    let (mut t_left, mut t_corner) = t_top.split_at_col_mut(left);
    let mut t_right = t_bottom.get_mut(.., left..);
    factor_panel(head_left, v_left.rb_mut(), t_left.rb_mut(), scratch);
    let reflectors = Reflectors { v: v_left.rb(), t: t_left.rb() };
    reflectors.apply_here(head_right, v_right.rb_mut(), scratch);
    factor_panel(head_bottom.get_mut(.., left..), v_right.rb_mut(), t_right.rb_mut(), scratch);
    // The product of two groups: their off-diagonal block of T is -T₁ V₁ᵀ V₂ T₂.
    let mut product = matrix(&mut scratch.product, left, k - left);
    matmul(product.rb_mut(), Accum::Replace, v_left.transpose(), v_right.rb(), 1.0, Par::Seq);
    let mut turned = matrix(&mut scratch.turned, left, k - left);
    matmul(turned.rb_mut(), Accum::Replace, t_left.rb(), product.rb(), 1.0, Par::Seq);
    matmul(t_corner.rb_mut(), Accum::Replace, turned.rb(), t_right.rb(), -1.0, Par::Seq);
}

/// At most [`LEAF`] columns, reflector by reflector.
fn factor_leaf(mut head: MatMut<'_, f64>, panel: MatMut<'_, f64>, mut t: MatMut<'_, f64>) {
    let k = panel.ncols();
    let mut filler = vec![0.0; (LEAF - k) * panel.nrows()];
    let mut fillers = filler.chunks_exact_mut(panel.nrows());
    let mut columns = panel.col_iter_mut();
    let columns: [&mut [f64]; LEAF] = array::from_fn(|_| match columns.next() {
        Some(column) => {
            column.try_as_col_major_mut().map_or_else(Default::default, faer::ColMut::as_slice_mut)
        }
        None => fillers.next().unwrap_or_default(),
    });
    let mut leaf = Leaf {
        head: array::from_fn(|i| {
            array::from_fn(|j| if i < k && j < k { head[(i, j)] } else { 0.0 })
        }),
        t: [[0.0; LEAF]; LEAF],
        count: k,
    };
    pulp::Arch::new().dispatch(LeafTask { leaf: &mut leaf, columns });
    for j in 0..k {
        for i in 0..k {
            head[(i, j)] = leaf.head[i][j];
            t[(i, j)] = leaf.t[i][j];
        }
    }
}

/// The small matrices of a leaf, row by row.
struct Leaf {
    head: [[f64; LEAF]; LEAF],
    t: [[f64; LEAF]; LEAF],
    count: usize,
}

/// What a reflector does to the columns after it: `y_l += gains[l] x`, and `x *= scale`.
struct Reflection {
    scale: f64,
    gains: [f64; LEAF],
}

impl Leaf {
    /// The reflector of column `j`, from the products of that column with all of the leaf's:
    /// finished reflectors before it, itself, and columns still to be turned.
    fn reflect(&mut self, j: usize, products: &[f64; LEAF]) -> Reflection {
        let mut gains = [0.0; LEAF];
        let (alpha, squared) = (self.head[j][j], products[j]);
        if squared < TINY_SQUARED {
            return Reflection { scale: 0.0, gains };
        }
        let beta = -(alpha * alpha + squared).sqrt().copysign(alpha);
        let tau = (beta - alpha) / beta;
        let scale = 1.0 / (alpha - beta);
        self.head[j][j] = beta;
        for l in j + 1..self.count {
            let along = tau * (self.head[j][l] + scale * products[l]);
            self.head[j][l] -= along;
            gains[l] = -along * scale;
        }
        for i in 0..j {
            let sum: f64 = (i..j).map(|m| self.t[i][m] * scale * products[m]).sum();
            self.t[i][j] = -tau * sum;
        }
        self.t[j][j] = tau;
        Reflection { scale, gains }
    }
}

struct LeafTask<'a, 'b> {
    leaf: &'a mut Leaf,
    columns: [&'b mut [f64]; LEAF],
}

impl WithSimd for LeafTask<'_, '_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { leaf, columns } = self;
        let mut columns = columns.map(|column| S::as_mut_simd_f64s(column).0);
        let mut products = products_with_first(simd, &mut columns);
        turn::<S, 0>(simd, leaf, &mut columns, &mut products);
        turn::<S, 1>(simd, leaf, &mut columns, &mut products);
        turn::<S, 2>(simd, leaf, &mut columns, &mut products);
        turn::<S, 3>(simd, leaf, &mut columns, &mut products);
        turn::<S, 4>(simd, leaf, &mut columns, &mut products);
        turn::<S, 5>(simd, leaf, &mut columns, &mut products);
        turn::<S, 6>(simd, leaf, &mut columns, &mut products);
        turn::<S, 7>(simd, leaf, &mut columns, &mut products);
    }
}

/// Products of column 0 with all columns.
#[inline(always)]
fn products_with_first<S: Simd>(simd: S, columns: &mut [&mut [S::f64s]; LEAF]) -> [f64; LEAF] {
    let rows = columns[0].len();
    let columns = columns.each_mut().map(|column| &column[..rows]);
    let mut sums = [simd.splat_f64s(0.0); LEAF];
    #[expect(clippy::needless_range_loop, reason = "one row of all columns at a time")]
    for i in 0..rows {
        let x = columns[0][i];
        for l in 0..LEAF {
            sums[l] = simd.mul_add_f64s(x, columns[l][i], sums[l]);
        }
    }
    sums.map(|sum| simd.reduce_sum_f64s(sum))
}

/// Reflects by column `J`, and in the same pass takes the products of column `J + 1`, turned,
/// with all columns.
#[inline(always)]
fn turn<S: Simd, const J: usize>(
    simd: S,
    leaf: &mut Leaf,
    columns: &mut [&mut [S::f64s]; LEAF],
    products: &mut [f64; LEAF],
) {
    if J >= leaf.count {
        return;
    }
    let Reflection { scale, gains } = leaf.reflect(J, products);
    let scale = simd.splat_f64s(scale);
    let gains = gains.map(|gain| simd.splat_f64s(gain));
    let rows = columns[0].len();
    let columns = columns.each_mut().map(|column| &mut column[..rows]);
    let next = (J + 1).min(LEAF - 1);
    let mut sums = [simd.splat_f64s(0.0); LEAF];
    #[expect(clippy::needless_range_loop, reason = "one row of all columns at a time")]
    for i in 0..rows {
        let x = columns[J][i];
        let mut turned = [x; LEAF];
        for l in 0..LEAF {
            turned[l] = if l < J {
                columns[l][i]
            } else if l == J {
                simd.mul_f64s(scale, x)
            } else {
                simd.mul_add_f64s(gains[l], x, columns[l][i])
            };
            if l >= J {
                columns[l][i] = turned[l];
            }
        }
        if J + 1 < LEAF {
            for l in 0..LEAF {
                sums[l] = simd.mul_add_f64s(turned[next], turned[l], sums[l]);
            }
        }
    }
    *products = sums.map(|sum| simd.reduce_sum_f64s(sum));
}

#[cfg(test)]
mod tests {
    use super::*;

    fn numbers(rows: usize, columns: usize) -> Mat<f64> {
        let mut state = 1_u64;
        Mat::from_fn(rows, columns, |_, _| {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            (state >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
        })
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
                fold(r.as_mut(), block, &mut scratch);
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
    fn rows_that_begin_late_are_left_out_until_then_and_nothing_changes() {
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
            fold(r.as_mut(), block, &mut Scratch::default());
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
        fold(r.as_mut(), block, &mut Scratch::default());
        let left = Mat::from_fn(64, 40, |i, j| if j < pivots { 0.0 } else { rows[(i, j)] });
        let both = r.transpose() * &r + left.transpose() * &left;
        assert!((a.transpose() * &a - both).norm_max() < 64.0 * 64.0 * f64::EPSILON);
    }

    #[test]
    fn columns_of_zeros_and_columns_alike_are_no_trouble() {
        let mut a = numbers(48, 20);
        for i in 0..48 {
            a[(i, 3)] = 0.0;
            a[(i, 9)] = a[(i, 8)];
        }
        let (mut r, mut rows) = (Mat::zeros(20, 20), a.clone());
        let block = Block { rows: rows.as_mut(), leads: None };
        fold(r.as_mut(), block, &mut Scratch::default());
        assert_eq!(r[(3, 3)], 0.0);
        assert!(r[(9, 9)].abs() < 1e-14);
        assert!(gram_difference(&a, &r) < 48.0 * 64.0 * f64::EPSILON);
    }
}
