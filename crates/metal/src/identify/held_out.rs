//! How many bodies, and of which form: what solutions of the other folds leave of measurements held out.

use super::noise::losses;
use super::rows::Rows;
use super::search::{Solutions, compact, extended};
use super::solve::{Bodies, Solution};
use super::sources::SourceModel;
use rayon::prelude::*;
use std::sync::atomic::{AtomicUsize, Ordering};
use trackwright_field::selection::folds::Folds;
use trackwright_task::{Cancelled, Task};

/// Standard errors beyond which a difference of held-out losses is not taken for noise.
const CLEAR: f64 = 2.0;

/// Standard deviations of χ² beyond which a loss that is less by so much is not taken for more unknowns.
const CLEAR_OF_ALL: f64 = 2.0;

/// A loss of bodies of any form that is so much more than the least is not looked at in folds.
const HOPELESS: f64 = 400.0;

/// Numbers that a tensor has more than a strength.
const MORE_OF_TENSOR: f64 = 5.0;

/// What all rows are explained with: compact bodies and bodies of any form, by their number, none first.
pub(super) struct Found {
    pub compact: Vec<Solutions>,
    pub extended: Vec<Solutions>,
}

/// So many bodies, compact ones or of any form.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Candidate {
    pub bodies: usize,
    pub is_extended: bool,
}

impl Found {
    /// Searches anew; `known` are solutions of rows that are nearly the same.
    pub fn new<'a>(
        task: &Task,
        rows: &Rows,
        most: usize,
        known: Option<&'a Self>,
    ) -> Result<Self, Cancelled> {
        let none = || vec![vec![Solution::none(rows)]];
        let mut found = Self { compact: none(), extended: none() };
        let known_of = |is_extended: bool, bodies: usize| {
            let of = |known: &'a Self| known.of(Candidate { bodies, is_extended });
            known.and_then(of).map_or(&[][..], |solutions| solutions)
        };
        let none = Solution::none(rows);
        for count in 1..=most {
            task.step(count - 1, most)?;
            let last = |all: &[Solutions]| all.get(count - 1).and_then(|all| all.first().cloned());
            let (compact_base, extended_base) = (last(&found.compact), last(&found.extended));
            let mut before = compact_base.iter().chain(&extended_base);
            if count > 1 && before.any(|solution| solution.is_noise(rows.dof)) {
                break;
            }
            if let Some(base) = &compact_base {
                let known_base = known_of(false, count - 1).first();
                let new = compact(task, rows, base, known_of(false, count), known_base)?;
                found.compact.extend((!new.is_empty()).then_some(new));
            }
            let known_extended = known_of(true, count);
            let has_hope = |known: &Self| {
                known.candidates().contains(&Candidate { bodies: count, is_extended: true })
            };
            let as_many = found.compact.get(count).map(|solutions| &solutions[0]);
            let new = match (known.is_none_or(has_hope), &extended_base) {
                (true, Some(base)) => extended(task, rows, base, as_many, known_extended)?,
                (true, None) if !known_extended.is_empty() => {
                    extended(task, rows, &none, as_many, known_extended)?
                }
                _ => Vec::new(),
            };
            found.extended.push(new);
        }
        Ok(found)
    }

    /// The simplest one first.
    pub fn candidates(&self) -> Vec<Candidate> {
        let most = self.compact.len().max(self.extended.len());
        (0..most)
            .flat_map(|bodies| [false, true].map(|is_extended| Candidate { bodies, is_extended }))
            .filter(|candidate| match self.best(*candidate) {
                Some(best) if candidate.is_extended => {
                    candidate.bodies > 0 && best.loss < self.least_loss() + HOPELESS
                }
                best => best.is_some(),
            })
            .collect()
    }

    fn least_loss(&self) -> f64 {
        let all =
            self.compact.iter().chain(&self.extended).filter_map(|solutions| solutions.first());
        all.map(|best| best.loss).fold(f64::INFINITY, f64::min)
    }

    pub fn of(&self, candidate: Candidate) -> Option<&Solutions> {
        let all = if candidate.is_extended { &self.extended } else { &self.compact };
        all.get(candidate.bodies)
    }

    pub fn best(&self, candidate: Candidate) -> Option<&Solution> {
        self.of(candidate)?.first()
    }
}

/// The bodies found without one fold, for each candidate.
pub(super) struct FoldSolutions {
    pub without: Vec<Vec<Bodies>>,
    /// For each candidate the mean loss of a row held out, in squares of noise.
    pub mean_losses: Vec<f64>,
    /// The candidate that the losses support.
    pub chosen: usize,
}

/// Searches anew without each fold, beginning from what is `known` with all rows. What is not found without a fold does
/// no better there than the candidate before.
pub(super) fn hold_out(
    task: &Task,
    rows: &Rows,
    folds: &Folds,
    known: &Found,
) -> Result<FoldSolutions, Cancelled> {
    let quiet = Task::cancelled_by(task.cancel.clone());
    let all: Vec<usize> = (0..rows.len()).collect();
    let candidates = known.candidates();
    let most = known.compact.len().max(known.extended.len()) - 1;
    let done = AtomicUsize::new(0);
    let of_fold = |out: &Vec<usize>| {
        let rest: Vec<usize> =
            all.iter().copied().filter(|m| out.binary_search(m).is_err()).collect();
        let found = Found::new(&quiet, &rows.some(&rest), most, Some(known))?;
        let out_rows = rows.some(out);
        let mut bodies: Vec<Bodies> = Vec::new();
        let mut out_losses: Vec<Vec<f64>> = Vec::new();
        for candidate in &candidates {
            let Some(best) = found.best(*candidate) else {
                bodies.extend(bodies.last().cloned());
                out_losses.extend(out_losses.last().cloned());
                continue;
            };
            // A measurement held out may be in a sphere that the others leave room for.
            let explained = best
                .bodies()
                .explained(&out_rows)
                .or_else(|| SourceModel::Dipoles.explained(&out_rows, &best.sources))
                .unwrap_or_else(|| vec![0.0; out_rows.right.len()]);
            out_losses.push(losses(&out_rows, &out_rows.left(&explained)));
            bodies.push(best.bodies());
        }
        task.step(done.fetch_add(1, Ordering::Relaxed) + 1, folds.rows.len())?;
        Ok::<_, Cancelled>((bodies, out_losses))
    };
    let found: Vec<_> = folds.rows.par_iter().map(of_fold).collect::<Result<_, _>>()?;
    let losses_of = |candidate: usize| -> Vec<f64> {
        found.iter().flat_map(|(_, losses)| losses[candidate].iter().copied()).collect()
    };
    let losses: Vec<Vec<f64>> = (0..candidates.len()).map(losses_of).collect();
    let mean = |losses: &Vec<f64>| losses.iter().sum::<f64>() / losses.len() as f64;
    let mean_losses: Vec<f64> = losses.iter().map(mean).collect();
    let all = 0..candidates.len();
    let least = all.min_by(|&a, &b| mean_losses[a].total_cmp(&mean_losses[b])).unwrap_or(0);
    // The simplest that is not clearly worse than the best.
    let clear = |k: &usize| !is_clearly_more(&losses[*k], &losses[least], CLEAR);
    let mut chosen = (0..least).find(clear).unwrap_or(least);
    if let Some(next) = candidates.get(chosen + 1)
        && next.bodies == candidates[chosen].bodies
        && let (Some(compact), Some(extended)) = (known.best(candidates[chosen]), known.best(*next))
    {
        let more = MORE_OF_TENSOR * next.bodies as f64;
        let gain = (compact.loss - extended.loss) / extended.variance(rows.dof).max(1.0);
        if gain > more + CLEAR_OF_ALL * (2.0 * more).sqrt() {
            chosen += 1;
        }
    }
    Ok(FoldSolutions {
        without: found.into_iter().map(|(bodies, _)| bodies).collect(),
        mean_losses: mean_losses.iter().map(|loss| loss / rows.dof as f64).collect(),
        chosen,
    })
}

/// Whether losses are more than others of the same measurements by so many standard errors of their differences.
pub(super) fn is_clearly_more(losses: &[f64], others: &[f64], clear: f64) -> bool {
    let count = losses.len() as f64;
    let differences: Vec<f64> = losses.iter().zip(others).map(|(a, b)| a - b).collect();
    let mean = differences.iter().sum::<f64>() / count;
    let squares: f64 = differences.iter().map(|d| (d - mean).powi(2)).sum();
    mean > clear * (squares / (count * (count - 1.0).max(1.0))).sqrt()
}
