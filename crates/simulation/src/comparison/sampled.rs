//! A design's figures between the poses of its grid, and in other fields that its room might have.

use crate::metric::{MetricValues, values_of_errors, values_of_spread};
use crate::motion::AxisRange;
use crate::run::{StudyError, is_rejected, run};
use crate::scenario::{InputTrial, Mode, Scenario};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};
use sobol::Sobol;
use sobol::params::JoeKuoD6;
use std::sync::Arc;
use trackwright_field::Environment;
use trackwright_task::CancelToken;

/// Figures over the whole range of motion, once from all poses and once from each independent part
/// of them.
#[derive(Clone, Debug, PartialEq)]
pub struct Sampled {
    pub whole: MetricValues,
    pub replicates: Vec<MetricValues>,
}

/// Figures in the room's field and in others that its fit might as well have given, at the same
/// poses.
#[derive(Clone, Debug, PartialEq)]
pub struct Drawn {
    pub nominal: MetricValues,
    pub draws: Vec<MetricValues>,
    pub from: DrawnFrom,
}

/// Where drawn fields are from, which decides on which side of the room's own figure the truth is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DrawnFrom {
    /// The fit's, with other noise: a noisy field lengthens errors, so that the room's own figures
    /// are too large by about as much as those of drawn fields are above them.
    Refits,
    /// What the measurements leave possible: the room is one of them.
    Measurements,
}

/// Tip error in mm and angle in degrees of a pose; `None` where it is left out.
pub type Errors = Option<[f64; 2]>;

/// Where a range of motion is looked at between its grid's poses: Sobol sequences of equal length,
/// each shifted by random bits of its own (a digital shift, after which every pose is anywhere in the
/// range with equal chance and the sequence as even as it was). The same seed takes the same part of
/// every range, so that two designs are compared at the same places.
pub fn range_trials(
    scenario: &Scenario,
    replicates: usize,
    each: usize,
    seed: u64,
) -> Vec<Vec<InputTrial>> {
    let Ok(Some(grid)) = scenario.motion_grid() else { return Vec::new() };
    let axes = grid.motion().axes();
    if !axes.iter().any(|(_, range)| range.is_some_and(moves)) {
        return Vec::new();
    }
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let params = JoeKuoD6::minimal();
    let replicate = |mask: [u32; 6]| {
        let sequence = Sobol::<u32>::new(6, &params).take(each);
        let trials = sequence.map(|point| {
            let offsets = std::array::from_fn(|k| {
                let Some(range) = axes[k].1 else { return 0.0 };
                let part = (f64::from(point[k] ^ mask[k]) + 0.5) / 2.0_f64.powi(32);
                match moves(range) {
                    true => range.min + part * (range.max - range.min),
                    false => range.min,
                }
            });
            InputTrial::at(grid.moved(offsets))
        });
        trials.collect()
    };
    (0..replicates).map(|_| replicate(std::array::from_fn(|_| random.next_u32()))).collect()
}

/// Whether an axis has more than one value, as its grid has it.
fn moves(range: AxisRange) -> bool {
    range.step > 0.0 && range.max > range.min
}

/// The errors at each pose, in order.
pub fn errors_at(
    scenario: &Scenario,
    trials: &Arc<[InputTrial]>,
    cancel: &CancelToken,
) -> Result<Vec<Errors>, StudyError> {
    let mut errors = Vec::with_capacity(trials.len());
    let mut keep = |trial: &crate::trial::Trial| {
        let is_kept = !is_rejected(trial, scenario.outside);
        errors.push(is_kept.then_some([trial.tip_error_mm, trial.angle_error_deg]));
    };
    match run(scenario, &Mode::Input(Arc::clone(trials)), cancel, Some(&mut keep)) {
        Ok(_) | Err(StudyError::AllRejected { .. }) => Ok(errors),
        Err(error) => Err(error),
    }
}

/// The figures of some errors; `None` where all were left out.
pub fn figures_of<'a>(errors: impl Iterator<Item = &'a Errors>) -> Option<MetricValues> {
    values_of_errors(errors.flatten().copied())
}

impl Sampled {
    /// `None` where nothing moves, or a part has no pose that is not left out.
    pub fn of(
        scenario: &Scenario,
        trials: &[Vec<InputTrial>],
        cancel: &CancelToken,
    ) -> Result<Option<Self>, StudyError> {
        if trials.is_empty() {
            return Ok(None);
        }
        let all: Arc<[InputTrial]> = trials.iter().flatten().copied().collect();
        let errors = errors_at(scenario, &all, cancel)?;
        let each = trials.first().map_or(1, Vec::len).max(1);
        let replicates: Option<Vec<_>> =
            errors.chunks(each).map(|part| figures_of(part.iter())).collect();
        let whole = figures_of(errors.iter());
        Ok(whole.zip(replicates).map(|(whole, replicates)| Self { whole, replicates }))
    }
}

/// Poses at which drawn fields are tried.
pub struct DrawnAt {
    trials: Arc<[InputTrial]>,
    /// So many of them are spread over the range; those after them count for extremes alone.
    spread: usize,
}

impl DrawnAt {
    /// Evenly spread poses, or the design's own where nothing moves, and the worst of the grid.
    pub fn new(scenario: &Scenario, spread: &[Vec<InputTrial>], worst: &[InputTrial]) -> Self {
        let mut trials: Vec<_> = spread.iter().flatten().copied().collect();
        if trials.is_empty() {
            trials.push(InputTrial::at(scenario.crf_from_tool));
        }
        let spread = trials.len();
        trials.extend(worst);
        Self { trials: trials.into(), spread }
    }

    /// The poses.
    pub fn trials(&self) -> &Arc<[InputTrial]> {
        &self.trials
    }

    /// Every so manieth of the poses, so that at most `most` are left.
    pub fn thinned(&self, most: usize) -> Self {
        let step = self.trials.len().div_ceil(most.max(1));
        let spread = self.trials[..self.spread].iter().step_by(step);
        let extremes = self.trials[self.spread..].iter().step_by(step);
        Self { spread: spread.len(), trials: spread.chain(extremes).copied().collect() }
    }

    /// The figures of the errors at the poses, those of extremes from all of them.
    pub fn figures_of(&self, errors: &[Errors]) -> Option<MetricValues> {
        let spread = errors.iter().take(self.spread);
        values_of_spread(spread.flatten().copied(), errors.iter().flatten().copied())
    }

    /// The figures in a room with this field.
    pub fn figures(
        &self,
        scenario: &Scenario,
        room: &Arc<Environment>,
        cancel: &CancelToken,
    ) -> Result<Option<MetricValues>, StudyError> {
        let in_room = Scenario { environment: Arc::clone(room), ..scenario.clone() };
        let errors = errors_at(&in_room, &self.trials, cancel)?;
        Ok(self.figures_of(&errors))
    }
}
