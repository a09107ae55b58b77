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
mod fit;
mod generator;
mod import;
mod jitter;
mod kinds;
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
use clap::{Parser, Subcommand};
use std::path::PathBuf;
use trackwright_project::Files;

/// Designs electromagnetically tracked surgical tools: simulates how far off a tool's tip is in a
/// measured, distorted field, and lets sensors be dragged while the error follows
#[derive(Debug, Parser)]
#[command(version, args_conflicts_with_subcommands = true)]
pub struct Cli {
    #[command(subcommand)]
    command: Option<Command>,

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

#[derive(Debug, Subcommand)]
enum Command {
    /// Fit a distortion model to measurements and write it as an environment
    Fit(fit::FitArgs),
    /// Learn the field generator of a tracker from its measurements
    #[command(subcommand)]
    Generator(generator::GeneratorCommand),
    /// Cross-validate model sizes and regularisation on measurements, and name the best
    Select(select::SelectArgs),
    /// Distort poses as the tracker of an environment would measure them
    Distort(distort::DistortArgs),
    /// Correct measured poses by the map of an environment, or by the inverse of it
    Compensate(compensate::CompensateArgs),
    /// Simulate a design at one pose, over its range of motion, or at given poses
    Simulate(simulate::SimulateArgs),
    /// Hold designs against each other in one room or several, and say which differences are more than the
    /// room's uncertainty and the sampling of the motion
    Compare(compare::CompareArgs),
    /// Say where a design stands in the design procedure: the CRF alone, the tool, the built tool, each in
    /// its rooms and against its requirement; and keep what is decided in the design
    Procedure(procedure::ProcedureArgs),
    /// Measure error against run time, for every way of computing the same thing
    Precision(precision::PrecisionArgs),
    /// Make a measurement table from another program's files
    #[command(subcommand)]
    Import(import::ImportCommand),
    /// Convert a tool definition of a tracker's maker to a body file, back, or to another maker's
    Convert(convert::ConvertArgs),
    /// Make a room's measurements from recordings of the tracker beside those of a reference tracker
    Characterize(characterize::CharacterizeArgs),
    /// Find where a tool's tip is from recordings around one point, and which way its shaft points from
    /// recordings of turns about it, or say why they don't tell
    Pivot(pivot::PivotArgs),
    /// Hold recordings of the built tool against what its design predicts for the same poses
    Verify(verify::VerifyArgs),
    /// Register points in two frames, and say how far off other points are to be expected
    Register(register::RegisterArgs),
    /// Write the field of an environment, or poses, as files for 3D Slicer, ParaView or a spreadsheet
    #[command(subcommand)]
    Export(export::ExportCommand),
    /// Hear a tracker's poses over OpenIGTLink, compensate each, record them and serve them on
    Live(live::LiveArgs),
    /// Print where a design's sensors are to be built, and how far off each may be before the
    /// requirement fails
    Tolerances(tolerances::TolerancesArgs),
    /// Write a design's report: one HTML page that holds all it shows, to open, mail and print
    Report(report::ReportArgs),
    /// Check the program's own numbers in stiff and extreme cases against 192 bits, for some
    /// minutes; exit status 1 where a bound is broken
    Stability(stability::StabilityArgs),
    /// Draw a design's 3D view to a PNG file, without a window
    #[cfg(feature = "editor")]
    Render(render::RenderArgs),
}

/// How a command that did its work ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ending {
    Done,
    /// It did what was asked, and the answer is that something does not hold.
    DoesNotHold,
}

/// Starts the threads that all computing shares, one a core or as many as `RAYON_NUM_THREADS` says.
/// Left to itself the pool would be made at its first use, and panic where the system has no more.
///
/// # Errors
/// Threads that the system does not give, and a pool that is there already.
pub fn start_threads() -> anyhow::Result<()> {
    rayon::ThreadPoolBuilder::new()
        .build_global()
        .context("the threads to compute with cannot be started; RAYON_NUM_THREADS=1 asks for one")
}

/// Runs what the command line asks for.
///
/// # Errors
/// Whatever the command cannot do, as one readable message.
pub fn run(cli: &Cli) -> anyhow::Result<Ending> {
    let files = &Files::overwriting(cli.overwrite);
    match &cli.command {
        Some(Command::Stability(args)) => return stability::run(args, files),
        Some(Command::Tolerances(args)) => return tolerances::run(args, files),
        Some(Command::Convert(args)) => return convert::run(args, files),
        Some(Command::Fit(args)) => fit::run(args, files),
        Some(Command::Generator(command)) => generator::run(command, files),
        Some(Command::Select(args)) => select::run(args, files),
        Some(Command::Distort(args)) => distort::run(args, files),
        Some(Command::Compensate(args)) => compensate::run(args, files),
        Some(Command::Simulate(args)) => simulate::run(args, files),
        Some(Command::Compare(args)) => compare::run(args, files),
        Some(Command::Procedure(args)) => procedure::run(args, files),
        Some(Command::Precision(args)) => precision::run(args, files),
        Some(Command::Import(command)) => import::run(command, files),
        Some(Command::Characterize(args)) => characterize::run(args, files),
        Some(Command::Pivot(args)) => pivot::run(args, files),
        Some(Command::Verify(args)) => verify::run(args, files),
        Some(Command::Register(args)) => register::run(args, files),
        Some(Command::Export(command)) => export::run(command, files),
        Some(Command::Live(args)) => live::run(args, files),
        Some(Command::Report(args)) => report::run(args, files),
        #[cfg(feature = "editor")]
        Some(Command::Render(args)) => render::run(args, files),
        #[cfg(feature = "editor")]
        None if cli.measure => edit::measure(),
        None => open_editor(cli, files),
    }?;
    Ok(Ending::Done)
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
