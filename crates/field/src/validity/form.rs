//! Quadratic forms of Bernstein products as polynomials of twice the order.
//!
//! `B_i^n B_j^n = C(n,i) C(n,j) / C(2n,i+j) · B_{i+j}^{2n}` along each axis, so a matrix of
//! `(n + 1)³` rows becomes `(2n + 1)³` coefficients. The factors of those that meet in one
//! coefficient add up to 1 (Vandermonde), so a coefficient is a mean of the matrix's entries and
//! never larger than the largest of them.

use crate::bernstein::{MAX_ORDER, binomial, fill_basis};
use faer::MatRef;
use nalgebra::Vector3;
use pulp::{Simd, WithSimd};

/// Basis values at most: order 24 along one axis.
const MAX_VALUES: usize = 2 * MAX_ORDER + 1;

/// `B(u)ᵀ M B(u)` as coefficients, i slowest. Only the symmetric part of `M` counts.
pub fn coefficients(order: usize, matrix: MatRef<'_, f64>) -> Vec<f64> {
    let (n, m) = (order + 1, 2 * order + 1);
    let factors = factors(order);
    let mut out = vec![0.0; m * m * m];
    let index = |i: usize| (i / (n * n), i / n % n, i % n);
    for column in 0..n * n * n {
        let (ci, cj, ck) = index(column);
        for row in 0..n * n * n {
            let (ri, rj, rk) = index(row);
            out[((ri + ci) * m + rj + cj) * m + rk + ck] +=
                factors[ri][ci] * factors[rj][cj] * factors[rk][ck] * matrix[(row, column)];
        }
    }
    out
}

/// `C(n,i) C(n,j) / C(2n,i+j)`.
fn factors(order: usize) -> Vec<Vec<f64>> {
    (0..=order)
        .map(|i| {
            (0..=order)
                .map(|j| binomial(order, i) * binomial(order, j) / binomial(2 * order, i + j))
                .collect()
        })
        .collect()
}

/// All products of Bernstein values at one point of the unit cube: a form's value is one sum of
/// products with them.
pub struct FormBasis {
    products: Vec<f64>,
}

impl FormBasis {
    /// Of polynomials of this order (twice that of the model).
    pub fn new(order: usize, unit: &Vector3<f64>) -> Self {
        let mut axes = [[0.0; MAX_VALUES]; 3];
        for (axis, x) in axes.iter_mut().zip(unit.iter()) {
            fill_basis(order, *x, axis);
        }
        let [bx, by, bz] = &axes;
        let m = order + 1;
        let mut products = Vec::with_capacity(m * m * m);
        for x in &bx[..m] {
            for y in &by[..m] {
                let xy = x * y;
                products.extend(bz[..m].iter().map(|z| xy * z));
            }
        }
        Self { products }
    }

    /// The form's value; one without coefficients is zero.
    pub fn value(&self, form: &[f64]) -> f64 {
        pulp::Arch::new().dispatch(Dot(form, &self.products))
    }
}

/// Sum of products, as wide as the machine is.
struct Dot<'a>(&'a [f64], &'a [f64]);

impl WithSimd for Dot<'_> {
    type Output = f64;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> f64 {
        let (a, a_rest) = S::as_simd_f64s(self.0);
        let (b, b_rest) = S::as_simd_f64s(self.1);
        let mut sums = [simd.splat_f64s(0.0); 4];
        let (a4, a1) = pulp::as_arrays::<4, _>(a);
        let (b4, b1) = pulp::as_arrays::<4, _>(b);
        for (a, b) in a4.iter().zip(b4) {
            for (sum, (a, b)) in sums.iter_mut().zip(a.iter().zip(b)) {
                *sum = simd.mul_add_e_f64s(*a, *b, *sum);
            }
        }
        for (a, b) in a1.iter().zip(b1) {
            sums[0] = simd.mul_add_e_f64s(*a, *b, sums[0]);
        }
        let pair = |i: usize, j: usize| simd.add_f64s(sums[i], sums[j]);
        let sum = simd.reduce_sum_f64s(simd.add_f64s(pair(0, 1), pair(2, 3)));
        let rest = a_rest.iter().zip(b_rest);
        sum + rest.map(|(a, b)| a * b).sum::<f64>()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bernstein::{coefficient_count, products};
    use faer::Mat;

    #[test]
    fn a_form_is_the_product_with_its_matrix() {
        for order in [1, 2, 5] {
            let p = coefficient_count(order);
            let matrix =
                Mat::from_fn(p, p, |i, j| ((i * 7 + j * 13 + i * j) as f64 * 0.618).fract() - 0.4);
            let form = coefficients(order, matrix.as_ref());
            assert_eq!(form.len(), (2 * order + 1).pow(3));
            for unit in [[0.1, 0.6, 0.9], [0.0, 1.0, 0.5], [1.2, -0.1, 0.3]] {
                let unit = Vector3::from(unit);
                let b = products(order, &unit);
                let mut exact = 0.0;
                let mut size = 0.0;
                for i in 0..p {
                    for j in 0..p {
                        exact += b[i] * matrix[(i, j)] * b[j];
                        size += (b[i] * matrix[(i, j)] * b[j]).abs();
                    }
                }
                let found = FormBasis::new(2 * order, &unit).value(&form);
                assert!((found - exact).abs() < 1e-14 * size.max(1.0), "{found} {exact}");
            }
        }
    }
}
