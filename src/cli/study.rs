//! A study with all that is printed of it, the same wherever it is printed.

use super::expected;
use super::missed::{self, Missed};
use super::prelude::*;
use trackwright_design::BodyRole;
use trackwright_geometry::pose::pose_to_array;
use trackwright_project::Output;
use trackwright_simulation::expected::{MoreMeasuring, judged, requirement_figures};
use trackwright_simulation::{
    self, CancelToken, Expected, Figures, Mode, Outcome, Scenario, Trial,
};

/// A study, and what is known of its figures.
pub(super) struct Study {
    pub outcome: Outcome,
    /// The trial of a study of one pose.
    pub single: Option<Trial>,
    pub expected: Option<Expected>,
    pub needed: Vec<MoreMeasuring>,
    pub missed: Option<Missed>,
}

impl Study {
    /// Runs it, of the tool in its CRF, with progress and, where requested, a log.
    ///
    /// # Errors
    /// A study that cannot run, a log that cannot be written.
    pub(super) fn of(
        (scenario, mode): (&Scenario, &Mode),
        log: Option<&Output>,
    ) -> anyhow::Result<Self> {
        let (outcome, last) = simulate(scenario, mode, log)?;
        let figures = &outcome.figures;
        let expected = expected::of(scenario, mode)?;
        let needed = expected::needed(scenario, mode, expected.as_ref(), figures)?;
        let missed = Missed::of(BodyRole::Tool, (scenario, mode), figures, expected.as_ref())?;
        let single = last.filter(|_| matches!(mode, Mode::Single));
        Ok(Self { outcome, single, expected, needed, missed })
    }

    pub(super) fn as_json(&self, (scenario, mode): (&Scenario, &Mode)) -> Value {
        let figures = &self.outcome.figures;
        let mut value = as_json(figures, self.single.as_ref(), self.expected.as_ref());
        expected::add_needed(&mut value, &self.needed);
        missed::add_json(
            &mut value,
            BodyRole::Tool,
            (scenario, mode),
            figures,
            self.missed.as_ref(),
        );
        value
    }
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

/// A study's figures.
pub(super) fn as_json(
    figures: &Figures,
    single: Option<&Trial>,
    expected: Option<&Expected>,
) -> Value {
    let mut value = json!({
        "trials": figures.trials,
        "outside": figures.outside,
        "out_of_volume": figures.out_of_volume,
        "rejected": figures.rejected,
        "position_mm": figures.position_mm,
        "angle_deg": figures.angle_deg,
        "worst": figures.worst,
        "requirement": requirement_figures(figures),
        "poorly_determined": figures.poorly_determined,
    });
    if let Some(free) = &figures.free_axis {
        value["free_axis"] = json!(free);
        value["position_mm_determined"] = json!(figures.position_mm_determined);
    }
    if let Some(weak) = &figures.barely_determined {
        value["barely_determined"] = json!(weak);
    }
    if let Some(trial) = single {
        let e = trial.tip_error_in_crf_mm;
        value["error_mm"] = json!([e.x, e.y, e.z]);
        value["true"] = json!(pose_to_array(&trial.crf_from_tool));
        value["simulated"] = json!(pose_to_array(&trial.crf_from_tool_simulated));
    }
    if let Some(expected) = expected {
        expected::add_json(&mut value, expected, &judged(figures, Some(expected)));
    }
    value
}
