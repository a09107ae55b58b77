//! What the figures come to, in a word and in a sentence.

use super::{Compared, NoiseCheck};
use serde::Serialize;

/// Chance below which a mean difference is reported as one.
const SIGNIFICANT: f64 = 0.05;

/// What the figures come to.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// The prediction explains a part of the measured error.
    Explains,
    /// It may as well explain none: the interval reaches zero.
    NoBetterThanNothing,
    /// It does harm: the interval is below zero.
    WorseThanNothing,
    /// The measured error is no larger than the noise.
    NothingToExplain,
    /// Too few poses are independent for an interval.
    TooFewIndependent,
}

/// The verdict and its sentence; `poses` are those used, and their effective number.
pub(super) fn verdict(
    found: &Compared,
    noise: Option<&NoiseCheck>,
    room_misfit_rms_mm: Option<f64>,
    poses: (usize, f64),
) -> (Verdict, String) {
    let Some(explained) = found.explained else {
        let statement = format!(
            "Nothing was measured but zero, where {:.2} mm RMS is predicted: there is nothing to explain.",
            found.predicted.rms()
        );
        return (Verdict::NothingToExplain, statement);
    };
    if noise.is_some_and(|n| n.has_nothing_to_explain() == Some(true)) {
        let statement = format!(
            "The measured error, {:.2} mm RMS, is no larger than the jitter that the room states: there is nothing to \
             explain.",
            found.measured.rms()
        );
        return (Verdict::NothingToExplain, statement);
    }
    let (Some(low), Some(high)) = (explained.low, explained.high) else {
        let statement = format!(
            "The simulation explains {} of the squared tip error, but {} poses have an effective number of {:.0}, too \
             few for an interval: record more, farther apart.",
            percent(explained.value),
            poses.0,
            poses.1.floor()
        );
        return (Verdict::TooFewIndependent, statement);
    };
    let part = format!(
        "The simulation explains {} of the squared tip error (95 % interval {} to {})",
        percent(explained.value),
        percent(low),
        percent(high)
    );
    if high < 0.0 {
        let statement = format!(
            "{part}: worse than predicting no error at all. Is it the room that the tool was recorded in, and the \
             design that was built?"
        );
        return (Verdict::WorseThanNothing, statement);
    }
    if low <= 0.0 {
        let statement = format!("{part}: no better than predicting no error at all.");
        return (Verdict::NoBetterThanNothing, statement);
    }
    let mut statement = format!("{part}. {}", left_over(found, noise, room_misfit_rms_mm));
    if let Some(bias) = found.bias.filter(|b| b.p.is_some_and(|p| p < SIGNIFICANT)) {
        let [x, y, z] = bias.mean;
        statement.push_str(&format!(
            " A part of it is the same at all poses: ({x:.2}, {y:.2}, {z:.2}) mm."
        ));
    }
    (Verdict::Explains, statement)
}

fn left_over(found: &Compared, noise: Option<&NoiseCheck>, room: Option<f64>) -> String {
    let left = format!("What it does not explain, {:.2} mm RMS,", found.residual.rms());
    let misfit = room.map(|mm| {
        format!("the misfit of the room's own model would come to {mm:.2} mm RMS at the tip")
    });
    match (noise.and_then(|n| Some((n, n.is_only_noise()?))), misfit) {
        (Some((noise, true)), _) => format!(
            "{left} is no more than the uncertainty that the room states ({:.2} mm RMS).",
            noise.rms_mm
        ),
        (Some((noise, false)), Some(misfit)) => format!(
            "{left} is more than the uncertainty that the room states ({:.2} mm RMS); {misfit}.",
            noise.rms_mm
        ),
        (Some((noise, false)), None) => format!(
            "{left} is more than the uncertainty that the room states ({:.2} mm RMS).",
            noise.rms_mm
        ),
        (None, Some(misfit)) => {
            format!("{left} has no stated uncertainty to be held against; {misfit}.")
        }
        (None, None) => format!("{left} has no stated uncertainty to be held against."),
    }
}

/// A part as a whole percentage, with a minus that is one.
pub(super) fn percent(part: f64) -> String {
    let rounded = (100.0 * part).round();
    let shown = match rounded {
        // 99.6 is not all of it.
        r if r >= 100.0 && part < 1.0 - 1e-9 => format!("{:.2}", (100.0 * part).min(99.99)),
        r if r < 0.0 => format!("−{:.0}", -r),
        r => format!("{:.0}", r + 0.0),
    };
    format!("{shown} %")
}
