//! Expected figures and their intervals beside those of the room's own field.

use super::prelude::*;
use serde_json::Map;
use trackwright_simulation::expected::{
    JudgedBound, MoreMeasuring, expected_rows, judged, more_measuring, most_times,
    requirement_figures, verdict_of,
};
use trackwright_simulation::figures::Figures;
use trackwright_simulation::{
    CancelToken, Deed, ErrorOf, Expected, ExpectedError, Explained, METRICS, Mode, Scenario,
    expected,
};

/// The expected figures; `None` in a room that was never measured, and where the environment keeps
/// nothing to draw fields from, which is noted.
///
/// # Errors
/// A study that cannot run.
pub(super) fn of(scenario: &Scenario, mode: &Mode) -> anyhow::Result<Option<Expected>> {
    if scenario.environment.provenance.is_none() && scenario.environment.process.is_none() {
        return Ok(None);
    }
    match expected(scenario, mode, &CancelToken::default()) {
        Ok(expected) => Ok(Some(expected)),
        Err(why @ (ExpectedError::NoProcess(_) | ExpectedError::Markers)) => {
            output::note(&format!("note: no expected figures: {why}"));
            Ok(None)
        }
        Err(why) => Err(why.into()),
    }
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

/// `expected` and `intervals`, and their verdict on the requirement.
pub(super) fn add_json(value: &mut Value, expected: &Expected, bounds: &[JudgedBound]) {
    let both = |each: &dyn Fn(usize) -> Value| -> Value {
        let of = |of: ErrorOf| {
            let own = METRICS.iter().enumerate().filter(|(_, metric)| metric.of == of);
            let entries = own.map(|(k, metric)| (metric.summary.key().to_owned(), each(k)));
            (of.json_key().to_owned(), Value::Object(entries.collect::<Map<_, _>>()))
        };
        Value::Object(ErrorOf::ALL.map(of).into_iter().collect())
    };
    value["expected"] = both(&|k| json!(expected.figures[k]));
    value["intervals"] = both(&|k| json!(expected.intervals[k]));
    if let Some(verdict) = verdict_of(bounds) {
        let named =
            bounds.iter().map(|bound| (bound.metric.name().to_owned(), json!(bound.verdict)));
        value["verdict"] = json!(verdict);
        value["verdicts"] = Value::Object(named.collect());
    }
}

/// A study's figures, and those that are to be expected.
pub(super) fn add_figures(
    value: &mut Value,
    figures: &Figures,
    without_field: usize,
    expected: Option<&Expected>,
) {
    value["trials"] = json!(figures.trials);
    value["outside"] = json!(figures.outside);
    value["out_of_volume"] = json!(figures.out_of_volume);
    value["without_field"] = json!(without_field);
    value["position_mm"] = json!(figures.position_mm);
    value["angle_deg"] = json!(figures.angle_deg);
    value["worst"] = json!(figures.worst);
    value["requirement"] = json!(requirement_figures(figures));
    if let Some(expected) = expected {
        add_json(value, expected, &judged(figures, Some(expected)));
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

/// The measurements that would decide the bounds that cannot be decided now.
///
/// # Errors
/// A study that cannot run.
pub(super) fn needed(
    scenario: &Scenario,
    mode: &Mode,
    expected: Option<&Expected>,
    figures: &Figures,
) -> anyhow::Result<Vec<MoreMeasuring>> {
    let bounds = judged(figures, expected);
    Ok(more_measuring(scenario, mode, &bounds, &CancelToken::default())?)
}

/// `measurements_needed`, a number a bound, null where there is none.
pub(super) fn add_needed(value: &mut Value, needed: &[MoreMeasuring]) {
    if !needed.is_empty() {
        let named =
            needed.iter().map(|more| (more.metric.name().to_owned(), json!(more.measurements)));
        value["measurements_needed"] = Value::Object(named.collect());
    }
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
