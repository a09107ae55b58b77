//! `export tips`: the tips of a design's study, true and simulated.

use super::super::file_kinds::{AXES, file_kind, refuse_axes};
use super::super::prelude::*;
use super::super::simulate::{ModeArg, mode_arg, mode_of, note_world};
use trackwright_formats::export::PatientAxes;
use trackwright_formats::export::markups::{self, MarkupList, MarkupPoint};
use trackwright_formats::export::tips_table::{self, StudiedTip};
use trackwright_geometry::pose::Pose;
use trackwright_report::palette::{Rgb, SERIES};
use trackwright_simulation::{CancelToken, Trial, trial_count};

/// More points than this make 3D Slicer slow.
const MANY: usize = 5_000;

#[derive(Debug, Args)]
pub struct TipsArgs {
    /// Design (*.design.ron), or the name of a built-in one
    design: PathBuf,

    /// File to write, its kind given by its name: *.mrk.json (two lists of points, LPS) or *.csv;
    /// in the frame of the CRF, or of the tracker where the design has none
    #[arg(short, long, value_name = "OUT")]
    output: PathBuf,

    /// Which poses to visit; the range of motion where the design has one, else its own pose
    #[arg(long, value_enum)]
    mode: Option<ModeArg>,

    /// Poses for `--mode input` (CSV), as `simulate` reads them
    #[arg(long, required_if_eq("mode", "input"), value_name = "FILE")]
    input: Option<PathBuf>,

    /// What happens to sensors outside the model's box; tips of rejected trials are left out
    #[arg(long, value_parser = OUTSIDE, default_value = "clamp")]
    outside: OutsidePolicy,

    /// What 3D Slicer is to take x, y and z for (*.mrk.json)
    #[arg(long, value_parser = AXES, default_value = "ras")]
    axes: PatientAxes,

    #[command(flatten)]
    as_is: AsIsArgs,
}

/// Simulates and writes.
///
/// # Errors
/// Files that can't be used, a range of motion that can't be visited, nothing left to write.
pub fn run(args: &TipsArgs, files: &Files) -> anyhow::Result<()> {
    let output = files.output(&args.output)?;
    let kind = file_kind(&args.output, "tips", &[".mrk.json", ".csv"])?;
    if kind == ".csv" {
        refuse_axes(args.axes, &args.output)?;
    }
    let named = || args.design.display().to_string();
    let world = files.open_design_without_meshes(&args.design)?;
    let mut scenario = trackwright_project::resolve(world.document.design(), &world.environment);
    scenario.outside = args.outside;
    let requested = mode_arg(args.mode, args.input.as_deref())?;
    let mode = requested.unwrap_or(match scenario.motion {
        Some(_) => ModeArg::Motion,
        None => ModeArg::Single,
    });
    let mode = mode_of(files, mode, args.input.as_deref(), &world, args.as_is)?;
    note_world(&world);
    let trials = trial_count(&scenario, &mode);
    let bar = output::progress(trials.unwrap_or(0) as u64, "simulating");
    let tip = scenario.tool.judged_tip_in_body();
    let tool_from_tip = Pose::translation(tip.x, tip.y, tip.z);
    let mut tips = Vec::new();
    let mut index = 0;
    let mut visit = |trial: &Trial| {
        bar.inc(1);
        if !trackwright_simulation::is_rejected(trial, scenario.outside) {
            tips.push(StudiedTip {
                trial: index,
                crf_from_tip: trial.crf_from_tool * tool_from_tip,
                crf_from_tip_simulated: trial.crf_from_tool_simulated * tool_from_tip,
            });
        }
        index += 1;
    };
    let cancel = CancelToken::default();
    let outcome = trackwright_simulation::run(&scenario, &mode, &cancel, Some(&mut visit))
        .with_context(named)?;
    bar.finish_and_clear();
    match kind {
        ".csv" => output.write(|out| tips_table::write(out, &tips))?,
        _ => {
            if tips.len() > MANY {
                output::note(&format!(
                    "{}: {} points in each of two lists, with which 3D Slicer is slow; a *.csv holds as many as you \
                     like",
                    args.output.display(),
                    with_separators(tips.len())
                ));
            }
            let lists = lists(&world.document.design().name, &tips);
            output.write(|out| markups::write_lists(out, &lists, args.axes))?;
        }
    }
    output::note_outside(
        "trials have a sensor",
        outcome.room_field.outside,
        index,
        scenario.outside,
    );
    let frame = match scenario.crf {
        Some(_) => "CRF",
        None => "tracker",
    };
    output::print(&format!(
        "{} tips, true and simulated, written to {}, in the frame of the {frame}; {} trials left out",
        with_separators(tips.len()),
        args.output.display(),
        with_separators(outcome.room_field.rejected)
    ))
}

/// Where the tips are, and where the tracker would report them; a trial has one label in both.
fn lists(design: &str, tips: &[StudiedTip]) -> [MarkupList; 2] {
    [
        list(format!("{design}, true tips"), SERIES[0], tips, |tip| tip.crf_from_tip),
        list(format!("{design}, simulated tips"), SERIES[1], tips, |tip| {
            tip.crf_from_tip_simulated
        }),
    ]
}

fn list(
    name: String,
    Rgb(red, green, blue): Rgb,
    tips: &[StudiedTip],
    pose: impl Fn(&StudiedTip) -> Pose,
) -> MarkupList {
    let point = |tip: &StudiedTip| MarkupPoint {
        // As a person counts trials.
        label: (tip.trial + 1).to_string(),
        tracker_from_point: pose(tip),
    };
    MarkupList { name, color: [red, green, blue], points: tips.iter().map(point).collect() }
}
