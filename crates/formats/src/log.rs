//! The simulation log: one row a trial.

use super::poses::write_pose;
use std::io::{self, Write};
use trackwright_geometry::number::shortest;
use trackwright_simulation::Trial;

/// The log's columns, in order.
pub const HEADER: &str = "true_x,true_y,true_z,true_qw,true_qx,true_qy,true_qz,\
    sim_x,sim_y,sim_z,sim_qw,sim_qx,sim_qy,sim_qz,\
    err_x,err_y,err_z,err_mm,err_deg,outside,out_of_volume";

/// Writes the header line.
pub fn write_header(out: &mut dyn Write) -> io::Result<()> {
    writeln!(out, "{HEADER}")
}

/// Writes one trial's line: the tool's poses in the CRF, its tip's error there, and how many
/// sensors were outside the model's box and out of the tracker's volume.
pub fn write_trial(out: &mut dyn Write, trial: &Trial) -> io::Result<()> {
    write_pose(out, &trial.crf_from_tool)?;
    out.write_all(b",")?;
    write_pose(out, &trial.crf_from_tool_simulated)?;
    let e = &trial.tip_error_in_crf_mm;
    for value in [e.x, e.y, e.z, trial.tip_error_mm, trial.angle_error_deg] {
        write!(out, ",{}", shortest(value))?;
    }
    writeln!(out, ",{},{}", trial.outside, trial.out_of_volume)
}
