//! Which model a room's measurements are fitted with: as it was requested, what was left open
//! chosen by cross-validation.

use super::row_labels::RowLabels;
use trackwright_field::fit::{FitMethod, FitSettings};
use trackwright_field::samples::{MapKind, SampleSet};
use trackwright_field::selection::places::Places;
use trackwright_field::selection::{Candidate, SelectError, SelectSettings, Selection, select_by};
use trackwright_geometry::directions::{DirectionSet, Weighting};
use trackwright_task::Task;

/// A model as far as the user states it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ModelRequest {
    pub order: Option<usize>,
    pub directions: Option<DirectionSet>,
    pub ridge: Option<f64>,
    pub method: FitMethod,
    pub map: MapKind,
    pub weighting: Weighting,
    pub rcond: f64,
}

#[derive(Clone, Debug, PartialEq)]
pub enum ModelChoice {
    /// Nothing is open.
    Fixed(FitSettings),
    /// One of these.
    Open(SelectSettings),
}

impl ModelChoice {
    /// What is tried where a model is judged although nothing of it is open, or as it is open.
    pub fn tried(self, samples: &SampleSet) -> SelectSettings {
        match self {
            Self::Open(tried) => tried,
            Self::Fixed(settings) => SelectSettings {
                orders: vec![settings.order],
                direction_sets: vec![settings.directions],
                ridges: vec![settings.ridge],
                method: settings.method,
                map: settings.map,
                weighting: settings.weighting,
                rcond: settings.rcond,
                ..SelectSettings::for_samples(samples)
            },
        }
    }
}

/// What cross-validation chose, of what.
#[derive(Clone, Debug, PartialEq)]
pub struct Chosen {
    pub selection: Selection,
    pub tried: SelectSettings,
    pub by: Option<String>,
    pub places: Option<Places>,
}

impl ModelRequest {
    /// The settings, or what is to be tried: orders 0 to 6 with every set of orientations.
    pub fn wanted(&self, samples: &SampleSet) -> ModelChoice {
        // Without orientations there is only one set of them: no choice.
        let directions =
            self.directions.or_else(|| (!samples.has_rotations).then_some(DirectionSet::One));
        let tried = SelectSettings {
            method: self.method,
            map: self.map,
            weighting: self.weighting,
            rcond: self.rcond,
            ..SelectSettings::for_samples(samples)
        };
        if let (Some(order), Some(directions)) = (self.order, directions) {
            return ModelChoice::Fixed(tried.fit_settings(&Candidate {
                order,
                directions,
                ridge: self.ridge.unwrap_or(0.0),
            }));
        }
        ModelChoice::Open(SelectSettings {
            orders: self.order.map_or(tried.orders, |order| vec![order]),
            direction_sets: directions.map_or(tried.direction_sets, |set| vec![set]),
            ridges: self.ridge.map_or(tried.ridges, |ridge| vec![ridge]),
            ..tried
        })
    }
}

/// Tries the models in every hold-out that is known, and chooses by the one that decides.
pub fn choose_by(
    samples: &SampleSet,
    labels: RowLabels,
    tried: SelectSettings,
    task: &Task,
) -> Result<Chosen, SelectError> {
    let hold_outs = labels.hold_outs();
    let selection = select_by(samples, &hold_outs, &tried, task)?;
    let (by, places) = labels.grouping.map(|g| (g.by, g.places)).unzip();
    Ok(Chosen { selection, tried, by, places: places.flatten() })
}

impl Chosen {
    /// What fits the chosen model to all samples.
    pub fn settings(&self) -> FitSettings {
        self.tried.fit_settings(&self.selection.best().candidate)
    }
}
