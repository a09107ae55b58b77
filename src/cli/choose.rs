//! What the command line leaves open about a model, chosen by cross-validation with a progress bar.

use super::prelude::*;
use trackwright_calibration::room_choice::{
    self, Chosen, Grouping, HeldOut, ModelChoice, ModelRequest, RowLabels, numbered_labels,
    row_groups,
};
use trackwright_field::fit::FitSettings;
use trackwright_field::samples::SampleSet;
use trackwright_field::selection::{HoldOutBy, SelectSettings};
use trackwright_formats::groups::SENSOR_COLUMN;
use trackwright_report::selection::{grouped_line, hold_out_lines, sensors_line};
use trackwright_report::selection_json::reason_of;

/// The settings of a fit; what is left open is chosen by cross-validation on the measurements.
/// Where a hold-out is named, a model with nothing open is cross-validated as well.
///
/// # Errors
/// Measurements that nothing can be chosen by.
pub(super) fn settings(
    files: &Files,
    file: &Path,
    samples: &SampleSet,
    request: &ModelRequest,
    hold_out: Option<&HeldOut>,
) -> anyhow::Result<(FitSettings, Option<Chosen>)> {
    let wanted = match (request.wanted(samples), hold_out) {
        (ModelChoice::Fixed(settings), None) => return Ok((settings, None)),
        (wanted, _) => wanted,
    };
    let tried = wanted.tried(samples);
    let labels = row_labels(files, file, samples, None, hold_out)?;
    let chosen = cross_validate(file, samples, labels, tried)?;
    Ok((chosen.settings(), Some(chosen)))
}

/// Which rows belong together, which sensor each is of, and what is to be held out.
///
/// # Errors
/// A column that is not there or has empty cells, nothing to hold out.
pub(super) fn row_labels(
    files: &Files,
    file: &Path,
    samples: &SampleSet,
    group: Option<&str>,
    hold_out: Option<&HeldOut>,
) -> anyhow::Result<RowLabels> {
    let held_out = hold_out.and_then(HeldOut::column);
    let column = match (group, held_out) {
        (Some(group), Some(column)) if group != column => {
            bail!("--group {group} and --hold-out {column}: expected one column")
        }
        (group, column) => group.or(column),
    };
    let deciding = hold_out.map(HeldOut::deciding);
    let grouping = grouping(files, file, samples, column)?;
    if deciding == Some(HoldOutBy::Groups) && grouping.is_none() {
        bail!(
            "{}: found no groups of rows to hold out, expected a column cluster, frame or pose, places that were measured several times, or --hold-out COLUMN",
            file.display()
        );
    }
    let sensors = match files.read_sensors(file) {
        Ok(Some(column)) => numbered_labels(&column.name, &column.labels, samples.samples.len())
            .map(Some)
            .with_context(|| file.display().to_string())?,
        Ok(None) => None,
        Err(error) if deciding == Some(HoldOutBy::Sensors) => return Err(error.into()),
        Err(error) => {
            output::note(&format!("note: {error}; sensors are not held out"));
            None
        }
    };
    if deciding == Some(HoldOutBy::Sensors) && sensors.is_none() {
        bail!(
            "{}: found no column {SENSOR_COLUMN:?}, expected one that names the sensor of each row",
            file.display()
        );
    }
    Ok(RowLabels { grouping, sensors, deciding })
}

/// The groups of a table's rows: by the named column, by one that is known to mean so, or by the
/// clusters or places that the data show.
fn grouping(
    files: &Files,
    file: &Path,
    samples: &SampleSet,
    column: Option<&str>,
) -> anyhow::Result<Option<Grouping>> {
    let column = files.read_groups(file, column)?;
    let column = column.as_ref().map(|c| (c.name.as_str(), c.labels.as_slice()));
    row_groups(samples, column).with_context(|| file.display().to_string())
}

/// [`room_choice::choose_by`], with a progress bar.
///
/// # Errors
/// Those of it, with the file's name.
pub(super) fn cross_validate(
    file: &Path,
    samples: &SampleSet,
    labels: RowLabels,
    tried: SelectSettings,
) -> anyhow::Result<Chosen> {
    let shown = Shown::new("cross-validating");
    room_choice::choose_by(samples, labels, tried, &shown.task)
        .with_context(|| file.display().to_string())
}

/// What was found of the rows, the chosen model in each hold-out, and why it was chosen.
pub(super) fn lines(chosen: &Chosen) -> Vec<String> {
    let (found, by) = (&chosen.selection, chosen.by.as_deref());
    let grouped = chosen.places.as_ref().map(grouped_line);
    let sensors = found.sensors.as_ref().map(sensors_line);
    grouped
        .into_iter()
        .chain(hold_out_lines(found, by))
        .chain(sensors)
        .chain([reason_of(chosen)])
        .collect()
}
