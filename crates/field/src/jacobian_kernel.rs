//! Value and three slopes of one orientation's polynomial, the six values side by side in a
//! vector.
//!
//! The innermost sum runs over k with one product for the value and one for the slope along z; the
//! sums along y and x are of lower order. Vectors of eight lanes hold a coefficient's six values
//! and the first two of the next, which are not looked at.

use super::bernstein::MAX_ORDER;
use super::model::Coefficient;
use pulp::{Simd, WithSimd};

/// A basis and its slopes along one axis.
pub(super) type BasisAndSlopes = ([f64; MAX_ORDER + 1], [f64; MAX_ORDER + 1]);

/// Lanes that are loaded for a coefficient.
const LOADED: usize = 8;

/// Value, and slopes by x, y, z in the unit cube; only the first six of each count.
pub(super) type Sums = [[f64; LOADED]; 4];

/// The work for up to three orientations.
pub(super) struct Contraction<'a> {
    pub order: usize,
    pub nets: [&'a [Coefficient]; 3],
    pub bases: &'a [BasisAndSlopes; 3],
    /// How many of the nets count.
    pub count: usize,
}

impl WithSimd for Contraction<'_> {
    type Output = [Sums; 3];

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> [Sums; 3] {
        let mut sums = [[[0.0; LOADED]; 4]; 3];
        for (net, sums) in self.nets.iter().zip(&mut sums).take(self.count) {
            // In vectors of one lane the last two would be for nothing.
            for vector in 0..6_usize.div_ceil(S::F64_LANES) {
                contract(simd, self.order + 1, net.as_flattened(), self.bases, vector, sums);
            }
        }
        sums
    }
}

/// The sums of one vector of each coefficient.
#[inline(always)]
fn contract<S: Simd>(
    simd: S,
    n: usize,
    net: &[f64],
    [bx, by, bz]: &[BasisAndSlopes; 3],
    vector: usize,
    sums: &mut Sums,
) {
    let zero = simd.splat_f64s(0.0);
    let (bx0, bx1) = (&bx.0[..n], &bx.1[..n]);
    let (by0, by1) = (&by.0[..n], &by.1[..n]);
    let (bz0, bz1) = (&bz.0[..n], &bz.1[..n]);
    let add = |factor: f64, value, sum| simd.mul_add_e_f64s(simd.splat_f64s(factor), value, sum);
    let mut total = [zero; 4];
    let mut at = 0;
    for (&x, &x_slope) in bx0.iter().zip(bx1) {
        let mut plane = [zero; 3];
        for (&y, &y_slope) in by0.iter().zip(by1) {
            let mut line = [zero; 2];
            for (&z, &z_slope) in bz0.iter().zip(bz1) {
                let c = load::<S>(net, at, vector);
                at += 6;
                line[0] = add(z, c, line[0]);
                line[1] = add(z_slope, c, line[1]);
            }
            plane[0] = add(y, line[0], plane[0]);
            plane[1] = add(y_slope, line[0], plane[1]);
            plane[2] = add(y, line[1], plane[2]);
        }
        total[0] = add(x, plane[0], total[0]);
        total[1] = add(x_slope, plane[0], total[1]);
        total[2] = add(x, plane[1], total[2]);
        total[3] = add(x, plane[2], total[3]);
    }
    for (sums, total) in sums.iter_mut().zip(total) {
        S::as_mut_simd_f64s(sums).0[vector] = total;
    }
}

/// One vector of the coefficient that starts at a place, and of what follows it.
#[inline(always)]
fn load<S: Simd>(net: &[f64], at: usize, vector: usize) -> S::f64s {
    match net.get(at..at + LOADED) {
        Some(loaded) => S::as_simd_f64s(loaded).0[vector],
        // Nothing follows the last.
        None => {
            let mut last = [0.0; LOADED];
            last[..6].copy_from_slice(&net[at..at + 6]);
            S::as_simd_f64s(&last).0[vector]
        }
    }
}
