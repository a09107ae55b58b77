//! A body that is not a sphere, by multipoles about its middle: what each adds to the rows.
//!
//! About a middle `c` a coil's field is the gradient of `Σ α_j R_j`, regular solid harmonics in Schmidt's
//! normalisation; what the body adds is the gradient of `Σ β_i I_i`, `I_i = R_i/r^(2l+1)`, with `β = T α`. A sensor's
//! axis is to the body as a dipole is: the signal is `aᵀ T α`, `a_i` the slope of `I_i` along the axis, and as coil and
//! sensor may be exchanged, `T` is symmetric. Of a body that is its own mirror image through `c`, as plates, rods and
//! boxes are, only orders `l + l'` that are even are not zero: this is what makes `c` its middle.

use super::rows::Rows;
use nalgebra::{DMatrix, Matrix3, Point3, SymmetricEigen, Vector3};
use rayon::prelude::*;
use std::sync::LazyLock;
use trackwright_field::generator::{Coil, Generator};
use trackwright_field::harmonic::solid_harmonics::gradients as gradients_of;

/// Degrees of the solid harmonics.
const DEGREE: usize = 5;
const HARMONICS: usize = 35;

/// Of each degree the first harmonic.
const FIRST: [usize; 7] = [0, 0, 3, 8, 15, 24, 35];

/// Entries of the dipole's tensor: xx, yy, zz, xy, xz, yz.
pub(super) const OF_TENSOR: usize = 6;

/// With those of `l + l' = 4`: quadrupoles by gradients, octupoles by the field.
pub(super) const OF_NEXT: usize = OF_TENSOR + 15 + 21;

/// With those of `l + l' = 6` that matter beside sensors, which are nearer than coils: degree 5 by the field, degree 4 by
/// gradients.
pub(super) const OF_ALL: usize = OF_NEXT + 33 + 45;

/// Points along a side of a square loop whose dipoles stand for it, and their weights (Gauss and Legendre).
const GAUSS: [(f64, f64); 4] = [
    (-0.861_136_311_594_052_6, 0.173_927_422_568_726_9),
    (-0.339_981_043_584_856_3, 0.326_072_577_431_273_1),
    (0.339_981_043_584_856_3, 0.326_072_577_431_273_1),
    (0.861_136_311_594_052_6, 0.173_927_422_568_726_9),
];

/// The entries of `T` that are unknown.
fn entries() -> impl Iterator<Item = (usize, usize)> {
    // Harmonics of degree 1 are z, x, y.
    let tensor = [(1, 1), (2, 2), (0, 0), (1, 2), (0, 1), (0, 2)];
    let of = |degree: usize| FIRST[degree]..FIRST[degree + 1];
    let quadrupoles = of(2).flat_map(move |i| (FIRST[2]..=i).map(move |j| (i, j)));
    let of_field = |degree: usize| of(degree).flat_map(move |i| of(1).map(move |j| (i, j)));
    let of_gradient = of(4).flat_map(move |i| of(2).map(move |j| (i, j)));
    tensor.into_iter().chain(quadrupoles).chain(of_field(3)).chain(of_field(5)).chain(of_gradient)
}

/// The entries that answer a gradient with a quadrupole of the same kind.
pub(super) fn diagonal_quadrupoles() -> impl Iterator<Item = usize> {
    let is_own = |(_, (i, j)): &(usize, (usize, usize))| i == j && *i >= FIRST[2];
    entries().enumerate().filter(is_own).map(|(k, _)| k)
}

/// The degree of each harmonic, and what it has in Schmidt's normalisation.
static SCALES: LazyLock<[(usize, f64); HARMONICS]> = LazyLock::new(|| {
    let mut scales = Vec::with_capacity(HARMONICS);
    for degree in 1..=DEGREE {
        for m in 0..=degree {
            let factorial = |n: usize| (1..=n).product::<usize>() as f64;
            let odd: f64 = (0..m).map(|k| (2 * k + 1) as f64).product();
            let twice = if m == 0 { 1.0 } else { 2.0 };
            let scale = odd * (twice * factorial(degree - m) / factorial(degree + m)).sqrt();
            scales.extend(vec![(degree, scale); if m == 0 { 1 } else { 2 }]);
        }
    }
    std::array::from_fn(|k| scales[k])
});

/// Slopes along `n` of irregular solid harmonics at `r`.
fn slopes_along(r: &Vector3<f64>, n: &Vector3<f64>, degree: usize) -> [f64; HARMONICS] {
    let mut gradients = [Vector3::zeros(); HARMONICS];
    let count = FIRST[degree + 1];
    gradients_of(degree, r, &mut gradients[..count]);
    let (r2, along) = (r.norm_squared(), r.dot(n));
    let odd_power = [1, 2, 3, 4, 5].map(|l| r2.sqrt().powi(-2 * l - 1));
    let mut slopes = [0.0; HARMONICS];
    for (k, slope) in slopes.iter_mut().enumerate().take(count) {
        let (l, scale) = SCALES[k];
        // A harmonic of degree l is a polynomial of that degree: l times it is r along its gradient.
        let value = gradients[k].dot(r) / l as f64;
        let own = gradients[k].dot(n) - (2 * l + 1) as f64 * value * along / r2;
        *slope = scale * own * odd_power[l - 1];
    }
    slopes
}

/// A coil's field about a point, by regular solid harmonics.
fn incident(coil: &Coil, center_mm: &Point3<f64>) -> [f64; HARMONICS] {
    match coil {
        Coil::Dipole { at_mm, moment } => {
            slopes_along(&(at_mm - center_mm), moment, DEGREE).map(|v| -v)
        }
        Coil::SquareLoop { center_mm: middle, normal, .. } => {
            let mut sum = [0.0; HARMONICS];
            let Some([a, b, _, d]) = coil.corners_mm() else { return sum };
            for (s, s_weight) in GAUSS {
                for (t, t_weight) in GAUSS {
                    let at = middle + 0.5 * s * (b - a) + 0.5 * t * (d - a);
                    let along = slopes_along(&(at - center_mm), normal, DEGREE);
                    for (sum, value) in sum.iter_mut().zip(along) {
                        *sum -= s_weight * t_weight * value;
                    }
                }
            }
            sum
        }
    }
}

/// What each of the first `count` entries of `T` adds to the rows, a column each: of the dipole's tensor with the
/// sign of a strength.
pub(super) fn columns(rows: &Rows, center_mm: &Point3<f64>, count: usize) -> DMatrix<f64> {
    let coils = rows.generator.coils.len();
    let incident: Vec<_> = rows.generator.coils.iter().map(|c| incident(c, center_mm)).collect();
    let entries: Vec<(usize, usize)> = entries().take(count).collect();
    let degree = if count > OF_NEXT {
        DEGREE
    } else if count > OF_TENSOR {
        3
    } else {
        1
    };
    let highest = FIRST[degree + 1];
    let dof = rows.dof;
    let blocks: Vec<Vec<f64>> = (0..rows.len())
        .into_par_iter()
        .with_min_len(64)
        .map(|m| {
            let mut block = vec![0.0; dof * count];
            let mut signals = vec![0.0; rows.signals()];
            let mut of_harmonics = [[0.0; 6]; HARMONICS];
            for (axis, n) in rows.axes(m).iter().enumerate() {
                let along = slopes_along(&(rows.positions_mm[m] - center_mm), n, degree);
                for (j, of_harmonic) in of_harmonics.iter_mut().enumerate().take(highest) {
                    signals.fill(0.0);
                    for (coil, incident) in incident.iter().enumerate() {
                        signals[axis * coils + coil] = incident[j];
                    }
                    rows.map(m, &signals, &mut of_harmonic[..dof]);
                }
                for (k, &(i, j)) in entries.iter().enumerate() {
                    let sign = if k < OF_TENSOR { -1.0 } else { 1.0 };
                    for row in 0..dof {
                        let mut value = along[i] * of_harmonics[j][row];
                        if i != j {
                            value += along[j] * of_harmonics[i][row];
                        }
                        block[k * dof + row] += sign * value;
                    }
                }
            }
            block
        })
        .collect();
    DMatrix::from_fn(rows.right.len(), count, |i, k| blocks[i / dof][k * dof + i % dof])
}

/// What a body adds to the field of each coil.
pub(super) struct MultipoleField {
    center_mm: Point3<f64>,
    /// `T α` of each coil.
    answers: Vec<[f64; HARMONICS]>,
}

impl MultipoleField {
    /// Of entries of `T`.
    pub fn new(generator: &Generator, center_mm: &Point3<f64>, values: &[f64]) -> Self {
        let answer = |coil: &Coil| {
            let incident = incident(coil, center_mm);
            let mut answer = [0.0; HARMONICS];
            for (k, ((i, j), value)) in entries().zip(values).enumerate() {
                let value = if k < OF_TENSOR { -value } else { *value };
                answer[i] += value * incident[j];
                if i != j {
                    answer[j] += value * incident[i];
                }
            }
            answer
        };
        Self { center_mm: *center_mm, answers: generator.coils.iter().map(answer).collect() }
    }

    pub fn add(&self, p: &Point3<f64>, fields: &mut [Vector3<f64>]) {
        let along =
            [0, 1, 2].map(|k| slopes_along(&(p - self.center_mm), &Vector3::ith(k, 1.0), DEGREE));
        for (field, answer) in fields.iter_mut().zip(&self.answers) {
            for (k, along) in along.iter().enumerate() {
                field[k] += along.iter().zip(answer).map(|(a, b)| a * b).sum::<f64>();
            }
        }
    }
}

/// The dipole's tensor of entries.
pub(super) fn tensor(entries: &[f64]) -> Matrix3<f64> {
    let [xx, yy, zz, xy, xz, yz] = entries[..OF_TENSOR] else { return Matrix3::zeros() };
    Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz)
}

/// Largest strength of a tensor along any axis.
pub(super) fn largest(entries: &[f64]) -> f64 {
    SymmetricEigen::new(tensor(entries)).eigenvalues.amax()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn harmonics_add_up_to_a_dipole() {
        // 1/|p − x| = Σ R_j(x) I_j(p): its slope along n at p, without degrees above 5.
        let (p, n) = (Vector3::new(90.0, -70.0, 110.0), Vector3::new(0.3, 0.8, -0.5));
        let x = Vector3::new(8.0, -14.0, 10.0);
        let slope = |d: Vector3<f64>| -d.dot(&n) / d.norm().powi(3);
        let mut gradients = [Vector3::zeros(); HARMONICS];
        gradients_of(DEGREE, &x, &mut gradients);
        let regular = |k: usize| SCALES[k].1 * gradients[k].dot(&x) / SCALES[k].0 as f64;
        let along = slopes_along(&p, &n, DEGREE);
        let sum: f64 = along.iter().enumerate().map(|(k, slope)| regular(k) * slope).sum();
        let expected = slope(p - x) - slope(p);
        // The next degree is a tenth to the fifth of the first.
        assert!((sum / expected - 1.0).abs() < 1e-4, "{sum} {expected}");
    }

    #[test]
    fn a_loop_is_as_its_dipoles_are() {
        let generator = Generator::anser();
        let c = Point3::new(40.0, 150.0, -120.0);
        for coil in &generator.coils {
            let (field, gradient) = coil.field_and_gradient(&c);
            let found = incident(coil, &c);
            let size = field.norm();
            assert!((Vector3::new(found[1], found[2], found[0]) - field).norm() < 1e-5 * size);
            assert!((found[3] - 0.5 * gradient[(2, 2)]).abs() < 1e-6 * size);
            assert!((found[7] - gradient[(0, 1)] / 3.0_f64.sqrt()).abs() < 1e-6 * size);
        }
    }
}
