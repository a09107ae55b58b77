//! The computations under test, as a set that can be exchanged: the program's own, or naive ones
//! that have to be found out.

use nalgebra::{Matrix3, Point3, Unit, UnitQuaternion, Vector3};
use trackwright_field::batch::{Batch, Instructions};
use trackwright_field::evaluation::Matrix6x3;
use trackwright_field::fit::{Fit, FitError, FitSettings, fit};
use trackwright_field::inverse::{InverseState, undistort};
use trackwright_field::least_squares::{LeastSquares, NoConvergence, Solution};
use trackwright_field::samples::{PoseError, SampleSet};
use trackwright_field::{DistortionModel, OutsidePolicy};
use trackwright_geometry::bounds::Bounds;
use trackwright_geometry::directions::{DirectionSet, DirectionWeights, Weighting};
use trackwright_geometry::pose::Pose;
use trackwright_geometry::rotation::{
    AxisRotation, axis_rotation, exp_vector, log_matrix, log_quaternion, rotation_angle_rad,
};
use trackwright_geometry::svd3::{Svd3, svd3};
use trackwright_simulation::RigidBody;
use trackwright_simulation::Statistics;
use trackwright_simulation::frame_fit::{FrameFit, FrameFitter, Reading};
use trackwright_simulation::linear_fit::{
    RotationNotDetermined, SensorCovariance, point_covariance_mm2,
};
use trackwright_simulation::tool_in_crf::{RelativeError, relative_error};
use trackwright_task::Task;

/// What the battery tests. Every method is the program's own unless replaced.
pub trait Methods: Sync {
    fn evaluate(
        &self,
        model: &DistortionModel,
        position_mm: &Point3<f64>,
        axis: &Unit<Vector3<f64>>,
        outside: OutsidePolicy,
    ) -> PoseError {
        model.evaluate(position_mm, axis, outside).error
    }

    /// The same at many poses at once, by each set of instructions.
    fn evaluate_together(
        &self,
        model: &DistortionModel,
        positions_mm: &[Point3<f64>],
        axes: &[Unit<Vector3<f64>>],
        outside: OutsidePolicy,
    ) -> Vec<Vec<PoseError>> {
        let levels = [Instructions::Best, Instructions::Avx2, Instructions::Portable];
        levels
            .into_iter()
            .map(|level| {
                let mut out = Vec::new();
                let mut batch = Batch::with_instructions(level);
                batch.evaluate(model, positions_mm, axes, outside, &mut out);
                out.iter().map(|e| e.error).collect()
            })
            .collect()
    }

    /// The same for one axis: at one position, in a batch, and on a lattice of one point.
    fn evaluate_along(
        &self,
        model: &DistortionModel,
        position_mm: &Point3<f64>,
        axis: &Unit<Vector3<f64>>,
        outside: OutsidePolicy,
    ) -> Vec<PoseError> {
        let along = model.at_axis(axis);
        let mut together = Vec::new();
        along.evaluate_all(&mut Batch::default(), &[*position_mm], outside, &mut together);
        let mut lattice = Vec::new();
        let [x, y, z] = position_mm.coords.into();
        along.evaluate_lattice([&[x], &[y], &[z]], outside, &mut lattice);
        let single = along.evaluate(position_mm, outside);
        [vec![single], together, lattice].concat().iter().map(|e| e.error).collect()
    }

    /// Derivatives by position, a mm, and by steps of the axis in its tangent plane, a rad.
    fn derivatives(
        &self,
        model: &DistortionModel,
        position_mm: &Point3<f64>,
        axis: &Unit<Vector3<f64>>,
        outside: OutsidePolicy,
    ) -> [Matrix6x3; 2] {
        let there = model.evaluate_with_jacobian(position_mm, axis, outside);
        [there.by_position, there.by_axis]
    }

    /// The poses behind readings, and what became of each.
    fn undistort(
        &self,
        model: &DistortionModel,
        measured: &[Pose],
        outside: OutsidePolicy,
    ) -> Vec<(Option<Pose>, InverseState)> {
        // Nobody cancels a task of its own.
        let all = undistort(model, measured, outside, &Task::default()).unwrap_or_default();
        all.into_iter().map(|u| (u.pose, u.state)).collect()
    }

    fn weights(
        &self,
        set: DirectionSet,
        axis: &Unit<Vector3<f64>>,
        weighting: Weighting,
    ) -> DirectionWeights {
        set.weights(axis, weighting)
    }

    /// Least squares of least norm: rows of the design matrix, and six values a row.
    fn solve(
        &self,
        rows: &[Vec<f64>],
        values: &[[f64; 6]],
        rcond: f64,
        ridge: f64,
    ) -> Result<Solution, NoConvergence> {
        let mut system = LeastSquares::new(rows.first().map_or(0, Vec::len));
        for (row, values) in rows.iter().zip(values) {
            system.push(|out| out.extend(row), *values);
        }
        system.solve(rcond, ridge)
    }

    fn fit(
        &self,
        set: &SampleSet,
        settings: &FitSettings,
        bounds: Option<Bounds>,
    ) -> Result<Fit, FitError> {
        fit(set, settings, bounds)
    }

    fn exp(&self, vector: &Vector3<f64>) -> UnitQuaternion<f64> {
        exp_vector(vector)
    }

    fn log_quaternion(&self, rotation: &UnitQuaternion<f64>) -> Vector3<f64> {
        log_quaternion(rotation)
    }

    fn log_matrix(&self, rotation: &Matrix3<f64>) -> Vector3<f64> {
        log_matrix(rotation)
    }

    fn angle(&self, rotation: &UnitQuaternion<f64>) -> f64 {
        rotation_angle_rad(rotation)
    }

    fn axis_rotation(&self, from: &Unit<Vector3<f64>>, to: &Unit<Vector3<f64>>) -> AxisRotation {
        axis_rotation(from, to)
    }

    fn svd3(&self, matrix: &Matrix3<f64>) -> Svd3 {
        svd3(matrix)
    }

    fn frame(
        &self,
        body: &RigidBody,
        orientation_weight_mm: f64,
        readings: &[Reading],
        tracker_from_body_true: &Pose,
    ) -> FrameFit {
        FrameFitter::new(body, orientation_weight_mm).fit(readings, tracker_from_body_true)
    }

    fn relative_error(
        &self,
        crf_from_tool: &Pose,
        crf_from_tool_simulated: &Pose,
        tip_in_tool: &Point3<f64>,
    ) -> RelativeError {
        relative_error(crf_from_tool, crf_from_tool_simulated, tip_in_tool)
    }

    fn covariance(
        &self,
        body: &RigidBody,
        orientation_weight_mm: f64,
        sensors: &[SensorCovariance],
        point_in_body: &Point3<f64>,
    ) -> Result<Matrix3<f64>, RotationNotDetermined> {
        point_covariance_mm2(body, orientation_weight_mm, sensors, point_in_body)
    }

    fn statistics(&self, values: &mut [f64]) -> Option<Statistics> {
        Statistics::of(values)
    }
}

/// The program's own methods.
#[derive(Clone, Copy, Debug, Default)]
pub struct Own;

impl Methods for Own {}
