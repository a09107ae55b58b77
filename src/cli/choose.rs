//! What the command line leaves open about a model, chosen by cross-validation.

use super::output;
use crate::field::fit::{FitMethod, FitSettings};
use crate::field::samples::{MapKind, SampleSet};
use crate::field::selection::{
    self, Candidate, SelectSettings, Selection, clusters, folds, select,
};
use crate::geometry::directions::{DirectionSet, Weighting};
use crate::store;
use crate::study::figures::with_separators;
use crate::task::Task;
use anyhow::{Context, bail};
use serde_json::{Value, json};
use std::path::Path;

/// Steps of the progress bar.
const BAR_STEPS: u64 = 1000;

/// A model as far as the command line says it.
pub(super) struct Asked {
    pub order: Option<usize>,
    pub directions: Option<DirectionSet>,
    pub ridge: Option<f64>,
    pub method: FitMethod,
    pub map: MapKind,
    pub weighting: Weighting,
    pub rcond: f64,
}

/// Which rows are held out together, and who says so.
pub(super) struct Grouping {
    /// "column cluster", "clusters of positions".
    pub by: String,
    pub groups: Vec<usize>,
}

/// What cross-validation chose for a fit.
pub(super) struct Chosen {
    selection: Selection,
    by: Option<String>,
    folds: usize,
}

/// The settings of a fit; what is left open is chosen by cross-validation on the measurements.
///
/// # Errors
/// Measurements that nothing can be chosen by.
pub(super) fn settings(
    file: &Path,
    samples: &SampleSet,
    asked: Asked,
) -> anyhow::Result<(FitSettings, Option<Chosen>)> {
    // Without orientations there is only one set of them: no choice.
    let directions = asked
        .directions
        .or_else(|| (!samples.has_rotations).then_some(DirectionSet::One));
    let fit_settings = |candidate: &Candidate| FitSettings {
        order: candidate.order,
        directions: candidate.directions,
        method: asked.method,
        map: asked.map,
        weighting: asked.weighting,
        ridge: candidate.ridge,
        rcond: asked.rcond,
    };
    if let (Some(order), Some(directions)) = (asked.order, directions) {
        let candidate = Candidate {
            order,
            directions,
            ridge: asked.ridge.unwrap_or(0.0),
        };
        return Ok((fit_settings(&candidate), None));
    }
    let mut tried = SelectSettings {
        method: asked.method,
        map: asked.map,
        weighting: asked.weighting,
        rcond: asked.rcond,
        ..SelectSettings::for_samples(samples)
    };
    if let Some(order) = asked.order {
        tried.orders = vec![order];
    }
    if let Some(directions) = directions {
        tried.direction_sets = vec![directions];
    }
    if let Some(ridge) = asked.ridge {
        tried.ridges = vec![ridge];
    }
    let grouping = grouping(file, samples, None, tried.folds)?;
    let selection = cross_validate(file, samples, grouping.as_ref(), &tried)?;
    Ok((
        fit_settings(&selection.best().candidate),
        Some(Chosen {
            selection,
            by: grouping.map(|g| g.by),
            folds: tried.folds,
        }),
    ))
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
    if let Some(column) = store::read_groups(file, column)? {
        if column.labels.len() != samples.samples.len() {
            bail!(
                "{}: column {} has {} rows, expected {}",
                file.display(),
                column.name,
                column.labels.len(),
                samples.samples.len()
            );
        }
        return Ok(Some(Grouping {
            by: format!("column {}", column.name),
            groups: folds::numbered(&column.labels).0,
        }));
    }
    let positions: Vec<_> = samples.samples.iter().map(|s| s.position_mm).collect();
    let Some(groups) = clusters::find(&positions) else {
        return Ok(None);
    };
    let count = groups.iter().max().map_or(0, |last| last + 1);
    if count < folds {
        output::note(&format!(
            "{}: the positions lie in {count} clusters, too few for {folds} folds, so rows are held out one by one",
            file.display()
        ));
        return Ok(None);
    }
    Ok(Some(Grouping {
        by: "clusters of positions".to_owned(),
        groups,
    }))
}

/// [`select`], with a progress bar.
///
/// # Errors
/// Those of [`select`], with the file's name.
pub(super) fn cross_validate(
    file: &Path,
    samples: &SampleSet,
    grouping: Option<&Grouping>,
    settings: &SelectSettings,
) -> anyhow::Result<Selection> {
    let bar = output::progress(BAR_STEPS, "cross-validating");
    let task = Task::told_to({
        let bar = bar.clone();
        move |part| bar.set_position((part * BAR_STEPS as f64) as u64)
    });
    let groups = grouping.map(|g| g.groups.as_slice());
    let selection =
        select(samples, groups, settings, &task).with_context(|| file.display().to_string())?;
    bar.finish_and_clear();
    Ok(selection)
}

/// "order 3, 42 orientations, ridge 1e-3".
pub(super) fn candidate_text(candidate: &Candidate) -> String {
    if candidate.order == 0 {
        return "order 0, no correction".to_owned();
    }
    let plural = if candidate.directions.len() == 1 {
        ""
    } else {
        "s"
    };
    let ridge = match candidate.ridge {
        0.0 => "no ridge".to_owned(),
        ridge => format!("ridge {}", ridge_text(ridge)),
    };
    format!(
        "order {}, {} orientation{plural}, {ridge}",
        candidate.order,
        candidate.directions.len(),
    )
}

/// A ridge with two digits, "3.2e-5".
pub(super) fn ridge_text(ridge: f64) -> String {
    let text = format!("{ridge:.1e}");
    text.replace(".0e", "e")
}

/// Why the choice is what it is, in one sentence.
pub(super) fn reason(selection: &Selection, by: Option<&str>, folds: usize) -> String {
    let (best, least) = (selection.best(), selection.least());
    let rms = best.deciding().position_rms_mm;
    let how = match (by, selection.groups) {
        (Some(by), Some(count)) => {
            format!(
                "{folds} folds over {} groups by {by}",
                with_separators(count)
            )
        }
        _ => format!("{folds} folds"),
    };
    let is_least_of_all = selection
        .table
        .iter()
        .all(|row| row.deciding().position_rms_mm >= least.deciding().position_rms_mm);
    let why = if selection.best == selection.least {
        match is_least_of_all {
            true => "the least of all".to_owned(),
            false => "the least of all that the rows determine".to_owned(),
        }
    } else {
        format!(
            "the smallest within {:.0} % of the least, {:.4} mm ({})",
            selection::TOLERANCE * 100.0,
            least.deciding().position_rms_mm,
            candidate_text(&least.candidate),
        )
    };
    format!(
        "chosen: {}; {rms:.4} mm RMS held out in {how}, {why}",
        candidate_text(&best.candidate)
    )
}

impl Chosen {
    pub fn reason(&self) -> String {
        reason(&self.selection, self.by.as_deref(), self.folds)
    }

    pub fn as_json(&self) -> Value {
        let best = self.selection.best();
        let cv = best.deciding();
        json!({
            "order": best.candidate.order,
            "directions": best.candidate.directions.len(),
            "ridge": best.candidate.ridge,
            "cv": super::select::scores_json(cv),
            "folds": self.folds,
            "groups": self.by.as_ref().map(|by| json!({
                "by": by,
                "count": self.selection.groups,
            })),
            "reason": self.reason(),
        })
    }
}
