//! Expected figures and their intervals beside those of the room's own field.

use super::output;
use crate::study::comparison::{ErrorOf, FIGURES, REQUIRED};
use crate::study::expected::{requirement_verdict, verdict_of};
use crate::study::figures::with_separators;
use crate::study::{
    CancelToken, Deed, Expected, ExpectedError, Explained, Mode, Requirement, Scenario, expected,
};
use serde_json::{Map, Value, json};

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

/// `expected` and `intervals`, and what they say of the requirement.
pub(super) fn add_json(value: &mut Value, expected: &Expected, requirement: Option<&Requirement>) {
    let of = |of: ErrorOf, each: &dyn Fn(usize) -> Value| -> Value {
        let own = FIGURES.iter().enumerate().filter(|(_, f)| f.of == of);
        let entries = own.map(|(k, figure)| (figure.name().to_owned(), each(k)));
        Value::Object(entries.collect::<Map<_, _>>())
    };
    let both = |each: &dyn Fn(usize) -> Value| {
        json!({
            "position_mm": of(ErrorOf::Position, each),
            "angle_deg": of(ErrorOf::Angle, each),
        })
    };
    value["expected"] = both(&|k| json!(expected.figures[k]));
    value["intervals"] = both(&|k| json!(expected.intervals[k]));
    if let Some(requirement) = requirement {
        let bounds = requirement_verdict(requirement, expected);
        let named: Map<_, _> = bounds
            .iter()
            .map(|(name, verdict)| ((*name).to_owned(), json!(verdict)))
            .collect();
        if let Some(verdict) = verdict_of(&bounds) {
            value["verdict"] = json!(verdict);
            value["verdicts"] = Value::Object(named);
        }
    }
}

/// The figures that a requirement can be about.
pub(super) fn as_text(expected: &Expected) -> String {
    output::aligned(&rows(expected))
}

/// Label, expected value, unit and interval.
pub(super) fn rows(expected: &Expected) -> Vec<(String, String, String)> {
    REQUIRED
        .iter()
        .filter_map(|figure| {
            let (value, [low, high]) = expected.of(*figure)?;
            Some((
                format!("expected {}", figure.label()),
                format!("{value:.4}"),
                format!("{} (95 %: {low:.4} to {high:.4})", figure.unit()),
            ))
        })
        .collect()
}

/// Each bound against the interval of its figure.
pub(super) fn requirement_lines(expected: &Expected, requirement: &Requirement) -> Vec<String> {
    let limits = requirement.bounds();
    let verdicts = requirement_verdict(requirement, expected);
    let each = verdicts.into_iter().filter_map(|(name, verdict)| {
        let place = limits.iter().position(|(other, _)| *other == name)?;
        let (limit, figure) = (limits[place].1?, REQUIRED[place]);
        let (value, [low, high]) = expected.of(figure)?;
        let unit = figure.unit();
        Some(format!(
            "requirement {name}: {}, at most {limit} {unit}, expected {value:.4} {unit} (95 %: {low:.4} to \
             {high:.4})",
            verdict.label()
        ))
    });
    each.collect()
}
