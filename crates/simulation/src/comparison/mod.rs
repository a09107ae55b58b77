//! Designs beside each other: every design in every room, and what each differs from a baseline by.
//!
//! A row's figures are those of a study of its own, to the bit. The verdict on a difference
//! is in `difference.rs`, what it rests on in `sampled.rs` and [`trackwright_field::validity::FieldDraws`].

mod difference;
mod measured_fields;
pub mod sampled;
mod words;

pub use super::study::{NoFigures, mode_of};
pub use difference::{COVERAGE, Difference, DifferenceVerdict, LEAST_DEG, LEAST_MM, Least};
pub use words::{difference_words, met_words, notes, worst_place_words, worst_words};

use super::judgement::{Verdict, unsettled};
use super::metric::MetricValues;
use super::profile::{trial_offsets, trial_pose};
use super::run::StudyError;
use super::scenario::{InputTrial, Scenario};
use super::study::{Study, study_with_figures};
use difference::{Side, between_rooms, differences};
use measured_fields::MeasuredFields;
use rayon::prelude::*;
use sampled::{Drawn, DrawnAt, DrawnFrom, Sampled, range_trials};
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use trackwright_field::Environment;
use trackwright_field::validity::DrawError;
use trackwright_geometry::pose::Pose;
use trackwright_task::{Cancelled, Task};

/// What is compared.
#[derive(Clone, Debug)]
pub struct Plan {
    pub rooms: Vec<Arc<Environment>>,
    /// A row each, in this order.
    pub pairs: Vec<Pair>,
    /// Number of the design that the others are held against.
    pub baseline: usize,
}

/// A design in a room, by their numbers.
#[derive(Clone, Debug)]
pub struct Pair {
    pub design: usize,
    /// Of [`Plan::rooms`], which the scenario is in.
    pub room: usize,
    pub scenario: Scenario,
}

/// How closely differences are looked at.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// Fields that the room's fit might as well have given. Their spread is known to
    /// `1 / sqrt(2 draws)`: 9 % for 64, which Student's t allows for.
    pub draws: usize,
    /// Independent looks at the range of motion.
    pub replicates: usize,
    /// Poses of each, a power of two.
    pub poses_each: usize,
    /// So many of the looks are tried in each drawn field.
    pub drawn_replicates: usize,
    pub least: Least,
    pub seed: u64,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            draws: 64,
            replicates: 8,
            poses_each: 128,
            drawn_replicates: 2,
            least: Least::default(),
            seed: 0,
        }
    }
}

/// All rows.
#[derive(Clone, Debug, PartialEq)]
pub struct Comparison {
    pub baseline: usize,
    pub rows: Vec<Row>,
    /// Of each room, why it does not state how far its field may be off; `None` where it does.
    pub rooms_unknown: Vec<Option<RoomUnknown>>,
}

/// One design in one room.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    pub design: usize,
    pub room: usize,
    pub measured: Result<Measured, NoFigures>,
    /// `None` for the baseline itself, and where it or the row has no figures.
    pub against_baseline: Option<AgainstBaseline>,
}

/// A row's study.
#[derive(Clone, Debug, PartialEq)]
pub struct Measured {
    pub study: Study,
    pub worst_pose: WorstPose,
    sampled: Option<Sampled>,
    drawn: Option<Drawn>,
    /// In the very fields that the design's are from, where the baseline is in the same room and
    /// fields are drawn for a pair of designs.
    drawn_baseline: Option<Drawn>,
}

/// Where the tool is in its worst trial.
#[derive(Clone, Debug, PartialEq)]
pub struct WorstPose {
    pub crf_from_tool: Pose,
    /// From the design's own pose, along each axis that moves: mm for x, y, z, degrees for rx, ry, rz.
    pub offsets: Vec<(&'static str, f64)>,
}

/// A row less the baseline's.
#[derive(Clone, Debug, PartialEq)]
pub struct AgainstBaseline {
    /// The baseline's row.
    pub row: usize,
    /// One of each of [`METRICS`](super::METRICS).
    pub differences: Vec<Difference>,
    /// Their ranges of motion are not the same.
    pub motion_differs: bool,
    pub requirement_differs: bool,
    /// Each is in its own room, and nothing of the rooms' errors cancels.
    pub room_differs: bool,
}

/// Why nobody knows how far a room's field may be off.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum RoomUnknown {
    #[error("it keeps no standard error of its field")]
    NoSupport,
    #[error(transparent)]
    Draws(#[from] DrawError),
    #[error("no pose of the range of motion is left in it")]
    NoPoses,
}

/// Runs every pair, and holds each against the baseline in its room, or in the baseline's own. The
/// result does not depend on the number of threads.
///
/// # Errors
/// [`Cancelled`]; what stands in the way of one row is that row's.
pub fn compare(plan: &Plan, settings: &Settings, task: &Task) -> Result<Comparison, Cancelled> {
    let mut measured: Vec<Option<Result<Measured, NoFigures>>> = vec![None; plan.pairs.len()];
    let mut rooms_unknown = Vec::with_capacity(plan.rooms.len());
    let mut done = 0;
    for (room, environment) in plan.rooms.iter().enumerate() {
        let of_room: Vec<usize> =
            (0..plan.pairs.len()).filter(|&pair| plan.pairs[pair].room == room).collect();
        let end = done + of_room.len();
        let all = plan.pairs.len().max(1) as f64;
        let task = task.subtask(done as f64 / all, end as f64 / all);
        let in_room = InRoom { plan, settings, pairs: &of_room, room };
        let RoomRows { rows, unknown } = in_room.measure(environment, &task)?;
        for (pair, row) in of_room.iter().zip(rows) {
            measured[*pair] = Some(row);
        }
        rooms_unknown.push(unknown);
        done = end;
    }
    let measured: Vec<_> = measured
        .into_iter()
        .map(|row| row.unwrap_or(Err(NoFigures::Study(StudyError::NoTrials))))
        .collect();
    let against: Vec<_> = (0..plan.pairs.len())
        .map(|pair| against_baseline(plan, &measured, pair, settings.least))
        .collect();
    let each = plan.pairs.iter().zip(measured).zip(against);
    let rows = each.map(|((pair, measured), against_baseline)| Row {
        design: pair.design,
        room: pair.room,
        measured,
        against_baseline,
    });
    Ok(Comparison { baseline: plan.baseline, rows: rows.collect(), rooms_unknown })
}

fn against_baseline(
    plan: &Plan,
    measured: &[Result<Measured, NoFigures>],
    pair: usize,
    least: Least,
) -> Option<AgainstBaseline> {
    let own = &plan.pairs[pair];
    if own.design == plan.baseline {
        return None;
    }
    let of_baseline = |room: Option<usize>| {
        plan.pairs
            .iter()
            .position(|p| p.design == plan.baseline && room.is_none_or(|room| p.room == room))
    };
    let row = of_baseline(Some(own.room)).or_else(|| of_baseline(None))?;
    let (Ok(design), Ok(baseline)) = (&measured[pair], &measured[row]) else {
        return None;
    };
    let known = [design, baseline].map(Measured::values);
    let in_own_field = [design, baseline].map(|m| m.study.room_field.values());
    let theirs = &plan.pairs[row];
    let mut baseline_side = baseline.side(&known[1], &in_own_field[1]);
    if own.room == theirs.room && design.drawn_baseline.is_some() {
        baseline_side.drawn = design.drawn_baseline.as_ref();
    }
    let room_differs = own.room != theirs.room;
    let differences = differences(design.side(&known[0], &in_own_field[0]), baseline_side, least);
    Some(AgainstBaseline {
        row,
        differences: match room_differs {
            true => between_rooms(differences),
            false => differences,
        },
        motion_differs: own.scenario.motion != theirs.scenario.motion,
        requirement_differs: own.scenario.requirement != theirs.scenario.requirement,
        room_differs,
    })
}

impl Measured {
    /// Whether the requirement is met, as far as the room determines it; `None` without one.
    pub fn verdict(&self) -> Option<Verdict> {
        Some(self.study.figures.requirement.as_ref()?.verdict)
    }

    /// What is known of the figures; a row that is measured has them all.
    fn values(&self) -> MetricValues {
        let of = |k: usize| self.study.figures.all.get(k).map_or(f64::NAN, |figure| figure.value);
        std::array::from_fn(of)
    }

    fn side<'a>(&'a self, grid: &'a MetricValues, own: &'a MetricValues) -> Side<'a> {
        Side {
            grid,
            own,
            sampled: self.sampled.as_ref(),
            drawn: self.drawn.as_ref(),
            unsettled: unsettled(&self.study.room_field).map(|(why, _)| why),
        }
    }
}

/// The pairs of one room.
struct InRoom<'a> {
    plan: &'a Plan,
    settings: &'a Settings,
    pairs: &'a [usize],
    room: usize,
}

/// The rows of one room, in the order of its pairs.
struct RoomRows {
    rows: Vec<Result<Measured, NoFigures>>,
    unknown: Option<RoomUnknown>,
}

/// A study, and where it is tried in other fields.
type Studied = Result<(Measured, DrawnAt), NoFigures>;

/// Part of a room's time that its studies take, for progress only.
const STUDIES_PART: f64 = 0.3;

impl InRoom<'_> {
    fn measure(&self, environment: &Arc<Environment>, task: &Task) -> Result<RoomRows, Cancelled> {
        let done = AtomicUsize::new(0);
        let studies = task.subtask(0.0, STUDIES_PART);
        let mut studied: Vec<Studied> = self
            .pairs
            .par_iter()
            .map(|&pair| {
                let studied = self.study(&self.plan.pairs[pair].scenario, task);
                studies.step(1 + done.fetch_add(1, Ordering::Relaxed), self.pairs.len())?;
                studied
            })
            .collect::<Result<_, Cancelled>>()?;
        // With nothing to compare, nothing is drawn.
        let is_needed = self.plan.pairs.iter().any(|p| p.design != self.plan.baseline);
        let has_any = studied.iter().any(Result::is_ok);
        let mut unknown = None;
        if is_needed && has_any {
            let drawing = task.subtask(STUDIES_PART, 1.0);
            unknown = match environment.states_uncertainty() {
                true => self.draw_from(environment, &mut studied, &drawing)?,
                false => match self.drawn_rooms(environment, task)? {
                    Ok(rooms) => self.try_in(&rooms, environment, &mut studied, &drawing)?,
                    Err(why) => Some(why),
                },
            };
        }
        let rows = studied.into_iter().map(|s| s.map(|(measured, _)| measured));
        Ok(RoomRows { rows: rows.collect(), unknown })
    }

    /// The study itself, and the looks between its poses.
    fn study(&self, scenario: &Scenario, task: &Task) -> Result<Studied, Cancelled> {
        let settings = self.settings;
        match studied(scenario, settings, task) {
            Ok(studied) => Ok(studied),
            Err(StudyError::Cancelled) => Err(Cancelled),
            Err(error) => Ok(Err(NoFigures::Study(error))),
        }
    }

    /// The room with each field that its fit might as well have given.
    fn drawn_rooms(
        &self,
        environment: &Arc<Environment>,
        task: &Task,
    ) -> Result<Result<Vec<Arc<Environment>>, RoomUnknown>, Cancelled> {
        let Some(support) = &environment.fit_validity else {
            return Ok(Err(RoomUnknown::NoSupport));
        };
        let ridge = environment.provenance.as_ref().map_or(0.0, |p| p.ridge);
        // Rooms were measured one by one: no two have the same noise.
        let seed = self.settings.seed.wrapping_add(1 + self.room as u64);
        let quiet = Task::cancelled_by(task.cancel.clone());
        match support.draw(&environment.model, ridge, self.settings.draws, seed, &quiet) {
            Err(DrawError::Cancelled(cancelled)) => Err(cancelled),
            Err(why) => Ok(Err(why.into())),
            Ok(drawn) => {
                let rooms = drawn.models.into_iter().map(|model| {
                    Arc::new(Environment {
                        volume: environment.volume,
                        jitter: environment.jitter,
                        ..Environment::of_model("", model)
                    })
                });
                Ok(Ok(rooms.collect()))
            }
        }
    }

    /// Figures of each design beside the baseline's in fields drawn for the two.
    fn draw_from(
        &self,
        environment: &Environment,
        studied: &mut [Studied],
        task: &Task,
    ) -> Result<Option<RoomUnknown>, Cancelled> {
        let seed = self.settings.seed.wrapping_add(1 + self.room as u64);
        let draws = self.settings.draws;
        let pair = |place: usize| &self.plan.pairs[self.pairs[place]];
        let is_baseline = |place: usize| pair(place).design == self.plan.baseline;
        let baseline = (0..studied.len()).find(|place| is_baseline(*place));
        let baseline_at = baseline.and_then(|place| {
            let (_, at) = studied[place].as_ref().ok()?;
            Some((&pair(place).scenario, at))
        });
        let mut found = Vec::with_capacity(studied.len());
        for (place, studied) in studied.iter().enumerate() {
            task.step(place, self.pairs.len())?;
            let Ok((_, at)) = studied else {
                found.push(None);
                continue;
            };
            let scenario = &pair(place).scenario;
            let compared = baseline_at.filter(|_| !is_baseline(place));
            found.push(MeasuredFields::draw(environment, (scenario, at), compared, draws, seed));
        }
        let mut unknown = None;
        for (studied, found) in studied.iter_mut().zip(found) {
            let Ok((measured, _)) = studied else { continue };
            match found {
                Some(fields) => {
                    measured.drawn = Some(fields.own);
                    measured.drawn_baseline = fields.baseline;
                }
                None => unknown = Some(RoomUnknown::NoPoses),
            }
        }
        Ok(unknown)
    }

    /// Tries every design in every drawn field.
    fn try_in(
        &self,
        drawn: &[Arc<Environment>],
        nominal: &Arc<Environment>,
        studied: &mut [Studied],
        task: &Task,
    ) -> Result<Option<RoomUnknown>, Cancelled> {
        let rooms: Vec<&Arc<Environment>> = std::iter::once(nominal).chain(drawn).collect();
        let of_pair = rooms.len();
        let jobs = studied.len() * of_pair;
        let done = AtomicUsize::new(0);
        let found: Vec<Option<MetricValues>> = (0..jobs)
            .into_par_iter()
            .map(|job| {
                let (pair, room) = (job / of_pair, job % of_pair);
                task.step(done.fetch_add(1, Ordering::Relaxed), jobs)?;
                let Ok((_, at)) = &studied[pair] else {
                    return Ok(None);
                };
                let scenario = &self.plan.pairs[self.pairs[pair]].scenario;
                match at.figures(scenario, rooms[room], &task.cancel) {
                    Err(StudyError::Cancelled) => Err(Cancelled),
                    found => Ok(found.ok().flatten()),
                }
            })
            .collect::<Result<_, Cancelled>>()?;
        let mut unknown = None;
        for (studied, found) in studied.iter_mut().zip(found.chunks(of_pair)) {
            let Ok((measured, _)) = studied else { continue };
            let all: Option<Vec<MetricValues>> = found.iter().copied().collect();
            measured.drawn = all.and_then(|all| {
                let (nominal, draws) = all.split_first()?;
                Some(Drawn { nominal: *nominal, draws: draws.to_vec(), from: DrawnFrom::Refits })
            });
            if measured.drawn.is_none() {
                unknown = Some(RoomUnknown::NoPoses);
            }
        }
        Ok(unknown)
    }
}

/// The study, its looks at the range, and the poses that are tried in drawn fields.
fn studied(scenario: &Scenario, settings: &Settings, task: &Task) -> Result<Studied, StudyError> {
    let mode = mode_of(scenario);
    let own = match study_with_figures(scenario, &mode, &task.cancel) {
        Ok(Ok(own)) => own,
        Ok(Err(why)) => return Ok(Err(why)),
        Err(Cancelled) => return Err(StudyError::Cancelled),
    };
    let at = |trial: usize| trial_pose(scenario, &mode, trial);
    let extremes: Vec<InputTrial> = own.extremes.iter().copied().filter_map(at).collect();
    let looks = range_trials(scenario, settings.replicates, settings.poses_each, settings.seed);
    let sampled = Sampled::of(scenario, &looks, &task.cancel)?;
    let tried = &looks[..settings.drawn_replicates.min(looks.len())];
    let drawn_at = DrawnAt::new(scenario, tried, &extremes);
    let worst = own.room_field.worst.trial;
    let worst_pose = WorstPose {
        crf_from_tool: at(worst).map_or(scenario.crf_from_tool, |t| t.crf_from_tool),
        offsets: trial_offsets(scenario, &mode, worst),
    };
    let measured = Measured { study: own, worst_pose, sampled, drawn: None, drawn_baseline: None };
    Ok(Ok((measured, drawn_at)))
}
