//! Where a tool's tip is, which way its shaft points, and where points and trackers are.

use crate::arrays::{Column, Matrix, matrix, pose_array, vector, vector_array};
use crate::errors::{Done, TrackwrightError};
use crate::found::{Found, refuse};
use crate::long_work;
use crate::pose_tables::{WhichTool, points, pose_rows, tool_poses};
use crate::tables::{Notes, of_memory, take, warn_of};
use nalgebra::Point3;
use numpy::{IntoPyArray, PyArray1, PyArray2};
use pyo3::prelude::*;
use trackwright_calibration::doubts::of_point_pairs;
use trackwright_calibration::hand_eye::{
    HandEyeSettings, PairedReading, ReadingNoise, hand_eye as solve,
};
use trackwright_calibration::judged_registration::{JudgedRegistration, MAX_TURN_ERROR_DEG};
use trackwright_calibration::pivot::{self, PivotLimits};
use trackwright_calibration::spin::{self, ShaftDirection, SpinLimits};
use trackwright_geometry::pose::pose_to_array;

/// A tip, and the point that it rested in.
#[pyclass(frozen, get_all, extends = Found, module = "trackwright")]
pub struct Pivot {
    tip: Py<PyArray1<f64>>,
    pivot: Py<PyArray1<f64>>,
    rms_mm: f64,
}

/// A shaft's direction.
#[pyclass(frozen, get_all, extends = Found, module = "trackwright")]
pub struct Spin {
    shaft: Py<PyArray1<f64>>,
    towards_tip: bool,
}

/// Two frames' points laid over each other.
#[pyclass(frozen, extends = Found, module = "trackwright")]
pub struct Registration {
    found: JudgedRegistration,
}

/// Two trackers, and sensors on a body.
#[pyclass(frozen, get_all, extends = Found, module = "trackwright")]
pub struct HandEye {
    tracker_from_reference: Py<PyArray1<f64>>,
    body_from_sensor: Py<PyArray2<f64>>,
    covariance: Py<PyArray2<f64>>,
    errors_mm: Py<PyArray1<f64>>,
    errors_deg: Py<PyArray1<f64>>,
}

/// Where a tool's tip is, from poses around one point.
///
/// poses: `tracker_from_tool`, shape (n, 7): x, y, z in mm and qw, qx, qy, qz; a table with these columns; a
/// recording, or a list of recordings, of which tool and relative_to choose one by a part of its name.
/// The limits are those below which the poses do not determine a tip.
#[pyfunction]
#[pyo3(name = "pivot", signature = (
    poses, *, tool = None, relative_to = None, min_poses = PivotLimits::MIN_POSES,
    min_range_deg = PivotLimits::MIN_RANGE_DEG, min_turn_deg = PivotLimits::MIN_TURN_DEG,
    max_rms_mm = PivotLimits::MAX_RMS_MM, as_is = false
))]
#[expect(clippy::too_many_arguments, reason = "keywords in Python")]
pub fn pivot_calibration(
    py: Python<'_>,
    poses: &Bound<'_, PyAny>,
    tool: Option<&str>,
    relative_to: Option<&str>,
    min_poses: usize,
    min_range_deg: f64,
    min_turn_deg: f64,
    max_rms_mm: f64,
    as_is: bool,
) -> Done<Py<Pivot>> {
    let mut notes = Notes::new();
    let poses = tool_poses(poses, WhichTool { tool, relative_to }, as_is, &mut notes)?;
    let limits = PivotLimits {
        min_poses,
        min_range_rad: min_range_deg.to_radians(),
        min_turn_rad: min_turn_deg.to_radians(),
        max_rms_mm,
    };
    let found = long_work::run(py, |_| {
        pivot::pivot(&poses, &limits).or_else(|error| refuse("no tip", &error))
    })?;
    let tip = Pivot {
        tip: vector_array(py, found.tip_in_tool.coords.into()).unbind(),
        pivot: vector_array(py, found.pivot_in_tracker.coords.into()).unbind(),
        rms_mm: found.rms_mm,
    };
    Ok(Py::new(py, (tip, Found::new(py, found.section(), notes)?))?)
}

/// Which way a tool's shaft points, from poses in which it was turned about it.
///
/// poses: as for `pivot`. tip: shape (3,), mm, tool's frame, determines which of the two directions along
/// the shaft leads to it; tip_std_error_mm is its standard error.
#[pyfunction]
#[pyo3(name = "spin", signature = (
    poses, *, tip = None, tip_std_error_mm = 0.0, tool = None, relative_to = None,
    min_poses = SpinLimits::MIN_POSES, min_range_deg = SpinLimits::MIN_RANGE_DEG,
    min_turn_deg = SpinLimits::MIN_TURN_DEG, max_shaft_deg = SpinLimits::MAX_RMS_DEG, as_is = false
))]
#[expect(clippy::too_many_arguments, reason = "keywords in Python")]
pub fn spin_calibration(
    py: Python<'_>,
    poses: &Bound<'_, PyAny>,
    tip: Option<&Bound<'_, PyAny>>,
    tip_std_error_mm: f64,
    tool: Option<&str>,
    relative_to: Option<&str>,
    min_poses: usize,
    min_range_deg: f64,
    min_turn_deg: f64,
    max_shaft_deg: f64,
    as_is: bool,
) -> Done<Py<Spin>> {
    let mut notes = Notes::new();
    let tip = tip.map(|tip| vector::<3>(tip, "tip")).transpose()?.map(Point3::from);
    let poses = tool_poses(poses, WhichTool { tool, relative_to }, as_is, &mut notes)?;
    let limits = SpinLimits {
        min_poses,
        min_range_rad: min_range_deg.to_radians(),
        min_turn_rad: min_turn_deg.to_radians(),
        max_rms_rad: max_shaft_deg.to_radians(),
    };
    let found = long_work::run(py, |_| {
        spin::spin(&poses, &limits).or_else(|error| refuse("no shaft", &error))
    })?;
    let found = match tip {
        Some(tip) => found.towards(&tip, tip_std_error_mm),
        None => found,
    };
    let shaft = Spin {
        shaft: vector_array(py, found.shaft_in_tool.into_inner().into()).unbind(),
        towards_tip: found.direction == ShaftDirection::TowardsTip,
    };
    Ok(Py::new(py, (shaft, Found::new(py, found.section(), notes)?))?)
}

/// Registers points in two frames.
///
/// source, target: shape (n, 3), mm, the same points in the same order; tables with x, y, z; or files of
/// points. fle_mm: how well a point was localised, RMS; estimated where it is None.
#[pyfunction]
#[pyo3(signature = (
    source, target, *, leave_out_outliers = false, fle_mm = None,
    max_turn_error_deg = MAX_TURN_ERROR_DEG, as_is = false
))]
pub fn register(
    py: Python<'_>,
    source: &Bound<'_, PyAny>,
    target: &Bound<'_, PyAny>,
    leave_out_outliers: bool,
    fle_mm: Option<f64>,
    max_turn_error_deg: f64,
    as_is: bool,
) -> Done<Py<Registration>> {
    if let Some(found) = fle_mm.filter(|fle_mm| !(fle_mm.is_finite() && *fle_mm > 0.0)) {
        let text = format!("fle_mm: found {found}, expected a number above zero");
        return Err(TrackwrightError::new_err(text).into());
    }
    let mut notes = Notes::new();
    let source = points(source, "source", as_is, &mut notes)?;
    let target = points(target, "target", as_is, &mut notes)?;
    let found = JudgedRegistration::of(&source, &target, leave_out_outliers, fle_mm)?;
    let suspicions = of_point_pairs(&source, &target);
    take(of_memory((), "target", suspicions), as_is, &mut notes)?;
    found.check_turn(max_turn_error_deg)?;
    let base = Found::new(py, found.section(), notes)?;
    Ok(Py::new(py, (Registration { found }, base))?)
}

#[pymethods]
impl Registration {
    /// The registration, shape (7,): x, y, z in mm and qw, qx, qy, qz.
    #[getter]
    fn target_from_source<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        pose_array(py, &self.found.registration.target_from_source)
    }

    /// What is left at each point, shape (n,), mm.
    #[getter]
    fn residuals_mm<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.found.residuals_mm.clone().into_pyarray(py)
    }

    /// Points of the source frame in the target frame, shape (n, 3), mm, and how far off each is to be
    /// expected (TRE, RMS), shape (n,), mm.
    #[pyo3(signature = (points, *, as_is = false))]
    fn move_points<'py>(
        &self,
        py: Python<'py>,
        points: &Bound<'_, PyAny>,
        as_is: bool,
    ) -> Done<(Matrix<'py>, Column<'py>)> {
        let mut notes = Notes::new();
        let points = self::points(points, "points", as_is, &mut notes)?;
        warn_of(py, notes)?;
        let target_from_source = &self.found.registration.target_from_source;
        let moved = points.iter().map(|point| (target_from_source * point).coords.into());
        let tre = points.iter().map(|point| self.found.spread.tre_rms_mm(self.found.fle_mm, point));
        let tre: Vec<f64> = tre.collect();
        Ok((matrix(py, moved.collect())?, tre.into_pyarray(py)))
    }
}

/// Where a reference tracker and the sensors on a body are: solves A = Y B X.
///
/// tracker_from_sensor, reference_from_body: shape (n, 7), mm, readings at the same moments. sensor: the
/// number of the sensor that each row is of, from 0. pose: rows with the same number share their
/// reference reading.
#[pyfunction]
#[pyo3(signature = (
    tracker_from_sensor, reference_from_body, *, sensor = None, pose = None,
    min_poses = HandEyeSettings::MIN_POSES, min_turn_deg = HandEyeSettings::MIN_TURN_DEG
))]
pub fn hand_eye(
    py: Python<'_>,
    tracker_from_sensor: &Bound<'_, PyAny>,
    reference_from_body: &Bound<'_, PyAny>,
    sensor: Option<Vec<usize>>,
    pose: Option<Vec<usize>>,
    min_poses: usize,
    min_turn_deg: f64,
) -> Done<Py<HandEye>> {
    let read = pose_rows(tracker_from_sensor, "tracker_from_sensor")?;
    let reference = pose_rows(reference_from_body, "reference_from_body")?;
    let of_rows = |what: &str, found: usize| match found == read.len() {
        true => Ok(()),
        false => {
            let text = format!(
                "{what}: found {found} rows, expected {}, one for each of tracker_from_sensor",
                read.len()
            );
            Err(TrackwrightError::new_err(text))
        }
    };
    let sensor = sensor.unwrap_or_else(|| vec![0; read.len()]);
    let pose = pose.unwrap_or_else(|| (0..read.len()).collect());
    of_rows("reference_from_body", reference.len())?;
    of_rows("sensor", sensor.len())?;
    of_rows("pose", pose.len())?;
    let sensors = sensor.iter().max().map_or(0, |last| last + 1);
    let each = read.into_iter().zip(reference).zip(sensor.into_iter().zip(pose));
    let readings: Vec<PairedReading> = each
        .map(|((tracker_from_sensor, reference_from_body), (sensor, pose))| PairedReading {
            pose,
            sensor,
            reference_from_body,
            tracker_from_sensor,
            noise: ReadingNoise::default(),
        })
        .collect();
    let settings = HandEyeSettings {
        min_poses,
        min_turn_rad: min_turn_deg.to_radians(),
        ..HandEyeSettings::default()
    };
    let found = long_work::run(py, |_| {
        solve(&readings, sensors, &settings).or_else(|error| refuse("no places", &error))
    })?;
    let (errors_mm, errors_deg): (Vec<f64>, Vec<f64>) = readings
        .iter()
        .map(|reading| found.error(reading))
        .map(|(position_mm, angle_rad)| (position_mm, angle_rad.to_degrees()))
        .unzip();
    let size = found.covariance.nrows();
    let covariance = found.covariance.as_slice().to_vec().into_pyarray(py);
    let sensors = found.body_from_sensor.iter().map(pose_to_array).collect();
    let places = HandEye {
        tracker_from_reference: pose_array(py, &found.tracker_from_reference).unbind(),
        body_from_sensor: matrix(py, sensors)?.unbind(),
        // It is symmetric: rows are columns.
        covariance: numpy::PyArrayMethods::reshape(&covariance, [size, size])?.unbind(),
        errors_mm: errors_mm.into_pyarray(py).unbind(),
        errors_deg: errors_deg.into_pyarray(py).unbind(),
    };
    Ok(Py::new(py, (places, Found::new(py, found.section(), Notes::new())?))?)
}
