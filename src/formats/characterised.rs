//! Measurement tables of a characterised room: as any, and which sensor, recording and pose a row is of.

use super::number::shortest;
use crate::calibration::characterisation::Characterisation;
use crate::geometry::pose::pose_to_array;
use std::io::{self, Write};

/// Columns that `select` holds rows out by.
const NAMES: [&str; 7] = ["x", "y", "z", "qw", "qx", "qy", "qz"];

/// Writes a row a reading: `sensor` by name, `pair` and `pose` numbered from 0. Rows of one pose
/// belong together: a still pose, or a second of a path.
///
/// # Errors
/// Those of the writer.
pub fn write(out: &mut dyn Write, found: &Characterisation) -> io::Result<()> {
    let mut table = csv::Writer::from_writer(out);
    let poses = ["ideal", "measured"]
        .iter()
        .flat_map(|whose| NAMES.iter().map(move |name| format!("{whose}_{name}")));
    let names = ["sensor", "pair", "pose"].map(str::to_owned);
    table.write_record(poses.chain(names)).map_err(io_error)?;
    for reading in &found.readings {
        let m = &reading.measurement;
        let numbers = [&m.tracker_from_ideal, &m.tracker_from_measured]
            .into_iter()
            .flat_map(pose_to_array)
            .map(shortest);
        let sensor = found.sensors.get(reading.sensor).cloned();
        let rest = [
            sensor.unwrap_or_default(),
            reading.pair.to_string(),
            reading.pose.to_string(),
        ];
        table.write_record(numbers.chain(rest)).map_err(io_error)?;
    }
    table.flush()
}

fn io_error(error: csv::Error) -> io::Error {
    io::Error::other(error)
}
