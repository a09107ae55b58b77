//! The model that a room gets: as it was requested, or the best of all kinds.

use super::{KindChoice, KindError, TriedKind, choose_kind};
use crate::learning_curve::labels_of;
use crate::room_choice::{Chosen, ModelChoice, ModelRequest, choose_by};
use crate::room_model::RoomModel;
use crate::row_labels::RowLabels;
use trackwright_field::computed::ModelKind;
use trackwright_field::fit::FitSettings;
use trackwright_field::gaussian::chosen_rows;
use trackwright_field::samples::SampleSet;
use trackwright_field::selection::SelectSettings;
use trackwright_field::selection::sensors::SensorSpread;
use trackwright_task::Task;

/// Rows that kinds are judged on: of more, so many taken by chance. The chosen one is fitted to all.
pub const MOST_RACED: usize = 4_000;

/// Which kinds of models a room may get.
#[derive(Clone, Debug, PartialEq)]
pub enum Wanted {
    /// This one; what is left open of polynomials is chosen.
    One(RoomModel),
    /// The best of these.
    Best(Vec<TriedKind>),
}

/// What to fit to a room's measurements, and how it was decided.
#[derive(Clone, Debug, PartialEq)]
pub struct Decided {
    pub model: RoomModel,
    /// Of polynomials; of any model, the map.
    pub settings: FitSettings,
    /// What cross-validation chose of polynomials, where any were tried.
    pub chosen: Option<Chosen>,
    /// How the kinds did, where several were tried.
    pub kinds: Option<KindChoice>,
}

impl Decided {
    /// What sensors differ by among themselves, where they were held out.
    pub fn sensors(&self) -> Option<SensorSpread> {
        self.chosen.as_ref().and_then(|chosen| chosen.selection.sensors)
    }
}

impl Wanted {
    /// Whether rows are held out to decide: not for a model that leaves nothing open, unless it is to be
    /// judged as well.
    pub fn is_open(&self, request: &ModelRequest, samples: &SampleSet, is_judged: bool) -> bool {
        match self {
            Self::Best(_) => true,
            Self::One(model) if model.kind() != ModelKind::Bernstein => false,
            Self::One(_) => is_judged || matches!(request.wanted(samples), ModelChoice::Open(_)),
        }
    }
}

/// Decides by cross-validation what the request leaves open; with `is_judged` also how polynomials do of
/// which nothing is open. Of a model that is not open ([`Wanted::is_open`]) the labels are not looked at.
///
/// # Errors
/// Those of [`choose_kind`].
pub fn decide(
    samples: &SampleSet,
    (wanted, request): (&Wanted, &ModelRequest),
    is_judged: bool,
    labels: RowLabels,
    task: &Task,
) -> Result<Decided, KindError> {
    match wanted {
        Wanted::One(model) if model.kind() != ModelKind::Bernstein => Ok(Decided {
            model: model.clone(),
            settings: FitSettings::without_polynomials(request.map),
            chosen: None,
            kinds: None,
        }),
        Wanted::One(model) => {
            let model = model.clone();
            let tried = match request.wanted(samples) {
                ModelChoice::Fixed(settings) if !is_judged => {
                    return Ok(Decided { model, settings, chosen: None, kinds: None });
                }
                open => open.tried(samples),
            };
            let chosen = choose_by(samples, labels, tried, task)?;
            let settings = chosen.settings();
            Ok(Decided { model, settings, chosen: Some(chosen), kinds: None })
        }
        Wanted::Best(kinds) => {
            let tried =
                SelectSettings { only_contenders: true, ..request.wanted(samples).tried(samples) };
            let (chosen, choice) = best_kind(samples, labels, &tried, kinds, task)?;
            let kind = choice.best();
            Ok(Decided {
                model: kind.model.clone(),
                settings: kind.settings(&tried),
                chosen: Some(chosen),
                kinds: Some(choice),
            })
        }
    }
}

/// [`choose_kind`] on [`MOST_RACED`] of the rows, by chance, where there are more.
///
/// # Errors
/// Those of [`choose_kind`].
pub fn best_kind(
    samples: &SampleSet,
    labels: RowLabels,
    tried: &SelectSettings,
    kinds: &[TriedKind],
    task: &Task,
) -> Result<(Chosen, KindChoice), KindError> {
    let rows = chosen_rows(samples.samples.len(), MOST_RACED);
    if rows.len() == samples.samples.len() {
        return choose_kind(samples, labels, tried, kinds, task);
    }
    choose_kind(&samples.of_rows(&rows), labels_of(&labels, &rows), tried, kinds, task)
}
