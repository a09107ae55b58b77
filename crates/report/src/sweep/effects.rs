//! What one number does to a figure while all others vary.

use super::{NumberColumn, SweepColumns};
use crate::plot::{Axis, Chart, Series, SeriesStyle};
use statrs::distribution::{ContinuousCDF, StudentsT};

/// Groups of a number that has more values.
const GROUPS: usize = 12;

/// The mean of a figure over the rows of one value, or of neighbouring values, of a number.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Effect {
    /// The mean of the number.
    pub at: f64,
    pub mean: f64,
    /// 95 % interval of the mean.
    pub interval: [f64; 2],
    pub rows: usize,
}

/// Means of a figure for the values of a number, by the number.
///
/// Few values are a group each, many are cut into groups of as many rows. The interval is that of a mean of
/// independent rows (Student): of a grid it is how far the mean spreads over what else varies.
pub fn main_effect(number: &[f64], figure: &[f64]) -> Vec<Effect> {
    let mut pairs: Vec<(f64, f64)> = number
        .iter()
        .copied()
        .zip(figure.iter().copied())
        .filter(|(x, y)| x.is_finite() && y.is_finite())
        .collect();
    pairs.sort_by(|a, b| a.0.total_cmp(&b.0));
    let distinct: Vec<&[(f64, f64)]> = pairs.chunk_by(|a, b| a.0 == b.0).collect();
    if distinct.len() <= GROUPS {
        return distinct.into_iter().map(effect).collect();
    }
    let at = |k: usize| k * pairs.len() / GROUPS;
    (0..GROUPS).map(|k| effect(&pairs[at(k)..at(k + 1)])).collect()
}

fn effect(pairs: &[(f64, f64)]) -> Effect {
    let count = pairs.len() as f64;
    let mean = |of: fn(&(f64, f64)) -> f64| pairs.iter().map(of).sum::<f64>() / count;
    let (at, middle) = (mean(|pair| pair.0), mean(|pair| pair.1));
    let square = pairs.iter().map(|(_, y)| (y - middle).powi(2)).sum::<f64>();
    // Of one row nothing is known but itself.
    let student = StudentsT::new(0.0, 1.0, count - 1.0).map(|student| student.inverse_cdf(0.975));
    let half = student.map_or(0.0, |t| t * (square / (count - 1.0) / count).sqrt());
    Effect { at, mean: middle, interval: [middle - half, middle + half], rows: pairs.len() }
}

/// The effect of a number on a figure.
pub fn effect_chart(sweep: &SweepColumns, number: &NumberColumn, figure: &NumberColumn) -> Chart {
    let effects = main_effect(&number.values, &figure.values);
    let ends = |effect: &Effect| effect.interval.map(|end| (effect.at, end));
    Chart {
        title: format!("{}: mean of {} for {}", sweep.title, figure.name, number.name),
        x: Axis::linear(number.label()),
        y: Axis::linear(figure.label()),
        series: vec![
            Series::new(
                "mean",
                SeriesStyle::Line,
                effects.iter().map(|e| (e.at, e.mean)).collect(),
            ),
            Series::new(
                "its 95 % interval",
                SeriesStyle::Intervals,
                effects.iter().flat_map(ends).collect(),
            ),
        ],
    }
}
