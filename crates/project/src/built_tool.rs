//! The built tool's tables against its design: read, paired, predicted, compared.

use super::error::StoreError;
use super::files::Files;
use std::path::{Path, PathBuf};
use trackwright_calibration::agreement::{
    Agreement, AgreementError, AgreementRow, AgreementSettings, FrameMismatch, RecordedFrame,
    RecordedPose, agreement, frame_mismatch, paired_rows,
};
use trackwright_calibration::built_tool::{
    BodySource, BuiltToolError, RecordedBody, RecordedTable, recorded_body, same_moments,
};
use trackwright_calibration::doubts::Suspicion;
use trackwright_field::OutsidePolicy;
use trackwright_result::{Row, Section, count, data, mm, with_separators};
use trackwright_simulation::RigidBody;
use trackwright_simulation::Scenario;
use trackwright_task::Task;

#[derive(Clone, Debug)]
pub struct BuiltToolTables<'a> {
    pub tool: &'a Path,
    /// With a row for every row of the tool's.
    pub crf: Option<&'a Path>,
    pub frame: RecordedFrame,
    /// A part of the name of what the tracker takes for the whole tool.
    pub whole: Option<&'a str>,
    /// Poses are compared even where they are too far apart to be in one frame.
    pub is_one_frame: bool,
    /// The tables are meant to be as they are, whatever is suspected of them.
    pub is_as_meant: bool,
    pub settings: AgreementSettings,
}

#[derive(Clone, Debug)]
pub struct BuiltTool {
    pub has_crf: bool,
    pub source: BodySource,
    pub rows_left_out: usize,
    pub crf_rows_left_out: usize,
    pub without_crf: usize,
    pub without_tool: usize,
    pub agreement: Agreement,
}

impl BuiltTool {
    /// How far the recording agrees with the design; `tip` is what a pivot found of the tip.
    pub fn section(&self, tip: impl IntoIterator<Item = Row>) -> Section {
        let left_out = |label, found: usize| count("", label, found).part().shown_if(found > 0);
        let unused = self.rows_left_out + self.crf_rows_left_out;
        let mut rows = vec![
            left_out("left out, the CRF not recorded", self.without_crf),
            left_out("of the CRF alone, left out", self.without_tool),
            left_out("rows of the tables not used", unused),
            data("without_crf", self.without_crf),
            data("without_tool", self.without_tool),
            data("rows_left_out", self.rows_left_out),
            data("crf_rows_left_out", self.crf_rows_left_out),
            data("frame", if self.has_crf { "crf" } else { "tracker" }),
        ];
        if let BodySource::Sensors { count, misfit_rms_mm } = self.source {
            let misfit = "sensors from their places in the design, RMS";
            rows.push(data("sensors.count", count));
            rows.push(mm("sensors.misfit_rms_mm", misfit, misfit_rms_mm));
        }
        self.agreement.section(rows.into_iter().chain(tip))
    }
}

#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum BuiltToolNote {
    #[error(
        "{}: {} of {} rows not used: {}",
        file.display(), with_separators(*unused), with_separators(*rows), why_unused(kind)
    )]
    RowsNotUsed { file: PathBuf, unused: usize, rows: usize, kind: BodySource },
    /// Moments of one body at which the other was not recorded.
    #[error(
        "{}: {} of {} poses not used: {} has none of these moments",
        file.display(), with_separators(*unpaired), with_separators(*moments), other.display()
    )]
    Unpaired { file: PathBuf, unpaired: usize, moments: usize, other: PathBuf },
    #[error("no recording of the CRF: it is left out, and errors are in the tracker's frame")]
    CrfLeftOut,
    #[error("warning: {}: {suspicion}", file.display())]
    Suspected { file: PathBuf, suspicion: Box<Suspicion> },
}

#[derive(Debug, thiserror::Error)]
pub enum BuiltToolFailure {
    #[error(transparent)]
    Store(#[from] StoreError),
    #[error("{}: {cause}", file.display())]
    Table { file: PathBuf, cause: BuiltToolError },
    #[error("{}: the design has no CRF that this could be of", file.display())]
    NoCrf { file: PathBuf },
    #[error("the design has no CRF, expected one for poses in its frame")]
    NoCrfFrame,
    #[error(
        "{} and {} have no moment in common, expected rows in the same order, or the same values in column \
         pose", tool.display(), crf.display()
    )]
    NothingInCommon { tool: PathBuf, crf: PathBuf },
    #[error("{}: {mismatch}", file.display())]
    Frames { file: PathBuf, mismatch: FrameMismatch },
    /// The design cannot be simulated there.
    #[error(transparent)]
    Simulation(AgreementError),
    #[error("{}: {cause}", file.display())]
    Agreement { file: PathBuf, cause: AgreementError },
}

/// Reads the tables, predicts, compares; a CRF without a table is left out in the tracker's frame.
pub fn built_tool(
    files: &Files,
    mut scenario: Scenario,
    tables: &BuiltToolTables,
    task: &Task,
    note: &dyn Fn(BuiltToolNote),
) -> Result<BuiltTool, BuiltToolFailure> {
    scenario.outside = tables.settings.outside;
    let weight_mm = scenario.orientation_weight_mm;
    let read = |file: &Path, body: &RigidBody, whole: Option<&str>| {
        let table =
            files.read_recorded_tool(file)?.take(tables.is_as_meant, |file, suspicion| {
                note(BuiltToolNote::Suspected {
                    file: file.to_owned(),
                    suspicion: Box::new(suspicion.clone()),
                });
            })?;
        read_body(file, &table, body, weight_mm, whole, note)
    };
    let tool = read(tables.tool, &scenario.tool, tables.whole)?;
    let (mut crf_rows_left_out, mut without_crf, mut without_tool) = (0, 0, 0);
    let checked = |body: &RecordedBody, scenario: &Scenario, file: &Path| match tables.is_one_frame
    {
        true => Ok(()),
        false => check_frames(body, scenario, file, task),
    };
    let poses: Vec<RecordedPose> = match (tables.crf, tables.frame) {
        (Some(crf_file), _) => {
            let Some(crf) = &scenario.crf else {
                let file = crf_file.to_owned();
                return Err(BuiltToolFailure::NoCrf { file });
            };
            let recorded = read(crf_file, &crf.body, None)?;
            let alone =
                |body: &RigidBody| Scenario { tool: body.clone(), crf: None, ..scenario.clone() };
            checked(&tool, &alone(&scenario.tool), tables.tool)?;
            checked(&recorded, &alone(&crf.body), crf_file)?;
            let both = same_moments(&tool, &recorded);
            crf_rows_left_out = recorded.rows_left_out;
            without_crf = tool.moments.len() - both.len();
            without_tool = recorded.moments.len() - both.len();
            if both.is_empty() {
                return Err(BuiltToolFailure::NothingInCommon {
                    tool: tables.tool.to_owned(),
                    crf: crf_file.to_owned(),
                });
            }
            for (unpaired, moments, file, other) in [
                (without_crf, &tool.moments, tables.tool, crf_file),
                (without_tool, &recorded.moments, crf_file, tables.tool),
            ] {
                if unpaired > 0 {
                    note(BuiltToolNote::Unpaired {
                        file: file.to_owned(),
                        unpaired,
                        moments: moments.len(),
                        other: other.to_owned(),
                    });
                }
            }
            let each = both.iter();
            each.map(|(tool, crf)| {
                RecordedPose::in_tracker(&tool.pose, Some(&crf.pose), tool.group)
            })
            .collect()
        }
        (None, frame) => {
            if frame == RecordedFrame::Crf && scenario.crf.is_none() {
                return Err(BuiltToolFailure::NoCrfFrame);
            }
            if frame == RecordedFrame::Tracker && scenario.crf.take().is_some() {
                note(BuiltToolNote::CrfLeftOut);
            }
            poses_of(&tool)
        }
    };
    let rows = paired_rows(&scenario, &poses, &task.subtask(0.0, 0.3))
        .map_err(BuiltToolFailure::Simulation)?;
    if tables.crf.is_none()
        && !tables.is_one_frame
        && let Some(mismatch) = reported_mismatch(&scenario, &rows)
    {
        let file = tables.tool.to_owned();
        return Err(BuiltToolFailure::Frames { file, mismatch });
    }
    let agreement = agreement(&scenario, rows, &tables.settings, &task.subtask(0.3, 1.0))
        .map_err(|cause| BuiltToolFailure::Agreement { file: tables.tool.to_owned(), cause })?;
    Ok(BuiltTool {
        has_crf: scenario.crf.is_some(),
        source: tool.source,
        rows_left_out: tool.rows_left_out,
        crf_rows_left_out,
        without_crf,
        without_tool,
        agreement,
    })
}

fn poses_of(body: &RecordedBody) -> Vec<RecordedPose> {
    let each = body.moments.iter();
    each.map(|m| RecordedPose::in_tracker(&m.pose, None, m.group)).collect()
}

/// A body's table by itself, in the tracker's frame.
fn check_frames(
    body: &RecordedBody,
    scenario: &Scenario,
    file: &Path,
    task: &Task,
) -> Result<(), BuiltToolFailure> {
    let quiet = Task::cancelled_by(task.cancel.clone());
    let rows =
        paired_rows(scenario, &poses_of(body), &quiet).map_err(BuiltToolFailure::Simulation)?;
    match reported_mismatch(scenario, &rows) {
        None => Ok(()),
        Some(mismatch) => Err(BuiltToolFailure::Frames { file: file.to_owned(), mismatch }),
    }
}

/// Poses that are all outside the room are reported where they are requested.
fn reported_mismatch(scenario: &Scenario, rows: &[AgreementRow]) -> Option<FrameMismatch> {
    let is_requested = scenario.outside != OutsidePolicy::Reject;
    frame_mismatch(scenario, rows)
        .filter(|found| !(is_requested && matches!(found, FrameMismatch::NotInRoom { .. })))
}

fn read_body(
    file: &Path,
    table: &RecordedTable,
    body: &RigidBody,
    orientation_weight_mm: f64,
    whole: Option<&str>,
    note: &dyn Fn(BuiltToolNote),
) -> Result<RecordedBody, BuiltToolFailure> {
    let found = recorded_body(table, body, orientation_weight_mm, whole)
        .map_err(|cause| BuiltToolFailure::Table { file: file.to_owned(), cause })?;
    if found.rows_left_out > 0 {
        note(BuiltToolNote::RowsNotUsed {
            file: file.to_owned(),
            unused: found.rows_left_out,
            rows: table.rows.len(),
            kind: found.source,
        });
    }
    Ok(found)
}

/// Why rows of a table are not used.
fn why_unused(kind: &BodySource) -> &'static str {
    match kind {
        BodySource::Whole => "they are of something else",
        BodySource::Sensors { .. } => {
            "of sensors that the body does not have, or of poses in which not every sensor was read as often"
        }
    }
}
