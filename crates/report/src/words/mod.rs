//! A study in plain words, for somebody who reads no tables: how many positions are within the
//! limit, how far off the worst is and how the tool is held there, and what to be careful about.
//!
//! Every sentence is made from figures alone, and is kept true where it is rounded: a figure has as
//! many digits as it takes to lie on the same side of a limit as the value itself, and a part of the
//! positions is rounded down, but neither to all nor to none of them.

mod metal;
mod plain;
mod worst;

pub use metal::{metal_lines, model_words};
use plain::{Part, percent};
pub use plain::{PlainFigure, plain_figure};
pub use worst::{WorstPose, worst_pose};

use crate::room::is_simulated;
use trackwright_field::OutsidePolicy;
use trackwright_result::with_separators;
use trackwright_simulation::figures::capitalised;
use trackwright_simulation::{
    Basis, ErrorOf, Figure, JudgedBound, Judgement, Metric, Mode, NoInterval, Requirement,
    RoomFieldFigures, Scenario, Study, Undecided, Verdict, trial_pose,
};

/// Between a number and its unit.
const THIN_SPACE: char = '\u{2009}';

/// Most decimals that a length gets to distinguish it from a limit.
const MOST_DECIMALS: usize = 4;

/// A study in words.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PlainWords {
    /// "97 % of the positions within 1 mm; worst 1.8 mm with the tool held flat to the field
    /// generator".
    pub headline: String,
    /// Whether the requirement is met, and where it is not.
    pub verdict: String,
    /// How the tool is held at its worst, in full; `None` for a single position.
    pub worst: Option<String>,
    /// What is not as one would wish it, each a sentence.
    pub cautions: Vec<String>,
}

/// A study in words.
pub fn plain_words(scenario: &Scenario, mode: &Mode, study: &Study) -> PlainWords {
    let limit_mm = scenario
        .requirement
        .as_ref()
        .and_then(Requirement::single_position_mm)
        .map(|(_, limit_mm)| limit_mm);
    let room_field = &study.room_field;
    let pose = trial_pose(scenario, mode, room_field.worst.trial)
        .filter(|_| room_field.trials > 1)
        .map(|trial| worst_pose(scenario, mode, &trial));
    PlainWords {
        headline: headline(study, limit_mm, pose.as_ref()),
        verdict: match &study.figures.requirement {
            None => "No requirement is set.".to_owned(),
            Some(requirement) => verdict(requirement),
        },
        worst: pose.map(|pose| {
            let held = pose.in_full();
            format!("The error is largest {held}, compared with the design's own pose.")
        }),
        cautions: cautions(scenario, room_field),
    }
}

fn headline(study: &Study, limit_mm: Option<f64>, worst: Option<&WorstPose>) -> String {
    let (figures, trials) = (&study.figures, study.room_field.trials);
    let (Some(largest), Some(p95)) = (figures.get(Metric::TIP_MAX), figures.get(Metric::TIP_P95))
    else {
        let why = study.no_overlap().map_or_else(String::new, |why| why.to_string());
        return format!("No figures: {why}");
    };
    if trials == 1 {
        let required = limit_mm.map_or_else(String::new, |limit_mm| {
            format!("; {} is required", as_set(limit_mm, "mm"))
        });
        return format!(
            "The tip is {} from where it is shown{required}",
            with_interval(largest, limit_mm)
        );
    }
    let part = match figures.within {
        Some(within) => {
            let limit = as_set(within.limit_mm, "mm");
            let part = part_of_positions(within.part, trials);
            match within.interval {
                None => format!("{part} within {limit}"),
                Some(interval) => {
                    let [low, high] = interval.map(percent);
                    format!("{part} within {limit} (95{THIN_SPACE}%: {low} to {high})")
                }
            }
        }
        None => {
            let p95 = with_interval(p95, limit_mm);
            format!("95{THIN_SPACE}% of the positions within {p95}")
        }
    };
    let largest = with_interval(largest, limit_mm);
    // Only where there is one field it is known where in it the error is largest.
    let worst = worst.filter(|_| figures.basis == Basis::Assumed);
    match worst.and_then(WorstPose::in_short) {
        None => format!("{part}; worst {largest}"),
        Some(held) => format!("{part}; worst {largest} with the tool {held}"),
    }
}

/// A length and its 95 % interval.
fn with_interval(figure: &Figure, limit_mm: Option<f64>) -> String {
    let value = length(figure.value, limit_mm);
    let end = |end_mm: f64| length(end_mm, limit_mm);
    match (figure.low.map(end), figure.high.map(end)) {
        (Some(low), Some(high)) => format!("{value} (95{THIN_SPACE}%: {low} to {high})"),
        (Some(low), None) => format!("{value} (95{THIN_SPACE}%: at least {low})"),
        (None, _) => value,
    }
}

/// What an audience that designs no tools calls a CRF.
pub const PATIENT_REFERENCE: &str = "patient reference";

/// A text as an audience reads it.
///
/// ```
/// use trackwright_report::words::for_audience;
/// assert_eq!(for_audience("Pointer on a CRF"), "Pointer on a patient reference");
/// assert_eq!(for_audience("CRF-2, CRFs"), "patient reference-2, CRFs");
/// ```
pub fn for_audience(text: &str) -> String {
    const CRF: &str = "CRF";
    let mut found = String::with_capacity(text.len());
    let mut rest = text;
    while let Some(at) = rest.find(CRF) {
        let (before, after) = (&rest[..at], &rest[at + CRF.len()..]);
        let is_word =
            !before.ends_with(char::is_alphanumeric) && !after.starts_with(char::is_alphanumeric);
        found.push_str(before);
        found.push_str(if is_word { PATIENT_REFERENCE } else { CRF });
        rest = after;
    }
    found + rest
}

/// A part of the positions, in a slide's words.
fn part_of_positions(part: f64, trials: usize) -> String {
    match Part::of(part) {
        Part::All => format!("All {} positions", with_separators(trials)),
        Part::MoreThan99 => format!("More than 99{THIN_SPACE}% of the positions"),
        Part::Percent(percent) => format!("{percent}{THIN_SPACE}% of the positions"),
        Part::LessThan1 => format!("Less than 1{THIN_SPACE}% of the positions"),
        Part::None => format!("None of the {} positions", with_separators(trials)),
    }
}

/// A length for a person: two decimals below a millimetre, one above, and as many more as it takes
/// to lie on the side of the limit on which the value lies.
///
/// ```
/// use trackwright_report::words::length;
/// assert_eq!(length(1.04, None), "1.0\u{2009}mm");
/// assert_eq!(length(1.04, Some(1.0)), "1.04\u{2009}mm");
/// ```
pub fn length(value_mm: f64, limit_mm: Option<f64>) -> String {
    rounded(value_mm, limit_mm, if value_mm < 1.0 { 2 } else { 1 }, "mm")
}

/// An angle likewise, with two decimals below ten degrees.
pub fn angle(value_deg: f64, limit_deg: Option<f64>) -> String {
    rounded(value_deg, limit_deg, if value_deg < 10.0 { 2 } else { 1 }, "°")
}

fn rounded(value: f64, limit: Option<f64>, decimals: usize, unit: &str) -> String {
    if !value.is_finite() {
        return "no number".to_owned();
    }
    let is_faithful = |text: &str| match (text.parse::<f64>(), limit) {
        (Ok(rounded), Some(limit)) => (rounded <= limit) == (value <= limit),
        _ => true,
    };
    let text = (decimals..=MOST_DECIMALS)
        .map(|decimals| format!("{value:.decimals$}"))
        .find(|text| is_faithful(text))
        .unwrap_or_else(|| value.to_string());
    format!("{text}{THIN_SPACE}{unit}")
}

/// A limit as it was set.
fn as_set(limit: f64, unit: &str) -> String {
    format!("{limit}{THIN_SPACE}{unit}")
}

fn verdict(requirement: &Judgement) -> String {
    let listed = |wanted: Verdict| -> Vec<String> {
        let of = requirement.bounds.iter().filter(|bound| bound.verdict == wanted);
        of.map(bound_words).collect()
    };
    match requirement.verdict {
        Verdict::Met => "The requirement is met.".to_owned(),
        Verdict::Missed => {
            format!("The requirement is missed: {}.", listed(Verdict::Missed).join("; "))
        }
        Verdict::CannotTell => {
            let open = listed(Verdict::CannotTell).join("; ");
            match requirement.reason() {
                Some(Undecided::Interval) | None => format!(
                    "The measurements of this room cannot decide whether the requirement is met: {open}."
                ),
                Some(Undecided::OnePose) => {
                    "One pose is not judged against what is required over the range of motion."
                        .to_owned()
                }
                Some(why @ Undecided::NoInterval(NoInterval::Outside { .. })) => {
                    format!("It is not decided whether the requirement is met: {why}.")
                }
                Some(why) => format!(
                    "It is undetermined, because {why}, whether the requirement is met: {open}."
                ),
            }
        }
    }
}

fn bound_words(bound: &JudgedBound) -> String {
    let limit = Some(bound.limit);
    let digits = |value: f64| match bound.metric.of {
        ErrorOf::Position => length(value, limit),
        ErrorOf::Angle => angle(value, limit),
    };
    let required = as_set(bound.limit, bound.metric.unit());
    let name = bound.metric.label();
    let over = bound.over_words(&THIN_SPACE.to_string());
    let over = over.map_or_else(String::new, |over| format!(", which is {over} less"));
    let Some(figure) = bound.figure else {
        return format!("{name} is not known, and {required} is required");
    };
    let value = digits(figure.value);
    match (figure.low.map(digits), figure.high.map(digits)) {
        (Some(low), Some(high)) => {
            format!("{name} is {value}, between {low} and {high}, and {required} is required{over}")
        }
        (Some(low), None) => {
            format!("{name} is {value}, at least {low}, and {required} is required{over}")
        }
        (None, _) => format!("{name} is {value}, and {required} is required{over}"),
    }
}

fn cautions(scenario: &Scenario, figures: &RoomFieldFigures) -> Vec<String> {
    let mut cautions = Vec::new();
    let of_all = |count: usize| match figures.trials {
        1 => "At the position looked at".to_owned(),
        trials => format!("In {} of {} positions", with_separators(count), with_separators(trials)),
    };
    if figures.outside > figures.in_metal {
        let what = match scenario.outside {
            OutsidePolicy::Clamp => "the field at the nearest measured place stands for it",
            OutsidePolicy::Extrapolate => "the model is extrapolated there",
            OutsidePolicy::Reject => "those positions are left out of every figure",
        };
        cautions.push(format!(
            "{} a sensor is outside the part of the room that was measured; {what}.",
            of_all(figures.outside)
        ));
    }
    if figures.in_metal > 0 {
        cautions.push(format!(
            "{} a sensor is in metal, where it has no reading.",
            of_all(figures.in_metal)
        ));
    }
    if figures.out_of_volume > 0 {
        cautions.push(format!(
            "{} a sensor is outside the volume in which the tracker is made to measure.",
            of_all(figures.out_of_volume)
        ));
    }
    if let Some(free) = &figures.free_axis {
        cautions.push(format!("{}.", capitalised(&free.statement())));
    }
    if let Some(weak) = &figures.barely_determined {
        cautions.push(format!("{}.", capitalised(&weak.statement())));
    } else if figures.poorly_determined && figures.free_axis.is_none() {
        cautions.push(
            "How a body is turned is poorly determined by where its sensors are: noise in the \
             readings, which is not part of these figures, decides it."
                .to_owned(),
        );
    }
    match &scenario.environment.provenance {
        None if is_simulated(&scenario.environment) => {
            cautions.push("The room is simulated and was never measured.".to_owned());
        }
        None => cautions.push(
            "The room is an ideal one, or its file does not state which measurements it comes from."
                .to_owned(),
        ),
        Some(from) if from.holdout.is_none() => cautions.push(
            "The model of the room was not tested on measurements that it was not made from."
                .to_owned(),
        ),
        Some(_) => {}
    }
    cautions
}

#[cfg(test)]
mod tests;
