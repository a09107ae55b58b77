//! Figures as people read them who do not design the tool.

use crate::design::SlideFigure;
use crate::editor::ui::widgets::{length, with_unit};
use crate::study::Figures;

/// A large figure and what it means.
#[derive(Clone, Debug, PartialEq)]
pub struct PlainFigure {
    pub value: String,
    pub words: String,
    /// Against the requirement, where it says something of this figure.
    pub is_met: Option<bool>,
}

/// A figure of a slide; `None` where the study does not have it.
pub fn plain_figure(figure: SlideFigure, figures: &Figures) -> Option<PlainFigure> {
    let met = |name: &str| {
        figures
            .checks
            .iter()
            .find(|c| c.name == name)
            .map(|c| c.met)
    };
    Some(match figure {
        SlideFigure::WithinLimit => {
            let within = figures.within?;
            PlainFigure {
                value: percent(within.part),
                words: format!("of the positions are within {}", length(within.limit_mm)),
                // Good news only where it is all of them, whatever the bound is on.
                is_met: (figures.requirement_met()).filter(|is_met| !is_met || within.part == 1.0),
            }
        }
        SlideFigure::TypicalTipError => PlainFigure {
            value: length(figures.position_mm.median),
            words: "typical error at the tip".to_owned(),
            is_met: None,
        },
        SlideFigure::LargestTipError => PlainFigure {
            value: length(figures.position_mm.max),
            words: "largest error at the tip".to_owned(),
            is_met: met("position_max"),
        },
        SlideFigure::TypicalAngleError => PlainFigure {
            value: with_unit(&format!("{:.2}", figures.angle_deg.median), "°"),
            words: "typical error of the direction".to_owned(),
            is_met: None,
        },
    })
}

/// A part from 0 to 1 in per cent. It is 100 % only where it is all of them, and 0 % only where it
/// is none.
fn percent(part: f64) -> String {
    let percent = 100.0 * part;
    let shown = match percent {
        p if p >= 100.0 => 100.0,
        p if p > 99.0 => return ">\u{2009}99\u{2009}%".to_owned(),
        p if p > 0.0 && p < 1.0 => return "<\u{2009}1\u{2009}%".to_owned(),
        p => p.floor(),
    };
    with_unit(&format!("{shown:.0}"), "%")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nearly_all_is_not_all_and_a_few_are_not_none() {
        let shown = [0.0, 1e-6, 0.5, 0.9799, 0.9901, 0.999_999, 1.0].map(percent);
        let plain = shown.map(|text| text.replace('\u{2009}', " "));
        assert_eq!(
            plain,
            ["0 %", "< 1 %", "50 %", "97 %", "> 99 %", "> 99 %", "100 %"]
        );
    }
}
