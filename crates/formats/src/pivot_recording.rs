//! What `pivot` reads: a tool's poses, or its markers, in one of several formats distinguished by
//! their first line.

use super::error::{FormatError, quoted, text};
use super::table_dialect::{ColumnName, first_cells, number_cells};
use super::{jhu_cis, matrices, poses, recording};
use nalgebra::Point3;
use trackwright_calibration::marker_body::BaseAndTool;
use trackwright_geometry::pose::Pose;
use trackwright_simulation::recording::Recording;

/// A recording of a tool whose tip rests in one point; tracker frame, mm.
#[derive(Clone, Debug, PartialEq)]
pub enum PivotRecording {
    /// `tracker_from_tool`.
    Poses(Vec<Pose>),
    /// Of the tool, frame by frame, in the same order.
    Markers(Vec<Vec<Point3<f64>>>),
    /// The same beside markers of an EM tracker's base, optical frame.
    MarkersAndBase(Vec<BaseAndTool>),
    /// One or several tools, of which one is meant.
    Tools(Recording),
}

/// Reads a tracker's recording, 4x4 matrices, a poses table, or an `empivot` or `optpivot` file of the
/// JHU course.
///
/// # Errors
/// Those of the format that the first line belongs to.
pub fn parse(bytes: &[u8]) -> Result<PivotRecording, FormatError> {
    if recording::is_recording(bytes) {
        return recording::parse(bytes).map(PivotRecording::Tools);
    }
    let (line, first, are_numbers) = first_cells(text(bytes)?).ok_or(FormatError::NoRows)?;
    match are_numbers {
        [true, true] => matrices::parse(bytes).map(PivotRecording::Poses),
        // Counts, then the file's name.
        [true, false] if number_cells(first).count() == 4 => {
            jhu_cis::parse_optpivot(bytes).map(PivotRecording::MarkersAndBase)
        }
        [true, false] => jhu_cis::parse_empivot(bytes).map(PivotRecording::Markers),
        [false, _] if names_pose_columns(first) => poses::parse(bytes).map(PivotRecording::Poses),
        [false, _] => {
            let expected = "the beginning of a recording: an NDI table, an Aurora log, a PLUS \
                sequence, a live recording, a log of lines with Position: and Orientation:, 4x4 or \
                3x4 matrices, a poses table (x, y, z, qw, qx, qy, qz), an empivot or an optpivot file";
            Err(FormatError::line(line, quoted(first), expected))
        }
    }
}

/// Whether a line is the header of a poses table, whatever is between its cells.
fn names_pose_columns(line: &str) -> bool {
    let names =
        line.split([',', ';', '\t']).map(|name| ColumnName::parse(name.trim().trim_matches('"')));
    names.map(|name| name.plain).any(|plain| ["x", "qw"].contains(&plain.as_str()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_line_states_what_a_recording_is() {
        let matrix = b"# log\n1 0 0 4\n0 1 0 5\n0 0 1 6\n0 0 0 1\n";
        let table = b"x,y,z,qw,qx,qy,qz\n4,5,6,1,0,0,0\n";
        for bytes in [&matrix[..], &table[..]] {
            let found = parse(bytes).unwrap();
            assert_eq!(found, PivotRecording::Poses(vec![Pose::translation(4.0, 5.0, 6.0)]));
        }
        let ndi = b"Tools\tPort 1\tState\tQ0\tQx\tQy\tQz\tTx\tTy\tTz\n1\tPort 1\tOK\t1\t0\t0\t0\t4\t5\t6\n";
        assert!(matches!(parse(ndi), Ok(PivotRecording::Tools(found)) if found.tools.len() == 1));
        let jhu = b"2, 1, pa1-empivot.txt\n1, 2, 3\n4, 5, 6\n";
        let markers = vec![vec![Point3::new(1.0, 2.0, 3.0), Point3::new(4.0, 5.0, 6.0)]];
        assert_eq!(parse(jhu).unwrap(), PivotRecording::Markers(markers));
    }

    #[test]
    fn errors_are_those_of_the_nearest_format() {
        let message = |bytes: &[u8]| parse(bytes).unwrap_err().to_string();
        assert_eq!(message(b""), "found no rows, expected at least one");
        let no_poses = message(b"time,x,y\n0,1,2\n");
        assert!(no_poses.contains("expected the columns of a poses table"), "{no_poses}");
        let prose = message(b"# Title\n\nSome words, and more.\n");
        assert!(
            prose.starts_with("line 3: found \"Some words, and more.\", expected the beginning of"),
            "{prose}"
        );
        let other_counts = message(b"8, 8, 27, 8, pa1-calreadings.txt\n");
        assert!(other_counts.contains("N_G, N_frames"), "{other_counts}");
        let cut = message(b"8, 6, 12, pa1-optpivot.txt\n");
        assert!(cut.contains("the end of the file, expected more points"), "{cut}");
    }
}
