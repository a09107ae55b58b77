//! What a room's model predicts for one compensated pose of a body: its standard error at the
//! sensors, the tip error that is left, and whether the model is valid there.

use crate::body::RigidBody;
use crate::linear_fit::{LinearFit, MotionCovariance, UnitCovariance};
use nalgebra::{Point3, Unit, Vector3};
use trackwright_field::validity::{ModelValidity, SensorPlace};
use trackwright_field::{Environment, OutsidePolicy};
use trackwright_geometry::pose::Pose;

/// A body made ready to be predicted often.
pub struct BodyPredictor<'a> {
    validity: Option<ModelValidity<'a>>,
    sensors: Vec<PredictedSensor>,
    /// From the sensors' centroid to the tip, body axes.
    lever_mm: Vector3<f64>,
}

struct PredictedSensor {
    position_in_body: Point3<f64>,
    /// `None` for a marker.
    axis_in_body: Option<Unit<Vector3<f64>>>,
    /// Components of a rotation that it measures.
    rotations: f64,
    covariance: UnitCovariance,
}

/// What is known of a body at one pose.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BodyPrediction {
    /// RMS distance of the compensated tip from the true one; `None` where the fit does not determine
    /// it, or orientations were not measured and the tip depends on them.
    pub tip_rms_mm: Option<f64>,
    /// Error of the model's field (`SensorValidity::position_error_mm`), RMS over the sensors; `None` where
    /// it is not determined.
    pub position_std_error_mm: Option<f64>,
    /// Likewise of the rotation; `None` also where orientations were not measured.
    pub angle_std_error_rad: Option<f64>,
    /// Whether the samples support the model at every sensor (`SensorValidity::is_supported`).
    pub is_valid: bool,
}

impl<'a> BodyPredictor<'a> {
    /// Of a body that the tracker fits to what its sensors read, with a weight of orientations
    /// against positions in mm per radian (13).
    pub fn new(
        body: &RigidBody,
        orientation_weight_mm: f64,
        environment: &'a Environment,
        outside: OutsidePolicy,
    ) -> Self {
        let linear = LinearFit::new(body, orientation_weight_mm);
        let parts = body.sensors.iter().zip(linear.unit_covariances());
        Self {
            validity: environment.model_validity(outside),
            sensors: parts
                .map(|(sensor, covariance)| PredictedSensor {
                    position_in_body: sensor.position_in_body,
                    axis_in_body: sensor.axis_in_body(),
                    rotations: if sensor.orientation.degrees_of_freedom() == 5 { 2.0 } else { 3.0 },
                    covariance,
                })
                .collect(),
            lever_mm: linear.lever_mm(&body.judged_tip_in_body()),
        }
    }

    /// The prediction with the body at a pose; `None` where the room keeps no model validity.
    ///
    /// A sensor's reading is off by what measurements scatter by and by the model's error at the pose,
    /// `σ² + s²`, as a new observation of a regression is; independent from sensor to sensor, and the same
    /// along all axes. The tip's covariance follows to first order. A rotation that the sensors leave free is
    /// taken as known.
    pub fn predict(&self, tracker_from_body: &Pose) -> Option<BodyPrediction> {
        let validity = self.validity.as_ref()?;
        let count = self.sensors.len().max(1) as f64;
        let mut sum = MotionCovariance::zero();
        let (mut position_mm2, mut angle_rad2) = (0.0, Some(0.0));
        let needs_angles =
            self.sensors.iter().any(|s| s.axis_in_body.is_some()) && self.lever_mm.norm() > 0.0;
        let mut is_valid = !self.sensors.is_empty();
        let mut is_tip_predicted = !self.sensors.is_empty();
        let places = self.sensors.iter().map(|sensor| {
            let axis = sensor.axis_in_body.map(|axis| tracker_from_body.rotation * axis);
            (tracker_from_body * sensor.position_in_body, axis)
        });
        let places: Vec<SensorPlace> = places.collect();
        let found = validity.at(&places);
        for ((sensor, place), at) in self.sensors.iter().zip(&places).zip(found) {
            is_valid &= at.is_supported;
            position_mm2 += at.position_error_mm.powi(2) / count;
            angle_rad2 =
                angle_rad2.zip(at.angle_error_rad).map(|(sum, angle)| sum + angle * angle / count);
            let scatter = validity.scatter_at(&place.0);
            is_tip_predicted &= scatter.is_some_and(|of| of.angle_rad.is_some() || !needs_angles);
            if let Some(scatter) = scatter {
                let position_mm = scatter.position_mm.hypot(at.position_error_mm);
                let angle_rad =
                    (scatter.angle_rad.unwrap_or(0.0)).hypot(at.angle_error_rad.unwrap_or(0.0));
                let (mm, rad) = (position_mm / 3.0_f64.sqrt(), angle_rad / sensor.rotations.sqrt());
                sensor.covariance.add_to(&mut sum, mm, rad);
            }
        }
        let finite_root = |square: f64| square.is_finite().then(|| square.sqrt());
        let tip_mm2 = sum.point_mm2(&self.lever_mm).trace().max(0.0);
        Some(BodyPrediction {
            tip_rms_mm: finite_root(tip_mm2).filter(|_| is_tip_predicted),
            position_std_error_mm: finite_root(position_mm2),
            angle_std_error_rad: angle_rad2.and_then(finite_root),
            is_valid,
        })
    }
}
