//! `simulate`: the paper's three modes, with summary statistics and a log.

use super::named_design::{named_or_builtin, note_sizes};
use super::prelude::*;
use super::study::run_study;
use super::uncertainty::UncertaintyArgs;
use clap::ValueEnum;
use trackwright_calibration::doubts;
use trackwright_design::BodyRole;
use trackwright_field::samples::MapKind;
use trackwright_project::World;
use trackwright_result::{Section, data};
use trackwright_simulation::support::SupportSurvey;
use trackwright_simulation::{self, Mode, Scenario, coil_section};

/// Simulate a design at one pose, over its range of motion, or at given poses
#[derive(Debug, Args)]
pub struct SimulateArgs {
    /// Design (*.design.ron), or the name of a built-in one
    design: PathBuf,

    /// Which poses to visit; those of --input where it is given
    #[arg(long, value_enum, required_unless_present = "input")]
    mode: Option<ModeArg>,

    /// Whose study: the tool's in the CRF, or the CRF's alone against the tracker, judged at each of
    /// its targets, with its own range of motion and requirement
    #[arg(long, value_parser = BODY, default_value = "tool")]
    body: BodyRole,

    /// Poses for `--mode input` (CSV): crf_x … crf_qz in the tracker frame, tool_x … tool_qz in the CRF frame
    #[arg(long, required_if_eq("mode", "input"), value_name = "FILE")]
    input: Option<PathBuf>,

    #[command(flatten)]
    as_is: AsIsArgs,

    /// Table to write, one row a trial
    #[arg(long, value_name = "OUT.csv")]
    log: Option<PathBuf>,

    /// What happens to sensors outside the model's box; rejected trials are left out and counted
    #[arg(long, value_parser = OUTSIDE, default_value = "clamp")]
    outside: OutsidePolicy,

    /// Count the trials that lean on field which the environment's samples do not support, and add
    /// the predicted standard errors of the field at the sensors
    #[arg(long)]
    support: bool,

    /// Print the paper's simulation as well: all figures with the room's model taken for its field
    #[arg(long)]
    room_field: bool,

    #[command(flatten)]
    uncertainty: UncertaintyArgs,

    /// Print what was computed, what was used again and what the design spared, to standard error
    #[arg(long)]
    explain: bool,

    /// How to print the figures
    #[arg(long, value_enum, default_value_t)]
    format: Format,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(super) enum ModeArg {
    /// The design's own pose
    Single,
    /// The design's range of motion
    Motion,
    /// Poses from a file
    Input,
}

const BODY: Choice<BodyRole> = Choice(&[
    ("tool", "In the CRF, or in the tracker's frame where the design has none", BodyRole::Tool),
    ("crf", "Alone against the tracker", BodyRole::Crf),
]);

/// Simulates, writes the log, and prints the figures.
///
/// # Errors
/// Files that can't be used, a range of motion that can't be visited.
pub fn run(args: &SimulateArgs, files: &Files) -> anyhow::Result<()> {
    let required = required_mode(args)?;
    if args.body == BodyRole::Crf {
        return run_crf(args, required, files);
    }
    let log = files.optional_output(args.log.as_deref())?;
    // With its meshes, for whether coils fit: no figure depends on them.
    let world = files.open_design(&args.design)?;
    let mode = mode_of(files, required, args.input.as_deref(), &world, args.as_is)?;
    let design = world.document.design();
    let environment = args.uncertainty.environment(&world.environment)?;
    let mut scenario = trackwright_project::resolve(design, &environment);
    scenario.outside = args.outside;
    let named = || args.design.display().to_string();
    args.uncertainty.check(&scenario, &mode).with_context(named)?;
    note_world(&world);
    let uncertainty = args
        .uncertainty
        .report(&scenario, design.orientation_weight_mm, &mode)
        .with_context(named)?;
    // Before the log is written: an environment without that data is an error.
    let survey = args.support.then(|| survey(&scenario, &mode).with_context(named)).transpose()?;
    let report = run_study(BodyRole::Tool, (&scenario, &mode), log.as_ref()).with_context(named)?;
    if args.explain {
        for line in trackwright_simulation::explain(&scenario, &report.study) {
            output::note(&line.to_string());
        }
        for line in
            world.metal_report().into_iter().flat_map(trackwright_report::words::metal_lines)
        {
            output::note(&format!("metal: {line}"));
        }
    }
    let uncertainty = uncertainty.map(|found| found.section(&report.study.room_field));
    let coils = trackwright_project::coil_findings(&world);
    let section = report
        .section((&scenario, &mode), args.room_field)
        .headed(title(&world))
        .with_all(uncertainty.map(|section| section.named("uncertainty")))
        .with_all(survey.as_ref().map(SupportSurvey::section))
        .with(coil_section(&coils));
    output::print_section(args.format, &section)
}

/// `--body crf`: the CRF alone at each of its targets, step 2 of the paper's design procedure.
fn run_crf(args: &SimulateArgs, required: ModeArg, files: &Files) -> anyhow::Result<()> {
    let (file, named) = (args.design.display(), || args.design.display().to_string());
    let world = files.open_design_without_meshes(&args.design)?;
    let design = world.document.design();
    let Some(crf) = &design.crf else {
        anyhow::bail!("{file}: the design has no CRF to simulate");
    };
    let mode = match required {
        ModeArg::Single => Mode::Single,
        ModeArg::Motion if crf.motion.is_none() => {
            anyhow::bail!("{file}: crf.motion is absent, expected the CRF's own range of motion");
        }
        ModeArg::Motion => Mode::Motion,
        ModeArg::Input => anyhow::bail!("--body crf takes --mode single or motion, not input"),
    };
    for (is_given, flag) in [
        (args.log.is_some(), "--log"),
        (args.support, "--support"),
        (args.explain, "--explain"),
        (args.uncertainty.is_requested(), "--uncertainty"),
    ] {
        if is_given {
            anyhow::bail!("{flag} is of the tool's study, not of the CRF's");
        }
    }
    note_world(&world);
    let mut all = Section::of([data("crf", &crf.body.rigid.name)]);
    for study in trackwright_project::resolve_crf(design, &world.environment) {
        let mut scenario = study.scenario;
        scenario.outside = args.outside;
        let of = (&scenario, &mode);
        let report = run_study(args.body, of, None).with_context(named)?;
        let at = match &study.target {
            Some(target) => format!(" at {target}"),
            None => String::new(),
        };
        let name = &crf.body.rigid.name;
        let title = output::head(&format!("{name}{at}, alone"), &world.environment.name);
        let section = report.section(of, args.room_field).headed(title);
        all = all.with(section.with(data("target", &study.target)).named("targets[]"));
    }
    output::print_section(args.format, &all)
}

fn required_mode(args: &SimulateArgs) -> anyhow::Result<ModeArg> {
    mode_arg(args.mode, args.input.as_deref())?.context("expected --mode single, motion or input")
}

/// The requested mode; a table of poses implies its own.
///
/// # Errors
/// A table beside another mode, which would not look at it.
pub(super) fn mode_arg(
    mode: Option<ModeArg>,
    input: Option<&Path>,
) -> anyhow::Result<Option<ModeArg>> {
    match (mode, input) {
        (None, Some(_)) => Ok(Some(ModeArg::Input)),
        (Some(mode), Some(file)) if mode != ModeArg::Input => {
            anyhow::bail!(
                "--input {}: found another --mode, expected --mode input or none",
                file.display()
            )
        }
        (mode, _) => Ok(mode),
    }
}

/// The mode with its poses.
///
/// # Errors
/// Input data without a table, or with one that can't be used.
pub(super) fn mode_of(
    files: &Files,
    mode: ModeArg,
    input: Option<&Path>,
    world: &World,
    as_is: AsIsArgs,
) -> anyhow::Result<Mode> {
    Ok(match (mode, input) {
        (ModeArg::Single, _) => Mode::Single,
        (ModeArg::Motion, _) => Mode::Motion,
        (ModeArg::Input, Some(file)) => {
            let scenario =
                trackwright_project::resolve(world.document.design(), &world.environment);
            let input = files.read_input(file, scenario.crf.is_some())?;
            let trials = as_is.take(input.and(|trials| doubts::of_input(trials, &scenario)))?;
            Mode::Input(trials.into())
        }
        (ModeArg::Input, None) => anyhow::bail!("--mode input needs --input FILE"),
    })
}

/// What the program does where there can be no editor: the design's own study, printed.
///
/// # Errors
/// As [`run`].
pub fn main_job(design: Option<&Path>, files: &Files) -> anyhow::Result<()> {
    let world = named_or_builtin(files, design)?;
    let scenario = trackwright_project::resolve(world.document.design(), &world.environment);
    let mode = if scenario.motion.is_some() { Mode::Motion } else { Mode::Single };
    let of = (&scenario, &mode);
    let section = run_study(BodyRole::Tool, of, None)?.section(of, false);
    output::print_section(Format::Text, &section.headed(title(&world)))
}

/// What a person has to know of a design before its figures: a body of a size that no instrument has,
/// and a model of the measured pose, with which simulating is the paper's shortcut.
pub(super) fn note_world(world: &World) {
    note_sizes(world.document.design());
    if world.environment.model.map() == MapKind::Correction {
        output::note(
            "note: the environment is a correction map, a function of the measured pose; \
             it is used as a distortion map",
        );
    }
}

/// Looks up the support of all sensors, with progress.
fn survey(scenario: &Scenario, mode: &Mode) -> anyhow::Result<SupportSurvey> {
    let shown = Shown::new("looking up support");
    Ok(trackwright_simulation::survey(scenario, mode, &shown.task)?)
}

/// What the figures are of.
fn title(world: &World) -> String {
    let design = world.document.design();
    output::head(&design.name, &world.environment.name)
}
