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
use trackwright_field::generator::{Coil, Generator};

/// Solid harmonics of degrees 1 to 3.
const HARMONICS: usize = 15;

/// Of each degree the first harmonic.
const FIRST: [usize; 5] = [0, 0, 3, 8, 15];

/// Entries of the dipole's tensor: xx, yy, zz, xy, xz, yz.
pub(super) const OF_TENSOR: usize = 6;

/// Entries of `T`: the tensor, and those of the next even order: quadrupoles by gradients, dipoles by second
/// gradients, and octupoles by the field.
pub(super) const OF_ALL: usize = OF_TENSOR + 15 + 21;

/// Points along a side of a square loop whose dipoles stand for it, and their weights (Gauss and Legendre).
const GAUSS: [(f64, f64); 4] = [
    (-0.861_136_311_594_052_6, 0.173_927_422_568_726_9),
    (-0.339_981_043_584_856_3, 0.326_072_577_431_273_1),
    (0.339_981_043_584_856_3, 0.326_072_577_431_273_1),
    (0.861_136_311_594_052_6, 0.173_927_422_568_726_9),
];

/// The entries of `T` that are unknown.
fn entries() -> impl Iterator<Item = (usize, usize)> {
    let tensor = [(0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)];
    let quadrupoles = (FIRST[2]..FIRST[3]).flat_map(|i| (FIRST[2]..=i).map(move |j| (i, j)));
    let octupoles = (FIRST[3]..FIRST[4]).flat_map(|i| (FIRST[1]..FIRST[2]).map(move |j| (i, j)));
    tensor.into_iter().chain(quadrupoles).chain(octupoles)
}

/// Slopes along `n` of irregular solid harmonics at `r`.
fn slopes_along(r: &Vector3<f64>, n: &Vector3<f64>) -> [f64; HARMONICS] {
    let (x, y, z) = (r.x, r.y, r.z);
    let (u, v, w) = (n.x, n.y, n.z);
    let (r2, along) = (r.norm_squared(), r.dot(n));
    let (s3, s6, s10, s15) = (3.0_f64.sqrt(), 6.0_f64.sqrt(), 10.0_f64.sqrt(), 15.0_f64.sqrt());
    // The value of each regular harmonic, and its slope along `n`.
    let harmonics: [(f64, f64); HARMONICS] = [
        (x, u),
        (y, v),
        (z, w),
        (0.5 * (3.0 * z * z - r2), 3.0 * z * w - along),
        (s3 * x * z, s3 * (u * z + x * w)),
        (s3 * y * z, s3 * (v * z + y * w)),
        (0.5 * s3 * (x * x - y * y), s3 * (x * u - y * v)),
        (s3 * x * y, s3 * (u * y + x * v)),
        (
            0.5 * z * (5.0 * z * z - 3.0 * r2),
            0.5 * (w * (15.0 * z * z - 3.0 * r2) - 6.0 * z * along),
        ),
        (
            0.25 * s6 * x * (5.0 * z * z - r2),
            0.25 * s6 * (u * (5.0 * z * z - r2) + x * (10.0 * z * w - 2.0 * along)),
        ),
        (
            0.25 * s6 * y * (5.0 * z * z - r2),
            0.25 * s6 * (v * (5.0 * z * z - r2) + y * (10.0 * z * w - 2.0 * along)),
        ),
        (
            0.5 * s15 * z * (x * x - y * y),
            0.5 * s15 * (w * (x * x - y * y) + 2.0 * z * (x * u - y * v)),
        ),
        (s15 * x * y * z, s15 * (u * y * z + x * v * z + x * y * w)),
        (
            0.25 * s10 * x * (x * x - 3.0 * y * y),
            0.75 * s10 * (u * (x * x - y * y) - 2.0 * x * y * v),
        ),
        (
            0.25 * s10 * y * (3.0 * x * x - y * y),
            0.75 * s10 * (v * (x * x - y * y) + 2.0 * x * y * u),
        ),
    ];
    std::array::from_fn(|i| {
        let degree = if i < FIRST[2] {
            1
        } else if i < FIRST[3] {
            2
        } else {
            3
        };
        let (value, slope) = harmonics[i];
        let odd = (2 * degree + 1) as f64;
        (slope - odd * value * along / r2) / r2.powf(0.5 * odd)
    })
}

/// A coil's field about a point, by regular solid harmonics.
fn incident(coil: &Coil, center_mm: &Point3<f64>) -> [f64; HARMONICS] {
    match coil {
        Coil::Dipole { at_mm, moment } => slopes_along(&(at_mm - center_mm), moment).map(|v| -v),
        Coil::SquareLoop { center_mm: middle, normal, .. } => {
            let mut sum = [0.0; HARMONICS];
            let Some([a, b, _, d]) = coil.corners_mm() else { return sum };
            for (s, s_weight) in GAUSS {
                for (t, t_weight) in GAUSS {
                    let at = middle + 0.5 * s * (b - a) + 0.5 * t * (d - a);
                    let along = slopes_along(&(at - center_mm), normal);
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
    let highest = if count > OF_TENSOR { HARMONICS } else { FIRST[2] };
    let dof = rows.dof;
    let blocks: Vec<Vec<f64>> = (0..rows.len())
        .into_par_iter()
        .with_min_len(64)
        .map(|m| {
            let mut block = vec![0.0; dof * count];
            let mut signals = vec![0.0; rows.signals()];
            let mut of_harmonics = [[0.0; 6]; HARMONICS];
            for (axis, n) in rows.axes(m).iter().enumerate() {
                let along = slopes_along(&(rows.positions_mm[m] - center_mm), n);
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
        let along = [0, 1, 2].map(|k| slopes_along(&(p - self.center_mm), &Vector3::ith(k, 1.0)));
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
        // 1/|p − x| = Σ R_j(x) I_j(p): its slope along n at p, without degrees above 3.
        let (p, n) = (Vector3::new(90.0, -70.0, 110.0), Vector3::new(0.3, 0.8, -0.5));
        let x = Vector3::new(0.4, -0.7, 0.5);
        let slope = |d: Vector3<f64>| -d.dot(&n) / d.norm().powi(3);
        let along = slopes_along(&p, &n);
        let (s3, s6, s10, s15) = (3.0_f64.sqrt(), 6.0_f64.sqrt(), 10.0_f64.sqrt(), 15.0_f64.sqrt());
        let r2 = x.norm_squared();
        let regular = [
            x.x,
            x.y,
            x.z,
            0.5 * (3.0 * x.z * x.z - r2),
            s3 * x.x * x.z,
            s3 * x.y * x.z,
            0.5 * s3 * (x.x * x.x - x.y * x.y),
            s3 * x.x * x.y,
            0.5 * x.z * (5.0 * x.z * x.z - 3.0 * r2),
            0.25 * s6 * x.x * (5.0 * x.z * x.z - r2),
            0.25 * s6 * x.y * (5.0 * x.z * x.z - r2),
            0.5 * s15 * x.z * (x.x * x.x - x.y * x.y),
            s15 * x.x * x.y * x.z,
            0.25 * s10 * x.x * (x.x * x.x - 3.0 * x.y * x.y),
            0.25 * s10 * x.y * (3.0 * x.x * x.x - x.y * x.y),
        ];
        let sum: f64 = regular.iter().zip(along).map(|(r, i)| r * i).sum();
        let expected = slope(p - x) - slope(p);
        // The next degree is a hundredth of a hundredth of a hundredth.
        assert!((sum / expected - 1.0).abs() < 1e-5, "{sum} {expected}");
    }

    #[test]
    fn a_loop_is_as_its_dipoles_are() {
        let generator = Generator::anser();
        let c = Point3::new(40.0, 150.0, -120.0);
        for coil in &generator.coils {
            let (field, gradient) = coil.field_and_gradient(&c);
            let found = incident(coil, &c);
            let size = field.norm();
            assert!((Vector3::new(found[0], found[1], found[2]) - field).norm() < 1e-5 * size);
            assert!((found[3] - 0.5 * gradient[(2, 2)]).abs() < 1e-6 * size);
            assert!((found[7] - gradient[(0, 1)] / 3.0_f64.sqrt()).abs() < 1e-6 * size);
        }
    }
}
