//! What `pivot` reads: a tool's poses, or its markers, in one of several formats told apart by their
//! first line.

use super::error::{FormatError, text};
use super::{jhu_cis, matrices, poses};
use crate::geometry::pose::Pose;
use nalgebra::Point3;

/// A recording of a tool whose tip rests in one point; tracker frame, mm.
#[derive(Clone, Debug, PartialEq)]
pub enum PivotRecording {
    /// `tracker_from_tool`.
    Poses(Vec<Pose>),
    /// Of the tool, frame by frame, in the same order.
    Markers(Vec<Vec<Point3<f64>>>),
}

/// Reads 4x4 matrices, a poses table, or an `empivot` file of the JHU course.
///
/// # Errors
/// Those of the format that the first line belongs to.
pub fn parse(bytes: &[u8]) -> Result<PivotRecording, FormatError> {
    let first = text(bytes)?
        .lines()
        .map(str::trim)
        .find(|line| !line.is_empty() && !line.starts_with('#'))
        .unwrap_or("");
    let is_number = |cell: &str| cell.trim().parse::<f64>().is_ok();
    let is_between = |c: char| c.is_whitespace() || c == ',' || c == ';';
    let mut cells = first.split(is_between).filter(|cell| !cell.is_empty());
    match (
        cells.next().map(is_number),
        cells.next_back().map(is_number),
    ) {
        // Counts, then the file's name.
        (Some(true), Some(false)) => jhu_cis::parse_empivot(bytes).map(PivotRecording::Markers),
        // A header.
        (Some(false), _) => poses::parse(bytes).map(PivotRecording::Poses),
        _ => matrices::parse(bytes).map(PivotRecording::Poses),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_line_says_what_a_recording_is() {
        let matrix = b"# log\n1 0 0 4\n0 1 0 5\n0 0 1 6\n0 0 0 1\n";
        let table = b"x,y,z,qw,qx,qy,qz\n4,5,6,1,0,0,0\n";
        for bytes in [&matrix[..], &table[..]] {
            let found = parse(bytes).unwrap();
            assert_eq!(
                found,
                PivotRecording::Poses(vec![Pose::translation(4.0, 5.0, 6.0)])
            );
        }
        let jhu = b"2, 1, pa1-empivot.txt\n1, 2, 3\n4, 5, 6\n";
        let markers = vec![vec![Point3::new(1.0, 2.0, 3.0), Point3::new(4.0, 5.0, 6.0)]];
        assert_eq!(parse(jhu).unwrap(), PivotRecording::Markers(markers));
    }

    #[test]
    fn what_it_is_not_is_said_as_of_the_nearest_format() {
        let said = |bytes: &[u8]| parse(bytes).unwrap_err().to_string();
        assert_eq!(said(b""), "found no rows, expected at least one");
        let no_poses = said(b"time,x,y\n0,1,2\n");
        assert!(
            no_poses.contains("expected the columns of a poses table"),
            "{no_poses}"
        );
        let other_counts = said(b"8, 6, 12, pa1-optpivot.txt\n");
        assert!(other_counts.contains("N_G, N_frames"), "{other_counts}");
    }
}
