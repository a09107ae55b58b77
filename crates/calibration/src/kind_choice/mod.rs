//! Which kind of model a room's measurements are fitted with: all are judged on the same rows held out.

mod decide;
mod harmonic;
mod judge;
mod kinds;
mod options;
mod rule;

pub use decide::{Decided, MOST_RACED, Wanted, best_kind, decide};
pub use kinds::{KindChoice, KindError, KindScored, TriedKind};
pub use options::{OptionsError, TriedOptions};

use super::room_choice::{Chosen, choose_by};
use super::row_labels::RowLabels;
use judge::Judge;
use trackwright_field::samples::SampleSet;
use trackwright_field::selection::{SelectError, SelectSettings};
use trackwright_task::Task;

/// Tries the kinds on the same rows held out, polynomials always; a kind that cannot be judged, or is
/// clearly behind another, is left out with its reason.
///
/// # Errors
/// Rows that cannot be folded, and work that was cancelled.
pub fn choose_kind(
    samples: &SampleSet,
    labels: RowLabels,
    tried: &SelectSettings,
    kinds: &[TriedKind],
    task: &Task,
) -> Result<(Chosen, KindChoice), KindError> {
    let subtask = |i: usize| {
        let parts = kinds.len() as f64 + 1.0;
        task.subtask(i as f64 / parts, (i + 1) as f64 / parts)
    };
    let chosen = choose_by(samples, labels.clone(), tried.clone(), &subtask(0))?;
    let judge = Judge { samples, labels: &labels, tried };
    let (mut scored, mut left_out): (Vec<KindScored>, _) = (Vec::new(), Vec::new());
    for (i, kind) in kinds.iter().enumerate() {
        let task = subtask(i + 1);
        match judge.judged(kind, &chosen, &scored, &task) {
            // Polynomials may have been found to be no better than none.
            Ok(kind) if scored.iter().any(|other| other.label() == kind.label()) => {}
            Ok(kind) => scored.push(kind),
            Err(error) if error.is_cancelled() => return Err(error),
            Err(error) => left_out.push((kind.label(), error.to_string())),
        }
    }
    scored.sort_by(|a, b| {
        let rms = |k: &KindScored| k.deciding().overall.position_rms_mm;
        rms(a).total_cmp(&rms(b))
    });
    let best = rule::best_of(&scored).ok_or(SelectError::NothingToTry("kinds of models"))?;
    let choice = KindChoice { kinds: scored, best, left_out };
    Ok((chosen, choice))
}
