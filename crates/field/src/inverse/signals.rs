//! Poses behind a reading among metal, by what its coils measure.
//!
//! A tracker reports the pose `p, n` whose signals `n·B⁰(p)` in the empty room are nearest to those of the true pose
//! `x, m`. With the Jacobian `J` of the signals there, `W = (JᵀJ)⁻¹ Jᵀ`, each true pose satisfies
//! `W (m·B(x) − n·B⁰(p)) = 0`. These equations are linear in `m`: they are solved for it at places all over the
//! box, which are the nearer to each other the more the metal's field varies, and from the places where the least
//! is left Broyden's method goes on. So poses a few millimetres from metal are found as well.

use super::equations::AxisPose;
use crate::computed::DisturbedCoils;
use crate::generator::Generator;
use crate::generator::reading::{LEVER_MM, Orientation, axis_error};
use nalgebra::{Matrix3, Matrix5, Point3, Unit, Vector3, Vector5};
use rayon::prelude::*;
use trackwright_geometry::bounds::Bounds;
use trackwright_geometry::directions::DirectionSet;

// All of these were chosen in the built-in theatre, where they miss four poses in 105,000.

/// Cells along each side of the box before they are halved.
const CELLS: usize = 8;

/// Halvings of a cell: those of the tracker's cube are 1 mm wide then.
const MOST_HALVINGS: u32 = 6;

/// A cell is halved where the metal's field varies in it by more than this part of the coils' own, and half of it
/// by more than twice as much.
const VARIES: f64 = 0.01;

/// Poses of a cell may be read farther off than those in its middle, by this part of where these are read.
const BETWEEN: f64 = 1.0;

/// Places from which solutions are looked for, at most.
const MOST_STARTS: usize = 8;

/// Steps after which less than half has to be left.
const SLOW_STEPS: usize = 4;

/// Broyden's method ends farther from its start than so many cells.
const FAR_CELLS: f64 = 6.0;

/// Steps of Broyden's method, and what is left at a solution, mm. Newton makes it exact.
const MOST_STEPS: usize = 40;
const LEFT_MM: f64 = 1e-6;

/// Cells from whose middle the first step is longer than this, in their sizes, hold no solution.
const FARTHEST: f64 = 2.0;

/// Readings change by no more than so many times the change of a pose, or Broyden's method has little hope.
const STEEPEST: f64 = 5.0;

/// Starts nearer to each other than this part of their cells are one.
const SAME_START: f64 = 0.5;

/// Starts that lead nearer to a known answer than this part of a cell are no other ones.
const KNOWN: f64 = 0.25;

/// Where a pose changes by more than this times the change of its reading, another one may be nearer than cells are. (By
/// the norm of a matrix of five rows, which is 2.2 where readings change as poses do.)
const FOLDED: f64 = 6.0;

/// How far from a pose its reading's slopes and curvature are taken, mm, and how far another one may be.
const BESIDE_MM: f64 = 0.02;
const FARTHEST_TWIN_MM: f64 = 5.0;

/// A part of the box, and what the coils' fields are in its middle.
#[derive(Clone, Debug)]
struct Cell {
    center_mm: Point3<f64>,
    size_mm: f64,
    fields: Vec<Vector3<f64>>,
    /// How each of them changes, a mm.
    slopes: Vec<Matrix3<f64>>,
    /// Where poses here are read.
    readings: Bounds,
}

/// The fields of a room all over its box.
#[derive(Clone, Debug)]
pub(super) struct Signals {
    cells: Vec<Cell>,
}

/// What is the same of a reading for all poses that are tried.
struct Equations {
    /// `W`, a column a coil.
    weights: Vec<Vector5<f64>>,
    /// `W` times the signals of the reading.
    right: Vector5<f64>,
}

/// Where Broyden's method starts: a place, an axis, and the first step in mm and turns at a lever.
#[derive(Clone, Copy, Debug)]
struct Start {
    from_mm: Point3<f64>,
    axis: Unit<Vector3<f64>>,
    inverse: Matrix5<f64>,
    rest: Vector5<f64>,
    step: Vector5<f64>,
}

impl Start {
    fn place_mm(&self) -> Point3<f64> {
        self.from_mm + self.step.fixed_rows::<3>(0)
    }
}

impl Signals {
    pub fn of(coils: &dyn DisturbedCoils, bounds: &Bounds) -> Self {
        let size_mm = bounds.size_mm() / CELLS as f64;
        let cell = |index: usize| {
            let at = [index / (CELLS * CELLS), index / CELLS % CELLS, index % CELLS];
            let from_min = Vector3::from_fn(|k, _| (at[k] as f64 + 0.5) * size_mm[k]);
            let mut found = Vec::new();
            let center_mm = bounds.min_mm + from_min;
            let there = fields(coils, &center_mm);
            halve(coils, (center_mm, there), size_mm, MOST_HALVINGS, &mut found);
            found
        };
        let cells = (0..CELLS.pow(3)).into_par_iter().flat_map_iter(cell).collect();
        Self { cells }
    }

    /// Poses that the equations of a reading hold for; what is read there is to be looked at, as signals may have
    /// several nearest poses.
    pub fn solutions(
        &self,
        coils: &dyn DisturbedCoils,
        reading: &AxisPose,
        known: Option<&AxisPose>,
    ) -> Vec<AxisPose> {
        let Some(equations) = Equations::new(coils.generator(), reading) else { return Vec::new() };
        let mut near: Vec<(f64, &Cell, Start)> = Vec::new();
        // Of the starts that lead to the known pose; nothing where there are none.
        let mut folded: Option<f64> = None;
        for cell in &self.cells {
            if !cell.readings.contains(&reading.position_mm) {
                continue;
            }
            let Some(start) = equations.start(cell) else { continue };
            let cells = start.step.fixed_rows::<3>(0).norm() / cell.size_mm;
            let is_known = |known: &AxisPose| {
                (start.place_mm() - known.position_mm).norm() <= KNOWN * cell.size_mm
            };
            if known.is_some_and(is_known) {
                folded = Some(start.inverse.norm().max(folded.unwrap_or(0.0)));
            } else if cells <= FARTHEST {
                near.push((cells, cell, start));
            }
        }
        near.sort_by(|(a, ..), (b, ..)| a.total_cmp(b));
        let mut tried: Vec<(&Cell, Start)> = Vec::new();
        let mut found: Vec<AxisPose> = Vec::new();
        for (_, cell, start) in near {
            let place_mm = start.place_mm();
            let is_new = |(other, known): &(&Cell, Start)| {
                let apart_mm = (place_mm - known.place_mm()).norm();
                apart_mm > SAME_START * cell.size_mm.min(other.size_mm)
            };
            let is_other = |known: &AxisPose| {
                (place_mm - known.position_mm).norm() > SAME_START * cell.size_mm
            };
            if tried.len() == MOST_STARTS {
                break;
            }
            if tried.iter().all(is_new) && found.iter().all(is_other) {
                tried.push((cell, start));
                let Some((pose, slope)) = equations.solve(coils, start, cell.size_mm) else {
                    continue;
                };
                found.push(pose);
                if slope > FOLDED {
                    found.extend(equations.twin(coils, &pose));
                }
            }
        }
        if folded.is_none_or(|folded| folded > FOLDED) {
            found.extend(known.and_then(|known| equations.twin(coils, known)));
        }
        found
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

/// All fields at a place; nothing in metal.
fn fields(coils: &dyn DisturbedCoils, p: &Point3<f64>) -> Option<Vec<Vector3<f64>>> {
    let mut added = coils.disturbance(p)?;
    let own = coils.generator().own_fields(p);
    added.iter_mut().zip(own).for_each(|(added, own)| *added += own);
    Some(added)
}

fn apart(a: &[Vector3<f64>], b: &[Vector3<f64>]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).norm_squared()).sum::<f64>().sqrt()
}

/// A place and all fields there; none in metal.
type Place = (Point3<f64>, Option<Vec<Vector3<f64>>>);

/// A cell, or its halves where the metal's field varies too much.
fn halve(
    coils: &dyn DisturbedCoils,
    (center_mm, there): Place,
    size_mm: Vector3<f64>,
    halvings: u32,
    found: &mut Vec<Cell>,
) {
    let half = |index: usize| -> Place {
        let side = |k: usize| if index >> k & 1 == 1 { 0.25 } else { -0.25 };
        let from_center = Vector3::new(side(0), side(1), side(2)).component_mul(&size_mm);
        let place = center_mm + from_center;
        (place, fields(coils, &place))
    };
    // Four halves no two of which are neighbours: their middles are the corners of a tetrahedron.
    const CORNERS: [usize; 4] = [0, 3, 5, 6];
    let corners = CORNERS.map(half);
    let own = coils.generator().own_fields(&center_mm);
    let whole = own.iter().map(Vector3::norm_squared).sum::<f64>().sqrt();
    let varies = VARIES * f64::from(1 << (MOST_HALVINGS - halvings)) * whole;
    let added = |place: &Place| {
        let fields = place.1.as_ref()?;
        let own = coils.generator().own_fields(&place.0);
        Some(fields.iter().zip(own).map(|(field, own)| field - own).collect::<Vec<_>>())
    };
    let center = (center_mm, there);
    let of_center = added(&center);
    let differs = |corner: &Place| match (&of_center, added(corner)) {
        (Some(center), Some(corner)) => apart(center, &corner) > varies,
        (None, None) => false,
        _ => true,
    };
    if !corners.iter().any(differs) {
        if let Some(there) = center.1 {
            found.push(Cell::new(coils, center_mm, &size_mm, there, &corners));
        }
        return;
    }
    let others = [1, 2, 4, 7].map(half);
    if halvings > 1 {
        for place in corners.into_iter().chain(others) {
            halve(coils, place, size_mm / 2.0, halvings - 1, found);
        }
        return;
    }
    let all: Vec<Place> = corners.into_iter().chain(others).collect();
    for (place, fields) in &all {
        if let Some(fields) = fields {
            found.push(Cell::new(coils, *place, &(size_mm / 2.0), fields.clone(), &all));
        }
    }
}

impl Cell {
    /// `around` are places around its middle, or that of the cell that it is a half of.
    fn new(
        coils: &dyn DisturbedCoils,
        center_mm: Point3<f64>,
        size_mm: &Vector3<f64>,
        fields: Vec<Vector3<f64>>,
        around: &[Place],
    ) -> Self {
        let generator = coils.generator();
        let own = generator.own_fields(&center_mm);
        let added: Vec<_> = fields.iter().zip(own).map(|(field, own)| field - own).collect();
        // An axis turned round has the same error.
        let axes = DirectionSet::TwentySix.up_to_sign();
        let read = axes.filter_map(|axis| axis_error(generator, &center_mm, axis, &added).ok());
        let read_mm = read.map(|error| center_mm + error.position_mm);
        let middle = Bounds { min_mm: center_mm, max_mm: center_mm };
        let readings = Bounds::around(read_mm).map_or(middle, |read| {
            let more = read.size_mm() * BETWEEN + size_mm;
            Bounds { min_mm: read.min_mm - more, max_mm: read.max_mm + more }
        });
        let slopes = slopes(generator, &center_mm, &fields, around);
        Self { center_mm, size_mm: size_mm.max(), fields, slopes, readings }
    }
}

/// By least squares, from a place and others around it; those of the coils alone where metal leaves too few.
fn slopes(
    generator: &Generator,
    center_mm: &Point3<f64>,
    fields: &[Vector3<f64>],
    around: &[Place],
) -> Vec<Matrix3<f64>> {
    let steps =
        around.iter().filter_map(|(place, fields)| Some((place - center_mm, fields.as_ref()?)));
    let steps: Vec<_> = steps.collect();
    let squares: Matrix3<f64> = steps.iter().map(|(step, _)| step * step.transpose()).sum();
    let Some(inverse) = squares.try_inverse() else {
        let mut own = vec![(Vector3::zeros(), Matrix3::zeros()); fields.len()];
        generator.field_and_gradient(center_mm, &mut own);
        return own.into_iter().map(|(_, slope)| slope).collect();
    };
    let slope = |(coil, field): (usize, &Vector3<f64>)| {
        let each = steps.iter().map(|(step, there)| (there[coil] - field) * step.transpose());
        each.sum::<Matrix3<f64>>() * inverse
    };
    fields.iter().enumerate().map(slope).collect()
}

impl Equations {
    fn new(generator: &Generator, reading: &AxisPose) -> Option<Self> {
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
    fn of_axes(&self, fields: &[Vector3<f64>]) -> nalgebra::SMatrix<f64, 5, 3> {
        self.weights.iter().zip(fields).map(|(w, field)| w * field.transpose()).sum()
    }

    /// In a cell's middle: the best axis, and a step of Newton from there by the cell's slopes.
    fn start(&self, cell: &Cell) -> Option<Start> {
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
    fn twin(&self, coils: &dyn DisturbedCoils, known: &AxisPose) -> Option<AxisPose> {
        let left = |u: &Vector5<f64>| self.left(coils, &moved(known, u));
        let beside = |direction: &Vector5<f64>| {
            Some([left(&(direction * BESIDE_MM))?, left(&(direction * -BESIDE_MM))?])
        };
        let mut jacobian = Matrix5::zeros();
        for k in 0..5 {
            let [ahead, back] = beside(&Vector5::ith(k, 1.0))?;
            jacobian.set_column(k, &((ahead - back) / (2.0 * BESIDE_MM)));
        }
        let parts = jacobian.svd(true, true);
        let (k, weakest) = parts.singular_values.argmin();
        if weakest * FOLDED > 1.0 {
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
        let (twin, _) = self.solve(coils, start, FARTHEST_TWIN_MM)?;
        let apart_mm = (twin.position_mm - known.position_mm).norm();
        (apart_mm > 0.5 * step.norm()).then_some(twin)
    }

    /// What of the equations is left at a pose; nothing in metal.
    fn left(&self, coils: &dyn DisturbedCoils, pose: &AxisPose) -> Option<Vector5<f64>> {
        Some(self.of_axes(&fields(coils, &pose.position_mm)?) * pose.axis.as_ref() - self.right)
    }

    /// Broyden's method in a place and two turns at a lever, and how much more a pose changes there than its reading.
    fn solve(
        &self,
        coils: &dyn DisturbedCoils,
        start: Start,
        size_mm: f64,
    ) -> Option<(AxisPose, f64)> {
        let Start { from_mm, axis, mut inverse, mut rest, .. } = start;
        let from = AxisPose { position_mm: from_mm, axis };
        let left = |u: &Vector5<f64>| self.left(coils, &moved(&from, u));
        let mut u = Vector5::zeros();
        let mut before = rest.norm();
        for count in 0..MOST_STEPS {
            if rest.norm() < LEFT_MM {
                return Some((moved(&from, &u), inverse.norm()));
            }
            let mut step = -(inverse * rest);
            let longest = 2.0 * size_mm.max(5.0);
            step *= (longest / step.norm()).min(1.0);
            let mut next = left(&(u + step));
            for _ in 0..5 {
                if next.is_some_and(|next| next.norm() < 2.0 * rest.norm()) {
                    break;
                }
                step *= 0.3;
                next = left(&(u + step));
            }
            let next = next?;
            // Sherman and Morrison.
            let change = inverse * (next - rest);
            let scale = step.dot(&change);
            if scale.abs() > 1e-12 * step.norm_squared() {
                inverse += (step - change) * (step.transpose() * inverse) / scale;
            }
            u += step;
            rest = next;
            if count % SLOW_STEPS == SLOW_STEPS - 1 {
                if rest.norm() > 0.5 * before {
                    return None;
                }
                before = rest.norm();
            }
            if u.fixed_rows::<3>(0).norm() > FAR_CELLS * size_mm.max(5.0) {
                return None;
            }
        }
        None
    }
}
