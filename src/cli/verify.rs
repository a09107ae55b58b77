//! `verify`: recordings of the built tool against what its design predicts for the same poses.

use super::as_is::refused;
use super::figures as known;
use super::named_design::note_sizes;
use super::numbers::zero_or_more;
use super::prelude::*;
use super::tool_reader::ToolReader;
use nalgebra::Point3;
use trackwright_calibration::agreement::{
    Agreement, AgreementSettings, Compared, Interval, PivotedError, RecordedFrame, Summary,
    Unknowns, pivoted_tool,
};
use trackwright_calibration::built_tool::BodySource;
use trackwright_calibration::pivot::Pivot;
use trackwright_design::Design;
use trackwright_field::environment::OrientationWeight;
use trackwright_formats::agreement_log;
use trackwright_project::{BuiltToolFailure, BuiltToolNote, BuiltToolTables};
use trackwright_report::agreement_chart;
use trackwright_report::figures_json::add_figures;
use trackwright_simulation::{Scenario, Statistics};

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
    let (recorded, found) = match args.pivot {
        true => pivoted(args, files, design, scenario, &shown)?,
        false => paired(args, files, design, scenario, &shown)?,
    };
    drop(shown);
    if let Some(log) = &log {
        log.write(|out| agreement_log::write(out, &found.rows))?;
    }
    if let Some(chart) = &chart {
        let svg = agreement_chart::chart(&design.name, &found).to_svg(CHART_SIZE);
        chart.write_bytes(svg.as_bytes())?;
    }
    let head = output::head(&design.name, &world.environment.name);
    let text = || format!("{head}\n{}", as_text(&recorded, &found));
    args.common.format.print(|| as_json(&recorded, &found), text)
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
    design: &Design,
    scenario: Scenario,
    shown: &Shown,
) -> anyhow::Result<(Recorded, Agreement)> {
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
    let orientation_weight = shown_weight(design, &scenario);
    let found = trackwright_project::built_tool(files, scenario, &tables, &shown.task, &|note| {
        match note {
            BuiltToolNote::CrfLeftOut => output::note(
                "note: no recording of the CRF (--crf): it is left out, and errors are in the tracker's frame",
            ),
            note => output::note(&format!("note: {note}")),
        }
    });
    let found = found.map_err(|failure| in_flags(args, failure))?;
    let recorded = Recorded {
        source: Some(found.source),
        rows_left_out: found.rows_left_out,
        crf_rows_left_out: found.crf_rows_left_out,
        without_crf: found.without_crf,
        without_tool: found.without_tool,
        has_crf: found.has_crf,
        orientation_weight,
        pivot: None,
    };
    Ok((recorded, found.agreement))
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

fn pivoted(
    args: &VerifyArgs,
    files: &Files,
    design: &Design,
    mut scenario: Scenario,
    shown: &Shown,
) -> anyhow::Result<(Recorded, Agreement)> {
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
    let recorded = Recorded {
        source: None,
        rows_left_out: 0,
        crf_rows_left_out: 0,
        without_crf: 0,
        without_tool: 0,
        has_crf: false,
        orientation_weight: shown_weight(design, &scenario),
        pivot: Some((found.pivot, scenario.tool.judged_tip_in_body())),
    };
    Ok((recorded, found.agreement))
}

fn shown_weight(design: &Design, scenario: &Scenario) -> OrientationWeight {
    scenario.environment.orientation_weight(design.orientation_weight_mm)
}

/// What is known of the recording besides its poses.
struct Recorded {
    /// `None` of a pivoted tool.
    source: Option<BodySource>,
    rows_left_out: usize,
    crf_rows_left_out: usize,
    /// Moments of the tool at which the CRF was not recorded.
    without_crf: usize,
    /// Moments of the CRF at which the tool was not.
    without_tool: usize,
    has_crf: bool,
    orientation_weight: OrientationWeight,
    /// The tip as the recording has it, and as the design does.
    pivot: Option<(Pivot, Point3<f64>)>,
}

fn as_json(recorded: &Recorded, found: &Agreement) -> Value {
    let mut value = json!(found.summary);
    add_figures(&mut value, &found.figures);
    value["frame"] = json!(if recorded.has_crf { "crf" } else { "tracker" });
    value["rows_left_out"] = json!(recorded.rows_left_out);
    value["crf_rows_left_out"] = json!(recorded.crf_rows_left_out);
    value["without_crf"] = json!(recorded.without_crf);
    value["without_tool"] = json!(recorded.without_tool);
    if let Some(BodySource::Sensors { count, misfit_rms_mm }) = recorded.source {
        value["sensors"] = json!({"count": count, "misfit_rms_mm": misfit_rms_mm});
    }
    if let Some((pivot, designed)) = &recorded.pivot {
        let point = |at: &Point3<f64>| -> [f64; 3] { at.coords.into() };
        value["tip"] = json!({
            "recorded": point(&pivot.tip_in_tool),
            "designed": point(designed),
            "distance_mm": (pivot.tip_in_tool - designed).norm(),
            "std_error_mm": pivot.tip_std_error_mm,
        });
    }
    value
}

fn as_text(recorded: &Recorded, found: &Agreement) -> String {
    let summary = &found.summary;
    let mut rows = vec![
        count("recorded poses", summary.poses),
        count("  compared", summary.used),
        count("  with a sensor outside the room's box", summary.outside),
    ];
    rows.extend(summary.unsupported.map(|found| count("  on poorly supported field", found)));
    let left_out = [
        ("  left out, the CRF not recorded", recorded.without_crf),
        ("  of the CRF alone, left out", recorded.without_tool),
        ("  rows of the tables not used", recorded.rows_left_out + recorded.crf_rows_left_out),
    ];
    let left_out = left_out.into_iter().filter(|(_, found)| *found > 0);
    rows.extend(left_out.map(|(label, found)| count(label, found)));
    rows.push(number("  effective number of poses", summary.effective, 1, ""));
    if let Some(BodySource::Sensors { misfit_rms_mm, .. }) = recorded.source {
        rows.push(mm("sensors from their places in the design, RMS", misfit_rms_mm));
    }
    if let Some((pivot, designed)) = &recorded.pivot {
        let off_mm = (pivot.tip_in_tool - designed).norm();
        rows.push(mm("recorded tip from that of the design", off_mm));
    }
    let recorded_rows = output::aligned(&rows);
    let position = side_by_side("tip error, mm", &summary.position_mm);
    let angle = summary.angle_deg.as_ref().map(|angle| side_by_side("angle error, °", angle));
    let errors: Vec<_> = [position].into_iter().chain(angle).collect();
    let mut rows = figures(summary);
    rows.extend(
        known::rows(&found.figures)
            .into_iter()
            .map(|(label, value, unit)| (format!("predicted {label}"), value, unit)),
    );
    let statement: Vec<_> = [summary.statement.clone()]
        .into_iter()
        .chain(known::no_interval_line(&found.figures))
        .chain(assumptions(recorded))
        .collect();
    [recorded_rows, errors.join("\n"), output::aligned(&rows), statement.join("\n")].join("\n\n")
}

/// The three distributions below each other.
fn side_by_side(what: &str, found: &Compared) -> String {
    let line = |name: &str, cells: [String; 5]| {
        let cells: Vec<String> = cells.iter().map(|c| format!("{c:>8}")).collect();
        format!("{name:<24}{}", cells.join(""))
    };
    let head = ["RMS", "mean", "median", "p95", "max"].map(str::to_owned);
    let of = |s: &Statistics| {
        [s.rms(), s.mean(), s.median(), s.p95(), s.max()].map(|v| format!("{v:.3}"))
    };
    [
        line(what, head),
        line("  measured", of(&found.measured)),
        line("  predicted", of(&found.predicted)),
        line("  measured − predicted", of(&found.residual)),
    ]
    .join("\n")
}

fn figures(summary: &Summary) -> Vec<Row> {
    let mut rows = Vec::new();
    let percent = |i: &Interval| interval(i, 100.0, 1);
    let found = &summary.position_mm;
    let mut push = |label: &str, value: Option<String>, unit: &str| {
        rows.extend(value.map(|value| row(label, value, unit)));
    };
    push("explained of the squared tip error", found.explained.as_ref().map(percent), "%");
    push(
        "  of its change from pose to pose",
        found.explained_of_variation.as_ref().map(percent),
        "%",
    );
    push(
        "  of the squared angle error",
        summary.angle_deg.as_ref().and_then(|a| a.explained.as_ref().map(percent)),
        "%",
    );
    push("predictions fit best times", found.slope.as_ref().map(|i| interval(i, 1.0, 2)), "");
    if let Some(bias) = &found.bias {
        let mean = bias.mean;
        let half = bias.half_width;
        for (k, axis) in ["x", "y", "z"].into_iter().enumerate() {
            let around = half.map_or_else(String::new, |h| format!(" ± {:.3}", h[k]));
            push(&format!("mean difference {axis}"), Some(format!("{:.3}{around}", mean[k])), "mm");
        }
        push(
            "  chance of so much without a bias",
            bias.p.map(|p| if p < 1e-4 { "< 0.0001".to_owned() } else { format!("{p:.4}") }),
            "",
        );
    }
    if let Some(limits) = &found.lengths {
        push("measured minus predicted length, mean", Some(interval(&limits.bias, 1.0, 3)), "mm");
        push("  lower limit of agreement", Some(interval(&limits.lower, 1.0, 3)), "mm");
        push("  upper limit of agreement", Some(interval(&limits.upper, 1.0, 3)), "mm");
    }
    if let Some(noise) = &summary.noise {
        push("uncertainty that the room states, RMS", Some(format!("{:.3}", noise.rms_mm)), "mm");
        let accepted = noise.accepted.map_or_else(String::new, |[low, high]| {
            format!(" (nothing else: {low:.2} to {high:.2})")
        });
        push(
            "  squared difference in its units",
            Some(format!("{:.2}{accepted}", noise.normalised)),
            "",
        );
    }
    rows.extend(
        summary.room_misfit_rms_mm.map(|off| mm("misfit of the room's model at the tip, RMS", off)),
    );
    rows
}

fn interval(found: &Interval, times: f64, digits: usize) -> String {
    let shown = |value: f64| format!("{:.digits$}", times * value);
    match found.low.zip(found.high) {
        Some((low, high)) => format!("{} ({} to {})", shown(found.value), shown(low), shown(high)),
        None => shown(found.value),
    }
}

/// What the figures depend on that the recording does not state.
fn assumptions(recorded: &Recorded) -> Vec<String> {
    let weight_mm = recorded.orientation_weight.value_mm;
    let is_whole = !matches!(recorded.source, Some(BodySource::Sensors { .. }));
    let mut assumed = Vec::new();
    if is_whole {
        assumed.push(format!(
            "Assumed: the tracker computes the tool's pose from its sensors by a least-squares fit, an axis weighing \
             {weight_mm:.0} mm, with the sensors where the design has them."
        ));
    }
    if recorded.pivot.is_some() {
        assumed.push(
            "What a pivot calibration takes up, a shift and the tip's place on the tool, is out of both; true poses are \
             those that would read as recorded."
                .to_owned(),
        );
    }
    assumed
}
