//! The share of a bound that the upper end of its 95 % interval uses up.
//!
//! An interval takes some 20 ms a point, so that it is found on a coarse lattice. What is interpolated
//! from there is `upper² - own²`: variances add up, and what the measurements leave open changes
//! more slowly over a room than its field does.

use super::share_of;
use crate::expected::{ExpectedError, expected};
use crate::run::StudyError;
use crate::scenario::{InputTrial, Mode, Scenario};
use crate::trial::Simulator;
use nalgebra::{Point3, UnitQuaternion};
use rayon::prelude::*;
use trackwright_geometry::bounds::Bounds;
use trackwright_geometry::isosurface::ScalarLattice;
use trackwright_geometry::volume::Volume;
use trackwright_task::{Cancelled, Task};

/// Points along each side. In the built-in room the shares halfway between them are within 8 % of those
/// that are found there directly in the median, and within 19 % of the worst of seven; with seven points a
/// side 6 % and 17 %: the rest is from the number of draws.
const COUNT: usize = 5;

/// What the measurements leave open, over a room.
pub(super) struct OpenPart {
    /// `upper² - own²`, of shares.
    squares: ScalarLattice,
    /// Points at which an interval was found.
    pub points: usize,
}

impl OpenPart {
    /// `None` in a room that keeps no measurements, and for bodies with markers.
    ///
    /// # Errors
    /// [`Cancelled`].
    pub fn find(
        scenario: &Scenario,
        simulator: &Simulator,
        orientations: &[UnitQuaternion<f64>],
        bounds: Bounds,
        task: &Task,
    ) -> Result<Option<Self>, Cancelled> {
        if !scenario.environment.states_uncertainty() {
            return Ok(None);
        }
        let mut squares = ScalarLattice { bounds, counts: [COUNT; 3], values: Vec::new() };
        let cell_mm = bounds.size_mm().norm() / (COUNT - 1) as f64;
        let excess = scenario.environment.volume.as_ref();
        let excess = excess.and_then(Volume::excess_mm);
        let is_near = |p: &Point3<f64>| excess.as_ref().is_none_or(|excess| excess(p) <= cell_mm);
        let at: Vec<Point3<f64>> =
            (0..COUNT.pow(3)).map(|place| squares.point_mm(squares.index(place))).collect();
        let found: Result<Vec<Option<f64>>, Cancelled> = at
            .par_iter()
            .map(|tip| match is_near(tip) {
                true => open_square(scenario, simulator, orientations, tip, task),
                false => Ok(Some(0.0)),
            })
            .collect();
        let found: Option<Vec<f64>> = found?.into_iter().collect();
        Ok(found.map(|values| {
            squares.values = values;
            Self { points: at.iter().filter(|p| is_near(p)).count(), squares }
        }))
    }

    /// The share that the upper end uses up where the figure of the room's model alone uses up `own`.
    pub fn upper(&self, at: &Point3<f64>, own: f64) -> f64 {
        own.hypot(self.squares.between(at).max(0.0).sqrt())
    }
}

/// `None` where there are no intervals for this room or these bodies.
fn open_square(
    scenario: &Scenario,
    simulator: &Simulator,
    orientations: &[UnitQuaternion<f64>],
    tip: &Point3<f64>,
    task: &Task,
) -> Result<Option<f64>, Cancelled> {
    if task.cancel.is_cancelled() {
        return Err(Cancelled);
    }
    let trials = orientations
        .iter()
        .map(|turn| InputTrial::at(simulator.crf_from_tool_with_tip_at(tip, turn)));
    let mode = Mode::Input(trials.collect());
    let found = match expected(scenario, &mode, &task.cancel) {
        Ok(found) => found,
        Err(ExpectedError::Study(StudyError::Cancelled)) => return Err(Cancelled),
        // Nothing is usable there whatever the interval.
        Err(ExpectedError::Study(_)) => return Ok(Some(0.0)),
        Err(_) => return Ok(None),
    };
    let Some(requirement) = &scenario.requirement else {
        return Ok(None);
    };
    let bounds = requirement.bounds();
    let upper =
        share_of(bounds.clone().map(|(metric, limit)| (found.continued[metric.index()][1], limit)));
    let own = share_of(bounds.map(|(metric, limit)| (found.own_of(metric), limit)));
    Ok(Some(match own.is_finite() {
        true => (upper * upper - own * own).max(0.0),
        false => 0.0,
    }))
}
