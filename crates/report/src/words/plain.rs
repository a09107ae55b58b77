//! Large figures as people read them who do not design the tool.

use super::THIN_SPACE;
use trackwright_design::SlideFigure;
use trackwright_simulation::{ErrorOf, Figures, Metric, Verdict};

/// A large figure and what it means.
#[derive(Clone, Debug, PartialEq)]
pub struct PlainFigure {
    pub value: String,
    pub words: String,
    /// Against the requirement, where it limits this figure.
    pub verdict: Option<Verdict>,
}

/// A figure of a slide; `None` where the study does not have it.
pub fn plain_figure(figure: SlideFigure, figures: &Figures) -> Option<PlainFigure> {
    let requirement = figures.requirement.as_ref();
    let of = |metric: Metric, name: &str| {
        let digits = |value: f64| match metric.of {
            ErrorOf::Position => length(value),
            ErrorOf::Angle => format!("{value:.2}°"),
        };
        let figure = figures.get(metric)?;
        let interval = figure.interval_text(2).map(|interval| match figure.high {
            // The unit once, at the end.
            Some(high) => interval.replace(&format!("{high:.2}"), &digits(high)),
            None => interval,
        });
        Some(PlainFigure {
            value: digits(figure.value),
            words: match interval {
                None => name.to_owned(),
                Some(interval) => format!("{name}, 95{THIN_SPACE}%: {interval}"),
            },
            verdict: requirement.and_then(|r| r.bound(metric)).map(|bound| bound.verdict),
        })
    };
    match figure {
        SlideFigure::WithinLimit => {
            let within = figures.within?;
            let limit = length(within.limit_mm);
            let verdict = requirement.map(|requirement| requirement.verdict);
            Some(PlainFigure {
                value: percent(within.part),
                words: match within.interval {
                    None => format!("of the positions are within {limit}"),
                    Some(interval) => {
                        let [low, high] = interval.map(percent);
                        format!(
                            "of the positions are within {limit}, 95{THIN_SPACE}%: {low} to {high}"
                        )
                    }
                },
                // Good news only where it is all of them, whatever the bound is on.
                verdict: verdict.filter(|v| *v != Verdict::Met || within.part == 1.0),
            })
        }
        SlideFigure::TypicalTipError => of(Metric::TIP_MEDIAN, "typical error at the tip"),
        SlideFigure::LargestTipError => of(Metric::TIP_MAX, "largest error at the tip"),
        SlideFigure::TypicalAngleError => {
            of(Metric::ANGLE_MEDIAN, "typical error of the direction")
        }
    }
}

/// Two decimals, whatever it is: figures stand one above the other.
fn length(value_mm: f64) -> String {
    format!("{value_mm:.2}{THIN_SPACE}mm")
}

/// A part from 0 to 1 in per cent, rounded down. It is 100 % only where it is all of them, and 0 % only
/// where it is none.
pub(super) fn percent(part: f64) -> String {
    match Part::of(part) {
        Part::All => format!("100{THIN_SPACE}%"),
        Part::MoreThan99 => format!(">{THIN_SPACE}99{THIN_SPACE}%"),
        Part::Percent(percent) => format!("{percent}{THIN_SPACE}%"),
        Part::LessThan1 => format!("<{THIN_SPACE}1{THIN_SPACE}%"),
        Part::None => format!("0{THIN_SPACE}%"),
    }
}

/// A part as a slide and a sentence state it: never more than is so.
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
        assert_eq!(plain, ["0 %", "< 1 %", "50 %", "97 %", "> 99 %", "> 99 %", "100 %"]);
    }
}
