//! Large figures as people read them who do not design the tool.

use super::THIN_SPACE;
use crate::design::SlideFigure;
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
            value: format!("{:.2}°", figures.angle_deg.median),
            words: "typical error of the direction".to_owned(),
            is_met: None,
        },
    })
}

/// Two decimals, whatever it is: figures stand one above the other.
fn length(value_mm: f64) -> String {
    format!("{value_mm:.2}{THIN_SPACE}mm")
}

/// A part from 0 to 1 in per cent, rounded down. It is 100 % only where it is all of them, and 0 % only
/// where it is none.
fn percent(part: f64) -> String {
    match Part::of(part) {
        Part::All => format!("100{THIN_SPACE}%"),
        Part::MoreThan99 => format!(">{THIN_SPACE}99{THIN_SPACE}%"),
        Part::Percent(percent) => format!("{percent}{THIN_SPACE}%"),
        Part::LessThan1 => format!("<{THIN_SPACE}1{THIN_SPACE}%"),
        Part::None => format!("0{THIN_SPACE}%"),
    }
}

/// A part as a slide and a sentence tell it: never more than is so.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Part {
    All,
    MoreThan99,
    /// Whole ones, what is beyond left out.
    Percent(u8),
    LessThan1,
    None,
}

impl Part {
    /// Of a part from 0 to 1.
    pub fn of(part: f64) -> Self {
        match 100.0 * part {
            p if p >= 100.0 => Self::All,
            p if p > 99.0 => Self::MoreThan99,
            p if p >= 1.0 => Self::Percent(p as u8),
            p if p > 0.0 => Self::LessThan1,
            _ => Self::None,
        }
    }
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
