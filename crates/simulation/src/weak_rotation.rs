//! A rotation that a body's sensors determine, but barely: what their errors are multiplied by.

use super::axis_words::{axis_words, body_name, shaft_of};
use super::body::RigidBody;
use super::linear_fit::LinearFit;
use super::scenario::Scenario;
use serde::Serialize;

/// A rotation is barely determined where a degree of tilt, or a millimetre of shift, in its sensors
/// turns the body by as many degrees.
///
/// Readings in a distorted field are off by some tenths of a degree and of a millimetre, which ten
/// times multiplied are degrees of the body; two square 5-DOF sensors multiply by one, and two at 20°
/// by four. Ten is where two 5-DOF sensors on a line are parallel up to 8°, or where parallel ones
/// stand 8 mm apart: nobody draws either to determine a rotation.
pub const BARELY: f64 = 10.0;

/// A multiplied degree that is no angle any more.
const ANY_ANGLE_DEG: f64 = 90.0;

/// The rotation that a body's sensors determine least, where that is barely.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct WeakRotation {
    /// `tool` or `crf`.
    pub body: &'static str,
    /// In that body's frame.
    #[serde(rename = "axis")]
    pub axis_in_body: [f64; 3],
    /// That of the body's shaft, if it has one, for words.
    #[serde(skip)]
    pub shaft_in_body: Option<[f64; 3]>,
    /// Degrees that it turns by for each degree that its sensors are tilted: RMS for errors of one
    /// degree about every axis of every sensor, independent of each other.
    pub turn_per_tilt: f64,
    /// Degrees that it turns by for each millimetre that its sensors are read off, likewise.
    pub turn_deg_per_mm: f64,
}

impl WeakRotation {
    /// Of a body, by its key; `None` where the rotation is well determined, or partly free.
    pub fn of_body(
        key: &'static str,
        body: &RigidBody,
        orientation_weight_mm: f64,
    ) -> Option<Self> {
        let (axis, by_tilt, by_shift) =
            LinearFit::new(body, orientation_weight_mm).least_determined_turn()?;
        let is_backward = axis[axis.iamax()] < 0.0;
        let axis = if is_backward { -axis } else { axis };
        let weak = Self {
            body: key,
            axis_in_body: axis.into_inner().into(),
            shaft_in_body: shaft_of(key, body),
            turn_per_tilt: by_tilt,
            turn_deg_per_mm: by_shift.to_degrees(),
        };
        (weak.largest() >= BARELY).then_some(weak)
    }

    /// Of tool and CRF, the one that is determined less.
    pub fn of(scenario: &Scenario) -> Option<Self> {
        let weight_mm = scenario.orientation_weight_mm;
        let tool = Self::of_body("tool", &scenario.tool, weight_mm);
        let crf = scenario.crf.as_ref();
        let crf = crf.and_then(|crf| Self::of_body("crf", &crf.body, weight_mm));
        [tool, crf].into_iter().flatten().max_by(|a, b| a.largest().total_cmp(&b.largest()))
    }

    fn largest(&self) -> f64 {
        self.turn_per_tilt.max(self.turn_deg_per_mm)
    }

    /// What is barely determined, and what it costs; one sentence without a full stop.
    pub fn statement(&self) -> String {
        let body = body_name(self.body);
        let axis = axis_words(self.axis_in_body, self.shaft_in_body, body);
        let (cause, turn_deg) = match self.turn_per_tilt >= self.turn_deg_per_mm {
            true => ("1° of tilt in its sensors", self.turn_per_tilt),
            false => ("1 mm of error in its sensors' positions", self.turn_deg_per_mm),
        };
        let turn = match turn_deg <= ANY_ANGLE_DEG {
            true => format!("{turn_deg:.0}°"),
            false => format!("more than {ANY_ANGLE_DEG:.0}°"),
        };
        format!(
            "the {body}'s rotation about {axis} is barely determined: {cause} turns it by {turn}"
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::body::{Sensor, SensorOrientation};
    use crate::frame_fit::{FrameFitter, Reading};
    use nalgebra::{Unit, UnitQuaternion, Vector3};
    use trackwright_geometry::pose::Pose;

    const WEIGHT_MM: f64 = 100.0;

    fn five(position: [f64; 3], axis: [f64; 3]) -> Sensor {
        Sensor::five_dof("", position, Unit::new_normalize(axis.into()))
    }

    fn weak(sensors: Vec<Sensor>) -> Option<WeakRotation> {
        let body = RigidBody { name: "body".into(), tip_in_body: None, sensors };
        WeakRotation::of_body("tool", &body, WEIGHT_MM)
    }

    /// Two sensors on a needle whose axes are at an angle.
    fn needle(angle_deg: f64) -> Vec<Sensor> {
        let (sine, cosine) = angle_deg.to_radians().sin_cos();
        vec![five([0.0, 0.0, 60.0], [0.0, 0.0, 1.0]), five([0.0, 0.0, 95.0], [sine, 0.0, cosine])]
    }

    #[test]
    fn nearly_parallel_sensors_multiply_tilts() {
        for angle_deg in [0.5, 2.0, 5.0, 7.0] {
            let weak = weak(needle(angle_deg)).unwrap_or_else(|| panic!("{angle_deg}"));
            let expected = 2.0_f64.sqrt() / angle_deg.to_radians();
            // 35 mm between them hold 3 % of what the axes do.
            assert!((weak.turn_per_tilt / expected - 0.97).abs() < 0.01, "{weak:?} {expected}");
            let along = Vector3::from(weak.axis_in_body).z.abs();
            assert!(along > angle_deg.to_radians().cos(), "{weak:?}");
        }
    }

    #[test]
    fn firm_and_free_rotations_are_no_weak_ones() {
        assert_eq!(weak(needle(90.0)), None);
        assert_eq!(weak(needle(20.0)), None);
        assert_eq!(weak(needle(0.0)), None, "free, which has its own statement");
        let mut six = five([0.0; 3], [0.0, 0.0, 1.0]);
        six.orientation = SensorOrientation::SixDof(UnitQuaternion::identity());
        assert_eq!(weak(vec![six]), None);
    }

    #[test]
    fn parallel_sensors_side_by_side_multiply_shifts() {
        let apart = |mm: f64| {
            weak(vec![five([0.0; 3], [0.0, 0.0, 1.0]), five([mm, 0.0, 0.0], [0.0, 0.0, 1.0])])
        };
        let found = apart(2.0).unwrap();
        // A millimetre at either end of 2 mm, square to it: √2 / 2 rad.
        assert!((found.turn_deg_per_mm - 0.5_f64.sqrt().to_degrees()).abs() < 1e-9, "{found:?}");
        assert!(found.turn_per_tilt < 1e-9);
        assert_eq!(
            found.statement(),
            "the tool's rotation about the tool's z axis is barely determined: 1 mm of error in its \
             sensors' positions turns it by 41°"
        );
        assert_eq!(apart(30.0), None);
    }

    #[test]
    fn the_statement_names_body_axis_and_cost() {
        let text = weak(needle(3.0)).unwrap().statement();
        assert!(text.starts_with("the tool's rotation about "), "{text}");
        assert!(text.ends_with("1° of tilt in its sensors turns it by 26°"), "{text}");
        let text = weak(needle(0.5)).unwrap().statement();
        assert!(text.ends_with("turns it by more than 90°"), "{text}");
    }

    #[test]
    fn a_fit_turns_by_what_is_stated() {
        let sensors = needle(5.0);
        let stated = weak(sensors.clone()).unwrap();
        let body = RigidBody { name: "body".into(), tip_in_body: None, sensors };
        let fitter = FrameFitter::new(&body, WEIGHT_MM);
        // Every axis of every sensor tilted by itself; the squares add up.
        let tilt_rad = 1e-6;
        let mut sum = 0.0;
        for tilted in 0..2 {
            for about in [Vector3::x(), Vector3::y(), Vector3::z()] {
                let readings: Vec<Reading> = (body.sensors.iter().enumerate())
                    .map(|(index, sensor)| {
                        let at = sensor.body_from_sensor();
                        let turn =
                            if index == tilted { about * tilt_rad } else { Vector3::zeros() };
                        Reading {
                            position_mm: at.translation.vector.into(),
                            rotation: UnitQuaternion::from_scaled_axis(turn) * at.rotation,
                        }
                    })
                    .collect();
                let fit = fitter.fit(&readings, &Pose::identity());
                let turn = fit.tracker_from_body.rotation.scaled_axis();
                sum += (turn.dot(&Vector3::from(stated.axis_in_body)) / tilt_rad).powi(2);
            }
        }
        let found = sum.sqrt();
        assert!((found / stated.turn_per_tilt - 1.0).abs() < 1e-4, "{found} {stated:?}");
    }
}
