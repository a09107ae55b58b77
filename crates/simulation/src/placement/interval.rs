//! What the measurements leave open of the tip RMS at each place of a sensor.
//!
//! Expected figures take some 10 ms a place, so that they are found at some places, over few trials, and
//! what they add to the figure of the room's own field, `expected² - own²`, is taken from there to the
//! others, as are the interval's ends in parts of the expected value.
//!
//! Of 39 vertices of the built-in pointer and its CRF the expected value is within 10 % of that of the
//! whole study in the median, within 15 % of the worst, and the interval's ends within a factor of 1.4:
//! most of it is from the few trials.

use super::outcome::{Candidates, ExpectedTip, PlacedBody, Placement, PlacementPlan};
use crate::expected::{ExpectedError, expected, spread};
use crate::metric::Metric;
use crate::plan::Plan;
use crate::run::StudyError;
use crate::scenario::{Mode, Scenario};
use rayon::prelude::*;
use trackwright_geometry::spread::{Position, farthest_first, shares};
use trackwright_task::{Cancelled, Task};

/// Places whose expected figure is computed.
const PLACES: usize = 64;

/// Trials of the study that it is computed over.
const TRIALS: usize = 16;

/// Expected tip RMS at some places.
pub(super) struct OpenParts {
    places: Vec<Position>,
    /// `expected² - own²` in mm², and the logarithms of the interval's ends in parts of the expected.
    parts: Vec<[f64; 3]>,
}

impl OpenParts {
    /// `None` in a room that keeps no measurements, and for bodies with markers.
    ///
    /// # Errors
    /// [`Cancelled`].
    pub fn find(
        scenario: &Scenario,
        plan: &PlacementPlan,
        candidates: &Candidates,
        features: &[Position],
        task: &Task,
    ) -> Result<Option<Self>, Cancelled> {
        let Some(mode) = few_trials(scenario) else {
            return Ok(None);
        };
        let chosen = farthest_first(features, PLACES);
        let found: Result<Vec<_>, Cancelled> = chosen
            .par_iter()
            .map(|&place| {
                if task.cancel.is_cancelled() {
                    return Err(Cancelled);
                }
                let mut moved = scenario.clone();
                let body = match (plan.body, &mut moved.crf) {
                    (PlacedBody::Crf, Some(crf)) => &mut crf.body,
                    _ => &mut moved.tool,
                };
                if let Some(sensor) = body.sensors.get_mut(plan.sensor) {
                    *sensor = candidates.sensors[place].clone();
                }
                match expected(&moved, &mode, &task.cancel) {
                    Ok(found) => {
                        let (rms_mm, ends) = found.of(Metric::TIP_RMS);
                        let own_mm = found.own_of(Metric::TIP_RMS);
                        let end = |end: f64| (end / rms_mm).max(f64::MIN_POSITIVE).ln();
                        let open = (rms_mm * rms_mm - own_mm * own_mm).max(0.0);
                        Ok(Some((features[place], [open, end(ends[0]), end(ends[1])])))
                    }
                    Err(ExpectedError::Study(StudyError::Cancelled)) => Err(Cancelled),
                    Err(_) => Ok(None),
                }
            })
            .collect();
        let known = found?.into_iter().flatten();
        let is_finite = |(_, part): &(Position, [f64; 3])| part.iter().all(|v| v.is_finite());
        let (places, parts): (Vec<Position>, Vec<[f64; 3]>) = known.filter(is_finite).unzip();
        Ok((!places.is_empty()).then_some(Self { places, parts }))
    }

    /// The expected tip RMS of every place.
    pub fn add_to(&self, of_place: &mut [Placement], place_of: &[usize], features: &[Position]) {
        of_place.par_iter_mut().zip(place_of).for_each_init(
            || (Vec::new(), Vec::new()),
            |(near, parts), (placement, &place)| {
                let Some(own_mm) = placement.tip_rms_mm else {
                    return;
                };
                shares(&features[place], &self.places, None, near, parts);
                let mixed = |k: usize| -> f64 {
                    let each = parts.iter();
                    each.map(|&(share, i)| share * self.parts[i][k]).sum()
                };
                let rms_mm = own_mm.hypot(mixed(0).sqrt());
                placement.expected = Some(ExpectedTip {
                    rms_mm,
                    interval_mm: [rms_mm * mixed(1).exp(), rms_mm * mixed(2).exp()],
                });
            },
        );
    }
}

/// Trials spread over the design's motion, or its own pose; `None` without measurements.
fn few_trials(scenario: &Scenario) -> Option<Mode> {
    scenario.environment.process.as_ref()?;
    let whole = match scenario.motion {
        Some(_) => Mode::Motion,
        None => Mode::Single,
    };
    let plan = Plan::new(scenario, &whole).ok()?;
    let some = spread(plan.len(), TRIALS.min(plan.len()));
    Some(Mode::Input(some.map(|i| plan.trial(scenario, i)).collect()))
}
