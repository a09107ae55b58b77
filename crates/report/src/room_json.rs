//! Fitted rooms and learned generators as JSON.

use crate::room::{map_name, method_name};
use serde_json::{Value, json};
use trackwright_calibration::room_fit::FittedRoom;
use trackwright_field::computed::ModelKind;
use trackwright_field::environment::HoldoutProvenance;
use trackwright_field::fit::{FitMethod, FitSettings, Residuals};
use trackwright_field::harmonic::LearnedGenerator;
use trackwright_field::harmonic::learn::{Start, StartReport};

/// A fit as `fit --format json` prints it.
pub fn fit_json(settings: &FitSettings, room: &FittedRoom) -> Value {
    let (fitted, holdout) = (&room.fit, holdout_of(room));
    let residuals = |r: &Residuals| {
        json!({
            "position_rms_mm": r.position_rms_mm,
            "angle_rms_deg": r.angle_rms_rad.map(f64::to_degrees),
        })
    };
    let before_after =
        |before, after| json!({"before": residuals(before), "after": residuals(after)});
    let one_or_all = |values: Vec<Value>| match (settings.method, values.as_slice()) {
        (FitMethod::Joint, [one]) => one.clone(),
        _ => Value::Array(values),
    };
    let mut value = json!({
        "samples": fitted.samples,
        "order": settings.order,
        "directions": settings.directions.len(),
        "method": method_name(settings.method),
        "map": map_name(settings.map),
        "train": before_after(&fitted.before, &fitted.after),
        "holdout": holdout.map(|h| before_after(&h.before, &h.after)),
        "rank": one_or_all(fitted.systems.iter().map(|s| json!(s.rank)).collect()),
        "condition": one_or_all(fitted.systems.iter().map(|s| json!(s.condition)).collect()),
    });
    value["system_samples"] = one_or_all(fitted.systems.iter().map(|s| json!(s.samples)).collect());
    value["ambiguous"] = json!(fitted.ambiguous);
    value["process_samples"] = match &room.environment.process {
        Some(process) => json!(process.rows.len()),
        None => Value::Null,
    };
    let kind = fitted.model.kind();
    value["model"] = json!(kind.name());
    if kind != ModelKind::Bernstein {
        for key in ["order", "directions", "method", "rank", "condition", "system_samples"] {
            value[key] = Value::Null;
        }
    }
    if let Some(harmonic) = &room.harmonic {
        value["harmonic"] = json!({
            "generator": harmonic.generator.name,
            "coils": harmonic.generator.coils.len(),
            "degree": harmonic.settings.degree,
            "ridge": harmonic.settings.ridge,
            "noise_mm": harmonic.noise_mm,
            "down_weighted": harmonic.down_weighted,
            "learned": harmonic.learned.as_ref().map(learned_json),
        });
    }
    value
}

/// The model's figures on measurements that it was not fitted to.
pub fn holdout_of(room: &FittedRoom) -> Option<&HoldoutProvenance> {
    room.environment.provenance.as_ref()?.holdout.as_ref()
}

/// What was learned of a generator.
pub fn learned_json(learned: &LearnedGenerator) -> Value {
    let start = |report: &StartReport| {
        json!({
            "start": start_name(report.start),
            "coils": report.coils,
            "steps": report.steps,
            "has_converged": report.has_converged,
            "held_out": {
                "position_rms_mm": report.held_out.position_rms_mm,
                "angle_rms_deg": report.held_out.angle_rms_rad.map(f64::to_degrees),
            },
        })
    };
    json!({
        "name": learned.generator.name,
        "coils": learned.generator.coils.len(),
        "start": start_name(learned.start),
        "degree": learned.degree,
        "samples": learned.measurements,
        "used": learned.used,
        "held_out_samples": learned.held_out,
        "has_converged": learned.has_converged,
        "starts": learned.starts.iter().map(start).collect::<Vec<_>>(),
    })
}

/// What learning began with, in words.
pub fn start_name(start: Start) -> &'static str {
    match start {
        Start::Triads => "three triads of dipoles",
        Start::Circle => "twelve dipoles on a circle",
    }
}
