//! A study with progress and, where requested, a log.

use super::expected;
use super::output;
use trackwright_design::BodyRole;
use trackwright_project::Output;
use trackwright_report::study::Study;
use trackwright_simulation::{CancelToken, Mode, Outcome, Scenario, Trial};

/// Runs a body's study, with progress and, where requested, a log.
///
/// # Errors
/// A study that cannot run, a log that cannot be written.
pub(super) fn study(
    role: BodyRole,
    (scenario, mode): (&Scenario, &Mode),
    log: Option<&Output>,
) -> anyhow::Result<Study> {
    let (outcome, last) = simulate(scenario, mode, log)?;
    let study = Study::of_outcome(role, (scenario, mode), outcome, last, &CancelToken::default())?;
    expected::note_none(&study.expected);
    Ok(study)
}

/// Runs with progress and, where requested, a log; gives the last trial beside the outcome.
pub(super) fn simulate(
    scenario: &Scenario,
    mode: &Mode,
    log: Option<&Output>,
) -> anyhow::Result<(Outcome, Option<Trial>)> {
    let trials = match (mode, &scenario.motion) {
        (Mode::Motion, Some(motion)) => motion.grid(&scenario.crf_from_tool)?.trials(),
        (Mode::Input(trials), _) => trials.len(),
        _ => 1,
    };
    let bar = output::progress(trials as u64, "simulating");
    let mut last = None;
    let mut visit = |trial: &Trial| {
        bar.inc(1);
        last = Some(*trial);
    };
    let cancel = CancelToken::default();
    let outcome = match log {
        None => trackwright_simulation::run(scenario, mode, &cancel, Some(&mut visit))?,
        Some(log) => trackwright_project::write_log(log, scenario, mode, &cancel, &mut visit)?,
    };
    bar.finish_and_clear();
    Ok((outcome, last))
}
