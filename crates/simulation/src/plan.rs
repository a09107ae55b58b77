//! Which trials a mode visits, in what groups they are computed, and in what order they are seen.

use super::motion::MotionGrid;
use super::run::StudyError;
use super::scenario::{InputTrial, Mode, Scenario};
use super::spread::spread;
use super::tracker::MIN_RUN;
use super::trial::{Simulator, Trial, TrialBuffers};
use super::work::Work;
use rayon::prelude::*;
use std::collections::BTreeSet;
use std::sync::Arc;
use trackwright_task::CancelToken;

/// Trials that are computed together before they are summed up and logged: 6 MB of them.
const BLOCK: usize = 32_768;

/// Trials that one core computes together, before it looks whether anyone still wants them: some
/// 0.3 ms. They share triangles enough to fill the lanes, and a small study still has some for
/// each core.
const CHUNK: usize = 256;

/// Which trials a mode visits.
pub(super) enum Plan {
    Single,
    Motion(Box<MotionGrid>),
    Input(Arc<[InputTrial]>),
}

impl Plan {
    pub fn new(scenario: &Scenario, mode: &Mode) -> Result<Self, StudyError> {
        Ok(match mode {
            Mode::Single => Self::Single,
            Mode::Motion => {
                let grid = scenario.motion_grid()?.ok_or(StudyError::NoMotion)?;
                Self::Motion(Box::new(grid))
            }
            Mode::Input(trials) if trials.is_empty() => return Err(StudyError::NoTrials),
            Mode::Input(trials) => Self::Input(trials.clone()),
        })
    }

    pub fn len(&self) -> usize {
        match self {
            Self::Single => 1,
            Self::Motion(grid) => grid.trials(),
            Self::Input(trials) => trials.len(),
        }
    }

    /// Numbers of some trials that are spread over all, in order, each once. In a grid every axis is visited
    /// evenly, and every few of them together: an additive recurrence whose steps are powers of the root of
    /// `x^7 = x + 1`, the golden ratio of six dimensions (Roberts 2018).
    pub fn spread(&self, some: usize) -> Vec<usize> {
        const STEP: f64 = 1.0 / 1.112_775_684_278_705_5;
        let numbers: BTreeSet<usize> = match self {
            _ if some >= self.len() => (0..self.len()).collect(),
            Self::Motion(grid) => {
                let number = |k: usize| {
                    let mut step = 1.0;
                    grid.counts().into_iter().fold(0, |number, count| {
                        step *= STEP;
                        let part = (0.5 + (k as f64 + 1.0) * step).fract();
                        number * count + ((part * count as f64) as usize).min(count - 1)
                    })
                };
                (0..some.max(1)).map(number).collect()
            }
            Self::Single | Self::Input(_) => spread(self.len(), some).collect(),
        };
        numbers.into_iter().collect()
    }

    /// One trial's poses.
    pub fn trial(&self, scenario: &Scenario, index: usize) -> InputTrial {
        match self {
            Self::Single => InputTrial::at(scenario.crf_from_tool),
            Self::Motion(grid) => InputTrial::at(grid.pose(index)),
            Self::Input(trials) => trials[index],
        }
    }

    /// The trials of a part of a block.
    fn trials(
        &self,
        simulator: &Simulator,
        buffers: &mut TrialBuffers,
        block: &Block,
        part: std::ops::Range<usize>,
    ) -> Vec<Trial> {
        match self {
            Self::Single => simulator.trials(buffers, &[simulator.design_crf_from_tool()], 1),
            Self::Motion(grid) => {
                let poses: Vec<_> = part.map(|place| grid.pose(block.trial(place))).collect();
                simulator.trials(buffers, &poses, block.run)
            }
            Self::Input(trials) => {
                let part = block.start + part.start..block.start + part.end;
                simulator.given_trials(buffers, &trials[part])
            }
        }
    }
}

/// Trials that are computed before any of them is seen.
struct Block {
    start: usize,
    len: usize,
    /// How many of its poses have the same orientation and are computed one after the other; 1
    /// where they are computed in their own order.
    run: usize,
}

impl Block {
    /// The blocks of a plan: in a grid with enough positions for each orientation, whole
    /// positions, and as many of them as fit.
    fn all(plan: &Plan) -> impl Iterator<Item = Self> {
        let trials = plan.len();
        let orientations = match plan {
            Plan::Motion(grid) => grid.orientations(),
            Plan::Single | Plan::Input(_) => trials,
        };
        let run = (BLOCK / orientations).min(trials / orientations);
        let (len, is_grouped) =
            if run >= MIN_RUN { (run * orientations, true) } else { (BLOCK, false) };
        (0..trials).step_by(len).map(move |start| {
            let len = len.min(trials - start);
            let run = if is_grouped { len / orientations } else { 1 };
            Self { start, len, run }
        })
    }

    /// The number of the trial that is computed at a place.
    fn trial(&self, place: usize) -> usize {
        let orientations = self.len / self.run;
        match self.run {
            1 => self.start + place,
            run => self.start + place % run * orientations + place / run,
        }
    }

    /// Where a trial is computed, by its number in the block.
    fn place(&self, offset: usize) -> usize {
        let orientations = self.len / self.run;
        match self.run {
            1 => offset,
            run => offset % orientations * run + offset / orientations,
        }
    }

    /// Places in each part: whole runs, or one of the pieces of a long one.
    fn part_len(&self) -> usize {
        if self.run >= CHUNK {
            self.run.div_ceil(self.run / CHUNK)
        } else {
            CHUNK / self.run * self.run
        }
    }

    /// What the cores share out.
    fn parts(&self) -> Vec<std::ops::Range<usize>> {
        // Pieces of a long run must not reach into the next.
        let step = self.run.max(self.part_len());
        (0..self.len)
            .step_by(step)
            .flat_map(|start| {
                let end = (start + step).min(self.len);
                let len = self.part_len();
                (start..end).step_by(len).map(move |start| start..(start + len).min(end))
            })
            .collect()
    }
}

/// Computes blocks in parallel, visits their trials in order, and gives what it cost. What a part
/// computes does not depend on the number of threads.
pub(super) fn each_trial(
    plan: &Plan,
    simulator: &Simulator,
    cancel: &CancelToken,
    mut visit: impl FnMut(usize, &Trial),
) -> Result<Work, StudyError> {
    let mut work = Work::default();
    for block in Block::all(plan) {
        let parts: Option<Vec<(Vec<Trial>, Work)>> = block
            .parts()
            .into_par_iter()
            .map_init(TrialBuffers::default, |buffers, part| {
                if cancel.is_cancelled() {
                    return None;
                }
                let trials = plan.trials(simulator, buffers, &block, part);
                Some((trials, buffers.take_work()))
            })
            .collect();
        let parts = parts.ok_or(StudyError::Cancelled)?;
        let mut trials = Vec::with_capacity(block.len);
        for (part, part_work) in &parts {
            trials.extend(part.iter());
            work += *part_work;
        }
        for offset in 0..block.len {
            visit(block.start + offset, trials[block.place(offset)]);
        }
    }
    Ok(work)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::motion::{AxisRange, Motion};
    use nalgebra::Point3;
    use trackwright_geometry::pose::Pose;

    fn grid(positions: usize, orientations: usize) -> Plan {
        // Steps that add up exactly, so small that no turn is beyond ten.
        let axis = |count: usize| {
            Some(AxisRange { min: 0.0, max: (count as f64 - 1.0) / 64.0, step: 1.0 / 64.0 })
        };
        let motion = Motion { y: axis(positions), rz: axis(orientations), ..Motion::default() };
        Plan::Motion(Box::new(motion.grid(&Pose::identity(), &Point3::origin()).unwrap()))
    }

    #[test]
    fn every_trial_is_computed_once_and_found_again() {
        for (positions, orientations) in [
            (1, 1),
            (1, 70_000),
            (70_000, 1),
            (100, 3),
            (15, 40),
            (16, 40),
            (300, 300),
            (1000, 1000),
            (5, 2049),
        ] {
            let plan = grid(positions, orientations);
            let mut next = 0;
            for block in Block::all(&plan) {
                assert_eq!(block.start, next);
                next += block.len;
                let mut place = 0;
                for part in block.parts() {
                    assert_eq!(part.start, place);
                    assert!(!part.is_empty() && part.len() <= 2 * CHUNK);
                    // No part begins inside a run and ends beyond it.
                    if block.run > 1 && part.start % block.run != 0 {
                        assert!(part.end <= part.start.next_multiple_of(block.run));
                    }
                    place = part.end;
                }
                assert_eq!(place, block.len);
                for offset in 0..block.len {
                    let place = block.place(offset);
                    assert_eq!(block.trial(place), block.start + offset);
                }
            }
            assert_eq!(next, positions * orientations);
        }
    }

    #[test]
    fn poses_of_a_run_share_their_orientation() {
        let plan = grid(40, 7);
        let Plan::Motion(grid) = &plan else { unreachable!() };
        let block = Block::all(&plan).next().unwrap();
        assert_eq!(block.run, 40);
        for place in 0..block.len {
            let first = place / block.run * block.run;
            let (a, b) = (grid.pose(block.trial(place)), grid.pose(block.trial(first)));
            assert_eq!(a.rotation, b.rotation);
        }
    }
}
