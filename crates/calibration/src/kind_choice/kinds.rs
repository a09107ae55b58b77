//! Kinds of models that may be tried, and how they did.

use crate::room_model::{GeneratorChoice, RoomModel, RoomModelError};
use crate::row_labels::GroupRowsError;
use trackwright_field::computed::ModelKind;
use trackwright_field::fit::FitSettings;
use trackwright_field::harmonic::Loss;
use trackwright_field::selection::other::OtherScored;
use trackwright_field::selection::scoring::HeldOutScores;
use trackwright_field::selection::{Candidate, SelectError, SelectSettings};

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
pub(super) const NO_CORRECTION: &str = "none";
pub(super) const SYMMETRIC: &str = "symmetric";

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
