//! How many bodies: what solutions of the other folds leave of measurements held out.

use super::noise::losses;
use super::rows::Rows;
use super::search::{Solutions, search};
use super::sources::{Source, SourceModel};
use rayon::prelude::*;
use std::sync::atomic::{AtomicUsize, Ordering};
use trackwright_field::selection::folds::Folds;
use trackwright_task::{Cancelled, Task};

/// Standard errors beyond which a difference of held-out losses is not taken for noise.
const CLEAR: f64 = 2.0;

/// The bodies found without one fold, for each number of bodies, none first.
pub(super) struct FoldSolutions {
    pub without: Vec<Vec<(SourceModel, Vec<Source>)>>,
    /// For each number of bodies the mean loss of a row held out, in squares of noise.
    pub mean_losses: Vec<f64>,
    /// The number of bodies that the losses support.
    pub bodies: usize,
}

/// Searches anew without each fold, beginning from bodies that are `known` with all rows. A number of bodies that is not found without a fold does no better
/// there than the number before.
pub(super) fn hold_out(
    task: &Task,
    rows: &Rows,
    folds: &Folds,
    most: usize,
    known: &[Solutions],
) -> Result<FoldSolutions, Cancelled> {
    let quiet = Task::cancelled_by(task.cancel.clone());
    let all: Vec<usize> = (0..rows.len()).collect();
    let done = AtomicUsize::new(0);
    let of_fold = |out: &Vec<usize>| {
        let rest: Vec<usize> =
            all.iter().copied().filter(|m| out.binary_search(m).is_err()).collect();
        let found = search(&quiet, &rows.some(&rest), most, known)?;
        let out_rows = rows.some(out);
        let mut sources: Vec<(SourceModel, Vec<Source>)> = Vec::new();
        let mut out_losses: Vec<Vec<f64>> = Vec::new();
        for count in 0..=most {
            let Some(best) = found.get(count).and_then(|solutions: &Solutions| solutions.first())
            else {
                sources.extend(sources.last().cloned());
                out_losses.extend(out_losses.last().cloned());
                continue;
            };
            // A measurement held out may be in a sphere that the others leave room for.
            let model = best.model;
            let explained = model
                .explained(&out_rows, &best.sources)
                .or_else(|| SourceModel::Dipoles.explained(&out_rows, &best.sources))
                .unwrap_or_else(|| vec![0.0; out_rows.right.len()]);
            out_losses.push(losses(&out_rows, &out_rows.left(&explained)));
            sources.push((model, best.sources.clone()));
        }
        task.step(done.fetch_add(1, Ordering::Relaxed) + 1, folds.rows.len())?;
        Ok::<_, Cancelled>((sources, out_losses))
    };
    let found: Vec<_> = folds.rows.par_iter().map(of_fold).collect::<Result<_, _>>()?;
    let losses_of = |count: usize| -> Vec<f64> {
        found.iter().flat_map(|(_, losses)| losses[count].iter().copied()).collect()
    };
    let by_count: Vec<Vec<f64>> = (0..=most).map(losses_of).collect();
    let mean = |losses: &Vec<f64>| losses.iter().sum::<f64>() / losses.len() as f64;
    let mean_losses: Vec<f64> = by_count.iter().map(mean).collect();
    let least = (0..=most).min_by(|&a, &b| mean_losses[a].total_cmp(&mean_losses[b])).unwrap_or(0);
    // The fewest bodies that are not clearly worse than the best number.
    let bodies = (0..least).find(|&count| !is_clearly_more(&by_count[count], &by_count[least]));
    Ok(FoldSolutions {
        without: found.into_iter().map(|(sources, _)| sources).collect(),
        mean_losses: mean_losses.iter().map(|loss| loss / rows.dof as f64).collect(),
        bodies: bodies.unwrap_or(least),
    })
}

/// Whether losses are more than others of the same measurements, by their differences.
fn is_clearly_more(losses: &[f64], others: &[f64]) -> bool {
    let count = losses.len() as f64;
    let differences: Vec<f64> = losses.iter().zip(others).map(|(a, b)| a - b).collect();
    let mean = differences.iter().sum::<f64>() / count;
    let squares: f64 = differences.iter().map(|d| (d - mean).powi(2)).sum();
    mean > CLEAR * (squares / (count * (count - 1.0).max(1.0))).sqrt()
}
