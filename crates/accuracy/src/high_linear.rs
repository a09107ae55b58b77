//! Linear algebra in [`High`] numbers: Householder QR, one-sided Jacobi SVD, three by three.
//!
//! Nothing here is fast. A system of 216 unknowns takes seconds.

use super::high::{High, One, Zero};
use nalgebra::{DMatrix, Matrix3, Vector3};
use rayon::prelude::*;
use std::cmp::Ordering;

/// Columns count as orthogonal below this part of their lengths: far below what any reference is
/// compared to, and above the round-off of 192 bits.
const ORTHOGONAL: f64 = 1e-50;

/// One-sided Jacobi converges quadratically; graded matrices need about ten sweeps to 1e-50.
const MAX_SWEEPS: usize = 60;

/// A dense matrix.
pub type HighMatrix = DMatrix<High>;

/// A vector of three.
pub type High3 = Vector3<High>;

/// A matrix of three by three.
pub type High33 = Matrix3<High>;

/// The nearest `f64` matrix: its singular values are good to as many digits as anyone reads of a
/// condition number.
pub fn to_f64(matrix: &HighMatrix) -> faer::Mat<f64> {
    faer::Mat::from_fn(matrix.nrows(), matrix.ncols(), |i, j| matrix[(i, j)].to_f64())
}

/// Sum of products.
pub fn dot<'a>(
    a: impl IntoIterator<Item = &'a High>,
    b: impl IntoIterator<Item = &'a High>,
) -> High {
    a.into_iter().zip(b).map(|(a, b)| a * b).sum()
}

/// Euclidean length.
pub fn norm<'a>(a: impl IntoIterator<Item = &'a High>) -> High {
    a.into_iter().map(|a| a * a).sum::<High>().sqrt()
}

/// `Aᵀ (b − A x)` and the length of `b − A x`, of numbers that `f64` has.
pub fn gradient(rows: &[Vec<f64>], b: impl Fn(usize) -> f64 + Sync, x: &[High]) -> (Vec<f64>, f64) {
    let model = |row: &[f64]| row.iter().zip(x).map(|(&a, x)| x * a).sum::<High>();
    let left = rows.par_iter().enumerate().map(|(i, row)| High::from(b(i)) - model(row));
    let left: Vec<High> = left.collect();
    let along = |j: usize| left.iter().zip(rows).map(|(left, row)| left * row[j]).sum::<High>();
    let gradient = (0..x.len()).into_par_iter().map(|j| along(j).to_f64());
    (gradient.collect(), norm(&left).to_f64())
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
    let n = a.ncols();
    for k in 0..n {
        let mut v: Vec<High> = a.column(k).iter().skip(k).cloned().collect();
        let length = norm(&v);
        if length.is_zero() {
            continue;
        }
        let head = if v[0].is_negative() { -length } else { length };
        v[0] += head;
        let square = dot(&v, &v);
        for mut column in a.column_iter_mut().skip(k).chain(b.column_iter_mut()) {
            let gain = dot(&v, column.iter().skip(k)) * 2.0 / &square;
            for (entry, v) in column.iter_mut().skip(k).zip(&v) {
                *entry -= &gain * v;
            }
        }
    }
    Reduced { r: a.rows(0, n).upper_triangle(), rotated: b.rows(0, n).into_owned() }
}

/// Solves `A x ≈ b` for a matrix of full column rank.
pub fn least_squares(a: &HighMatrix, b: &HighMatrix) -> HighMatrix {
    let Reduced { r, mut rotated } = reduce(a.clone(), b.clone());
    for mut x in rotated.column_iter_mut() {
        for k in (0..r.ncols()).rev() {
            let known = dot(r.row(k).iter().skip(k + 1), x.iter().skip(k + 1));
            x[k] = (&x[k] - known) / &r[(k, k)];
        }
    }
    rotated
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
    let n = matrix.ncols();
    let mut w = matrix.clone();
    let mut v = HighMatrix::identity(n, n);
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
    let lengths: Vec<High> = w.column_iter().map(|c| norm(&c)).collect();
    let mut order: Vec<usize> = (0..n).collect();
    order.sort_by(|&a, &b| lengths[b].partial_cmp(&lengths[a]).unwrap_or(Ordering::Equal));
    let unit = |i, k: usize| {
        let length = &lengths[k];
        if length.is_zero() { High::zero() } else { &w[(i, k)] / length }
    };
    HighSvd {
        u: HighMatrix::from_fn(w.nrows(), n, |i, j| unit(i, order[j])),
        singular_values: order.iter().map(|&k| lengths[k].clone()).collect(),
        v: v.select_columns(&order),
    }
}

/// Rotates columns `p` and `q` until they are orthogonal; whether that was needed.
fn orthogonalise(w: &mut HighMatrix, v: &mut HighMatrix, p: usize, q: usize) -> bool {
    let product = |p, q| dot(w.column(p), w.column(q));
    let (a, b, c) = (product(p, p), product(q, q), product(p, q));
    if c.is_zero() || c.abs() <= (&a * &b).sqrt() * ORTHOGONAL {
        return false;
    }
    let zeta = (b - a) / (&c * 2.0);
    let root = (&zeta * &zeta + 1.0).sqrt();
    let root = if zeta.is_negative() { -root } else { root };
    let t = High::one() / (zeta + root);
    let cosine = High::one() / (&t * &t + 1.0).sqrt();
    let sine = &cosine * &t;
    for m in [w, v] {
        for mut row in m.row_iter_mut() {
            let (x, y) = (row[p].clone(), row[q].clone());
            row[p] = &cosine * &x - &sine * &y;
            row[q] = &sine * &x + &cosine * &y;
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
    let is_tall = a.nrows() >= a.ncols();
    // A wide matrix by its transpose: `Aᵀ = U Λ Vᵀ`, so `A⁺ = U Λ⁺ Vᵀ`.
    let (svd, rotated) = if is_tall {
        let Reduced { r, rotated } = reduce(a.clone(), b.clone());
        (svd(&r), rotated)
    } else {
        (svd(&a.transpose()), b.clone())
    };
    let (left, right) = if is_tall { (&svd.u, &svd.v) } else { (&svd.v, &svd.u) };
    let cutoff = svd.singular_values.first().map_or_else(High::zero, |s| s * rcond);
    let rank = svd.singular_values.iter().filter(|s| **s > cutoff).count();
    let mut along = left.columns(0, rank).transpose() * rotated;
    for (mut row, s) in along.row_iter_mut().zip(&svd.singular_values) {
        row /= s.clone();
    }
    Truncated { x: right.columns(0, rank) * along, rank, singular_values: svd.singular_values }
}

/// A vector of `f64` numbers.
pub fn vector3(values: [f64; 3]) -> High3 {
    values.map(High::from).into()
}

/// The direction of a vector.
pub fn unit3(a: &High3) -> High3 {
    a / norm(a)
}

/// A column of a matrix of three rows.
pub fn column3(matrix: &HighMatrix, k: usize) -> High3 {
    High3::from_fn(|i, _| matrix[(i, k)].clone())
}

/// The inverse by cofactors; entries are not finite where there is none.
pub fn inverse33(m: &High33) -> High33 {
    let [a, b, c] = [0, 1, 2].map(|k| m.column(k).into_owned());
    let cofactors = [b.cross(&c), c.cross(&a), a.cross(&b)];
    let determinant = a.dot(&cofactors[0]);
    High33::from_columns(&cofactors).transpose() / determinant
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
        m.iter().map(|x| x.abs().to_f64()).fold(0.0, f64::max)
    }

    #[test]
    fn least_squares_residual_is_perpendicular() {
        let a = HighMatrix::from_fn(9, 4, entry);
        let b = HighMatrix::from_fn(9, 2, |i, j| entry(i + 3, j + 5));
        let residual = &a * least_squares(&a, &b) - b;
        assert!(largest(&residual) > 0.1);
        assert!(largest(&(a.transpose() * residual)) < 1e-50);
    }

    #[test]
    fn factors_of_the_svd_multiply_to_the_matrix() {
        let a = HighMatrix::from_fn(7, 4, entry);
        let HighSvd { mut u, singular_values, v } = svd(&a);
        for (mut column, s) in u.column_iter_mut().zip(singular_values) {
            column *= s;
        }
        assert!(largest(&(u * v.transpose() - a)) < 1e-50);
        assert!(largest(&(v.transpose() * &v - HighMatrix::identity(4, 4))) < 1e-50);
    }

    #[test]
    fn least_norm_solution_is_in_the_row_space() {
        // Five equations of rank three for six unknowns.
        let left = HighMatrix::from_fn(5, 3, entry);
        let right = HighMatrix::from_fn(3, 6, |i, j| entry(i + 2, j));
        let a = left * &right;
        let b = &a * HighMatrix::from_fn(6, 1, |i, _| entry(i, 4));
        for a in [a.clone(), stacked_twice(&a)] {
            let b = if a.nrows() > 5 { stacked_twice(&b) } else { b.clone() };
            let found = truncated_least_squares(&a, &b, 1e-30);
            assert_eq!(found.rank, 3);
            assert!(largest(&(a * &found.x - b)) < 1e-50);
            // In the row space: x = rightᵀ y for some y.
            let y = least_squares(&right.transpose(), &found.x);
            assert!(largest(&(right.transpose() * y - found.x)) < 1e-50);
        }
    }

    fn stacked_twice(m: &HighMatrix) -> HighMatrix {
        let rows = m.nrows();
        HighMatrix::from_fn(2 * rows, m.ncols(), |i, j| m[(i % rows, j)].clone())
    }

    #[test]
    fn an_inverse_undoes_its_matrix() {
        let m = High33::from_fn(entry);
        let off = &m * inverse33(&m) - High33::identity();
        assert!(off.iter().all(|x| x.abs() < High::from(1e-50)));
    }
}
