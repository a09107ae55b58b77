//! The search for one set of sensors: a coarse grid, a finer one, then steps off the grid, judged over
//! few poses first and as the study has it at the end.

use crate::bodies::{Bodies, Movable, Position, Slot};
use crate::choice::Choice;
use crate::constraint::{Constraint, pair_fault};
use crate::grid_search::{GridFound, GridLayout, GridSearch, layouts};
use crate::judge::{Judge, Judged};
use crate::outcome::OptimizeError;
use crate::places::PlacedSensor;
use crate::polish::{Found, polished, spread_out};
use crate::problem::Settings;
use crate::slot_grids::SlotGrids;
use crate::table::Table;
use rayon::prelude::*;
use std::sync::atomic::{AtomicU64, Ordering};
use trackwright_simulation::{CancelToken, Study, StudyError};
use trackwright_task::Task;

/// Part of the frame fits that the first, coarse grid may take, so that there is a first answer soon.
const FIRST_PART: f64 = 0.02;

/// Part that the grid may take.
const GRID_PART: f64 = 0.4;

/// Part that steps off the grid may take, over few poses.
const STEPS_PART: f64 = 0.2;

/// Part that the last steps may take, with the whole study.
const STUDY_PART: f64 = 0.3;

/// Parts of a search, for progress.
const PARTS: usize = 5;

/// Starts off the grid.
const STARTS: usize = 6;

/// Of them, those that are judged with the whole study.
const FINALISTS: usize = 3;

/// Layouts whose study is made where the grid's own order of the best is close: figures of few poses
/// are within this part of the study's.
const CLOSE: f64 = 0.03;
const MOST_STUDIES: usize = 24;

/// Layouts whose study a search still makes that is ended: the first answer, and the best over few poses.
const ENDED_STUDIES: usize = 2;

/// Layouts of the grid that are tried with the CRF elsewhere on its patch.
const LAYOUTS_ON_PATCH: usize = 3;

/// Two layouts are distinct if a sensor is farther from its place than this, or than twice the grid's
/// spacing.
const DISTINCT_MM: f64 = 5.0;

/// First steps off a grid whose spacing is not known.
const FIRST_STEP_MM: f64 = 5.0;

/// A layout with its study.
#[derive(Clone, Debug)]
pub(crate) struct Studied {
    pub position: Position,
    pub bodies: Bodies,
    pub judged: Judged,
}

/// What the search for one set of sensors comes to.
pub(crate) struct Searched {
    /// Distinct, the best first; empty where no layout is allowed.
    pub studied: Vec<Studied>,
    pub evaluations: u64,
    pub certain_to_mm: Option<f64>,
}

/// A search over grids.
struct Gridded {
    found: GridFound,
    /// Of each slot.
    places: Vec<Vec<PlacedSensor>>,
}

impl Gridded {
    fn position(&self, search: &Search, layout: &GridLayout) -> Position {
        let each = self.places.iter().zip(&layout.chosen).map(|(places, k)| places[*k].clone());
        search.movable.position(each.collect())
    }
}

/// One search.
pub(crate) struct Search<'a> {
    pub judge: &'a Judge<'a>,
    pub movable: Movable<'a>,
    pub settings: Settings,
    /// Ends the search with the best so far.
    pub enough: &'a CancelToken,
    /// Part of the frame fits that is this search's.
    pub share: f64,
    evaluations: AtomicU64,
}

impl<'a> Search<'a> {
    /// # Errors
    /// Bounds of poses that are no numbers.
    pub fn new(
        judge: &'a Judge<'a>,
        choice: &Choice,
        settings: Settings,
        (enough, share): (&'a CancelToken, f64),
    ) -> Result<Self, OptimizeError> {
        let movable = Movable::new(judge.problem, choice.bodies.clone(), choice.slots.clone())?;
        let evaluations = AtomicU64::new(0);
        Ok(Self { judge, movable, settings, enough, share, evaluations })
    }

    /// Runs it; `deliver` gets the best of each part of it.
    ///
    /// # Errors
    /// A slot without a place, and what [`Judge::study`] returns.
    pub fn run(
        &self,
        task: &Task,
        deliver: &mut dyn FnMut(&Studied, u64),
    ) -> Result<Searched, OptimizeError> {
        let start = self.start();
        let own = start.as_ref().map(|start| start.position.clone());
        let coarse = self.grid(FIRST_PART)?;
        let first: Vec<Position> = coarse
            .found
            .layouts
            .iter()
            .take(1)
            .map(|layout| coarse.position(self, layout))
            .collect();
        if let Some(studied) = self.studied(&first)?.first() {
            deliver(studied, self.evaluations.load(Ordering::Relaxed));
        }
        task.step(1, PARTS)?;
        let grid = self.grid(GRID_PART)?;
        task.step(2, PARTS)?;
        let (found, spacing_mm) = (&grid.found, self.slot_grids().spacing_mm(&grid.places));
        let step_mm = spacing_mm.unwrap_or(FIRST_STEP_MM).max(1.0);
        // A grid is of places; of poses there is none that all were judged of.
        let is_exhaustive = found.is_exhaustive && !self.movable.has_poses();
        // All that the few poses do not tell from the best.
        let best = found.layouts.first().map_or(f64::INFINITY, |layout| layout.value);
        let close = found.layouts.iter().take_while(|layout| layout.value <= best * (1.0 + CLOSE));
        let is_significant = close.count() <= MOST_STUDIES;
        let mut starts: Vec<Found> = Vec::new();
        let on_grid = found
            .layouts
            .iter()
            .map(|layout| Found { position: grid.position(self, layout), value: layout.value });
        let on_patch = self.on_the_patch(start.as_ref(), on_grid.clone().take(LAYOUTS_ON_PATCH));
        for found in start.into_iter().chain(on_grid).chain(on_patch) {
            let is_new = starts.iter().all(|other| {
                far_mm(&found.position, &other.position) > DISTINCT_MM.max(2.0 * step_mm)
            });
            if is_new {
                starts.push(found);
            }
        }
        starts.sort_by(|a, b| a.value.total_cmp(&b.value));
        starts.truncate(STARTS);
        let polished = self.off_grid(starts, step_mm, is_exhaustive && spacing_mm.is_some())?;
        task.step(3, PARTS)?;
        let mut positions = first;
        positions.extend(polished.into_iter().map(|found| found.position));
        let close: Vec<Position> = found
            .layouts
            .iter()
            .take(MOST_STUDIES)
            .take_while(|layout| layout.value <= best * (1.0 + CLOSE))
            .map(|layout| grid.position(self, layout))
            .collect();
        positions.extend(close);
        positions.extend(own);
        let studied = self.studied(&positions)?;
        if let Some(best) = studied.first() {
            deliver(best, self.evaluations.load(Ordering::Relaxed));
        }
        task.step(4, PARTS)?;
        let studied = self.last_steps(studied, step_mm, deliver)?;
        let certain_to_mm = spacing_mm.filter(|_| is_exhaustive && is_significant);
        let evaluations = self.evaluations.load(Ordering::Relaxed);
        Ok(Searched { studied, evaluations, certain_to_mm })
    }

    /// The layout as it is, put on the regions, where that is allowed.
    fn start(&self) -> Option<Found> {
        let each = self.movable.slots.iter().map(|slot| {
            let sensor = &self.movable.base.body(slot.body)?.sensors[slot.index];
            self.movable.places(slot.body)?.nearest(sensor)
        });
        let position = self.movable.position(each.collect::<Option<Vec<_>>>()?);
        let value = self.value(&position, f64::INFINITY).ok().flatten()?;
        Some(Found { position, value })
    }

    /// The start and some layouts with the CRF at poses that are spread over its patch, the best first.
    fn on_the_patch(
        &self,
        start: Option<&Found>,
        layouts: impl Iterator<Item = Found>,
    ) -> Vec<Found> {
        let foot_poses = self.movable.foot_poses();
        if foot_poses.is_empty() {
            return Vec::new();
        }
        let each = start.cloned().into_iter().chain(layouts).flat_map(|found| {
            let moved = foot_poses.iter().copied().map(Some);
            moved.map(move |foot_pose| Position { foot_pose, ..found.position.clone() })
        });
        let each: Vec<Position> = each.collect();
        let judged = each.into_par_iter().filter_map(|position| {
            let value = self.value(&position, f64::INFINITY).ok().flatten()?;
            Some(Found { position, value })
        });
        let mut found: Vec<Found> = judged.collect();
        found.sort_by(|a, b| a.value.total_cmp(&b.value));
        found
    }

    fn affordable(&self, part: f64) -> f64 {
        let fits = self.judge.few_fits(&self.movable.base) as f64;
        self.settings.most_fits as f64 * self.share * part / fits.max(1.0)
    }

    fn slot_grids(&self) -> SlotGrids<'_, 'a> {
        SlotGrids { movable: &self.movable }
    }

    /// Searches grids of as many places as a part of the frame fits affords.
    fn grid(&self, part: f64) -> Result<Gridded, OptimizeError> {
        let grids = self.slot_grids();
        let places = grids.places(self.affordable(part))?;
        let mut found = GridFound::default();
        if !places.is_empty() {
            let (alike, slots) = (grids.alike(), &self.movable.slots);
            let table = Table::new(self.judge, &self.movable.base, slots, &places)?;
            let search =
                GridSearch::new(&self.movable, &table, slots, &places, &alike, self.enough);
            let affordable = self.affordable(part);
            let counts: Vec<usize> = places.iter().map(Vec::len).collect();
            found = match layouts(&counts, &alike) <= 1.2 * affordable {
                true => search.all(),
                false => search.by_exchanges(self.settings.seed, affordable as u64),
            };
        }
        self.evaluations.fetch_add(found.evaluations, Ordering::Relaxed);
        Ok(Gridded { found, places })
    }

    /// Steps off the grid from each start, over few poses.
    fn off_grid(
        &self,
        starts: Vec<Found>,
        step_mm: f64,
        is_known: bool,
    ) -> Result<Vec<Found>, OptimizeError> {
        if starts.is_empty() {
            return Ok(starts);
        }
        let each = (self.affordable(STEPS_PART) / starts.len() as f64) as u64;
        let starts = starts.into_par_iter().enumerate();
        let mut found: Vec<Found> = starts
            .map(|(number, start)| {
                let value = |position: &Position, best: f64| self.value(position, best);
                // From the best of all layouts of a fine grid there is no far way to go.
                let start = match is_known {
                    true => start,
                    false => {
                        let seed = self.settings.seed.wrapping_add(1 + number as u64);
                        spread_out(&self.movable, &start, 2.0 * step_mm, (each / 2, seed), value)
                    }
                };
                polished(&self.movable, &start, step_mm, each / 2, value)
            })
            .collect();
        found.sort_by(|a, b| a.value.total_cmp(&b.value));
        Ok(found)
    }

    /// The study of each, the best first; those that are not allowed are left out, and of near ones all
    /// but the best.
    fn studied(&self, positions: &[Position]) -> Result<Vec<Studied>, OptimizeError> {
        let mut all = Vec::new();
        for position in positions {
            if self.enough.is_cancelled() && all.len() >= ENDED_STUDIES {
                break;
            }
            all.extend(self.study(position)?);
        }
        Ok(distinct(all))
    }

    fn study(&self, position: &Position) -> Result<Option<Studied>, StudyError> {
        if !self.is_allowed(position) {
            return Ok(None);
        }
        let bodies = self.movable.bodies(position);
        self.evaluations.fetch_add(1, Ordering::Relaxed);
        // Whoever has enough still gets the study of the best.
        let judged = self.judge.study(&bodies, &CancelToken::default())?;
        Ok(judged.map(|judged| Studied { position: position.clone(), bodies, judged }))
    }

    /// Steps with the whole study from each of the best.
    fn last_steps(
        &self,
        studied: Vec<Studied>,
        step_mm: f64,
        deliver: &mut dyn FnMut(&Studied, u64),
    ) -> Result<Vec<Studied>, OptimizeError> {
        if self.enough.is_cancelled() {
            return Ok(studied);
        }
        let most_fits = self.settings.most_fits as f64 * self.share * STUDY_PART;
        let study_fits: usize =
            studied.first().map_or(1, |best| best.judged.studies.iter().map(fits).sum());
        let each = (most_fits / study_fits.max(1) as f64 / FINALISTS as f64) as u64;
        let (finalists, rest) = studied.split_at(FINALISTS.min(studied.len()));
        let mut all = rest.to_vec();
        for finalist in finalists {
            let start =
                Found { position: finalist.position.clone(), value: finalist.judged.objective };
            let value = |position: &Position, _: f64| match self.enough.is_cancelled() {
                true => Err(()),
                false => match self.study(position) {
                    Ok(studied) => Ok(studied.map(|studied| studied.judged.objective)),
                    Err(_) => Err(()),
                },
            };
            let found = polished(&self.movable, &start, step_mm / 4.0, each, value);
            match self.study(&found.position)? {
                Some(studied) => {
                    deliver(&studied, self.evaluations.load(Ordering::Relaxed));
                    all.push(studied);
                }
                None => all.push(finalist.clone()),
            }
        }
        Ok(distinct(all))
    }

    /// What a position comes to over few poses; `None` of what is not allowed, an error where the
    /// search is to end. Whether the body holds the coils costs most, and is looked at where the
    /// value is below the best.
    pub fn value(&self, position: &Position, best: f64) -> Result<Option<f64>, ()> {
        if self.enough.is_cancelled() {
            return Err(());
        }
        let bodies = self.movable.bodies(position);
        if !self.movable.is_on_patch(position)
            || self.has_near_pair(&bodies)
            || self.judge.determination_fault(&bodies).is_some()
        {
            return Ok(None);
        }
        self.evaluations.fetch_add(1, Ordering::Relaxed);
        let value = self.judge.few_value(&bodies).map_err(|_| ())?;
        let is_best = value.is_some_and(|value| value < best);
        let is_allowed = !is_best || self.holds_all(position);
        Ok(value.filter(|_| is_allowed))
    }

    /// Whether a sensor that moves is too near to another one of its body: each pair once.
    fn has_near_pair(&self, bodies: &Bodies) -> bool {
        let slots = &self.movable.slots;
        (0..slots.len())
            .any(|number| self.pair_fault_of(bodies, number, &slots[..number]).is_some())
    }

    /// What stands in the way between a slot's sensor and the others of its body but those of some slots.
    fn pair_fault_of(&self, bodies: &Bodies, number: usize, but: &[Slot]) -> Option<Constraint> {
        let slot = self.movable.slots[number];
        let gap_mm = self.movable.places(slot.body)?.body.mounting.least_gap_mm;
        let sensors = &bodies.body(slot.body)?.sensors;
        let own = &sensors[slot.index];
        let is_left_out =
            |index: usize| index == slot.index || but.contains(&Slot { index, ..slot });
        let others = sensors.iter().enumerate().filter(|(index, _)| !is_left_out(*index));
        others.map(|(_, other)| other).find_map(|other| pair_fault(own, other, gap_mm))
    }

    /// Whether each sensor may be at its place by itself.
    fn holds_all(&self, position: &Position) -> bool {
        let each = self.movable.slots.iter().zip(&position.places);
        each.into_iter().all(|(slot, place)| {
            let places = self.movable.places(slot.body);
            places.is_some_and(|places| places.fault(place).is_none())
        })
    }

    /// Whether nothing stands in the way of a position: what costs least is looked at first.
    pub fn is_allowed(&self, position: &Position) -> bool {
        let bodies = self.movable.bodies(position);
        self.movable.is_on_patch(position)
            && !self.has_near_pair(&bodies)
            && self.holds_all(position)
            && self.judge.determination_fault(&bodies).is_none()
    }

    /// What stands in the way of one sensor's place.
    pub fn fault_of(&self, position: &Position, number: usize) -> Option<Constraint> {
        let places = self.movable.places(self.movable.slots[number].body)?;
        self.pair_fault_of(&self.movable.bodies(position), number, &[])
            .or_else(|| places.fault(&position.places[number]))
    }
}

/// Time of a trial in a drawn field, which has to be drawn, over that of a trial in the room's own. For the
/// built-in pointer it is 2.4 (a study takes 11.8 ms with its figures and 2.1 ms without); more is counted, so
/// that a search of three sensors ends within its 30 s on two cores.
const DRAWN_FITS: usize = 4;

/// Frame fits that take as long as a study with its figures.
fn fits(study: &Study) -> usize {
    let drawn = study.figures.drawn.map_or(0, |drawn| drawn.draws * drawn.trials);
    study.room_field.trials + DRAWN_FITS * drawn
}

/// The farthest that a sensor, or a pose, is from where it is in another layout.
fn far_mm(one: &Position, other: &Position) -> f64 {
    let places = one.places.iter().zip(&other.places);
    let sensors = places.map(|(a, b)| {
        let way = a.sensor.position_in_body - b.sensor.position_in_body;
        // A turned axis counts by what it moves half a coil's length by.
        let turn = match (a.sensor.axis_in_body(), b.sensor.axis_in_body()) {
            (Some(a), Some(b)) => a.dot(&b).clamp(-1.0, 1.0).abs().acos() * 10.0,
            _ => 0.0,
        };
        way.norm().max(turn)
    });
    let poses = [(&one.generator, &other.generator), (&one.crf_pose, &other.crf_pose)];
    let poses = poses.into_iter().flat_map(|(a, b)| a.iter().zip(b).map(|(a, b)| (a - b).abs()));
    let foot_pose = one.foot_pose.zip(other.foot_pose).map(|(a, b)| {
        let way_mm = (a.foot.position_mm - b.foot.position_mm).norm();
        way_mm.max((a.turn_deg - b.turn_deg).abs())
    });
    sensors.chain(poses).chain(foot_pose).fold(0.0, f64::max)
}

/// The best first, of those that are near each other the best alone.
fn distinct(mut all: Vec<Studied>) -> Vec<Studied> {
    all.sort_by(|a, b| a.judged.objective.total_cmp(&b.judged.objective));
    let mut out: Vec<Studied> = Vec::new();
    for studied in all {
        if out.iter().all(|other| far_mm(&studied.position, &other.position) > DISTINCT_MM) {
            out.push(studied);
        }
    }
    out
}
