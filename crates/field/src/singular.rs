//! The largest and smallest singular value of a triangle, without the ones between.
//!
//! Lanczos with full reorthogonalisation (Golub & Van Loan, Matrix Computations, chapter 10) on
//! `RᵀR` and on its inverse by back substitution. Nothing is squared that is not the vector's own
//! step: the smallest value is as exact as the substitutions, which are backward stable.

use super::random_models::Seeded;
use faer::{Mat, MatRef, Side};

/// Residual of the eigenvalue, relative to it, at which it counts as found.
const CONVERGED: f64 = 1e-12;

/// Steps after which a full decomposition is the better way.
const MAX_STEPS: usize = 400;

/// Steps before the first look at the eigenvalue, and the growth from look to look.
const FIRST_LOOK: usize = 10;

/// A square upper triangle, in whatever form it is stored.
pub trait UpperTriangle {
    fn len(&self) -> usize;
    /// `x = R x`
    fn multiply(&self, x: &mut [f64]);
    /// `x = Rᵀ x`
    fn multiply_transposed(&self, x: &mut [f64]);
    /// `x = R⁻¹ x`
    fn solve(&self, x: &mut [f64]);
    /// `x = R⁻ᵀ x`
    fn solve_transposed(&self, x: &mut [f64]);
}

/// Largest and smallest singular value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Extremes {
    pub largest: f64,
    pub smallest: f64,
}

/// The extreme singular values to 1e-12 of each; `None` where that is not reached, as for a
/// triangle that is singular to working precision.
pub fn extremes(r: &impl UpperTriangle) -> Option<Extremes> {
    let largest = largest(r)?;
    let inverse = largest_eigenvalue(r.len(), |x| {
        r.solve_transposed(x);
        r.solve(x);
    })?;
    let smallest = 1.0 / inverse.sqrt();
    (smallest > 0.0 && smallest <= largest).then_some(Extremes { largest, smallest })
}

/// The largest singular value to 1e-12.
pub fn largest(r: &impl UpperTriangle) -> Option<f64> {
    let square = largest_eigenvalue(r.len(), |x| {
        r.multiply(x);
        r.multiply_transposed(x);
    })?;
    Some(square.sqrt())
}

/// Largest eigenvalue of a symmetric operator that is positive definite.
fn largest_eigenvalue(len: usize, apply: impl Fn(&mut [f64])) -> Option<f64> {
    let mut basis: Vec<Vec<f64>> = Vec::new();
    let (mut diagonal, mut off_diagonal) = (Vec::new(), Vec::new());
    let mut next = start(len);
    let mut look = FIRST_LOOK;
    for step in 1..=len.min(MAX_STEPS) {
        normalise(&mut next)?;
        basis.push(next.clone());
        apply(&mut next);
        diagonal.push(dot(&basis[step - 1], &next));
        // Twice is enough (Giraud et al., Numer. Math. 101, 2005).
        for _ in 0..2 {
            for b in &basis {
                let along = dot(b, &next);
                add_scaled(&mut next, -along, b);
            }
        }
        let left = dot(&next, &next).sqrt();
        if !left.is_finite() {
            return None;
        }
        let is_last = step == len || left == 0.0;
        if step == look || is_last {
            look = step + step / 4 + 1;
            let (value, last) = ritz(&diagonal, &off_diagonal)?;
            if is_last || left * last.abs() <= CONVERGED * value {
                return Some(value);
            }
        }
        off_diagonal.push(left);
    }
    None
}

/// Largest eigenvalue of a tridiagonal matrix, and the last entry of its vector.
fn ritz(diagonal: &[f64], off_diagonal: &[f64]) -> Option<(f64, f64)> {
    let k = diagonal.len();
    let mut t = Mat::<f64>::zeros(k, k);
    for i in 0..k {
        t[(i, i)] = diagonal[i];
        if i + 1 < k {
            t[(i + 1, i)] = off_diagonal[i];
        }
    }
    let eigen = t.self_adjoint_eigen(Side::Lower).ok()?;
    Some((eigen.S().column_vector()[k - 1], eigen.U()[(k - 1, k - 1)]))
}

/// A vector that is not orthogonal to anything in particular, the same each time.
fn start(len: usize) -> Vec<f64> {
    let mut seeded = Seeded::new(1);
    (0..len).map(|_| seeded.uniform() - 0.5).collect()
}

fn normalise(x: &mut [f64]) -> Option<()> {
    let norm = dot(x, x).sqrt();
    if !(norm.is_finite() && norm > 0.0) {
        return None;
    }
    x.iter_mut().for_each(|v| *v /= norm);
    Some(())
}

/// Eight sums side by side, which vectorises where one sum may not.
pub fn dot(a: &[f64], b: &[f64]) -> f64 {
    let mut sums = [0.0; 8];
    let (a_chunks, b_chunks) = (a.chunks_exact(8), b.chunks_exact(8));
    let rest: f64 = a_chunks.remainder().iter().zip(b_chunks.remainder()).map(|(a, b)| a * b).sum();
    for (a, b) in a_chunks.zip(b_chunks) {
        for (sum, (a, b)) in sums.iter_mut().zip(a.iter().zip(b)) {
            *sum += a * b;
        }
    }
    sums.iter().sum::<f64>() + rest
}

/// `y += gain x`
pub fn add_scaled(y: &mut [f64], gain: f64, x: &[f64]) {
    for (y, x) in y.iter_mut().zip(x) {
        *y += gain * x;
    }
}

/// The upper triangle of a dense matrix with columns in one piece.
#[derive(Clone, Copy)]
pub struct Dense<'a>(MatRef<'a, f64>);

impl<'a> Dense<'a> {
    /// The triangle of the leading `len` rows and columns.
    pub fn leading(matrix: &'a Mat<f64>, len: usize) -> Self {
        Self(matrix.get(..len, ..len))
    }

    /// Column `j` down to and with the diagonal.
    fn column(&self, j: usize) -> &'a [f64] {
        self.0.col(j).try_as_col_major().map_or(&[], |column| &column.as_slice()[..=j])
    }
}

impl UpperTriangle for Dense<'_> {
    fn len(&self) -> usize {
        self.0.ncols()
    }

    fn multiply(&self, x: &mut [f64]) {
        for j in 0..self.len() {
            let (column, value) = (self.column(j), x[j]);
            add_scaled(&mut x[..j], value, column);
            x[j] = column[j] * value;
        }
    }

    fn multiply_transposed(&self, x: &mut [f64]) {
        for j in (0..self.len()).rev() {
            x[j] = dot(self.column(j), &x[..=j]);
        }
    }

    fn solve(&self, x: &mut [f64]) {
        for j in (0..self.len()).rev() {
            let column = self.column(j);
            x[j] /= column[j];
            let value = x[j];
            add_scaled(&mut x[..j], -value, column);
        }
    }

    fn solve_transposed(&self, x: &mut [f64]) {
        for j in 0..self.len() {
            let column = self.column(j);
            x[j] = (x[j] - dot(&column[..j], &x[..j])) / column[j];
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A triangle whose singular values are spread over `decades` powers of ten, by random turns.
    fn triangle(len: usize, decades: f64) -> Mat<f64> {
        let numbers = start(len * len);
        let random = Mat::from_fn(len, len, |i, j| numbers[i * len + j]);
        let q = random.qr().compute_Q();
        let spread = Mat::from_fn(len, len, |i, j| {
            10_f64.powf(-decades * i as f64 / len as f64) * q[(i, j)]
        });
        spread.qr().thin_R().to_owned()
    }

    #[test]
    fn extremes_are_those_of_the_full_decomposition() {
        for (len, decades) in [(1, 0.0), (2, 3.0), (9, 6.0), (120, 2.0), (120, 9.0)] {
            let r = triangle(len, decades);
            let s = r.singular_values().unwrap();
            let found = extremes(&Dense::leading(&r, len)).unwrap();
            let epsilon = len as f64 * f64::EPSILON * s[0];
            assert!((found.largest - s[0]).abs() < 1e-12 * s[0] + epsilon);
            assert!((found.smallest - s[len - 1]).abs() < 1e-12 * s[len - 1] + epsilon);
        }
    }

    #[test]
    fn a_singular_triangle_has_no_smallest_value() {
        let mut r = triangle(12, 1.0);
        for i in 0..12 {
            r[(i, 5)] = 0.0;
        }
        assert_eq!(extremes(&Dense::leading(&r, 12)), None);
    }

    #[test]
    fn solving_undoes_multiplying() {
        let r = triangle(40, 1.0);
        let r = Dense::leading(&r, 40);
        let x = start(40);
        let mut y = x.clone();
        r.multiply(&mut y);
        r.multiply_transposed(&mut y);
        r.solve_transposed(&mut y);
        r.solve(&mut y);
        // The condition of RᵀR is 100.
        assert!(x.iter().zip(&y).all(|(x, y)| (x - y).abs() < 1e-11));
    }
}
