//! Measurement tables: where sensors were, and where the tracker said they were.

use super::error::FormatError;
use super::number::shortest;
use super::table::{PoseColumns, Table};
use crate::field::samples::{Measurement, MeasurementContent, MeasurementSet};
use crate::geometry::pose::pose_to_array;
use std::io::{self, Write};

const EXPECTED: &str =
    "the columns of a measurement table (ideal_x, ideal_y, ideal_z, …, measured_x, …)";
const EXPECTED_QUATERNIONS: &str =
    "all of ideal_qw … ideal_qz and measured_qw … measured_qz, or none of them";
const QUATERNIONS: [&str; 8] = [
    "ideal_qw",
    "ideal_qx",
    "ideal_qy",
    "ideal_qz",
    "measured_qw",
    "measured_qx",
    "measured_qy",
    "measured_qz",
];

/// Reads a measurement table. One with quaternions is taken to be of 5-DOF sensors, one without
/// is position-only.
///
/// # Errors
/// Missing columns, cells that are no numbers, quaternions off unit length, no rows.
pub fn parse(bytes: &[u8]) -> Result<MeasurementSet, FormatError> {
    let table = Table::parse(bytes)?;
    let [ix, iy, iz, mx, my, mz] = table.columns(
        [
            "ideal_x",
            "ideal_y",
            "ideal_z",
            "measured_x",
            "measured_y",
            "measured_z",
        ],
        EXPECTED,
    )?;
    let quaternions = if QUATERNIONS.iter().any(|name| table.has(name)) {
        Some(table.columns(QUATERNIONS, EXPECTED_QUATERNIONS)?)
    } else {
        None
    };
    let ideal = PoseColumns {
        position: [ix, iy, iz],
        rotation: quaternions.map(|[w, x, y, z, ..]| [w, x, y, z]),
    };
    let measured = PoseColumns {
        position: [mx, my, mz],
        rotation: quaternions.map(|[.., w, x, y, z]| [w, x, y, z]),
    };
    let measurements = table
        .rows()?
        .map(|row| {
            Ok(Measurement {
                tracker_from_ideal: row.pose(&ideal)?,
                tracker_from_measured: row.pose(&measured)?,
            })
        })
        .collect::<Result<_, FormatError>>()?;
    Ok(MeasurementSet {
        measurements,
        content: match quaternions {
            Some(_) => MeasurementContent::FiveDof,
            None => MeasurementContent::PositionOnly,
        },
    })
}

/// Writes a measurement table, without quaternions where there is nothing in them.
///
/// # Errors
/// Those of the writer.
pub fn write(out: &mut dyn Write, set: &MeasurementSet) -> io::Result<()> {
    let names = match set.content {
        MeasurementContent::PositionOnly => &["x", "y", "z"][..],
        MeasurementContent::FiveDof | MeasurementContent::SixDof => {
            &["x", "y", "z", "qw", "qx", "qy", "qz"]
        }
    };
    let header: Vec<_> = ["ideal", "measured"]
        .iter()
        .flat_map(|whose| names.iter().map(move |name| format!("{whose}_{name}")))
        .collect();
    writeln!(out, "{}", header.join(","))?;
    for m in &set.measurements {
        let cells: Vec<_> = [&m.tracker_from_ideal, &m.tracker_from_measured]
            .into_iter()
            .flat_map(|pose| pose_to_array(pose).into_iter().take(names.len()))
            .map(shortest)
            .collect();
        writeln!(out, "{}", cells.join(","))?;
    }
    Ok(())
}
