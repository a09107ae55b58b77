//! One system on all its folds: every fold's triangles once, each complement from the others'
//! triangles, all ridges from one decomposition.

use super::clusters;
use super::folds::Folds;
use super::scoring::{FoldSums, HeldOutScores, Residual};
use super::settings::{Candidate, SelectError, SelectSettings};
use crate::bernstein::{coefficient_count, push_products};
use crate::fit::{FitMethod, factor};
use crate::least_squares::{Decomposition, Triangle, VALUES};
use crate::rows::Progress;
use crate::samples::{Sample, SampleSet};
use nalgebra::Vector3;
use rayon::prelude::*;
use std::collections::HashSet;
use trackwright_geometry::bounds::Bounds;
use trackwright_geometry::directions::{DirectionSet, DirectionWeights};
use trackwright_task::Task;

/// Held-out rows that one thread judges at a time. Sums are taken by such blocks, in order, so
/// that they do not depend on the threads.
const BLOCK_ROWS: usize = 128;

/// The samples as all systems see them.
pub(super) struct Problem<'a> {
    set: &'a SampleSet,
    bounds: Bounds,
    unit_positions: Vec<Vector3<f64>>,
    /// The place of each row, where rows come in clusters: neighbours are not independent.
    places: Option<Vec<usize>>,
}

/// Folds with the samples of each.
pub(super) struct Split {
    folds: Folds,
    samples: Vec<SampleSet>,
}

/// One order with one set of orientations, and the ridges to try on it.
pub(super) struct System {
    pub order: usize,
    pub directions: DirectionSet,
    pub ridges: Vec<f64>,
}

/// A system on all its folds.
pub(super) struct Outcome {
    /// One a ridge.
    pub scores: Vec<HeldOutScores>,
    /// Whether most held-out rows are judged by more places than unknowns.
    pub is_determined: bool,
}

/// A least-squares system without one fold.
struct Fitted {
    /// For every ridge: `[unknown][ridge][value]`.
    coefficients: Vec<f64>,
    is_determined: bool,
}

impl<'a> Problem<'a> {
    pub fn new(set: &'a SampleSet, bounds: Bounds) -> Self {
        let positions: Vec<_> = set.samples.iter().map(|s| s.position_mm).collect();
        Self { places: clusters::find(&positions), ..Self::without_places(set, bounds) }
    }

    /// For residuals only: what is determined is not reported.
    pub fn without_places(set: &'a SampleSet, bounds: Bounds) -> Self {
        let unit = |s: &Sample| bounds.to_unit(&s.position_mm);
        Self { set, bounds, unit_positions: set.samples.iter().map(unit).collect(), places: None }
    }

    /// How many of a set's orientations have fewer places than coefficients. All rows count: it is
    /// they that the chosen model is fitted to.
    pub fn under_sampled(&self, system: &System, settings: &SelectSettings) -> usize {
        if system.order == 0 {
            return 0;
        }
        let mut rows_of = vec![Vec::new(); system.directions.len()];
        for (row, sample) in self.set.samples.iter().enumerate() {
            let DirectionWeights { directions, weights } =
                system.directions.weights(&sample.axis, settings.weighting);
            for (direction, weight) in directions.into_iter().zip(weights) {
                if weight > 0.0 {
                    rows_of[direction].push(row);
                }
            }
        }
        let unknowns = coefficient_count(system.order);
        let is_short = |rows: &&Vec<usize>| self.places(rows.iter().copied()) < unknowns;
        rows_of.iter().filter(is_short).count()
    }

    pub fn rows(&self) -> usize {
        self.set.samples.len()
    }

    fn weights(&self, system: &System, settings: &SelectSettings) -> Vec<DirectionWeights> {
        let of_axis = |axis| system.directions.weights(axis, settings.weighting);
        self.set.samples.iter().map(|s| of_axis(&s.axis)).collect()
    }

    /// How many places the rows are at, counting clusters once.
    fn places(&self, rows: impl Iterator<Item = usize>) -> usize {
        match &self.places {
            None => rows.count(),
            Some(places) => rows.map(|row| places[row]).collect::<HashSet<_>>().len(),
        }
    }
}

impl Split {
    pub fn new(set: &SampleSet, folds: Folds) -> Self {
        Self { samples: folds.rows.iter().map(|rows| set.of_rows(rows)).collect(), folds }
    }
}

impl System {
    pub fn candidate(&self, ridge: f64) -> Candidate {
        Candidate { order: self.order, directions: self.directions, ridge }
    }

    /// Work in units of its own, roughly in proportion to time.
    fn cost(&self) -> usize {
        match self.order {
            0 => 0,
            order => self.directions.len() * coefficient_count(order).pow(2),
        }
    }
}

/// Progress over all systems and splits.
pub(super) fn progress<'a>(task: &'a Task, systems: &[System], splits: usize) -> Progress<'a> {
    Progress::new(task, systems.iter().map(System::cost).sum::<usize>() * splits)
}

/// Fits a system to all rows but each fold's, and judges it there.
pub(super) fn scores(
    problem: &Problem,
    system: &System,
    split: &Split,
    settings: &SelectSettings,
    progress: &Progress<'_>,
) -> Result<Outcome, SelectError> {
    let weights = problem.weights(system, settings);
    let fitted = fit_complements(problem, &weights, system, split, settings, progress)?;
    let judge =
        Judge { problem, weights: &weights, system, method: settings.method, fitted: &fitted };
    // By ridge, then fold.
    let mut sums = vec![Vec::with_capacity(split.folds.rows.len()); system.ridges.len()];
    let mut determined = 0;
    for (fold, rows) in split.folds.rows.iter().enumerate() {
        let blocks: Vec<_> =
            rows.par_chunks(BLOCK_ROWS).map(|rows| judge.sums(fold, rows)).collect();
        for (ridge, of_folds) in sums.iter_mut().enumerate() {
            of_folds.push(blocks.iter().map(|block| block[ridge]).sum());
        }
        let is_determined = |row: &&usize| judge.is_determined(fold, **row);
        determined += rows.iter().filter(is_determined).count();
    }
    let has_rotations = problem.set.has_rotations;
    Ok(Outcome {
        scores: sums
            .into_iter()
            .map(|by_fold| HeldOutScores::of_sums(by_fold, has_rotations))
            .collect(),
        is_determined: 2 * determined > problem.set.samples.len(),
    })
}

/// What a candidate leaves of each row when its fold is held out, in the order of the rows.
pub(super) fn residuals(
    problem: &Problem,
    candidate: &Candidate,
    split: &Split,
    settings: &SelectSettings,
    task: &Task,
) -> Result<Vec<Residual>, SelectError> {
    let system = System {
        order: candidate.order,
        directions: candidate.directions,
        ridges: vec![candidate.ridge],
    };
    let progress = progress(task, std::slice::from_ref(&system), 1);
    let weights = problem.weights(&system, settings);
    let fitted = fit_complements(problem, &weights, &system, split, settings, &progress)?;
    let judge = Judge {
        problem,
        weights: &weights,
        system: &system,
        method: settings.method,
        fitted: &fitted,
    };
    let mut residuals = vec![[0.0; VALUES]; problem.set.samples.len()];
    for (fold, rows) in split.folds.rows.iter().enumerate() {
        judge.each(fold, rows, |row, _, residual| residuals[row] = residual);
    }
    Ok(residuals)
}

/// Fits to all rows but one fold's: by orientation (one for all where they are fitted jointly),
/// then fold.
fn fit_complements(
    problem: &Problem,
    weights: &[DirectionWeights],
    system: &System,
    split: &Split,
    settings: &SelectSettings,
    progress: &Progress<'_>,
) -> Result<Vec<Vec<Fitted>>, SelectError> {
    if system.order == 0 {
        return Ok(Vec::new());
    }
    let fit_settings = settings.fit_settings(&system.candidate(0.0));
    let quiet = progress.quiet();
    // By fold, then orientation.
    let parts: Vec<Vec<Triangle>> = split
        .samples
        .par_iter()
        .map(|part| Ok(factor(part, &fit_settings, Some(problem.bounds), &quiet)?.systems()))
        .collect::<Result<_, SelectError>>()?;
    let count = parts.first().map_or(0, Vec::len);
    (0..count)
        .into_par_iter()
        .map(|i| {
            let is_used = |row: usize| match settings.method {
                FitMethod::PerDirection => weights[row].of(i) > 0.0,
                FitMethod::Joint => true,
            };
            progress.add(0)?;
            let of_folds: Vec<&Triangle> = parts.iter().map(|fold| &fold[i]).collect();
            let found = complements(&of_folds)
                .par_iter()
                .enumerate()
                .map(|(left_out, others)| {
                    progress.add(0)?;
                    let decomposition = others.decompose()?;
                    let (coefficients, unknowns) =
                        solve_all(&decomposition, settings.rcond, &system.ridges);
                    let folds = split.folds.rows.iter().enumerate();
                    let rows = folds
                        .filter(|(fold, _)| *fold != left_out)
                        .flat_map(|(_, rows)| rows.iter().copied());
                    Ok(Fitted {
                        coefficients,
                        is_determined: problem.places(rows.filter(|&row| is_used(row))) > unknowns,
                    })
                })
                .collect();
            progress.add(system.cost() / count)?;
            found
        })
        .collect()
}

/// For each part the triangle of all others, from those before it and those after it: a number of
/// merges in proportion to that of parts.
fn complements(parts: &[&Triangle]) -> Vec<Triangle> {
    let merged = |a: &Triangle, b: &Triangle| Triangle::merged([a, b]);
    // By number of parts left out at the front, from all but none to all but all.
    let mut after: Vec<Option<Triangle>> = vec![None];
    for &part in parts.iter().rev() {
        after.push(match after.last() {
            Some(Some(rest)) => merged(part, rest),
            _ => Some(part.clone()),
        });
    }
    after.pop();
    let mut before: Option<Triangle> = None;
    let mut complements = Vec::with_capacity(parts.len());
    for &part in parts {
        let rest = after.pop().flatten();
        complements.extend(match (&before, &rest) {
            (Some(a), Some(b)) => merged(a, b),
            (Some(one), None) | (None, Some(one)) => Some(one.clone()),
            (None, None) => None,
        });
        before = match before {
            Some(before) => merged(&before, part),
            None => Some(part.clone()),
        };
    }
    complements
}

/// The solution for every ridge as `[unknown][ridge][value]`, and the number of unknowns.
fn solve_all(decomposition: &Decomposition, rcond: f64, ridges: &[f64]) -> (Vec<f64>, usize) {
    let solutions: Vec<_> =
        ridges.iter().map(|&ridge| decomposition.solve(rcond, ridge).unknowns).collect();
    let unknowns = solutions.first().map_or(0, Vec::len);
    let coefficients =
        (0..unknowns).flat_map(|i| solutions.iter().flat_map(move |x| x[i])).collect();
    (coefficients, unknowns)
}

/// A fitted system, to be judged on the rows it has not seen.
struct Judge<'a> {
    problem: &'a Problem<'a>,
    weights: &'a [DirectionWeights],
    system: &'a System,
    method: FitMethod,
    /// By orientation (one for all where they are fitted jointly), then fold.
    fitted: &'a [Vec<Fitted>],
}

impl Judge<'_> {
    /// Sums over held-out rows for each ridge.
    fn sums(&self, fold: usize, rows: &[usize]) -> Vec<FoldSums> {
        let mut sums = vec![FoldSums::default(); self.system.ridges.len()];
        self.each(fold, rows, |_, ridge, residual| {
            sums[ridge].add(&FoldSums::of(&residual));
        });
        sums
    }

    /// Calls `visit` with the row, the ridge's place and what is left of the row by equation (8).
    fn each(&self, fold: usize, rows: &[usize], mut visit: impl FnMut(usize, usize, Residual)) {
        let mut products = Vec::with_capacity(coefficient_count(self.system.order));
        let mut predicted = vec![0.0; self.system.ridges.len() * VALUES];
        for &row in rows {
            predicted.fill(0.0);
            if self.system.order > 0 {
                self.predict(fold, row, &mut products, &mut predicted);
            }
            let measured = self.problem.set.samples[row].error.values();
            for (ridge, p) in predicted.chunks_exact(VALUES).enumerate() {
                visit(row, ridge, std::array::from_fn(|i| measured[i] - p[i]));
            }
        }
    }

    /// Six values for each ridge, added to `predicted`.
    fn predict(&self, fold: usize, row: usize, products: &mut Vec<f64>, predicted: &mut [f64]) {
        products.clear();
        push_products(self.system.order, &self.problem.unit_positions[row], products);
        let DirectionWeights { directions, weights } = self.weights[row];
        for (direction, w) in directions.into_iter().zip(weights) {
            if w == 0.0 {
                continue;
            }
            let coefficients = match self.method {
                FitMethod::PerDirection => &self.fitted[direction][fold].coefficients[..],
                FitMethod::Joint => {
                    let width = products.len() * predicted.len();
                    &self.fitted[0][fold].coefficients[direction * width..][..width]
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
        let DirectionWeights { directions, weights } = self.weights[row];
        let nearest = (0..3).max_by(|&a, &b| weights[a].total_cmp(&weights[b]));
        let of_system = match (self.method, nearest) {
            (FitMethod::PerDirection, Some(k)) => self.fitted.get(directions[k]),
            _ => self.fitted.first(),
        };
        // Order 0 has no systems and leaves nothing open.
        of_system.is_none_or(|folds| folds[fold].is_determined)
    }
}
