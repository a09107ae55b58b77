//! `trackwright`: the editor, and the same simulation on the command line.

use clap::Parser;
use std::process::ExitCode;

/// What can't be done ends with this status: a file or an argument that can't be used.
const UNUSABLE: u8 = 2;

fn main() -> ExitCode {
    match trackwright::cli::run(&trackwright::cli::Cli::parse()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            trackwright::cli::report(&error);
            ExitCode::from(UNUSABLE)
        }
    }
}
