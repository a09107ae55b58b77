//! Poses and points that come in: arrays, tables, or recordings of any kind.

use crate::arrays::{points as point_rows, rotation, rows};
use crate::errors::{Done, TrackwrightError};
use crate::tables::{Notes, Table, of_memory, take};
use anyhow::Context;
use nalgebra::{Point3, Vector3};
use pyo3::prelude::*;
use pyo3::types::{PyList, PyTuple};
use std::path::Path;
use trackwright_calibration::doubts::{PoseFrame, of_points, with_written_quaternions};
use trackwright_calibration::marker_body::MarkerBody;
use trackwright_formats::pivot_recording::PivotRecording;
use trackwright_geometry::pose::{Pose, pose_from_parts};
use trackwright_project::Files;
use trackwright_result::with_separators;

const EXPECTED_POSES: &str = "the columns of a poses table (x, y, z, qw, qx, qy, qz)";
const EXPECTED_POINTS: &str = "the columns of points (x, y, z)";

/// Which tool of a recording is meant.
#[derive(Clone, Copy, Default)]
pub struct WhichTool<'a> {
    /// A part of the tool's name.
    pub tool: Option<&'a str>,
    /// A part of the name of the tool in whose frame poses are.
    pub relative_to: Option<&'a str>,
}

/// Poses of a matrix with seven columns.
///
/// # Errors
/// Another shape, numbers that are not finite, quaternions that are not of unit length.
pub fn pose_rows(given: &Bound<'_, PyAny>, what: &str) -> Done<Vec<Pose>> {
    let each = rows::<7>(given, what)?.into_iter().enumerate();
    let poses = each.map(|(row, [x, y, z, quaternion @ ..])| {
        Ok(pose_from_parts(Vector3::new(x, y, z), rotation(quaternion, what, row)?))
    });
    poses.collect()
}

/// Whether an object is an array of numbers, or rows of them, and no table with names.
fn is_array(given: &Bound<'_, PyAny>) -> PyResult<bool> {
    if given.is_instance_of::<PyList>() || given.is_instance_of::<PyTuple>() {
        return Ok(true);
    }
    match given.getattr_opt("dtype")? {
        Some(dtype) => Ok(dtype.getattr_opt("names")?.is_none_or(|names| names.is_none())),
        None => Ok(false),
    }
}

/// A tool's poses: an array of n rows of seven, a table, a recording, or a list of recordings one after
/// the other.
///
/// # Errors
/// What is none of these, and poses beside markers.
pub fn tool_poses(
    given: &Bound<'_, PyAny>,
    which: WhichTool<'_>,
    as_is: bool,
    notes: &mut Notes,
) -> Done<Vec<Pose>> {
    let is_files = |list: &Bound<'_, PyAny>| -> PyResult<bool> {
        let first = list.try_iter()?.next().transpose()?;
        first.map_or(Ok(false), |first| Ok(first.extract::<std::path::PathBuf>().is_ok()))
    };
    if is_array(given)? {
        if given.is_instance_of::<PyList>() && is_files(given)? {
            let mut poses = Vec::new();
            for file in given.try_iter()? {
                poses.extend(recorded(
                    &file?.extract::<std::path::PathBuf>()?,
                    which,
                    as_is,
                    notes,
                )?);
            }
            return Ok(poses);
        }
        let poses = pose_rows(given, "poses")?;
        return checked_poses(poses, as_is, notes);
    }
    match Table::of(given)? {
        Table::File(file) => recorded(&file, which, as_is, notes),
        Table::Memory(columns) => {
            checked_poses(columns.poses("", EXPECTED_POSES)?.all()?, as_is, notes)
        }
    }
}

fn checked_poses(poses: Vec<Pose>, as_is: bool, notes: &mut Notes) -> Done<Vec<Pose>> {
    let suspicions = with_written_quaternions(&poses, PoseFrame::Recorded);
    take(of_memory(poses, "poses", suspicions), as_is, notes)
}

/// A tool's poses in a file.
fn recorded(file: &Path, which: WhichTool<'_>, as_is: bool, notes: &mut Notes) -> Done<Vec<Pose>> {
    let named = || file.display().to_string();
    let refused =
        |what: &str| Err(TrackwrightError::new_err(format!("{}: {what}", file.display())).into());
    match take(Files::default().read_pivot_recording(file)?, as_is, notes)? {
        PivotRecording::Tools(recording) => {
            let track = recording.track(which.tool, which.relative_to).with_context(named)?;
            for (reason, count) in track.unusable() {
                notes.push(format!(
                    "{}: {} of {} samples not used: {reason}",
                    named(),
                    with_separators(count),
                    with_separators(track.samples.len())
                ));
            }
            Ok(track.good().copied().collect())
        }
        _ if which.relative_to.is_some() => refused(
            "found poses of one tool, expected a recording of several, one of which is the reference tool",
        ),
        PivotRecording::Poses(poses) => Ok(poses),
        PivotRecording::Markers(frames) => {
            let first = frames.first().map_or(&[][..], Vec::as_slice);
            Ok(MarkerBody::seen_at(first).poses(&frames).with_context(named)?)
        }
        PivotRecording::MarkersAndBase(_) => refused(
            "found markers beside those of the EM tracker's base, expected poses or markers",
        ),
    }
}

/// Points: an array of n rows of three, a table, or a file of points.
///
/// # Errors
/// What is none of these.
pub fn points(
    given: &Bound<'_, PyAny>,
    what: &str,
    as_is: bool,
    notes: &mut Notes,
) -> Done<Vec<Point3<f64>>> {
    let found = match is_array(given)? {
        true => point_rows(given, what)?,
        false => match Table::of(given)? {
            Table::File(file) => return take(Files::default().read_points(&file)?, as_is, notes),
            Table::Memory(columns) => {
                let columns = columns.positions("", EXPECTED_POINTS)?;
                (0..columns.rows()?).map(|row| columns.point(row)).collect::<Result<_, _>>()?
            }
        },
    };
    let suspicions = of_points(&found);
    take(of_memory(found, what, suspicions), as_is, notes)
}
