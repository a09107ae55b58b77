//! The whole search: the start, every set of sensors that is requested, and the verdict on the best.

use crate::bodies::Bodies;
use crate::choice::{Choice, choices};
use crate::judge::{Judge, Judged};
use crate::outcome::{Layout, OptimizeError, Optimized, Progress, RoughlyBuilt, body_key};
use crate::problem::{BuiltError, Goal, Problem, Settings};
use crate::search::{Search, Studied};
use crate::verdict::{binding, crowded, flatness, gain, required};
use trackwright_simulation::study::NoFigures;
use trackwright_simulation::{CancelToken, RoomFieldFigures, run};
use trackwright_task::Task;

/// Layouts that are listed.
const LISTED: usize = 6;

/// Seed of the fields that the gain is judged in, apart from that of the search.
const UNSEEN_SEED: u64 = 0x5eed;

/// Part of the work that the search is, for progress.
const SEARCH_PART: f64 = 0.85;

/// Finds the best places of what may move.
///
/// `enough` ends the search with the best so far; `task` gives it up. `deliver` gets each layout that is
/// better than those before it. The result does not depend on the number of threads, and where it
/// was not ended early on the problem and the settings alone.
///
/// # Errors
/// See [`OptimizeError`].
pub fn optimize(
    problem: &Problem,
    settings: &Settings,
    enough: &CancelToken,
    task: &Task,
    deliver: &mut dyn FnMut(&Progress),
) -> Result<Optimized, OptimizeError> {
    let first = problem.scenarios.first().ok_or(OptimizeError::NoRoom)?;
    if required(problem.goal).is_empty() {
        return Err(OptimizeError::NothingRequired);
    }
    let ended = enough.clone();
    task.cancel.on_cancel(move || ended.cancel());
    let built = problem.built.map_or([0.0; 2], |built| [built.position_mm, built.angle_deg]);
    if let Some(found) = built.into_iter().find(|b| !(b.is_finite() && *b >= 0.0)) {
        return Err(OptimizeError::Bounds { found, expected: "a finite number from 0" });
    }
    let choices = choices(problem)?;
    let own = Bodies::of(first);
    let mut figures = Vec::with_capacity(problem.scenarios.len());
    for scenario in &problem.scenarios {
        figures.push(run(scenario, &problem.mode, &task.cancel, None)?.room_field);
    }
    let judge = Judge::new(problem, &own, &figures)?;
    if !judge.requires_anything() {
        return Err(OptimizeError::NothingRequired);
    }
    // Its own study leaves the field at no more poses than itself: it has no figures in one of the rooms.
    let no_start = || {
        let without = figures.iter().find(|own| own.without_field == own.trials);
        let &RoomFieldFigures { trials, outside, in_metal, out_of_volume, .. } =
            without.unwrap_or(&figures[0]);
        NoFigures::NoOverlap { trials, outside, in_metal, out_of_volume }
    };
    let of_start = judge.study(&own, &task.cancel)?.ok_or_else(no_start)?;
    let start = layout(&own, &of_start, None);
    let share = 1.0 / choices.len() as f64;
    let mut best_objective = start.objective;
    let mut evaluations = 0;
    let mut found: Vec<Found> = Vec::new();
    let mut refused = None;
    for (number, choice) in choices.iter().enumerate() {
        let part = |k: usize| SEARCH_PART * k as f64 * share;
        let searching = task.subtask(part(number), part(number + 1));
        let search = Search::new(&judge, choice, *settings, (enough, share))?;
        let before = evaluations;
        let searched = search.run(&searching, &mut |studied: &Studied, judged| {
            if studied.judged.objective < best_objective {
                best_objective = studied.judged.objective;
                let best = studied.layout(choice);
                deliver(&Progress { best: &best, evaluations: before + judged });
            }
        });
        match searched {
            Ok(searched) => {
                evaluations += searched.evaluations;
                let certain_to_mm = searched.certain_to_mm;
                let mut listed = searched.studied;
                listed.truncate(LISTED);
                found.push(Found { choice, search, listed, certain_to_mm });
            }
            // Fewer sensors may still have places.
            Err(error @ OptimizeError::NoPlace { .. }) if choices.len() > 1 => {
                refused = Some(error);
            }
            Err(error) => return Err(error),
        }
    }
    if found.iter().all(|found| found.listed.is_empty()) {
        if !enough.is_cancelled() {
            return Err(refused.unwrap_or_else(|| too_many(&choices[0])));
        }
        return Ok(Optimized::of_start(start, evaluations, notes(problem)));
    }
    let pareto = pareto(&found);
    let chosen = best_choice(problem.goal, &found);
    let of_choice = &found[chosen];
    let studied = &of_choice.listed[0];
    let is_start = of_choice.choice.is_own && studied.judged.objective >= start.objective;
    let best = match is_start {
        true => start.clone(),
        false => studied.layout(of_choice.choice),
    };
    let search = &of_choice.search;
    let reference = search.judge.few_value(&search.movable.bodies(&studied.position));
    let reference = reference?.unwrap_or(f64::INFINITY);
    let (binding, flatness) = match is_start {
        true => (Vec::new(), Vec::new()),
        false => (
            binding(search, &studied.position, reference),
            flatness(search, &studied.position, reference),
        ),
    };
    let judging = task.subtask(SEARCH_PART, 1.0);
    let best_bodies = if is_start { &own } else { &studied.bodies };
    let (gain, is_better) = match is_start {
        true => (Vec::new(), false),
        false => gain(
            problem,
            judge.deciding(&start.studies),
            (&own, start.objective),
            (best_bodies, best.objective),
            settings.seed.wrapping_add(UNSEEN_SEED),
            &judging,
        )?,
    };
    task.step(1, 1)?;
    let mut notes = notes(problem);
    if refused.is_some() {
        notes.push("the regions do not hold as many sensors as were allowed".into());
    }
    let rough = BuiltError::rough(problem.built);
    let roughly_built = RoughlyBuilt {
        position_mm: rough.position_mm,
        angle_deg: rough.angle_deg,
        start: of_start.roughly_built,
        best: studied.judged.roughly_built,
    };
    let is_rougher = problem.built != Some(rough);
    Ok(Optimized {
        candidates: of_choice.listed.iter().map(|own| own.layout(of_choice.choice)).collect(),
        roughly_built: (is_better && is_rougher).then_some(roughly_built),
        crowded: if is_start { Vec::new() } else { crowded(&search.movable, best_bodies) },
        undetermined: undetermined(&best),
        pareto,
        is_better,
        evaluations,
        certain_to_mm: of_choice.certain_to_mm,
        gain,
        binding,
        flatness,
        is_stopped: enough.is_cancelled(),
        notes,
        start,
        best,
    })
}

/// What the search for one set of sensors has found.
struct Found<'a> {
    choice: &'a Choice,
    search: Search<'a>,
    /// The best first.
    listed: Vec<Studied>,
    certain_to_mm: Option<f64>,
}

impl Studied {
    fn layout(&self, choice: &Choice) -> Layout {
        layout(&self.bodies, &self.judged, choice.cost)
    }
}

/// No layout of a choice is allowed: each of its sensors has places, but not beside the others.
fn too_many(choice: &Choice) -> OptimizeError {
    choice.slots.first().map_or(OptimizeError::NothingMoves, |slot| OptimizeError::TooMany {
        body: body_key(slot.body),
        sensors: choice.bodies.body(slot.body).map_or(0, |body| body.sensors.len()),
    })
}

fn layout(bodies: &Bodies, judged: &Judged, cost: Option<f64>) -> Layout {
    Layout {
        tool: bodies.tool.clone(),
        crf: bodies.crf.clone(),
        tracker_from_crf: bodies.tracker_from_crf,
        crf_from_tool: bodies.crf_from_tool,
        objective: judged.objective,
        studies: judged.studies.clone(),
        cost,
    }
}

/// How many sensors there are in all.
fn sensors(layout: &Layout) -> usize {
    layout.tool.sensors.len() + layout.crf.as_ref().map_or(0, |crf| crf.sensors.len())
}

/// Layouts of which no other has as few sensors, as low a cost and as low an objective.
fn pareto(found: &[Found]) -> Vec<Layout> {
    let best = found.iter().filter_map(|found| Some(found.listed.first()?.layout(found.choice)));
    let all: Vec<Layout> = best.collect();
    let key =
        |layout: &Layout| (sensors(layout) as f64, layout.cost.unwrap_or(0.0), layout.objective);
    let is_dominated = |layout: &Layout| {
        let own = key(layout);
        all.iter().any(|other| {
            let other = key(other);
            other != own && other.0 <= own.0 && other.1 <= own.1 && other.2 <= own.2
        })
    };
    let mut kept: Vec<Layout> = all.iter().filter(|l| !is_dominated(l)).cloned().collect();
    kept.sort_by(|a, b| sensors(a).cmp(&sensors(b)).then(a.objective.total_cmp(&b.objective)));
    kept
}

/// The fewest sensors that meet all that is required, else the least objective.
fn best_choice(goal: Goal, found: &[Found]) -> usize {
    let objective =
        |k: &usize| found[*k].listed.first().map_or(f64::INFINITY, |best| best.judged.objective);
    let count = |k: &usize| {
        let bodies = &found[*k].choice.bodies;
        bodies.tool.sensors.len() + bodies.crf.as_ref().map_or(0, |crf| crf.sensors.len())
    };
    let all = 0..found.len();
    let meets = |k: &usize| matches!(goal, Goal::Requirement(_)) && objective(k) <= 1.0;
    let fewest = all
        .clone()
        .filter(meets)
        .min_by(|a, b| count(a).cmp(&count(b)).then(objective(a).total_cmp(&objective(b))));
    let least = all.min_by(|a, b| objective(a).total_cmp(&objective(b)));
    fewest.or(least).unwrap_or(0)
}

fn undetermined(best: &Layout) -> Vec<String> {
    let Some(figures) = best.studies.first().map(|study| &study.room_field) else {
        return Vec::new();
    };
    let free = figures.free_axis.as_ref().map(|free| free.statement());
    let weak = figures.barely_determined.as_ref().map(|weak| weak.statement());
    free.into_iter().chain(weak).collect()
}

fn notes(problem: &Problem) -> Vec<String> {
    let mut notes = Vec::new();
    if problem.scenarios.iter().any(|scenario| scenario.environment.jitter.is_some()) {
        notes.push("the jitter that a room states counts: E|e|² = |bias|² + tr cov".to_owned());
    }
    if let Some(BuiltError { position_mm, angle_deg }) = problem.built {
        notes.push(format!(
            "sensors are taken to be built within {position_mm} mm and {angle_deg}° (standard deviations)"
        ));
    }
    if let (Some(_), Some(patch)) = (problem.moves.crf_pose, problem.crf_patches.first()) {
        notes.push(format!(
            "the CRF stands on the patch of the anatomy {:?} and turns with its surface",
            patch.anatomy
        ));
    }
    if problem.moves.crf_pose.is_some() {
        notes.push("the range of motion turns with the CRF: its axes are the CRF's".to_owned());
    }
    if problem.moves.generator.is_some() {
        notes.push(
            "the field's errors are taken to go with the generator: right for metal that does, such as \
             the table that it is fixed to"
                .to_owned(),
        );
    }
    let bodies = [
        ("tool", Some(&problem.scenarios[0].tool), &problem.moves.tool),
        ("crf", problem.scenarios[0].crf.as_ref().map(|crf| &crf.body), &problem.moves.crf),
    ];
    for (key, body, moved) in bodies {
        let Some(body) = body else { continue };
        let has_no_coil = |k: &&usize| body.sensors.get(**k).is_some_and(|s| s.coil.is_none());
        if moved.iter().any(|k| has_no_coil(&k)) {
            notes.push(format!(
                "sensors of the {key} state no coil size: they are points that may be at one place"
            ));
        }
    }
    notes
}
