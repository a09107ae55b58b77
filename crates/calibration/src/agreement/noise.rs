//! How far the tip scatters at each pose by what the room states of itself: the tracker's jitter and
//! the field's standard error, to first order.

use super::rows::AgreementRow;
use nalgebra::{Matrix3, Point3, UnitQuaternion};
use trackwright_field::OutsidePolicy;
use trackwright_field::validity::ModelValidity;
use trackwright_geometry::pose::Pose;
use trackwright_simulation::linear_fit::{LinearFit, MotionCovariance, SensorCovariance};
use trackwright_simulation::scenario::Scenario;
use trackwright_simulation::support::is_supported;
use trackwright_simulation::{RigidBody, Sensor};

/// What a sensor's reading scatters by, a component: variances in mm² and rad².
type Variances = [f64; 2];

/// Where noise comes from.
pub struct Noise<'a> {
    scenario: &'a Scenario,
    tool: LinearFit,
    crf: Option<LinearFit>,
    validity: Option<ModelValidity<'a>>,
    averaged: f64,
    truth_std_mm: f64,
}

impl<'a> Noise<'a> {
    /// The noise of a scenario, for means of so many readings.
    pub fn new(scenario: &'a Scenario, averaged: f64, truth_std_mm: f64) -> Self {
        let linear = |body: &RigidBody| LinearFit::new(body, scenario.orientation_weight_mm);
        Self {
            tool: linear(&scenario.tool),
            crf: scenario.crf.as_ref().map(|crf| linear(&crf.body)),
            validity: scenario.environment.model_validity(OutsidePolicy::Clamp),
            scenario,
            averaged,
            truth_std_mm,
        }
    }

    /// Whether the room states jitter.
    pub fn has_jitter(&self) -> bool {
        self.scenario.environment.jitter.is_some()
    }

    /// Whether the room states its field's standard error.
    pub fn has_field_error(&self) -> bool {
        self.validity.is_some()
    }

    /// Covariance of the tip in CRF axes, of jitter, field and truth together; `None` where the room
    /// states nothing, or the fit does not determine the field.
    pub fn at(&self, row: &AgreementRow) -> Option<Matrix3<f64>> {
        if !self.has_jitter() && !self.has_field_error() {
            return None;
        }
        let both = |sensor: &Sensor, pose: &Pose| {
            let [jitter, field] = [self.jitter(sensor, pose), self.field_error(sensor, pose)];
            let sum = [jitter[0] + field[0], jitter[1] + field[1]];
            sum.iter().all(|v| v.is_finite()).then_some(sum)
        };
        Some(self.tip_covariance(row, &both)? + self.truth_mm2())
    }

    /// The same without the field, whose error is the prediction's: what a measurement scatters by.
    /// `None` where the room states no jitter.
    pub fn of_measurement(&self, row: &AgreementRow) -> Option<Matrix3<f64>> {
        if !self.has_jitter() {
            return None;
        }
        let jitter = |sensor: &Sensor, pose: &Pose| Some(self.jitter(sensor, pose));
        Some(self.tip_covariance(row, &jitter)? + self.truth_mm2())
    }

    fn truth_mm2(&self) -> Matrix3<f64> {
        Matrix3::identity() * self.truth_std_mm.powi(2)
    }

    /// The same of the room's own misfit: what its model leaves of the measurements that it was
    /// judged by. `None` where it does not state it.
    pub fn misfit_mm2(&self, row: &AgreementRow) -> Option<f64> {
        let provenance = self.scenario.environment.provenance.as_ref()?;
        let left = provenance.holdout.as_ref().map_or(provenance.train_after, |h| h.after);
        let of = |sensor: &Sensor, _: &Pose| {
            let angle_rad = left.angle_rms_rad.unwrap_or(0.0);
            Some([left.position_rms_mm.powi(2) / 3.0, angle_rad.powi(2) / rotations(sensor)])
        };
        Some(self.tip_covariance(row, &of)?.trace())
    }

    /// Whether a sensor of tool or CRF leans on field that the samples do not support.
    pub fn is_unsupported(&self, row: &AgreementRow) -> Option<bool> {
        let validity = self.validity.as_ref()?;
        let tracker_from_crf = row.tracker_from_crf_in(self.scenario);
        let crf = self.scenario.crf.as_ref();
        let tool = tracker_from_crf * row.crf_from_tool;
        Some(
            !(is_supported(validity, &self.scenario.tool, &tool)
                && crf.is_none_or(|crf| is_supported(validity, &crf.body, &tracker_from_crf))),
        )
    }

    fn tip_covariance(
        &self,
        row: &AgreementRow,
        of: &impl Fn(&Sensor, &Pose) -> Option<Variances>,
    ) -> Option<Matrix3<f64>> {
        let tracker_from_crf = row.tracker_from_crf_in(self.scenario);
        let tracker_from_tool = tracker_from_crf * row.crf_from_tool;
        let tip_in_tool = self.scenario.tool.judged_tip_in_body();
        let at_tip = |linear: &LinearFit,
                      body,
                      pose: &Pose,
                      turn: &UnitQuaternion<f64>,
                      tip: &Point3<f64>| {
            let covariance = motion(linear, body, pose, of)?.rotated_by(turn);
            Some(covariance.point_mm2(&(turn * linear.lever_mm(tip))))
        };
        let mut sum = at_tip(
            &self.tool,
            &self.scenario.tool,
            &tracker_from_tool,
            &row.crf_from_tool.rotation,
            &tip_in_tool,
        )?;
        if let (Some(crf), Some(linear)) = (&self.scenario.crf, &self.crf) {
            sum += at_tip(
                linear,
                &crf.body,
                &tracker_from_crf,
                &UnitQuaternion::identity(),
                &(row.crf_from_tool * tip_in_tool),
            )?;
        }
        Some(sum)
    }

    /// Of a mean of readings.
    fn jitter(&self, sensor: &Sensor, tracker_from_body: &Pose) -> Variances {
        let at = tracker_from_body * sensor.position_in_body;
        let jitter = self.scenario.environment.jitter.as_ref();
        jitter.map_or([0.0; 2], |jitter| {
            let local = jitter.at(&at);
            [local.position_mm, local.angle_rad].map(|std| std.powi(2) / self.averaged)
        })
    }

    fn field_error(&self, sensor: &Sensor, tracker_from_body: &Pose) -> Variances {
        let validity = self.validity.as_ref();
        validity.map_or([0.0; 2], |validity| field_variances(validity, sensor, tracker_from_body))
    }
}

/// Components of a rotation's variance: the turn of an axis has two.
fn rotations(sensor: &Sensor) -> f64 {
    if sensor.orientation.degrees_of_freedom() == 5 { 2.0 } else { 3.0 }
}

/// Model validity gives lengths of vectors.
fn field_variances(
    validity: &ModelValidity,
    sensor: &Sensor,
    tracker_from_body: &Pose,
) -> Variances {
    let axis = sensor.axis_in_body().map(|axis| tracker_from_body.rotation * axis);
    let at = validity.at_sensor(&(tracker_from_body * sensor.position_in_body, axis));
    let angle_rad = at.angle_error_rad.unwrap_or(0.0);
    [at.position_error_mm.powi(2) / 3.0, angle_rad.powi(2) / rotations(sensor)]
}

fn motion(
    linear: &LinearFit,
    body: &RigidBody,
    tracker_from_body: &Pose,
    of: &impl Fn(&Sensor, &Pose) -> Option<Variances>,
) -> Option<MotionCovariance> {
    let each: Option<Vec<SensorCovariance>> = body
        .sensors
        .iter()
        .map(|sensor| {
            let [position, angle] = of(sensor, tracker_from_body)?;
            Some(SensorCovariance::isotropic(position.sqrt(), angle.sqrt()))
        })
        .collect();
    Some(linear.covariance(&each?))
}
