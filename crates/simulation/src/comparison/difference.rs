//! The difference of two designs' figures, how far it may be off, and whether it is one.
//!
//! Two things stand between a difference of two studies and one of two tools: the studies share a
//! room that was measured with noise, and each visits a grid of its range of motion. `docs/methods/comparing.md`
//! derives what is done here.

use super::sampled::{Drawn, DrawnFrom, Sampled};
use crate::expected::WIDENING;
use crate::judgement::Undecided;
use crate::metric::{ErrorOf, METRICS, Metric, MetricValues, Summary};
use serde::Serialize;
use statrs::distribution::{ContinuousCDF, StudentsT};

/// Part of such intervals that hold the true difference.
pub const COVERAGE: f64 = 0.95;

/// Below this no difference is called one: less than any EM tracker's jitter (0.04 mm at the very
/// least, on real recordings) and than a sensor can be glued to its place.
pub const LEAST_MM: f64 = 0.01;

/// Likewise: 0.01 mm across some 60 mm.
pub const LEAST_DEG: f64 = 0.01;

/// The verdict on a difference.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum DifferenceVerdict {
    /// The error is smaller than the baseline's.
    Better,
    Worse,
    /// Smaller than what the model's uncertainty and the sampling of the motion allow, or than what counts
    /// while it may be more.
    NotTold,
    /// Too small to matter, whether it is there or not: the whole interval is.
    Negligible,
    /// More than the sampling allows, in a room that does not state how far it may be off.
    RoomUnknown,
    /// A study of the two leaves a rotation open or left trials out: its figures may be any others.
    Unsettled,
    /// The two are in different rooms: a smaller error in another room is no better design.
    OtherRoom,
}

/// A figure less the baseline's, in the figure's unit.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Difference {
    #[serde(skip)]
    pub metric: Metric,
    /// Of the figures that the studies print.
    pub difference: f64,
    /// Of the same figures over the whole range of motion, as far as it was looked at between the
    /// poses of the grid; `None` where nothing moves.
    pub over_range: Option<f64>,
    /// Standard deviation for the room's error, which both designs share; `None` where the room does
    /// not state it.
    pub model_std: Option<f64>,
    /// Standard error of `over_range`; `None` where nothing moves.
    pub sampling_std: Option<f64>,
    /// Holds 95 %.
    pub low: f64,
    pub high: f64,
    pub verdict: DifferenceVerdict,
    /// Of the design, else of the baseline.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub unsettled: Option<Undecided>,
}

/// What a design's figures are, and how far they may be off.
#[derive(Clone, Debug)]
pub(super) struct Side<'a> {
    /// What is known of its figures.
    pub grid: &'a MetricValues,
    /// By the room's model alone, as `sampled` and `drawn` have it.
    pub own: &'a MetricValues,
    pub sampled: Option<&'a Sampled>,
    pub drawn: Option<&'a Drawn>,
    pub unsettled: Option<Undecided>,
}

/// Least differences that count, mm and degrees.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Least {
    pub mm: f64,
    pub deg: f64,
}

impl Default for Least {
    fn default() -> Self {
        Self { mm: LEAST_MM, deg: LEAST_DEG }
    }
}

/// Every figure of a design less the baseline's.
pub(super) fn differences(design: Side<'_>, baseline: Side<'_>, least: Least) -> Vec<Difference> {
    let each = METRICS.iter().enumerate();
    each.map(|(index, metric)| difference(index, *metric, [&design, &baseline], least)).collect()
}

/// The same of two that are in different rooms: differences without a verdict on the designs.
pub(super) fn between_rooms(differences: Vec<Difference>) -> Vec<Difference> {
    let each = differences.into_iter();
    each.map(|difference| Difference { verdict: DifferenceVerdict::OtherRoom, ..difference })
        .collect()
}

fn difference(index: usize, metric: Metric, sides: [&Side<'_>; 2], least: Least) -> Difference {
    let [a, b] = sides.map(|side| side.grid[index]);
    let difference = a - b;
    let mut hull = Hull::of(difference);
    let mut over_range = None;
    let mut sampling = None;
    if sides.iter().any(|side| side.sampled.is_some()) {
        let [wide_a, wide_b] = sides.map(|side| side.over_range(index, metric));
        over_range = Some(wide_a - wide_b);
        hull.add(wide_a - wide_b);
        if metric.is_extreme() {
            // Either may have been pushed further where the other was not looked at closely enough.
            hull.add(wide_a - b);
            hull.add(a - wide_b);
            sampling = Some(Spread::none());
        } else {
            let own = sides.map(|side| side.own[index]);
            sampling = Some(Spread::of_replicates(&sides.map(|side| side.sampled), own, index));
        }
    }
    let drawn = match sides.map(|side| side.drawn) {
        [Some(a), Some(b)] => Some((a, b)),
        _ => None,
    };
    let model = drawn.map(|(a, b)| Spread::of_draws(a, b, index));
    let mut half_width = sampling.as_ref().map_or(0.0, |s| s.half_width);
    match drawn.and_then(|(a, b)| measured_ends(a, b, index)) {
        Some(ends) => ends.into_iter().for_each(|end| hull.add(end)),
        None => {
            if let Some(model) = &model {
                half_width = half_width.hypot(model.half_width);
                hull.shift(model.shift);
            }
        }
    }
    let (low, high) = (hull.low - half_width, hull.high + half_width);
    let least = match metric.of {
        ErrorOf::Position => least.mm,
        ErrorOf::Angle => least.deg,
    };
    let is_resolved = (low > 0.0 || high < 0.0) && difference.abs() >= least;
    // Where it is not known how far the room is off, only no difference at all is known to be small.
    let is_small = low > -least && high < least && (model.is_some() || (low == 0.0 && high == 0.0));
    let unsettled = sides.iter().find_map(|side| side.unsettled.clone());
    let verdict = if unsettled.is_some() {
        DifferenceVerdict::Unsettled
    } else if is_small {
        DifferenceVerdict::Negligible
    } else if !is_resolved {
        DifferenceVerdict::NotTold
    } else if model.is_none() {
        DifferenceVerdict::RoomUnknown
    } else if difference < 0.0 {
        DifferenceVerdict::Better
    } else {
        DifferenceVerdict::Worse
    };
    Difference {
        metric,
        difference,
        over_range,
        model_std: model.map(|m| m.std),
        sampling_std: sampling.map(|s| s.std),
        low,
        high,
        verdict,
        unsettled,
    }
}

impl Side<'_> {
    /// The figure over the range of motion; that of the grid for what has none. What the grid leaves out is
    /// known of the room's model alone, in squares.
    fn over_range(&self, index: usize, metric: Metric) -> f64 {
        let grid = self.grid[index];
        let Some(sampled) = self.sampled else {
            return grid;
        };
        let whole = sampled.whole[index];
        let beyond = whole * whole - self.own[index] * self.own[index];
        let whole = (grid * grid + beyond).max(0.0).sqrt();
        match metric.summary {
            Summary::Max => grid.max(whole),
            _ if metric.is_extreme() => grid.min(whole),
            _ => whole,
        }
    }
}

/// From the least to the largest of what the difference may be before noise.
#[derive(Clone, Copy, Debug)]
struct Hull {
    low: f64,
    high: f64,
}

impl Hull {
    fn of(value: f64) -> Self {
        Self { low: value, high: value }
    }

    fn add(&mut self, value: f64) {
        self.low = self.low.min(value);
        self.high = self.high.max(value);
    }

    /// Holds what it held, and the same moved by so much.
    fn shift(&mut self, by: f64) {
        let moved = Self { low: self.low + by, high: self.high + by };
        self.add(moved.low);
        self.add(moved.high);
    }
}

/// How a difference scatters.
#[derive(Clone, Copy, Debug)]
struct Spread {
    std: f64,
    /// Of the interval, from its middle.
    half_width: f64,
    /// From the difference as it is found to the one that is expected.
    shift: f64,
}

impl Spread {
    fn none() -> Self {
        Self { std: 0.0, half_width: 0.0, shift: 0.0 }
    }

    /// Of the mean of independent looks at the range of motion, in which both designs take the same
    /// part of theirs; `grid` stands for a design that does not move.
    fn of_replicates(sampled: &[Option<&Sampled>; 2], grid: [f64; 2], index: usize) -> Self {
        let count = sampled.iter().flatten().map(|s| s.replicates.len()).min().unwrap_or(0);
        let value = |side: usize, replicate: usize| {
            sampled[side].map_or(grid[side], |s| s.replicates[replicate][index])
        };
        let each = (0..count).map(|replicate| value(0, replicate) - value(1, replicate));
        let (_, std) = mean_and_std(each);
        let std = std / (count.max(1) as f64).sqrt();
        Self { std, half_width: quantile(count) * std, shift: 0.0 }
    }

    /// Over drawn fields, the same for both designs where they are in one room.
    fn of_draws(a: &Drawn, b: &Drawn, index: usize) -> Self {
        let nominal = a.nominal[index] - b.nominal[index];
        let each = a.draws.iter().zip(&b.draws);
        let (mean, std) = mean_and_std(each.map(|(a, b)| a[index] - b[index]));
        let bias = mean - nominal;
        let (shift, widening) = match a.from {
            DrawnFrom::Refits => (-bias, 1.0),
            DrawnFrom::Measurements => (bias, WIDENING),
        };
        Self { std, half_width: widening * quantile(a.draws.len().min(b.draws.len())) * std, shift }
    }
}

/// Intervals of drawn differences are widened by these, on logarithmic scales: of the ratio of the
/// two figures, and of their size. What a process is wrong by is mostly the size of the error, which
/// both designs share; it does not change which of them is better. Found in 24 rooms of an independent
/// tracker (95 pairs of tools): without them 86 to 95 % of the intervals hold, with them 95 to 99 %.
const RATIO_WIDENING: f64 = 1.5;
const SIZE_WIDENING: f64 = 1.25;

/// What the difference of two figures may be in fields drawn from measurements: with a design's figure
/// `a` and the baseline's `b`, ratio `r = ln(a / b)` and size `s = sqrt(a b)`, it is `2 s sinh(r / 2)`.
/// `None` where fields were drawn otherwise, and where a figure is zero in one of them.
fn measured_ends(a: &Drawn, b: &Drawn, index: usize) -> Option<[f64; 4]> {
    if [a, b].iter().any(|drawn| drawn.from != DrawnFrom::Measurements) {
        return None;
    }
    let pairs: Vec<[f64; 2]> =
        a.draws.iter().zip(&b.draws).map(|(a, b)| [a[index], b[index]]).collect();
    let own = [a.nominal[index], b.nominal[index]];
    if pairs.iter().chain([&own]).flatten().any(|value| *value <= 0.0) {
        return None;
    }
    let ends = |widening: f64, (mean, std): (f64, f64)| {
        let half_width = widening * quantile(pairs.len()) * std;
        [mean - half_width, mean + half_width]
    };
    let each = pairs.iter();
    let ratio = mean_and_std(each.clone().map(|[a, b]| (a / b).ln()));
    let size = mean_and_std(each.map(|[a, b]| 0.5 * (a.ln() + b.ln())));
    // The room's model alone is one of those that are possible.
    let own_ratio = (own[0] / own[1]).ln();
    let [low, high] = ends(RATIO_WIDENING, ratio);
    let ratios = [low.min(own_ratio), high.max(own_ratio)];
    let [small, large] = ends(SIZE_WIDENING, size).map(f64::exp);
    let at = |size: f64| ratios.map(|ratio| 2.0 * size * (0.5 * ratio).sinh());
    let ([a, b], [c, d]) = (at(small), at(large));
    Some([a, b, c, d])
}

/// Mean and sample standard deviation.
fn mean_and_std(values: impl Iterator<Item = f64> + Clone) -> (f64, f64) {
    let count = values.clone().count() as f64;
    let mean = values.clone().sum::<f64>() / count.max(1.0);
    let squares: f64 = values.map(|v| (v - mean).powi(2)).sum();
    (mean, (squares / (count - 1.0).max(1.0)).sqrt())
}

/// Student's t of a standard deviation estimated from so many values.
fn quantile(count: usize) -> f64 {
    let freedom = count.saturating_sub(1).max(1) as f64;
    StudentsT::new(0.0, 1.0, freedom)
        .map(|t| t.inverse_cdf(0.5 + COVERAGE / 2.0))
        .unwrap_or(f64::INFINITY)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sampled(values: &[f64]) -> Sampled {
        Sampled {
            whole: [values.iter().sum::<f64>() / values.len() as f64; METRICS.len()],
            replicates: values.iter().map(|v| [*v; METRICS.len()]).collect(),
        }
    }

    fn drawn(nominal: f64, draws: &[f64]) -> Drawn {
        Drawn {
            nominal: [nominal; METRICS.len()],
            draws: draws.iter().map(|v| [*v; METRICS.len()]).collect(),
            from: DrawnFrom::Refits,
        }
    }

    fn rms(design: Side<'_>, baseline: Side<'_>) -> Difference {
        differences(design, baseline, Least::default())[0].clone()
    }

    fn side<'a>(grid: &'a MetricValues, drawn: &'a Drawn) -> Side<'a> {
        Side { grid, own: grid, sampled: None, drawn: Some(drawn), unsettled: None }
    }

    #[test]
    fn only_model_errors_of_both_designs_cancel() {
        let (one, two) = ([1.0; METRICS.len()], [1.5; METRICS.len()]);
        let draws: Vec<f64> = (0..64).map(|k| f64::from(k % 8) - 3.5).collect();
        let moved = |by: f64| draws.iter().map(|d| d + by).collect::<Vec<_>>();
        let (shared, also) = (drawn(1.0, &moved(1.0)), drawn(1.5, &moved(1.5)));
        let own = drawn(1.5, &moved(1.5).into_iter().rev().collect::<Vec<_>>());
        let same_room = rms(side(&two, &also), side(&one, &shared));
        assert!(same_room.model_std.unwrap() < 1e-15);
        assert!((same_room.low - 0.5).abs() < 1e-14 && (same_room.high - 0.5).abs() < 1e-14);
        assert_eq!(same_room.verdict, DifferenceVerdict::Worse);
        let other = rms(side(&two, &own), side(&one, &shared));
        // Reversed they are each other's negative: twice the deviation.
        assert!(
            (other.model_std.unwrap() - 2.0 * 5.25_f64.sqrt() * (64.0 / 63.0_f64).sqrt()).abs()
                < 1e-12
        );
        assert_eq!(other.verdict, DifferenceVerdict::NotTold);
    }

    #[test]
    fn only_a_small_interval_is_negligible() {
        let zero = [0.0; METRICS.len()];
        let verdict = |difference: f64, spread: f64| {
            let draws: Vec<f64> = (0..64).map(|k| spread * f64::from(k % 2 * 2 - 1)).collect();
            let (grid, own) = ([difference; METRICS.len()], drawn(difference, &draws));
            let base = drawn(0.0, &[0.0; 64]);
            rms(side(&grid, &own), side(&zero, &base)).verdict
        };
        assert_eq!(verdict(0.004, 1e-4), DifferenceVerdict::Negligible);
        assert_eq!(verdict(0.004, 0.1), DifferenceVerdict::NotTold);
        assert_eq!(verdict(0.0, 0.1), DifferenceVerdict::NotTold);
        assert_eq!(verdict(0.02, 1e-4), DifferenceVerdict::Worse);
    }

    #[test]
    fn a_shared_error_scale_does_not_hide_the_better_one() {
        // In every field the design is off by a fifth less, and fields differ by a factor of four.
        let sizes: Vec<f64> = (0..64).map(|k| 2.0_f64.powf(f64::from(k % 8) / 3.5)).collect();
        let less: Vec<f64> = sizes.iter().map(|size| 0.8 * size).collect();
        let measured = |nominal, draws: &[f64]| Drawn {
            from: DrawnFrom::Measurements,
            ..drawn(nominal, draws)
        };
        let (design, baseline) = (measured(0.4, &less), measured(0.5, &sizes));
        let (own, theirs) = ([0.4; METRICS.len()], [0.5; METRICS.len()]);
        let found = rms(side(&own, &design), side(&theirs, &baseline));
        assert_eq!(found.verdict, DifferenceVerdict::Better);
        // The largest difference in a drawn field is a fifth of four.
        assert!(found.low < -0.8 && (-0.2..0.0).contains(&found.high), "{found:?}");
    }

    #[test]
    fn the_interval_spans_grid_and_range_differences() {
        let (one, two) = ([1.0; METRICS.len()], [1.5; METRICS.len()]);
        // The design's own 1.2 over its range, four looks that differ by 0.1 each.
        let looks = sampled(&[1.05, 1.15, 1.25, 1.35]);
        let side = |grid, sampled| Side { grid, own: grid, sampled, drawn: None, unsettled: None };
        let found = rms(side(&two, Some(&looks)), side(&one, None));
        assert!((found.over_range.unwrap() - 0.2).abs() < 1e-14);
        let std = (0.05 / 3.0_f64).sqrt() / 2.0;
        assert!((found.sampling_std.unwrap() - std).abs() < 1e-14);
        // Student's t of three degrees of freedom.
        assert!((found.low - (0.2 - 3.182_446 * std)).abs() < 1e-6, "{found:?}");
        assert!((found.high - (0.5 + 3.182_446 * std)).abs() < 1e-6);
        // The largest over grid and range is the grid's 1.5.
        let max = &differences(side(&two, Some(&looks)), side(&one, None), Least::default())[6];
        assert_eq!((max.difference, max.over_range), (0.5, Some(0.5)));
    }

    #[test]
    fn small_or_unknown_differences_give_no_winner() {
        let verdict = |a: f64, b: f64| {
            let [a, b] = [a, b].map(|v| [v; METRICS.len()]);
            let [a, b] = [&a, &b].map(|grid| Side {
                grid,
                own: grid,
                sampled: None,
                drawn: None,
                unsettled: None,
            });
            rms(a, b).verdict
        };
        assert_eq!(verdict(1.0, 1.0), DifferenceVerdict::Negligible);
        assert_eq!(verdict(1.0, 1.009), DifferenceVerdict::NotTold);
        assert_eq!(verdict(1.0, 1.011), DifferenceVerdict::RoomUnknown);
        assert_eq!(verdict(f64::NAN, 1.0), DifferenceVerdict::NotTold);
    }
}
