//! The best middles of so many bodies that are no spheres: Levenberg–Marquardt on the middles, multipoles solved for
//! by themselves (variable projection).
//!
//! The dipole's tensor is free. Multipoles beyond it are held near zero by a prior, whose width is that of a body of
//! an extent `a`: `g a²`, `g` the tensor's largest strength. The extent is the one that makes the rows most probable
//! (MacKay, Neural Computation 4, 1992), at least that of a sphere. So what the rows don't tell of a body's form makes
//! the interval of its middle longer.

use super::multipoles::{OF_ALL, OF_TENSOR, columns, largest};
use super::noise::losses;
use super::rows::Rows;
use super::solve::{Solution, equations, inverse, weighted_square};
use super::sources::{Source, SourceModel, are_possible};
use nalgebra::{DMatrix, DVector, Point3, Vector3};
use trackwright_field::harmonic::huber_weights;
use trackwright_task::{Cancelled, Task};

/// Unknowns of a body: its middle, and all multipoles.
pub(super) const OF_EXTENDED: usize = 3 + OF_ALL;

const MAX_STEPS: usize = 30;
const CONVERGED: f64 = 1e-2;
const STEP_MM: f64 = 0.1;
const MAX_STEP_MM: f64 = 60.0;
const FIRST_DAMPING: f64 = 1e-3;
const MORE_DAMPING: f64 = 8.0;
const LESS_DAMPING: f64 = 0.1;
const MAX_DAMPING: f64 = 1e6;

/// Times that extents are estimated anew, and the change of one that is none.
const ROUNDS: usize = 4;
const SAME_EXTENT: f64 = 0.05;

/// Largest extent of a body: a farther multipole has no meaning in a room.
const MOST_EXTENT_MM: f64 = 500.0;

/// Nearest sample: nearer, no multipoles serve.
const MIN_FROM_SAMPLE_MM: f64 = 25.0;

/// A body by its multipoles.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Extended {
    pub center_mm: Point3<f64>,
    /// Entries of [`super::multipoles`], the tensor's first; the others may be absent.
    pub entries: Vec<f64>,
    /// Of the prior.
    pub extent_mm: f64,
}

impl Extended {
    /// A dipole to begin with.
    pub fn at(center_mm: Point3<f64>) -> Self {
        Self { center_mm, entries: Vec::new(), extent_mm: 0.0 }
    }

    pub fn source(&self) -> Source {
        let strength_mm3 = self.entries[..3].iter().sum::<f64>() / 3.0;
        Source { center_mm: self.center_mm, strength_mm3 }
    }

    /// The least extent that a body of this strength has.
    fn least_extent_mm(&self) -> f64 {
        largest(&self.entries).cbrt()
    }
}

/// What the bodies add to the rows.
pub(super) fn explained(rows: &Rows, bodies: &[Extended]) -> Vec<f64> {
    let mut sum = DVector::zeros(rows.right.len());
    for body in bodies {
        let entries = DVector::from_column_slice(&body.entries);
        sum += columns(rows, &body.center_mm, body.entries.len()) * entries;
    }
    sum.as_slice().to_vec()
}

/// The best bodies near a start, as tensors alone; `None` where it leads nowhere.
pub(super) fn solve_tensors(
    task: &Task,
    rows: &Rows,
    start: &[Point3<f64>],
    weights: &[f64],
) -> Result<Option<Solution>, Cancelled> {
    let start: Vec<Extended> = start.iter().map(|center| Extended::at(*center)).collect();
    near(task, rows, &start, OF_TENSOR, weights)
}

/// The best bodies near a start with all multipoles; their extents are found as well, where `is_known` does not hold.
pub(super) fn solve_extended(
    task: &Task,
    rows: &Rows,
    start: &[Extended],
    weights: &[f64],
    is_known: bool,
) -> Result<Option<Solution>, Cancelled> {
    let mut bodies = start.to_vec();
    for body in &mut bodies {
        body.extent_mm = body.extent_mm.max(body.least_extent_mm());
    }
    let mut best = None;
    for _ in 0..if is_known { 1 } else { ROUNDS } {
        let Some(solution) = near(task, rows, &bodies, OF_ALL, weights)? else {
            break;
        };
        bodies.clone_from(&solution.extended);
        let is_same = is_known || !update_extents(&solution, &mut bodies, rows.dof);
        best = Some(solution);
        if is_same {
            break;
        }
    }
    Ok(best)
}

/// Sets each extent to what the multipoles found state; whether any changed.
fn update_extents(solution: &Solution, bodies: &mut [Extended], dof: usize) -> bool {
    let Some(inverse) = solution.inverse(dof) else { return false };
    let mut has_changed = false;
    for (k, body) in bodies.iter_mut().enumerate() {
        let from = k * OF_EXTENDED + 3 + OF_TENSOR;
        let count = OF_ALL - OF_TENSOR;
        let held: f64 = (from..from + count).map(|i| inverse[(i, i)] * solution.prior[i]).sum();
        let determined = (count as f64 - held).max(1e-3);
        let strength = largest(&body.entries);
        let square: f64 = body.entries[OF_TENSOR..].iter().map(|v| v * v).sum();
        let extent_mm = (square / (strength * strength) / determined).powf(0.25);
        let least_mm = body.least_extent_mm();
        let extent_mm = extent_mm.clamp(least_mm, MOST_EXTENT_MM.max(least_mm));
        has_changed |= (extent_mm / body.extent_mm - 1.0).abs() > SAME_EXTENT;
        body.extent_mm = extent_mm;
    }
    has_changed
}

/// Levenberg–Marquardt with the prior of the start.
fn near(
    task: &Task,
    rows: &Rows,
    start: &[Extended],
    terms: usize,
    weights: &[f64],
) -> Result<Option<Solution>, Cancelled> {
    let of_body = 3 + terms;
    let mut prior = DVector::zeros(of_body * start.len());
    for (k, body) in start.iter().enumerate().filter(|_| terms > OF_TENSOR) {
        let width = largest(&body.entries) * body.extent_mm.powi(2);
        prior.rows_mut(k * of_body + 3 + OF_TENSOR, terms - OF_TENSOR).fill(width.powi(-2));
    }
    let mut weights = weights.to_vec();
    let Some(mut state) = State::new(rows, start.to_vec(), terms, &prior, &weights) else {
        return Ok(None);
    };
    let mut damping = FIRST_DAMPING;
    for step in 0..MAX_STEPS {
        task.step(0, 1)?;
        if step > 0 {
            weights = huber_weights(&state.left, rows.dof);
            state.square = state.square(&prior, &weights, rows.dof);
        }
        let slopes = state.slopes(rows, terms);
        let (mut normal, mut slope) = equations(&slopes, &state.left, &weights, rows.dof);
        let entries = state.unknowns(terms);
        for i in 0..slope.len() {
            normal[(i, i)] += prior[i];
            slope[i] -= prior[i] * entries[i];
        }
        let scale = normal.diagonal().map(|d| 1.0 / d.sqrt());
        let mut gain = f64::INFINITY;
        let next = loop {
            let damped = DMatrix::from_fn(slope.len(), slope.len(), |i, j| {
                let is_middle = i == j && i % of_body < 3;
                let more = if is_middle { 1.0 + damping } else { 1.0 + 1e-12 * f64::from(i == j) };
                normal[(i, j)] * scale[i] * scale[j] * more
            });
            if let Some(factor) = damped.cholesky() {
                let step = factor.solve(&slope.component_mul(&scale)).component_mul(&scale);
                gain = step.dot(&slope);
                let moved = state.bodies.iter().enumerate().map(|(k, body)| {
                    let step: Vector3<f64> = step.fixed_rows::<3>(k * of_body).into_owned();
                    let length_mm = step.norm().max(1e-9);
                    let step = step * (MAX_STEP_MM / length_mm).min(1.0);
                    Extended { center_mm: body.center_mm + step, ..body.clone() }
                });
                let next = State::new(rows, moved.collect(), terms, &prior, &weights);
                if let Some(next) = next.filter(|next| next.square < state.square) {
                    break Some(next);
                }
            }
            damping *= MORE_DAMPING;
            if damping > MAX_DAMPING || gain < CONVERGED {
                break None;
            }
        };
        damping = (damping * LESS_DAMPING).max(1e-12);
        let is_stuck = next.is_none();
        if let Some(next) = next {
            state = next;
        }
        if gain < CONVERGED {
            let slopes = state.slopes(rows, terms);
            return Ok(Some(state.solution(rows, slopes, prior)));
        }
        if is_stuck {
            return Ok(None);
        }
    }
    Ok(None)
}

/// Bodies, what they leave, and the columns of their entries.
struct State {
    bodies: Vec<Extended>,
    columns: DMatrix<f64>,
    left: Vec<f64>,
    square: f64,
}

impl State {
    /// Entries are the best for their middles.
    fn new(
        rows: &Rows,
        mut bodies: Vec<Extended>,
        terms: usize,
        prior: &DVector<f64>,
        weights: &[f64],
    ) -> Option<Self> {
        let is_apart = |body: &Extended| {
            let apart = |p: &Point3<f64>| (p - body.center_mm).norm() > MIN_FROM_SAMPLE_MM;
            body.center_mm.iter().all(|v| v.is_finite()) && rows.positions_mm.iter().all(apart)
        };
        // Of the strength of a sphere that is next to nothing: where they are decides.
        let points: Vec<Source> = bodies
            .iter()
            .map(|body| Source { center_mm: body.center_mm, strength_mm3: 1.0 })
            .collect();
        if !bodies.iter().all(is_apart) || !are_possible(rows, &points) {
            return None;
        }
        let mut all = DMatrix::zeros(rows.right.len(), terms * bodies.len());
        for (k, body) in bodies.iter().enumerate() {
            all.columns_mut(k * terms, terms).copy_from(&columns(rows, &body.center_mm, terms));
        }
        let (mut normal, slope) = equations(&all, &rows.right, weights, rows.dof);
        for i in 0..slope.len() {
            normal[(i, i)] += prior[i / terms * (terms + 3) + 3 + i % terms];
        }
        let scale = normal.diagonal().map(|d| 1.0 / d.sqrt());
        let scaled = DMatrix::from_fn(slope.len(), slope.len(), |i, j| {
            normal[(i, j)] * scale[i] * scale[j] * if i == j { 1.0 + 1e-12 } else { 1.0 }
        });
        let entries = scaled.cholesky()?.solve(&slope.component_mul(&scale)).component_mul(&scale);
        let explained = &all * &entries;
        for (body, entries) in bodies.iter_mut().zip(entries.as_slice().chunks_exact(terms)) {
            body.entries = entries.to_vec();
        }
        let left = rows.left(explained.as_slice());
        let mut state = Self { bodies, columns: all, left, square: 0.0 };
        state.square = state.square(prior, weights, rows.dof);
        state.square.is_finite().then_some(state)
    }

    /// Unknowns as the prior counts them, middles as zero.
    fn unknowns(&self, terms: usize) -> Vec<f64> {
        let of_body = |body: &Extended| [&[0.0; 3], &body.entries[..terms]].concat();
        self.bodies.iter().flat_map(of_body).collect()
    }

    fn square(&self, prior: &DVector<f64>, weights: &[f64], dof: usize) -> f64 {
        let terms = self.columns.ncols() / self.bodies.len().max(1);
        let entries = self.unknowns(terms);
        let held: f64 = entries.iter().zip(prior.iter()).map(|(v, p)| p * v * v).sum();
        weighted_square(&self.left, weights, dof) + held
    }

    /// By differences for the middles.
    fn slopes(&self, rows: &Rows, terms: usize) -> DMatrix<f64> {
        let of_body = 3 + terms;
        let mut slopes = DMatrix::zeros(rows.right.len(), of_body * self.bodies.len());
        for (k, body) in self.bodies.iter().enumerate() {
            let own = self.columns.columns(k * terms, terms);
            let entries = DVector::from_column_slice(&body.entries);
            let here = own * &entries;
            for axis in 0..3 {
                let mut moved = body.center_mm;
                moved[axis] += STEP_MM;
                let there = columns(rows, &moved, terms) * &entries;
                slopes.set_column(k * of_body + axis, &((there - &here) / STEP_MM));
            }
            slopes.columns_mut(k * of_body + 3, terms).copy_from(&own);
        }
        slopes
    }

    fn solution(self, rows: &Rows, slopes: DMatrix<f64>, prior: DVector<f64>) -> Solution {
        let entries = self.unknowns(self.bodies[0].entries.len());
        let held: f64 = entries.iter().zip(prior.iter()).map(|(v, p)| p * v * v).sum();
        let weights = huber_weights(&self.left, rows.dof);
        let count = slopes.ncols() as f64;
        let of_prior = inverse(&slopes, &self.left, &weights, &prior, rows.dof)
            .map_or(0.0, |inverse| inverse.diagonal().dot(&prior));
        Solution {
            model: SourceModel::Multipoles,
            sources: self.bodies.iter().map(Extended::source).collect(),
            unknowns: count - of_prior,
            weights,
            loss: losses(rows, &self.left).iter().sum::<f64>() + held,
            left: self.left,
            slopes,
            extended: self.bodies,
            prior,
        }
    }
}
