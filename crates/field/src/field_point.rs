//! Where a sensor is.

use nalgebra::{Point3, Unit, Vector3};
use trackwright_geometry::pose::Pose;

/// Where a sensor is: all that its error depends on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FieldPoint {
    /// Tracker frame, mm.
    pub position_mm: Point3<f64>,
    /// Local z, tracker frame.
    pub axis: Unit<Vector3<f64>>,
    /// Local x of a 6-DOF sensor, tracker frame: it has two coils, whose errors differ. `None` where the
    /// roll is not known or does not matter.
    pub x_axis: Option<Unit<Vector3<f64>>>,
}

impl FieldPoint {
    /// Where a 5-DOF sensor is.
    pub fn new(position_mm: Point3<f64>, axis: Unit<Vector3<f64>>) -> Self {
        Self { position_mm, axis, x_axis: None }
    }

    /// Where a 6-DOF sensor is.
    pub fn of_pose(tracker_from_sensor: &Pose) -> Self {
        Self {
            position_mm: tracker_from_sensor.translation.vector.into(),
            axis: tracker_from_sensor.rotation * Vector3::z_axis(),
            x_axis: Some(tracker_from_sensor.rotation * Vector3::x_axis()),
        }
    }

    /// Cosines of the angles between the axes, and the second axes, of a measured sensor and another; 1 for the
    /// second where the measured one has none, 0 where only the other has none.
    pub(super) fn cosines(&self, other: &Self) -> [f64; 2] {
        let second = self.x_axis.map(|x| other.x_axis.map_or(0.0, |other| x.dot(&other)));
        [self.axis.dot(&other.axis), second.unwrap_or(1.0)]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compensation::{Method, compensate};
    use crate::computed::FieldSource;
    use crate::gaussian::{GaussianField, Kernel, KernelScale, Kriging, ReadingError, Readings};
    use crate::random_models::{Seeded, room};
    use crate::samples::{MapKind, PoseError, Sample, SampleSet};
    use crate::{DistortionModel, OutsidePolicy};
    use nalgebra::UnitQuaternion;
    use std::f64::consts::PI;
    use std::sync::Arc;
    use trackwright_task::Task;

    /// Poses, and readings there of 6-DOF sensors in a field that depends on both axes.
    fn drawn(count: usize) -> (Vec<Pose>, SampleSet) {
        let mut seeded = Seeded::new(7);
        let poses: Vec<Pose> = (0..count).map(|_| seeded.pose(&room(), 0.0)).collect();
        let points: Vec<FieldPoint> = poses.iter().map(FieldPoint::of_pose).collect();
        let scale = |length_mm, variance| KernelScale {
            length_mm,
            axis_sine: 0.9,
            x_axis_sine: 0.6,
            variance,
        };
        let kernel = Kernel { scales: [scale(250.0, 1.0), scale(80.0, 0.02)], nugget: 1e-4 };
        let factor = kernel.lower_triangle(&points).llt(faer::Side::Lower).unwrap().L().to_owned();
        let values = &factor * faer::Mat::from_fn(count, 6, |_, _| seeded.normal());
        let sample = |(i, point): (usize, &FieldPoint)| {
            let three = |from: usize| Vector3::from_fn(|c, _| values[(i, from + c)]);
            let error = PoseError { position_mm: three(0) * 2.0, rotation_rad: three(3) * 0.01 };
            Sample { x_axis: point.x_axis, ..Sample::new(point.position_mm, point.axis, error) }
        };
        let samples = points.iter().enumerate().map(sample).collect();
        (poses, SampleSet { samples, has_rotations: true, ambiguous: 0 })
    }

    fn fitted(set: &SampleSet) -> GaussianField {
        GaussianField::fit(set, None, &Task::default()).unwrap()
    }

    fn correction(process: GaussianField) -> DistortionModel {
        let kriging = Kriging::new(Arc::new(process), &Task::default()).unwrap();
        let source = FieldSource::Kriging(Arc::new(kriging));
        DistortionModel::of_source(source, MapKind::Correction, room())
    }

    #[test]
    fn a_process_of_both_axes_leaves_less_and_states_it() {
        let (_, set) = drawn(400);
        let mut without = set.clone();
        without.samples.iter_mut().for_each(|sample| sample.x_axis = None);
        let [with, without] = [&set, &without].map(|set| fitted(set).left_out_rms_mm);
        assert!(with < 0.75 * without, "{with} {without}");
        let (known, held_out) = set.samples.split_at(300);
        let process = fitted(&SampleSet { samples: known.to_vec(), ..set.clone() });
        let points: Vec<_> = held_out.iter().map(Sample::point).collect();
        let model = correction(process.clone());
        let given = points.iter().map(|at| model.evaluate_point(at, OutsidePolicy::Clamp).error);
        let given: Vec<_> = given.collect();
        let stated = Readings::new(&process).errors(&points, &given).unwrap();
        let left = held_out
            .iter()
            .zip(&given)
            .map(|(sample, given)| (sample.error.position_mm - given.position_mm).norm());
        let is_within =
            |(left, stated): &(f64, &ReadingError)| *left < stated.position_mm.within_95;
        let within = left.zip(&stated).filter(is_within).count();
        // 95 of 100; the binomial standard deviation is 2.2.
        assert!(within >= 88, "{within}");
    }

    #[test]
    fn readings_are_corrected_by_their_roll() {
        let (poses, set) = drawn(120);
        let model = correction(fitted(&set));
        let clamp = OutsidePolicy::Clamp;
        let all = compensate(&model, &poses, clamp, Method::Correction, &Task::default()).unwrap();
        let turned = |pose: &Pose, angle: f64| {
            let roll = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), angle);
            pose * nalgebra::Isometry3::from_parts(nalgebra::Translation3::identity(), roll)
        };
        let error = |pose: &Pose| model.evaluate_point(&FieldPoint::of_pose(pose), clamp).error;
        let mut differences = 0.0;
        for (pose, found) in poses.iter().zip(&all) {
            let (alone, _) = model.correct(pose, clamp);
            let found = found.pose.unwrap();
            assert!((alone.translation.vector - found.translation.vector).norm() < 1e-12);
            // A coil turned round reads the same.
            let half = error(&turned(pose, PI)).largest_difference(&error(pose));
            assert!(half < 1e-9, "{half}");
            differences += error(&turned(pose, PI / 2.0)).largest_difference(&error(pose));
        }
        assert!(differences / poses.len() as f64 > 0.5, "{differences}");
    }

    #[test]
    fn without_a_roll_the_error_is_the_mean_over_all() {
        let (poses, set) = drawn(60);
        let model = correction(fitted(&set));
        for pose in &poses {
            let point = FieldPoint::of_pose(pose);
            let rolls = 64;
            let mut mean = [0.0; 6];
            for k in 0..rolls {
                let angle = 2.0 * PI * f64::from(k) / f64::from(rolls);
                let roll = UnitQuaternion::from_axis_angle(&point.axis, angle);
                let turned = FieldPoint { x_axis: point.x_axis.map(|x| roll * x), ..point };
                let error = model.evaluate_point(&turned, OutsidePolicy::Clamp).error;
                for (mean, e) in mean.iter_mut().zip(error.values()) {
                    *mean += e / f64::from(rolls);
                }
            }
            let found = model.evaluate(&point.position_mm, &point.axis, OutsidePolicy::Clamp).error;
            assert!(found.largest_difference(&PoseError::of_values(mean)) < 1e-9);
        }
    }
}
