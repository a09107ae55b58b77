//! Expected figures and their intervals as JSON, beside those of the room's own field.

use serde_json::{Map, Value, json};
use trackwright_simulation::expected::{
    JudgedBound, MoreMeasuring, judged, requirement_figures, verdict_of,
};
use trackwright_simulation::figures::Figures;
use trackwright_simulation::{ErrorOf, Expected, METRICS};

/// `expected` and `intervals`, and their verdict on the requirement.
pub fn add_expected(value: &mut Value, expected: &Expected, bounds: &[JudgedBound]) {
    let both = |each: &dyn Fn(usize) -> Value| -> Value {
        let of = |of: ErrorOf| {
            let own = METRICS.iter().enumerate().filter(|(_, metric)| metric.of == of);
            let entries = own.map(|(k, metric)| (metric.summary.key().to_owned(), each(k)));
            (of.json_key().to_owned(), Value::Object(entries.collect::<Map<_, _>>()))
        };
        Value::Object(ErrorOf::ALL.map(of).into_iter().collect())
    };
    value["expected"] = both(&|k| json!(expected.figures[k]));
    value["intervals"] = both(&|k| json!(expected.intervals[k]));
    if let Some(verdict) = verdict_of(bounds) {
        let named =
            bounds.iter().map(|bound| (bound.metric.name().to_owned(), json!(bound.verdict)));
        value["verdict"] = json!(verdict);
        value["verdicts"] = Value::Object(named.collect());
    }
}

/// A study's figures, and those that are to be expected.
pub fn add_figures(
    value: &mut Value,
    figures: &Figures,
    without_field: usize,
    expected: Option<&Expected>,
) {
    value["trials"] = json!(figures.trials);
    value["outside"] = json!(figures.outside);
    value["out_of_volume"] = json!(figures.out_of_volume);
    value["without_field"] = json!(without_field);
    value["position_mm"] = json!(figures.position_mm);
    value["angle_deg"] = json!(figures.angle_deg);
    value["worst"] = json!(figures.worst);
    value["requirement"] = json!(requirement_figures(figures));
    if let Some(expected) = expected {
        add_expected(value, expected, &judged(figures, Some(expected)));
    }
}

/// `measurements_needed`, a number a bound, null where there is none.
pub fn add_needed(value: &mut Value, needed: &[MoreMeasuring]) {
    if !needed.is_empty() {
        let named =
            needed.iter().map(|more| (more.metric.name().to_owned(), json!(more.measurements)));
        value["measurements_needed"] = Value::Object(named.collect());
    }
}
