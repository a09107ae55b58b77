//! `verify`: recordings of the built tool against what its design predicts for the same poses.

use super::as_is::refused;
use super::named_design::note_sizes;
use super::numbers::zero_or_more;
use super::prelude::*;
use super::tool_reader::ToolReader;
use trackwright_calibration::agreement::{
    AgreementSettings, PivotedError, RecordedFrame, Unknowns, pivoted_tool,
};
use trackwright_calibration::built_tool::BodySource;
use trackwright_field::environment::OrientationWeight;
use trackwright_formats::agreement_log;
use trackwright_project::{BuiltTool, BuiltToolFailure, BuiltToolNote, BuiltToolTables};
use trackwright_report::agreement_chart;
use trackwright_result::Row;
use trackwright_simulation::Scenario;

/// Size of the chart in pixels.
const CHART_SIZE: (u32, u32) = (1000, 560);

/// Hold recordings of the built tool against what its design predicts for the same poses
#[derive(Debug, Args)]
pub struct VerifyArgs {
    /// Design that the tool was built after (*.design.ron, or the name of a built-in one), in the room that it was recorded in
    design: PathBuf,

    /// What was recorded of the built tool. A table with its true and its measured poses (CSV: ideal_x
    /// … ideal_qz, measured_x … measured_qz, as `characterize` writes them): of the tool as a whole,
    /// as the tracker reports it, or a row for each of its sensors at each pose, with columns
    /// `sensor` (named as in the design) and `pose`. With --pivot, recordings of the tool's poses
    /// while its tip rested in one point, in any format that `pivot` reads
    #[arg(required = true, value_name = "RECORDED")]
    recorded: Vec<PathBuf>,

    /// The same table of the CRF, with a row for every row of the tool's: errors are then those of the
    /// tool in the CRF. Without it a design's CRF is left out, and errors are in the tracker's frame
    #[arg(long, value_name = "CRF.csv", conflicts_with = "pivot")]
    crf: Option<PathBuf>,

    /// Frame of a table's poses
    #[arg(long, value_parser = FRAME, default_value = "tracker", conflicts_with_all = ["pivot", "crf"])]
    frame: RecordedFrame,

    /// The recordings are of the tool with its tip at rest in one point, and nothing measured the
    /// truth: where that point is and where the tip is on the tool are found from them, and what
    /// this takes up of the error is taken out of the prediction too
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

    /// Compare true and measured poses of a table even where they are so far apart that they seem to be
    /// in different frames, or all outside the room
    #[arg(long, conflicts_with = "pivot")]
    same_frame: bool,

    /// What happens to poses with a sensor outside the room's box, about which the room knows nothing
    #[arg(long, value_parser = OUTSIDE, default_value = "reject")]
    outside: OutsidePolicy,

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

    #[command(flatten)]
    common: TableArgs,
}

/// Frame of a table's poses.
pub(super) const FRAME: Choice<RecordedFrame> = Choice(&[
    ("tracker", "The tracker's", RecordedFrame::Tracker),
    ("crf", "The CRF's, which is at rest where the design has it", RecordedFrame::Crf),
]);

/// Reads, predicts, compares, and writes what was requested.
///
/// # Errors
/// Files that can't be used, recordings that cannot answer, with the reason.
pub fn run(args: &VerifyArgs, files: &Files) -> anyhow::Result<()> {
    let log = files.optional_output(args.log.as_deref())?;
    let chart = files.optional_output(args.chart.as_deref())?;
    let world = files.open_design_without_meshes(&args.design)?;
    let design = world.document.design();
    let scenario = trackwright_project::resolve(design, &world.environment);
    note_sizes(design);
    let shown = Shown::new("verifying");
    let orientation_weight = scenario.environment.orientation_weight(design.orientation_weight_mm);
    let (found, tip) = match args.pivot {
        true => pivoted(args, files, scenario, &shown)?,
        false => (paired(args, files, scenario, &shown)?, None),
    };
    drop(shown);
    if let Some(log) = &log {
        log.write(|out| agreement_log::write(out, &found.agreement.rows))?;
    }
    if let Some(chart) = &chart {
        let svg = agreement_chart::chart(&design.name, &found.agreement).to_svg(CHART_SIZE);
        chart.write_bytes(svg.as_bytes())?;
    }
    let assumptions = assumptions(&found, orientation_weight, tip.is_some());
    let section = found.section(tip.into_iter().flatten()).with_all(assumptions);
    let head = output::head(&design.name, &world.environment.name);
    output::print_section(args.common.format, &section.headed(head))
}

fn settings(args: &VerifyArgs) -> AgreementSettings {
    AgreementSettings {
        unknowns: match (args.pivot, args.registered) {
            (true, _) => Unknowns::Pivot,
            (false, true) => Unknowns::Registration,
            (false, false) => Unknowns::None,
        },
        outside: args.outside,
        keeps_unsupported: !args.supported_only,
        averaged: f64::from(args.averaged),
        truth_std_mm: args.truth_mm,
        seed: args.seed,
        ..AgreementSettings::default()
    }
}

fn paired(
    args: &VerifyArgs,
    files: &Files,
    scenario: Scenario,
    shown: &Shown,
) -> anyhow::Result<BuiltTool> {
    let [file] = args.recorded.as_slice() else {
        bail!(
            "found {} tables, expected one; several recordings are for --pivot",
            args.recorded.len()
        );
    };
    let tables = BuiltToolTables {
        tool: file,
        crf: args.crf.as_deref(),
        frame: args.frame,
        whole: args.tool.as_deref(),
        is_one_frame: args.same_frame,
        is_as_meant: args.common.as_is.as_is,
        settings: settings(args),
    };
    let found = trackwright_project::built_tool(files, scenario, &tables, &shown.task, &|note| {
        match note {
            BuiltToolNote::CrfLeftOut => output::note(
                "note: no recording of the CRF (--crf): it is left out, and errors are in the tracker's frame",
            ),
            note => output::note(&format!("note: {note}")),
        }
    });
    found.map_err(|failure| in_flags(args, failure))
}

/// A failure as it reads on the command line.
fn in_flags(args: &VerifyArgs, failure: BuiltToolFailure) -> anyhow::Error {
    let design = args.design.display();
    match failure {
        BuiltToolFailure::NoCrf { file } => {
            anyhow!("{design}: the design has no CRF, which --crf {} would be of", file.display())
        }
        BuiltToolFailure::NoCrfFrame => {
            anyhow!("{design}: found no CRF, expected one for --frame crf")
        }
        BuiltToolFailure::Simulation(cause) => anyhow!("{design}: {cause}"),
        BuiltToolFailure::Frames { .. } => {
            anyhow!("{failure}; --same-frame compares them as they are")
        }
        BuiltToolFailure::Store(error) => refused(error),
        failure => failure.into(),
    }
}

/// With what was found of the tip.
fn pivoted(
    args: &VerifyArgs,
    files: &Files,
    mut scenario: Scenario,
    shown: &Shown,
) -> anyhow::Result<(BuiltTool, Option<[Row; 4]>)> {
    scenario.outside = args.outside;
    if scenario.crf.take().is_some() {
        output::note(
            "note: a pivoted tool is compared in the tracker's frame: the CRF is left out",
        );
    }
    let mut reader = ToolReader::of_tool(files, args.tool.as_deref(), args.common.as_is);
    let poses = reader.read_all(args.recorded.iter().map(PathBuf::as_path))?;
    let found = pivoted_tool(&scenario, &poses, &settings(args), &shown.task);
    let found = found.map_err(|error| match error {
        PivotedError::Simulation(cause) => anyhow!("{}: {cause}", args.design.display()),
        PivotedError::Agreement(cause) => anyhow!("the recording: {cause}"),
        error => error.into(),
    })?;
    let tip = found.tip_rows(&scenario.tool.judged_tip_in_body());
    let built = BuiltTool {
        has_crf: false,
        source: BodySource::Whole,
        rows_left_out: 0,
        crf_rows_left_out: 0,
        without_crf: 0,
        without_tool: 0,
        agreement: found.agreement,
    };
    Ok((built, Some(tip)))
}

/// What the figures depend on that the recording does not state.
fn assumptions(found: &BuiltTool, weight: OrientationWeight, is_pivoted: bool) -> Vec<String> {
    let mut assumed = Vec::new();
    if found.source == BodySource::Whole {
        assumed.push(format!(
            "Assumed: the tracker computes the tool's pose from its sensors by a least-squares fit, an axis weighing \
             {:.0} mm, with the sensors where the design has them.",
            weight.value_mm
        ));
    }
    if is_pivoted {
        assumed.push(
            "What a pivot calibration takes up, a shift and the tip's place on the tool, is out of both; true poses are \
             those that would read as recorded."
                .to_owned(),
        );
    }
    assumed
}
