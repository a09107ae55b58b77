//! Bernstein polynomials (2) on the unit interval and their products on the unit cube (3).

/// Highest order that a model may have: (n + 1)³ unknowns an orientation are 2,197 then, far
/// beyond what any table of measurements can answer.
pub const MAX_ORDER: usize = 12;

/// Number of coefficients of one value: `(n + 1)³`.
pub const fn coefficient_count(order: usize) -> usize {
    (order + 1).pow(3)
}

/// `n` over `k`, exact up to twice [`MAX_ORDER`].
pub(crate) fn binomial(n: usize, k: usize) -> f64 {
    (0..k).fold(1.0, |c, i| c * (n - i) as f64 / (i + 1) as f64)
}

/// `B_0..B_n` at `x`, in the first `order + 1` places.
///
/// By the triangle recurrence, which adds only terms of one sign inside the interval and so keeps
/// full relative accuracy there. Outside it is the same polynomial.
pub fn basis(order: usize, x: f64) -> [f64; MAX_ORDER + 1] {
    let mut b = [0.0; MAX_ORDER + 1];
    fill_basis(order, x, &mut b);
    b
}

/// As [`basis`], of any order.
#[inline]
pub(crate) fn fill_basis(order: usize, x: f64, b: &mut [f64]) {
    b[0] = 1.0;
    for n in 1..=order {
        let mut carried = 0.0;
        for value in &mut b[..n] {
            let old = *value;
            *value = carried + (1.0 - x) * old;
            carried = x * old;
        }
        b[n] = carried;
    }
}

/// `B_0..B_n` at `x` and their derivatives, `B_i' = n (B_{i-1} - B_i)` of one order less.
pub fn basis_with_slopes(order: usize, x: f64) -> ([f64; MAX_ORDER + 1], [f64; MAX_ORDER + 1]) {
    if order == 0 {
        return (basis(0, x), [0.0; MAX_ORDER + 1]);
    }
    let lower = basis(order - 1, x);
    let (mut values, mut slopes) = ([0.0; MAX_ORDER + 1], [0.0; MAX_ORDER + 1]);
    let n = order as f64;
    let mut before = 0.0;
    for i in 0..=order {
        // Past the end of the lower order's places stands a zero.
        let here = if i < order { lower[i] } else { 0.0 };
        values[i] = (1.0 - x) * here + x * before;
        slopes[i] = n * (before - here);
        before = here;
    }
    (values, slopes)
}

/// Where the coefficients of an order stand in the unit cube, i slowest: a function of order 1 has
/// its own values there as coefficients.
pub fn control_points(order: usize) -> impl Iterator<Item = [f64; 3]> {
    let n = order + 1;
    (0..n.pow(3)).map(move |index| {
        [index / (n * n), index / n % n, index % n].map(|i| i as f64 / order.max(1) as f64)
    })
}

/// All `B_i(x) B_j(y) B_k(z)`, i slowest.
pub fn products(order: usize, unit_position: &nalgebra::Vector3<f64>) -> Vec<f64> {
    let mut products = Vec::with_capacity(coefficient_count(order));
    push_products(order, unit_position, &mut products);
    products
}

/// All `B_i(x) B_j(y) B_k(z)`, i slowest, appended to `row`.
pub fn push_products(order: usize, unit_position: &nalgebra::Vector3<f64>, row: &mut Vec<f64>) {
    let [bx, by, bz] = [0, 1, 2].map(|k| basis(order, unit_position[k]));
    for x in &bx[..=order] {
        for y in &by[..=order] {
            for z in &bz[..=order] {
                row.push(x * y * z);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_and_slopes_are_those_of_the_definition() {
        for n in 0..=MAX_ORDER {
            for x in [-0.3, 0.0, 0.2, 0.5, 0.9, 1.0, 1.4_f64] {
                let (values, slopes) = basis_with_slopes(n, x);
                let own = basis(n, x);
                for (i, slope) in slopes[..=n].iter().enumerate() {
                    assert!((values[i] - own[i]).abs() <= 1e-15 * 2.0_f64.powi(n as i32));
                    let (up, down) = (i as f64, (n - i) as f64);
                    let power = |b: f64, e: f64| if e < 0.0 { 0.0 } else { b.powi(e as i32) };
                    let exact = binomial(n, i) * power(x, up) * power(1.0 - x, down);
                    assert!((own[i] - exact).abs() <= 1e-13 * exact.abs().max(1.0));
                    let exact = binomial(n, i)
                        * (up * power(x, up - 1.0) * power(1.0 - x, down)
                            - down * power(x, up) * power(1.0 - x, down - 1.0));
                    assert!((slope - exact).abs() <= 1e-12 * exact.abs().max(1.0));
                }
            }
        }
    }

    #[test]
    fn is_a_partition_of_unity() {
        for n in 0..=MAX_ORDER {
            for x in [0.0, 0.1, 0.37, 1.0] {
                let sum: f64 = basis(n, x)[..=n].iter().sum();
                assert!((sum - 1.0).abs() < 1e-15 * (n + 1) as f64);
            }
        }
    }

    #[test]
    fn products_add_to_one() {
        let row = products(4, &nalgebra::Vector3::new(0.1, 0.6, 0.9));
        assert_eq!(row.len(), coefficient_count(4));
        assert!((row.iter().sum::<f64>() - 1.0).abs() < 1e-14);
    }
}
