//! What a room's model predicts for one compensated pose of a body: its standard error at the
//! sensors, the tip error that is left, and whether the model is valid there.

use crate::body::RigidBody;
use crate::linear_fit::{LinearFit, MotionCovariance, UnitCovariance};
use nalgebra::{Point3, Unit, Vector3};
use trackwright_field::{Environment, FitValidity, OutsidePolicy};
use trackwright_geometry::pose::Pose;

/// A body made ready to be predicted often.
pub struct BodyPredictor<'a> {
    support: Option<&'a FitValidity>,
    outside: OutsidePolicy,
    sensors: Vec<PredictedSensor>,
    /// From the sensors' centroid to the tip, body axes.
    lever_mm: Vector3<f64>,
    noise: Option<Noise>,
}

struct PredictedSensor {
    position_in_body: Point3<f64>,
    /// `None` for a marker.
    axis_in_body: Option<Unit<Vector3<f64>>>,
    /// Components of a rotation that it measures.
    rotations: f64,
    covariance: UnitCovariance,
}

/// What the fit left of its samples, RMS lengths of vectors.
struct Noise {
    position_mm: f64,
    angle_rad: Option<f64>,
}

/// What is known of a body at one pose.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BodyPrediction {
    /// RMS distance of the compensated tip from the true one; `None` where the fit does not determine
    /// it, or orientations were not measured and the tip depends on them.
    pub tip_rms_mm: Option<f64>,
    /// Standard error of the model's field, RMS over the sensors; `None` where it is not determined.
    pub position_std_error_mm: Option<f64>,
    /// Likewise of the rotation; `None` also where orientations were not measured.
    pub angle_std_error_rad: Option<f64>,
    /// Whether the samples support the model at every sensor ([FitValidity::is_valid`]).
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
        let support = environment.fit_validity.as_ref();
        Self {
            support,
            outside,
            sensors: parts
                .map(|(sensor, covariance)| PredictedSensor {
                    position_in_body: sensor.position_in_body,
                    axis_in_body: sensor.axis_in_body(),
                    rotations: if sensor.orientation.degrees_of_freedom() == 5 { 2.0 } else { 3.0 },
                    covariance,
                })
                .collect(),
            lever_mm: linear.lever_mm(&body.judged_tip_in_body()),
            noise: support.and_then(Noise::of),
        }
    }

    /// The prediction with the body at a pose; `None` where the room keeps no support.
    ///
    /// A sensor's reading is off by what the fit left of its samples (noise, and what the model does
    /// not follow) and by the model's standard error at the pose, `σ² + s²`, as a new observation of a
    /// regression is; independent from sensor to sensor, and the same along all axes. The tip's
    /// covariance follows to first order. A rotation that the sensors leave free is taken as known.
    pub fn predict(&self, tracker_from_body: &Pose) -> Option<BodyPrediction> {
        let support = self.support?;
        let count = self.sensors.len().max(1) as f64;
        let mut sum = MotionCovariance::zero();
        let (mut position_mm2, mut angle_rad2) = (0.0, Some(0.0));
        let mut is_valid = !self.sensors.is_empty();
        for sensor in &self.sensors {
            let position_mm = tracker_from_body * sensor.position_in_body;
            let axis = sensor.axis_in_body.map(|axis| tracker_from_body.rotation * axis);
            let at = support.at_sensor(&position_mm, axis.as_ref(), self.outside);
            is_valid &= at.is_valid;
            position_mm2 += at.position_std_error_mm.powi(2) / count;
            angle_rad2 = angle_rad2
                .zip(at.angle_std_error_rad)
                .map(|(sum, angle)| sum + angle * angle / count);
            if let Some(noise) = &self.noise {
                let position_mm = noise.position_mm.hypot(at.position_std_error_mm);
                let angle_rad =
                    (noise.angle_rad.unwrap_or(0.0)).hypot(at.angle_std_error_rad.unwrap_or(0.0));
                let (mm, rad) = (position_mm / 3.0_f64.sqrt(), angle_rad / sensor.rotations.sqrt());
                sensor.covariance.add_to(&mut sum, mm, rad);
            }
        }
        let finite_root = |square: f64| square.is_finite().then(|| square.sqrt());
        let tip_mm2 = sum.point_mm2(&self.lever_mm).trace().max(0.0);
        Some(BodyPrediction {
            tip_rms_mm: finite_root(tip_mm2).filter(|_| self.is_tip_predicted()),
            position_std_error_mm: finite_root(position_mm2),
            angle_std_error_rad: angle_rad2.and_then(finite_root),
            is_valid,
        })
    }

    fn is_tip_predicted(&self) -> bool {
        let has_axes = self.sensors.iter().any(|s| s.axis_in_body.is_some());
        let needs_angles = has_axes && self.lever_mm.norm() > 0.0;
        (self.noise.as_ref()).is_some_and(|noise| noise.angle_rad.is_some() || !needs_angles)
            && !self.sensors.is_empty()
    }
}

impl Noise {
    /// `None` where a fit has no residual to estimate its noise from.
    fn of(support: &FitValidity) -> Option<Self> {
        let parts = support.parts();
        Some(Self {
            position_mm: rms(&parts.position_std_mm)?,
            angle_rad: parts.angle_std_rad.as_deref().and_then(rms),
        })
    }
}

fn rms(values: &[Option<f64>]) -> Option<f64> {
    let squares: Option<f64> = values.iter().map(|v| v.map(|v| v * v)).sum();
    squares.filter(|_| !values.is_empty()).map(|sum| (sum / values.len() as f64).sqrt())
}
