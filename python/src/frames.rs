//! A body's frame from the readings of its sensors, and how far their errors move a point of it.

use crate::arrays::{floats, points, pose, pose_array, poses, vector, vector_array};
use crate::design::Sensor;
use crate::errors::{Done, TrackwrightError};
use nalgebra::{Matrix3, Point3, UnitQuaternion};
use numpy::{PyArray1, PyArray2, PyUntypedArrayMethods};
use pyo3::prelude::*;
use trackwright_field::environment::DEFAULT_ORIENTATION_WEIGHT_MM;
use trackwright_geometry::pose::Pose;
use trackwright_simulation::frame_fit::{self, FrameFitter, Reading};
use trackwright_simulation::linear_fit::{SensorCovariance, point_covariance_mm2};
use trackwright_simulation::{Determination, RigidBody};

/// How far a covariance may be from symmetric: round-off of whatever it was computed by.
const SYMMETRIC: f64 = 1e-9;

/// A frame that was fitted.
#[pyclass(frozen, get_all, module = "trackwright")]
pub struct FrameFit {
    tracker_from_body: Py<PyArray1<f64>>,
    singular_values_mm2: Py<PyArray1<f64>>,
    determination: &'static str,
    free_axis: Option<Py<PyArray1<f64>>>,
}

/// Fits a body's frame to the readings of its sensors, as the tracker does.
///
/// sensors: those of the body, as `Design.sensors` has them. positions: shape (n, 3), mm, tracker's frame, one
/// a sensor in their order. quaternions: shape (n, 4), `tracker_from_sensor`, scalar first; None for markers,
/// and where the weight is zero. orientation_weight_mm: of an axis against a position. near: a pose, shape
/// (7,), that decides what the sensors leave free; the identity where it is None.
///
/// The result has tracker_from_body, shape (7,); singular_values_mm2 of the cross-covariance, descending;
/// determination, "full", "poor", "free-axis" or "free-rotation"; and free_axis, shape (3,), body's frame, or
/// None.
#[pyfunction]
#[pyo3(signature = (
    sensors, positions, quaternions = None, *,
    orientation_weight_mm = DEFAULT_ORIENTATION_WEIGHT_MM, near = None
))]
pub fn fit_frame(
    py: Python<'_>,
    sensors: Vec<Bound<'_, Sensor>>,
    positions: &Bound<'_, PyAny>,
    quaternions: Option<&Bound<'_, PyAny>>,
    orientation_weight_mm: f64,
    near: Option<&Bound<'_, PyAny>>,
) -> Done<FrameFit> {
    check_weight(orientation_weight_mm)?;
    let body = body_of(&sensors);
    let readings: Vec<Reading> = match quaternions {
        Some(quaternions) => {
            let each = poses(positions, quaternions)?.into_iter();
            each.map(|pose| Reading {
                position_mm: pose.translation.vector.into(),
                rotation: pose.rotation,
            })
            .collect()
        }
        None => {
            let has_axes = body.sensors.iter().any(|sensor| sensor.axis_in_body().is_some());
            if has_axes && orientation_weight_mm > 0.0 {
                let text =
                    "quaternions: found none, expected one for each sensor that is no marker";
                return Err(TrackwrightError::new_err(text).into());
            }
            let each = points(positions, "positions")?.into_iter();
            let rotation = UnitQuaternion::identity();
            each.map(|position_mm| Reading { position_mm, rotation }).collect()
        }
    };
    if readings.len() != body.sensors.len() {
        let text = format!(
            "positions: found {} rows, expected {}, one for each of sensors",
            readings.len(),
            body.sensors.len()
        );
        return Err(TrackwrightError::new_err(text).into());
    }
    let near = near.map(|near| pose(near, "near")).transpose()?.unwrap_or_else(Pose::identity);
    let frame_fit::FrameFit { tracker_from_body, singular_values_mm2, determination } =
        FrameFitter::new(&body, orientation_weight_mm).fit(&readings, &near);
    let (determination, free_axis) = match determination {
        Determination::Full => ("full", None),
        Determination::Poor { .. } => ("poor", None),
        Determination::FreeAxis { axis_in_body } => ("free-axis", Some(axis_in_body)),
        Determination::FreeRotation => ("free-rotation", None),
    };
    let free_axis = free_axis.map(|axis| vector_array(py, axis.into_inner().into()).unbind());
    Ok(FrameFit {
        tracker_from_body: pose_array(py, &tracker_from_body).unbind(),
        singular_values_mm2: vector_array(py, singular_values_mm2.into()).unbind(),
        determination,
        free_axis,
    })
}

/// How far the errors of a body's sensors scatter a point of it: its covariance to first order, shape (3, 3),
/// mm², body's frame.
///
/// point: shape (3,), mm, body's frame. position_covariance in mm² and rotation_covariance in degrees² of the
/// sensors' independent errors, in the body's axes: shape (3, 3) of each, or (n, 3, 3), one a sensor.
/// orientation_weight_mm as for `fit_frame`.
#[pyfunction]
#[pyo3(signature = (
    sensors, point, position_covariance, rotation_covariance, *,
    orientation_weight_mm = DEFAULT_ORIENTATION_WEIGHT_MM
))]
pub fn point_covariance<'py>(
    py: Python<'py>,
    sensors: Vec<Bound<'py, Sensor>>,
    point: &Bound<'py, PyAny>,
    position_covariance: &Bound<'py, PyAny>,
    rotation_covariance: &Bound<'py, PyAny>,
    orientation_weight_mm: f64,
) -> Done<Bound<'py, PyArray2<f64>>> {
    check_weight(orientation_weight_mm)?;
    let body = body_of(&sensors);
    let point = Point3::from(vector::<3>(point, "point")?);
    let count = body.sensors.len();
    let positions = covariances(position_covariance, "position_covariance", count)?;
    let rotations = covariances(rotation_covariance, "rotation_covariance", count)?;
    let rad2 = 1.0_f64.to_radians().powi(2);
    let each = positions.into_iter().zip(rotations);
    let each: Vec<SensorCovariance> = each
        .map(|(position_mm2, deg2)| SensorCovariance { position_mm2, rotation_rad2: deg2 * rad2 })
        .collect();
    let found = point_covariance_mm2(&body, orientation_weight_mm, &each, &point)?;
    // It is symmetric: rows are columns.
    crate::arrays::matrix(py, <[[f64; 3]; 3]>::from(found).to_vec())
}

fn body_of(sensors: &[Bound<'_, Sensor>]) -> RigidBody {
    let sensors = sensors.iter().map(|sensor| sensor.get().simulated().clone()).collect();
    RigidBody { name: String::new(), tip_in_body: None, sensors }
}

fn check_weight(orientation_weight_mm: f64) -> PyResult<()> {
    match orientation_weight_mm.is_finite() && orientation_weight_mm >= 0.0 {
        true => Ok(()),
        false => {
            let text = format!(
                "orientation_weight_mm: found {orientation_weight_mm}, expected zero or more"
            );
            Err(TrackwrightError::new_err(text))
        }
    }
}

/// One covariance a sensor, from that of all or from one of each.
fn covariances(given: &Bound<'_, PyAny>, what: &str, count: usize) -> Done<Vec<Matrix3<f64>>> {
    let array = floats(given, what)?;
    let refused = |text: String| Err(TrackwrightError::new_err(format!("{what}: {text}")).into());
    let view = array.as_array();
    let matrices: Vec<Matrix3<f64>> = match array.shape() {
        [3, 3] => vec![Matrix3::from_fn(|row, column| view[[row, column]]); count],
        [rows, 3, 3] if *rows == count => {
            let of = |k: usize| Matrix3::from_fn(|row, column| view[[k, row, column]]);
            (0..count).map(of).collect()
        }
        shape => {
            return refused(format!(
                "found the shape {shape:?}, expected (3, 3) or ({count}, 3, 3)"
            ));
        }
    };
    let is_fine = |matrix: &Matrix3<f64>| {
        let scale = matrix.amax();
        scale.is_finite() && (matrix - matrix.transpose()).amax() <= SYMMETRIC * scale
    };
    match matrices.iter().position(|matrix| !is_fine(matrix)) {
        None => Ok(matrices),
        Some(index) => refused(format!("matrix {index} is not finite and symmetric")),
    }
}
