//! Compensation by the inverse of a distortion map: the pose behind a reading, or why there is
//! none.

mod contraction;
mod equations;
mod nets;
mod newton;
mod regions;
mod search;
mod signal_cells;
mod signal_equations;
mod signals;
mod slopes;
#[cfg(test)]
mod tests;
mod triangles;

use super::computed::DisturbedCoils;
use super::evaluation::OutsidePolicy;
use super::generator::reading::axis_error;
use super::model::DistortionModel;
use super::samples::PoseError;
use contraction::{Contraction, Stepped};
use equations::{AxisPose, Reading, Tolerance};
use newton::{Found, Newton, SINGULAR};
use rayon::prelude::*;
use regions::{Possible, Regions};
use search::Search;
use signals::Signals;
use std::sync::atomic::{AtomicUsize, Ordering};
use trackwright_geometry::directions::DirectionSet;
use trackwright_geometry::pose::{Pose, pose_from_parts};
use trackwright_geometry::rotation::exp_vector;
use trackwright_task::{Cancelled, Task};

pub use equations::{AXIS_TOLERANCE_RAD, POSITION_TOLERANCE_MM};

/// Readings that one core takes at a time: enough for a batch to have full lanes in most of its
/// triangles.
const CHUNK: usize = 1024;

/// The same where other answers are looked for, which takes most of the time.
const SEARCHED_CHUNK: usize = 32;

/// The pose behind a reading.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Undistorted {
    /// The answer, where there is one: converged or ambiguous.
    pub pose: Option<Pose>,
    /// Other poses that read the same, where no more than two were found.
    pub others: [Option<Pose>; 2],
    pub state: InverseState,
    /// Evaluations of the field.
    pub evaluations: usize,
    /// What is left of the equations at the answer, or where the search ended.
    pub residual_mm: f64,
    pub residual_rad: f64,
    /// Whether the answer, or where the search ended, lies in the model's box.
    pub is_inside: bool,
}

/// What became of a reading.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum InverseState {
    /// The equations hold, and nothing speaks for a second answer.
    Converged,
    /// The equations hold, but other poses may read the same.
    Ambiguous(Ambiguity),
    /// The map folds here: no answer is given.
    Folded { determinant: f64 },
    /// The equations do not hold anywhere that was searched.
    NotConverged,
    /// The search ended where the tracker reads nothing, as in metal.
    NoReading,
    /// The answer lies outside the box, and the policy leaves such out.
    Rejected,
}

/// Why an answer may not be the only one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Ambiguity {
    /// The determinant was not positive on the way to the answer.
    FoldOnTheWay { least_determinant: f64 },
    /// Another pose reads the same.
    SecondPreimage { distance_mm: f64, angle_rad: f64 },
    /// The area weights jump within reach of the answer.
    WeightJump,
    /// Within reach of the reading the field is too steep for a search to see every answer;
    /// 1 and more allows a second one.
    TooSteep { steepness: f64 },
}

/// The poses behind readings, by the inverse of a distortion model, on all cores.
///
/// ```
/// use trackwright_field::OutsidePolicy::Clamp;
/// use trackwright_field::inverse::undistort;
/// use trackwright_field::random_models::random_model;
/// use trackwright_geometry::directions::{DirectionSet, Weighting};
/// use trackwright_geometry::pose::Pose;
/// use trackwright_task::Task;
///
/// let model = random_model(2, DirectionSet::Fourteen, Weighting::Area, [1.0, 0.005], 7);
/// let pose = Pose::translation(10.0, 20.0, -300.0);
/// let (reading, _) = model.distort(&pose, Clamp);
/// let found = undistort(&model, &[reading], Clamp, &Task::default())?[0].pose.unwrap();
/// assert!((found.translation.vector - pose.translation.vector).norm() < 1e-9);
/// # Ok::<(), trackwright_task::Cancelled>(())
/// ```
///
/// # Errors
/// [`Cancelled`].
pub fn undistort(
    model: &DistortionModel,
    measured: &[Pose],
    outside: OutsidePolicy,
    task: &Task,
) -> Result<Vec<Undistorted>, Cancelled> {
    Inverse::new(model, outside).undistort(measured, task)
}

/// A distortion model made ready to be inverted.
#[derive(Clone, Debug)]
pub struct Inverse<'a> {
    newton: Newton<'a>,
    regions: Regions,
    /// Where the errors are made of coils' fields.
    signals: Option<Signals>,
}

impl<'a> Inverse<'a> {
    /// Bounds the slopes of a model, cell by cell where they are needed.
    pub fn new(model: &'a DistortionModel, outside: OutsidePolicy) -> Self {
        let diagonal_mm = model.bounds().diagonal_mm();
        let newton = Newton {
            model,
            outside,
            mm_per_rad: if diagonal_mm > 0.0 { diagonal_mm } else { 1.0 },
        };
        let signals = newton.coils().map(|made| Signals::of(made.coils, model.bounds()));
        Self { newton, regions: Regions::of(model, outside), signals }
    }

    /// Whether no two poses in the box can read the same, as the coefficients alone show; a
    /// model that is extrapolated is looked at a quarter of its box further on each side.
    pub fn is_one_to_one(&self) -> bool {
        self.signals.is_none() && self.regions.is_certain_everywhere()
    }

    /// The poses behind readings, on all cores; the answers do not depend on how many.
    ///
    /// # Errors
    /// [`Cancelled`].
    pub fn undistort(&self, measured: &[Pose], task: &Task) -> Result<Vec<Undistorted>, Cancelled> {
        let done = AtomicUsize::new(0);
        let mut found = vec![Undistorted::NOTHING; measured.len()];
        let chunk = if self.signals.is_some() { SEARCHED_CHUNK } else { CHUNK };
        found.par_chunks_mut(chunk).zip(measured.par_chunks(chunk)).try_for_each_init(
            Contraction::default,
            |contraction, (found, chunk)| {
                self.undistort_chunk(contraction, chunk, found, task)?;
                let done = done.fetch_add(chunk.len(), Ordering::Relaxed) + chunk.len();
                task.step(done, measured.len())
            },
        )?;
        Ok(found)
    }

    /// Steps all readings together where that is known to lead to the only answer, and searches
    /// for the others one by one.
    fn undistort_chunk(
        &self,
        contraction: &mut Contraction,
        measured: &[Pose],
        found: &mut [Undistorted],
        task: &Task,
    ) -> Result<(), Cancelled> {
        let Newton { model, outside, .. } = self.newton;
        let places: Vec<_> = measured.iter().map(AxisPose::of).collect();
        let possible = self.possible(&places);
        let tolerances: Vec<_> =
            places.iter().map(|place| Tolerance::of(model, &self.regions, place)).collect();
        let anywhere = self.regions.anywhere();
        let possible = |i: usize| possible.get(i).unwrap_or(&anywhere);
        // Where Newton goes on from what did not settle; the reading with its error off for most.
        let mut starts = Vec::new();
        found.fill(Undistorted::NOTHING);
        contraction.run(
            model,
            outside,
            &places,
            &tolerances,
            |i| places[i].is_finite() && possible(i).is_certain(),
            |i, stepped| {
                let is_read = self.newton.is_read(stepped.is_inside, &stepped.place);
                let has_settled = stepped.has_settled && is_read;
                if has_settled && self.others(&places[i], Some(&stepped.place)).is_empty() {
                    found[i] = self.settled(&measured[i], possible(i), &stepped);
                } else {
                    starts.push((i, Some(stepped.place)));
                }
            },
        );
        let uncertain = (0..places.len()).filter(|&i| !possible(i).is_certain());
        starts.extend(uncertain.filter(|&i| places[i].is_finite()).map(|i| (i, None)));
        for (i, start) in starts {
            if task.cancel.is_cancelled() {
                return Err(Cancelled);
            }
            let search = self.search(&places[i], &tolerances[i], start, possible(i));
            found[i] = self.found(&measured[i], &places[i], &search, possible(i));
        }
        Ok(())
    }

    /// Poses by the coils' signals that may read the same as a reading, but for one that is known.
    fn others(&self, reading: &AxisPose, known: Option<&AxisPose>) -> Vec<AxisPose> {
        let (Some(signals), Some(made)) = (&self.signals, self.newton.coils()) else {
            return Vec::new();
        };
        let of_coils = match made.has_others {
            true => self.without_others(made.coils, reading),
            false => *reading,
        };
        let mut all = signals.solutions(made.coils, &of_coils, known);
        all.retain(|pose| known.is_none_or(|known| !search::is_same(&self.newton, pose, known)));
        all
    }

    /// Of each reading, where its answers can be; nothing where all have one only.
    fn possible(&self, places: &[AxisPose]) -> Vec<Possible> {
        if self.regions.is_certain_everywhere() {
            return Vec::new();
        }
        let mut triangles = vec![0; places.len()];
        let set = self.newton.model.directions();
        if set != DirectionSet::One {
            let axes: Vec<_> = places.iter().map(|p| p.axis).collect();
            set.sphere().find_all(pulp::Scalar::new(), &axes, &mut triangles);
        }
        let mut buffer = Vec::new();
        places
            .iter()
            .zip(triangles)
            .map(|(place, triangle)| {
                self.regions.possible(place, usize::from(triangle), &mut buffer)
            })
            .collect()
    }

    fn settled(&self, measured: &Pose, possible: &Possible, stepped: &Stepped) -> Undistorted {
        let state = if self.is_left_out(stepped.is_inside) {
            InverseState::Rejected
        } else if self.is_at_jump(possible, None, &stepped.place) {
            InverseState::Ambiguous(Ambiguity::WeightJump)
        } else {
            InverseState::Converged
        };
        Undistorted {
            pose: state.has_answer().then(|| answer(measured, &stepped.place, &stepped.error)),
            others: [None; 2],
            state,
            evaluations: stepped.evaluations,
            residual_mm: stepped.residual_mm,
            residual_rad: stepped.residual_rad,
            is_inside: stepped.is_inside,
        }
    }

    /// A reading as it would be by the coils alone, by what is added to their errors there.
    fn without_others(&self, coils: &dyn DisturbedCoils, reading: &AxisPose) -> AxisPose {
        let Newton { model, outside, .. } = self.newton;
        let AxisPose { position_mm, axis } = reading;
        let of_coils = coils
            .disturbance(position_mm)
            .and_then(|added| axis_error(coils.generator(), position_mm, axis, &added).ok());
        let Some(of_coils) = of_coils else { return *reading };
        let all = model.evaluate(position_mm, axis, outside).error;
        let others = PoseError {
            position_mm: all.position_mm - of_coils.position_mm,
            rotation_rad: all.rotation_rad - of_coils.rotation_rad,
        };
        contraction::stepped(reading, &others)
    }

    fn search(
        &self,
        place: &AxisPose,
        tolerance: &Tolerance,
        start: Option<AxisPose>,
        possible: &Possible,
    ) -> Search {
        let Newton { model, outside, .. } = self.newton;
        let start = start.unwrap_or_else(|| {
            let at = model.evaluate(&place.position_mm, &place.axis, outside);
            contraction::stepped(place, &at.error)
        });
        let reading = Reading::new(*place);
        let first = self.newton.solve(&reading, start, tolerance);
        // Only from a pose that is known the one beyond a fold is looked for.
        let others = self.others(place, first.is_solution.then_some(&first.place));
        Search::run(&self.newton, possible, &reading, tolerance, first, others)
    }

    fn found(
        &self,
        measured: &Pose,
        place: &AxisPose,
        search: &Search,
        possible: &Possible,
    ) -> Undistorted {
        let found = search.best(place).or(search.answers.first()).unwrap_or(&search.first);
        let state = self.judged(search, found, possible);
        let pose = |found: &Found| answer(measured, &found.place, &found.there.at.error);
        Undistorted {
            pose: state.has_answer().then(|| pose(found)),
            others: if state.has_answer() {
                search.two_others(found).map(|of| of.map(pose))
            } else {
                [None; 2]
            },
            state,
            evaluations: search.evaluations,
            residual_mm: found.remainder.length_mm(),
            residual_rad: found.remainder.angle_rad(),
            is_inside: found.there.at.is_inside,
        }
    }

    fn judged(&self, search: &Search, found: &Found, possible: &Possible) -> InverseState {
        let least_determinant = found.least_determinant;
        if !found.is_solution {
            return if !self.newton.is_read(found.there.at.is_inside, &found.place) {
                InverseState::NoReading
            } else if least_determinant <= SINGULAR {
                InverseState::Folded { determinant: least_determinant }
            } else {
                InverseState::NotConverged
            };
        }
        if !found.is_regular() {
            return InverseState::Folded { determinant: found.determinant };
        }
        if self.is_left_out(found.there.at.is_inside) {
            return InverseState::Rejected;
        }
        if let Some(other) = search.others(found).next() {
            let [distance_mm, angle_rad] = search::apart(&found.place, &other.place);
            return InverseState::Ambiguous(Ambiguity::SecondPreimage { distance_mm, angle_rad });
        }
        if least_determinant <= 0.0 && self.signals.is_none() {
            return InverseState::Ambiguous(Ambiguity::FoldOnTheWay { least_determinant });
        }
        if possible.is_too_steep() {
            return InverseState::Ambiguous(Ambiguity::TooSteep {
                steepness: possible.slopes.contraction(),
            });
        }
        if self.is_at_jump(possible, Some(found), &found.place) {
            return InverseState::Ambiguous(Ambiguity::WeightJump);
        }
        InverseState::Converged
    }

    fn is_left_out(&self, is_inside: bool) -> bool {
        !is_inside && self.newton.outside == OutsidePolicy::Reject
    }

    /// Whether weights jump so close to an answer that there may be a second one beyond.
    ///
    /// Two answers with `k` edges between them are at most `(1 - M)⁻¹ k jump` apart; around a
    /// corner, within so little, lie six edges at most.
    fn is_at_jump(&self, possible: &Possible, found: Option<&Found>, place: &AxisPose) -> bool {
        const EDGES: f64 = 6.0;
        let [mm, rad] = possible.jump.map(|jump| EDGES * jump);
        if mm == 0.0 && rad == 0.0 {
            return false;
        }
        let reach = match found {
            Some(found) if !possible.is_certain() => {
                // Jumps are small: to first order, and twice that.
                2.0 * (rad + mm / self.newton.mm_per_rad) * found.magnification
            }
            _ => possible.slopes.reach(mm, rad)[1],
        };
        search::edge_distance_rad(&self.newton, &place.axis) <= reach
    }
}

/// The pose at an answer: the reading's rotation, roll and all, turned back.
fn answer(measured: &Pose, place: &AxisPose, error: &PoseError) -> Pose {
    pose_from_parts(place.position_mm.coords, exp_vector(&-error.rotation_rad) * measured.rotation)
}

impl InverseState {
    /// Whether a pose is given.
    pub fn has_answer(&self) -> bool {
        matches!(self, Self::Converged | Self::Ambiguous(_))
    }
}

impl Undistorted {
    /// What a reading that is no number gets.
    const NOTHING: Self = Self {
        pose: None,
        others: [None; 2],
        state: InverseState::NotConverged,
        evaluations: 0,
        residual_mm: f64::NAN,
        residual_rad: f64::NAN,
        is_inside: false,
    };
}
