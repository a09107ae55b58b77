//! How an interval and a verdict are written and coloured: never by colour alone.

use crate::palette;
use crate::palette::ThemedColor;
use crate::widgets::basic::{MET_SIGN, MISSED_SIGN, THIN_SPACE, with_unit};
use crate::widgets::theme;
use bevy_egui::egui::Color32;
use trackwright_simulation::{Figure, JudgedBound, Verdict};

/// Where a room leaves it undetermined.
const OPEN_SIGN: char = '?';

/// The sign and the colour of a verdict.
pub fn verdict_mark(verdict: Verdict) -> (char, Color32) {
    match verdict {
        Verdict::Met => (MET_SIGN, theme::verdict_color(Some(true))),
        Verdict::Missed => (MISSED_SIGN, theme::verdict_color(Some(false))),
        Verdict::CannotTell => (OPEN_SIGN, palette::ACCENT.color32()),
    }
}

/// `? cannot tell`.
pub fn verdict_text(verdict: Verdict) -> String {
    format!("{} {}", verdict_mark(verdict).0, verdict.label())
}

/// `✔ met: at most 1.00 mm`, `✖ missed: 0.44 mm, limit 0.30 mm, 0.14 mm over`.
pub fn bound_text(bound: &JudgedBound) -> String {
    if let Some(missed) = bound.missed_words(&THIN_SPACE.to_string()) {
        return format!("{} {missed}", verdict_mark(bound.verdict).0);
    }
    let limit = with_unit(&format!("{:.2}", bound.limit), bound.metric.unit());
    format!("{} {}: at most {limit}", verdict_mark(bound.verdict).0, bound.label())
}

/// `95 %: 0.28 to 0.81 mm`; `None` where the figure has no interval.
pub fn interval_text(figure: &Figure) -> Option<String> {
    let ends = with_unit(&figure.interval_text(2)?, figure.metric.unit());
    Some(format!("95{THIN_SPACE}%: {ends}"))
}

/// The colour of a figure that may be held against a bound.
pub fn figure_color(verdict: Option<Verdict>) -> Color32 {
    verdict.map_or_else(|| theme::verdict_color(None), |verdict| verdict_mark(verdict).1)
}
