//! Calibrations and registrations as JSON, and what their standard errors do not hold for.

use nalgebra::{Point3, Vector3};
use serde_json::{Value, json};
use trackwright_calibration::judged_registration::JudgedRegistration;
use trackwright_calibration::pivot::Pivot;
use trackwright_calibration::spin::Spin;
use trackwright_geometry::pose::pose_to_array;

/// A tip as `pivot --format json` prints it.
pub fn pivot_json(found: &Pivot) -> Value {
    let point = |point: &Point3<f64>| -> [f64; 3] { point.coords.into() };
    json!({
        "poses": found.poses,
        "tip": point(&found.tip_in_tool),
        "pivot": point(&found.pivot_in_tracker),
        "rms_mm": found.rms_mm,
        "rms_component_mm": found.rms_component_mm(),
        "orientation_range_deg": found.orientation_range_rad.to_degrees(),
        "tip_std_error_mm": found.tip_std_error_mm,
        "pivot_std_error_mm": found.pivot_std_error_mm(),
        "intervals": intervals(found),
        "covariance_mm2": (0..6)
            .map(|i| (0..6).map(|j| found.covariance_mm2[(i, j)]).collect::<Vec<_>>())
            .collect::<Vec<_>>(),
        "effective": found.effective_size.effective,
        "degrees_of_freedom": found.effective_size.freedom,
        "quarters": found.quarters.map(|quarters| json!({
            "apart_mm": quarters.apart_mm,
            "expected_mm": quarters.expected_mm,
            "drift": quarters.has_drift,
        })),
    })
}

/// Of 95 %, component by component; null where the recording is too short.
fn intervals(found: &Pivot) -> Value {
    let around = |at: &Point3<f64>, half: Vector3<f64>| {
        json!([0, 1, 2].map(|k| [at[k] - half[k], at[k] + half[k]]))
    };
    match found.half_widths_mm() {
        Some([tip, pivot]) => json!({
            "tip": around(&found.tip_in_tool, tip),
            "pivot": around(&found.pivot_in_tracker, pivot),
        }),
        None => Value::Null,
    }
}

/// What the standard errors of a tip do not hold for.
pub fn error_limits(found: &Pivot) -> Option<String> {
    match (found.effective_size.freedom, &found.quarters) {
        (None, _) => Some(
            "the recording is too short to determine how far readings depend on their neighbours: standard errors are lower \
             bounds, and there are no intervals"
                .to_owned(),
        ),
        (Some(_), None) => Some(
            "a quarter of the recording by itself does not determine the tip: slow drift cannot be distinguished from the tool's \
             motion, and is not in the standard errors"
                .to_owned(),
        ),
        (Some(_), Some(quarters)) if quarters.has_drift => Some(format!(
            "the tips of two quarters of the recording differ by {:.3} mm, with a standard error of {:.3} mm by what \
             happens within them: the tip or a sensor moved, or the field differs; the standard errors of the whole \
             include it",
            quarters.apart_mm, quarters.expected_mm
        )),
        _ => None
    }
}

/// Why a shaft's direction is open, or its standard error a lower bound; `has_tip` where the tip is known.
pub fn shaft_limits(spin: &Spin, has_tip: bool, is_towards_tip: bool) -> Vec<&'static str> {
    let mut limits = Vec::new();
    if spin.effective_size.freedom.is_none() {
        limits.push(
            "the recording of turns is too short to determine how far readings depend on their neighbours: the shaft's \
             standard error is a lower bound",
        );
    }
    match (is_towards_tip, has_tip) {
        (true, _) => {}
        (false, false) => limits.push(
            "no tip is known: which of the two directions along the shaft leads to it is open",
        ),
        (false, true) => limits.push(
            "the tip is not clearly before or behind the tool's origin: which of the two directions along the \
             shaft leads to it is open",
        ),
    }
    limits
}

/// A shaft as `pivot --spin --format json` prints it; `is_towards_tip` where its direction leads to the
/// tip.
pub fn spin_json(spin: &Spin, is_towards_tip: bool) -> Value {
    let direction = |v: &Vector3<f64>| -> [f64; 3] { (*v).into() };
    let rows: [[f64; 3]; 3] = spin.covariance.transpose().into();
    json!({
        "poses": spin.poses,
        "shaft": direction(&spin.shaft_in_tool),
        "shaft_in_tracker": direction(&spin.shaft_in_tracker),
        "towards_tip": is_towards_tip,
        "rms_deg": spin.rms_rad.to_degrees(),
        "max_deg": spin.worst_rad.to_degrees(),
        "std_error_deg": spin.std_error_rad.to_degrees(),
        "covariance": rows,
        "orientation_range_deg": spin.orientation_range_rad.to_degrees(),
        "effective": spin.effective_size.effective,
        "degrees_of_freedom": spin.effective_size.freedom,
        "half_width_95_deg": spin.half_width_rad().map(f64::to_degrees),
    })
}

/// A registration as `register --format json` prints it.
pub fn registration_json(found: &JudgedRegistration) -> Value {
    json!({
        "points": found.residuals_mm.len() - found.left_out.len(),
        "target_from_source": pose_to_array(&found.registration.target_from_source),
        "fre_rms_mm": found.registration.fre_rms_mm,
        "residuals_mm": found.residuals_mm,
        "fre_of_all_rms_mm": found.fre_of_all_mm,
        "left_out": found.left_out.iter().map(|point| json!({
            "point": point.index + 1,
            "off_mm": point.off_mm,
            "chance": point.chance,
        })).collect::<Vec<_>>(),
        "fle_rms_mm": found.fle_mm,
        "off_line_mm": found.spread.off_line_mm(),
        "turn_std_error_deg": found.turn_error_deg(),
    })
}
