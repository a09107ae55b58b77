//! What each sensor contributes to the tip error of one trial.
//!
//! With `e` and `e₋ₛ` as in the parent module, sensor `s` contributes `e · (e − e₋ₛ) / |e|`: its part
//! of the error vector along that vector, in mm. Contributions of all sensors of tool and CRF add up
//! to `|e|` but for what is of second order; one is negative where it cancels others.

use super::{Refits, named_sensors};
use crate::run::check;
use crate::scenario::{InputTrial, Scenario};

/// What one sensor contributes to the tip error of a trial.
#[derive(Clone, Debug, PartialEq)]
pub struct TrialSource {
    /// `tool` or `CRF`.
    pub body: &'static str,
    pub name: String,
    /// Along the tip error, in mm.
    pub along_tip_error_mm: f64,
}

/// Contributions at a trial: the tool's sensors, then the CRF's. None where the tip has no error,
/// where a body has no sensors, and at a trial that is left out because sensors are outside.
pub fn trial_sources(scenario: &Scenario, trial: InputTrial) -> Vec<TrialSource> {
    if check(scenario).is_err() {
        return Vec::new();
    }
    let sums = Refits::new(scenario).sums(&[0], vec![trial]);
    let Some([tip_error_mm, _]) = sums.errors.first().copied().filter(|error| error[0] > 0.0)
    else {
        return Vec::new();
    };
    let sources = named_sensors(scenario).zip(&sums.sensors);
    let sources = sources.map(|((body, sensor), [product_mm2, _])| TrialSource {
        body,
        name: sensor.name.clone(),
        along_tip_error_mm: product_mm2[0] / tip_error_mm,
    });
    sources.collect()
}

/// Contributions in words, the largest first: at most so many sensors, then the sum of all others, so
/// that what is listed adds up. Sensors of the CRF are named as such; with this before units.
pub fn source_words(sources: &[TrialSource], most: usize, space: &str) -> Vec<String> {
    let mut order: Vec<&TrialSource> = sources.iter().collect();
    order.sort_by(|a, b| b.along_tip_error_mm.abs().total_cmp(&a.along_tip_error_mm.abs()));
    // One alone takes as much room as the words for it.
    let listed = if order.len() == most + 1 { most + 1 } else { most.min(order.len()) };
    let (listed, others) = order.split_at(listed);
    let each = listed.iter().map(|source| {
        let of = if source.body == "CRF" { "CRF " } else { "" };
        format!("{of}{} {}", source.name, length(source.along_tip_error_mm, space))
    });
    let rest_mm: f64 = others.iter().map(|source| source.along_tip_error_mm).sum();
    let rest =
        (!others.is_empty()).then(|| format!("{} others {}", others.len(), length(rest_mm, space)));
    each.chain(rest).collect()
}

fn length(mm: f64, space: &str) -> String {
    let text = format!("{mm:.2}");
    // Round-off has no sign.
    let text = text.strip_prefix('-').filter(|rest| *rest == "0.00").unwrap_or(&text);
    format!("{}{space}mm", text.replace('-', "−"))
}
