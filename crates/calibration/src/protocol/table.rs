//! The protocol's table: the same rows for text, JSON, CSV and control charts.

use std::collections::BTreeMap;
use trackwright_result::Table;
use trackwright_simulation::statistics::Sample;

/// The condition of a row over everything that was measured of its kind.
pub const ALL: &str = "all";

/// What one run of the protocol found.
#[derive(Clone, Debug, PartialEq)]
pub struct ProtocolTable {
    /// Name of the room or of the recording.
    pub source: String,
    /// `2026-05-31`, where it is known.
    pub date: Option<String>,
    pub rows: Vec<ProtocolRow>,
}

impl ProtocolTable {
    /// The rows as a result.
    pub fn rows_table(&self) -> Table {
        Table::of("rows", &self.rows)
            .data("measure", |row| row.measure.key())
            .text("", "measure", |row| row.measure.label())
            .text("condition", "of", |row| row.condition.clone())
            .number("count", "count", 0, |row| row.statistics.count)
            .number("mean", "mean", 3, |row| row.statistics.mean)
            .number("std", "std", 3, |row| row.statistics.std)
            .number("rms", "rms", 3, |row| row.statistics.rms)
            .number("min", "min", 3, |row| row.statistics.min)
            .number("max", "max", 3, |row| row.statistics.max)
            .text("unit", "unit", |row| row.measure.unit())
            .data("worst", |row| row.worst.clone())
            .data("paper", |row| {
                row.paper().map(|found| {
                    BTreeMap::from_iter(["aurora", "microbird"].into_iter().zip(found))
                })
            })
            .text("", "paper: Aurora", |row| row.paper().unwrap_or_default()[0])
            .text("", "microBIRD", |row| row.paper().unwrap_or_default()[1])
            .done()
    }
}

/// One line of the table.
#[derive(Clone, Debug, PartialEq)]
pub struct ProtocolRow {
    pub measure: Measure,
    /// Levels, directions or distances that it is of.
    pub condition: String,
    pub statistics: Statistics,
    /// Where the value is that is farthest from zero.
    pub worst: String,
}

/// What is measured.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Measure {
    /// RMS distance of single readings from their mean, at each site.
    Jitter,
    /// Measured distance of two holes minus the true one, so many mm.
    Distance(u32),
    /// Measured turn of the disc by one step minus the true one.
    Rotation,
    /// How far a rod of this material shifts the reading.
    Rod(String),
}

/// Of the values of one row, in its unit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Statistics {
    pub count: usize,
    pub mean: f64,
    /// About the mean, of all values there are.
    pub std: f64,
    pub rms: f64,
    pub min: f64,
    pub max: f64,
}

impl Statistics {
    /// Of at least one value; `None` of none.
    pub fn of(values: impl IntoIterator<Item = f64>) -> Option<Self> {
        let mut values: Vec<f64> = values.into_iter().collect();
        let count = values.len();
        if count == 0 {
            return None;
        }
        let mut sample = Sample::new(&mut values);
        Some(Self {
            count,
            mean: sample.mean(),
            std: sample.std(),
            rms: sample.rms(),
            min: sample.min(),
            max: sample.max(),
        })
    }
}

impl Measure {
    /// What files write.
    pub fn key(&self) -> String {
        match self {
            Self::Jitter => "jitter".to_owned(),
            Self::Distance(mm) => format!("distance_{mm}"),
            Self::Rotation => "rotation".to_owned(),
            Self::Rod(material) => format!("rod_{material}"),
        }
    }

    /// The measure of a key; `None` where it is not one.
    pub fn of_key(key: &str) -> Option<Self> {
        if let Some(mm) = key.strip_prefix("distance_") {
            return mm.parse().ok().map(Self::Distance);
        }
        match key {
            "jitter" => Some(Self::Jitter),
            "rotation" => Some(Self::Rotation),
            _ => key.strip_prefix("rod_").map(|material| Self::Rod(material.to_owned())),
        }
    }

    /// For a person.
    pub fn label(&self) -> String {
        match self {
            Self::Jitter => "jitter".to_owned(),
            Self::Distance(mm) => format!("error of {mm} mm"),
            Self::Rotation => "error of a turn".to_owned(),
            Self::Rod(material) => format!("rod of {material}"),
        }
    }

    pub fn unit(&self) -> &'static str {
        match self {
            Self::Rotation => "deg",
            _ => "mm",
        }
    }
}

impl ProtocolTable {
    /// The row of a measure over everything, or under a condition.
    pub fn row(&self, measure: &Measure, condition: &str) -> Option<&ProtocolRow> {
        self.rows.iter().find(|row| row.measure == *measure && row.condition == condition)
    }
}

impl ProtocolRow {
    /// What the paper found of the NDI Aurora and the Ascension microBIRD, as its abstract has it; none
    /// for what that does not name.
    pub fn paper(&self) -> Option<[&'static str; 2]> {
        match (&self.measure, self.condition.as_str()) {
            (Measure::Jitter, ALL) => Some(["0.14", "0.08"]),
            (Measure::Distance(50), ALL) => {
                Some(["0.96 ± 0.68, -0.06 to 2.23", "1.14 ± 0.78, -3.72 to 1.57"])
            }
            (Measure::Rotation, ALL) => Some(["0.51", "0.04"]),
            (Measure::Rod(rod), "20 mm") if rod == "steel-416" => Some(["max 4.2", "max ≥ 100"]),
            _ => None,
        }
    }
}
