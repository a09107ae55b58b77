//! `sweep`: many designs in many rooms, as a table that any number of workers compute.

mod merge;
mod numbers;
mod plot;
mod status;
mod submit;

use super::prelude::*;
use clap::{Subcommand, ValueEnum};
use std::time::Instant;
use trackwright_sweep::{Folder, Part, Sweep, SweepError};

/// Simulate many designs in many rooms: every point of a plan is a row of a table, written in shards that
/// any number of workers share
#[derive(Debug, Args)]
#[command(args_conflicts_with_subcommands = true, subcommand_negates_reqs = true)]
pub struct SweepArgs {
    /// Plan (*.sweep.ron): designs, rooms, the numbers that vary, motions and figures
    #[arg(required = true)]
    plan: Option<PathBuf>,

    /// Folder for the shards; what is there of the same plan is kept
    #[arg(short, long, required = true, value_name = "FOLDER")]
    output: Option<PathBuf>,

    /// Compute one of N equal parts of the rows, K from 1 to N
    #[arg(long, value_name = "K/N", default_value = "1/1")]
    shard: Part,

    /// Have a cluster compute what is missing, and merge the rows then
    #[arg(long, value_enum, conflicts_with = "shard")]
    submit: Option<Engine>,

    #[command(flatten)]
    cluster: submit::ClusterArgs,

    /// How to print what was done
    #[arg(long, value_enum, default_value_t)]
    format: Format,

    #[command(subcommand)]
    then: Option<SweepCommand>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Engine {
    /// A job array with a merge that depends on it, by sbatch
    Slurm,
}

#[derive(Debug, Subcommand)]
enum SweepCommand {
    /// Write all rows of a sweep's folder to one file, in order
    Merge(merge::MergeArgs),
    /// Print which rows of a sweep's folder are there, and what a cluster is doing about the others
    Status(status::StatusArgs),
    /// Draw the rows of a sweep: parallel coordinates, what each number does, and the best rows
    Plot(plot::PlotArgs),
    /// List the numbers of a design that a plan may vary, by their paths
    Numbers(numbers::NumbersArgs),
}

/// Computes the rows that are missing, or does what is requested of them.
///
/// # Errors
/// A plan or files that can't be used, another plan's folder, a disk that is full.
pub fn run(args: &SweepArgs, files: &Files) -> anyhow::Result<Ending> {
    let done = match &args.then {
        Some(SweepCommand::Merge(args)) => merge::run(args, files),
        Some(SweepCommand::Status(args)) => status::run(args),
        Some(SweepCommand::Plot(args)) => plot::run(args, files),
        Some(SweepCommand::Numbers(args)) => numbers::run(args, files),
        None => return compute(args),
    };
    done.map(Ending::from)
}

fn compute(args: &SweepArgs) -> anyhow::Result<Ending> {
    let (Some(plan), Some(output)) = (&args.plan, &args.output) else {
        bail!("expected a plan and -o FOLDER");
    };
    let sweep = Sweep::open(plan)?;
    for problem in sweep.problems() {
        output::note(&format!("warning: {problem}; all its rows will state it"));
    }
    let folder = Folder::open(output, &sweep)?;
    if args.submit == Some(Engine::Slurm) {
        return submit::run(&args.cluster, &sweep, &folder, args.format).map(Ending::from);
    }
    let started = Instant::now();
    let shown = Shown::new("rows");
    let cancel = shown.task.cancel.clone();
    ctrlc::set_handler(move || cancel.cancel()).context("Ctrl+C cannot be listened for")?;
    let report = trackwright_sweep::run(&sweep, &folder, args.shard, &shown.task, &output::note);
    drop(shown);
    if let Err(SweepError::Cancelled(cancelled)) = report {
        output::note(&format!("{cancelled}: the rows that are computed are written"));
        return Ok(Ending::Interrupted);
    }
    let seconds = started.elapsed().as_secs_f64();
    output::print_section(args.format, &report?.section(Some(seconds)))?;
    Ok(Ending::Done)
}
