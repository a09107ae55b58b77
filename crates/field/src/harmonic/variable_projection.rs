//! Effective dipoles of a generator that is not known: variable projection by Levenberg–Marquardt.
//!
//! For each generator the harmonics' coefficients are solved exactly; what is left depends on the
//! coils' positions and directions alone. Its derivative at fixed coefficients, projected off what
//! the coefficients can follow (Kaufman, BIT 15, 1975), is the Jacobian (Golub & Pereyra, Inverse
//! Problems 19, 2003).

use super::fit::huber_weights;
use super::normal::{Scaling, Solved, System};
use super::rows::{Harmonics, Maps, SolveError, axis_of};
use crate::generator::dipole::Dipole;
use crate::generator::reading::{LEVER_MM, Orientation};
use crate::generator::{Coil, Generator};
use crate::samples::{Measurement, MeasurementContent};
use faer::linalg::solvers::Solve;
use faer::{Mat, Side};
use nalgebra::{Point3, Unit, UnitQuaternion, Vector3};
use rayon::prelude::*;
use trackwright_geometry::rotation::{axis_rotation, exp_vector, perpendicular};
use trackwright_task::{Cancelled, Task};

/// Unknowns of a coil: its position in units of [`PRIOR_LENGTH_MM`], then two rotations of its
/// moment in rad.
const OF_COIL: usize = 5;

/// The prior holds a coil to where it starts, 1 for this length or a radian …
const PRIOR_LENGTH_MM: f64 = 100.0;

/// … times this, in the mm of the rows: far weaker than the noise of a room's measurements.
const PRIOR_WEIGHT: f64 = 0.02;

/// Damping at first, relative to the diagonal, and what it is multiplied by.
const FIRST_DAMPING: f64 = 1e-2;
const LESS_DAMPING: f64 = 0.2;
const MORE_DAMPING: f64 = 4.0;

/// Where more damping is tried no longer.
const MAX_DAMPING: f64 = 1e6;

/// Relative decrease of the sum of squares below which no further step is made.
const SETTLED: f64 = 3e-4;

/// Steps in a row that bring less than that.
const SETTLED_STEPS: usize = 3;

/// Unit dipoles in the tracker frame.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Dipoles(pub(super) Vec<(Point3<f64>, Unit<Vector3<f64>>)>);

impl Dipoles {
    pub(super) fn generator(&self, name: &str) -> Generator {
        let coils = self.0.iter();
        Generator {
            name: name.to_owned(),
            coils: coils
                .map(|(at_mm, moment)| Coil::Dipole { at_mm: *at_mm, moment: moment.into_inner() })
                .collect(),
        }
    }

    /// The dipoles of a generator; `None` where it has other coils.
    pub(super) fn of(generator: &Generator) -> Option<Self> {
        let dipole = |coil: &Coil| match coil {
            Coil::Dipole { at_mm, moment } => Some((*at_mm, Unit::new_normalize(*moment))),
            _ => None,
        };
        generator.coils.iter().map(dipole).collect::<Option<_>>().map(Self)
    }

    fn moved(&self, step: &[f64]) -> Self {
        let coils = self.0.iter().zip(step.chunks_exact(OF_COIL));
        Self(
            coils
                .map(|((at, moment), step)| {
                    let shift = Vector3::new(step[0], step[1], step[2]) * PRIOR_LENGTH_MM;
                    let [a, b] = tangents(moment);
                    let turn = moment.cross(&(a * step[3] + b * step[4]));
                    let turned = exp_vector(&turn) * moment.into_inner();
                    (at + shift, Unit::new_normalize(turned))
                })
                .collect(),
        )
    }

    /// How far each unknown is from its start, in the prior's units.
    fn displacement_from(&self, start: &Self) -> Vec<f64> {
        let coils = self.0.iter().zip(&start.0);
        coils
            .flat_map(|((at, moment), (start_at, start_moment))| {
                let shift = (at - start_at) / PRIOR_LENGTH_MM;
                // Along the tangents at the moment, away from its start.
                let turn = axis_rotation(start_moment, moment).vector_rad;
                let away = turn.cross(moment);
                let [a, b] = tangents(moment);
                [shift.x, shift.y, shift.z, away.dot(&a), away.dot(&b)]
            })
            .collect()
    }
}

fn tangents(axis: &Unit<Vector3<f64>>) -> [Vector3<f64>; 2] {
    let a = perpendicular(axis).into_inner();
    [a, axis.cross(&a)]
}

/// The measurements that a generator is learned from.
pub(super) struct Problem<'a> {
    pub(super) measurements: &'a [Measurement],
    pub(super) content: MeasurementContent,
    pub(super) harmonics: &'a Harmonics,
    pub(super) ridge: f64,
    pub(super) start: Dipoles,
}

/// Where Levenberg–Marquardt ended.
pub(super) struct Learned {
    pub(super) dipoles: Dipoles,
    pub(super) steps: usize,
    pub(super) has_converged: bool,
}

/// A generator with the coefficients that are best for it.
struct State {
    dipoles: Dipoles,
    maps: Maps,
    scaling: Scaling,
    solved: Solved,
    residuals: Vec<f64>,
    cost: f64,
}

impl Problem<'_> {
    /// At most `max_steps` steps from `from`; measurements are weighted anew after each.
    pub(super) fn learn(
        &self,
        task: &Task,
        from: &Dipoles,
        max_steps: usize,
    ) -> Result<Learned, SolveError> {
        let quiet = Task::cancelled_by(task.cancel.clone());
        let mut weights = vec![1.0; self.measurements.len()];
        let mut state = self.state(&quiet, from.clone(), &weights)?;
        let (mut damping, mut settled, mut steps) = (FIRST_DAMPING, 0, 0);
        while steps < max_steps && settled < SETTLED_STEPS {
            task.step(steps, max_steps)?;
            steps += 1;
            weights = huber_weights(&state.residuals, state.maps.dof);
            state = self.state(&quiet, state.dipoles, &weights)?;
            let (matrix, slope) = self.equations(&state, &weights);
            let next = loop {
                let next = self.step(&quiet, &state, &weights, (&matrix, &slope), damping);
                match next {
                    Ok(Some(next)) => break Some(next),
                    Ok(None) => damping *= MORE_DAMPING,
                    Err(cancelled) => return Err(cancelled.into()),
                }
                if damping > MAX_DAMPING {
                    break None;
                }
            };
            let Some(next) = next else {
                settled = SETTLED_STEPS;
                break;
            };
            damping = (damping * LESS_DAMPING).max(1e-12);
            if state.cost - next.cost < SETTLED * state.cost {
                settled += 1;
            } else {
                settled = 0;
            }
            state = next;
        }
        Ok(Learned { dipoles: state.dipoles, steps, has_converged: settled >= SETTLED_STEPS })
    }

    /// A step with a damping; `None` where it is no better, or no generator that can be read.
    fn step(
        &self,
        task: &Task,
        state: &State,
        weights: &[f64],
        (matrix, slope): (&Mat<f64>, &[f64]),
        damping: f64,
    ) -> Result<Option<State>, Cancelled> {
        let mut damped = matrix.clone();
        for k in 0..slope.len() {
            damped[(k, k)] *= 1.0 + damping;
        }
        let Ok(factor) = damped.llt(Side::Lower) else {
            return Ok(None);
        };
        let step = factor.solve(&Mat::from_fn(slope.len(), 1, |k, _| -slope[k]));
        let step: Vec<_> = (0..slope.len()).map(|k| step[(k, 0)]).collect();
        if !step.iter().all(|v| v.is_finite()) {
            return Ok(None);
        }
        match self.state(task, state.dipoles.moved(&step), weights) {
            Ok(next) => Ok((next.cost < state.cost).then_some(next)),
            Err(SolveError::Cancelled) => Err(Cancelled),
            Err(_) => Ok(None),
        }
    }

    fn state(&self, task: &Task, dipoles: Dipoles, weights: &[f64]) -> Result<State, SolveError> {
        let generator = dipoles.generator("");
        let maps = Maps::new(task, &generator, self.measurements, self.content)?;
        let system = self.system(&maps);
        let gram = system.gram(task, weights)?;
        let scaling = Scaling::new(&gram, self.ridge)?;
        let solved = system.solve(&gram, weights, &scaling)?;
        let residuals = system.residuals(&solved.coefficients);
        let squares: f64 = residuals
            .chunks_exact(maps.dof)
            .zip(weights)
            .map(|(r, w)| w * r.iter().map(|v| v * v).sum::<f64>())
            .sum();
        let prior: f64 = dipoles.displacement_from(&self.start).iter().map(|v| v * v).sum();
        Ok(State {
            cost: squares + solved.penalty + PRIOR_WEIGHT * PRIOR_WEIGHT * prior,
            dipoles,
            scaling,
            solved,
            residuals,
            maps,
        })
    }

    fn system<'m>(&self, maps: &'m Maps) -> System<'m> {
        let all = (0..self.measurements.len()).collect();
        System::new(self.harmonics, maps, self.harmonics.terms, all)
    }

    /// Half the Hessian of the cost (Gauss–Newton) and half its gradient.
    fn equations(&self, state: &State, weights: &[f64]) -> (Mat<f64>, Vec<f64>) {
        let system = self.system(&state.maps);
        let dof = state.maps.dof;
        let slopes = self.slopes(state, &system);
        let unknowns = slopes.ncols();
        let columns: Vec<_> = (0..unknowns)
            .into_par_iter()
            .map(|column| {
                let column = slopes.col_as_slice(column);
                system.adjoint(column, weights)
            })
            .collect();
        let norms = &state.scaling.norms;
        let mut followed =
            Mat::from_fn(norms.len(), unknowns, |k, column| columns[column][k] / norms[k]);
        state.solved.factor.solve_lower_triangular_in_place(followed.as_mut());
        let weighted = Mat::from_fn(slopes.nrows(), unknowns, |row, column| {
            slopes[(row, column)] * weights[row / dof]
        });
        let mut matrix = slopes.transpose() * &weighted - followed.transpose() * &followed;
        let displacements = state.dipoles.displacement_from(&self.start);
        let weight = PRIOR_WEIGHT * PRIOR_WEIGHT;
        let mut slope = Vec::with_capacity(unknowns);
        for (k, displacement) in displacements.iter().enumerate() {
            matrix[(k, k)] += weight;
            let column = weighted.col_as_slice(k);
            let along: f64 = column.iter().zip(&state.residuals).map(|(a, b)| a * b).sum();
            slope.push(along + weight * displacement);
        }
        (matrix, slope)
    }

    /// Derivatives of the rows' residuals at fixed coefficients, an unknown a column.
    fn slopes(&self, state: &State, system: &System<'_>) -> Mat<f64> {
        let dof = state.maps.dof;
        let unknowns = OF_COIL * state.maps.coils;
        let parts: Vec<_> = (0..self.measurements.len())
            .into_par_iter()
            .map(|m| {
                if state.maps.axes == 3 {
                    let orientation = |pose: &trackwright_geometry::pose::Pose| pose.rotation;
                    self.slopes_of::<3, 3, 6, UnitQuaternion<f64>>(state, system, m, orientation)
                } else {
                    self.slopes_of::<1, 2, 5, Unit<Vector3<f64>>>(state, system, m, axis_of)
                }
            })
            .collect();
        Mat::from_fn(parts.len() * dof, unknowns, |row, column| {
            parts[row / dof][column * dof + row % dof]
        })
    }

    /// The rows of one measurement, an unknown after another.
    ///
    /// With `v` the signals that are not explained by coefficients, `ρ = W v` and `W = R⁻¹ Qᵀ`:
    /// `dρ = W (dv − dJ ρ) + (W Wᵀ) dJᵀ (v − J ρ)`, where only a coil's own signals change.
    fn slopes_of<const AXES: usize, const ROTATIONS: usize, const UNKNOWNS: usize, O>(
        &self,
        state: &State,
        system: &System<'_>,
        m: usize,
        orientation: impl Fn(&trackwright_geometry::pose::Pose) -> O,
    ) -> Vec<f64>
    where
        O: Orientation<AXES, ROTATIONS>,
    {
        let maps = system.maps();
        let coils = maps.coils;
        let terms = self.harmonics.terms;
        let map = maps.map(m);
        let w =
            |row: usize, axis: usize, coil: usize| map[row * maps.signals() + axis * coils + coil];
        let residual = &state.residuals[m * UNKNOWNS..][..UNKNOWNS];
        let mut square = [[0.0; UNKNOWNS]; UNKNOWNS];
        for (i, row) in square.iter_mut().enumerate() {
            for (j, entry) in row.iter_mut().enumerate() {
                let [a, b] = [i, j].map(|row| &map[row * maps.signals()..][..maps.signals()]);
                *entry = a.iter().zip(b).map(|(a, b)| a * b).sum();
            }
        }
        let Measurement { tracker_from_ideal: ideal, tracker_from_measured: measured } =
            &self.measurements[m];
        let [p, q] = [ideal, measured].map(|pose| Point3::from(pose.translation.vector));
        let axes_at_p = orientation(ideal).axes();
        let at_q = orientation(measured);
        let (axes_at_q, turns) = (at_q.axes(), at_q.rotation_axes());
        let mut out = Vec::with_capacity(OF_COIL * coils * UNKNOWNS);
        for (coil, (at, moment)) in state.dipoles.0.iter().enumerate() {
            let dipole = Dipole::new(at, moment);
            let coefficients = &state.solved.coefficients[coil * terms..][..terms];
            let turned = tangents(moment).map(|tangent| Dipole::new(at, &tangent));
            let mut slopes = [[0.0; UNKNOWNS]; OF_COIL];
            for axis in 0..AXES {
                let (n, nq) = (axes_at_p[axis], axes_at_q[axis]);
                let moves = turns.map(|turn| turn.cross(&nq) / LEVER_MM);
                // A row of J of a dipole.
                let row_of = |dipole: &Dipole, field: &Vector3<f64>| {
                    let mut row = [0.0; UNKNOWNS];
                    row[..3].copy_from_slice(dipole.signal_gradient(&q, &nq).as_slice());
                    for (entry, moved) in row[3..].iter_mut().zip(&moves) {
                        *entry = moved.dot(field);
                    }
                    row
                };
                let field = dipole.field(&q);
                let row = row_of(&dipole, &field);
                let harmonic: f64 = coefficients
                    .iter()
                    .enumerate()
                    .map(|(k, a)| a * system.slopes()[axis][(m, k)])
                    .sum();
                let unexplained =
                    nq.dot(&field) - n.dot(&dipole.field(&p)) - harmonic - inner(&row, residual);
                let mut add = |unknown: usize, dv: f64, dj: &[f64; UNKNOWNS]| {
                    let changed = dv - inner(dj, residual);
                    for (i, slope) in slopes[unknown].iter_mut().enumerate() {
                        *slope += w(i, axis, coil) * changed + inner(&square[i], dj) * unexplained;
                    }
                };
                let moved = dipole.signal_gradient(&p, &n) - Vector3::new(row[0], row[1], row[2]);
                let hessian = dipole.signal_hessian(&q, &nq);
                let of_moves = moves.map(|u| dipole.signal_gradient(&q, &u));
                for k in 0..3 {
                    let mut dj = [0.0; UNKNOWNS];
                    for j in 0..3 {
                        dj[j] = -hessian[(j, k)] * PRIOR_LENGTH_MM;
                    }
                    for (entry, slope) in dj[3..].iter_mut().zip(&of_moves) {
                        *entry = -slope[k] * PRIOR_LENGTH_MM;
                    }
                    add(k, moved[k] * PRIOR_LENGTH_MM, &dj);
                }
                for (k, turned) in turned.iter().enumerate() {
                    let field = turned.field(&q);
                    let dv = nq.dot(&field) - n.dot(&turned.field(&p));
                    add(3 + k, dv, &row_of(turned, &field));
                }
            }
            out.extend(slopes.iter().flatten());
        }
        out
    }
}

fn inner<const N: usize>(a: &[f64; N], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

#[cfg(test)]
mod tests {
    use super::super::fit::tests::room_a;
    use super::super::learn::{Start, start};
    use super::*;

    /// Judges the problem of some of the room's measurements, of either content.
    fn each_problem(count: usize, kind: Start, ridge: f64, judge: impl Fn(&Problem<'_>)) {
        for content in [MeasurementContent::FiveDof, MeasurementContent::SixDof] {
            let measurements = &room_a("fit").measurements[..count];
            let harmonics = &Harmonics::new(measurements, content, 2);
            judge(&Problem { measurements, content, harmonics, ridge, start: start(kind) });
        }
    }

    /// Central differences of the whole cost, which at the best coefficients has the same slope as
    /// at fixed ones; of the residuals at fixed coefficients for the matrix's part.
    #[test]
    fn the_slope_is_the_difference_of_the_cost() {
        // A ridge, whose own change with the generator is not in the slope, of next to nothing.
        each_problem(60, Start::Triads, 1e-7, |problem| {
            let unknowns = OF_COIL * problem.start.0.len();
            let off: Vec<_> = (0..unknowns).map(|k| 0.05 * (k as f64).sin()).collect();
            let task = Task::default();
            let weights: Vec<_> = (0..60).map(|k| 1.0 - 0.01 * f64::from(k % 9)).collect();
            let state = problem.state(&task, problem.start.moved(&off), &weights).unwrap();
            let (_, slope) = problem.equations(&state, &weights);
            let largest = slope.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
            let h = 1e-4;
            for k in 0..unknowns {
                let cost = |h: f64| {
                    let mut step = vec![0.0; unknowns];
                    step[k] = h;
                    let moved = state.dipoles.moved(&step);
                    problem.state(&task, moved, &weights).unwrap().cost
                };
                let difference = (cost(h) - cost(-h)) / (4.0 * h);
                assert!(
                    (difference - slope[k]).abs() < 2e-4 * largest,
                    "{k}: {difference} {}",
                    slope[k]
                );
            }
        });
    }

    #[test]
    fn residual_slopes_are_differences() {
        each_problem(20, Start::Circle, 1e-3, |problem| {
            let task = Task::default();
            let state = problem.state(&task, problem.start.clone(), &[1.0; 20]).unwrap();
            let slopes = problem.slopes(&state, &problem.system(&state.maps));
            let h = 1e-5;
            for column in 0..slopes.ncols() {
                let residuals = |h: f64| {
                    let mut step = vec![0.0; slopes.ncols()];
                    step[column] = h;
                    let generator = state.dipoles.moved(&step).generator("");
                    let (measurements, content) = (problem.measurements, problem.content);
                    let maps = Maps::new(&task, &generator, measurements, content).unwrap();
                    problem.system(&maps).residuals(&state.solved.coefficients)
                };
                let (plus, minus) = (residuals(h), residuals(-h));
                let scale = slopes.col(column).norm_l2();
                for row in 0..slopes.nrows() {
                    let difference = (plus[row] - minus[row]) / (2.0 * h);
                    assert!((difference - slopes[(row, column)]).abs() < 1e-6 * scale);
                }
            }
        });
    }
}
