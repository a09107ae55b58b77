//! What jitter, sensors that are not built where they were designed, and what is not known of the field
//! add to the errors: `E|e|² = |bias|² + tr cov`, to first order.

use crate::bodies::Bodies;
use crate::problem::BuiltError;
use nalgebra::Point3;
use trackwright_field::environment::Jitter;
use trackwright_field::gaussian::{Amplitude, GaussianField};
use trackwright_geometry::pose::Pose;
use trackwright_simulation::linear_fit::{LinearFit, MotionCovariance};

/// The scatter of tip and rotation for one layout in one room.
pub(crate) struct TipScatter<'a> {
    sensors: SensorScatter<'a>,
    bodies: &'a Bodies,
    tool: Vec<ToolSensor>,
    crf: Option<(LinearFit, MotionCovariance)>,
}

/// What one sensor's readings scatter by.
#[derive(Clone, Copy)]
pub(crate) struct SensorScatter<'a> {
    pub jitter: Option<Jitter>,
    pub built: Option<BuiltError>,
    pub field: Option<FieldScatter<'a>>,
}

/// What measurements leave open of the field, as if each sensor had its own part of it. Sensors beside each
/// other share most of it, so that this counts for more of a rotation than is so: the last steps of a search
/// are judged in drawn fields.
#[derive(Clone, Copy)]
pub(crate) struct FieldScatter<'a> {
    pub amplitude: &'a Amplitude,
    /// Standard deviations an axis where the amplitude is 1.
    pub position_mm: f64,
    pub angle_rad: f64,
}

impl<'a> FieldScatter<'a> {
    /// Of a room at a variance of the process of unit amplitude.
    pub fn of(process: &'a GaussianField, unit_variance: f64) -> Self {
        let std = |from: usize| -> f64 {
            let each = (from..from + 3).map(|c| process.component_covariance[c][c]);
            (unit_variance * each.sum::<f64>() / 3.0).max(0.0).sqrt()
        };
        Self { amplitude: &process.amplitude, position_mm: std(0), angle_rad: std(3) }
    }
}

impl SensorScatter<'_> {
    /// Of a sensor at a place of the tracker frame: standard deviations in mm and rad.
    fn at(&self, place: &Point3<f64>) -> [f64; 2] {
        let jitter = self.jitter.map_or([0.0; 2], |jitter| {
            let local = jitter.at(place);
            [local.position_mm, local.angle_rad]
        });
        let built = self.built.map_or([0.0; 2], |b| [b.position_mm, b.angle_deg.to_radians()]);
        let field = self.field.map_or([0.0; 2], |field| {
            let amplitude = field.amplitude.at(place);
            [amplitude * field.position_mm, amplitude * field.angle_rad]
        });
        [0, 1].map(|k| jitter[k].hypot(built[k]).hypot(field[k]))
    }
}

/// What unit variances of one of the tool's sensors make of the tip's.
struct ToolSensor {
    at_mm: Point3<f64>,
    by_position: f64,
    by_rotation_mm2: f64,
    /// Of the tool's rotation: an mm² and a rad².
    turn_by_position: f64,
    turn_by_rotation: f64,
}

impl<'a> TipScatter<'a> {
    pub fn new(sensors: SensorScatter<'a>, bodies: &'a Bodies, orientation_weight_mm: f64) -> Self {
        let linear = LinearFit::new(&bodies.tool, orientation_weight_mm);
        let lever_mm = linear.lever_mm(&bodies.tool.judged_tip_in_body());
        let units = linear.unit_covariances();
        let tool = bodies.tool.sensors.iter().zip(units).map(|(sensor, unit)| ToolSensor {
            at_mm: sensor.position_in_body,
            by_position: unit.position.point_mm2(&lever_mm).trace(),
            by_rotation_mm2: unit.rotation.point_mm2(&lever_mm).trace(),
            turn_by_position: unit.position.turn_rad2.trace(),
            turn_by_rotation: unit.rotation.turn_rad2.trace(),
        });
        let crf = bodies.crf.as_ref().zip(bodies.tracker_from_crf).map(|(crf, pose)| {
            let linear = LinearFit::new(crf, orientation_weight_mm);
            let mut sum = MotionCovariance::zero();
            for (sensor, unit) in crf.sensors.iter().zip(linear.unit_covariances()) {
                let [position_mm, angle_rad] = sensors.at(&(pose * sensor.position_in_body));
                unit.add_to(&mut sum, position_mm, angle_rad);
            }
            (linear, sum)
        });
        Self { sensors, bodies, tool: tool.collect(), crf }
    }

    /// Tip error in mm and angle error in degrees with the scatter added, the tool at a pose.
    pub fn added_to(
        &self,
        own: [f64; 2],
        crf_from_tool: &Pose,
        tracker_from_crf: Option<Pose>,
    ) -> [f64; 2] {
        let variances = self.variances(crf_from_tool, tracker_from_crf);
        [0, 1].map(|k| (own[k] * own[k] + variances[k]).sqrt())
    }

    /// `tr cov` of tip and rotation with the tool at a pose: mm² and degrees².
    pub fn variances(&self, crf_from_tool: &Pose, tracker_from_crf: Option<Pose>) -> [f64; 2] {
        let pose = tracker_from_crf.or(self.bodies.tracker_from_crf);
        let tracker_from_tool = pose.map_or(*crf_from_tool, |pose| pose * crf_from_tool);
        let (mut tip_mm2, mut turn_rad2) = (0.0, 0.0);
        for sensor in &self.tool {
            let [position_mm, angle_rad] = self.sensors.at(&(tracker_from_tool * sensor.at_mm));
            let (mm2, rad2) = (position_mm.powi(2), angle_rad.powi(2));
            tip_mm2 += sensor.by_position * mm2 + sensor.by_rotation_mm2 * rad2;
            turn_rad2 += sensor.turn_by_position * mm2 + sensor.turn_by_rotation * rad2;
        }
        if let Some((linear, covariance)) = &self.crf {
            let tip_in_crf = crf_from_tool * self.bodies.tool.judged_tip_in_body();
            tip_mm2 += covariance.point_mm2(&linear.lever_mm(&tip_in_crf)).trace();
            turn_rad2 += covariance.turn_rad2.trace();
        }
        [tip_mm2, turn_rad2 * 1_f64.to_degrees().powi(2)]
    }
}
