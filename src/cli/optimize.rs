//! `optimize`: the best places for a design's sensors, and how much is gained.

mod arguments;

use super::compare::named_once;
use super::named_design::note_sizes;
use super::numbers::above_zero;
use super::prelude::*;
use arguments::{bounds, kind, metric, sensors};
use std::ops::RangeInclusive;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{RecvTimeoutError, Sender, channel};
use std::time::{Duration, Instant};
use trackwright_field::Environment;
use trackwright_field::samples::MapKind;
use trackwright_optimization::{
    BuiltError, Goal, Moves, Optimized, OverRooms, Problem, Progress, SensorChoice, Settings,
    optimize,
};
use trackwright_project::{MOST_SETS, MoveBounds, World, named_moves, sets_of_sensors};
use trackwright_report::optimization_section::{FoundPlaces, objective_text, with_layout};
use trackwright_simulation::{CancelToken, Metric};

/// Find the best places for a design's sensors within what can be built, write the design that has
/// them, and report how much is gained
#[derive(Debug, Args)]
pub struct OptimizeArgs {
    /// Design (*.design.ron), or the name of a built-in one
    design: PathBuf,

    /// Design to write (*.design.ron), with bodies that changed beside it. Where nothing better was
    /// found it has the places of the first
    #[arg(short, long, value_name = "BETTER.design.ron")]
    output: PathBuf,

    /// What may move, with commas: tool or crf (all sensors of a body), generator or crf-pose (where it
    /// is), or names of sensors, the tool's before the CRF's; all sensors of the tool where left out
    #[arg(long = "move", value_name = "tool,crf,generator,crf-pose,NAME…", value_delimiter = ',')]
    moves: Vec<String>,

    /// How many sensors the tool may have, or the CRF where none of the tool's moves; as many as it has
    /// where left out
    #[arg(long, value_name = "N|MIN-MAX", value_parser = sensors)]
    sensors: Option<RangeInclusive<usize>>,

    /// A kind of sensor that may be used: 5 or 6 degrees of freedom, what one costs, and the size of its
    /// coil in mm; repeat for each. Sensors keep their kinds where left out
    #[arg(long, value_name = "DOF:COST[:DIAMETERxLENGTH]", value_parser = kind)]
    kind: Vec<SensorChoice>,

    /// Figure that is made least, such as position_rms; where left out the largest part of a limit, of
    /// the design's requirement
    #[arg(long, value_name = "KEY", value_parser = metric)]
    metric: Option<Metric>,

    /// Rooms (*.env.ron) that count; the design's own and its further ones where left out
    #[arg(long, value_name = "FILE", num_args = 1..)]
    environment: Vec<PathBuf>,

    /// How several rooms count
    #[arg(long, value_parser = ROOMS, default_value = "worst")]
    rooms: OverRooms,

    /// How far the field generator may be moved along each of its axes and turned; 50,10 where left out
    #[arg(long, value_name = "MM,DEG", value_parser = bounds, allow_hyphen_values = true)]
    generator_bounds: Option<(f64, f64)>,

    /// How far the CRF may be moved on the patient along each of its axes and turned; where left out 20,10,
    /// or as far as the patch goes that the anatomy states
    #[arg(long, value_name = "MM,DEG", value_parser = bounds, allow_hyphen_values = true)]
    crf_bounds: Option<(f64, f64)>,

    /// Standard deviations of where a built sensor is along each axis and of how it is turned, which count as
    /// well; 0,0 for sensors that are exactly where they are drawn
    #[arg(long, value_name = "MM,DEG", value_parser = bounds, allow_hyphen_values = true,
        default_value = "0.2,0.3")]
    built_error: (f64, f64),

    /// End the search after this time with the best so far
    #[arg(long, value_name = "S", default_value_t = 30.0, value_parser = above_zero)]
    seconds: f64,

    /// Seed of the search: the same seed finds the same places, unless the time ends the search
    #[arg(long, default_value_t = 0)]
    seed: u64,

    /// How to print what was found
    #[arg(long, value_enum, default_value_t)]
    format: Format,
}

const ROOMS: Choice<OverRooms> = Choice(&[
    ("worst", "The room that is worst for a layout", OverRooms::Worst),
    ("mean", "The mean over all rooms", OverRooms::Mean),
]);

/// Searches, writes the better design, and prints the gain.
///
/// # Errors
/// Files that can't be used, names of nothing that moves, no figure to make least, regions without a
/// place for a coil.
pub fn run(args: &OptimizeArgs, files: &Files) -> anyhow::Result<()> {
    let named = || args.design.display().to_string();
    let output = files.output(&args.output)?;
    named_once(&args.environment, "environment")?;
    let world = files.open_design(&args.design)?;
    output.expect_own()?;
    trackwright_project::check_place(&args.output)?;
    let rooms = rooms(args, files, &world)?;
    note_problems(&world, &rooms);
    let moves = moves(args, &world).with_context(named)?;
    let goal = goal(args, &world).with_context(named)?;
    let (position_mm, angle_deg) = args.built_error;
    let built = BuiltError { position_mm, angle_deg }.unless_exact();
    let problem = trackwright_project::placement_problem(&world, &rooms, moves, goal, args.rooms);
    let problem = Problem { built, ..problem };
    let (optimized, seconds) = search(args, &problem).with_context(named)?;
    let better = with_layout(&world, &optimized.best).with_context(named)?;
    // It may have appeared, or been changed, during the search.
    output.expect_own()?;
    let mut saved = if optimized.is_better { better.clone() } else { world.clone() };
    let report = trackwright_project::save_as(&mut saved, &args.output)?;
    let here = |file: &PathBuf| file.strip_prefix(".").unwrap_or(file).display().to_string();
    let written = report.written.iter().map(here).collect();
    let found = FoundPlaces { world, better, rooms, problem, optimized, seconds, written };
    let section = found.section();
    let section = match args.format {
        Format::Json => {
            section.with_all(found.studies(&CancelToken::default()).with_context(named)?)
        }
        Format::Text => section.with(format!("written: {}", found.written.join(", "))),
    };
    output::print_section(args.format, &section)
}

fn rooms(
    args: &OptimizeArgs,
    files: &Files,
    world: &World,
) -> anyhow::Result<Vec<Arc<Environment>>> {
    if args.environment.is_empty() {
        return Ok(trackwright_project::design_rooms(files, world)?);
    }
    let read = trackwright_project::read_compared_rooms(files, &args.environment)?;
    Ok(read.rooms.into_iter().map(|room| room.environment).collect())
}

/// What a person has to know of design and rooms before places are looked for.
fn note_problems(world: &World, rooms: &[Arc<Environment>]) {
    note_sizes(world.document.design());
    for problem in world.mesh_problems() {
        output::note(&format!("note: {problem}; sensors find no place on its surface"));
    }
    for doubt in world.mesh_doubts() {
        output::note(&format!("warning: {doubt}"));
    }
    for room in rooms.iter().filter(|room| room.model.map() == MapKind::Correction) {
        output::note(&format!(
            "note: {} is a correction map, a function of the measured pose; it is used as a distortion map",
            room.name
        ));
    }
}

/// # Errors
/// Names of nothing, bounds of what does not move.
fn moves(args: &OptimizeArgs, world: &World) -> anyhow::Result<Moves> {
    let names: Vec<String> = args.moves.iter().map(|name| name.trim().to_owned()).collect();
    let design = world.document.design();
    let bounds = MoveBounds::of(design, args.generator_bounds, args.crf_bounds);
    let moves = named_moves(design, &names, bounds).context("--move")?;
    for (option, is_given, name, is_moving) in [
        (
            "--generator-bounds",
            args.generator_bounds.is_some(),
            "generator",
            moves.generator.is_some(),
        ),
        ("--crf-bounds", args.crf_bounds.is_some(), "crf-pose", moves.crf_pose.is_some()),
    ] {
        if is_given && !is_moving {
            bail!("{option} needs --move {name}");
        }
    }
    let has_sensors = !(moves.tool.is_empty() && moves.crf.is_empty());
    if !has_sensors && (args.sensors.is_some() || !args.kind.is_empty()) {
        bail!("--sensors and --kind need sensors that move, expected some in --move");
    }
    let moves = Moves { sensors: args.sensors.clone(), kinds: args.kind.clone(), ..moves };
    let sets = sets_of_sensors(design, &moves);
    if sets > MOST_SETS {
        bail!(
            "--sensors and --kind: found {sets} sets of sensors, expected at most {MOST_SETS}: fewer \
             numbers or kinds"
        );
    }
    Ok(moves)
}

/// # Errors
/// Nothing to make least.
fn goal(args: &OptimizeArgs, world: &World) -> anyhow::Result<Goal> {
    match (args.metric, world.document.design().requirement) {
        (Some(metric), _) => Ok(Goal::Figure(metric)),
        (None, Some(requirement)) if !requirement.is_empty() => Ok(Goal::Requirement(requirement)),
        _ => bail!("found no requirement, expected one in the design, or a figure by --metric"),
    }
}

/// The search with a progress bar, until its end, the end of its time, or Ctrl+C; and how long it took.
///
/// # Errors
/// See [`optimize`].
fn search(args: &OptimizeArgs, problem: &Problem) -> anyhow::Result<(Optimized, f64)> {
    let started = Instant::now();
    let shown = Shown::new("searching");
    let enough = CancelToken::default();
    end_at_signals(enough.clone(), shown.task.cancel.clone())?;
    // Until this is dropped.
    let _timer = end_after(args.seconds, enough.clone())?;
    let settings = Settings { seed: args.seed, ..Settings::default() };
    let mut deliver = |progress: &Progress| {
        shown.set_message(format!(
            "best so far {}",
            objective_text(problem.goal, progress.best.objective)
        ));
    };
    let found = optimize(problem, &settings, &enough, &shown.task, &mut deliver)?;
    IS_OVER.store(true, Ordering::Relaxed);
    Ok((found, started.elapsed().as_secs_f64()))
}

/// Nothing of the search is left to be kept, and what is written is whole or not at all.
static IS_OVER: AtomicBool = AtomicBool::new(false);

#[expect(
    clippy::disallowed_methods,
    reason = "whoever writes may wait for a pipe's reader for ever"
)]
fn give_up() -> ! {
    std::process::exit(super::INTERRUPTED.into())
}

/// The first signal keeps the best so far; another one gives up, and so does one after the search.
fn end_at_signals(enough: CancelToken, cancel: CancelToken) -> anyhow::Result<()> {
    let mut signals = 0;
    ctrlc::set_handler(move || {
        signals += 1;
        match signals {
            _ if IS_OVER.load(Ordering::Relaxed) => give_up(),
            1 => enough.cancel(),
            2 => cancel.cancel(),
            _ => give_up(),
        }
    })
    .context("Ctrl+C cannot be listened for")
}

/// Requests the end once the time is over, unless what it returns is dropped before.
fn end_after(seconds: f64, enough: CancelToken) -> anyhow::Result<Sender<()>> {
    let (alive, ended) = channel();
    let longest = Duration::try_from_secs_f64(seconds).unwrap_or(Duration::MAX);
    std::thread::Builder::new()
        .spawn(move || {
            if ended.recv_timeout(longest) == Err(RecvTimeoutError::Timeout) {
                enough.cancel();
            }
        })
        .context("a thread for --seconds cannot be started")?;
    Ok(alive)
}
