//! A study of part of a range of motion: figures that follow the hand where the whole is too long.

use super::motion::{MotionGrid, moved};
use super::scenario::{InputTrial, Mode, Scenario};
use sobol::Sobol;
use sobol::params::JoeKuoD6;

/// Ranges of motion up to so many poses are always studied whole: some ten milliseconds.
pub const WHOLE_UP_TO: usize = 20_000;

/// Poses of a preview: on the built-in design its tip error RMS is within 1 % of the whole
/// grid's (the `motion` family of `precision` measures it).
pub const PREVIEW_TRIALS: usize = 2048;

/// Moves the sequence off the corner of the range where it begins: the golden ratio's powers,
/// which share no period with it.
const SHIFT: [f64; 6] = [0.618_034, 0.381_966, 0.236_068, 0.145_898, 0.090_170, 0.055_728];

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
    let grid = scenario.motion?.grid(&scenario.crf_from_tool).ok()?;
    let whole_trials = grid.trials();
    (whole_trials > WHOLE_UP_TO).then(|| Preview {
        mode: Mode::Input(spread(scenario, &grid, PREVIEW_TRIALS, SHIFT)),
        whole_trials,
    })
}

/// So many poses of the grid along a Sobol sequence, shifted around each axis by a part of it.
pub fn spread(
    scenario: &Scenario,
    grid: &MotionGrid,
    count: usize,
    shift: [f64; 6],
) -> std::sync::Arc<[InputTrial]> {
    let axes = scenario.motion.unwrap_or_default().axes();
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
            InputTrial {
                tracker_from_crf: None,
                crf_from_tool: moved(&scenario.crf_from_tool, values),
            }
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::store;
    use crate::study::{AxisRange, CancelToken, Motion, run};
    use std::collections::HashSet;

    fn scenario(steps: f64) -> Scenario {
        let world = store::open_builtin(store::DEFAULT_BUILTIN).unwrap();
        let range =
            |reach: f64| Some(AxisRange { min: -reach, max: reach, step: 2.0 * reach / steps });
        Scenario {
            motion: Some(Motion {
                x: range(40.0),
                y: range(40.0),
                z: range(40.0),
                rx: range(30.0),
                rz: range(30.0),
                ..Motion::default()
            }),
            ..store::resolve(world.document.design(), &world.environment)
        }
    }

    #[test]
    fn a_short_range_of_motion_needs_no_preview() {
        assert!(preview(&scenario(2.0)).is_none());
        let still = Scenario { motion: None, ..scenario(2.0) };
        assert!(preview(&still).is_none());
    }

    #[test]
    fn a_preview_is_close_to_the_whole_and_says_how_much_it_stands_for() {
        let scenario = scenario(7.0);
        let preview = preview(&scenario).unwrap();
        assert_eq!(preview.whole_trials, 8_usize.pow(5));
        let rms = |mode: &Mode| {
            let outcome = run(&scenario, mode, &CancelToken::default(), None).unwrap();
            outcome.figures.position_mm.rms
        };
        let (part, whole) = (rms(&preview.mode), rms(&Mode::Motion));
        assert!((part - whole).abs() < 0.01 * whole, "{part} {whole}");
    }

    #[test]
    fn the_poses_of_a_preview_are_poses_of_the_grid_and_hardly_repeat() {
        let scenario = scenario(7.0);
        let grid = scenario.motion.unwrap().grid(&scenario.crf_from_tool).unwrap();
        let key = |pose: &crate::geometry::pose::Pose| {
            crate::geometry::pose::pose_to_array(pose).map(|v| (v * 1e6).round() as i64)
        };
        let all: HashSet<_> = (0..grid.trials()).map(|i| key(&grid.pose(i))).collect();
        let some = spread(&scenario, &grid, 512, SHIFT);
        let found: HashSet<_> = some.iter().map(|t| key(&t.crf_from_tool)).collect();
        assert!(found.is_subset(&all));
        assert!(found.len() > 500, "{}", found.len());
    }
}
