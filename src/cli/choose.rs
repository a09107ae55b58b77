//! What the command line leaves open about a model, chosen by cross-validation with a progress bar.

use super::output::{self, Shown};
use crate::calibration::room_choice::{
    self, AskedModel, Chosen, Grouping, RowGroups, WantedModel, row_groups,
};
use crate::field::fit::FitSettings;
use crate::field::samples::SampleSet;
use crate::field::selection::SelectSettings;
use crate::report::selection::reason;
use crate::store;
use anyhow::Context;
use serde_json::{Value, json};
use std::path::Path;

/// The settings of a fit; what is left open is chosen by cross-validation on the measurements.
///
/// # Errors
/// Measurements that nothing can be chosen by.
pub(super) fn settings(
    file: &Path,
    samples: &SampleSet,
    asked: &AskedModel,
) -> anyhow::Result<(FitSettings, Option<Chosen>)> {
    match asked.wanted(samples) {
        WantedModel::Said(settings) => Ok((settings, None)),
        WantedModel::Open(tried) => {
            let grouping = grouping(file, samples, None, tried.folds)?;
            let chosen = cross_validate(file, samples, grouping, tried)?;
            Ok((chosen.settings(), Some(chosen)))
        }
    }
}

/// The groups of a table's rows: by the named column, by one that is known to mean so, or by the
/// clusters that the positions themselves show.
///
/// # Errors
/// A column that is not there or has empty cells.
pub(super) fn grouping(
    file: &Path,
    samples: &SampleSet,
    column: Option<&str>,
    folds: usize,
) -> anyhow::Result<Option<Grouping>> {
    let column = store::read_groups(file, column)?;
    let column = column
        .as_ref()
        .map(|c| (c.name.as_str(), c.labels.as_slice()));
    let groups = row_groups(samples, column, folds).with_context(|| file.display().to_string())?;
    Ok(match groups {
        RowGroups::OneByOne => None,
        RowGroups::TooFewClusters(count) => {
            output::note(&format!(
                "{}: the positions lie in {count} clusters, too few for {folds} folds, so rows are held out one by one",
                file.display()
            ));
            None
        }
        RowGroups::Together(grouping) => Some(grouping),
    })
}

/// [`room_choice::choose`], with a progress bar.
///
/// # Errors
/// Those of it, with the file's name.
pub(super) fn cross_validate(
    file: &Path,
    samples: &SampleSet,
    grouping: Option<Grouping>,
    tried: SelectSettings,
) -> anyhow::Result<Chosen> {
    let shown = Shown::new("cross-validating");
    room_choice::choose(samples, grouping, tried, &shown.task)
        .with_context(|| file.display().to_string())
}

/// Why the choice is what it is.
pub(super) fn reason_of(chosen: &Chosen) -> String {
    reason(&chosen.selection, chosen.by.as_deref(), chosen.tried.folds)
}

pub(super) fn as_json(chosen: &Chosen) -> Value {
    let best = chosen.selection.best();
    let cv = best.deciding();
    json!({
        "order": best.candidate.order,
        "directions": best.candidate.directions.len(),
        "ridge": best.candidate.ridge,
        "cv": super::select::scores_json(cv),
        "folds": chosen.tried.folds,
        "groups": chosen.by.as_ref().map(|by| json!({
            "by": by,
            "count": chosen.selection.groups,
        })),
        "reason": reason_of(chosen),
    })
}
