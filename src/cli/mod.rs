//! The command line: one file a subcommand, each a function that a test can call.

mod as_is;
mod characterize;
mod choice;
mod choose;
mod compare;
mod compensate;
mod convert;
mod distort;
#[cfg(feature = "editor")]
mod edit;
mod export;
mod file_kinds;
mod fit;
mod generator;
mod import;
mod jitter;
mod live;
mod metal;
mod model_kind;
mod named_design;
mod numbers;
mod optimize;
mod output;
mod pivot;
mod precision;
mod prelude;
mod procedure;
mod protocol;
mod register;
mod registration;
#[cfg(feature = "editor")]
mod render;
#[cfg(feature = "editor")]
mod render_video;
mod report;
mod select;
mod simulate;
mod stability;
mod study;
mod sweep;
mod tolerances;
mod tool_reader;
mod uncertainty;
mod validity;
mod verify;

pub use output::Ending;

/// A signal ended the work early: as a shell reports Ctrl+C.
pub const INTERRUPTED: u8 = 130;

use anyhow::{Context, bail};
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

    /// Write over files that no command wrote, or that somebody has changed since; a file that the command reads is
    /// never written over
    #[arg(long, global = true)]
    overwrite: bool,

    /// Print what is drawn and computed, and the figures shown, to standard error
    #[arg(long)]
    explain: bool,

    /// With --explain, print name and place of each control too, for scripts that operate the window
    #[cfg(feature = "editor")]
    #[arg(long, requires = "explain")]
    controls: bool,

    /// Measure what a hand waits for in the editor, in a window that closes by itself, and print it
    #[cfg(feature = "editor")]
    #[arg(long, conflicts_with_all = ["design", "explain"])]
    measure: bool,
}

/// The table of subcommands: a line each. What a command is for is the first comment of its arguments.
fn subcommands() -> Vec<Registered> {
    vec![
        command("fit", fit::run),
        group("generator", generator::run),
        group("metal", metal::run),
        command("select", select::run),
        command("distort", distort::run),
        command("compensate", compensate::run),
        command("simulate", simulate::run),
        command("compare", compare::run),
        command("optimize", optimize::run),
        command("sweep", sweep::run),
        command("procedure", procedure::run),
        command("precision", precision::run),
        group("import", import::run),
        command("convert", convert::run),
        command("characterize", characterize::run),
        command("pivot", pivot::run),
        group("protocol", protocol::run),
        command("verify", verify::run),
        command("register", register::run),
        group("export", export::run),
        command("live", live::run),
        command("tolerances", tolerances::run),
        command("report", report::run),
        command("stability", stability::run),
        #[cfg(feature = "editor")]
        command("render", render::run),
    ]
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
    run: fn(&A, &Files) -> anyhow::Result<E>,
) -> Registered {
    Registered { command: A::augment_args(Command::new(name)), run: parsed(run) }
}

/// A subcommand that has further ones.
fn group<S: Subcommand + 'static, E: Into<Ending> + 'static>(
    name: &'static str,
    run: fn(&S, &Files) -> anyhow::Result<E>,
) -> Registered {
    let command = S::augment_subcommands(Command::new(name));
    let command = command.subcommand_required(true).arg_required_else_help(true);
    Registered { command, run: parsed(run) }
}

fn parsed<A: FromArgMatches + 'static, E: Into<Ending> + 'static>(
    run: fn(&A, &Files) -> anyhow::Result<E>,
) -> Run {
    Box::new(move |matches, files| Ok(run(&A::from_arg_matches(matches)?, files)?.into()))
}

/// Most threads that are requested: each takes several of the 65,530 mappings that Linux gives a process.
const MOST_THREADS: usize = 4096;

/// Least address space, in MiB: with less the allocator ends the program at any moment, without a word.
const LEAST_SPACE_MIB: u64 = 256;

/// The limit of `ulimit -v`, where there is one and the system states it.
fn address_space_mib() -> Option<u64> {
    let limits = std::fs::read_to_string("/proc/self/limits").ok()?;
    let line = limits.lines().find_map(|line| line.strip_prefix("Max address space"))?;
    Some(line.split_whitespace().next()?.parse::<u64>().ok()? >> 20)
}

/// Starts the threads that all computing shares, one a core or as many as `RAYON_NUM_THREADS` sets.
/// Left to itself the pool would be made at its first use, and panic where the system has no more.
///
/// # Errors
/// Threads that the system does not give, more of them than any machine has, too little address space, and a
/// pool that is there already.
fn start_threads() -> anyhow::Result<()> {
    if let Some(found) = address_space_mib().filter(|mib| *mib < LEAST_SPACE_MIB) {
        bail!(
            "the address space is limited to {found} MiB, expected {LEAST_SPACE_MIB} MiB at least: `ulimit -v` sets it"
        );
    }
    let requested = std::env::var("RAYON_NUM_THREADS").ok();
    let requested = requested.and_then(|threads| threads.parse::<usize>().ok());
    if let Some(found) = requested.filter(|threads| *threads > MOST_THREADS) {
        bail!("RAYON_NUM_THREADS is {found}, expected {MOST_THREADS} at most");
    }
    rayon::ThreadPoolBuilder::new()
        .build_global()
        .context("the threads to compute with cannot be started; RAYON_NUM_THREADS=1 requests one")
}

/// Runs the command line's command; one without any ends the program with its usage.
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
    let requested = registered.iter().find(|own| own.command.get_name() == name);
    (requested.with_context(|| format!("no command {name}"))?.run)(matches, files)
}

/// Opens the editor; where there can be none, reports why in one line and does the main job.
fn open_editor(cli: &Cli, files: &Files) -> anyhow::Result<()> {
    #[cfg(feature = "editor")]
    let missing = match edit::run(cli.design.as_deref(), cli.explain, cli.controls)? {
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

#[cfg(test)]
mod tests {
    use super::*;

    /// The names of all commands, those of groups with the group's before theirs.
    fn names(command: &Command) -> Vec<String> {
        let of = |own: &Command| {
            let below = names(own).into_iter().map(|name| format!("{} {name}", own.get_name()));
            match own.is_subcommand_required_set() {
                true => below.collect(),
                false => below.chain([own.get_name().to_owned()]).collect::<Vec<_>>(),
            }
        };
        command.get_subcommands().flat_map(of).collect()
    }

    #[test]
    fn each_command_is_in_the_reference() {
        let page =
            include_str!(concat!(env!("CARGO_MANIFEST_DIR"), "/", "docs/reference/commands.md"));
        let all = Cli::command().subcommands(subcommands().into_iter().map(|own| own.command));
        let names = names(&all);
        assert!(names.len() > 25, "{names:?}");
        // A group is one line there: `export field\|poses\|tips`.
        let rows: Vec<String> = page.lines().map(|line| line.replace("\\|", " ")).collect();
        let has = |name: &str| {
            let words: Vec<&str> = name.split(' ').collect();
            let is_row = |row: &String| {
                row.split('`').any(|code| {
                    let mut code = code.split(' ');
                    code.next() == Some(words[0])
                        && words[1..].iter().all(|word| code.any(|own| own == *word))
                })
            };
            rows.iter().any(is_row)
        };
        let missing: Vec<&String> = names.iter().filter(|name| !has(name)).collect();
        assert!(missing.is_empty(), "docs/reference/commands.md lacks {missing:?}");
    }
}
