//! The best of the places, with what the study comes to there and not an estimate of it.

use super::outcome::{
    Basis, Candidates, ExpectedTip, PlacedBody, Placement, PlacementOutcome, PlacementPlan,
};
use crate::body::Sensor;
use crate::expected::{ExpectedError, expected};
use crate::metric::Metric;
use crate::run::{StudyError, run};
use crate::scenario::{Mode, Scenario};
use crate::work::Work;
use trackwright_task::{Cancelled, Task};

/// How often the place that seems the best is studied. Each time it may turn out to be worse than the
/// next one's estimate.
const ROUNDS: usize = 8;

/// The place of least tip error that was found.
#[derive(Clone, Debug, PartialEq)]
pub struct BestPlace {
    /// Among the candidates.
    pub candidate: usize,
    /// The sensor as it is there.
    pub sensor: Sensor,
    /// What the study of the design comes to with it there.
    pub placement: Placement,
}

/// The scenario with a sensor like this in the place of the plan's own.
pub(super) fn with_sensor(scenario: &Scenario, plan: &PlacementPlan, own: &Sensor) -> Scenario {
    let mut moved = scenario.clone();
    let body = match (plan.body, &mut moved.crf) {
        (PlacedBody::Crf, Some(crf)) => &mut crf.body,
        _ => &mut moved.tool,
    };
    if let Some(sensor) = body.sensors.get_mut(plan.sensor) {
        let name = std::mem::take(&mut sensor.name);
        *sensor = Sensor { name, ..own.clone() };
    }
    moved
}

/// The trials that the design is judged by.
pub(super) fn whole_mode(scenario: &Scenario) -> Mode {
    match scenario.motion {
        Some(_) => Mode::Motion,
        None => Mode::Single,
    }
}

/// Studies the candidates that seem the best, until the one that does is one that was studied. What
/// they and those at the same place come to is then that study.
pub(super) fn find_best(
    scenario: &Scenario,
    plan: &PlacementPlan,
    candidates: &Candidates,
    outcome: &mut PlacementOutcome,
    task: &Task,
) -> Result<Option<BestPlace>, Cancelled> {
    let mut studied: Vec<usize> = Vec::new();
    for _ in 0..ROUNDS {
        let all = outcome.places.iter().enumerate().filter(|(_, place)| !place.is_outside);
        let values = all.filter_map(|(i, place)| Some((i, place.shown_mm()?)));
        let Some((candidate, _)) = values.min_by(|a, b| a.1.total_cmp(&b.1)) else {
            break;
        };
        if studied.contains(&candidate) {
            break;
        }
        if task.cancel.is_cancelled() {
            return Err(Cancelled);
        }
        let place = candidates.place_of[candidate];
        let moved = with_sensor(scenario, plan, &candidates.sensors[place]);
        let (own, work) = study(&moved, outcome.places[candidate], task)?;
        outcome.work += work;
        for (other, of) in outcome.places.iter_mut().zip(&candidates.place_of) {
            if *of == place {
                outcome.full += usize::from(other.basis != Basis::Full);
                *other = own;
            }
        }
        studied.push(candidate);
    }
    let value = |candidate: &usize| outcome.places[*candidate].shown_mm();
    let known = studied.iter().filter_map(|candidate| Some((*candidate, value(candidate)?)));
    let Some((candidate, _)) = known.min_by(|a, b| a.1.total_cmp(&b.1)) else {
        return Ok(None);
    };
    let moved = with_sensor(scenario, plan, &candidates.sensors[candidates.place_of[candidate]]);
    let body = match (plan.body, moved.crf) {
        (PlacedBody::Crf, Some(crf)) => crf.body,
        _ => moved.tool,
    };
    let sensor = body.sensors.into_iter().nth(plan.sensor);
    let placement = outcome.places[candidate];
    Ok(sensor.map(|sensor| BestPlace { candidate, sensor, placement }))
}

/// What the design comes to, from what is known of it.
fn study(moved: &Scenario, known: Placement, task: &Task) -> Result<(Placement, Work), Cancelled> {
    let mode = whole_mode(moved);
    let (mut placement, mut work) = (known, Work::default());
    if known.basis != Basis::Full {
        placement.tip_rms_mm = match run(moved, &mode, &task.cancel, None) {
            Ok(outcome) => {
                let placement_evaluations = outcome.work.study_evaluations;
                work = Work { placement_evaluations, study_evaluations: 0, ..outcome.work };
                Some(outcome.figures.position_mm.rms())
            }
            Err(StudyError::Cancelled) => return Err(Cancelled),
            Err(_) => None,
        };
        placement.basis = Basis::Full;
    }
    placement.expected = match moved.environment.process {
        Some(_) => expected_tip(moved, &mode, task)?.map(|found| found.0),
        None => None,
    };
    Ok((placement, work))
}

/// The expected tip RMS, and that in the room's own field; `None` where there is none to be found.
pub(super) fn expected_tip(
    moved: &Scenario,
    mode: &Mode,
    task: &Task,
) -> Result<Option<(ExpectedTip, f64)>, Cancelled> {
    match expected(moved, mode, &task.cancel) {
        Ok(found) => {
            let (rms_mm, interval_mm) = found.of(Metric::TIP_RMS);
            Ok(Some((ExpectedTip { rms_mm, interval_mm }, found.own_of(Metric::TIP_RMS))))
        }
        Err(ExpectedError::Study(StudyError::Cancelled)) => Err(Cancelled),
        Err(_) => Ok(None),
    }
}
