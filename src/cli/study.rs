//! A study with progress and, where requested, a log.

use super::output;
use trackwright_design::BodyRole;
use trackwright_project::Output;
use trackwright_report::study::StudyReport;
use trackwright_simulation::{CancelToken, Mode, Scenario, Trial, study, trial_count};

/// Runs a body's study, with progress and, where requested, a log.
///
/// # Errors
/// A study that cannot run, a log that cannot be written.
pub(super) fn run_study(
    role: BodyRole,
    (scenario, mode): (&Scenario, &Mode),
    log: Option<&Output>,
) -> anyhow::Result<StudyReport> {
    let trials = trial_count(scenario, mode).unwrap_or(1);
    let bar = output::progress(trials as u64, "simulating");
    let mut last = None;
    let mut visit = |trial: &Trial| {
        bar.inc(1);
        last = Some(*trial);
    };
    let cancel = CancelToken::default();
    let study = match log {
        None => study(scenario, mode, &cancel, Some(&mut visit))?,
        Some(log) => trackwright_project::write_log(log, scenario, mode, &cancel, &mut visit)?,
    };
    bar.finish_and_clear();
    Ok(StudyReport::of(role, (scenario, mode), study, last, &cancel)?)
}
