//! One system on all its folds: every part's triangle once, each complement from the others'
//! triangles, all ridges from one decomposition.

use super::clusters;
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
use std::collections::HashSet;
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
    /// The place of each row, where rows come in clusters: neighbours say the same.
    places: Option<Vec<usize>>,
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

/// A system on all its folds.
pub(super) struct Outcome {
    /// One a ridge.
    pub scores: Vec<Scores>,
    /// Whether most held-out rows are judged by more places than unknowns.
    pub is_determined: bool,
}

/// The rows of one fold that a system takes, as a triangle.
struct Part {
    triangle: Triangle,
    rows: Vec<usize>,
}

/// A least-squares system without one fold.
struct Fitted {
    coefficients: Coefficients,
    is_determined: bool,
}

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
            places: clusters::find(
                &set.samples
                    .iter()
                    .map(|s| s.position_mm)
                    .collect::<Vec<_>>(),
            ),
        }
    }
}

impl Problem {
    /// How many places the rows are at, counting clusters once.
    fn places(&self, rows: impl Iterator<Item = usize>) -> usize {
        match &self.places {
            None => rows.count(),
            Some(places) => rows.map(|row| places[row]).collect::<HashSet<_>>().len(),
        }
    }
}

impl System {
    /// Work in units of its own, roughly in proportion to time.
    fn cost(&self) -> u64 {
        self.directions.len() as u64 * self.direction_cost()
    }

    fn direction_cost(&self) -> u64 {
        match self.order {
            0 => 0,
            order => (coefficient_count(order) as u64).pow(2),
        }
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

/// Fits a system to all rows but each fold's, and judges it there.
pub(super) fn scores(
    problem: &Problem,
    system: &System,
    folds: &Folds,
    settings: &SelectSettings,
    progress: &Progress,
) -> Result<Outcome, SelectError> {
    let weights: Vec<_> = problem
        .axes
        .iter()
        .map(|axis| system.directions.weights(axis, settings.weighting))
        .collect();
    let fitted = match (system.order, settings.method) {
        (0, _) => Vec::new(),
        (_, FitMethod::PerDirection) => (0..system.directions.len())
            .into_par_iter()
            .map(|direction| {
                let part = |rows: &[usize]| {
                    direction_part(problem, &weights, system.order, direction, rows)
                };
                let found = fit_each(problem, folds, system, settings, progress, part)?;
                progress.add(system.direction_cost())?;
                Ok(found)
            })
            .collect::<Result<Vec<_>, SelectError>>()?,
        (_, FitMethod::Joint) => {
            let part = |rows: &[usize]| joint_part(problem, &weights, system, rows);
            let found = fit_each(problem, folds, system, settings, progress, part)?;
            progress.add(system.cost())?;
            vec![found]
        }
    };
    let judge = Judge {
        problem,
        weights: &weights,
        system,
        method: settings.method,
        fitted: &fitted,
    };
    let mut sums = vec![Sums::default(); system.ridges.len()];
    let mut determined = 0;
    for (fold, rows) in folds.rows.iter().enumerate() {
        let blocks: Vec<_> = rows
            .par_chunks(BLOCK_ROWS)
            .map(|rows| judge.sums(fold, rows))
            .collect();
        for block in blocks {
            for (sum, part) in sums.iter_mut().zip(block) {
                sum.add(&part);
            }
        }
        determined += rows
            .iter()
            .filter(|&&row| judge.is_determined(fold, row))
            .count();
    }
    let n = problem.values.len() as f64;
    let scores = sums
        .iter()
        .map(|sum| Scores {
            position_rms_mm: (sum.position_squares / n).sqrt(),
            position_max_mm: sum.position_max_square.sqrt(),
            angle_rms_rad: problem
                .has_rotations
                .then(|| (sum.rotation_squares / n).sqrt()),
        })
        .collect();
    Ok(Outcome {
        scores,
        is_determined: 2 * determined > problem.values.len(),
    })
}

/// Fits to all rows but one fold's, for each fold; `part` reduces the rows of a fold.
fn fit_each(
    problem: &Problem,
    folds: &Folds,
    system: &System,
    settings: &SelectSettings,
    progress: &Progress,
    part: impl Fn(&[usize]) -> Part + Sync,
) -> Result<Vec<Fitted>, SelectError> {
    let parts: Vec<_> = folds.rows.par_iter().map(|rows| part(rows)).collect();
    (0..parts.len())
        .into_par_iter()
        .map(|left_out| {
            progress.add(0)?;
            let others = || {
                let all = parts.iter().enumerate();
                all.filter(|(i, _)| *i != left_out).map(|(_, part)| part)
            };
            // At least two folds, so there is another one.
            let merged = Triangle::merged(others().map(|part| &part.triangle))
                .ok_or(SelectError::Folds(parts.len()))?;
            let decomposition = merged.decompose()?;
            let coefficients = Coefficients::new(&decomposition, settings.rcond, &system.ridges);
            let rows = others().flat_map(|part| part.rows.iter().copied());
            Ok(Fitted {
                is_determined: problem.places(rows) > coefficients.unknowns(system),
                coefficients,
            })
        })
        .collect()
}

fn direction_part(
    problem: &Problem,
    weights: &[DirectionWeights],
    order: usize,
    direction: usize,
    rows: &[usize],
) -> Part {
    let mut system = LeastSquares::new(coefficient_count(order));
    let mut used = Vec::new();
    for &row in rows {
        let w = weights[row].of(direction);
        if w > 0.0 {
            used.push(row);
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
    Part {
        triangle: system.into_triangle(),
        rows: used,
    }
}

fn joint_part(
    problem: &Problem,
    weights: &[DirectionWeights],
    system: &System,
    rows: &[usize],
) -> Part {
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
    Part {
        triangle: joint.into_triangle(),
        rows: rows.to_vec(),
    }
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

    fn unknowns(&self, system: &System) -> usize {
        self.0.len() / (system.ridges.len() * VALUES)
    }
}

impl Sums {
    fn add(&mut self, other: &Self) {
        self.position_squares += other.position_squares;
        self.position_max_square = self.position_max_square.max(other.position_max_square);
        self.rotation_squares += other.rotation_squares;
    }
}

/// A fitted system, to be judged on the rows it has not seen.
struct Judge<'a> {
    problem: &'a Problem,
    weights: &'a [DirectionWeights],
    system: &'a System,
    method: FitMethod,
    /// By orientation (one for all where they are fitted jointly), then fold.
    fitted: &'a [Vec<Fitted>],
}

impl Judge<'_> {
    /// What is left of held-out rows by equation (8), for each ridge.
    fn sums(&self, fold: usize, rows: &[usize]) -> Vec<Sums> {
        let ridges = self.system.ridges.len();
        let mut sums = vec![Sums::default(); ridges];
        let mut products = Vec::with_capacity(coefficient_count(self.system.order));
        let mut predicted = vec![0.0; ridges * VALUES];
        for &row in rows {
            predicted.fill(0.0);
            if self.system.order > 0 {
                self.predict(fold, row, &mut products, &mut predicted);
            }
            let e = &self.problem.values[row];
            for (sum, p) in sums.iter_mut().zip(predicted.chunks_exact(VALUES)) {
                let square =
                    |k: std::ops::Range<usize>| k.map(|k| (e[k] - p[k]).powi(2)).sum::<f64>();
                let position = square(0..3);
                sum.add(&Sums {
                    position_squares: position,
                    position_max_square: position,
                    rotation_squares: square(3..6),
                });
            }
        }
        sums
    }

    /// Six values for each ridge, added to `predicted`.
    fn predict(&self, fold: usize, row: usize, products: &mut Vec<f64>, predicted: &mut [f64]) {
        products.clear();
        push_products(
            self.system.order,
            &self.problem.unit_positions[row],
            products,
        );
        let DirectionWeights {
            directions,
            weights,
        } = self.weights[row];
        for (direction, w) in directions.into_iter().zip(weights) {
            if w == 0.0 {
                continue;
            }
            let coefficients = match self.method {
                FitMethod::PerDirection => &self.fitted[direction][fold].coefficients.0[..],
                FitMethod::Joint => {
                    let width = products.len() * predicted.len();
                    &self.fitted[0][fold].coefficients.0[direction * width..][..width]
                }
            };
            let of_unknowns = coefficients.chunks_exact(predicted.len());
            for (product, of_unknown) in products.iter().zip(of_unknowns) {
                let product = w * product;
                for (sum, c) in predicted.iter_mut().zip(of_unknown) {
                    *sum += product * c;
                }
            }
        }
    }

    /// Whether the orientation nearest to a held-out row was fitted to more places than unknowns.
    fn is_determined(&self, fold: usize, row: usize) -> bool {
        let DirectionWeights {
            directions,
            weights,
        } = self.weights[row];
        let nearest = (0..3).max_by(|&a, &b| weights[a].total_cmp(&weights[b]));
        let of_system = match (self.method, nearest) {
            (FitMethod::PerDirection, Some(k)) => self.fitted.get(directions[k]),
            _ => self.fitted.first(),
        };
        // Order 0 has no systems and leaves nothing open.
        of_system.is_none_or(|folds| folds[fold].is_determined)
    }
}
