//! Which model a room's measurements are fitted with: as it was requested, what was left open
//! chosen by cross-validation.

use trackwright_field::fit::{FitMethod, FitSettings};
use trackwright_field::samples::{MapKind, SampleSet};
use trackwright_field::selection::places::{self, Places};
use trackwright_field::selection::{
    Candidate, HoldOutBy, HoldOuts, SelectError, SelectSettings, Selection, clusters, folds, path,
    select_by,
};
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

/// What is to be held out, as a person names it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum HeldOut {
    Rows,
    Groups,
    Sensors,
    /// Rows with equal text in this column.
    Column(String),
}

impl From<&str> for HeldOut {
    fn from(text: &str) -> Self {
        match text {
            "rows" => Self::Rows,
            "groups" => Self::Groups,
            // The column that names sensors means the same.
            "sensors" | "sensor" => Self::Sensors,
            column => Self::Column(column.to_owned()),
        }
    }
}

impl HeldOut {
    /// Which hold-out decides then.
    pub fn deciding(&self) -> HoldOutBy {
        match self {
            Self::Rows => HoldOutBy::Rows,
            Self::Groups | Self::Column(_) => HoldOutBy::Groups,
            Self::Sensors => HoldOutBy::Sensors,
        }
    }

    /// The column that groups rows, where one is named.
    pub fn column(&self) -> Option<&str> {
        match self {
            Self::Column(column) => Some(column),
            Self::Rows | Self::Groups | Self::Sensors => None,
        }
    }
}

/// Which rows are held out together, and who decided it.
#[derive(Clone, Debug, PartialEq)]
pub struct Grouping {
    /// "column cluster", "clusters of positions", "places found from the data", "pieces of a path".
    pub by: String,
    pub groups: Vec<usize>,
    /// Whether no input states it: fewer groups than folds are then held out in fewer folds.
    pub is_found: bool,
    /// What the places were found by, where it is they.
    pub places: Option<Places>,
}

/// What is known of which rows belong together, and what is to decide.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RowLabels {
    pub grouping: Option<Grouping>,
    pub sensors: Option<Vec<usize>>,
    /// `None`: groups where there are any, else rows.
    pub deciding: Option<HoldOutBy>,
}

impl RowLabels {
    /// The group of each row, where there are any.
    pub fn groups(&self) -> Option<&[usize]> {
        self.grouping.as_ref().map(|g| g.groups.as_slice())
    }

    /// What is held out.
    pub fn hold_outs(&self) -> HoldOuts<'_> {
        HoldOuts {
            groups: self.groups(),
            sensors: self.sensors.as_deref(),
            has_few_groups: self.deciding == Some(HoldOutBy::Groups)
                || self.grouping.as_ref().is_some_and(|g| g.is_found),
            deciding: self.deciding,
            only_deciding: false,
        }
    }
}

/// A column of groups that does not belong to the rows.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("column {name} has {found} rows, expected {expected}")]
pub struct GroupRowsError {
    pub name: String,
    pub found: usize,
    pub expected: usize,
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

/// The groups of a table's rows, if there are any: by a column of labels where there is one (its name first), else
/// by places whose readings depend on each other or the clusters that the positions themselves show,
/// whichever are fewer, else by pieces of the path that the rows are.
///
/// # Errors
/// A column with more or fewer rows than the samples.
pub fn row_groups(
    samples: &SampleSet,
    column: Option<(&str, &[String])>,
) -> Result<Option<Grouping>, GroupRowsError> {
    let rows = samples.samples.len();
    if let Some((name, labels)) = column {
        return Ok(Some(Grouping {
            by: format!("column {name}"),
            groups: numbered_labels(name, labels, rows)?,
            is_found: false,
            places: None,
        }));
    }
    let positions: Vec<_> = samples.samples.iter().map(|s| s.position_mm).collect();
    let count = |groups: &[usize]| groups.iter().max().map_or(0, |last| last + 1);
    let clusters = clusters::find(&positions);
    // Clusters that are more than the places have taken some places to pieces.
    let is_better = |places: &Places| clusters.as_ref().is_none_or(|c| places.count < count(c));
    let found = match places::find(samples).filter(is_better) {
        Some(places) => Some(("places found from the data", places.groups.clone(), Some(places))),
        None => match clusters {
            Some(clusters) => Some(("clusters of positions", clusters, None)),
            None => path::pieces(samples).map(|pieces| ("pieces of a path", pieces, None)),
        },
    };
    Ok(found.map(|(by, groups, places)| Grouping {
        by: by.to_owned(),
        groups,
        is_found: true,
        places,
    }))
}

/// A column of labels as numbers, one a row; an error for another number of rows.
pub fn numbered_labels(
    name: &str,
    labels: &[String],
    rows: usize,
) -> Result<Vec<usize>, GroupRowsError> {
    match labels.len() == rows {
        true => Ok(folds::numbered(labels).0),
        false => Err(GroupRowsError { name: name.to_owned(), found: labels.len(), expected: rows }),
    }
}

/// Tries the models on rows held out by their groups, and chooses.
pub fn choose(
    samples: &SampleSet,
    grouping: Option<Grouping>,
    tried: SelectSettings,
    task: &Task,
) -> Result<Chosen, SelectError> {
    let labels = RowLabels { grouping, ..RowLabels::default() };
    choose_by(samples, labels, tried, task)
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
