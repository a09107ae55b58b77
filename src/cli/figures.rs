//! What is known of a study's figures, for a terminal.

use super::prelude::*;
use trackwright_simulation::expected::{MoreMeasuring, most_times};
use trackwright_simulation::{Deed, Explained, Figures, JudgedBound, NoInterval};

/// Decimals of a figure.
const DECIMALS: usize = 4;

/// What the drawn fields cost.
pub(super) fn explained(figures: &Figures) -> Explained {
    match &figures.drawn {
        Some(drawn) => Explained {
            deed: Deed::Computed,
            what: format!(
                "{} drawn fields at {} sensor poses of {} trials, given {} measurements",
                drawn.draws,
                with_separators(drawn.points),
                with_separators(drawn.trials),
                with_separators(drawn.rows)
            ),
        },
        None => Explained {
            deed: Deed::LeftOut,
            what: "drawn fields: there is nothing to draw them from".to_owned(),
        },
    }
}

/// Label, value, unit and interval of each figure that a requirement can be about.
pub(super) fn rows(figures: &Figures) -> Vec<output::Row> {
    let each = figures.bounded().map(|figure| {
        let unit = figure.metric.unit();
        let interval = figure.interval_text(DECIMALS);
        let interval = interval.map_or_else(String::new, |words| format!(" (95 %: {words})"));
        (figure.metric.label().to_owned(), figure.value_text(DECIMALS), format!("{unit}{interval}"))
    });
    each.collect()
}

/// Why there is no interval, a sentence.
pub(super) fn no_interval_line(figures: &Figures) -> Option<String> {
    let why = figures.no_interval.as_ref()?;
    let what = if figures.all.is_empty() { "no figures" } else { "no interval" };
    let what = if *why == NoInterval::Assumed { "no interval" } else { what };
    Some(format!("{what}: {why}"))
}

/// The requirement, a line a bound.
pub(super) fn requirement_lines(figures: &Figures) -> Vec<String> {
    let line = |bound: &JudgedBound| {
        format!("requirement {}: {}", bound.metric.name(), bound.words(DECIMALS, " "))
    };
    figures.requirement.iter().flat_map(|requirement| &requirement.bounds).map(line).collect()
}

/// A sentence a bound.
pub(super) fn needed_lines(needed: &[MoreMeasuring]) -> Vec<String> {
    let each = needed.iter().map(|more| match more.measurements {
        Some(measurements) => format!(
            "requirement {}: decided with about {} measurements spread as widely, if the figure stays",
            more.metric.name(),
            with_separators(measurements)
        ),
        None => format!(
            "requirement {}: not decided even with {} times as many measurements, if the figure stays",
            more.metric.name(),
            most_times()
        ),
    });
    each.collect()
}
