//! `trackwright`: the editor, and the same simulation on the command line.

use clap::Parser;
use std::process::ExitCode;
use trackwright::cli::Ending;

/// What can't be done ends with this status: a file or an argument that can't be used.
const UNUSABLE: u8 = 2;

/// The work was done, and what it checked does not hold.
const DOES_NOT_HOLD: u8 = 1;

fn main() -> ExitCode {
    let cli = trackwright::cli::Cli::parse();
    match trackwright::cli::start_threads().and_then(|()| trackwright::cli::run(&cli)) {
        Ok(Ending::Done) => ExitCode::SUCCESS,
        Ok(Ending::DoesNotHold) => ExitCode::from(DOES_NOT_HOLD),
        Err(error) => {
            trackwright::cli::report(&error);
            ExitCode::from(UNUSABLE)
        }
    }
}
