//! `trackwright`: the editor, and the same simulation on the command line.

mod cli;

use cli::{Ending, INTERRUPTED};
use std::process::ExitCode;

/// What can't be done ends with this status: a file or an argument that can't be used.
const UNUSABLE: u8 = 2;

/// The work was done, and what it checked does not hold.
const DOES_NOT_HOLD: u8 = 1;

fn main() -> ExitCode {
    match cli::run() {
        Ok(Ending::Done) => ExitCode::SUCCESS,
        Ok(Ending::DoesNotHold) => ExitCode::from(DOES_NOT_HOLD),
        Ok(Ending::Interrupted) => ExitCode::from(INTERRUPTED),
        Err(error) => {
            cli::report(&error);
            ExitCode::from(UNUSABLE)
        }
    }
}
