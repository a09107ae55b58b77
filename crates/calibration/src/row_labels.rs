//! Which of a table's rows belong together, and what of them is held out.

use trackwright_field::samples::SampleSet;
use trackwright_field::selection::places::{self, Places};
use trackwright_field::selection::{HoldOutBy, HoldOuts, clusters, folds, path};

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

/// A column of a table: its name, and the text of each row.
pub type LabelColumn<'a> = (&'a str, &'a [String]);

impl RowLabels {
    /// The labels of a table's columns of groups and of sensors, and what is to be held out,
    /// where that is stated.
    ///
    /// # Errors
    /// A column of another number of rows; nothing of what is to be held out.
    pub fn of(
        samples: &SampleSet,
        groups: Option<LabelColumn<'_>>,
        sensors: Option<LabelColumn<'_>>,
        deciding: Option<HoldOutBy>,
    ) -> Result<Self, RowLabelsError> {
        let grouping = row_groups(samples, groups)?;
        let rows = samples.samples.len();
        let sensors = sensors.map(|(name, labels)| numbered_labels(name, labels, rows));
        match deciding {
            Some(HoldOutBy::Groups) if grouping.is_none() => Err(RowLabelsError::NoGroups),
            Some(HoldOutBy::Sensors) if sensors.is_none() => Err(RowLabelsError::NoSensors),
            _ => Ok(Self { grouping, sensors: sensors.transpose()?, deciding }),
        }
    }
}

/// Why nothing can be held out.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum RowLabelsError {
    #[error(transparent)]
    Rows(#[from] GroupRowsError),
    #[error(
        "found no groups of rows to hold out, expected a column cluster, frame or pose, places that were measured \
         several times, or a named column"
    )]
    NoGroups,
    #[error("found no column \"sensor\", expected one that names the sensor of each row")]
    NoSensors,
}

/// A column of groups that does not belong to the rows.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("column {name} has {found} rows, expected {expected}")]
pub struct GroupRowsError {
    pub name: String,
    pub found: usize,
    pub expected: usize,
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
fn numbered_labels(
    name: &str,
    labels: &[String],
    rows: usize,
) -> Result<Vec<usize>, GroupRowsError> {
    match labels.len() == rows {
        true => Ok(folds::numbered(labels).0),
        false => Err(GroupRowsError { name: name.to_owned(), found: labels.len(), expected: rows }),
    }
}
