//! What the small writers put where; independent readers are in `tests/commands/export.rs`.

use super::markups::MarkupPoint;
use super::*;
use serde_json::Value;
use trackwright_geometry::pose::{Pose, pose_from_array};

/// A quarter turn about z, and a shift.
fn pose() -> Pose {
    let half = std::f64::consts::FRAC_1_SQRT_2;
    pose_from_array([1.0, 2.0, 3.0, half, 0.0, 0.0, half]).unwrap()
}

fn markup(axes: PatientAxes) -> Value {
    let point = MarkupPoint { label: "tip \"1\"".to_owned(), tracker_from_point: pose() };
    let mut bytes = Vec::new();
    markups::write(&mut bytes, &[point], axes).unwrap();
    serde_json::from_slice(&bytes).unwrap()
}

#[test]
fn markups_are_lps_with_axes_as_columns() {
    for (axes, sign) in [(PatientAxes::Ras, -1.0), (PatientAxes::Lps, 1.0)] {
        let file = markup(axes);
        let list = &file["markups"][0];
        assert_eq!(list["coordinateSystem"], "LPS");
        let point = &list["controlPoints"][0];
        assert_eq!(point["label"], "tip \"1\"");
        assert_eq!(point["positionStatus"], "defined");
        let position: [f64; 3] = serde_json::from_value(point["position"].clone()).unwrap();
        assert_eq!(position, [sign, 2.0 * sign, 3.0]);
        // Its x is the tracker's y, its y the tracker's -x, its z the tracker's.
        let expected = [0.0, -sign, 0.0, sign, 0.0, 0.0, 0.0, 0.0, 1.0];
        let orientation: [f64; 9] = serde_json::from_value(point["orientation"].clone()).unwrap();
        for (found, expected) in orientation.iter().zip(expected) {
            assert!((found - expected).abs() < 1e-15, "{orientation:?}");
        }
    }
}
