//! The command line: one file a subcommand, each a function that a test can call.

mod as_is;
mod characterize;
mod choose;
mod compare;
mod compensate;
mod convert;
mod distort;
#[cfg(feature = "editor")]
mod edit;
mod expected;
mod export;
mod file_kinds;
mod fit;
mod generator;
mod import;
mod jitter;
mod live;
mod model_kind;
mod named_design;
mod numbers;
mod output;
mod pivot;
mod precision;
mod procedure;
mod register;
#[cfg(feature = "editor")]
mod render;
#[cfg(feature = "editor")]
mod render_video;
mod report;
mod select;
mod simulate;
mod stability;
mod tolerances;
mod tool_reader;
mod tool_report;
mod uncertainty;
mod verify;

use anyhow::Context;
use clap::{ArgMatches, Args, Command, CommandFactory, FromArgMatches, Parser, Subcommand};
use std::path::PathBuf;
use trackwright_project::Files;

/// Designs electromagnetically tracked surgical tools: simulates how far off a tool's tip is in a
/// measured, distorted field, and lets sensors be dragged while the error follows
#[derive(Debug, Parser)]
#[command(version, args_conflicts_with_subcommands = true)]
pub struct Cli {
    /// Design to open in the editor (*.design.ron); the built-in one where none is named
    design: Option<PathBuf>,

    /// Write over documents that other programs or commands wrote; a file that the command reads is
    /// never written over
    #[arg(long, global = true)]
    overwrite: bool,

    /// Print what is drawn and computed, and the figures shown, to standard error
    #[arg(long)]
    explain: bool,

    /// Measure what a hand waits for in the editor, in a window that closes by itself, and print it
    #[cfg(feature = "editor")]
    #[arg(long, conflicts_with_all = ["design", "explain"])]
    measure: bool,
}

/// The table of subcommands: a line each.
fn subcommands() -> Vec<Registered> {
    vec![
        command(
            "fit",
            "Fit a distortion model to measurements and write it as an environment",
            fit::run,
        ),
        group(
            "generator",
            "Learn the field generator of a tracker from its measurements",
            generator::run,
        ),
        command(
            "select",
            "Cross-validate model sizes and regularisation on measurements, and name the best",
            select::run,
        ),
        command(
            "distort",
            "Distort poses as the tracker of an environment would measure them",
            distort::run,
        ),
        command(
            "compensate",
            "Correct measured poses by the map of an environment, or by the inverse of it",
            compensate::run,
        ),
        command(
            "simulate",
            "Simulate a design at one pose, over its range of motion, or at given poses",
            simulate::run,
        ),
        command(
            "compare",
            "Hold designs against each other in one room or several, and say which differences are more than the room's uncertainty and the sampling of the motion",
            compare::run,
        ),
        command(
            "procedure",
            "Say where a design stands in the design procedure: the CRF alone, the tool, the built tool, each in its rooms and against its requirement; and keep what is decided in the design",
            procedure::run,
        ),
        command(
            "precision",
            "Measure error against run time, for every way of computing the same thing",
            precision::run,
        ),
        group("import", "Make a measurement table from another program's files", import::run),
        command(
            "convert",
            "Convert a tool definition of a tracker's maker to a body file, back, or to another maker's",
            convert::run,
        ),
        command(
            "characterize",
            "Make a room's measurements from recordings of the tracker beside those of a reference tracker",
            characterize::run,
        ),
        command(
            "pivot",
            "Find where a tool's tip is from recordings around one point, and which way its shaft points from recordings of turns about it, or say why they don't tell",
            pivot::run,
        ),
        command(
            "verify",
            "Hold recordings of the built tool against what its design predicts for the same poses",
            verify::run,
        ),
        command(
            "register",
            "Register points in two frames, and say how far off other points are to be expected",
            register::run,
        ),
        group(
            "export",
            "Write the field of an environment, or poses, as files for 3D Slicer, ParaView or a spreadsheet",
            export::run,
        ),
        command(
            "live",
            "Receive a tracker's poses over OpenIGTLink, compensate each, record them and serve them on",
            live::run,
        ),
        command(
            "tolerances",
            "Print where a design's sensors are to be built, and how far off each may be before the requirement fails",
            tolerances::run,
        ),
        command(
            "report",
            "Write a design's report: one HTML page that holds all it shows, to open, mail and print",
            report::run,
        ),
        command(
            "stability",
            "Check the program's own numbers in stiff and extreme cases against 192 bits, for some minutes; exit status 1 where a bound is broken",
            stability::run,
        ),
        #[cfg(feature = "editor")]
        command("render", "Draw a design's 3D view to a PNG file, without a window", render::run),
    ]
}

/// How a command that did its work ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ending {
    Done,
    /// It did what was asked, and the answer is that something does not hold.
    DoesNotHold,
}

impl From<()> for Ending {
    fn from((): ()) -> Self {
        Self::Done
    }
}

type Run = Box<dyn Fn(&ArgMatches, &Files) -> anyhow::Result<Ending>>;

/// A subcommand: its arguments, and what it does.
struct Registered {
    command: Command,
    run: Run,
}

/// A subcommand with arguments.
fn command<A: Args + 'static, E: Into<Ending> + 'static>(
    name: &'static str,
    about: &'static str,
    run: fn(&A, &Files) -> anyhow::Result<E>,
) -> Registered {
    Registered { command: A::augment_args(Command::new(name)).about(about), run: parsed(run) }
}

/// A subcommand that has further ones.
fn group<S: Subcommand + 'static, E: Into<Ending> + 'static>(
    name: &'static str,
    about: &'static str,
    run: fn(&S, &Files) -> anyhow::Result<E>,
) -> Registered {
    let command = S::augment_subcommands(Command::new(name)).about(about);
    let command = command.subcommand_required(true).arg_required_else_help(true);
    Registered { command, run: parsed(run) }
}

fn parsed<A: FromArgMatches + 'static, E: Into<Ending> + 'static>(
    run: fn(&A, &Files) -> anyhow::Result<E>,
) -> Run {
    Box::new(move |matches, files| Ok(run(&A::from_arg_matches(matches)?, files)?.into()))
}

/// Starts the threads that all computing shares, one a core or as many as `RAYON_NUM_THREADS` says.
/// Left to itself the pool would be made at its first use, and panic where the system has no more.
///
/// # Errors
/// Threads that the system does not give, and a pool that is there already.
fn start_threads() -> anyhow::Result<()> {
    rayon::ThreadPoolBuilder::new()
        .build_global()
        .context("the threads to compute with cannot be started; RAYON_NUM_THREADS=1 asks for one")
}

/// Runs what the command line asks for; one that asks for nothing ends the program with its usage.
///
/// # Errors
/// Whatever the command cannot do, as one readable message.
pub fn run() -> anyhow::Result<Ending> {
    let registered = subcommands();
    let all = registered.iter().map(|own| own.command.clone());
    let matches = Cli::command().subcommands(all).get_matches();
    let cli = Cli::from_arg_matches(&matches)?;
    start_threads()?;
    let files = &Files::overwriting(cli.overwrite);
    let Some((name, matches)) = matches.subcommand() else {
        #[cfg(feature = "editor")]
        if cli.measure {
            return Ok(edit::measure()?.into());
        }
        return Ok(open_editor(&cli, files)?.into());
    };
    let asked = registered.iter().find(|own| own.command.get_name() == name);
    (asked.with_context(|| format!("no command {name}"))?.run)(matches, files)
}

/// Opens the editor; where there can be none, says why in one line and does the main job.
fn open_editor(cli: &Cli, files: &Files) -> anyhow::Result<()> {
    #[cfg(feature = "editor")]
    let missing = match edit::run(cli.design.as_deref(), cli.explain)? {
        edit::Opened::Closed => return Ok(()),
        edit::Opened::Missing(missing) => missing,
    };
    #[cfg(not(feature = "editor"))]
    let missing = "this program was built without the editor";
    output::note(&format!("no editor: {missing}; simulating the design instead"));
    simulate::main_job(cli.design.as_deref(), files)
}

/// Prints why a command failed.
pub fn report(error: &anyhow::Error) {
    output::note(&format!("error: {error:#}"));
}
