//! Chosen models of rooms, and what they were chosen from, as JSON.

use crate::kinds::kind_reason;
use crate::room::{map_name, method_name};
use crate::room_json::fit_json;
use crate::selection::{SENSOR_INTERVAL, hold_out_name, reason};
use serde_json::{Value, json};
use trackwright_calibration::kind_choice::{Decided, KindChoice};
use trackwright_calibration::learning_curve::LearningPoint;
use trackwright_calibration::room_choice::Chosen;
use trackwright_calibration::room_fit::FittedRoom;
use trackwright_calibration::room_model::RoomModel;
use trackwright_field::selection::places::Places;
use trackwright_field::selection::sensors::SensorSpread;
use trackwright_field::selection::{HoldOutBy, Scored, Scores};

/// Why the choice is what it is.
pub fn reason_of(chosen: &Chosen) -> String {
    reason(&chosen.selection, chosen.by.as_deref(), chosen.tried.folds)
}

/// A fitted room, and how its model was decided.
pub fn decided_json(decided: &Decided, room: &FittedRoom) -> Value {
    let mut value = fit_json(&decided.settings, room);
    match (&decided.kinds, &decided.chosen) {
        (Some(kinds), _) => value["models"] = kinds_json(kinds),
        (None, Some(chosen)) => value["selection"] = choice_json(chosen),
        (None, None) => {}
    }
    value
}

/// The polynomials that `fit` chose.
pub fn choice_json(chosen: &Chosen) -> Value {
    let best = chosen.selection.best();
    let mut value = json!({
        "order": best.candidate.order,
        "directions": best.candidate.directions.len(),
        "ridge": best.candidate.ridge,
        "cv": scores_json(best.deciding()),
        "folds": chosen.tried.folds,
        "reason": reason_of(chosen),
    });
    add_hold_outs(&mut value, chosen);
    value
}

/// Adds what was held out, how the chosen model did in each hold-out, and what was found of rows
/// and sensors.
fn add_hold_outs(value: &mut Value, chosen: &Chosen) {
    let found = &chosen.selection;
    let hold_outs: Vec<Value> = found
        .hold_outs
        .iter()
        .map(|hold_out| {
            json!({
                "by": hold_out_name(hold_out.by),
                "folds": hold_out.folds,
                "count": hold_out.count,
                "decides": hold_out.by == found.decided_by,
                "cv": found.best().held_out_by(hold_out.by).map(scores_json),
            })
        })
        .collect();
    value["groups"] = json!(chosen.by.as_ref().map(|by| json!({"by": by, "count": found.groups})));
    value["hold_out"] = json!(hold_out_name(found.decided_by));
    value["hold_outs"] = json!(hold_outs);
    value["sensors"] = json!(found.sensors.as_ref().map(sensors_json));
    value["grouped"] = json!(chosen.places.as_ref().map(places_json));
}

/// What is left of rows held out.
fn scores_json(scores: &Scores) -> Value {
    json!({
        "position_rms_mm": scores.position_rms_mm,
        "position_max_mm": scores.position_max_mm,
        "angle_rms_deg": scores.angle_rms_rad.map(f64::to_degrees),
    })
}

fn sensors_json(spread: &SensorSpread) -> Value {
    let degrees = |angles: [f64; 2]| angles.map(f64::to_degrees);
    json!({
        "count": spread.sensors,
        "degrees_of_freedom": spread.degrees_of_freedom,
        "position_mm": spread.position_std_dev_mm(),
        "position_rms_mm": spread.position_rms_mm(),
        "angle_rms_deg": spread.angle_rms_rad().map(f64::to_degrees),
        "intervals": {
            "position_rms_mm": spread.position_interval_mm(SENSOR_INTERVAL),
            "angle_rms_deg": spread.angle_interval_rad(SENSOR_INTERVAL).map(degrees),
        },
    })
}

fn places_json(places: &Places) -> Value {
    let variogram: Vec<Value> = places
        .variogram
        .iter()
        .map(|point| {
            json!({
                "distance_mm": point.distance_mm,
                "semivariance_mm2": point.semivariance_mm2,
                "pairs": point.pairs,
            })
        })
        .collect();
    json!({
        "places": places.count,
        "width_mm": places.width_mm,
        "dependence": places.dependence,
        "correlation_length_mm": places.correlation_length_mm,
        "nugget_mm2": places.nugget_mm2,
        "sill_mm2": places.sill_mm2,
        "variogram": variogram,
    })
}

/// A choice as `select --format json` prints it.
pub fn selection_json(chosen: &Chosen, samples: usize) -> Value {
    let (settings, selection) = (&chosen.tried, &chosen.selection);
    let model = |row: &Scored| {
        json!({
            "order": row.candidate.order,
            "directions": row.candidate.directions.len(),
            "ridge": row.candidate.ridge,
        })
    };
    let table: Vec<_> = selection
        .table
        .iter()
        .map(|row| {
            let mut value = model(row);
            value["coefficients"] = json!(row.candidate.coefficients());
            value["is_determined"] = json!(row.is_determined);
            value["cv"] = scores_json(row.deciding());
            value["cv_by_row"] = json!(row.by_row.as_ref().map(scores_json));
            value["cv_by_group"] = json!(row.by_group.as_ref().map(scores_json));
            value["cv_by_sensor"] = json!(row.by_sensor.as_ref().map(scores_json));
            value["under_sampled_directions"] = json!(row.under_sampled);
            value["is_admissible"] = json!(row.is_admissible());
            value
        })
        .collect();
    let mut value = json!({
        "best": model(selection.best()),
        "least": model(selection.least()),
        "reason": reason_of(chosen),
        "samples": samples,
        "folds": settings.folds,
        "seed": settings.seed,
        "method": method_name(settings.method),
        "map": map_name(settings.map),
        "left_out": selection
            .left_out
            .iter()
            .map(|(order, directions)| json!({"order": order, "directions": directions.len()}))
            .collect::<Vec<_>>(),
        "table": table,
    });
    add_hold_outs(&mut value, chosen);
    value
}

/// A learning curve.
pub fn curve_json(points: &[LearningPoint]) -> Value {
    let each = points.iter().map(|point| {
        let mut value = kinds_json(&point.choice);
        value["rows"] = json!(point.rows);
        value
    });
    Value::Array(each.collect())
}

/// Kinds of models, each with what it leaves.
pub fn kinds_json(choice: &KindChoice) -> Value {
    let kinds: Vec<Value> = choice
        .kinds
        .iter()
        .enumerate()
        .map(|(place, kind)| {
            let mut value = json!({
                "model": kind.name(),
                "is_chosen": place == choice.best,
                "cv": scores_json(&kind.deciding().overall),
            });
            for (by, scores) in &kind.scores.hold_outs {
                let key = match by {
                    HoldOutBy::Rows => "cv_by_row",
                    HoldOutBy::Groups => "cv_by_group",
                    HoldOutBy::Sensors => "cv_by_sensor",
                };
                value[key] = scores_json(&scores.overall);
            }
            if let Some(candidate) = &kind.candidate {
                value["order"] = json!(candidate.order);
                value["directions"] = json!(candidate.directions.len());
                value["ridge"] = json!(candidate.ridge);
            }
            if let RoomModel::Harmonic(order) = &kind.model {
                value["generator"] = json!(order.generator.name());
                value["degree"] = json!(order.degree);
                value["ridge"] = json!(order.ridge);
            }
            value
        })
        .collect();
    let left_out: Vec<Value> =
        choice.left_out.iter().map(|(kind, why)| json!({"model": kind, "reason": why})).collect();
    json!({"kinds": kinds, "left_out": left_out, "reason": kind_reason(choice)})
}
