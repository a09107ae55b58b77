//! The manufacturing sheet: where each sensor sits, and how far off it may be before the requirement
//! fails.
//!
//! A tool is built with sensors that are not quite where its design has them, and the tracker's
//! software assumes the design. [`manufacturing_sheet`] states for each sensor how far off it may
//! be alone, and for each body how far off all of its sensors may be at once, with those of the
//! other body off too; [`check_built`] draws tools that are off within that and simulates them. How
//! it is found, and what it means, is in `docs/methods/tolerances.md`.

pub mod as_built;
pub mod built_check;
pub mod first_order;
pub mod geometry;
pub mod search;
mod sheet;

pub use as_built::AS_DRAWN;
pub use built_check::{BuiltCheck, MAX_DRAWS, check_built};
pub use search::nearest_bound;
pub use sheet::{
    BuiltBody, ManufacturingSheet, NoTolerance, SheetAxis, SheetBody, SheetPair, SheetSensor,
    Tolerance, Tolerances, Within, rounded_down, stated_decimals,
};

use super::judgement::{Judgement, Undecided};
use super::metric::ErrorOf;
use super::requirement::Check;
use super::requirement::Requirement;
use super::run::StudyError;
use super::scenario::Scenario;
use super::study::{NoFigures, mode_of, study};
use super::work::Work;
use as_built::{BuildErrors, BuiltBuffers, BuiltStudy};
use first_order::{Direction, FirstOrder};
use rayon::prelude::*;
use search::{Cost, Family, Found, Search, worst_ratio};
use std::sync::atomic::{AtomicUsize, Ordering};
use trackwright_task::{Cancelled, Task};

/// As far as tolerances are looked for: nobody builds sensors that are further off, and an error of
/// the size of the tool is another tool.
pub const MAX_POSITION_MM: f64 = 10.0;
pub const MAX_ANGLE_DEG: f64 = 20.0;

/// Sensors of both bodies up to which tolerances are looked for: the time grows with their square.
pub const MAX_SENSORS: usize = 64;

/// Smallest number that is stated, mm or degrees.
const SMALLEST: f64 = 1e-3;

/// Why there are no tolerances.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
enum NoTolerances {
    #[error(transparent)]
    Study(StudyError),
    #[error(
        "the design states no requirement, so there is no limit to compare with; state it in the \
         design as requirement: (position_rms: 1.0, angle_rms: 0.5), in mm and degrees"
    )]
    NoRequirement,
    #[error(
        "the requirement is missed with every sensor where it is drawn: {name} is {value:.4}, at most \
         {limit} is allowed"
    )]
    Missed { name: &'static str, value: f64, limit: f64 },
    #[error(transparent)]
    NoFigures(NoFigures),
    #[error("it is not determined whether the requirement is met as drawn: {0}")]
    Unsettled(Undecided),
    #[error("{found} sensors, expected at most {MAX_SENSORS} in tool and CRF together")]
    TooManySensors { found: usize },
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

impl From<StudyError> for NoTolerances {
    fn from(error: StudyError) -> Self {
        match error {
            StudyError::Cancelled => Self::Cancelled(Cancelled),
            other => Self::Study(other),
        }
    }
}

/// The sheet of a design: of its range of motion, or of its pose where it has none. Where there can
/// be no tolerances it states why. The result does not depend on the number of threads.
///
/// # Errors
/// [`Cancelled`].
pub fn manufacturing_sheet(
    scenario: &Scenario,
    task: &Task,
) -> Result<ManufacturingSheet, Cancelled> {
    let mut bodies = vec![geometry::sheet_body(BuiltBody::Tool, &scenario.tool)];
    let crf = scenario.crf.as_ref();
    bodies.extend(crf.map(|crf| geometry::sheet_body(BuiltBody::Crf, &crf.body)));
    let mut sheet = ManufacturingSheet {
        poses: 0,
        study_poses: 0,
        study_outside: 0,
        as_drawn: Vec::new(),
        requirement: None,
        no_tolerances: None,
        free_axis: None,
        poorly_determined: false,
        barely_determined: None,
        coils: Vec::new(),
        bodies,
        together_worst: Vec::new(),
        simulations: 0,
        work: Work::default(),
    };
    match find(scenario, &mut sheet, task) {
        Ok(()) => Ok(sheet),
        Err(NoTolerances::Cancelled(cancelled)) => Err(cancelled),
        Err(reason) => {
            sheet.no_tolerances = Some(reason.to_string());
            Ok(sheet)
        }
    }
}

fn find(
    scenario: &Scenario,
    sheet: &mut ManufacturingSheet,
    task: &Task,
) -> Result<(), NoTolerances> {
    let mode = mode_of(scenario);
    let found = study(scenario, &mode, &task.cancel, None)?;
    let no_overlap = found.no_overlap();
    let room_field = found.room_field;
    sheet.requirement = found.figures.requirement;
    sheet.study_poses = room_field.trials;
    sheet.study_outside = room_field.outside;
    sheet.free_axis = room_field.free_axis;
    sheet.poorly_determined = room_field.poorly_determined;
    sheet.barely_determined = room_field.barely_determined;
    sheet.work += found.work;
    if let Some(none) = no_overlap {
        return Err(NoTolerances::NoFigures(none));
    }
    let checks = |requirement: Requirement| {
        requirement.checks(&room_field.position_mm, &room_field.angle_deg)
    };
    sheet.as_drawn = scenario.requirement.map(checks).unwrap_or_default();
    let Some(requirement) = scenario.requirement.filter(|_| !sheet.as_drawn.is_empty()) else {
        return Err(NoTolerances::NoRequirement);
    };
    if let Some(missed) = sheet.as_drawn.iter().find(|check| !check.met) {
        return Err(NoTolerances::Missed {
            name: missed.metric.name(),
            value: missed.value,
            limit: missed.limit,
        });
    }
    let reason = sheet.requirement.as_ref().and_then(Judgement::reason);
    if let Some(why) = reason.filter(|why| why.is_of_study()) {
        return Err(NoTolerances::Unsettled(why.clone()));
    }
    let found = sheet.bodies.iter().map(|b| b.sensors.len()).sum();
    if found > MAX_SENSORS {
        return Err(NoTolerances::TooManySensors { found });
    }
    let study = BuiltStudy::new(scenario, requirement)?;
    sheet.poses = study.poses();
    sheet.work += study.own_work();
    let mut buffers = BuiltBuffers::default();
    study.simulate(&mut buffers, &BuildErrors::none(scenario), &task.cancel)?;
    let first_order = FirstOrder::new(&study, &buffers.simulated);
    let search = Search { study: &study, first_order: &first_order, cancel: &task.cancel };
    // Every sensor alone, then each kind of error of each body, then all together.
    let all = first_order.blocks.len() + 4 + 2;
    let done = AtomicUsize::new(0);
    let step = || task.step(done.fetch_add(1, Ordering::Relaxed), all);
    let alone: Result<Vec<(Tolerance, Cost)>, Cancelled> = (0..first_order.blocks.len())
        .into_par_iter()
        .map(|block| {
            step()?;
            alone(&search, block)
        })
        .collect();
    for (block, (tolerance, cost)) in first_order.blocks.iter().zip(alone?) {
        sheet.count(cost);
        let body = sheet.bodies.iter_mut().find(|b| b.role == block.body);
        let sensor = body.and_then(|b| b.sensors.get_mut(block.sensor));
        let Some(sensor) = sensor else { continue };
        let of_sensor = sensor.alone.get_or_insert_with(no_axis);
        *of_kind(of_sensor, block.kind) = tolerance;
    }
    together(&search, sheet, &step)
}

impl ManufacturingSheet {
    fn count(&mut self, cost: Cost) {
        self.simulations += cost.simulations;
        self.work += cost.work;
    }
}

/// What is returned until something is found.
fn no_axis() -> Tolerances {
    let none = Tolerance::None { none: NoTolerance::NoAxis };
    Tolerances { position_mm: none.clone(), angle_deg: none }
}

fn of_kind(tolerances: &mut Tolerances, kind: ErrorOf) -> &mut Tolerance {
    match kind {
        ErrorOf::Position => &mut tolerances.position_mm,
        ErrorOf::Angle => &mut tolerances.angle_deg,
    }
}

/// As far as is looked, mm or degrees, and what one of that unit is in the core's.
fn scale_of(kind: ErrorOf) -> (f64, f64) {
    match kind {
        ErrorOf::Position => (MAX_POSITION_MM, 1.0),
        ErrorOf::Angle => (MAX_ANGLE_DEG, 1.0_f64.to_radians()),
    }
}

/// Errors of one kind that are all of one size.
fn family_of(blocks: Vec<usize>, kind: ErrorOf) -> Family {
    let (cap, unit) = scale_of(kind);
    Family { sizes: vec![unit; blocks.len()], blocks, cap, floor: SMALLEST }
}

/// How far off one sensor may be, in position or in angle, all else as drawn.
fn alone(search: &Search, block: usize) -> Result<(Tolerance, Cost), Cancelled> {
    let family = family_of(vec![block], search.first_order.blocks[block].kind);
    let found = search.largest(&family)?;
    let mut cost = found.cost;
    let mut value = rounded_down(found.scale);
    while value >= SMALLEST {
        let sizes: Vec<f64> = family.sizes.iter().map(|size| size * value).collect();
        let checks = search.worst_at(&family.blocks, &sizes, &found.directions, &mut cost)?;
        if worst_ratio(&checks) <= 1.0 {
            let direction = found.limit.as_ref().and_then(|l| l.direction.first());
            let within = Within {
                value,
                simulated: found.scale,
                first_order: found.first_order,
                limited_by: limiting_check(search, &family.blocks, &sizes, &found, &mut cost)?,
                worst_direction: direction.map(|d| (*d).into()),
            };
            return Ok((Tolerance::Within(within), cost));
        }
        value = sheet::next_below(value);
    }
    let none = NoTolerance::NothingLeft;
    Ok((Tolerance::None { none }, cost))
}

/// The bound that limits what was found, with its figure at the sizes that are stated.
fn limiting_check(
    search: &Search,
    blocks: &[usize],
    sizes: &[f64],
    found: &Found,
    cost: &mut Cost,
) -> Result<Option<Check>, Cancelled> {
    let Some(limit) = &found.limit else {
        return Ok(None);
    };
    let checks = search.checks_at(blocks, sizes, &limit.direction, cost)?;
    Ok(checks.into_iter().find(|check| Some(check.metric) == limit.bound))
}

/// One kind of error of one body in the sheet's last step.
struct Share {
    body: BuiltBody,
    kind: ErrorOf,
    blocks: Vec<usize>,
    /// With all sensors of the body off by it and nothing else, mm or degrees.
    by_itself: f64,
    /// To be stated.
    value: f64,
}

/// How far off all sensors may be at once. Position and angle, tool and CRF share what the requirement
/// leaves: each gets the same part of what it might use up by itself.
fn together(
    search: &Search,
    sheet: &mut ManufacturingSheet,
    step: &(impl Fn() -> Result<(), Cancelled> + Sync),
) -> Result<(), NoTolerances> {
    let blocks = &search.first_order.blocks;
    let kinds: Vec<(BuiltBody, ErrorOf, Vec<usize>)> = [BuiltBody::Tool, BuiltBody::Crf]
        .into_iter()
        .flat_map(|body| ErrorOf::ALL.map(|kind| (body, kind)))
        .map(|(body, kind)| {
            let is_of = |i: &usize| blocks[*i].body == body && blocks[*i].kind == kind;
            (body, kind, (0..blocks.len()).filter(is_of).collect())
        })
        .filter(|(_, _, blocks): &(_, _, Vec<usize>)| !blocks.is_empty())
        .collect();
    let found: Result<Vec<Found>, Cancelled> = kinds
        .par_iter()
        .map(|(_, kind, blocks)| {
            step()?;
            search.largest(&family_of(blocks.clone(), *kind))
        })
        .collect();
    let mut shares = Vec::new();
    for ((body, kind, blocks), found) in kinds.into_iter().zip(found?) {
        sheet.count(found.cost);
        shares.push(Share { body, kind, blocks, by_itself: found.scale, value: 0.0 });
    }
    step()?;
    let whole = Family {
        blocks: shares.iter().flat_map(|s| s.blocks.clone()).collect(),
        sizes: sizes(&shares, |share| share.by_itself),
        cap: 1.0,
        floor: SMALLEST / MAX_ANGLE_DEG,
    };
    let found = search.largest(&whole)?;
    let mut cost = found.cost;
    let checks = state(search, &mut shares, &whole.blocks, &found, &mut cost)?;
    let sizes = sizes(&shares, |share| share.value);
    let limited_by = limiting_check(search, &whole.blocks, &sizes, &found, &mut cost)?;
    sheet.count(cost);
    for share in &shares {
        let body = sheet.bodies.iter_mut().find(|b| b.role == share.body);
        let Some(body) = body else { continue };
        let tolerance = match share.value >= SMALLEST {
            false => Tolerance::None { none: NoTolerance::NothingLeft },
            true => Tolerance::Within(Within {
                value: share.value,
                simulated: found.scale * share.by_itself,
                first_order: found.first_order * share.by_itself,
                limited_by,
                worst_direction: None,
            }),
        };
        *of_kind(body.together.get_or_insert_with(no_axis), share.kind) = tolerance;
    }
    sheet.together_worst = checks;
    Ok(step()?)
}

/// Rounds every share down, and gives the requirement in the worst case of that.
fn state(
    search: &Search,
    shares: &mut [Share],
    blocks: &[usize],
    found: &Found,
    cost: &mut Cost,
) -> Result<Vec<Check>, Cancelled> {
    let directions: &[Direction] = &found.directions;
    let mut scale = found.scale;
    loop {
        for share in &mut *shares {
            share.value = rounded_down(scale * share.by_itself);
        }
        let sizes = sizes(shares, |share| share.value);
        let checks = search.worst_at(blocks, &sizes, directions, cost)?;
        // Sizes of zero cannot be reduced.
        if worst_ratio(&checks) <= 1.0 || sizes.iter().all(|size| *size <= 0.0) {
            return Ok(checks);
        }
        scale *= 0.99;
    }
}

/// Of every block of the shares, mm or radians.
fn sizes(shares: &[Share], of: impl Fn(&Share) -> f64) -> Vec<f64> {
    let each = shares.iter();
    each.flat_map(|share| {
        let (_, unit) = scale_of(share.kind);
        vec![of(share) * unit; share.blocks.len()]
    })
    .collect()
}
