//! The study: how few poses still tell the tip error RMS of a range of motion.

use super::{Family, Row, Settings, Steps, What};
use crate::study::figures::with_separators;
use crate::study::motion::moved;
use crate::study::{self, AxisRange, InputTrial, Mode, Motion, Scenario, StudyError};
use crate::task::Cancelled;
use sobol::Sobol;
use sobol::params::JoeKuoD6;
use std::sync::Arc;

/// The figure that `simulate` prints: over the poses of the design's grid.
const GRID: &str = "the design's grid of poses";
/// The same figure over everything that the range of motion allows, each pose as likely.
const RANGE: &str = "the whole range of motion";

/// Poses of a Sobol sequence: powers of two, at which it is even.
const SOBOL_COUNTS: [usize; 8] = [16, 32, 64, 128, 256, 512, 1024, 2048];

/// Cells an axis of the reference at most, each seen from its middle.
const MAX_REFERENCE_CELLS: usize = 64;

/// A grid that is larger is not run several times over.
const MAX_GRID: usize = 300_000;

pub fn measure(
    scenario: &Scenario,
    settings: &Settings,
    steps: &Steps,
) -> Result<Family, Cancelled> {
    let mut family = Family {
        what: What::Motion,
        about: format!(
            "Tip error RMS of the design's study, on all threads; size is the number of poses. \
                Over the design's grid of poses the reference is the full grid, which is what \
                `simulate` prints; over the whole range of motion it is a grid of cell middles, \
                as fine as {} poses allow. The grid counts the ends of the range as much as its \
                middle, so the two figures differ.",
            with_separators(settings.motion_reference)
        ),
        rows: Vec::new(),
        charted: GRID.to_owned(),
        left_out: None,
    };
    let sampling = match Sampling::new(scenario) {
        Ok(sampling) => sampling,
        Err(reason) => {
            family.left_out = Some(reason);
            return Ok(family);
        }
    };
    let plans = sampling.plans();
    let all = plans.len() + 2;
    let mut reference = [0.0; 2];
    for (i, poses) in [
        sampling.grid(1),
        sampling.reference(settings.motion_reference),
    ]
    .into_iter()
    .enumerate()
    {
        match rms(scenario, &poses, steps) {
            Ok(value) => reference[i] = value,
            Err(StudyError::Cancelled) => return Err(Cancelled),
            Err(other) => {
                family.left_out = Some(other.to_string());
                return Ok(family);
            }
        }
        steps.at(i + 1, all)?;
    }
    for (i, plan) in plans.into_iter().enumerate() {
        let poses = (plan.poses)();
        let (seconds, found) = settings.timing.measure(|| rms(scenario, &poses, steps));
        steps.at(i + 3, all)?;
        // A sample that has every pose rejected has no figure.
        let Ok(found) = found else { continue };
        let reference = reference[usize::from(plan.problem == RANGE)];
        family.rows.push(Row {
            what: What::Motion,
            method: plan.method,
            order: scenario.environment.model.order(),
            directions: scenario.environment.model.directions().len(),
            size: poses.len(),
            seconds,
            error: (found - reference).abs(),
            error_unit: "mm",
            on_front: false,
            is_default: plan.is_default,
            problem: plan.problem.to_owned(),
            series: plan.series.to_owned(),
        });
    }
    Ok(family)
}

/// Tip error RMS over some poses.
fn rms(scenario: &Scenario, poses: &Poses, steps: &Steps) -> Result<f64, StudyError> {
    let cancel = &steps.task.cancel;
    let outcome = match poses {
        Poses::Grid(motion, _) => {
            let scenario = Scenario {
                motion: Some(*motion),
                ..scenario.clone()
            };
            study::run(&scenario, &Mode::Motion, cancel, None)
        }
        Poses::List(trials) => study::run(scenario, &Mode::Input(trials.clone()), cancel, None),
    };
    outcome.map(|o| o.figures.position_mm.rms)
}

/// Poses to visit.
enum Poses {
    Grid(Motion, usize),
    List(Arc<[InputTrial]>),
}

impl Poses {
    fn len(&self) -> usize {
        match self {
            Self::Grid(_, trials) => *trials,
            Self::List(trials) => trials.len(),
        }
    }
}

/// One way to choose poses.
struct Plan<'a> {
    method: String,
    series: &'static str,
    problem: &'static str,
    is_default: bool,
    poses: Box<dyn Fn() -> Poses + 'a>,
}

/// A range of motion that can be sampled.
struct Sampling<'a> {
    scenario: &'a Scenario,
    motion: Motion,
    counts: [usize; 6],
}

impl<'a> Sampling<'a> {
    /// # Errors
    /// Why there is nothing to sample.
    fn new(scenario: &'a Scenario) -> Result<Self, String> {
        let motion = scenario.motion.ok_or("the design has no range of motion")?;
        if scenario.environment.model.order() == 0 {
            return Err("the design's room is ideal: every tip error is zero".to_owned());
        }
        let grid = motion
            .grid(&scenario.crf_from_tool)
            .map_err(|e| e.to_string())?;
        match grid.trials() {
            0 | 1 => return Err("the design's range of motion is a single pose".to_owned()),
            trials if trials > MAX_GRID => {
                return Err(format!(
                    "the design's range of motion has {trials} poses, more than {MAX_GRID} that \
                     would be run several times over"
                ));
            }
            _ => {}
        }
        Ok(Self {
            scenario,
            motion,
            counts: grid.counts(),
        })
    }

    fn plans(&self) -> Vec<Plan<'_>> {
        let trials: usize = self.counts.iter().product();
        let mut plans = Vec::new();
        for problem in [GRID, RANGE] {
            plans.push(Plan {
                method: "full grid".to_owned(),
                series: if problem == GRID {
                    "grids"
                } else {
                    "grids, of the range"
                },
                problem,
                is_default: problem == GRID,
                poses: Box::new(|| self.grid(1)),
            });
            for stride in [2, 4] {
                plans.push(Plan {
                    method: format!("grid with steps {stride} times as long"),
                    series: if problem == GRID {
                        "grids"
                    } else {
                        "grids, of the range"
                    },
                    problem,
                    is_default: false,
                    poses: Box::new(move || self.grid(stride)),
                });
            }
            for count in SOBOL_COUNTS.into_iter().filter(|&c| c < trials) {
                plans.push(Plan {
                    method: format!("Sobol, {count} poses"),
                    series: if problem == GRID {
                        "Sobol"
                    } else {
                        "Sobol, of the range"
                    },
                    problem,
                    is_default: false,
                    poses: Box::new(move || self.sobol(count, problem == GRID)),
                });
            }
        }
        plans
    }

    /// The design's grid with longer steps.
    fn grid(&self, stride: usize) -> Poses {
        let motion = self.each_axis(|range, _| {
            Some(AxisRange {
                step: range.step * stride as f64,
                ..range
            })
        });
        let trials = motion
            .grid(&self.scenario.crf_from_tool)
            .map_or(0, |g| g.trials());
        Poses::Grid(motion, trials)
    }

    /// The middles of cells that fill the range.
    fn reference(&self, most: usize) -> Poses {
        let moving = self.counts.iter().filter(|&&c| c > 1).count() as u32;
        let cells = (2..=MAX_REFERENCE_CELLS)
            .rev()
            .find(|c| c.checked_pow(moving).is_some_and(|all| all <= most))
            .unwrap_or(2);
        let motion = self.each_axis(|range, count| {
            if count < 2 {
                return Some(range);
            }
            let step = (range.max - range.min) / cells as f64;
            Some(AxisRange {
                min: range.min + step / 2.0,
                // Half a step further, so that rounding does not lose the last.
                max: range.max,
                step,
            })
        });
        Poses::Grid(motion, cells.pow(moving))
    }

    fn each_axis(&self, change: impl Fn(AxisRange, usize) -> Option<AxisRange>) -> Motion {
        let [x, y, z, rx, ry, rz] = {
            let axes = self.motion.axes();
            std::array::from_fn(|k| axes[k].1.and_then(|range| change(range, self.counts[k])))
        };
        Motion {
            x,
            y,
            z,
            rx,
            ry,
            rz,
        }
    }

    /// Poses of a Sobol sequence, of the grid or of anywhere in the range.
    fn sobol(&self, count: usize, of_grid: bool) -> Poses {
        let axes = self.motion.axes();
        // The sequence's first point is a corner; a half of the last bit puts each in its cell.
        let params = JoeKuoD6::minimal();
        let trials = Sobol::<f64>::new(6, &params).take(count).map(|point| {
            let values = std::array::from_fn(|k| {
                let Some(range) = axes[k].1 else { return 0.0 };
                let cells = self.counts[k];
                let part = point[k] + 0.5 / count as f64;
                if cells < 2 {
                    range.min
                } else if of_grid {
                    range.min + ((part * cells as f64) as usize).min(cells - 1) as f64 * range.step
                } else {
                    range.min + part * (range.max - range.min)
                }
            });
            InputTrial {
                tracker_from_crf: None,
                crf_from_tool: moved(&self.scenario.crf_from_tool, values),
            }
        });
        Poses::List(trials.collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::accuracy::precision::{Timing, testing};
    use crate::task::Task;

    fn rows(scenario: &Scenario) -> Family {
        let settings = Settings {
            timing: Timing::ONCE,
            ..Settings::default()
        };
        let task = Task::default();
        measure(scenario, &settings, &Steps::whole(&task)).unwrap()
    }

    #[test]
    fn the_full_grid_is_the_figure_that_simulate_prints() {
        let family = rows(&testing::built_in());
        let full = family.rows.iter().find(|r| r.is_default).unwrap();
        assert_eq!((full.size, full.error), (3375, 0.0));
    }

    /// Each point of a Sobol sequence in its own cell: far closer to the whole than the spread of
    /// single tip errors over the root of the count, which independent draws would give.
    #[test]
    fn a_sobol_sequence_is_closer_than_chance() {
        let scenario = testing::built_in();
        let figures = study::run(&scenario, &Mode::Motion, &Default::default(), None)
            .unwrap()
            .figures;
        let family = rows(&scenario);
        for problem in [GRID, RANGE] {
            for row in family
                .rows
                .iter()
                .filter(|r| r.problem == problem && r.method.starts_with("Sobol"))
            {
                let by_chance = figures.position_mm.std / (row.size as f64).sqrt();
                assert!(row.error < by_chance, "{row:?} {by_chance}");
            }
        }
    }

    #[test]
    fn a_design_without_motion_is_left_out_with_a_reason() {
        let mut scenario = testing::built_in();
        scenario.motion = None;
        let family = rows(&scenario);
        assert!(family.rows.is_empty());
        assert_eq!(
            family.left_out.as_deref(),
            Some("the design has no range of motion")
        );
    }
}
