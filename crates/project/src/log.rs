//! The log of a study as a file, whole or not at all.

use super::error::StoreError;
use super::files::Output;
use std::io;
use trackwright_formats::log;
use trackwright_simulation::{CancelToken, Mode, Outcome, Scenario, StudyError, Trial, run};

/// Why there is no log.
#[derive(Debug, thiserror::Error)]
pub enum LogError {
    #[error(transparent)]
    Study(#[from] StudyError),
    #[error(transparent)]
    Store(#[from] StoreError),
}

/// Runs a study while its trials are written, one row each; `visit` gets them too.
///
/// # Errors
/// Those of the study and of the file; no file appears then, and one that was there stays.
pub fn write_log(
    output: &Output,
    scenario: &Scenario,
    mode: &Mode,
    cancel: &CancelToken,
    visit: &mut dyn FnMut(&Trial),
) -> Result<Outcome, LogError> {
    let mut result: Option<Result<Outcome, StudyError>> = None;
    let written = output.write(|out| {
        log::write_header(out)?;
        let mut failure = None;
        let mut write = |trial: &Trial| {
            visit(trial);
            if failure.is_none()
                && let Err(error) = log::write_trial(out, trial)
            {
                failure = Some(error);
                cancel.cancel();
            }
        };
        let outcome = run(scenario, mode, cancel, Some(&mut write));
        if let Some(error) = failure {
            return Err(error);
        }
        let is_ok = outcome.is_ok();
        result = Some(outcome);
        match is_ok {
            true => Ok(()),
            false => Err(io::Error::other("no outcome")),
        }
    });
    match (result, written) {
        (Some(Err(study)), _) => Err(study.into()),
        (_, Err(store)) => Err(store.into()),
        (Some(Ok(outcome)), Ok(())) => Ok(outcome),
        // Whatever was written came with a result.
        (None, Ok(())) => Err(StudyError::NoTrials.into()),
    }
}
