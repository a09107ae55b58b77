//! Where on a body's surface a sensor would serve the tip best: the study's tip RMS if it sat
//! there, for every vertex of the surface, coarse first.
//!
//! All that does not change with the sensor's place is computed once: the readings of the other
//! sensors at every pose, the CRF, the poses. A vertex then costs one reading and one frame fit a
//! pose. For a sensor of the CRF, which stands still, it costs one of each in all (`crf.rs`), and
//! every vertex is computed fully. For a sensor of the tool 20,000 vertices times thousands of
//! poses are too many, so that a part of the vertices is computed fully, farthest first, and the
//! others as their own tip RMS over few poses times how far that is from the full one at the
//! fully computed vertices around.
//!
//! 20,000 vertices of a tool and 3,375 poses take 4.3 million fits, 0.6 µs of one core each; the
//! first picture 0.11 million. 20,000 vertices of a CRF take some 0.05 s.
//!
//! The few poses are a Gauss rule on the motion's grid. How far values are from the full study, in
//! parts of it, median / 90th percentile / worst of 97 vertices of the built-in tools (room of order 2,
//! 3,375 poses):
//!
//! | picture | full | axis kept | along the normal | along the surface |
//! | --- | --- | --- | --- | --- |
//! | pointer, 512 vertices at few poses, others between | 24 | 0.1 / 0.3 / 0.6 % | 2.4 / 7.4 / 21 % | 2.3 / 5.7 / 10 % |
//! | pointer, all 11,204 vertices at few poses | 24 | 0.08 / 0.17 / 0.3 % | 2.2 / 5.6 / 21 % | 1.8 / 4.5 / 6.6 % |
//! | pointer, the last one | 900 | 0.01 / 0.02 / 0.03 % | 0.5 / 2.1 / 7.3 % | 0.4 / 1.6 / 4.4 % |
//! | shaver, 512 vertices at few poses, others between | 24 | 0.2 / 0.7 / 1.5 % | 2.6 / 7.8 / 32 % | 2.3 / 6.2 / 22 % |
//! | shaver, all 13,476 vertices at few poses | 24 | 0.07 / 0.3 / 0.5 % | 1.2 / 3.5 / 17 % | 0.9 / 3.6 / 8.6 % |
//! | shaver, the last one | 900 | 0.01 / 0.02 / 0.06 % | 0.5 / 1.4 / 3.1 % | 0.2 / 1.3 / 2.5 % |
//!
//! The large errors are where trials vary most over the motion, as they do where the sensor's axis
//! is nearly along the others' and the tool's roll is poorly determined: few poses do not show
//! that. Vertices are therefore also distinguished by how much their trials vary.

mod best;
mod crf;
mod depth;
mod interval;
mod known;
mod outcome;
mod rule;
mod tool;

pub use best::BestPlace;
pub use depth::{CoilDepth, longest_edge_mm, placement_mesh, vertices};
pub use outcome::{
    Basis, ExpectedTip, PlacedBody, Placement, PlacementError, PlacementOutcome, PlacementPlan,
};
pub use rule::{AxisRule, along_surface};

use super::refit::RefitBuffers;
use super::run::{StudyError, check};
use super::scenario::Scenario;
use super::work::Work;
use best::find_best;
use crf::CrfAt;
use interval::OpenParts;
use known::Known;
use outcome::{Candidates, Found, NOWHERE, Study, difference_mm};
use rayon::prelude::*;
use tool::ToolAt;
use trackwright_geometry::pose::Pose;
use trackwright_geometry::spread::{Position, farthest_first};
use trackwright_task::{Cancelled, Task};

/// Trials that go into fully computed vertices.
const FULL_TRIALS: usize = 3_000_000;

/// Vertices that are computed fully whatever that costs: without any, nobody knows how good the
/// others are.
const LEAST_FULL: usize = 24;

/// Vertices that the first picture is made of.
const FIRST_VERTICES: usize = 512;

/// Trials up to which there is one picture only.
const AT_ONCE: usize = 100_000;

/// Finds what each place comes to; `deliver` gets each picture, the last one too, which is
/// returned. The result does not depend on the number of threads.
///
/// # Errors
/// See [`PlacementError`].
pub fn place(
    scenario: &Scenario,
    plan: &PlacementPlan,
    task: &Task,
    deliver: &mut dyn FnMut(&PlacementOutcome),
) -> Result<PlacementOutcome, PlacementError> {
    check(scenario)?;
    let body = match plan.body {
        PlacedBody::Tool => &scenario.tool,
        PlacedBody::Crf => &scenario.crf.as_ref().ok_or(PlacementError::NoCrf)?.body,
    };
    let sensors = body.sensors.len();
    let Some(sensor) = body.sensors.get(plan.sensor) else {
        return Err(PlacementError::NoSensor {
            body: body.name.clone(),
            sensor: plan.sensor,
            sensors,
        });
    };
    task.step(0, 1)?;
    let study = Study::new(scenario).map_err(StudyError::from)?;
    let candidates = Candidates::new(sensor, plan);
    let (mut outcome, features) = match (plan.body, &scenario.crf) {
        (PlacedBody::Crf, Some(crf)) => {
            let of = |rule| CrfAt::new(scenario, crf, plan.sensor, rule, &task.cancel);
            let outcome = on_crf(&of(&study.many)?, &of(&study.few)?, &study, &candidates, task)?;
            (outcome, candidates.places.clone())
        }
        _ => {
            let of = |rule| ToolAt::new(scenario, plan.sensor, rule, &task.cancel);
            let tools = [of(&study.many)?, of(&study.few)?];
            on_tool(scenario, &tools, &study, &candidates, task, deliver)?
        }
    };
    if scenario.environment.states_uncertainty() {
        outcome.is_final = false;
        deliver(&outcome);
        if let Some(open) = OpenParts::find(scenario, plan, &candidates, &features, task)? {
            open.add_to(&mut outcome.places, &candidates.place_of, &features);
        }
        outcome.is_final = true;
    }
    outcome.best = find_best(scenario, plan, &candidates, &mut outcome, task)?;
    deliver(&outcome);
    task.step(1, 1)?;
    Ok(outcome)
}

fn on_crf(
    many: &CrfAt,
    few: &CrfAt,
    study: &Study,
    candidates: &Candidates,
    task: &Task,
) -> Result<PlacementOutcome, PlacementError> {
    let found: Result<Vec<(Placement, Work)>, Cancelled> = candidates
        .sensors
        .par_iter()
        .enumerate()
        .map_init(RefitBuffers::default, |buffers, (place, sensor)| {
            if task.cancel.is_cancelled() {
                return Err(Cancelled);
            }
            if !candidates.is_finite(place) {
                return Ok((NOWHERE, Work::default()));
            }
            let found = many.found(buffers, sensor, &task.cancel)?;
            let basis = match study.is_whole {
                true => Basis::Full,
                false => Basis::Approximate {
                    error_mm: difference_mm(&found, &few.found(buffers, sensor, &task.cancel)?),
                },
            };
            let placement = Placement {
                tip_rms_mm: found.tip_rms_mm,
                basis,
                expected: None,
                is_outside: found.is_outside,
            };
            Ok((placement, buffers.take_work()))
        })
        .collect();
    let (places, cost): (Vec<_>, Work) = found?.into_iter().unzip();
    let work = many.own_work() + few.own_work() + cost;
    Ok(candidates.outcome(&places, study.trials, true, work))
}

fn on_tool(
    scenario: &Scenario,
    [many, few]: &[ToolAt; 2],
    study: &Study,
    candidates: &Candidates,
    task: &Task,
    deliver: &mut dyn FnMut(&PlacementOutcome),
) -> Result<(PlacementOutcome, Vec<Position>), PlacementError> {
    let all: Vec<usize> =
        (0..candidates.places.len()).filter(|&place| candidates.is_finite(place)).collect();
    let most = (FULL_TRIALS / many.poses()).max(LEAST_FULL).min(all.len());
    let mut known = Known {
        candidates,
        study,
        many: vec![None; candidates.places.len()],
        few: vec![None; candidates.places.len()],
        leaves: leaves_box(scenario, few, study, candidates),
        work: many.own_work() + few.own_work(),
    };
    let mut learn = |fully: &[usize], partly: &[usize], is_final: bool| {
        let (found, work) = compute(few, candidates, partly, &known.few, task)?;
        known.work += work;
        for (place, found) in found {
            known.few[place] = Some(found);
        }
        let (found, work) = compute(many, candidates, fully, &known.many, task)?;
        known.work += work;
        for (place, found) in found {
            known.many[place] = Some(found);
        }
        Ok::<_, Cancelled>((known.outcome(is_final), known.features()))
    };
    if most * many.poses() > AT_ONCE {
        let first = farthest_first(&candidates.places, FIRST_VERTICES);
        let fully = &first[..LEAST_FULL.min(first.len())];
        deliver(&learn(fully, &first, false)?.0);
        task.step(1, 3)?;
    }
    if most == all.len() {
        // Few poses then only show how good many are where those are not all.
        let partly = if study.is_whole { &[][..] } else { &all };
        return Ok(learn(&all, partly, true)?);
    }
    let (outcome, features) = learn(&[], &all, false)?;
    deliver(&outcome);
    task.step(2, 3)?;
    Ok(learn(&farthest_first(&features, most), &[], true)?)
}

/// Whether each place leaves the model's box at one of few poses or in a corner of the motion.
fn leaves_box(
    scenario: &Scenario,
    few: &ToolAt,
    study: &Study,
    candidates: &Candidates,
) -> Vec<bool> {
    let bounds = *scenario.environment.model.bounds();
    let tracker_from_crf = scenario.tracker_from_crf();
    let ends = study.corners.iter().map(|pose| tracker_from_crf * pose);
    let poses: Vec<Pose> = few.tracker_from_tool().iter().copied().chain(ends).collect();
    candidates
        .sensors
        .par_iter()
        .map(|sensor| {
            let at = sensor.position_in_body;
            poses.iter().any(|pose| !bounds.contains(&(pose * at)))
        })
        .collect()
}

/// A place by its number, and what it comes to.
type Numbered = (usize, Found);

type Computed = (Vec<Numbered>, Work);

/// What those of the places come to that are not known yet.
fn compute(
    tool: &ToolAt,
    candidates: &Candidates,
    places: &[usize],
    known: &[Option<Found>],
    task: &Task,
) -> Result<Computed, Cancelled> {
    let found: Result<Vec<(Numbered, Work)>, Cancelled> = places
        .par_iter()
        .filter(|place| known[**place].is_none())
        .map_init(RefitBuffers::default, |buffers, &place| {
            let found = tool.found(buffers, &candidates.sensors[place], &task.cancel)?;
            Ok(((place, found), buffers.take_work()))
        })
        .collect();
    Ok(found?.into_iter().unzip())
}
