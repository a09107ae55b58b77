//! What several sensors with one axis are reported at, by a generator of dipoles, in the lanes of the
//! machine's vectors: [`super::reading::read_axis`] for eight sensors at once.

use super::coils::{Coil, Generator, MAX_COILS};
use super::reading::{CONVERGED_MM, LEVER_MM, MAX_STEP_MM, MIN_INDEPENDENT_SQUARE};
use nalgebra::{SimdComplexField, SimdPartialOrd, SimdRealField, SimdValue, Vector3};
use simba::simd::AutoF64x8;

/// A number of each sensor.
pub type Lanes = AutoF64x8;

/// Sensors at once.
pub const LANES: usize = 8;

/// Sensors that need more steps than this are left to the plain form; nearly all need 4 to 6.
const MAX_STEPS: usize = 10;

type LaneVector = Vector3<Lanes>;

/// A coil of which nothing but place and moment is needed.
#[derive(Clone, Copy, Debug)]
pub struct LaneDipole {
    at_mm: Vector3<f64>,
    moment: Vector3<f64>,
}

/// Position and axis that each sensor is reported at.
#[derive(Clone, Copy, Debug)]
pub struct LaneReadings {
    pub position_mm: LaneVector,
    pub axis: LaneVector,
    /// The others are to be read by the plain form, which reports why there is no answer or finds
    /// it.
    pub is_found: [bool; LANES],
}

impl Generator {
    /// Its coils, where all of them are dipoles.
    pub fn lane_dipoles(&self) -> Option<Vec<LaneDipole>> {
        let each = self.coils.iter().map(|coil| match coil {
            Coil::Dipole { at_mm, moment } => {
                Some(LaneDipole { at_mm: at_mm.coords, moment: *moment })
            }
            Coil::SquareLoop { .. } => None,
        });
        each.collect()
    }
}

/// Reads all sensors; `disturbed` is what the room adds to each coil's signal.
///
/// # Panics
/// If `disturbed` has another length than the dipoles, or there are more than [`MAX_COILS`].
#[inline(always)]
pub fn read_axes(
    dipoles: &[LaneDipole],
    position_mm: &LaneVector,
    axis: &LaneVector,
    disturbed: &[Lanes],
) -> LaneReadings {
    assert_eq!(disturbed.len(), dipoles.len(), "one disturbance a coil");
    let mut measured = [Lanes::splat(0.0); MAX_COILS];
    let (mut p, mut n) = (*position_mm, *axis);
    let mut is_active = [true; LANES];
    let mut is_found = [false; LANES];
    for step in 0..MAX_STEPS {
        let rotation_axes = tangents(&n);
        let moves = rotation_axes.map(|turn| turn.cross(&n) / Lanes::splat(LEVER_MM));
        let mut normal = Normal::default();
        for (i, dipole) in dipoles.iter().enumerate() {
            let (signal, row) = dipole.signal_and_slopes(&p, &n, &moves);
            let residual = if step == 0 {
                measured[i] = signal + disturbed[i];
                disturbed[i]
            } else {
                measured[i] - signal
            };
            normal.add(&row, residual);
        }
        let (unknowns, is_regular) = normal.solve();
        let squares = unknowns.iter().map(|v| *v * *v);
        let length = squares.fold(Lanes::splat(0.0), |sum, v| sum + v).simd_sqrt();
        let limit = Lanes::splat(MAX_STEP_MM);
        let part = (limit / length).select(length.simd_gt(limit), Lanes::splat(1.0));
        let [x, y, z, a, b] = unknowns.map(|v| v * part);
        let moved = p + Vector3::new(x, y, z);
        let lever = Lanes::splat(LEVER_MM);
        let turned =
            rotated(&n, &(rotation_axes[0] * (a / lever) + rotation_axes[1] * (b / lever)));
        let active = simba::simd::AutoSimd(is_active);
        p = p.zip_map(&moved, |old, new| new.select(active, old));
        n = n.zip_map(&turned, |old, new| new.select(active, old));
        for k in 0..LANES {
            // A length that is no number ends a lane without an answer.
            let is_last = length.0[k] <= CONVERGED_MM;
            is_found[k] |= is_active[k] && is_regular[k] && is_last;
            is_active[k] &= is_regular[k] && length.0[k] > CONVERGED_MM;
        }
        if is_active == [false; LANES] {
            break;
        }
    }
    LaneReadings { position_mm: p, axis: n, is_found }
}

impl LaneDipole {
    /// What a coil measures, and its derivatives by position and by the two turns whose moves of the
    /// axis are given.
    #[inline(always)]
    fn signal_and_slopes(
        &self,
        p: &LaneVector,
        n: &LaneVector,
        moves: &[LaneVector; 2],
    ) -> (Lanes, [Lanes; 5]) {
        let m = self.moment.map(Lanes::splat);
        let r = p - self.at_mm.map(Lanes::splat);
        let inverse_square = Lanes::splat(1.0) / r.dot(&r);
        let cube = inverse_square * inverse_square.simd_sqrt();
        let three_fifth = Lanes::splat(3.0) * cube * inverse_square;
        let (mr, nr, mn) = (m.dot(&r), n.dot(&r), m.dot(n));
        let signal = three_fifth * mr * nr - mn * cube;
        let field = r * (three_fifth * mr) - m * cube;
        let along = mn - Lanes::splat(5.0) * mr * nr * inverse_square;
        let slope = (m * nr + n * mr + r * along) * three_fifth;
        let row = [slope.x, slope.y, slope.z, moves[0].dot(&field), moves[1].dot(&field)];
        (signal, row)
    }
}

/// Two unit vectors perpendicular to a unit vector and to each other (Duff et al., J. Computer Graphics
/// Techniques 6(1), 2017).
#[inline(always)]
fn tangents(n: &LaneVector) -> [LaneVector; 2] {
    let one = Lanes::splat(1.0);
    let sign = one.simd_copysign(n.z);
    let a = -one / (sign + n.z);
    let b = n.x * n.y * a;
    [
        Vector3::new(one + sign * n.x * n.x * a, sign * b, -sign * n.x),
        Vector3::new(b, sign + n.y * n.y * a, -n.y),
    ]
}

/// A unit vector after a rotation vector perpendicular to it, at most [`MAX_STEP_MM`] over [`LEVER_MM`]
/// long: the series of cosine and of sine over angle end below round-off there.
#[inline(always)]
fn rotated(n: &LaneVector, vector_rad: &LaneVector) -> LaneVector {
    let square = vector_rad.dot(vector_rad);
    let series = |first: u32| {
        // Σ (−s)^k / (2k + first)!, from the last term.
        let mut sum = Lanes::splat(1.0);
        for k in (1..=6).rev() {
            let next = f64::from((2 * k + first) * (2 * k + first - 1));
            sum = Lanes::splat(1.0) - sum * square / Lanes::splat(next);
        }
        sum
    };
    let turned = n * series(0) + vector_rad.cross(n) * series(1);
    turned / turned.dot(&turned).simd_sqrt()
}

/// Normal equations of one step, the lower triangle row by row.
struct Normal {
    matrix: [[Lanes; 5]; 5],
    right: [Lanes; 5],
}

impl Default for Normal {
    #[inline(always)]
    fn default() -> Self {
        Self { matrix: [[Lanes::splat(0.0); 5]; 5], right: [Lanes::splat(0.0); 5] }
    }
}

impl Normal {
    #[inline(always)]
    fn add(&mut self, row: &[Lanes; 5], residual: Lanes) {
        for i in 0..5 {
            for j in 0..=i {
                self.matrix[i][j] += row[i] * row[j];
            }
            self.right[i] += row[i] * residual;
        }
    }

    /// By Cholesky, and where the matrix is regular.
    #[inline(always)]
    #[expect(
        clippy::needless_range_loop,
        reason = "rows and columns of a triangle are clearest by their indices"
    )]
    fn solve(mut self) -> ([Lanes; 5], [bool; LANES]) {
        let (m, x) = (&mut self.matrix, &mut self.right);
        let mut is_regular = [true; LANES];
        for j in 0..5 {
            let whole = m[j][j];
            let mut left = whole;
            for k in 0..j {
                left -= m[j][k] * m[j][k];
            }
            for lane in 0..LANES {
                // False for what is no number.
                is_regular[lane] &= left.0[lane] > MIN_INDEPENDENT_SQUARE * whole.0[lane];
            }
            let inverse = Lanes::splat(1.0) / left.simd_sqrt();
            m[j][j] = inverse;
            for i in j + 1..5 {
                let mut sum = m[i][j];
                for k in 0..j {
                    sum -= m[i][k] * m[j][k];
                }
                m[i][j] = sum * inverse;
            }
        }
        for i in 0..5 {
            for k in 0..i {
                let known = x[k];
                x[i] -= m[i][k] * known;
            }
            x[i] *= m[i][i];
        }
        for i in (0..5).rev() {
            for k in i + 1..5 {
                let known = x[k];
                x[i] -= m[k][i] * known;
            }
            x[i] *= m[i][i];
        }
        (self.right, is_regular)
    }
}
