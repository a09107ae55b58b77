//! Markers, fiducials and poses as calibrations read them.

use super::read;
use trackwright_formats::pivot_recording::{self, PivotRecording};
use trackwright_formats::{jhu_cis, matrices, points};
use trackwright_geometry::pose::Pose;

/// Points of a file's line: `1,2,3`.
const LEAST_LINE: usize = 5;

/// The same bytes as each kind of file: no more points come of them than they have room for, and
/// poses written as matrices are read again.
pub fn calibration_files(bytes: &[u8]) -> bool {
    let calbody = read(jhu_cis::parse_calbody(bytes)).map(|body| {
        body.optical_on_base.len() + body.optical_on_object.len() + body.em_on_object.len()
    });
    let calreadings = read(jhu_cis::parse_calreadings(bytes)).map(|frames| {
        let count = |frame: &trackwright_calibration::calibration_object::CalibrationFrame| {
            frame.optical_on_base.len() + frame.optical_on_object.len() + frame.em_on_object.len()
        };
        frames.iter().map(count).sum()
    });
    let empivot =
        read(jhu_cis::parse_empivot(bytes)).map(|frames| frames.iter().map(Vec::len).sum());
    let optpivot = read(jhu_cis::parse_optpivot(bytes)).map(|frames| {
        let counts = frames.iter().map(|frame| frame.on_base.len() + frame.on_tool.len());
        counts.sum()
    });
    let fiducials = read(jhu_cis::parse_ct_fiducials(bytes)).map(|points| points.len());
    let points = read(points::parse(bytes)).map(|points| {
        assert!(points.iter().flat_map(|p| p.iter()).all(|v| v.is_finite()));
        points.len()
    });
    let counts = [calbody, calreadings, empivot, optpivot, fiducials, points];
    for count in counts.into_iter().flatten() {
        assert!(count * LEAST_LINE <= bytes.len(), "{count}");
    }
    let matrices = read(matrices::parse(bytes));
    if let Some(poses) = &matrices {
        assert_survive(poses);
    }
    let pivot = read(pivot_recording::parse(bytes));
    if let Some(PivotRecording::Poses(poses)) = &pivot {
        assert_survive(poses);
    }
    counts.iter().any(Option::is_some) || matrices.is_some() || pivot.is_some()
}

/// Poses through matrices in text, up to the rounding of a matrix of a quaternion and back.
fn assert_survive(poses: &[Pose]) {
    let mut text = String::new();
    for pose in poses {
        let matrix = pose.to_homogeneous();
        for row in 0..4 {
            for column in 0..4 {
                text += &format!("{} ", matrix[(row, column)]);
            }
        }
        text.push('\n');
    }
    let again = matrices::parse(text.as_bytes()).expect("it was written here");
    assert_eq!(again.len(), poses.len());
    for (again, pose) in again.iter().zip(poses) {
        assert_eq!(again.translation, pose.translation);
        assert!(again.rotation.angle_to(&pose.rotation) < 1e-7);
    }
}
