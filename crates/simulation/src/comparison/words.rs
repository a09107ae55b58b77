//! A comparison as text, the same on the command line and in the editor.

use super::difference::{Difference, DifferenceVerdict};
use super::{AgainstBaseline, Measured};
use crate::figures::{signed_offset, trial_number};
use crate::judgement::Verdict;

/// Whether the requirement is met, as far as the room determines it.
pub fn met_words(measured: &Measured) -> &'static str {
    measured.verdict().map_or("–", Verdict::label)
}

/// The verdict on a difference from the baseline of this name.
pub fn difference_words(difference: &Difference, baseline: &str) -> String {
    let unit = difference.metric.unit();
    let better = difference.difference < 0.0;
    let side = if better { "better" } else { "worse" };
    let size = amount(difference.difference.abs(), unit);
    let ends = match better {
        true => [-difference.high, -difference.low],
        false => [difference.low, difference.high],
    };
    let [from, to] = ends.map(|end| format!("{end:.3}"));
    match difference.verdict {
        DifferenceVerdict::Better | DifferenceVerdict::Worse => {
            format!("{size} {side} than {baseline} (95 %: {from} to {to})")
        }
        DifferenceVerdict::NotTold => format!(
            "not significant ({}; 95 %: {} to {})",
            signed(difference.difference, unit),
            signed(difference.low, unit),
            signed(difference.high, unit)
        ),
        DifferenceVerdict::Negligible => {
            format!("negligible ({})", signed(difference.difference, unit))
        }
        DifferenceVerdict::RoomUnknown => format!(
            "{size} {side} than {baseline} as the room stands ({from} to {to} for the sampling); how far the \
             room may be off is not known, so this is no verdict"
        ),
        DifferenceVerdict::OtherRoom => format!(
            "{} from {baseline}, which is in another room, so this is no verdict",
            signed(difference.difference, unit)
        ),
        DifferenceVerdict::Unsettled => format!(
            "{size} {side} than {baseline} as far as the figures go; {}, so this is no verdict",
            difference.unsettled.as_ref().map_or_else(String::new, |why| why.to_string())
        ),
    }
}

/// What has to be known of a row before its figures are read.
pub fn notes(measured: &Measured, against: Option<&AgainstBaseline>) -> Vec<String> {
    let mut notes = measured.study.notes();
    let Some(against) = against else {
        return notes;
    };
    if against.motion_differs {
        notes.push("its range of motion is not the baseline's".to_owned());
    }
    if against.requirement_differs {
        notes.push("its requirement is not the baseline's".to_owned());
    }
    if against.room_differs {
        notes.push("it is not in the baseline's room".to_owned());
    }
    notes
}

/// How large the worst error is, and where the tool then stands.
pub fn worst_words(measured: &Measured) -> String {
    let size_mm = measured.study.room_field.worst.position_mm;
    format!("worst {size_mm:.4} mm at {}", worst_place_words(measured))
}

/// Where the tool stands in the worst trial, from its own pose.
pub fn worst_place_words(measured: &Measured) -> String {
    let offsets = &measured.worst_pose.offsets;
    let of = |unit: &str, is_turn: bool| {
        let axes = offsets.iter().filter(|(a, _)| a.starts_with('r') == is_turn);
        let axes: Vec<String> =
            axes.map(|(axis, v)| format!("{axis} {}", signed_offset(*v))).collect();
        (!axes.is_empty()).then(|| format!("{}{unit}", axes.join(" ")))
    };
    let places: Vec<String> = [of(" mm", false), of("°", true)].into_iter().flatten().collect();
    match places.is_empty() {
        true => "its own pose".to_owned(),
        false => {
            let trial = trial_number(measured.study.room_field.worst.trial);
            format!("{} (trial {trial})", places.join(", "))
        }
    }
}

/// With as many digits as are significant.
fn amount(value: f64, unit: &str) -> String {
    match unit {
        "°" => format!("{value:.3}°"),
        unit => format!("{value:.3} {unit}"),
    }
}

fn signed(value: f64, unit: &str) -> String {
    let rounded = amount(value.abs(), unit);
    // What rounds to nothing has no sign.
    let is_nothing = value.abs() < 0.0005;
    match (is_nothing, value < 0.0) {
        (true, _) => rounded,
        (false, true) => format!("-{rounded}"),
        (false, false) => format!("+{rounded}"),
    }
}
