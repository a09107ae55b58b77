//! What is known of a study's figures as JSON, for the program and for Python.

use serde_json::{Map, Value, json};
use trackwright_geometry::pose::pose_to_array;
use trackwright_simulation::expected::MoreMeasuring;
use trackwright_simulation::{ErrorOf, Figure, Figures, METRICS, RoomFieldFigures, Study, Trial};

/// `figures`, and what they rest on.
pub fn add_figures(value: &mut Value, figures: &Figures) {
    let entry =
        |figure: &Figure| json!({"value": figure.value, "low": figure.low, "high": figure.high});
    value["figures"] = match figures.all.is_empty() {
        true => Value::Null,
        false => by_kind(|k| figures.all.get(k).map_or(Value::Null, entry)),
    };
    value["basis"] = json!(figures.basis);
    value["no_interval"] = json!(figures.no_interval.as_ref().map(ToString::to_string));
    if let Some(within) = &figures.within {
        value["within"] = json!({
            "figure": within.metric,
            "limit_mm": within.limit_mm,
            "part": within.part,
            "low": within.interval.map(|[low, _]| low),
            "high": within.interval.map(|[_, high]| high),
        });
    }
}

/// A value of each of [`METRICS`], by position and angle.
fn by_kind(value: impl Fn(usize) -> Value) -> Value {
    let of = |of: ErrorOf| {
        let own = METRICS.iter().enumerate().filter(|(_, metric)| metric.of == of);
        let entries = own.map(|(k, metric)| (metric.summary.key().to_owned(), value(k)));
        (of.json_key().to_owned(), Value::Object(entries.collect::<Map<_, _>>()))
    };
    Value::Object(ErrorOf::ALL.map(of).into_iter().collect())
}

/// A study: its figures and its requirement, counts, and the paper's simulation in `room_field`.
pub fn study_json(study: &Study, single: Option<&Trial>) -> Value {
    let mut value = room_field_json(&study.room_field, single);
    value["requirement"] = json!(study.figures.requirement);
    add_figures(&mut value, &study.figures);
    value
}

/// The part of [`study_json`] that needs no drawn fields.
pub fn room_field_json(found: &RoomFieldFigures, single: Option<&Trial>) -> Value {
    let mut value = json!({
        "trials": found.trials,
        "outside": found.outside,
        "out_of_volume": found.out_of_volume,
        "without_field": found.without_field,
        "rejected": found.rejected,
        "worst": found.worst,
        "poorly_determined": found.poorly_determined,
        "room_field": {"position_mm": found.position_mm, "angle_deg": found.angle_deg},
    });
    if let Some(free) = &found.free_axis {
        value["free_axis"] = json!(free);
        value["room_field"]["position_mm_determined"] = json!(found.position_mm_determined);
    }
    if let Some(weak) = &found.barely_determined {
        value["barely_determined"] = json!(weak);
    }
    if let Some(trial) = single {
        let e = trial.tip_error_in_crf_mm;
        value["error_mm"] = json!([e.x, e.y, e.z]);
        value["true"] = json!(pose_to_array(&trial.crf_from_tool));
        value["simulated"] = json!(pose_to_array(&trial.crf_from_tool_simulated));
    }
    value
}

/// Adds the members of one object to another.
pub fn merge(value: &mut Value, other: Value) {
    if let (Some(value), Value::Object(other)) = (value.as_object_mut(), other) {
        value.extend(other);
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
