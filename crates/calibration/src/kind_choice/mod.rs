//! Which kind of model a room's measurements are fitted with: all are judged on the same rows held out.

mod decide;
mod harmonic;
mod judge;
mod options;
mod rule;

pub use decide::{Decided, MOST_RACED, Wanted, best_kind, decide};
pub use options::{OptionsError, TriedOptions};

use super::room_choice::{Chosen, choose_by};
use super::room_model::{GeneratorChoice, RoomModel, RoomModelError};
use super::row_labels::{GroupRowsError, RowLabels};
use judge::Judge;
use trackwright_field::computed::ModelKind;
use trackwright_field::fit::FitSettings;
use trackwright_field::harmonic::Loss;
use trackwright_field::samples::SampleSet;
use trackwright_field::selection::other::OtherScored;
use trackwright_field::selection::scoring::HeldOutScores;
use trackwright_field::selection::{Candidate, SelectError, SelectSettings};
use trackwright_task::Task;

/// A kind of model to try.
#[derive(Clone, Debug, PartialEq)]
pub enum TriedKind {
    NoCorrection,
    /// The best of the polynomials that are tried.
    Bernstein,
    /// The same with an axis and the one turned round having the same error.
    Symmetric,
    Kriging,
    Harmonic {
        generator: GeneratorChoice,
        /// Those around the highest that the rows determine, as long as they leave less.
        degrees: Vec<usize>,
        loss: Loss,
    },
}

/// The name of no correction, and of polynomials that are the same with the axis reversed.
const NO_CORRECTION: &str = "none";
const SYMMETRIC: &str = "symmetric";

/// The best model of a kind, and how it did on rows held out.
#[derive(Clone, Debug, PartialEq)]
pub struct KindScored {
    pub model: RoomModel,
    /// What fits it, of polynomials.
    pub candidate: Option<Candidate>,
    pub scores: OtherScored,
}

impl KindScored {
    /// As the command line names the kind.
    pub fn name(&self) -> &'static str {
        match (&self.model, &self.candidate) {
            (_, Some(Candidate { order: 0, .. })) => NO_CORRECTION,
            (RoomModel::Bernstein { is_symmetric: true }, _) => SYMMETRIC,
            (other, _) => other.kind().name(),
        }
    }

    /// The same, with the generator where there may be several.
    pub fn label(&self) -> String {
        match &self.model {
            RoomModel::Harmonic(order) => format!("harmonic, {}", order.generator.name()),
            _ => self.name().to_owned(),
        }
    }

    /// The scores that decide.
    pub fn deciding(&self) -> &HeldOutScores {
        self.scores.deciding()
    }

    /// The settings of the fit.
    pub fn settings(&self, tried: &SelectSettings) -> FitSettings {
        match &self.candidate {
            Some(candidate) => tried.fit_settings(candidate),
            None => FitSettings::without_polynomials(tried.map),
        }
    }
}

/// Kinds in the order of what they leave of rows held out, and the chosen one's place.
#[derive(Clone, Debug, PartialEq)]
pub struct KindChoice {
    pub kinds: Vec<KindScored>,
    pub best: usize,
    /// Kinds that could not be judged or are clearly behind, and why.
    pub left_out: Vec<(String, String)>,
}

impl KindChoice {
    /// The chosen kind.
    pub fn best(&self) -> &KindScored {
        &self.kinds[self.best]
    }
}

#[derive(Debug, thiserror::Error)]
pub enum KindError {
    #[error(transparent)]
    Select(#[from] SelectError),
    #[error(transparent)]
    Model(#[from] RoomModelError),
    #[error(transparent)]
    Groups(#[from] GroupRowsError),
    #[error(
        "leaves {found_mm:.3} mm of the first rows held out, where {than} leaves {least_mm:.3} mm"
    )]
    Behind { found_mm: f64, least_mm: f64, than: String },
}

impl KindError {
    /// Whether the work was cancelled.
    pub fn is_cancelled(&self) -> bool {
        match self {
            Self::Select(error) => matches!(error, SelectError::Cancelled(_)),
            Self::Model(error) => error.is_cancelled(),
            Self::Groups(_) | Self::Behind { .. } => false,
        }
    }
}

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

impl TriedKind {
    /// As the command line names it.
    pub fn name(&self) -> &'static str {
        match self {
            Self::NoCorrection => NO_CORRECTION,
            Self::Bernstein => ModelKind::Bernstein.name(),
            Self::Symmetric => SYMMETRIC,
            Self::Kriging => ModelKind::Kriging.name(),
            Self::Harmonic { .. } => ModelKind::Harmonic.name(),
        }
    }

    /// The same, with the generator where there may be several.
    pub fn label(&self) -> String {
        match self {
            Self::Harmonic { generator, .. } => format!("harmonic, {}", generator.name()),
            _ => self.name().to_owned(),
        }
    }
}
