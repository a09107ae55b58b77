//! An axis of a body in words: the shaft or an axis of its frame where it is one, else numbers.

use super::body::RigidBody;
use super::shaft::shaft_in_body;
use nalgebra::Vector3;

/// What is nearer to an axis than this is along it.
const ALONG_DEG: f64 = 1.0;

/// The shaft of a body by its key: a CRF has none.
pub(super) fn shaft_of(key: &str, body: &RigidBody) -> Option<[f64; 3]> {
    let shaft = (key == "tool").then(|| shaft_in_body(body)).flatten();
    shaft.map(|shaft| shaft.into_inner().into())
}

/// The name of a body for a person, by its key.
pub(super) fn body_name(key: &'static str) -> &'static str {
    if key == "crf" { "CRF" } else { key }
}

/// An axis of either sign, after *about* or *along*: `the shaft`, `the tool's x axis`, or its
/// components with two decimals.
pub fn axis_words(
    axis_in_body: [f64; 3],
    shaft_in_body: Option<[f64; 3]>,
    body_name: &str,
) -> String {
    let axis = Vector3::from(axis_in_body);
    let is_along = |other: &Vector3<f64>| {
        let off_rad = axis.cross(other).norm().atan2(axis.dot(other).abs());
        off_rad.to_degrees() < ALONG_DEG
    };
    if shaft_in_body.is_some_and(|shaft| is_along(&shaft.into())) {
        return "the shaft".to_owned();
    }
    let frame = [("x", Vector3::x()), ("y", Vector3::y()), ("z", Vector3::z())];
    if let Some((name, _)) = frame.iter().find(|(_, own)| is_along(own)) {
        return format!("the {body_name}'s {name} axis");
    }
    // As it is printed, and zero without a sign.
    let [x, y, z] = axis_in_body.map(|value| (value * 1e2).round() / 1e2 + 0.0);
    format!("({x:.2}, {y:.2}, {z:.2})")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::body::Sensor;
    use nalgebra::Point3;

    const SHAFT: Option<[f64; 3]> = Some([0.0, 0.6, 0.8]);

    fn turned_from_x(angle_deg: f64) -> [f64; 3] {
        let (sine, cosine) = angle_deg.to_radians().sin_cos();
        [cosine, -sine, 0.0]
    }

    #[test]
    fn an_axis_along_the_shaft_is_named_by_it() {
        assert_eq!(axis_words([0.0, 0.6, 0.8], SHAFT, "tool"), "the shaft");
        assert_eq!(axis_words([0.0, -0.6, -0.8], SHAFT, "tool"), "the shaft", "either sign");
        assert_eq!(axis_words([0.01, 0.6, 0.8], SHAFT, "tool"), "the shaft", "0.6° off");
        assert_eq!(axis_words([0.0, 0.6, 0.8], None, "tool"), "(0.00, 0.60, 0.80)");
        // Of a shaft along an axis of the frame the shaft is named.
        assert_eq!(axis_words([0.0, 0.0, 1.0], Some([0.0, 0.0, 1.0]), "tool"), "the shaft");
    }

    #[test]
    fn an_axis_of_the_frame_is_named_up_to_a_degree() {
        assert_eq!(axis_words(turned_from_x(0.9), SHAFT, "tool"), "the tool's x axis");
        assert_eq!(axis_words(turned_from_x(1.1), SHAFT, "tool"), "(1.00, -0.02, 0.00)");
        assert_eq!(axis_words([0.0, -1.0, 0.0], None, "CRF"), "the CRF's y axis");
    }

    #[test]
    fn only_a_tool_has_a_shaft() {
        let at = |z: f64| Sensor::five_dof("", Point3::new(0.0, 0.0, z), Vector3::x_axis());
        let body = RigidBody {
            name: "needle".into(),
            tip_in_body: Some(Point3::origin()),
            sensors: vec![at(40.0), at(60.0)],
        };
        assert_eq!(shaft_of("tool", &body), Some([0.0, 0.0, 1.0]));
        assert_eq!(shaft_of("crf", &body), None);
    }
}
