//! How fast the error can change at most, from the coefficients: what makes an inverse unique.
//!
//! A polynomial in Bernstein form lies in the convex hull of its coefficients, and so do its
//! derivatives: the largest norm over their coefficients bounds the slope everywhere in a box.

use crate::evaluation::Coefficient;
use crate::jacobian::weight_slopes;
use nalgebra::{Matrix3, Unit, Vector3};
use trackwright_geometry::directions::Weighting;

/// Bounds of the error's slopes.
///
/// If two poses read the same, their distances `Δp` and `θ` satisfy `Δp <= pp Δp + pn θ` and
/// `θ <= np Δp + nn θ`: rotations `exp(a)` and `exp(b)` are at most `|a - b|` apart. So where the
/// matrix of the four has a spectral radius below 1 there is only one pose, and stepping
/// `p = p_m - e_pos`, `n = exp(-e_ori) n_m` contracts to it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Slopes {
    /// `e_pos` by position, mm a mm.
    pub pp: f64,
    /// `e_pos` by axis, mm a radian.
    pub pn: f64,
    /// `e_ori` by position, radians a mm.
    pub np: f64,
    /// `e_ori` by axis, radians a radian.
    pub nn: f64,
}

impl Slopes {
    /// Bounds that hold in both places.
    pub fn max(self, other: Self) -> Self {
        Self {
            pp: self.pp.max(other.pp),
            pn: self.pn.max(other.pn),
            np: self.np.max(other.np),
            nn: self.nn.max(other.nn),
        }
    }

    /// Spectral radius of the four.
    pub fn contraction(&self) -> f64 {
        let half_difference = 0.5 * (self.pp - self.nn);
        0.5 * (self.pp + self.nn) + half_difference.hypot((self.pn * self.np).sqrt())
    }

    /// Bounds of the distances `Δp`, `θ` to the answer for what is left of the equations:
    /// `(1 - M)⁻¹` times it. Only where [`Self::contraction`] is below 1.
    pub fn reach(&self, remainder_mm: f64, remainder_rad: f64) -> [f64; 2] {
        let determinant = (1.0 - self.pp) * (1.0 - self.nn) - self.pn * self.np;
        [
            ((1.0 - self.nn) * remainder_mm + self.pn * remainder_rad) / determinant,
            (self.np * remainder_mm + (1.0 - self.pp) * remainder_rad) / determinant,
        ]
    }
}

/// Slopes by position of one orientation's polynomial, `[pp, np]`, over the box that its
/// coefficients belong to.
pub(super) fn by_position(net: &[Coefficient], order: usize, size_mm: &Vector3<f64>) -> [f64; 2] {
    let n = order + 1;
    let at = |i: usize, j: usize, k: usize| &net[(i * n + j) * n + k];
    let per_mm = size_mm.map(|s| if s > 0.0 { 1.0 / s } else { 0.0 });
    let mut largest = [Largest::default(), Largest::default()];
    for i in 0..n {
        for j in 0..n {
            for k in 0..n {
                // The derivative of order n - 1, raised to order n again, so that all three have
                // the same places: i (c_i - c_{i-1}) + (n - i) (c_{i+1} - c_i).
                let here = at(i, j, k);
                let sides = [
                    (i, at(i.max(1) - 1, j, k), at((i + 1).min(order), j, k)),
                    (j, at(i, j.max(1) - 1, k), at(i, (j + 1).min(order), k)),
                    (k, at(i, j, k.max(1) - 1), at(i, j, (k + 1).min(order))),
                ];
                for (half, largest) in largest.iter_mut().enumerate() {
                    let slope = Matrix3::from_fn(|row, column| {
                        let (index, before, after) = sides[column];
                        let c = 3 * half + row;
                        let below = index as f64 * (here[c] - before[c]);
                        let above = (order - index) as f64 * (after[c] - here[c]);
                        (below + above) * per_mm[column]
                    });
                    largest.see(&slope);
                }
            }
        }
    }
    largest.map(|l| l.0)
}

/// The largest spectral norm seen.
#[derive(Default)]
struct Largest(f64);

impl Largest {
    fn see(&mut self, matrix: &Matrix3<f64>) {
        // The Frobenius norm is cheap and never smaller.
        if matrix.norm() > self.0 {
            let largest = (matrix.transpose() * matrix).symmetric_eigenvalues().max();
            // Eigenvalues of a product carry its round-off, some epsilons of the norm.
            self.0 = self.0.max(largest.sqrt() * (1.0 + 1e-12));
        }
    }
}

/// Slopes by axis in a triangle, `[pn, nn]`, from the polynomials at its three corners:
/// `Σ e_k ∇w_k = Σ (e_k - e_r) ∇w_k` with any corner `r`, since weights add to 1.
pub(super) fn by_axis(nets: [&[Coefficient]; 3], steepest: &[f64; 3]) -> [f64; 2] {
    let apart = |a: usize, b: usize| largest_differences(nets[a], nets[b]);
    // Opposite corner 0, 1, 2.
    let edges = [apart(1, 2), apart(2, 0), apart(0, 1)];
    [0, 1].map(|half| {
        (0..3)
            .map(|r| {
                let (a, b) = ((r + 1) % 3, (r + 2) % 3);
                // The edge from r to a is opposite b.
                edges[b][half] * steepest[a] + edges[a][half] * steepest[b]
            })
            .fold(f64::INFINITY, f64::min)
    })
}

/// Largest distances between two polynomials' values, mm and radians.
pub(super) fn largest_differences(a: &[Coefficient], b: &[Coefficient]) -> [f64; 2] {
    let mut largest = [0.0_f64; 2];
    for (a, b) in a.iter().zip(b) {
        for (half, largest) in largest.iter_mut().enumerate() {
            let squared: f64 = (3 * half..3 * half + 3).map(|c| (a[c] - b[c]).powi(2)).sum();
            *largest = largest.max(squared);
        }
    }
    largest.map(f64::sqrt)
}

/// Steps along an edge of a triangle at which its weights' slopes are looked at. They are smooth
/// there: from one step to the next they change by less than [`BETWEEN_STEPS`].
const STEPS: usize = 24;

/// What a slope may exceed the largest one looked at by.
const BETWEEN_STEPS: f64 = 0.05;

/// The steepest that the three weights get in a triangle, per radian.
pub(super) fn steepest_weights(corners: &[Vector3<f64>; 3], weighting: Weighting) -> [f64; 3] {
    let mut steepest = [0.0_f64; 3];
    for axis in grid(corners) {
        for (s, slope) in steepest.iter_mut().zip(weight_slopes(corners, weighting, &axis)) {
            *s = s.max(slope.norm());
        }
    }
    steepest.map(|s| s * (1.0 + BETWEEN_STEPS))
}

/// Axes all over a triangle, its edges and corners too.
fn grid(corners: &[Vector3<f64>; 3]) -> impl Iterator<Item = Unit<Vector3<f64>>> {
    let [a, b, c] = *corners;
    (0..=STEPS).flat_map(move |i| {
        (0..=STEPS - i).map(move |j| {
            let (u, v) = (i as f64, j as f64);
            Unit::new_normalize(a * u + b * v + c * (STEPS as f64 - u - v))
        })
    })
}
