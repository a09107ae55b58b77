//! Compensation by the inverse of a distortion map: the pose behind a reading, or why there is
//! none.

mod equations;
mod newton;
#[cfg(test)]
mod tests;
mod tolerance;

use super::model::{DistortionModel, OutsidePolicy};
use crate::geometry::pose::{Pose, pose_from_parts};
use crate::geometry::rotation::exp_vector;
use crate::task::{Cancelled, Task};
use equations::{Place, Reading};
use newton::{Found, Newton, SINGULAR};
use rayon::prelude::*;
use std::sync::atomic::{AtomicUsize, Ordering};
use tolerance::{Magnitudes, Tolerance};

pub use tolerance::{AXIS_TOLERANCE_RAD, POSITION_TOLERANCE_MM};

/// Readings that one core does before it looks whether anyone still wants them.
const CHUNK: usize = 256;

/// The pose behind a reading.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Undistorted {
    /// The answer, where there is one: converged or ambiguous.
    pub pose: Option<Pose>,
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
}

/// The poses behind readings, by the inverse of a distortion model, on all cores.
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
    model: &'a DistortionModel,
    outside: OutsidePolicy,
    magnitudes: Magnitudes,
    mm_per_rad: f64,
}

impl<'a> Inverse<'a> {
    pub fn new(model: &'a DistortionModel, outside: OutsidePolicy) -> Self {
        let diagonal_mm = model.bounds().diagonal_mm();
        Self {
            model,
            outside,
            magnitudes: Magnitudes::of(model),
            mm_per_rad: if diagonal_mm > 0.0 { diagonal_mm } else { 1.0 },
        }
    }

    /// The poses behind readings, on all cores; the answers do not depend on how many.
    ///
    /// # Errors
    /// [`Cancelled`].
    pub fn undistort(&self, measured: &[Pose], task: &Task) -> Result<Vec<Undistorted>, Cancelled> {
        let done = AtomicUsize::new(0);
        let chunks: Vec<Vec<Undistorted>> = measured
            .par_chunks(CHUNK)
            .map(|chunk| {
                let before = done.fetch_add(chunk.len(), Ordering::Relaxed);
                task.step(before, measured.len())?;
                Ok(chunk.iter().map(|pose| self.undistort_one(pose)).collect())
            })
            .collect::<Result<_, Cancelled>>()?;
        Ok(chunks.into_iter().flatten().collect())
    }

    fn undistort_one(&self, measured: &Pose) -> Undistorted {
        let place = Place::of(measured);
        if !place.is_finite() {
            return Undistorted {
                pose: None,
                state: InverseState::NotConverged,
                evaluations: 0,
                residual_mm: f64::NAN,
                residual_rad: f64::NAN,
                is_inside: false,
            };
        }
        let reading = Reading::new(place);
        let tolerance = Tolerance::of(&self.magnitudes, &place);
        let newton = Newton {
            model: self.model,
            outside: self.outside,
            mm_per_rad: self.mm_per_rad,
        };
        let found = newton.solve(&reading, place, &tolerance);
        self.judge(measured, &found)
    }

    fn judge(&self, measured: &Pose, found: &Found) -> Undistorted {
        let is_inside = found.there.at.is_inside;
        let state = if !found.is_solution {
            if found.determinant.abs() <= SINGULAR {
                InverseState::Folded {
                    determinant: found.determinant,
                }
            } else {
                InverseState::NotConverged
            }
        } else if found.determinant <= SINGULAR {
            InverseState::Folded {
                determinant: found.determinant,
            }
        } else if !is_inside && self.outside == OutsidePolicy::Reject {
            InverseState::Rejected
        } else if found.least_determinant <= 0.0 {
            InverseState::Ambiguous(Ambiguity::FoldOnTheWay {
                least_determinant: found.least_determinant,
            })
        } else {
            InverseState::Converged
        };
        let has_answer = matches!(state, InverseState::Converged | InverseState::Ambiguous(_));
        let pose = pose_from_parts(
            found.place.position_mm.coords,
            exp_vector(&-found.there.at.error.rotation_rad) * measured.rotation,
        );
        Undistorted {
            pose: has_answer.then_some(pose),
            state,
            evaluations: found.evaluations,
            residual_mm: found.remainder.length_mm(),
            residual_rad: found.remainder.angle_rad(),
            is_inside,
        }
    }
}
