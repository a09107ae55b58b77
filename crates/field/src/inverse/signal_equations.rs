//! The equations between a pose among metal and its reading, by the coils' signals, and Broyden's method for them.

use super::equations::AxisPose;
use super::signal_cells::{Cell, fields};
use crate::computed::DisturbedCoils;
use crate::generator::Generator;
use crate::generator::reading::{LEVER_MM, Orientation};
use nalgebra::{Matrix3, Matrix5, Point3, SMatrix, Unit, Vector3, Vector5};

/// Cells from whose middle the first step is longer than this, in their sizes, hold no solution.
pub(super) const FARTHEST: f64 = 2.0;

/// Readings change by no more than so many times the change of a pose, or Broyden's method has little hope.
const STEEPEST: f64 = 5.0;

/// Steps after which less than half has to be left, or differences of the fields make a new start, once.
const SLOW_STEPS: usize = 4;

/// Times that a step is made shorter.
const MOST_SHORTER: usize = 5;

/// Broyden's method ends farther from its start than so many cells.
const FAR_CELLS: f64 = 6.0;

/// Steps of Broyden's method, and what is left at a solution, mm. Newton makes it exact.
const MOST_STEPS: usize = 40;
const LEFT_MM: f64 = 1e-6;

/// Broyden's method ends nearer to a known answer than this part of a cell: it would only lead back there.
const LEADS_BACK: f64 = 0.05;

/// How far from a pose its reading's slopes and curvature are taken, mm.
const BESIDE_MM: f64 = 0.02;

/// Singular value of these slopes above which no other pose is looked for.
const WEAK: f64 = 0.8;

/// How far from a known pose another one beyond a fold may be.
const FARTHEST_TWIN_MM: f64 = 30.0;

/// What is the same of a reading for all poses that are tried.
pub(super) struct SignalEquations {
    /// `W`, a column a coil.
    weights: Vec<Vector5<f64>>,
    /// `W` times the signals of the reading.
    right: Vector5<f64>,
}

/// Where Broyden's method starts: a place, an axis, and the first step in mm and turns at a lever.
#[derive(Clone, Copy, Debug)]
pub(super) struct Start {
    from_mm: Point3<f64>,
    axis: Unit<Vector3<f64>>,
    inverse: Matrix5<f64>,
    rest: Vector5<f64>,
    pub step: Vector5<f64>,
}

impl Start {
    pub fn place_mm(&self) -> Point3<f64> {
        self.from_mm + self.step.fixed_rows::<3>(0)
    }
}

/// A pose moved in mm and turned at a lever.
fn moved(from: &AxisPose, by: &Vector5<f64>) -> AxisPose {
    let [first, second] = from.axis.rotation_axes();
    let axis = from.axis.as_ref() + (first * by[3] + second * by[4]) / LEVER_MM;
    AxisPose {
        position_mm: from.position_mm + by.fixed_rows::<3>(0),
        axis: Unit::new_normalize(axis),
    }
}

impl SignalEquations {
    pub fn new(generator: &Generator, reading: &AxisPose) -> Option<Self> {
        let (p, n) = (&reading.position_mm, reading.axis.as_ref());
        let tangents = reading.axis.rotation_axes();
        let rows: Vec<(f64, Vector5<f64>)> = generator
            .coils
            .iter()
            .map(|coil| {
                let (field, by_place) = coil.field_and_signal_gradient(p, n);
                // Both span what the axis can be turned to.
                let [a, b] = tangents.map(|tangent| tangent.dot(&field) / LEVER_MM);
                let row = Vector5::new(by_place.x, by_place.y, by_place.z, a, b);
                (field.dot(n), row)
            })
            .collect();
        let normal: Matrix5<f64> = rows.iter().map(|(_, row)| row * row.transpose()).sum();
        let inverse = normal.try_inverse()?;
        let weights: Vec<Vector5<f64>> = rows.iter().map(|(_, row)| inverse * row).collect();
        let right = weights.iter().zip(&rows).map(|(w, (signal, _))| w * *signal).sum();
        Some(Self { weights, right })
    }

    /// `W` times the fields: what it makes of each axis.
    fn of_axes(&self, fields: &[Vector3<f64>]) -> SMatrix<f64, 5, 3> {
        self.weights.iter().zip(fields).map(|(w, field)| w * field.transpose()).sum()
    }

    /// In a cell's middle: the best axis, and a step of Newton from there by the cell's slopes.
    pub fn start(&self, cell: &Cell) -> Option<Start> {
        let of_axes = self.of_axes(&cell.fields);
        let normal: Matrix3<f64> = of_axes.tr_mul(&of_axes);
        let best = normal.try_inverse()? * of_axes.tr_mul(&self.right);
        let axis = Unit::try_new(best, 1e-6)?;
        let rest = of_axes * axis.as_ref() - self.right;
        if rest.norm() > STEEPEST * FARTHEST * cell.size_mm {
            return None;
        }
        let [first, second] = axis.rotation_axes();
        let mut jacobian = Matrix5::zeros();
        for (weight, slope) in self.weights.iter().zip(&cell.slopes) {
            let by_place = slope.tr_mul(&axis);
            for k in 0..3 {
                jacobian.set_column(k, &(jacobian.column(k) + weight * by_place[k]));
            }
        }
        jacobian.set_column(3, &(of_axes * first / LEVER_MM));
        jacobian.set_column(4, &(of_axes * second / LEVER_MM));
        let inverse = jacobian.try_inverse()?;
        Some(Start { from_mm: cell.center_mm, axis, inverse, rest, step: -(inverse * rest) })
    }

    /// Readings turn back at a fold: a pose beside it has another one beyond, that reads the same. It is as far from the
    /// fold as the curvature along the weakest direction has it.
    pub fn twin(&self, coils: &dyn DisturbedCoils, known: &AxisPose) -> Option<AxisPose> {
        let left = |u: &Vector5<f64>| self.left(coils, &moved(known, u));
        let beside = |direction: &Vector5<f64>| {
            Some([left(&(direction * BESIDE_MM))?, left(&(direction * -BESIDE_MM))?])
        };
        let jacobian = self.jacobian(coils, known)?;
        let parts = jacobian.svd(true, true);
        let (k, weakest) = parts.singular_values.argmin();
        if weakest > WEAK {
            return None;
        }
        let along: Vector5<f64> = parts.v_t?.row(k).transpose();
        let of_rest: Vector5<f64> = parts.u?.column(k).into();
        let [ahead, back] = beside(&along)?;
        let bend = of_rest.dot(&(ahead + back - left(&Vector5::zeros())? * 2.0));
        let step = along * (-2.0 * weakest * BESIDE_MM * BESIDE_MM / bend);
        if step.norm().is_nan() || step.norm() > FARTHEST_TWIN_MM {
            return None;
        }
        let from = moved(known, &step);
        let rest = self.left(coils, &from)?;
        // Beyond the fold the slope is the opposite.
        let beyond = jacobian - of_rest * along.transpose() * (2.0 * weakest);
        let inverse = beyond.try_inverse()?;
        let start = Start {
            from_mm: from.position_mm,
            axis: from.axis,
            inverse,
            rest,
            step: -(inverse * rest),
        };
        self.solve(coils, start, FARTHEST_TWIN_MM, None)
    }

    /// By place and turns at a lever: differences of the fields, which turns need none of; nothing in metal.
    fn jacobian(&self, coils: &dyn DisturbedCoils, pose: &AxisPose) -> Option<Matrix5<f64>> {
        let at = |step: Vector3<f64>| {
            let fields = fields(coils, &(pose.position_mm + step))?;
            Some(self.of_axes(&fields) * pose.axis.as_ref())
        };
        let mut jacobian = Matrix5::zeros();
        for k in 0..3 {
            let step = Vector3::ith(k, BESIDE_MM);
            jacobian.set_column(k, &((at(step)? - at(-step)?) / (2.0 * BESIDE_MM)));
        }
        let of_axes = self.of_axes(&fields(coils, &pose.position_mm)?);
        for (k, turn) in pose.axis.rotation_axes().iter().enumerate() {
            jacobian.set_column(3 + k, &(of_axes * turn / LEVER_MM));
        }
        Some(jacobian)
    }

    /// What of the equations is left at a pose; nothing in metal.
    fn left(&self, coils: &dyn DisturbedCoils, pose: &AxisPose) -> Option<Vector5<f64>> {
        Some(self.of_axes(&fields(coils, &pose.position_mm)?) * pose.axis.as_ref() - self.right)
    }

    /// Broyden's method in a place and two turns at a lever, from a start in a cell; it ends where it leads back to a known
    /// answer.
    pub fn solve(
        &self,
        coils: &dyn DisturbedCoils,
        start: Start,
        size_mm: f64,
        known: Option<&AxisPose>,
    ) -> Option<AxisPose> {
        let Start { from_mm, axis, mut inverse, mut rest, .. } = start;
        let mut from = AxisPose { position_mm: from_mm, axis };
        let mut u = Vector5::zeros();
        let mut before = rest.norm();
        let mut is_renewed = false;
        for count in 0..MOST_STEPS {
            if rest.norm() < LEFT_MM {
                return Some(moved(&from, &u));
            }
            let mut step = -(inverse * rest);
            let longest = 2.0 * size_mm.max(5.0);
            step *= (longest / step.norm()).min(1.0);
            let left = |step: &Vector5<f64>| {
                let next = self.left(coils, &moved(&from, &(u + step)))?;
                (next.norm() < 2.0 * rest.norm()).then_some(next)
            };
            let mut next = left(&step);
            for _ in 0..MOST_SHORTER {
                if next.is_some() {
                    break;
                }
                step *= 0.3;
                next = left(&step);
            }
            if let Some(next) = next {
                // Sherman and Morrison.
                let change = inverse * (next - rest);
                let scale = step.dot(&change);
                if scale.abs() > 1e-12 * step.norm_squared() {
                    inverse += (step - change) * (step.transpose() * inverse) / scale;
                }
                u += step;
                rest = next;
            }
            let mut is_stuck = next.is_none();
            if count % SLOW_STEPS == SLOW_STEPS - 1 {
                is_stuck |= rest.norm() > 0.5 * before;
                before = rest.norm();
            }
            if is_stuck {
                if is_renewed {
                    return None;
                }
                is_renewed = true;
                from = moved(&from, &u);
                u = Vector5::zeros();
                inverse = self.jacobian(coils, &from)?.try_inverse()?;
            }
            let place_mm = from.position_mm + u.fixed_rows::<3>(0);
            let leads_back =
                |known: &AxisPose| (place_mm - known.position_mm).norm() < LEADS_BACK * size_mm;
            let is_far = (place_mm - from_mm).norm() > FAR_CELLS * size_mm.max(5.0);
            if is_far || known.is_some_and(leads_back) {
                return None;
            }
        }
        None
    }
}
