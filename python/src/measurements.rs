//! Measurement tables as samples, and which of their rows belong together.

use crate::errors::{Done, TrackwrightError};
use crate::long_work;
use crate::tables::{Columns, ColumnsError, Notes, Table, of_memory, take};
use anyhow::Context;
use pyo3::prelude::*;
use trackwright_calibration::row_labels::{HeldOut, RowLabels};
use trackwright_field::samples::{Measurement, MeasurementContent, SampleSet};
use trackwright_field::selection::HoldOutBy;
use trackwright_formats::groups::{GROUP_COLUMNS, GroupColumn, SENSOR_COLUMN};
use trackwright_formats::table::POSE;
use trackwright_project::{Doubted, Files, SampleReading, file_name, room_name};

const EXPECTED: &str =
    "the columns of a measurement table (ideal_x, ideal_y, ideal_z, …, measured_x, …)";
const EXPECTED_QUATERNIONS: &str =
    "all of ideal_qw … ideal_qz and measured_qw … measured_qz, or none of them";

/// A table's samples, and what the table is called.
pub struct Measured {
    /// In messages.
    pub label: String,
    /// In the environment that is made of it.
    pub name: String,
    /// Of the room that is made of it, where it has no other.
    pub room: String,
    pub samples: SampleSet,
}

/// Reads a measurement table.
///
/// # Errors
/// Columns that are missing, numbers that are not finite, and what is beyond doubt no such table.
pub fn read(
    py: Python<'_>,
    table: &Table<'_>,
    reading: SampleReading,
    as_is: bool,
    notes: &mut Notes,
) -> Done<Measured> {
    match table {
        Table::File(file) => {
            let read =
                long_work::run(py, |task| Ok(Files::default().read_samples(file, reading, task)?))?;
            Ok(Measured {
                label: file.display().to_string(),
                name: file_name(file),
                room: room_name(file),
                samples: take(read, as_is, notes)?,
            })
        }
        Table::Memory(columns) => {
            let [label, name, room] = ["table", "table", "room"].map(str::to_owned);
            let samples = take(samples(columns, reading)?, as_is, notes)?;
            Ok(Measured { label, name, room, samples })
        }
    }
}

fn samples(columns: &Columns<'_>, reading: SampleReading) -> Done<Doubted<SampleSet>> {
    let mut has_rotations = false;
    for end in &POSE[3..] {
        has_rotations |= columns.has(&format!("ideal_{end}"))?;
        has_rotations |= columns.has(&format!("measured_{end}"))?;
    }
    let content = match (has_rotations, reading.has_rolls) {
        (true, true) => MeasurementContent::SixDof,
        (true, false) => MeasurementContent::FiveDof,
        (false, false) => MeasurementContent::PositionOnly,
        (false, true) => {
            let text = "table: found no quaternions, expected them for 6-DOF sensors";
            return Err(TrackwrightError::new_err(text).into());
        }
    };
    // Positions that are missing are named before quaternions.
    for begin in ["ideal_", "measured_"] {
        columns.positions(begin, EXPECTED)?;
    }
    let poses = |begin: &str| match has_rotations {
        true => columns.poses(begin, EXPECTED_QUATERNIONS),
        false => columns.positions(begin, EXPECTED),
    };
    let (ideal, measured) = (poses("ideal_")?, poses("measured_")?);
    let mut rows = 0..ideal.rows()?;
    let (set, suspicions) = reading.samples(content, || -> Done<Option<Measurement>> {
        let measurement = |row| -> Done<Measurement> {
            Ok(Measurement {
                tracker_from_ideal: ideal.pose(row)?,
                tracker_from_measured: measured.pose(row)?,
            })
        };
        rows.next().map(measurement).transpose()
    })?;
    Ok(of_memory(set, "table", suspicions))
}

/// Which rows belong together, which sensor each is of, and what is to be held out.
///
/// # Errors
/// A column that is not there or has empty cells, nothing to hold out.
pub fn labels(
    table: &Table<'_>,
    measured: &Measured,
    group: Option<&str>,
    held_out: Option<&HeldOut>,
    notes: &mut Notes,
) -> Done<RowLabels> {
    let column = match (group, held_out.and_then(HeldOut::column)) {
        (Some(group), Some(column)) if group != column => {
            let text = format!("group {group} and hold_out {column}: expected one column");
            return Err(TrackwrightError::new_err(text).into());
        }
        (group, column) => group.or(column),
    };
    let deciding = held_out.map(HeldOut::deciding);
    let groups = group_column(table, column)?;
    let sensors = match sensor_column(table) {
        Err(error) if deciding != Some(HoldOutBy::Sensors) => {
            notes.push(format!("{error}; sensors are not held out"));
            None
        }
        read => read?,
    };
    let [groups, sensors] =
        [&groups, &sensors].map(|of| of.as_ref().map(GroupColumn::named_labels));
    let labels = RowLabels::of(&measured.samples, groups, sensors, deciding);
    Ok(labels.with_context(|| measured.label.clone())?)
}

/// The named column, or one that is known to group rows.
fn group_column(table: &Table<'_>, name: Option<&str>) -> Done<Option<GroupColumn>> {
    match table {
        Table::File(file) => Ok(Files::default().read_groups(file, name)?),
        Table::Memory(columns) => {
            if let Some(name) = name {
                let missing = || ColumnsError::NoGroups(name.to_owned());
                return Ok(Some(columns.labels(name)?.ok_or_else(missing)?));
            }
            for known in GROUP_COLUMNS {
                if columns.has(known)? {
                    return columns.labels(known);
                }
            }
            Ok(None)
        }
    }
}

fn sensor_column(table: &Table<'_>) -> Done<Option<GroupColumn>> {
    match table {
        Table::File(file) => Ok(Files::default().read_sensors(file)?),
        Table::Memory(columns) => columns.labels(SENSOR_COLUMN),
    }
}
