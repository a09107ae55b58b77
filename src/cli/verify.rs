//! `verify`: recordings of the built tool against what its design predicts for the same poses.

mod report;

use super::numbers::zero_or_more;
use super::output::{self, Format, OutsideArg, Shown};
use super::tool_reader::ToolReader;
use crate::calibration::built_tool::{BodySource, RecordedBody, recorded_body, same_moments};
use crate::calibration::pivot::{Pivot, PivotLimits, pivot};
use crate::design::Design;
use crate::formats::agreement_log;
use crate::report::agreement_chart;
use crate::store;
use crate::study::Scenario;
use crate::study::agreement::{
    Agreement, AgreementSettings, RecordedPose, Unknowns, agreement, paired_rows, pivot_rows,
};
use crate::study::figures::with_separators;
use crate::tracking::RigidBody;
use anyhow::{Context, bail};
use clap::{Args, ValueEnum};
use report::Recorded;
use std::path::{Path, PathBuf};

/// Size of the chart in pixels.
const CHART_SIZE: (u32, u32) = (1000, 560);

#[derive(Debug, Args)]
pub struct VerifyArgs {
    /// Design that the tool was built after (*.design.ron), in the room that it was recorded in
    design: PathBuf,

    /// What was recorded of the built tool. A table with its true and its measured poses (CSV: ideal_x
    /// … ideal_qz, measured_x … measured_qz, as `characterize` writes them): of the tool as a whole,
    /// as the tracker tells it, or a row for each of its sensors at each pose, with columns `sensor`
    /// (named as in the design) and `pose`. With --pivot, recordings of the tool's poses while its tip
    /// rested in one point, in any format that `pivot` reads
    #[arg(required = true, value_name = "RECORDED")]
    recorded: Vec<PathBuf>,

    /// The same table of the CRF, with a row for every row of the tool's: errors are then those of the
    /// tool in the CRF. Without it a design's CRF is left out, and errors are in the tracker's frame
    #[arg(long, value_name = "CRF.csv", conflicts_with = "pivot")]
    crf: Option<PathBuf>,

    /// Frame of a table's poses
    #[arg(long, value_enum, default_value_t, conflicts_with_all = ["pivot", "crf"])]
    frame: FrameArg,

    /// The recordings are of the tool with its tip at rest in one point, and nothing told the truth:
    /// where that point is and where the tip is on the tool are found from them, and what this takes
    /// up of the error is taken out of the prediction too
    #[arg(long)]
    pivot: bool,

    /// The true poses were registered to this very recording, as `characterize` does, which took up a
    /// part of the error: the same part is taken out of the prediction
    #[arg(long, conflicts_with = "pivot")]
    registered: bool,

    /// The tool where a recording has several, or the sensor of a table that is the whole tool: a part
    /// of its name
    #[arg(long, value_name = "NAME")]
    tool: Option<String>,

    /// What happens to poses with a sensor outside the room's box, about which the room knows nothing
    #[arg(long, value_enum, default_value = "reject")]
    outside: OutsideArg,

    /// Leave out poses that lean on field which the room's samples do not support; they are counted
    /// either way
    #[arg(long)]
    supported_only: bool,

    /// Readings that each recorded pose is the mean of: the tracker's jitter is smaller by their root
    #[arg(long, value_name = "COUNT", default_value_t = 1)]
    averaged: u32,

    /// Standard deviation of the true position of the tip, an axis: of the reference tracker, the
    /// phantom, the divot
    #[arg(long, value_name = "MM", default_value_t = 0.0, value_parser = zero_or_more)]
    truth_mm: f64,

    /// Seed of the resamplings that intervals come from
    #[arg(long, default_value_t = 0)]
    seed: u64,

    /// Table to write, one row a recorded pose: measured, predicted, difference
    #[arg(long, value_name = "OUT.csv")]
    log: Option<PathBuf>,

    /// Chart to write: measured and predicted side by side, pose by pose
    #[arg(long, value_name = "OUT.svg")]
    chart: Option<PathBuf>,

    /// How to print the figures
    #[arg(long, value_enum, default_value_t)]
    format: Format,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
enum FrameArg {
    /// The tracker's
    #[default]
    Tracker,
    /// The CRF's, which is at rest where the design has it
    Crf,
}

/// Reads, predicts, compares, and writes what was asked for.
///
/// # Errors
/// Files that can't be used, recordings that cannot answer, with the reason.
pub fn run(args: &VerifyArgs) -> anyhow::Result<()> {
    let world = store::open_design_without_meshes(&args.design)?;
    let design = world.document.design();
    let scenario = store::resolve(design, &world.environment);
    let shown = Shown::new("verifying");
    let (recorded, found) = match args.pivot {
        true => pivoted(args, design, scenario, &shown)?,
        false => paired(args, design, scenario, &shown)?,
    };
    drop(shown);
    if let Some(file) = &args.log {
        store::write_atomic(file, |out| agreement_log::write(out, &found.rows))?;
    }
    if let Some(file) = &args.chart {
        let svg = agreement_chart::chart(&design.name, &found).to_svg(CHART_SIZE);
        store::write_atomic(file, |out| out.write_all(svg.as_bytes()))?;
    }
    match args.format {
        Format::Json => output::print_json(&report::as_json(&recorded, &found.summary)),
        Format::Text => {
            let head = format!("{} in {}", design.name, world.environment.name);
            let text = report::as_text(&recorded, &found.summary);
            output::print(&format!("{head}\n{text}"))
        }
    }
}

fn settings(args: &VerifyArgs) -> AgreementSettings {
    AgreementSettings {
        unknowns: match (args.pivot, args.registered) {
            (true, _) => Unknowns::Pivot,
            (false, true) => Unknowns::Registration,
            (false, false) => Unknowns::None,
        },
        outside: args.outside.into(),
        keeps_unsupported: !args.supported_only,
        averaged: f64::from(args.averaged),
        truth_std_mm: args.truth_mm,
        seed: args.seed,
        ..AgreementSettings::default()
    }
}

fn paired(
    args: &VerifyArgs,
    design: &Design,
    mut scenario: Scenario,
    shown: &Shown,
) -> anyhow::Result<(Recorded, Agreement)> {
    scenario.outside = args.outside.into();
    let [file] = args.recorded.as_slice() else {
        bail!(
            "found {} tables, expected one; several recordings are for --pivot",
            args.recorded.len()
        );
    };
    let weight_mm = scenario.orientation_weight_mm;
    let tool = read_body(file, &scenario.tool, weight_mm, args.tool.as_deref())?;
    let mut unmatched = 0;
    let poses: Vec<RecordedPose> = match (&args.crf, args.frame) {
        (Some(crf_file), _) => {
            let Some(crf) = &scenario.crf else {
                bail!(
                    "{}: the design has no CRF, which --crf {} would be of",
                    args.design.display(),
                    crf_file.display()
                );
            };
            let crf = read_body(crf_file, &crf.body, weight_mm, None)?;
            let both = same_moments(&tool, &crf);
            unmatched = tool.moments.len() - both.len();
            if both.is_empty() {
                bail!(
                    "{} and {} have no moment in common, expected rows in the same order, or the same values in column \
                     pose",
                    file.display(),
                    crf_file.display()
                );
            }
            let each = both.iter();
            each.map(|(tool, crf)| {
                RecordedPose::in_tracker(&tool.pose, Some(&crf.pose), tool.group)
            })
            .collect()
        }
        (None, frame) => {
            if frame == FrameArg::Crf && scenario.crf.is_none() {
                bail!(
                    "{}: found no CRF, expected one for --frame crf",
                    args.design.display()
                );
            }
            if frame == FrameArg::Tracker && scenario.crf.take().is_some() {
                output::note(
                    "note: no recording of the CRF (--crf): it is left out, and errors are in the tracker's frame",
                );
            }
            let each = tool.moments.iter();
            each.map(|m| RecordedPose::in_tracker(&m.pose, None, m.group))
                .collect()
        }
    };
    let named = || args.design.display().to_string();
    let rows = paired_rows(&scenario, &poses, &shown.task.stretch(0.0, 0.3)).with_context(named)?;
    let task = shown.task.stretch(0.3, 1.0);
    let found = agreement(&scenario, rows, &settings(args), &task)
        .with_context(|| file.display().to_string())?;
    let recorded = Recorded {
        source: Some(tool.source),
        rows_left_out: tool.rows_left_out,
        without_crf: unmatched,
        has_crf: scenario.crf.is_some(),
        orientation_weight: scenario
            .environment
            .orientation_weight(design.orientation_weight_mm),
        pivot: None,
    };
    Ok((recorded, found))
}

fn read_body(
    file: &Path,
    body: &RigidBody,
    orientation_weight_mm: f64,
    whole: Option<&str>,
) -> anyhow::Result<RecordedBody> {
    let table = store::read_recorded_tool(file)?;
    let found = recorded_body(&table, body, orientation_weight_mm, whole)
        .with_context(|| file.display().to_string())?;
    if found.rows_left_out > 0 {
        output::note(&format!(
            "{}: {} of {} rows not used: {}",
            file.display(),
            with_separators(found.rows_left_out),
            with_separators(table.rows.len()),
            match found.source {
                BodySource::Whole => "they are of something else",
                BodySource::Sensors { .. } =>
                    "of sensors that the body does not have, or of poses in which not every sensor was read as often",
            }
        ));
    }
    Ok(found)
}

fn pivoted(
    args: &VerifyArgs,
    design: &Design,
    mut scenario: Scenario,
    shown: &Shown,
) -> anyhow::Result<(Recorded, Agreement)> {
    scenario.outside = args.outside.into();
    if scenario.crf.take().is_some() {
        output::note(
            "note: a pivoted tool is compared in the tracker's frame: the CRF is left out",
        );
    }
    let mut reader = ToolReader::of_tool(args.tool.as_deref());
    let poses = reader.read_all(args.recorded.iter().map(PathBuf::as_path))?;
    // How far the tip strays is what is asked here, so no distance is too large.
    let limits = PivotLimits {
        max_rms_mm: f64::MAX,
        ..PivotLimits::default()
    };
    let found: Pivot = pivot(&poses, &limits).context("no tip")?;
    let named = || args.design.display().to_string();
    let task = shown.task.stretch(0.0, 0.5);
    let (with_tip, rows) = pivot_rows(&scenario, &poses, &found, &task).with_context(named)?;
    let task = shown.task.stretch(0.5, 1.0);
    let judged = agreement(&with_tip, rows, &settings(args), &task)
        .with_context(|| "the recording".to_owned())?;
    let recorded = Recorded {
        source: None,
        rows_left_out: 0,
        without_crf: 0,
        has_crf: false,
        orientation_weight: scenario
            .environment
            .orientation_weight(design.orientation_weight_mm),
        pivot: Some((found, scenario.tool.judged_tip_in_body())),
    };
    Ok((recorded, judged))
}
