//! Input data mode: where the tool was in the CRF, and perhaps where that was.

use super::error::FormatError;
use super::table::{PoseColumns, Table};
use trackwright_simulation::InputTrial;

const EXPECTED: &str =
    "the columns of an input table (tool_x, tool_y, tool_z, tool_qw, …, tool_qz)";
const EXPECTED_CRF: &str = "all of crf_x … crf_qz, or none of them";
const CRF: [&str; 7] = ["crf_x", "crf_y", "crf_z", "crf_qw", "crf_qx", "crf_qy", "crf_qz"];

/// Reads input data; the CRF's columns only for a design that has one.
///
/// # Errors
/// Missing columns, cells that are no numbers, quaternions off unit length, no rows.
pub fn parse(bytes: &[u8], design_has_crf: bool) -> Result<Vec<InputTrial>, FormatError> {
    let table = Table::parse(bytes)?;
    let tool = pose_columns(table.columns(
        ["tool_x", "tool_y", "tool_z", "tool_qw", "tool_qx", "tool_qy", "tool_qz"],
        EXPECTED,
    )?);
    let crf = if design_has_crf && CRF.iter().any(|name| table.has(name)) {
        Some(pose_columns(table.columns(CRF, EXPECTED_CRF)?))
    } else {
        None
    };
    table
        .rows()?
        .map(|row| {
            Ok(InputTrial {
                tracker_from_crf: crf.as_ref().map(|crf| row.pose(crf)).transpose()?,
                crf_from_tool: row.pose(&tool)?,
            })
        })
        .collect()
}

fn pose_columns([x, y, z, qw, qx, qy, qz]: [super::table::Column; 7]) -> PoseColumns {
    PoseColumns { position: [x, y, z], rotation: Some([qw, qx, qy, qz]) }
}
