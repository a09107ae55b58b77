//! One system on all its folds: every part's triangle once, each complement from the others'
//! triangles, all ridges from one decomposition.

use super::folds::Folds;
use super::{Scores, SelectError, SelectSettings};
use crate::field::bernstein::{coefficient_count, push_products};
use crate::field::fit::FitMethod;
use crate::field::least_squares::{Decomposition, LeastSquares, Triangle};
use crate::field::samples::SampleSet;
use crate::geometry::bounds::Bounds;
use crate::geometry::directions::{DirectionSet, DirectionWeights};
use crate::task::Task;
use nalgebra::{Unit, Vector3};
use rayon::prelude::*;
use std::sync::atomic::{AtomicU64, Ordering};

/// Values of an error: X, Y, Z, Rx, Ry, Rz.
const VALUES: usize = 6;

/// Held-out rows that one thread judges at a time. Sums are taken by such blocks, in order, so
/// that they do not depend on the threads.
const BLOCK_ROWS: usize = 128;

/// The samples as all systems see them.
pub(super) struct Problem {
    unit_positions: Vec<Vector3<f64>>,
    axes: Vec<Unit<Vector3<f64>>>,
    values: Vec<[f64; VALUES]>,
    has_rotations: bool,
}

/// One order with one set of orientations, and the ridges to try on it.
pub(super) struct System {
    pub order: usize,
    pub directions: DirectionSet,
    pub ridges: Vec<f64>,
}

/// How much of the work is done, told to who waits for it.
pub(super) struct Progress<'a> {
    task: &'a Task,
    done: AtomicU64,
    all: u64,
}

/// Coefficients of one least-squares system for every ridge: `[unknown][ridge][value]`.
struct Coefficients(Vec<f64>);

/// Sums over held-out rows for one ridge.
#[derive(Clone, Copy, Default)]
struct Sums {
    position_squares: f64,
    position_max_square: f64,
    rotation_squares: f64,
}

impl Problem {
    pub fn new(set: &SampleSet, bounds: &Bounds) -> Self {
        Self {
            unit_positions: set
                .samples
                .iter()
                .map(|s| bounds.to_unit(&s.position_mm))
                .collect(),
            axes: set.samples.iter().map(|s| s.axis).collect(),
            values: set
                .samples
                .iter()
                .map(|s| {
                    let (p, r) = (s.error.position_mm, s.error.rotation_rad);
                    [p.x, p.y, p.z, r.x, r.y, r.z]
                })
                .collect(),
            has_rotations: set.has_rotations,
        }
    }
}

impl System {
    /// Work of one decomposition, and how many a fold needs.
    fn cost(&self) -> u64 {
        let per_direction = coefficient_count(self.order) as u64;
        self.directions.len() as u64 * per_direction.pow(2)
    }
}

impl<'a> Progress<'a> {
    pub fn new(task: &'a Task, systems: &[System], splits: usize) -> Self {
        Self {
            task,
            done: AtomicU64::new(0),
            all: systems.iter().map(System::cost).sum::<u64>() * splits as u64,
        }
    }

    fn add(&self, cost: u64) -> Result<(), SelectError> {
        let done = self.done.fetch_add(cost, Ordering::Relaxed) + cost;
        // Per mille: a share of any size fits whatever a count of work is.
        let part = done * 1000 / self.all.max(1);
        Ok(self.task.step(part as usize, 1000)?)
    }
}

/// Scores of a system for each of its ridges.
pub(super) fn scores(
    problem: &Problem,
    system: &System,
    folds: &Folds,
    settings: &SelectSettings,
    progress: &Progress,
) -> Result<Vec<Scores>, SelectError> {
    let weights: Vec<_> = problem
        .axes
        .iter()
        .map(|axis| system.directions.weights(axis, settings.weighting))
        .collect();
    let fitted = match (system.order, settings.method) {
        (0, _) => {
            progress.add(system.cost())?;
            Vec::new()
        }
        (_, FitMethod::PerDirection) => {
            let directions = system.directions.len();
            (0..directions)
                .into_par_iter()
                .map(|direction| {
                    let found = each_complement(folds, system, settings, progress, |rows| {
                        direction_triangle(problem, &weights, system.order, direction, rows)
                    })?;
                    progress.add(system.cost() / directions as u64)?;
                    Ok(found)
                })
                .collect::<Result<Vec<_>, SelectError>>()?
        }
        (_, FitMethod::Joint) => {
            let found = each_complement(folds, system, settings, progress, |rows| {
                joint_triangle(problem, &weights, system, rows)
            })?;
            progress.add(system.cost())?;
            vec![found]
        }
    };
    let mut sums = vec![Sums::default(); system.ridges.len()];
    for (fold, rows) in folds.rows.iter().enumerate() {
        let blocks: Vec<_> = rows
            .par_chunks(BLOCK_ROWS)
            .map(|rows| {
                judge(
                    problem,
                    &weights,
                    system,
                    settings.method,
                    &fitted,
                    fold,
                    rows,
                )
            })
            .collect();
        for block in blocks {
            for (sum, part) in sums.iter_mut().zip(block) {
                sum.position_squares += part.position_squares;
                sum.position_max_square = sum.position_max_square.max(part.position_max_square);
                sum.rotation_squares += part.rotation_squares;
            }
        }
    }
    let n = problem.values.len() as f64;
    Ok(sums
        .iter()
        .map(|sum| Scores {
            position_rms_mm: (sum.position_squares / n).sqrt(),
            position_max_mm: sum.position_max_square.sqrt(),
            angle_rms_rad: problem
                .has_rotations
                .then(|| (sum.rotation_squares / n).sqrt()),
        })
        .collect())
}

/// Fits to all rows but one fold's, for each fold: `triangle` reduces the rows of one part.
fn each_complement(
    folds: &Folds,
    system: &System,
    settings: &SelectSettings,
    progress: &Progress,
    triangle: impl Fn(&[usize]) -> Triangle + Sync,
) -> Result<Vec<Coefficients>, SelectError> {
    let parts: Vec<_> = folds.rows.par_iter().map(|rows| triangle(rows)).collect();
    (0..parts.len())
        .into_par_iter()
        .map(|left_out| {
            progress.add(0)?;
            let others = parts
                .iter()
                .enumerate()
                .filter(|(i, _)| *i != left_out)
                .map(|(_, part)| part);
            // At least two folds, so there is another one.
            let merged = Triangle::merged(others).ok_or(SelectError::Folds(parts.len()))?;
            Ok(Coefficients::new(
                &merged.decompose()?,
                settings.rcond,
                &system.ridges,
            ))
        })
        .collect()
}

fn direction_triangle(
    problem: &Problem,
    weights: &[DirectionWeights],
    order: usize,
    direction: usize,
    rows: &[usize],
) -> Triangle {
    let mut system = LeastSquares::new(coefficient_count(order));
    for &row in rows {
        let w = weights[row].of(direction);
        if w > 0.0 {
            let fill = |out: &mut Vec<f64>| {
                let start = out.len();
                push_products(order, &problem.unit_positions[row], out);
                for entry in &mut out[start..] {
                    *entry *= w;
                }
            };
            system.push(fill, problem.values[row].map(|v| w * v));
        }
    }
    system.into_triangle()
}

fn joint_triangle(
    problem: &Problem,
    weights: &[DirectionWeights],
    system: &System,
    rows: &[usize],
) -> Triangle {
    let per_direction = coefficient_count(system.order);
    let unknowns = system.directions.len() * per_direction;
    let mut joint = LeastSquares::new(unknowns);
    let mut products = Vec::with_capacity(per_direction);
    for &row in rows {
        products.clear();
        push_products(system.order, &problem.unit_positions[row], &mut products);
        let fill = |out: &mut Vec<f64>| {
            let start = out.len();
            out.resize(start + unknowns, 0.0);
            let DirectionWeights {
                directions,
                weights,
            } = weights[row];
            for (direction, w) in directions.into_iter().zip(weights) {
                let block = &mut out[start + direction * per_direction..][..per_direction];
                for (entry, product) in block.iter_mut().zip(&products) {
                    *entry += w * product;
                }
            }
        };
        joint.push(fill, problem.values[row]);
    }
    joint.into_triangle()
}

impl Coefficients {
    fn new(decomposition: &Decomposition, rcond: f64, ridges: &[f64]) -> Self {
        let solutions: Vec<_> = ridges
            .iter()
            .map(|&ridge| decomposition.solve(rcond, ridge).unknowns)
            .collect();
        let unknowns = solutions.first().map_or(0, Vec::len);
        Self(
            (0..unknowns)
                .flat_map(|i| solutions.iter().flat_map(move |x| x[i]))
                .collect(),
        )
    }
}

/// What is left of held-out rows by equation (8), for each ridge.
fn judge(
    problem: &Problem,
    weights: &[DirectionWeights],
    system: &System,
    method: FitMethod,
    fitted: &[Vec<Coefficients>],
    fold: usize,
    rows: &[usize],
) -> Vec<Sums> {
    let ridges = system.ridges.len();
    let per_direction = coefficient_count(system.order);
    let mut sums = vec![Sums::default(); ridges];
    let mut products = Vec::with_capacity(per_direction);
    let mut predicted = vec![0.0; ridges * VALUES];
    for &row in rows {
        predicted.fill(0.0);
        if system.order > 0 {
            products.clear();
            push_products(system.order, &problem.unit_positions[row], &mut products);
            let DirectionWeights {
                directions,
                weights,
            } = weights[row];
            for (direction, w) in directions.into_iter().zip(weights) {
                if w == 0.0 {
                    continue;
                }
                let coefficients = match method {
                    FitMethod::PerDirection => &fitted[direction][fold].0[..],
                    FitMethod::Joint => {
                        let width = per_direction * ridges * VALUES;
                        &fitted[0][fold].0[direction * width..][..width]
                    }
                };
                let each = coefficients.chunks_exact(ridges * VALUES);
                for (product, of_ridges) in products.iter().zip(each) {
                    let product = w * product;
                    for (sum, c) in predicted.iter_mut().zip(of_ridges) {
                        *sum += product * c;
                    }
                }
            }
        }
        let e = &problem.values[row];
        for (sum, p) in sums.iter_mut().zip(predicted.chunks_exact(VALUES)) {
            let square = |k: std::ops::Range<usize>| k.map(|k| (e[k] - p[k]).powi(2)).sum::<f64>();
            let position = square(0..3);
            sum.position_squares += position;
            sum.position_max_square = sum.position_max_square.max(position);
            sum.rotation_squares += square(3..6);
        }
    }
    sums
}
