//! What jitter, and sensors that are not built where they were designed, add to the tip's error:
//! `E|e|² = |bias|² + tr cov`, to first order.

use crate::bodies::Bodies;
use crate::problem::BuiltError;
use nalgebra::Point3;
use trackwright_field::environment::Jitter;
use trackwright_geometry::pose::Pose;
use trackwright_simulation::linear_fit::{LinearFit, MotionCovariance};

/// The scatter of the tip for one layout in one room.
pub(crate) struct TipScatter<'a> {
    sensors: SensorScatter,
    bodies: &'a Bodies,
    tool: Vec<ToolSensor>,
    crf: Option<(LinearFit, MotionCovariance)>,
}

/// What one sensor's readings scatter by.
#[derive(Clone, Copy)]
pub(crate) struct SensorScatter {
    pub jitter: Option<Jitter>,
    pub built: Option<BuiltError>,
}

impl SensorScatter {
    /// Of a sensor at a place of the tracker frame: standard deviations in mm and rad.
    fn at(&self, place: &Point3<f64>) -> [f64; 2] {
        let jitter = self.jitter.map_or([0.0; 2], |jitter| {
            let local = jitter.at(place);
            [local.position_mm, local.angle_rad]
        });
        let built = self.built.map_or([0.0; 2], |b| [b.position_mm, b.angle_deg.to_radians()]);
        [jitter[0].hypot(built[0]), jitter[1].hypot(built[1])]
    }
}

/// What unit variances of one of the tool's sensors make of the tip's.
struct ToolSensor {
    at_mm: Point3<f64>,
    by_position: f64,
    by_rotation_mm2: f64,
}

impl<'a> TipScatter<'a> {
    pub fn new(sensors: SensorScatter, bodies: &'a Bodies, orientation_weight_mm: f64) -> Self {
        let linear = LinearFit::new(&bodies.tool, orientation_weight_mm);
        let lever_mm = linear.lever_mm(&bodies.tool.judged_tip_in_body());
        let units = linear.unit_covariances();
        let tool = bodies.tool.sensors.iter().zip(units).map(|(sensor, unit)| ToolSensor {
            at_mm: sensor.position_in_body,
            by_position: unit.position.point_mm2(&lever_mm).trace(),
            by_rotation_mm2: unit.rotation.point_mm2(&lever_mm).trace(),
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

    /// `tr cov` of the tip with the tool at a pose.
    pub fn variance_mm2(&self, crf_from_tool: &Pose, tracker_from_crf: Option<Pose>) -> f64 {
        let pose = tracker_from_crf.or(self.bodies.tracker_from_crf);
        let tracker_from_tool = pose.map_or(*crf_from_tool, |pose| pose * crf_from_tool);
        let each = self.tool.iter().map(|sensor| {
            let [position_mm, angle_rad] = self.sensors.at(&(tracker_from_tool * sensor.at_mm));
            sensor.by_position * position_mm.powi(2) + sensor.by_rotation_mm2 * angle_rad.powi(2)
        });
        let of_tool: f64 = each.sum();
        let of_crf = self.crf.as_ref().map_or(0.0, |(linear, covariance)| {
            let tip_in_crf = crf_from_tool * self.bodies.tool.judged_tip_in_body();
            covariance.point_mm2(&linear.lever_mm(&tip_in_crf)).trace()
        });
        of_tool + of_crf
    }
}
