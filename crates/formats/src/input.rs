//! Input data mode: where the tool was in the CRF, and perhaps where that was.

use super::error::FormatError;
use super::table::Table;
use trackwright_simulation::InputTrial;

const EXPECTED: &str =
    "the columns of an input table (tool_x, tool_y, tool_z, tool_qw, …, tool_qz)";
const EXPECTED_CRF: &str = "all of crf_x … crf_qz, or none of them";

/// Reads input data; the CRF's columns only for a design that has one.
///
/// # Errors
/// Missing columns, cells that are no numbers, quaternions off unit length, no rows.
pub fn parse(bytes: &[u8], design_has_crf: bool) -> Result<Vec<InputTrial>, FormatError> {
    let table = Table::parse(bytes)?;
    let header = table.header();
    let tool = header.pose("tool_", EXPECTED)?;
    let has_crf = design_has_crf && header.has_pose("crf_");
    let crf = has_crf.then(|| header.pose("crf_", EXPECTED_CRF)).transpose()?;
    table.read(|row| {
        Ok(InputTrial {
            tracker_from_crf: crf.as_ref().map(|crf| row.pose(crf)).transpose()?,
            crf_from_tool: row.pose(&tool)?,
        })
    })
}
