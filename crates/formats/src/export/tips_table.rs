//! Tips of a study as a table: where each is, and where the tracker would report it.

use std::io::{self, Write};
use trackwright_geometry::number::shortest;
use trackwright_geometry::pose::Pose;

/// The tip of one trial; its frame has the tool's axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StudiedTip {
    /// From 0, also of those that were left out.
    pub trial: usize,
    /// In the CRF, or in the tracker's frame where the design has none.
    pub crf_from_tip: Pose,
    pub crf_from_tip_simulated: Pose,
}

impl StudiedTip {
    pub fn error_mm(&self) -> f64 {
        let [is, reported] = [&self.crf_from_tip, &self.crf_from_tip_simulated];
        (reported.translation.vector - is.translation.vector).norm()
    }
}

/// Writes a row a tip: places in mm.
pub fn write(out: &mut dyn Write, tips: &[StudiedTip]) -> io::Result<()> {
    writeln!(out, "trial,true_x,true_y,true_z,sim_x,sim_y,sim_z,err_mm")?;
    for tip in tips {
        write!(out, "{}", tip.trial)?;
        for pose in [&tip.crf_from_tip, &tip.crf_from_tip_simulated] {
            for value in pose.translation.vector.iter() {
                write!(out, ",{}", shortest(*value))?;
            }
        }
        writeln!(out, ",{}", shortest(tip.error_mm()))?;
    }
    Ok(())
}
