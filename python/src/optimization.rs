//! The best places for a design's sensors.

use crate::design::{Design, notes_of};
use crate::environment::Environment;
use crate::errors::{Done, TrackwrightError};
use crate::found::Found;
use crate::keywords::Keywords;
use crate::long_work;
use anyhow::Context;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::ops::RangeInclusive;
use std::sync::Arc;
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::thread;
use std::time::{Duration, Instant};
use trackwright_optimization::{
    BuiltError, Goal, Moves, Optimized, OverRooms, Problem, SensorChoice, Settings,
    optimize as search,
};
use trackwright_project::{
    Files, MOST_SENSORS, MOST_SETS, MoveBounds, World, design_rooms, named_moves,
    placement_problem, sets_of_sensors,
};
use trackwright_report::optimization_section::{FoundPlaces, with_layout};
use trackwright_simulation::{Coil, Metric};
use trackwright_task::{CancelToken, Task};

/// How long a search lasts where that is not stated, seconds.
const SECONDS: f64 = 30.0;

/// What a search came to.
#[pyclass(frozen, get_all, extends = Found, module = "trackwright")]
pub struct Places {
    design: Py<Design>,
    is_better: bool,
}

/// Finds the best places for a design's sensors within what can be built.
///
/// moves: names of what may move, of tool, crf, generator, crf-pose and names of sensors; all sensors of the
/// tool where it is None. sensors: how many there may be, or the least and the most. kinds: tuples of degrees
/// of freedom and cost, and perhaps diameter and length of the coil in mm. metric: the figure that is made
/// least; the largest part of a limit of the requirement where it is None. environments: the rooms that
/// count. bounds and built_error: mm and degrees; built_error=(0, 0) is of sensors that are built exactly. The
/// same seed finds the same places, unless seconds end the search.
#[pyfunction]
#[pyo3(
    signature = (design, **options),
    text_signature = "(design, *, moves=None, sensors=None, kinds=None, metric=None, \
        environments=None, rooms='worst', generator_bounds=None, crf_bounds=None, \
        built_error=(0.2, 0.3), seconds=30.0, seed=0)"
)]
pub fn optimize(
    py: Python<'_>,
    design: &Bound<'_, Design>,
    options: Option<&Bound<'_, PyDict>>,
) -> Done<Py<Places>> {
    let keywords = Keywords::of(options);
    let label = design.get().label();
    let world = design.get().world();
    let moves = moves(&keywords, world, &label)?;
    let goal = goal(&keywords, world, &label)?;
    let rooms: Option<Vec<Bound<'_, Environment>>> = keywords.value("environments")?;
    let over =
        keywords.one_of("rooms", &[("worst", OverRooms::Worst), ("mean", OverRooms::Mean)])?;
    let built = bounds(&keywords, "built_error")?;
    let seconds = keywords.number("seconds", "a number above zero", |value| value > 0.0)?;
    let settings = Settings { seed: keywords.value("seed")?.unwrap_or(0), ..Settings::default() };
    keywords.finish()?;
    let rooms = match rooms {
        Some(rooms) => rooms.iter().map(|room| Arc::clone(&room.get().solved)).collect(),
        None => long_work::run(py, |_| Ok(design_rooms(&Files::default(), world)?))?,
    };
    let mut notes: Vec<String> = rooms.iter().flat_map(|room| notes_of(world, room)).collect();
    notes.dedup();
    let problem = placement_problem(world, &rooms, moves, goal, over);
    let built = match built {
        None => Some(BuiltError::default()),
        Some((0.0, 0.0)) => None,
        Some((position_mm, angle_deg)) => Some(BuiltError { position_mm, angle_deg }),
    };
    let problem = Problem { built, ..problem };
    let longest = seconds.unwrap_or(SECONDS);
    let (found, section) = long_work::run(py, |task| {
        let (optimized, seconds) =
            searched(&problem, &settings, longest, task).with_context(|| label.clone())?;
        let better = with_layout(world, &optimized.best).with_context(|| label.clone())?;
        let (world, written) = (world.clone(), Vec::new());
        let found = FoundPlaces { world, better, rooms, problem, optimized, seconds, written };
        let studies = found.studies(&task.cancel).with_context(|| label.clone())?;
        let section = found.section().with_all(studies);
        Ok((found, section))
    })?;
    let is_better = found.optimized.is_better;
    let chosen = if is_better { Design::of(found.better) } else { Design::of(found.world) };
    let places = Places { design: Py::new(py, chosen)?, is_better };
    Ok(Py::new(py, (places, Found::new(py, section, notes)?))?)
}

/// The search until its end or that of its time, and how long it took.
fn searched(
    problem: &Problem,
    settings: &Settings,
    longest_s: f64,
    task: &Task,
) -> anyhow::Result<(Optimized, f64)> {
    let started = Instant::now();
    let enough = CancelToken::default();
    let longest = Duration::try_from_secs_f64(longest_s).unwrap_or(Duration::MAX);
    let found = thread::scope(|scope| {
        let (_alive, ended) = channel::<()>();
        let timed = enough.clone();
        scope.spawn(move || {
            if ended.recv_timeout(longest) == Err(RecvTimeoutError::Timeout) {
                timed.cancel();
            }
        });
        search(problem, settings, &enough, task, &mut |_| ())
    })?;
    Ok((found, started.elapsed().as_secs_f64()))
}

/// A way in mm and a turn in degrees.
fn bounds(keywords: &Keywords, name: &'static str) -> Done<Option<(f64, f64)>> {
    let found: Option<(f64, f64)> = keywords.value(name)?;
    if let Some((mm, deg)) = found
        && !(mm.is_finite() && mm >= 0.0 && (0.0..=180.0).contains(&deg))
    {
        let text =
            format!("{name}: found ({mm}, {deg}), expected mm and degrees, each zero or more");
        return Err(TrackwrightError::new_err(text).into());
    }
    Ok(found)
}

/// What may move, and which sensors there may be.
fn moves(keywords: &Keywords, world: &World, label: &str) -> Done<Moves> {
    let design = world.document.design();
    let names: Vec<String> = keywords.value("moves")?.unwrap_or_default();
    let generator = bounds(keywords, "generator_bounds")?;
    let crf = bounds(keywords, "crf_bounds")?;
    let limits = MoveBounds::of(design, generator, crf);
    let moves =
        named_moves(design, &names, limits).context("moves").with_context(|| label.to_owned())?;
    for (option, is_given, name, is_moving) in [
        ("generator_bounds", generator.is_some(), "generator", moves.generator.is_some()),
        ("crf_bounds", crf.is_some(), "crf-pose", moves.crf_pose.is_some()),
    ] {
        if is_given && !is_moving {
            let text = format!("{option} needs {name:?} among moves");
            return Err(TrackwrightError::new_err(text).into());
        }
    }
    let moves = Moves { sensors: counts(keywords)?, kinds: kinds(keywords)?, ..moves };
    let has_sensors = !(moves.tool.is_empty() && moves.crf.is_empty());
    if !has_sensors && (moves.sensors.is_some() || !moves.kinds.is_empty()) {
        let text = "sensors and kinds need sensors that move, expected some in moves";
        return Err(TrackwrightError::new_err(text).into());
    }
    let sets = sets_of_sensors(design, &moves);
    if sets > MOST_SETS {
        let text = format!(
            "sensors and kinds: found {sets} sets of sensors, expected at most {MOST_SETS}: fewer \
             numbers or kinds"
        );
        return Err(TrackwrightError::new_err(text).into());
    }
    Ok(moves)
}

/// A number of sensors, or the least and the most.
fn counts(keywords: &Keywords) -> Done<Option<RangeInclusive<usize>>> {
    let Some(given) = keywords.object("sensors")? else { return Ok(None) };
    let found: Result<(usize, usize), _> =
        given.extract().or_else(|_: PyErr| given.extract().map(|count: usize| (count, count)));
    match found {
        Ok((least @ 1.., most @ ..=MOST_SENSORS)) if least <= most => Ok(Some(least..=most)),
        _ => {
            let text = format!(
                "sensors: found {given}, expected a number from 1 to {MOST_SENSORS}, or two, least first"
            );
            Err(TrackwrightError::new_err(text).into())
        }
    }
}

/// Kinds of sensors: degrees of freedom and cost, and diameter and length of the coil where they are
/// known.
fn kinds(keywords: &Keywords) -> Done<Vec<SensorChoice>> {
    let given: Option<Vec<Vec<f64>>> = keywords.value("kinds")?;
    let each = given.unwrap_or_default().into_iter().map(|kind| {
        let is_fine = |value: &f64| value.is_finite() && *value >= 0.0;
        let (dof, cost, coil) = match kind[..] {
            [dof, cost] => (dof, cost, None),
            [dof, cost, diameter_mm, length_mm] if diameter_mm > 0.0 && length_mm > 0.0 => {
                (dof, cost, Some(Coil { diameter_mm, length_mm }))
            }
            _ => (0.0, 0.0, None),
        };
        let degrees_of_freedom = [5, 6].into_iter().find(|known| f64::from(*known) == dof);
        match degrees_of_freedom {
            Some(degrees_of_freedom) if kind.iter().all(is_fine) => {
                Ok(SensorChoice { degrees_of_freedom, coil, cost })
            }
            _ => {
                let text = format!(
                    "kinds: found {kind:?}, expected (5 or 6, cost) or (5 or 6, cost, diameter_mm, length_mm)"
                );
                Err(TrackwrightError::new_err(text).into())
            }
        }
    });
    each.collect()
}

/// What is made least.
fn goal(keywords: &Keywords, world: &World, label: &str) -> Done<Goal> {
    let metric: Option<String> = keywords.value("metric")?;
    match (metric, world.document.design().requirement) {
        (Some(name), _) => Ok(Goal::Figure(Metric::named(&name).ok_or_else(|| {
            let known = trackwright_simulation::METRICS.iter().map(|metric| metric.name());
            let known = known.collect::<Vec<_>>().join(", ");
            TrackwrightError::new_err(format!("metric: found {name:?}, expected one of {known}"))
        })?)),
        (None, Some(requirement)) if !requirement.is_empty() => Ok(Goal::Requirement(requirement)),
        _ => {
            let text = format!(
                "{label}: found no requirement, expected one in the design, or a figure by metric"
            );
            Err(TrackwrightError::new_err(text).into())
        }
    }
}
