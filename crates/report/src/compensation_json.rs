//! Compensated readings as JSON.

use serde_json::{Value, json};
use trackwright_field::compensation::{Compensation, Method, Tally};

/// A method as `--format json` names it.
pub fn method_name(method: Method) -> &'static str {
    match method {
        Method::Correction => "correction",
        Method::Inverse => "inverse",
        Method::Shortcut => "shortcut",
    }
}

/// A run as `compensate --format json` prints it.
pub fn compensation_json(outcome: &Compensation) -> Value {
    let mut value = tally_json(&outcome.tally);
    value["method"] = json!(method_name(outcome.method));
    value["shortcut_against_inverse"] = json!(outcome.shortcut.map(|d| json!({
        "compared": d.compared,
        "position_rms_mm": d.position_rms_mm,
        "position_max_mm": d.position_max_mm,
        "angle_rms_deg": d.angle_rms_rad.to_degrees(),
        "angle_max_deg": d.angle_max_rad.to_degrees(),
    })));
    value
}

/// What became of readings that were corrected for a room.
pub fn tally_json(t: &Tally) -> Value {
    json!({
        "rows": t.rows,
        "converged": t.converged,
        "ambiguous": t.ambiguous,
        "folded": t.folded,
        "not_converged": t.not_converged,
        "rejected": t.rejected,
        "outside": t.outside,
        "largest_correction_mm": t.largest_correction_mm,
        "largest_correction_deg": t.largest_correction_rad.to_degrees(),
    })
}
