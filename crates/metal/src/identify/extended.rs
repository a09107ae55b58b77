//! The best middles of so many bodies that are no spheres: Levenberg–Marquardt on the middles, multipoles solved for
//! by themselves (variable projection).
//!
//! The dipole's tensor is free. Multipoles beyond it are held near those of a compact body by a prior, whose width is that
//! of a body of an extent `a`: `g a²`, `g` the tensor's largest strength. The extent is the one that makes the rows most
//! probable (MacKay, Neural Computation 4, 1992), at least that of a sphere. So what the rows don't tell of a body's form
//! makes the interval of its middle longer.
//!
//! A body nearer to the sensors has more freedom, which would draw it there. So a middle is where tensors are best in noise
//! that has the covariance of the other multipoles added, held as it is there (generalised least squares): its
//! expectation is the true one.

use super::multipoles::{OF_ALL, OF_NEXT, OF_TENSOR, columns, diagonal_quadrupoles, largest};
use super::noise::losses;
use super::rows::Rows;
use super::solve::{Solution, equations, weighted_square};
use super::sources::{Source, SourceModel, are_possible};
use nalgebra::{DMatrix, DVector, Point3, Vector3};
use trackwright_field::harmonic::huber_weights;
use trackwright_task::{Cancelled, Task};

/// Unknowns of a body: its middle, and all multipoles.
pub(super) const OF_EXTENDED: usize = 3 + OF_ALL;

const MAX_STEPS: usize = 30;
const CONVERGED: f64 = 0.03;
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

/// Standard deviation of a compact body's multipoles from those of a sphere, over what they may be.
const NOT_A_SPHERE: f64 = 0.2;

/// Steps to larger extents, and what a loss may be more there: five standard deviations, as few entries of a long body are
/// far from zero, which the prior takes for improbable.
const WIDER: f64 = 1.4;
const AS_GOOD_EXTENT: f64 = 25.0;

/// Least extent over the cubic root of the strength: of a sphere and of a disc the entries beyond the tensor are then 0.7
/// to 1.3 of the prior's width.
const LEAST_EXTENT: f64 = 1.25;

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
        LEAST_EXTENT * largest(&self.entries).cbrt()
    }

    /// What the entries are held near: of quadrupoles by gradients a sphere's sign and about half its size.
    fn prior_mean(&self, terms: usize) -> Vec<f64> {
        let strength = largest(&self.entries);
        let sign = -self.entries[..3].iter().sum::<f64>().signum();
        let mut mean = vec![0.0; terms];
        for k in diagonal_quadrupoles().filter(|k| *k < terms) {
            mean[k] = sign * strength.powf(5.0 / 3.0);
        }
        mean
    }
}

/// Covariance of the unknowns of compact bodies, [`super::sources::OF_BODY`] each, that may be nearly spheres: boxes or
/// balls with a hole. `None` where the rows do not determine them.
pub(super) fn nearly_spheres(rows: &Rows, best: &Solution) -> Option<DMatrix<f64>> {
    let unknowns = best.slopes.ncols();
    let all = unknowns + OF_ALL * best.sources.len();
    let mut wide = Solution { prior: DVector::zeros(all), ..best.clone() };
    wide.slopes = DMatrix::zeros(best.left.len(), all);
    wide.slopes.columns_mut(0, unknowns).copy_from(&best.slopes);
    for (k, source) in best.sources.iter().enumerate() {
        let from = unknowns + k * OF_ALL;
        let columns = columns(rows, &source.center_mm, OF_ALL);
        wide.slopes.columns_mut(from, OF_ALL).copy_from(&columns);
        let strength = source.strength_mm3.abs();
        let extent_mm = LEAST_EXTENT * strength.cbrt();
        for (entries, power) in [(0..OF_TENSOR, 0), (OF_TENSOR..OF_NEXT, 2), (OF_NEXT..OF_ALL, 4)] {
            let width = NOT_A_SPHERE * strength * extent_mm.powi(power);
            let entries = from + entries.start..from + entries.end;
            wide.prior.rows_range_mut(entries).fill(width.powi(-2));
        }
    }
    let covariance = wide.covariance(rows.dof)?;
    Some(covariance.view((0, 0), (unknowns, unknowns)).into_owned())
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
    let prior = Prior::new(&start, OF_TENSOR);
    let mut weights = weights.to_vec();
    let Some(mut state) = State::new(rows, start, &prior, &weights) else { return Ok(None) };
    let mut damping = FIRST_DAMPING;
    for step in 0..MAX_STEPS {
        task.step(0, 1)?;
        if step > 0 {
            weights = huber_weights(&state.left, rows.dof);
            state.square = state.square(&prior, &weights, rows.dof);
        }
        let equations = Equations::new(rows, &state, &prior, &weights);
        let mut gain = f64::INFINITY;
        let next = loop {
            if let Some((moved, expected)) = equations.step(&state, damping) {
                gain = expected;
                let next = State::new(rows, moved, &prior, &weights);
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
        state = next.unwrap_or(state);
        if gain < CONVERGED {
            return Ok(Some(state.solution(rows, prior)));
        }
        if is_stuck {
            return Ok(None);
        }
    }
    Ok(None)
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
        let Some(solution) = near(task, rows, &bodies, weights)? else {
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

/// The same with the largest extents that explain the rows as well: what is not known of a body's extent makes the interval
/// of its middle longer.
pub(super) fn widened(task: &Task, rows: &Rows, best: Solution) -> Result<Solution, Cancelled> {
    let mut least = best.loss;
    let mut widest = best;
    for body in 0..widest.extended.len() {
        loop {
            let mut start = widest.extended.clone();
            start[body].extent_mm *= WIDER;
            if start[body].extent_mm > MOST_EXTENT_MM {
                break;
            }
            let wider = near(task, rows, &start, &widest.weights)?;
            let Some(wider) = wider.filter(|wider| wider.loss < least + AS_GOOD_EXTENT) else {
                break;
            };
            least = least.min(wider.loss);
            widest = wider;
        }
    }
    Ok(widest)
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
        let mean = body.prior_mean(OF_ALL);
        let squares = |entries: std::ops::Range<usize>| -> f64 {
            entries.map(|k| ((body.entries[k] - mean[k]) / strength).powi(2)).sum()
        };
        let (next, last) = (squares(OF_TENSOR..OF_NEXT), squares(OF_NEXT..OF_ALL));
        // With both widths at the extent squares are as many as the entries that the rows determine.
        let to_fourth =
            (next + (next * next + 4.0 * determined * last).sqrt()) / (2.0 * determined);
        let extent_mm = to_fourth.powf(0.25);
        let least_mm = body.least_extent_mm();
        let extent_mm = extent_mm.clamp(least_mm, MOST_EXTENT_MM.max(least_mm));
        has_changed |= (extent_mm / body.extent_mm - 1.0).abs() > SAME_EXTENT;
        body.extent_mm = extent_mm;
    }
    has_changed
}

/// The middles at which tensors are best, with the prior of the start.
fn near(
    task: &Task,
    rows: &Rows,
    start: &[Extended],
    weights: &[f64],
) -> Result<Option<Solution>, Cancelled> {
    let prior = Prior::new(start, OF_ALL);
    let mut weights = weights.to_vec();
    let Some(mut state) = State::new(rows, start.to_vec(), &prior, &weights) else {
        return Ok(None);
    };
    let mut last_step = DVector::zeros(3 * start.len());
    let mut part: f64 = 1.0;
    for step in 0..MAX_STEPS {
        task.step(0, 1)?;
        if step > 0 {
            weights = huber_weights(&state.left, rows.dof);
        }
        let equations = Equations::new(rows, &state, &prior, &weights);
        let Some((mut moved, gain)) = equations.step(&state, 0.0) else { return Ok(None) };
        if gain < CONVERGED {
            return Ok(Some(state.solution(rows, prior)));
        }
        let steps = moved.iter().zip(&state.bodies);
        let steps = steps.flat_map(|(new, old)| <[f64; 3]>::from(new.center_mm - old.center_mm));
        let step = DVector::from_iterator(last_step.len(), steps);
        // The covariance held at one place and then at the next may lead to and fro between them.
        let is_back = step.dot(&last_step) < 0.0;
        part = if is_back { 0.5 * part } else { (1.5 * part).min(1.0) };
        for (body, old) in moved.iter_mut().zip(&state.bodies) {
            body.center_mm = old.center_mm + part * (body.center_mm - old.center_mm);
        }
        last_step = step;
        let Some(next) = State::new(rows, moved, &prior, &weights) else { return Ok(None) };
        state = next;
    }
    Ok(None)
}

/// The linearised equations of middles and entries at a state.
struct Equations {
    normal: DMatrix<f64>,
    slope: DVector<f64>,
}

impl Equations {
    fn new(rows: &Rows, state: &State, prior: &Prior, weights: &[f64]) -> Self {
        let slopes = state.slopes(rows, prior);
        let (mut normal, mut slope) = equations(&slopes, &state.left, weights, rows.dof);
        let off = state.unknowns() - &prior.mean;
        for i in 0..slope.len() {
            normal[(i, i)] += prior.precision[i];
            slope[i] -= prior.precision[i] * off[i];
        }
        Self { normal, slope }
    }

    /// Where the middles go, and the expected gain.
    fn step(&self, state: &State, damping: f64) -> Option<(Vec<Extended>, f64)> {
        let of_body = self.slope.len() / state.bodies.len();
        let scale = self.normal.diagonal().map(|d| 1.0 / d.sqrt());
        let damped = DMatrix::from_fn(self.slope.len(), self.slope.len(), |i, j| {
            let is_middle = i == j && i % of_body < 3;
            let more = if is_middle { 1.0 + damping } else { 1.0 + 1e-12 * f64::from(i == j) };
            self.normal[(i, j)] * scale[i] * scale[j] * more
        });
        let step = damped.cholesky()?.solve(&self.slope.component_mul(&scale));
        let step = step.component_mul(&scale);
        let moved = state.bodies.iter().enumerate().map(|(k, body)| {
            let step: Vector3<f64> = step.fixed_rows::<3>(k * of_body).into_owned();
            let step = step * (MAX_STEP_MM / step.norm().max(1e-9)).min(1.0);
            Extended { center_mm: body.center_mm + step, ..body.clone() }
        });
        Some((moved.collect(), step.dot(&self.slope)))
    }
}

/// What unknowns are held near, and how much, in noise; middles and tensors are free.
struct Prior {
    /// Entries of a body.
    terms: usize,
    mean: DVector<f64>,
    precision: DVector<f64>,
}

impl Prior {
    fn new(bodies: &[Extended], terms: usize) -> Self {
        let of_body = 3 + terms;
        let zero = || DVector::zeros(of_body * bodies.len());
        let mut prior = Self { terms, mean: zero(), precision: zero() };
        for (k, body) in bodies.iter().enumerate().filter(|_| terms > OF_TENSOR) {
            let from = k * of_body + 3;
            let width = |power: i32| largest(&body.entries) * body.extent_mm.powi(power);
            for (entries, power) in [(OF_TENSOR..OF_NEXT, 2), (OF_NEXT..OF_ALL, 4)] {
                let entries = from + entries.start..from + entries.end;
                prior.precision.rows_range_mut(entries).fill(width(power).powi(-2));
            }
            let mean = DVector::from_vec(body.prior_mean(terms));
            prior.mean.rows_mut(from, terms).copy_from(&mean);
        }
        prior
    }

    fn square(&self, unknowns: &DVector<f64>) -> f64 {
        let off = unknowns - &self.mean;
        off.component_mul(&off).dot(&self.precision)
    }
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
    fn new(rows: &Rows, mut bodies: Vec<Extended>, prior: &Prior, weights: &[f64]) -> Option<Self> {
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
        let terms = prior.terms;
        let mut all = DMatrix::zeros(rows.right.len(), terms * bodies.len());
        for (k, body) in bodies.iter().enumerate() {
            all.columns_mut(k * terms, terms).copy_from(&columns(rows, &body.center_mm, terms));
        }
        let (mut normal, mut slope) = equations(&all, &rows.right, weights, rows.dof);
        for i in 0..slope.len() {
            let unknown = i / terms * (terms + 3) + 3 + i % terms;
            normal[(i, i)] += prior.precision[unknown];
            slope[i] += prior.precision[unknown] * prior.mean[unknown];
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
    fn unknowns(&self) -> DVector<f64> {
        let of_body = |body: &Extended| [&[0.0; 3], &body.entries[..]].concat();
        DVector::from_iterator(
            self.columns.ncols() + 3 * self.bodies.len(),
            self.bodies.iter().flat_map(of_body),
        )
    }

    fn square(&self, prior: &Prior, weights: &[f64], dof: usize) -> f64 {
        weighted_square(&self.left, weights, dof) + prior.square(&self.unknowns())
    }

    /// By differences for the middles, of what the tensors and the prior's means add.
    fn slopes(&self, rows: &Rows, prior: &Prior) -> DMatrix<f64> {
        let terms = prior.terms;
        let of_body = 3 + terms;
        let mut slopes = DMatrix::zeros(rows.right.len(), of_body * self.bodies.len());
        for (k, body) in self.bodies.iter().enumerate() {
            let own = self.columns.columns(k * terms, terms);
            let count = terms.min(OF_NEXT);
            let mut entries = prior.mean.rows(k * of_body + 3, count).into_owned();
            entries.rows_mut(0, OF_TENSOR).copy_from_slice(&body.entries[..OF_TENSOR]);
            let here = own.columns(0, count) * &entries;
            for axis in 0..3 {
                let mut moved = body.center_mm;
                moved[axis] += STEP_MM;
                let there = columns(rows, &moved, count) * &entries;
                slopes.set_column(k * of_body + axis, &((there - &here) / STEP_MM));
            }
            slopes.columns_mut(k * of_body + 3, terms).copy_from(&own);
        }
        slopes
    }

    fn solution(self, rows: &Rows, prior: Prior) -> Solution {
        let slopes = self.slopes(rows, &prior);
        let weights = huber_weights(&self.left, rows.dof);
        let held = prior.square(&self.unknowns());
        let mut solution = Solution {
            model: SourceModel::Multipoles,
            sources: self.bodies.iter().map(Extended::source).collect(),
            unknowns: slopes.ncols() as f64,
            weights,
            loss: losses(rows, &self.left).iter().sum::<f64>() + held,
            left: self.left,
            slopes,
            extended: self.bodies,
            prior: prior.precision,
        };
        if let Some(inverse) = solution.inverse(rows.dof) {
            solution.unknowns -= inverse.diagonal().dot(&solution.prior);
        }
        solution.loss += solution.freedom(rows.dof);
        solution
    }
}

impl Solution {
    /// What the freedom of the entries beyond the tensors costs: twice the logarithm of the part of the prior's volume that
    /// the rows leave. With it losses of different priors can be compared.
    fn freedom(&self, dof: usize) -> f64 {
        let held: Vec<usize> = (0..self.prior.len()).filter(|&i| self.prior[i] > 0.0).collect();
        let root = |i: usize| self.weights[i / dof].sqrt();
        let slopes = DMatrix::from_fn(self.slopes.nrows(), held.len(), |i, k| {
            root(i) * self.slopes[(i, held[k])] / self.prior[held[k]].sqrt()
        });
        let normal = slopes.transpose() * &slopes + DMatrix::identity(held.len(), held.len());
        let factor = normal.cholesky();
        factor.map_or(0.0, |factor| 2.0 * factor.l_dirty().diagonal().map(f64::ln).sum())
    }
}
