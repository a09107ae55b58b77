//! What is no more as it was when a step was decided.

use super::decided::{DecidedRecording, DecidedRow, DecidedStudies, RoomName};
use super::status::Row;
use serde::Serialize;
use std::fmt;
use trackwright_result::with_separators;
use trackwright_simulation::Metric;
use trackwright_simulation::requirement::Requirement;

/// Digits after the point with which figures of a study are printed.
const STUDY_DIGITS: usize = 4;

/// One difference between what was decided on and what is there.
#[derive(Clone, Debug, PartialEq)]
pub struct Change {
    /// `None` of what is the same in all rooms.
    pub room: Option<RoomName>,
    /// Of a CRF.
    pub target: Option<String>,
    pub what: Changed,
}

#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(tag = "kind", rename_all = "snake_case")]
pub enum Changed {
    /// By more than the digits that are printed.
    Figure {
        figure: String,
        unit: &'static str,
        /// After the point, as printed.
        #[serde(skip)]
        digits: usize,
        before: f64,
        now: f64,
    },
    Count {
        #[serde(rename = "count")]
        of: &'static str,
        before: usize,
        now: usize,
    },
    /// Of the requirement, by its name in a design file.
    Bound { bound: Metric, before: Option<f64>, now: Option<f64> },
    /// Another recording, or another way to take it.
    Recording { before: String, now: String },
    /// There were none then.
    HasFigures,
    /// There were some then.
    HasNoFigures { why: String },
    /// It was not judged there then.
    IsNew,
    /// It is not judged there any more.
    IsGone,
}

/// A figure then and now; one that differs by more than a unit of its last printed digit is printed
/// with other digits, whatever both were rounded from.
pub(super) fn figure(
    figure: impl Into<String>,
    unit: &'static str,
    digits: usize,
    [before, now]: [f64; 2],
) -> Option<Changed> {
    let last_digit = 0.1_f64.powi(i32::try_from(digits).unwrap_or(i32::MAX));
    // Whatever is no number is another figure.
    let is_same = (before - now).abs() <= last_digit;
    (!is_same).then(|| Changed::Figure { figure: figure.into(), unit, digits, before, now })
}

fn count(of: &'static str, [before, now]: [usize; 2]) -> Option<Changed> {
    (before != now).then_some(Changed::Count { of, before, now })
}

/// Of studies. Rooms that are looked at this once are left out by the caller.
pub(super) fn study_changes<'a>(
    decided: &DecidedStudies,
    requirement: Option<&Requirement>,
    rows: impl Iterator<Item = &'a Row>,
) -> Vec<Change> {
    let mut changes = bound_changes(decided.requirement.as_ref(), requirement);
    let mut left: Vec<&DecidedRow> = decided.rows.iter().collect();
    for row in rows {
        let is_its =
            |before: &&DecidedRow| before.room.file == row.room.file && before.target == row.target;
        let before = left.iter().position(is_its).map(|index| left.remove(index));
        let what = match before {
            None => vec![Changed::IsNew],
            Some(before) => row_changes(before, row),
        };
        changes.extend(what.into_iter().map(|what| Change {
            room: Some(row.room.clone()),
            target: row.target.clone(),
            what,
        }));
    }
    changes.extend(left.into_iter().map(|gone| Change {
        room: Some(gone.room.clone()),
        target: gone.target.clone(),
        what: Changed::IsGone,
    }));
    changes
}

fn bound_changes(before: Option<&Requirement>, now: Option<&Requirement>) -> Vec<Change> {
    let [before, now] = [before, now].map(|of| of.copied().unwrap_or_default());
    let each = Metric::bounded().map(|metric| (metric, before.bound(metric), now.bound(metric)));
    let changed = each.filter(|(_, before, now)| before != now);
    changed
        .map(|(bound, before, now)| Change {
            room: None,
            target: None,
            what: Changed::Bound { bound, before, now },
        })
        .collect()
}

fn row_changes(before: &DecidedRow, row: &Row) -> Vec<Changed> {
    match (&before.figures, &row.studied) {
        (Err(_), Err(_)) => Vec::new(),
        (Err(_), Ok(_)) => vec![Changed::HasFigures],
        (Ok(_), Err(why)) => vec![Changed::HasNoFigures { why: why.to_string() }],
        (Ok(before), Ok(now)) => {
            let now = before.of_the_same_kind(now);
            let figures = Metric::decided().map(|metric| {
                let [before, now] = [before, &now].map(|f| f.values.get(metric));
                // What was not kept then is not compared.
                figure(metric.label(), metric.unit(), STUDY_DIGITS, [before?, now?])
            });
            let counts = [
                count("trials", [before.trials, now.trials]),
                count("trials without field", [before.without_field, now.without_field]),
            ];
            figures.chain(counts).flatten().collect()
        }
    }
}

/// Of the built tool, with the digits that `verify` prints.
pub(super) fn recording_changes(
    before: &DecidedRecording,
    now: Result<&DecidedRecording, &str>,
) -> Vec<Change> {
    let everywhere = |what| Change { room: None, target: None, what };
    let now = match now {
        Ok(now) => now,
        Err(why) => {
            let why = why.to_owned();
            return vec![everywhere(Changed::HasNoFigures { why })];
        }
    };
    if before.recording != now.recording {
        let [before, now] = [before, now].map(|of| of.recording.to_string());
        return vec![everywhere(Changed::Recording { before, now })];
    }
    let mm = |name: &str, before, now| figure(name, "mm", 3, [before, now]);
    let rms = Metric::TIP_RMS.label();
    // A part that is not known is none.
    let part = |of: Option<f64>| of.unwrap_or(0.0);
    let changes = [
        mm(&format!("measured {rms}"), before.measured_rms_mm, now.measured_rms_mm),
        mm(&format!("predicted {rms}"), before.predicted_rms_mm, now.predicted_rms_mm),
        mm("measured minus predicted RMS", before.residual_rms_mm, now.residual_rms_mm),
        figure("explained part", "%", 1, [before, now].map(|of| 100.0 * part(of.explained))),
        figure("slope", "", 2, [before, now].map(|of| part(of.slope))),
        count("recorded poses", [before.poses, now.poses]),
        count("compared poses", [before.used, now.used]),
    ];
    changes.into_iter().flatten().map(everywhere).collect()
}

impl fmt::Display for Change {
    /// In words, after the step's name.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(room) = &self.room {
            let name = match room.name.trim() {
                "" => &room.file,
                name => name,
            };
            write!(f, "{name}")?;
            if let Some(target) = &self.target {
                write!(f, ", {target}")?;
            }
            f.write_str(": ")?;
        }
        write!(f, "{}", self.what)
    }
}

impl fmt::Display for Changed {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Figure { figure, unit, digits, before, now } => {
                let space = if unit.is_empty() || *unit == "°" { "" } else { " " };
                write!(
                    f,
                    "{figure} was {before:.digits$}{space}{unit}, is {now:.digits$}{space}{unit}"
                )
            }
            Self::Count { of, before, now } => {
                write!(f, "{of} were {}, are {}", with_separators(*before), with_separators(*now))
            }
            Self::Bound { bound, before, now } => {
                let shown = |of: &Option<f64>| of.map_or("none".to_owned(), |v| v.to_string());
                write!(f, "required {} was {}, is {}", bound.name(), shown(before), shown(now))
            }
            Self::Recording { before, now } => write!(f, "decided on {before}, looked at is {now}"),
            Self::HasFigures => f.write_str("has figures, had none"),
            Self::HasNoFigures { why } => write!(f, "no figures any more: {why}"),
            Self::IsNew => f.write_str("not judged then"),
            Self::IsGone => f.write_str("not judged any more"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn a_reported_change_is_one_that_is_seen(
            before in 0.0..10.0_f64,
            by in -5e-4..5e-4_f64,
            digits in 1..5_usize,
        ) {
            let now = before + by;
            let printed = |value: f64| format!("{value:.digits$}");
            match figure(Metric::TIP_RMS.label(), "mm", digits, [before, now]) {
                Some(_) => prop_assert_ne!(printed(before), printed(now)),
                None => prop_assert!(by.abs() <= 1.01 * 0.1_f64.powi(digits as i32)),
            }
        }
    }
}
