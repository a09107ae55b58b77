//! How far off sensors may be: the first order shows where it is worst and about how far,
//! simulation determines how far.
//!
//! Errors of several sensors grow together: a family states how large each is at scale 1. What is
//! looked for is the largest scale at which the requirement is met, every error at the edge of its
//! zone, in every direction that is tried. Those are the worst to first order, of each bound of the
//! requirement; the same once more from the errors that were simulated there, which mends what the
//! first order leaves out; and many that are spread over all directions. One of these that turns
//! out worse joins the others, and the scale is looked for again.

use super::as_built::{BuildErrors, BuiltBuffers, BuiltStudy};
use super::first_order::{Bound, Direction, FirstOrder, part};
use crate::metric::Metric;
use crate::requirement::Check;
use crate::work::Work;
use nalgebra::Vector3;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use rand_distr::{Distribution, StandardNormal};
use rayon::prelude::*;
use trackwright_geometry::rotation::log_quaternion;
use trackwright_task::{CancelToken, Cancelled};

/// Random directions that the first order starts from.
const STARTS: usize = 24;

/// Starts where every pose has to be looked at in each step, beside the worst of the RMS.
const COSTLY_STARTS: usize = 6;

/// Steps of the first order from each start; they end when a step gains less than [`GAIN`].
const STEPS: usize = 40;
const COSTLY_STEPS: usize = 12;

/// Part of a figure below which a step has gained nothing.
const GAIN: f64 = 1e-9;

/// Part of a scale to which the first order finds it.
const FIRST_ORDER_PRECISION: f64 = 1e-4;

/// Local maxima of each bound that are simulated.
const KEPT: usize = 2;

/// Directions are the same where every sensor's is within some 10° of the other's.
const SAME_COSINE: f64 = 0.985;

/// A step that moves no sensor's direction by more than this leads nowhere new: the figure, flat at a
/// maximum, changes by a millionth.
const SAME_STEP: f64 = 1e-3;

/// Directions that confirm a scale: those to the middles of the sides, edges and corners of a cube for
/// one sensor; for several as many at random.
const SPREAD_OF_SEVERAL: usize = 64;

/// Part of a scale to which it is found.
const PRECISION: f64 = 1e-3;

/// Steps by which the scale is first looked for above and below that of the first order.
const FIRST_STEP: f64 = 0.01;

/// A direction whose figure is further below the worst than this part of its limit, or that so many
/// are worse than, does not become the worst while a scale is looked for close by; if it does, it is
/// found at the end.
const NEAR: f64 = 0.02;
const MOST_NEAR: usize = 6;

/// Times that a scale is looked for again because a direction was worse than those known.
const ROUNDS: usize = 8;

/// Errors that grow together.
#[derive(Clone, Debug)]
pub struct Family {
    /// Numbers among the first order's blocks.
    pub blocks: Vec<usize>,
    /// Of each at scale 1, mm or radians.
    pub sizes: Vec<f64>,
    /// As far as is looked.
    pub cap: f64,
    /// A scale below this cannot be stated.
    pub floor: f64,
}

/// What was found for a family.
#[derive(Clone, Debug)]
pub struct Found {
    /// The largest scale at which the requirement was met; the cap where it always is.
    pub scale: f64,
    pub first_order: f64,
    /// What misses the requirement at a scale that is larger by no more than a thousandth; `None` where
    /// nothing does up to the cap.
    pub limit: Option<Missed>,
    /// Those that decided.
    pub directions: Vec<Direction>,
    pub cost: Cost,
}

/// A scale at which the requirement is missed.
#[derive(Clone, Debug)]
pub struct Missed {
    scale: f64,
    pub direction: Direction,
    pub bound: Option<Metric>,
}

/// What simulations cost.
#[derive(Clone, Copy, Debug, Default)]
pub struct Cost {
    pub simulations: u64,
    pub work: Work,
}

impl std::ops::AddAssign for Cost {
    fn add_assign(&mut self, other: Self) {
        self.simulations += other.simulations;
        self.work += other.work;
    }
}

/// A local maximum of a bound, by the bound's number.
struct Worst {
    bound: usize,
    direction: Direction,
}

/// One simulated direction.
struct Simulated {
    checks: Vec<Check>,
    ratio: f64,
    work: Work,
}

pub struct Search<'a> {
    pub study: &'a BuiltStudy<'a>,
    pub first_order: &'a FirstOrder,
    pub cancel: &'a CancelToken,
}

/// The largest figure as a part of its limit; endless without any figure.
pub fn worst_ratio(checks: &[Check]) -> f64 {
    let worst = nearest_bound(checks);
    worst.map_or(f64::INFINITY, |check| match check.met {
        true => part(check.value, check.limit).min(1.0),
        // Beyond 1, however little.
        false => part(check.value, check.limit).max(1.0 + f64::EPSILON),
    })
}

/// The bound that is reached, or will be first.
pub fn nearest_bound(checks: &[Check]) -> Option<&Check> {
    let ratio = |check: &Check| part(check.value, check.limit);
    checks.iter().max_by(|a, b| ratio(a).total_cmp(&ratio(b)))
}

impl Search<'_> {
    /// The largest scale of a family.
    ///
    /// # Errors
    /// [`Cancelled`].
    pub fn largest(&self, family: &Family) -> Result<Found, Cancelled> {
        let mut cost = Cost::default();
        let (first_order, mut known) = self.first_order_scale(family)?;
        known.extend(self.refined(family, first_order, &known, &mut cost)?);
        let found = self.simulate_all(family, first_order, &known, &mut cost)?;
        let mut critical = worst_of(&found, &known);
        let spread = self.spread(family);
        let (mut scale, mut high) = (0.0, None);
        for _ in 0..ROUNDS {
            (scale, high) = self.bracketed(family, first_order, &critical, high, &mut cost)?;
            if scale <= 0.0 {
                break;
            }
            // Is there a direction that is worse than those known to be?
            known.extend(self.refined(family, scale, &critical, &mut cost)?);
            let all = [&known[..], &spread[..]].concat();
            let found = self.simulate_all(family, scale, &all, &mut cost)?;
            critical.extend(worst_of(&found, &all));
            let Some(missed) = missed(scale, &found, &all) else {
                break;
            };
            high = Some(missed);
        }
        Ok(Found { scale, first_order, limit: high, directions: critical, cost })
    }

    /// The requirement in the worst of the directions given and of those spread over all, at sizes of
    /// one's own.
    ///
    /// # Errors
    /// [`Cancelled`].
    pub fn worst_at(
        &self,
        blocks: &[usize],
        sizes: &[f64],
        directions: &[Direction],
        cost: &mut Cost,
    ) -> Result<Vec<Check>, Cancelled> {
        let family =
            Family { blocks: blocks.to_vec(), sizes: sizes.to_vec(), cap: 1.0, floor: 0.0 };
        let mut all = directions.to_vec();
        all.extend(self.spread(&family));
        let found = self.simulate_all(&family, 1.0, &all, cost)?;
        let worst = found.into_iter();
        let worst = worst.max_by(|a, b| a.ratio.total_cmp(&b.ratio));
        Ok(worst.map_or_else(Vec::new, |simulated| simulated.checks))
    }

    /// A scale at which every direction meets the requirement and, if there is one below the cap, a
    /// slightly larger one at which one of them does not.
    fn bracketed(
        &self,
        family: &Family,
        guess: f64,
        directions: &[Direction],
        mut high: Option<Missed>,
        cost: &mut Cost,
    ) -> Result<(f64, Option<Missed>), Cancelled> {
        let mut low = 0.0;
        let mut step = FIRST_STEP;
        let mut next = high.as_ref().map_or(guess.min(family.cap), |high| guess.min(high.scale));
        loop {
            let found = self.simulate_all(family, next, directions, cost)?;
            match missed(next, &found, directions) {
                Some(missed) => high = Some(missed),
                None if next >= family.cap => return Ok((family.cap, None)),
                None => low = next,
            }
            let top = high.as_ref().map(|high| high.scale);
            next = match top {
                None => (low * (1.0 + step)).min(family.cap),
                Some(top) if top - low <= PRECISION * top => return Ok((low, high)),
                Some(top) if top < family.floor => return Ok((0.0, high)),
                Some(top) if low > 0.0 => 0.5 * (low + top),
                Some(top) => top * (1.0 - step.min(0.5)),
            };
            step *= 2.0;
        }
    }

    /// The requirement in one direction.
    ///
    /// # Errors
    /// [`Cancelled`].
    pub fn checks_at(
        &self,
        blocks: &[usize],
        sizes: &[f64],
        direction: &Direction,
        cost: &mut Cost,
    ) -> Result<Vec<Check>, Cancelled> {
        let errors = self.first_order.build_errors(self.study, blocks, sizes, direction);
        let simulated = self.simulate(&mut BuiltBuffers::default(), &errors)?;
        cost.simulations += 1;
        cost.work += simulated.work;
        Ok(simulated.checks)
    }

    fn sizes(family: &Family, scale: f64) -> Vec<f64> {
        family.sizes.iter().map(|size| size * scale).collect()
    }

    fn simulate_all(
        &self,
        family: &Family,
        scale: f64,
        directions: &[Direction],
        cost: &mut Cost,
    ) -> Result<Vec<Simulated>, Cancelled> {
        let sizes = Self::sizes(family, scale);
        let found: Result<Vec<Simulated>, Cancelled> = directions
            .par_iter()
            .map_init(BuiltBuffers::default, |buffers, direction| {
                self.simulate(buffers, &self.errors(family, &sizes, direction))
            })
            .collect();
        let found = found?;
        for simulated in &found {
            cost.simulations += 1;
            cost.work += simulated.work;
        }
        Ok(found)
    }

    fn simulate(
        &self,
        buffers: &mut BuiltBuffers,
        errors: &BuildErrors,
    ) -> Result<Simulated, Cancelled> {
        let checks = self.study.simulate(buffers, errors, self.cancel)?;
        Ok(Simulated { ratio: worst_ratio(&checks), checks, work: buffers.take_work() })
    }

    fn errors(&self, family: &Family, sizes: &[f64], direction: &Direction) -> BuildErrors {
        self.first_order.build_errors(self.study, &family.blocks, sizes, direction)
    }

    /// Of each bound, the next step from the errors that are simulated in its worst direction.
    fn refined(
        &self,
        family: &Family,
        scale: f64,
        directions: &[Direction],
        cost: &mut Cost,
    ) -> Result<Vec<Direction>, Cancelled> {
        let sizes = Self::sizes(family, scale);
        let tip = self.study.scenario().tool.judged_tip_in_body();
        let mut buffers = BuiltBuffers::default();
        let mut refined = Vec::new();
        for bound in &self.first_order.bounds {
            let motions = |d: &Direction| self.first_order.motions(&family.blocks, &sizes, d);
            let ratio = |d: &Direction| self.first_order.ratio(bound, &motions(d));
            let worst = directions.iter().max_by(|a, b| ratio(a).total_cmp(&ratio(b)));
            let Some(worst) = worst else { continue };
            let errors = self.errors(family, &sizes, worst);
            cost.simulations += 1;
            cost.work += self.simulate(&mut buffers, &errors)?.work;
            let errors = self.study.crf_from_tool().zip(&buffers.simulated);
            let errors = errors.filter(|((_, is_kept), _)| *is_kept).map(
                |((pose, _), simulated)| -> [Vector3<f64>; 2] {
                    [
                        simulated * tip - pose * tip,
                        log_quaternion(&(simulated.rotation * pose.rotation.inverse())),
                    ]
                },
            );
            let next = self.first_order.step_from(bound, &family.blocks, errors, worst);
            let is_new = next.iter().zip(worst).any(|(a, b)| (a - b).norm() > SAME_STEP);
            if is_new {
                refined.push(next);
            }
        }
        Ok(refined)
    }

    /// The scale at which the first order reaches a bound, and the worst directions there.
    fn first_order_scale(&self, family: &Family) -> Result<(f64, Vec<Direction>), Cancelled> {
        let (mut low, mut high) = (0.0, family.cap);
        let mut known = self.worst_directions(family, family.cap, &[])?;
        let is_met = |scale: f64, known: &[Worst]| {
            let sizes = Self::sizes(family, scale);
            known.iter().all(|worst| {
                let motions = self.first_order.motions(&family.blocks, &sizes, &worst.direction);
                let bound = &self.first_order.bounds[worst.bound];
                self.first_order.ratio(bound, &motions) <= 1.0
            })
        };
        if !is_met(high, &known) {
            while high - low > FIRST_ORDER_PRECISION * high
                && high > FIRST_ORDER_PRECISION * family.floor
            {
                let middle = 0.5 * (low + high);
                for worst in &mut known {
                    let bound = &self.first_order.bounds[worst.bound];
                    worst.direction = self.climb(family, middle, bound, &worst.direction)?.1;
                }
                if is_met(middle, &known) {
                    low = middle;
                } else {
                    high = middle;
                }
            }
            // The whole search once more: at another size the worst may be another.
            known = self.worst_directions(family, high, &known)?;
        }
        Ok((high, known.into_iter().map(|w| w.direction).collect()))
    }

    /// The worst local maxima of each bound, from many starts and those given.
    fn worst_directions(
        &self,
        family: &Family,
        scale: f64,
        known: &[Worst],
    ) -> Result<Vec<Worst>, Cancelled> {
        let starts = self.random(family, STARTS);
        let mut worst: Vec<Worst> = Vec::new();
        for (number, bound) in self.first_order.bounds.iter().enumerate() {
            let starts = match bound.is_costly() {
                false => &starts[..],
                true => &starts[..COSTLY_STARTS],
            };
            // What is worst for another bound is a start too.
            let others = known.iter().chain(&worst).map(|w| &w.direction);
            let mut found = Vec::new();
            for start in starts.iter().chain(others) {
                found.push(self.climb(family, scale, bound, start)?);
            }
            found.sort_by(|a, b| b.0.total_cmp(&a.0));
            let mut kept: Vec<Worst> = Vec::new();
            for (_, direction) in found {
                if kept.len() < KEPT && !kept.iter().any(|k| is_same(&k.direction, &direction)) {
                    kept.push(Worst { bound: number, direction });
                }
            }
            worst.extend(kept);
        }
        Ok(worst)
    }

    fn climb(
        &self,
        family: &Family,
        scale: f64,
        bound: &Bound,
        start: &Direction,
    ) -> Result<(f64, Direction), Cancelled> {
        if self.cancel.is_cancelled() {
            return Err(Cancelled);
        }
        let sizes = Self::sizes(family, scale);
        let (blocks, first_order) = (&family.blocks, self.first_order);
        let mut motions = first_order.motions(blocks, &sizes, start);
        let mut best = (first_order.ratio(bound, &motions), start.clone());
        let steps = if bound.is_costly() { COSTLY_STEPS } else { STEPS };
        for _ in 0..steps {
            let next = first_order.step(bound, blocks, &motions, &best.1);
            motions = first_order.motions(blocks, &sizes, &next);
            let ratio = first_order.ratio(bound, &motions);
            let gain = ratio - best.0;
            if ratio > best.0 {
                best = (ratio, next);
            }
            if gain <= GAIN * best.0 {
                break;
            }
        }
        Ok(best)
    }

    /// Directions that are spread over all.
    fn spread(&self, family: &Family) -> Vec<Direction> {
        let [only] = family.blocks[..] else {
            return self.random(family, SPREAD_OF_SEVERAL);
        };
        let block = &self.first_order.blocks[only];
        let range = || [-1.0, 0.0, 1.0].into_iter();
        let all = range().flat_map(|x| range().flat_map(move |y| range().map(move |z| [x, y, z])));
        all.filter(|v| *v != [0.0; 3]).map(|v| vec![block.unit_along(&Vector3::from(v))]).collect()
    }

    fn random(&self, family: &Family, count: usize) -> Vec<Direction> {
        let mut rng = ChaCha8Rng::seed_from_u64(family.blocks.len() as u64);
        let mut one = || Vector3::from_fn(|_, _| StandardNormal.sample(&mut rng));
        (0..count)
            .map(|_| {
                let blocks = family.blocks.iter();
                blocks.map(|&block| self.first_order.blocks[block].unit_along(&one())).collect()
            })
            .collect()
    }
}

/// What misses the requirement by most.
fn missed(scale: f64, found: &[Simulated], directions: &[Direction]) -> Option<Missed> {
    let each = found.iter().zip(directions).filter(|(s, _)| s.ratio > 1.0);
    let (worst, direction) = each.max_by(|a, b| a.0.ratio.total_cmp(&b.0.ratio))?;
    Some(Missed {
        scale,
        direction: direction.clone(),
        bound: nearest_bound(&worst.checks).map(|check| check.metric),
    })
}

/// The directions that come nearest to the worst.
fn worst_of(found: &[Simulated], directions: &[Direction]) -> Vec<Direction> {
    let worst = found.iter().map(|s| s.ratio).fold(0.0, f64::max);
    let each = found.iter().zip(directions);
    let mut near: Vec<_> = each.filter(|(s, _)| s.ratio >= worst - NEAR).collect();
    near.sort_by(|a, b| b.0.ratio.total_cmp(&a.0.ratio));
    near.into_iter().take(MOST_NEAR).map(|(_, d)| d.clone()).collect()
}

fn is_same(a: &Direction, b: &Direction) -> bool {
    a.iter().zip(b).all(|(a, b)| a.dot(b) > SAME_COSINE)
}
