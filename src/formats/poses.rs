//! Pose tables: `x, y, z, qw, qx, qy, qz`, and what `distort` adds to them.

use super::error::FormatError;
use super::number::shortest;
use super::table::{PoseColumns, Table};
use crate::geometry::pose::{Pose, pose_to_array};
use std::io::{self, Write};

const EXPECTED: &str = "the columns of a poses table (x, y, z, qw, qx, qy, qz)";

/// Reads a table of poses.
///
/// # Errors
/// Missing columns, cells that are no numbers, quaternions off unit length, no rows.
pub fn parse(bytes: &[u8]) -> Result<Vec<Pose>, FormatError> {
    let table = Table::parse(bytes)?;
    let [x, y, z, qw, qx, qy, qz] =
        table.columns(["x", "y", "z", "qw", "qx", "qy", "qz"], EXPECTED)?;
    let columns = PoseColumns {
        position: [x, y, z],
        rotation: Some([qw, qx, qy, qz]),
    };
    table.rows()?.map(|row| row.pose(&columns)).collect()
}

/// Writes poses, each with whether it was outside the model's box; a pose that was left out has
/// empty cells.
///
/// # Errors
/// Those of the writer.
pub fn write_with_outside(
    out: &mut dyn Write,
    rows: impl IntoIterator<Item = (Option<Pose>, bool)>,
) -> io::Result<()> {
    writeln!(out, "x,y,z,qw,qx,qy,qz,outside")?;
    for (pose, is_outside) in rows {
        match pose {
            Some(pose) => write_pose(out, &pose)?,
            None => out.write_all(b",,,,,,")?,
        }
        writeln!(out, ",{}", u8::from(is_outside))?;
    }
    Ok(())
}

/// A compensated pose as a row: no pose where there is no answer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CompensatedRow {
    pub pose: Option<Pose>,
    pub is_outside: bool,
    /// Other poses may read the same.
    pub is_ambiguous: bool,
}

/// Writes compensated poses with their flags; one without an answer has empty pose cells and did
/// not converge.
///
/// # Errors
/// Those of the writer.
pub fn write_compensated(
    out: &mut dyn Write,
    rows: impl IntoIterator<Item = CompensatedRow>,
) -> io::Result<()> {
    writeln!(out, "x,y,z,qw,qx,qy,qz,outside,converged,ambiguous")?;
    for row in rows {
        match row.pose {
            Some(pose) => write_pose(out, &pose)?,
            None => out.write_all(b",,,,,,")?,
        }
        let [outside, converged, ambiguous] =
            [row.is_outside, row.pose.is_some(), row.is_ambiguous].map(u8::from);
        writeln!(out, ",{outside},{converged},{ambiguous}")?;
    }
    Ok(())
}

/// Writes a pose's seven cells, without a line end.
pub(super) fn write_pose(out: &mut dyn Write, pose: &Pose) -> io::Result<()> {
    let cells = pose_to_array(pose).map(shortest);
    out.write_all(cells.join(",").as_bytes())
}
