//! Measurement tables: where sensors were, and where the tracker reported them.

use super::error::{FormatError, text};
use super::table::{POSE, PoseColumns, Table};
use std::io::{self, Read, Write};
use trackwright_field::samples::{Measurement, MeasurementContent, MeasurementSet};
use trackwright_geometry::number::shortest;
use trackwright_geometry::pose::pose_to_array;

const EXPECTED: &str =
    "the columns of a measurement table (ideal_x, ideal_y, ideal_z, …, measured_x, …)";
const EXPECTED_QUATERNIONS: &str =
    "all of ideal_qw … ideal_qz and measured_qw … measured_qz, or none of them";
/// A measurement table that is read row by row. One with quaternions is taken to be of 5-DOF
/// sensors, one without is position-only.
pub struct MeasurementReader<R: Read> {
    table: Table<R>,
    ideal: PoseColumns,
    measured: PoseColumns,
}

impl<R: Read> MeasurementReader<R> {
    /// Reads the header.
    ///
    /// # Errors
    /// Missing columns, or text that is no table.
    pub fn new(reader: R) -> Result<Self, FormatError> {
        let table = Table::new(reader)?;
        let [ideal, measured] =
            table.header().poses(["ideal_", "measured_"], EXPECTED, EXPECTED_QUATERNIONS)?;
        Ok(Self { table, ideal, measured })
    }

    /// What the table's columns can hold.
    pub fn content(&self) -> MeasurementContent {
        match self.ideal.rotation {
            Some(_) => MeasurementContent::FiveDof,
            None => MeasurementContent::PositionOnly,
        }
    }

    /// The next row; `None` after the last.
    ///
    /// # Errors
    /// Cells that are no numbers, quaternions off unit length, no rows at all.
    pub fn next_measurement(&mut self) -> Result<Option<Measurement>, FormatError> {
        let Some(row) = self.table.next_row()? else {
            return Ok(None);
        };
        Ok(Some(Measurement {
            tracker_from_ideal: row.pose(&self.ideal)?,
            tracker_from_measured: row.pose(&self.measured)?,
        }))
    }
}

/// Reads a whole measurement table.
///
/// # Errors
/// Those of [`MeasurementReader`].
pub fn parse(bytes: &[u8]) -> Result<MeasurementSet, FormatError> {
    // A byte that is no text is named before anything else.
    text(bytes)?;
    let mut reader = MeasurementReader::new(bytes)?;
    let mut set = MeasurementSet { measurements: Vec::new(), content: reader.content() };
    while let Some(measurement) = reader.next_measurement()? {
        set.measurements.push(measurement);
    }
    Ok(set)
}

/// Writes a measurement table, without quaternions where there is nothing in them.
pub fn write(out: &mut dyn Write, set: &MeasurementSet) -> io::Result<()> {
    let names = match set.content {
        MeasurementContent::PositionOnly => &POSE[..3],
        MeasurementContent::FiveDof | MeasurementContent::SixDof => &POSE[..],
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
