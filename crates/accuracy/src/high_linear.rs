//! Linear algebra in [`High`] numbers: Householder QR, one-sided Jacobi SVD, three by three.
//!
//! Nothing here is fast. A system of 216 unknowns takes seconds.

use super::high::High;

/// Columns count as orthogonal below this part of their lengths: far below what any reference is
/// compared to, and above the round-off of 192 bits.
const ORTHOGONAL: f64 = 1e-50;

/// One-sided Jacobi converges quadratically; graded matrices need about ten sweeps to 1e-50.
const MAX_SWEEPS: usize = 60;

/// A dense matrix, column after column.
#[derive(Clone, Debug)]
pub struct HighMatrix {
    pub columns: Vec<Vec<High>>,
    rows: usize,
}

impl HighMatrix {
    /// A matrix by its entries.
    pub fn from_fn(rows: usize, columns: usize, entry: impl Fn(usize, usize) -> High) -> Self {
        Self {
            columns: (0..columns).map(|j| (0..rows).map(|i| entry(i, j)).collect()).collect(),
            rows,
        }
    }

    /// The identity of a size.
    pub fn identity(n: usize) -> Self {
        Self::from_fn(n, n, |i, j| if i == j { High::one() } else { High::zero() })
    }

    /// Number of rows.
    pub fn rows(&self) -> usize {
        self.rows
    }

    /// Number of columns.
    pub fn width(&self) -> usize {
        self.columns.len()
    }

    /// An entry.
    pub fn at(&self, row: usize, column: usize) -> &High {
        &self.columns[column][row]
    }

    /// The transpose.
    pub fn transposed(&self) -> Self {
        Self::from_fn(self.width(), self.rows, |i, j| self.at(j, i).clone())
    }

    /// The product with a matrix on the right.
    pub fn times(&self, other: &Self) -> Self {
        Self::from_fn(self.rows, other.width(), |i, j| {
            self.columns
                .iter()
                .zip(&other.columns[j])
                .map(|(column, factor)| &column[i] * factor)
                .sum()
        })
    }

    /// The difference.
    pub fn minus(&self, other: &Self) -> Self {
        Self::from_fn(self.rows, self.width(), |i, j| self.at(i, j) - other.at(i, j))
    }

    /// The nearest `f64` matrix: its singular values are good to as many digits as anyone reads of
    /// a condition number.
    pub fn to_f64(&self) -> faer::Mat<f64> {
        faer::Mat::from_fn(self.rows, self.width(), |i, j| self.at(i, j).to_f64())
    }
}

/// Sum of products.
pub fn dot(a: &[High], b: &[High]) -> High {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// Euclidean length.
pub fn norm(a: &[High]) -> High {
    dot(a, a).sqrt()
}

/// Triangle and rotated right-hand sides of `[A | b]`, for at least as many rows as columns.
pub struct Reduced {
    /// Upper triangle, square.
    pub r: HighMatrix,
    /// `Qᵀ b`, first as many rows as unknowns.
    pub rotated: HighMatrix,
}

/// Householder QR.
pub fn reduce(mut a: HighMatrix, mut b: HighMatrix) -> Reduced {
    let n = a.width();
    for k in 0..n {
        let mut v: Vec<High> = a.columns[k][k..].to_vec();
        let length = norm(&v);
        if length.is_zero() {
            continue;
        }
        let head = if v[0].is_negative() { -length } else { length };
        v[0] += &head;
        let square = dot(&v, &v);
        let rest = a.columns[k..].iter_mut().chain(b.columns.iter_mut());
        for column in rest {
            let tail = &mut column[k..];
            let gain = dot(&v, tail) * 2.0 / &square;
            for (entry, v) in tail.iter_mut().zip(&v) {
                *entry = &*entry - &gain * v;
            }
        }
    }
    let upper = |i: usize, j: usize| {
        if i <= j { a.at(i, j).clone() } else { High::zero() }
    };
    Reduced {
        r: HighMatrix::from_fn(n, n, upper),
        rotated: HighMatrix::from_fn(n, b.width(), |i, j| b.at(i, j).clone()),
    }
}

/// Solves `A x ≈ b` for a matrix of full column rank.
///
/// ```
/// use trackwright_accuracy::high::High;
/// use trackwright_accuracy::high_linear::{HighMatrix, least_squares};
/// // A line through (0, 1), (1, 2), (2, 6): slope 2.5, height 0.5.
/// let a = HighMatrix::from_fn(3, 2, |i, j| High::from([i as f64, 1.0][j]));
/// let b = HighMatrix::from_fn(3, 1, |i, _| High::from([1.0, 2.0, 6.0][i]));
/// let x = least_squares(&a, &b);
/// assert_eq!([0, 1].map(|k| x.at(k, 0).to_f64()), [2.5, 0.5]);
/// ```
pub fn least_squares(a: &HighMatrix, b: &HighMatrix) -> HighMatrix {
    let Reduced { r, mut rotated } = reduce(a.clone(), b.clone());
    for x in &mut rotated.columns {
        for k in (0..r.width()).rev() {
            let known = dot_row(&r, k, &x[k + 1..], k + 1);
            x[k] = (&x[k] - known) / r.at(k, k);
        }
    }
    rotated
}

fn dot_row(r: &HighMatrix, row: usize, x: &[High], first: usize) -> High {
    x.iter().enumerate().map(|(j, x)| r.at(row, first + j) * x).sum()
}

/// `M = U Λ Vᵀ`, singular values in descending order. Columns of `U` whose singular value is zero
/// are zero.
pub struct HighSvd {
    pub u: HighMatrix,
    pub singular_values: Vec<High>,
    pub v: HighMatrix,
}

/// One-sided Jacobi, for at least as many rows as columns.
pub fn svd(matrix: &HighMatrix) -> HighSvd {
    let n = matrix.width();
    let mut w = matrix.clone();
    let mut v = HighMatrix::identity(n);
    for _ in 0..MAX_SWEEPS {
        let mut is_done = true;
        for p in 0..n {
            for q in p + 1..n {
                is_done &= !orthogonalise(&mut w, &mut v, p, q);
            }
        }
        if is_done {
            break;
        }
    }
    let lengths: Vec<High> = w.columns.iter().map(|c| norm(c)).collect();
    let mut order: Vec<usize> = (0..n).collect();
    order
        .sort_by(|&a, &b| lengths[b].partial_cmp(&lengths[a]).unwrap_or(std::cmp::Ordering::Equal));
    let unit = |k: &usize| -> Vec<High> {
        let length = &lengths[*k];
        let part = |x: &High| {
            if length.is_zero() { High::zero() } else { x / length }
        };
        w.columns[*k].iter().map(part).collect()
    };
    HighSvd {
        u: HighMatrix { columns: order.iter().map(unit).collect(), rows: w.rows },
        singular_values: order.iter().map(|&k| lengths[k].clone()).collect(),
        v: HighMatrix { columns: order.iter().map(|&k| v.columns[k].clone()).collect(), rows: n },
    }
}

/// Rotates columns `p` and `q` until they are orthogonal; whether that was needed.
fn orthogonalise(w: &mut HighMatrix, v: &mut HighMatrix, p: usize, q: usize) -> bool {
    let (a, b) = (dot(&w.columns[p], &w.columns[p]), dot(&w.columns[q], &w.columns[q]));
    let c = dot(&w.columns[p], &w.columns[q]);
    if c.is_zero() || c.abs() <= (&a * &b).sqrt() * ORTHOGONAL {
        return false;
    }
    let zeta = (b - a) / (&c * 2.0);
    let root = (&zeta * &zeta + 1.0).sqrt();
    let t = if zeta.is_negative() {
        High::one() / (&zeta - root)
    } else {
        High::one() / (&zeta + root)
    };
    let cosine = High::one() / (&t * &t + 1.0).sqrt();
    let sine = &cosine * &t;
    for m in [w, v] {
        for row in 0..m.rows {
            let (x, y) = (m.columns[p][row].clone(), m.columns[q][row].clone());
            m.columns[p][row] = &cosine * &x - &sine * &y;
            m.columns[q][row] = &sine * &x + &cosine * &y;
        }
    }
    true
}

/// A solution of least norm and what was cut off to get it.
pub struct Truncated {
    pub x: HighMatrix,
    pub rank: usize,
    pub singular_values: Vec<High>,
}

/// The solution of least norm; singular values at or below `rcond` times the largest are zero.
pub fn truncated_least_squares(a: &HighMatrix, b: &HighMatrix, rcond: f64) -> Truncated {
    let is_tall = a.rows() >= a.width();
    // A wide matrix by its transpose: `Aᵀ = U Λ Vᵀ`, so `A⁺ = U Λ⁺ Vᵀ`.
    let (svd, rotated) = if is_tall {
        let Reduced { r, rotated } = reduce(a.clone(), b.clone());
        (svd(&r), rotated)
    } else {
        (svd(&a.transposed()), b.clone())
    };
    let (left, right) = if is_tall { (&svd.u, &svd.v) } else { (&svd.v, &svd.u) };
    let cutoff = svd.singular_values.first().map_or_else(High::zero, |s| s * rcond);
    let rank = svd.singular_values.iter().filter(|s| **s > cutoff).count();
    let x = HighMatrix::from_fn(a.width(), b.width(), |_, _| High::zero());
    let mut truncated = Truncated { x, rank, singular_values: svd.singular_values.clone() };
    for (column, b) in truncated.x.columns.iter_mut().zip(&rotated.columns) {
        for k in 0..rank {
            let gain = dot(&left.columns[k], b) / &svd.singular_values[k];
            for (x, v) in column.iter_mut().zip(&right.columns[k]) {
                *x += &gain * v;
            }
        }
    }
    truncated
}

/// A vector of three.
pub type High3 = [High; 3];

/// A matrix of three by three, row after row.
pub type High33 = [High3; 3];

/// A vector of `f64` numbers.
pub fn vector3(values: [f64; 3]) -> High3 {
    values.map(High::from)
}

/// `a × b`.
pub fn cross3(a: &High3, b: &High3) -> High3 {
    std::array::from_fn(|k| {
        let (i, j) = ((k + 1) % 3, (k + 2) % 3);
        &a[i] * &b[j] - &a[j] * &b[i]
    })
}

/// The direction of a vector.
pub fn unit3(a: &High3) -> High3 {
    let length = norm(a);
    std::array::from_fn(|k| &a[k] / &length)
}

/// `a + b`.
pub fn add3(a: &High3, b: &High3) -> High3 {
    std::array::from_fn(|k| &a[k] + &b[k])
}

/// `a − b`.
pub fn sub3(a: &High3, b: &High3) -> High3 {
    std::array::from_fn(|k| &a[k] - &b[k])
}

/// A vector times a number.
pub fn scale3(a: &High3, factor: &High) -> High3 {
    std::array::from_fn(|k| &a[k] * factor)
}

/// A matrix by its entries.
pub fn matrix_from_fn(entry: impl Fn(usize, usize) -> High) -> High33 {
    std::array::from_fn(|i| std::array::from_fn(|j| entry(i, j)))
}

/// The transpose.
pub fn transposed33(m: &High33) -> High33 {
    matrix_from_fn(|i, j| m[j][i].clone())
}

/// `M x`.
pub fn apply33(m: &High33, x: &High3) -> High3 {
    std::array::from_fn(|i| dot(&m[i], x))
}

/// `A B`.
pub fn times33(a: &High33, b: &High33) -> High33 {
    matrix_from_fn(|i, j| (0..3).map(|k| &a[i][k] * &b[k][j]).sum())
}

/// The determinant.
pub fn determinant33(m: &High33) -> High {
    dot(&m[0], &cross3(&m[1], &m[2]))
}

/// The inverse by cofactors; entries are not finite where there is none.
pub fn inverse33(m: &High33) -> High33 {
    let determinant = determinant33(m);
    let cofactors = [cross3(&m[1], &m[2]), cross3(&m[2], &m[0]), cross3(&m[0], &m[1])];
    matrix_from_fn(|i, j| &cofactors[j][i] / &determinant)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Entries of a matrix without structure.
    fn entry(i: usize, j: usize) -> High {
        let x = (i * 7 + j * 13 + i * j * 3) % 17;
        High::from(x as f64 - 8.0) / 7.0
    }

    fn largest(m: &HighMatrix) -> f64 {
        m.columns.iter().flatten().map(|x| x.abs().to_f64()).fold(0.0, f64::max)
    }

    #[test]
    fn least_squares_residual_is_perpendicular() {
        let a = HighMatrix::from_fn(9, 4, entry);
        let b = HighMatrix::from_fn(9, 2, |i, j| entry(i + 3, j + 5));
        let residual = a.times(&least_squares(&a, &b)).minus(&b);
        assert!(largest(&residual) > 0.1);
        assert!(largest(&a.transposed().times(&residual)) < 1e-50);
    }

    #[test]
    fn factors_of_the_svd_multiply_to_the_matrix() {
        let a = HighMatrix::from_fn(7, 4, entry);
        let HighSvd { mut u, singular_values, v } = svd(&a);
        for (column, s) in u.columns.iter_mut().zip(&singular_values) {
            for x in column {
                *x = &*x * s;
            }
        }
        assert!(largest(&u.times(&v.transposed()).minus(&a)) < 1e-50);
        assert!(largest(&v.transposed().times(&v).minus(&HighMatrix::identity(4))) < 1e-50);
    }

    #[test]
    fn least_norm_solution_is_in_the_row_space() {
        // Five equations of rank three for six unknowns.
        let left = HighMatrix::from_fn(5, 3, entry);
        let right = HighMatrix::from_fn(3, 6, |i, j| entry(i + 2, j));
        let a = left.times(&right);
        let b = a.times(&HighMatrix::from_fn(6, 1, |i, _| entry(i, 4)));
        for a in [a.clone(), stacked_twice(&a)] {
            let b = if a.rows() > 5 { stacked_twice(&b) } else { b.clone() };
            let found = truncated_least_squares(&a, &b, 1e-30);
            assert_eq!(found.rank, 3);
            assert!(largest(&a.times(&found.x).minus(&b)) < 1e-50);
            // In the row space: x = rightᵀ y for some y.
            let y = least_squares(&right.transposed(), &found.x);
            assert!(largest(&right.transposed().times(&y).minus(&found.x)) < 1e-50);
        }
    }

    fn stacked_twice(m: &HighMatrix) -> HighMatrix {
        let rows = m.rows();
        HighMatrix::from_fn(2 * rows, m.width(), |i, j| m.at(i % rows, j).clone())
    }

    #[test]
    fn an_inverse_undoes_its_matrix() {
        let m = matrix_from_fn(entry);
        let product = times33(&m, &inverse33(&m));
        for (i, row) in product.iter().enumerate() {
            for (j, x) in row.iter().enumerate() {
                let expected = if i == j { 1.0 } else { 0.0 };
                assert!((x - High::from(expected)).abs() < High::from(1e-50));
            }
        }
    }
}
