//! A study with all that is reported of it, the same wherever it is reported.

use crate::expected_json::{add_expected, add_needed};
use crate::missed::{Missed, add_sources};
use serde_json::{Value, json};
use trackwright_design::BodyRole;
use trackwright_geometry::pose::pose_to_array;
use trackwright_simulation::expected::{
    MoreMeasuring, judged, more_measuring, requirement_figures,
};
use trackwright_simulation::{
    CancelToken, Expected, ExpectedError, Figures, Mode, Outcome, Scenario, Trial, expected,
};

/// A study, and what is known of its figures.
#[derive(Clone, Debug)]
pub struct Study {
    pub outcome: Outcome,
    /// The trial of a study of one pose.
    pub single: Option<Trial>,
    pub expected: KnownExpected,
    pub needed: Vec<MoreMeasuring>,
    pub missed: Option<Missed>,
    role: BodyRole,
}

/// Expected figures, or why there are none.
#[derive(Clone, Debug, Default)]
pub struct KnownExpected {
    pub figures: Option<Expected>,
    /// Of a room that was measured; one that never was has no expected figures and needs no reason.
    pub why_none: Option<ExpectedError>,
}

impl KnownExpected {
    /// The expected figures; none in a room that was never measured, and where the environment keeps
    /// nothing to draw fields from.
    ///
    /// # Errors
    /// A study that cannot run.
    pub fn of(
        scenario: &Scenario,
        mode: &Mode,
        cancel: &CancelToken,
    ) -> Result<Self, ExpectedError> {
        if scenario.environment.provenance.is_none() && scenario.environment.process.is_none() {
            return Ok(Self::default());
        }
        match expected(scenario, mode, cancel) {
            Ok(figures) => Ok(Self { figures: Some(figures), why_none: None }),
            Err(why @ (ExpectedError::NoProcess(_) | ExpectedError::Markers)) => {
                Ok(Self { figures: None, why_none: Some(why) })
            }
            Err(why) => Err(why),
        }
    }
}

impl Study {
    /// What is known of an outcome; `last` is the last trial of its run. The study is that of this
    /// body; the measurements that would decide a bound are counted for the tool's.
    ///
    /// # Errors
    /// A study that cannot run.
    pub fn of_outcome(
        role: BodyRole,
        (scenario, mode): (&Scenario, &Mode),
        outcome: Outcome,
        last: Option<Trial>,
        cancel: &CancelToken,
    ) -> Result<Self, ExpectedError> {
        let figures = &outcome.figures;
        let expected = KnownExpected::of(scenario, mode, cancel)?;
        let known = expected.figures.as_ref();
        let needed = match role {
            BodyRole::Tool => more_measuring(scenario, mode, &judged(figures, known), cancel)?,
            BodyRole::Crf => Vec::new(),
        };
        let missed = Missed::of(role, (scenario, mode), figures, known, cancel)?;
        let single = last.filter(|_| matches!(mode, Mode::Single));
        Ok(Self { outcome, single, expected, needed, missed, role })
    }

    /// The study as `simulate --format json` prints it.
    pub fn as_json(&self, (scenario, mode): (&Scenario, &Mode)) -> Value {
        let figures = &self.outcome.figures;
        let known = self.expected.figures.as_ref();
        let mut value = figures_json(figures, self.single.as_ref(), known);
        add_needed(&mut value, &self.needed);
        add_sources(&mut value, self.role, (scenario, mode), figures, self.missed.as_ref());
        value
    }
}

/// A study's figures.
pub fn figures_json(
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
        add_expected(&mut value, expected, &judged(figures, Some(expected)));
    }
    value
}
