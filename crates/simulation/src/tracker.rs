//! Tracks a body at many poses: every sensor distorted (6), (7), the frame refitted (9)–(13).

use super::scenario::Scenario;
use super::work::Work;
use crate::body::{RigidBody, Sensor};
use crate::frame_fit::Determination;
use crate::frame_fit::{FrameFit, FrameFitter, Reading};
use crate::tool_in_crf::FreeMotion;
use nalgebra::{Point3, Unit, Vector3};
use trackwright_field::FieldPoint;
use trackwright_field::axis_model::AxisModel;
use trackwright_field::model::Evaluation;
use trackwright_field::samples::PoseError;
use trackwright_field::{Batch, Environment, OutsidePolicy};
use trackwright_geometry::pose::{Pose, pose_from_parts};
use trackwright_geometry::rotation::exp_vector;

/// Fewest poses with one orientation for which a model of that orientation is made: blending
/// costs as many products as three evaluations with it, and saves two of three after that.
pub const MIN_RUN: usize = 16;

/// Tracks one body in one room.
pub struct BodyTracker<'a> {
    environment: &'a Environment,
    outside: OutsidePolicy,
    fitter: FrameFitter,
    /// Made once for all trials.
    sensors: Vec<TrackedSensor>,
    /// The field for what has no axis, where there is such a thing.
    for_markers: Option<AxisModel>,
}

struct TrackedSensor {
    body_from_sensor: Pose,
    /// `None` for a marker.
    axis_in_body: Option<Unit<Vector3<f64>>>,
}

/// A body as the tracker sees it.
#[derive(Clone, Copy)]
pub struct Tracked {
    pub fit: FrameFit,
    pub outside: usize,
    pub in_metal: usize,
    pub out_of_volume: usize,
}

/// One sensor at one pose.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SensorDetail {
    pub tracker_from_sensor: Pose,
    pub tracker_from_measured: Pose,
    pub error: PoseError,
    /// In the model's box.
    pub is_inside: bool,
    /// In the tracker's measurement volume, where that is known.
    pub is_in_volume: bool,
}

/// What tracking writes to, used again for the next poses, and what it has cost.
#[derive(Default)]
pub struct TrackBuffers {
    batch: Batch,
    /// Sensor by sensor, the poses of each in order.
    positions_mm: Vec<Point3<f64>>,
    axes: Vec<Unit<Vector3<f64>>>,
    evaluations: Vec<Evaluation>,
    of_one_run: Vec<Evaluation>,
    readings: Vec<Reading>,
    pub work: Work,
}

impl<'a> BodyTracker<'a> {
    pub fn new(body: &RigidBody, scenario: &'a Scenario) -> Self {
        Self::of_sensors(
            FrameFitter::new(body, scenario.orientation_weight_mm),
            &body.sensors,
            &scenario.environment,
            scenario.outside,
        )
    }

    /// Reads these sensors; `fitter` fits them.
    pub fn of_sensors(
        fitter: FrameFitter,
        sensors: &[Sensor],
        environment: &'a Environment,
        outside: OutsidePolicy,
    ) -> Self {
        let sensors: Vec<_> = sensors
            .iter()
            .map(|s| TrackedSensor {
                body_from_sensor: s.body_from_sensor(),
                axis_in_body: s.axis_in_body(),
            })
            .collect();
        let model = &environment.model;
        let has_markers = sensors.iter().any(|s| s.axis_in_body.is_none());
        Self {
            environment,
            outside,
            fitter,
            sensors,
            for_markers: has_markers.then(|| model.mean_over_axes()),
        }
    }

    /// What the sensors leave free, in the body's frame.
    pub fn free_motion(&self, determination: &Determination) -> Option<FreeMotion> {
        FreeMotion::in_body(determination, self.fitter.centroid_in_body())
    }

    /// The body at one pose.
    pub fn track(&self, buffers: &mut TrackBuffers, tracker_from_body: &Pose) -> Tracked {
        self.evaluate(buffers, std::slice::from_ref(tracker_from_body), 1);
        self.tracked(buffers, tracker_from_body, 0, 1)
    }

    /// The body at one pose, with what each sensor reads there.
    pub fn track_in_detail(
        &self,
        buffers: &mut TrackBuffers,
        tracker_from_body: &Pose,
    ) -> (Tracked, Vec<SensorDetail>) {
        let tracked = self.track(buffers, tracker_from_body);
        let readings = buffers.readings.iter().zip(&buffers.evaluations);
        let details = self.sensors.iter().zip(readings);
        let details = details.map(|(sensor, (reading, evaluation))| {
            let tracker_from_sensor = tracker_from_body * sensor.body_from_sensor;
            let position_mm = reading.position_mm.coords;
            SensorDetail {
                tracker_from_sensor,
                tracker_from_measured: pose_from_parts(position_mm, reading.rotation),
                error: evaluation.error,
                is_inside: evaluation.is_inside,
                is_in_volume: self.is_in_volume(&tracker_from_sensor.translation.vector.into()),
            }
        });
        (tracked, details.collect())
    }

    /// The body at many poses, appended to `out`. Where poses come in runs of one orientation,
    /// `run` is their length; the last run may be shorter.
    pub fn track_all(
        &self,
        buffers: &mut TrackBuffers,
        tracker_from_body: &[Pose],
        run: usize,
        out: &mut Vec<Tracked>,
    ) {
        let count = tracker_from_body.len();
        self.evaluate(buffers, tracker_from_body, run);
        out.extend(
            tracker_from_body
                .iter()
                .enumerate()
                .map(|(place, pose)| self.tracked(buffers, pose, place, count)),
        );
    }

    /// What each sensor reads at many poses, and whether it is in the model's box there: appended
    /// to `out` sensor by sensor. Runs are those of [`Self::track_all`].
    pub fn read_all(
        &self,
        buffers: &mut TrackBuffers,
        tracker_from_body: &[Pose],
        run: usize,
        out: &mut Vec<(Reading, bool)>,
    ) {
        let count = tracker_from_body.len();
        self.evaluate(buffers, tracker_from_body, run);
        for sensor in 0..self.sensors.len() {
            out.extend(tracker_from_body.iter().enumerate().map(|(place, pose)| {
                let index = sensor * count + place;
                let is_inside = buffers.evaluations[index].is_inside;
                (self.reading(buffers, pose, sensor, index), is_inside)
            }));
        }
    }

    /// Where each sensor is at each pose, and the model's error there: sensor by sensor, the poses
    /// of each in order. `None` of a body with markers, whose errors have no axis.
    pub fn field_points(
        &self,
        buffers: &mut TrackBuffers,
        tracker_from_body: &[Pose],
    ) -> Option<Vec<(FieldPoint, PoseError)>> {
        if self.for_markers.is_some() {
            return None;
        }
        self.evaluate(buffers, tracker_from_body, 1);
        let points = buffers.positions_mm.iter().zip(&buffers.axes);
        let each = points.zip(&buffers.evaluations);
        let each = each.map(|((position_mm, axis), evaluation)| {
            let point = FieldPoint::new(*position_mm, *axis);
            (point, evaluation.error)
        });
        Some(each.collect())
    }

    /// The frames of poses whose sensors err like this, in the order of [`Self::field_points`].
    pub fn fit_with_errors(&self, tracker_from_body: &[Pose], errors: &[PoseError]) -> Vec<Pose> {
        let count = tracker_from_body.len();
        let mut readings = Vec::with_capacity(self.sensors.len());
        let each = tracker_from_body.iter().enumerate().map(|(place, pose)| {
            readings.clear();
            readings.extend(self.sensors.iter().enumerate().map(|(sensor, of)| {
                let error = &errors[sensor * count + place];
                let tracker_from_sensor = pose * of.body_from_sensor;
                Reading {
                    position_mm: (tracker_from_sensor.translation.vector + error.position_mm)
                        .into(),
                    rotation: exp_vector(&error.rotation_rad) * tracker_from_sensor.rotation,
                }
            }));
            self.fitter.fit(&readings, pose).tracker_from_body
        });
        each.collect()
    }

    /// The error of every sensor at every pose.
    fn evaluate(&self, buffers: &mut TrackBuffers, tracker_from_body: &[Pose], run: usize) {
        let model = &self.environment.model;
        buffers.positions_mm.clear();
        buffers.axes.clear();
        for sensor in &self.sensors {
            // A marker's goes unread.
            let axis_in_body = sensor.axis_in_body.unwrap_or_else(Vector3::z_axis);
            for pose in tracker_from_body {
                let position = pose * Point3::from(sensor.body_from_sensor.translation.vector);
                buffers.positions_mm.push(position);
                buffers.axes.push(pose.rotation * axis_in_body);
            }
        }
        buffers.work.study_evaluations += buffers.positions_mm.len() as u64;
        let (positions_mm, axes) = (&buffers.positions_mm, &buffers.axes);
        let is_scattered = run < MIN_RUN || model.order() == 0;
        if is_scattered && self.for_markers.is_none() {
            let out = &mut buffers.evaluations;
            let batch = &mut buffers.batch;
            batch.evaluate(model, positions_mm, axes, self.outside, out);
            return;
        }
        buffers.evaluations.clear();
        let (batch, out) = (&mut buffers.batch, &mut buffers.of_one_run);
        let count = tracker_from_body.len().max(1);
        let each = positions_mm.chunks(count).zip(axes.chunks(count));
        for (sensor, (positions_mm, axes)) in self.sensors.iter().zip(each) {
            match (&self.for_markers, sensor.axis_in_body) {
                (Some(mean), None) => {
                    mean.evaluate_all(batch, positions_mm, self.outside, out);
                    // What has no axis reads none.
                    for evaluation in out.iter_mut() {
                        evaluation.error.rotation_rad = Vector3::zeros();
                    }
                    buffers.evaluations.extend_from_slice(out);
                }
                _ if is_scattered => {
                    batch.evaluate(model, positions_mm, axes, self.outside, out);
                    buffers.evaluations.extend_from_slice(out);
                }
                _ => {
                    for (positions_mm, axes) in positions_mm.chunks(run).zip(axes.chunks(run)) {
                        let at_axis = model.at_axis(&axes[0]);
                        at_axis.evaluate_all(batch, positions_mm, self.outside, out);
                        buffers.evaluations.extend_from_slice(out);
                        buffers.work.coefficient_blends += 1;
                        buffers.work.blended_evaluations += positions_mm.len() as u64;
                    }
                }
            }
        }
    }

    /// The frame of the pose at a place among `count` that were evaluated.
    fn tracked(
        &self,
        buffers: &mut TrackBuffers,
        tracker_from_body: &Pose,
        place: usize,
        count: usize,
    ) -> Tracked {
        let (mut outside, mut in_metal, mut out_of_volume) = (0, 0, 0);
        let bounds = self.environment.model.bounds();
        buffers.readings.clear();
        for sensor in 0..self.sensors.len() {
            let index = sensor * count + place;
            let is_outside = !buffers.evaluations[index].is_inside;
            outside += usize::from(is_outside);
            // A model has no reading in its box only where there is metal.
            in_metal += usize::from(is_outside && bounds.contains(&buffers.positions_mm[index]));
            out_of_volume += usize::from(!self.is_in_volume(&buffers.positions_mm[index]));
            let reading = self.reading(buffers, tracker_from_body, sensor, index);
            buffers.readings.push(reading);
        }
        buffers.work.frame_fits += 1;
        Tracked {
            fit: self.fitter.fit(&buffers.readings, tracker_from_body),
            outside,
            in_metal,
            out_of_volume,
        }
    }

    /// What a sensor reads that was evaluated.
    fn reading(
        &self,
        buffers: &TrackBuffers,
        tracker_from_body: &Pose,
        sensor: usize,
        index: usize,
    ) -> Reading {
        let (at, error) = (&buffers.positions_mm[index], &buffers.evaluations[index].error);
        let body_from_sensor = &self.sensors[sensor].body_from_sensor;
        Reading {
            position_mm: at + error.position_mm,
            rotation: exp_vector(&error.rotation_rad)
                * (tracker_from_body.rotation * body_from_sensor.rotation),
        }
    }

    fn is_in_volume(&self, position_mm: &Point3<f64>) -> bool {
        self.environment.volume.is_none_or(|volume| volume.contains(position_mm))
    }
}
