//! What the measurements leave open of the tip RMS at each place of a sensor.
//!
//! Expected figures take some 10 ms a place, so that they are found at some places, over few trials, and
//! what they add to the figure of the room's model alone, `expected² - own²`, is taken from there to the
//! others, as are the interval's ends in parts of the expected value.
//!
//! Few trials are not the whole study. What they leave open is therefore multiplied by how far the whole
//! study is from them at one place, the candidate nearest to where the sensor is now: there the map shows
//! what the study shows.
//!
//! Of 39 vertices of the built-in pointer and its CRF the expected value is within 10 % of that of the
//! whole study in the median, within 15 % of the worst, and the interval's ends within a factor of 1.4:
//! most of it is from the few trials.

use super::best::{expected_tip, whole_mode, with_sensor};
use super::outcome::{Candidates, ExpectedTip, Placement, PlacementPlan};
use crate::plan::Plan;
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
    parts: Vec<OpenPart>,
    /// From few trials to the whole study.
    whole: WholeFromFew,
}

/// `expected² - own²` in mm², and the logarithms of the interval's ends in parts of the expected.
type OpenPart = [f64; 3];

/// How far the whole study is from few trials.
#[derive(Clone, Copy, Debug)]
struct WholeFromFew {
    times: f64,
    ends: [f64; 2],
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
        let open_at = |place: usize, mode: &Mode| -> Result<Option<OpenPart>, Cancelled> {
            if task.cancel.is_cancelled() {
                return Err(Cancelled);
            }
            let moved = with_sensor(scenario, plan, &candidates.sensors[place]);
            Ok(expected_tip(&moved, mode, task)?.and_then(open_part))
        };
        let present = candidates.nearest_to_present();
        let mut chosen = farthest_first(features, PLACES);
        if let Some(present) = present.filter(|present| !chosen.contains(present)) {
            chosen.push(present);
        }
        let found: Result<Vec<_>, Cancelled> = chosen
            .par_iter()
            .map(|&place| Ok(open_at(place, &mode)?.map(|part| (place, part))))
            .collect();
        let known: Vec<(usize, OpenPart)> = found?.into_iter().flatten().collect();
        let few = known.iter().find(|(place, _)| Some(*place) == present);
        let whole = match few {
            Some((place, few)) => {
                let whole = open_at(*place, &whole_mode(scenario))?;
                whole.map_or(WholeFromFew::SAME, |whole| WholeFromFew::between(few, &whole))
            }
            None => WholeFromFew::SAME,
        };
        let (places, parts) = known.into_iter().map(|(at, part)| (features[at], part)).unzip();
        let parts: Self = Self { places, parts, whole };
        Ok((!parts.places.is_empty()).then_some(parts))
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
                let WholeFromFew { times, ends } = self.whole;
                let rms_mm = own_mm.hypot((mixed(0) * times).sqrt());
                let end = |k: usize| rms_mm * (mixed(1 + k) + ends[k]).exp();
                placement.expected = Some(ExpectedTip { rms_mm, interval_mm: [end(0), end(1)] });
            },
        );
    }
}

impl WholeFromFew {
    const SAME: Self = Self { times: 1.0, ends: [0.0; 2] };

    fn between(few: &OpenPart, whole: &OpenPart) -> Self {
        Self {
            times: if few[0] > 0.0 { whole[0] / few[0] } else { 1.0 },
            ends: [whole[1] - few[1], whole[2] - few[2]],
        }
    }
}

/// What an expected figure adds to that of the room's model alone; `None` where that is not a number.
fn open_part((expected, own_mm): (ExpectedTip, f64)) -> Option<OpenPart> {
    let ExpectedTip { rms_mm, interval_mm } = expected;
    let end = |end: f64| (end / rms_mm).max(f64::MIN_POSITIVE).ln();
    let open = (rms_mm * rms_mm - own_mm * own_mm).max(0.0);
    let part = [open, end(interval_mm[0]), end(interval_mm[1])];
    part.iter().all(|v| v.is_finite()).then_some(part)
}

/// Trials spread over the design's motion, or its own pose; `None` without measurements.
fn few_trials(scenario: &Scenario) -> Option<Mode> {
    if !scenario.environment.states_uncertainty() {
        return None;
    }
    let whole = whole_mode(scenario);
    let plan = Plan::new(scenario, &whole).ok()?;
    let some = plan.spread(TRIALS).into_iter();
    Some(Mode::Input(some.map(|i| plan.trial(scenario, i)).collect()))
}
