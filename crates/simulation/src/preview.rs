//! A study of part of a range of motion: figures that follow the hand where the whole is too long.

use super::motion::MotionGrid;
use super::scenario::{InputTrial, Mode, Scenario};
use sobol::Sobol;
use sobol::params::JoeKuoD6;
use trackwright_field::computed::ModelKind;

/// Ranges of motion up to so many poses are always studied whole: some ten milliseconds.
pub const WHOLE_UP_TO: usize = 20_000;

/// Poses of a preview: on the built-in design its tip error RMS is within 1 % of the whole
/// grid's (the `motion` family of `precision` measures it).
pub const PREVIEW_TRIALS: usize = 2048;

/// Moves the sequence off the corner of the range where it begins: the golden ratio's powers,
/// which share no period with it.
pub const SHIFT: [f64; 6] = [0.618_034, 0.381_966, 0.236_068, 0.145_898, 0.090_170, 0.055_728];

/// The same in rooms whose field is computed anew at each pose, which takes some 30 times as long.
const WHOLE_OF_SIMULATED: usize = 1_000;
const PREVIEW_OF_SIMULATED: usize = 768;

/// A study that stands for a long one.
#[derive(Clone, Debug)]
pub struct Preview {
    pub mode: Mode,
    /// Poses of the whole study.
    pub whole_trials: usize,
}

/// A part of the scenario's range of motion, evenly spread over it; `None` where the whole is
/// short enough or cannot be visited.
pub fn preview(scenario: &Scenario) -> Option<Preview> {
    let grid = scenario.motion_grid().ok()??;
    let whole_trials = grid.trials();
    let (most, trials) = match scenario.environment.model.kind() {
        ModelKind::Simulated => (WHOLE_OF_SIMULATED, PREVIEW_OF_SIMULATED),
        _ => (WHOLE_UP_TO, PREVIEW_TRIALS),
    };
    (whole_trials > most)
        .then(|| Preview { mode: Mode::Input(spread(&grid, trials, SHIFT)), whole_trials })
}

/// So many poses of the grid along a Sobol sequence, shifted around each axis by a part of it.
pub fn spread(grid: &MotionGrid, count: usize, shift: [f64; 6]) -> std::sync::Arc<[InputTrial]> {
    let axes = grid.motion().axes();
    let counts = grid.counts();
    Sobol::<f64>::new(6, &JoeKuoD6::minimal())
        .take(count)
        .map(|point| {
            let values = std::array::from_fn(|k| {
                axes[k].1.map_or(0.0, |range| {
                    let part = (point[k] + shift[k]).fract();
                    let index = ((part * counts[k] as f64) as usize).min(counts[k] - 1);
                    range.min + index as f64 * range.step
                })
            });
            InputTrial::at(grid.moved(values))
        })
        .collect()
}
