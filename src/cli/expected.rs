//! Expected figures and their intervals beside those of the room's own field.

use super::prelude::*;
use trackwright_report::study::KnownExpected;
use trackwright_simulation::expected::{JudgedBound, MoreMeasuring, expected_rows, most_times};
use trackwright_simulation::{
    CancelToken, Deed, Expected, ExpectedError, Explained, Mode, Scenario,
};

/// The expected figures; why a measured room has none is noted.
///
/// # Errors
/// A study that cannot run.
pub(super) fn of(scenario: &Scenario, mode: &Mode) -> anyhow::Result<Option<Expected>> {
    let found = KnownExpected::of(scenario, mode, &CancelToken::default())?;
    note_none(&found);
    Ok(found.figures)
}

/// Reports why there are none, where that has a reason.
pub(super) fn note_none(found: &KnownExpected) {
    found.why_none.iter().for_each(note);
}

/// Reports why there are none.
pub(super) fn note(why: &ExpectedError) {
    output::note(&format!("note: no expected figures: {why}"));
}

/// What it cost.
pub(super) fn explained(expected: Option<&Expected>) -> Explained {
    match expected {
        Some(expected) => Explained {
            deed: Deed::Computed,
            what: format!(
                "{} drawn fields at {} sensor poses of {} trials, given {} measurements",
                expected.draws,
                with_separators(expected.points),
                with_separators(expected.trials),
                with_separators(expected.rows)
            ),
        },
        None => Explained {
            deed: Deed::LeftOut,
            what: "drawn fields: the room keeps no measurements to draw them from".to_owned(),
        },
    }
}

/// The figures that a requirement can be about.
pub(super) fn as_text(expected: &Expected) -> String {
    output::aligned(&rows(expected))
}

/// Label, expected value, unit and interval.
pub(super) fn rows(expected: &Expected) -> Vec<output::Row> {
    let each = expected_rows(expected).into_iter();
    each.map(|row| {
        (row.label(), row.value.clone(), format!("{} {}", row.metric.unit(), row.interval_words()))
    })
    .collect()
}

/// A bound against the interval of its figure.
pub(super) fn requirement_line(bound: &JudgedBound, [low, high]: [f64; 2]) -> String {
    let (name, unit) = (bound.metric.name(), bound.metric.unit());
    if let Some(missed) = bound.missed_words(" ") {
        return format!(
            "requirement {name}: {missed} (expected; 95 %: {low:.4} to {high:.4} {unit})"
        );
    }
    format!(
        "requirement {name}: {}, at most {} {unit}, expected {:.4} {unit} (95 %: {low:.4} to {high:.4})",
        bound.label(),
        bound.limit,
        bound.value
    )
}

/// A sentence a bound.
pub(super) fn needed_lines(needed: &[MoreMeasuring]) -> Vec<String> {
    let each = needed.iter().map(|more| match more.measurements {
        Some(measurements) => format!(
            "requirement {}: decided with about {} measurements spread as widely, if the figure is as expected",
            more.metric.name(),
            with_separators(measurements)
        ),
        None => format!(
            "requirement {}: not decided even with {} times as many measurements, if the figure is as expected",
            more.metric.name(),
            most_times()
        ),
    });
    each.collect()
}
