//! The log of a built tool held against its design: one row a recorded pose.

use super::poses::write_pose;
use std::io::{self, Write};
use trackwright_calibration::agreement::AgreementRow;
use trackwright_geometry::number::shortest;

/// The log's columns, in order: the tool's true pose in the CRF (or the tracker), the tip's error as
/// it was measured and as it is predicted, and the difference; turns likewise.
pub const HEADER: &str = "true_x,true_y,true_z,true_qw,true_qx,true_qy,true_qz,\
    measured_x,measured_y,measured_z,measured_mm,predicted_x,predicted_y,predicted_z,predicted_mm,\
    residual_x,residual_y,residual_z,residual_mm,measured_deg,predicted_deg,residual_deg,\
    group,outside,supported,used";

/// Writes the rows; cells of what is not known are empty.
pub fn write(out: &mut dyn Write, rows: &[AgreementRow]) -> io::Result<()> {
    writeln!(out, "{HEADER}")?;
    for row in rows {
        write_pose(out, &row.crf_from_tool)?;
        for v in [row.measured_mm, row.predicted_mm, row.residual_mm()] {
            for value in [v.x, v.y, v.z, v.norm()] {
                write!(out, ",{}", shortest(value))?;
            }
        }
        let deg = |turn_rad: f64| shortest(turn_rad.to_degrees());
        let measured = row.measured_rad.map(|m| deg(m.norm()));
        let residual = row.measured_rad.map(|m| deg((m - row.predicted_rad).norm()));
        writeln!(
            out,
            ",{},{},{},{},{},{},{}",
            measured.unwrap_or_default(),
            deg(row.predicted_rad.norm()),
            residual.unwrap_or_default(),
            row.group,
            row.outside,
            row.is_unsupported.map_or("", |is_unsupported| if is_unsupported { "0" } else { "1" }),
            u8::from(row.is_used)
        )?;
    }
    Ok(())
}
