//! A study's figures by the room's model alone, the paper's simulation, and how they are written for a person.

use super::axis_words::{axis_words, body_name, shaft_of};
use super::metric::{Metric, MetricValues, Statistics, values};
use super::requirement::Within;
use super::scenario::Scenario;
use super::weak_rotation::WeakRotation;
use nalgebra::{Unit, Vector3};
use serde::Serialize;
use trackwright_result::{Row, count, number, text, with_separators};

/// What a study comes to where the room's model is taken for its field: the paper's simulation. What is
/// known of the figures is in [`Figures`](super::figure::Figures).
#[derive(Clone, Debug, PartialEq)]
pub struct RoomFieldFigures {
    pub trials: usize,
    /// Trials with a sensor of tool or CRF outside the model's box, or in metal.
    pub outside: usize,
    /// Trials with a sensor in metal, or so close to it that its signals determine no pose.
    pub in_metal: usize,
    /// Trials with a sensor outside the tracker's measurement volume.
    pub out_of_volume: usize,
    /// Trials with a sensor where the room states no field.
    pub without_field: usize,
    /// Trials that were left out of the statistics.
    pub rejected: usize,
    pub position_mm: Statistics,
    pub angle_deg: Statistics,
    pub worst: Worst,
    /// How single trials keep to the requirement's bound of the tip error.
    pub within: Option<Within>,
    pub free_axis: Option<FreeRotation>,
    /// The part of the position error that the free rotation cannot change.
    pub position_mm_determined: Option<Statistics>,
    pub poorly_determined: bool,
    /// A rotation that the sensors determine, but that multiplies their errors.
    pub barely_determined: Option<WeakRotation>,
}

/// The label of [`RoomFieldFigures::in_metal`].
pub(super) const IN_METAL: &str = "trials with a sensor in metal";

/// The trial with the largest position error, the first of equals.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Worst {
    /// Its row in the log, from 0; [`trial_number`] for a person.
    pub trial: usize,
    pub position_mm: f64,
    pub angle_deg: f64,
}

/// A rotation that a body's sensors do not determine.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct FreeAxis {
    /// `tool` or `crf`.
    pub body: &'static str,
    /// In that body's frame; `None` where no rotation is determined at all.
    #[serde(rename = "axis")]
    pub axis_in_body: Option<[f64; 3]>,
    /// That of the body's shaft, if it has one, for words.
    #[serde(skip)]
    pub shaft_in_body: Option<[f64; 3]>,
}

/// A rotation that a study's figures take the true one for.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct FreeRotation {
    #[serde(flatten)]
    pub free: FreeAxis,
    /// Largest distance of the tip from the axis over the trials: a wrong guess of the rotation puts
    /// the tip up to twice as far off.
    pub reach_mm: f64,
}

/// Digits of a figure for people.
pub(super) const DECIMALS: usize = 4;

/// Reach of a free rotation that is round-off: the tip lies on the axis, as that of a needle with one
/// sensor in its shaft.
const NO_REACH_MM: f64 = 1e-6;

impl FreeAxis {
    /// Of a body by its key; without an axis where no rotation is determined at all.
    pub(super) fn of(
        key: &'static str,
        axis_in_body: Option<Unit<Vector3<f64>>>,
        scenario: &Scenario,
    ) -> Self {
        let axis_in_body = axis_in_body.map(|axis| axis.into_inner().into());
        Self { body: key, axis_in_body, shaft_in_body: shaft_of(key, &scenario.tool) }
    }

    /// For a person.
    pub fn body_name(&self) -> &'static str {
        body_name(self.body)
    }
}

/// Whether a rotation about an axis so far away moves the tip.
pub(super) fn reaches_tip(reach_mm: f64) -> bool {
    reach_mm > NO_REACH_MM
}

impl FreeRotation {
    /// Whether a wrong guess of the rotation moves the tip.
    pub fn reaches_tip(&self) -> bool {
        reaches_tip(self.reach_mm)
    }

    /// What is not determined, and what the figures take for it; one sentence without a full stop.
    pub fn statement(&self) -> String {
        let body = self.free.body_name();
        let what = match self.free.axis_in_body {
            Some(axis) => {
                let axis = axis_words(axis, self.free.shaft_in_body, body);
                format!("the {body}'s sensors do not determine its rotation about {axis}")
            }
            None => format!("the {body}'s sensors determine no rotation at all"),
        };
        match self.reaches_tip() {
            true => format!(
                "{what}; figures take the true one, and a wrong one puts the tip up to {:.1} mm off",
                2.0 * self.reach_mm
            ),
            false => format!("{what}; the tip lies on that axis and does not depend on it"),
        }
    }
}

impl RoomFieldFigures {
    pub(super) fn outside_label(&self) -> &'static str {
        match self.in_metal {
            0 => "trials with a sensor outside the model's box",
            _ => "trials with a sensor outside the model's box or in metal",
        }
    }

    /// The value of a figure, mm or degrees.
    pub fn value(&self, metric: Metric) -> f64 {
        metric.of_study(&self.position_mm, &self.angle_deg)
    }

    /// All figures.
    pub fn values(&self) -> MetricValues {
        values(&self.position_mm, &self.angle_deg)
    }
}

/// The figures as rows. Those of a metric have its name as key, their determined parts that with
/// `_determined`, others none.
pub fn figure_rows(figures: &RoomFieldFigures) -> Vec<Row> {
    let of = |m: Metric| number(m.name(), m.label(), figures.value(m), DECIMALS, m.unit());
    let mut rows: Vec<Row> = Metric::printed().map(of).collect();
    if let Some(determined) = &figures.position_mm_determined {
        rows.extend([Metric::TIP_RMS, Metric::TIP_MAX].map(|m| {
            let (key, label) = (
                format!("{}_determined", m.name()),
                format!("{}, undetermined rotation left out", m.label()),
            );
            number(key, label, determined.get(m.summary), DECIMALS, m.unit())
        }));
    }
    rows.push(count("", "trials", figures.trials));
    rows.push(text("", "worst trial", trial_number(figures.worst.trial)));
    rows.push(count("", figures.outside_label(), figures.outside));
    if figures.in_metal > 0 {
        rows.push(count("", IN_METAL, figures.in_metal));
    }
    rows.push(count("", "trials with a sensor out of the volume", figures.out_of_volume));
    if figures.rejected > 0 {
        rows.push(count("", "trials left out", figures.rejected));
    }
    rows
}

/// The number of a trial for a person, counted from 1 everywhere that one reads it: `1,203` of
/// index 1202. Files and JSON have the index.
///
/// ```
/// assert_eq!(trackwright_simulation::figures::trial_number(1202), "1,203");
/// ```
pub fn trial_number(index: usize) -> String {
    with_separators(index + 1)
}

/// How far something is from where it was, with its sign; nothing has none.
pub fn signed_offset(value: f64) -> String {
    match value == 0.0 {
        true => "0".to_owned(),
        false => format!("{value:+}"),
    }
}

/// With a capital letter, as a sentence begins.
///
/// ```
/// assert_eq!(trackwright_simulation::figures::capitalised("tip error"), "Tip error");
/// ```
pub fn capitalised(words: &str) -> String {
    let mut letters = words.chars();
    let first = letters.next().into_iter().flat_map(char::to_uppercase);
    first.chain(letters).collect()
}

/// A sentence with minus signs before its numbers where it has hyphens, as windows and pages write
/// them.
pub fn with_minus_signs(text: &str) -> String {
    let mut before = ' ';
    let mut after = text.chars().skip(1);
    let signs = text.chars().map(|c| {
        let is_number = after.next().is_some_and(|next| next.is_ascii_digit());
        let is_sign = c == '-' && is_number && !before.is_alphanumeric();
        before = c;
        if is_sign { '\u{2212}' } else { c }
    });
    signs.collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_hyphens_before_numbers_become_minus_signs() {
        assert_eq!(
            with_minus_signs("0.2 mm better than tool-2-b (95 %: -0.5 to 0.1), x -20 y +5"),
            "0.2 mm better than tool-2-b (95 %: −0.5 to 0.1), x −20 y +5"
        );
        assert_eq!(with_minus_signs("-1"), "−1");
        assert_eq!(with_minus_signs(""), "");
    }
}
