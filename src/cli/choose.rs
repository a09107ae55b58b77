//! What the command line leaves open about a model, chosen by cross-validation with a progress bar.

use super::prelude::*;
use trackwright_calibration::kind_choice::{Decided, Wanted, decide};
use trackwright_calibration::room_choice::{self, Chosen, ModelRequest};
use trackwright_calibration::row_labels::{HeldOut, RowLabels};
use trackwright_field::samples::SampleSet;
use trackwright_field::selection::{HoldOutBy, SelectSettings};
use trackwright_formats::groups::GroupColumn;

/// What to fit; what is left open is chosen by cross-validation on the measurements. Where a hold-out is
/// named, a model with nothing open is cross-validated as well.
///
/// # Errors
/// Measurements that nothing can be chosen by.
pub(super) fn decided(
    files: &Files,
    file: &Path,
    samples: &SampleSet,
    wanted: (&Wanted, &ModelRequest),
    hold_out: Option<&HeldOut>,
) -> anyhow::Result<Decided> {
    let (model, request) = wanted;
    let labels = match model.is_open(request, samples, hold_out.is_some()) {
        true => row_labels(files, file, samples, None, hold_out)?,
        false => RowLabels::default(),
    };
    let shown = Shown::new("cross-validating");
    decide(samples, wanted, hold_out.is_some(), labels, &shown.task)
        .with_context(|| file.display().to_string())
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
    let groups = files.read_groups(file, column)?;
    let sensors = match files.read_sensors(file) {
        Err(error) if deciding != Some(HoldOutBy::Sensors) => {
            output::note(&format!("note: {error}; sensors are not held out"));
            None
        }
        read => read?,
    };
    let [groups, sensors] =
        [&groups, &sensors].map(|of| of.as_ref().map(GroupColumn::named_labels));
    RowLabels::of(samples, groups, sensors, deciding).with_context(|| file.display().to_string())
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
