//! The designs that no other one beats in two figures (Pareto front).

use super::{NumberColumn, SweepColumns};
use crate::plot::{Axis, Chart, Series, SeriesStyle};

/// The rows that no other row is better than in one of two figures and no worse in the other, by the first.
/// Of rows with the same figures the first.
pub fn front(first: &[f64], second: &[f64]) -> Vec<usize> {
    let mut rows: Vec<usize> =
        (0..first.len()).filter(|&row| first[row].is_finite() && second[row].is_finite()).collect();
    rows.sort_by(|&a, &b| {
        let by = |of: &[f64]| of[a].total_cmp(&of[b]);
        by(first).then(by(second)).then(a.cmp(&b))
    });
    let mut best = f64::INFINITY;
    rows.retain(|&row| {
        let is_better = second[row] < best;
        best = best.min(second[row]);
        is_better
    });
    rows
}

/// Two figures of all rows, and the front.
pub fn front_chart(sweep: &SweepColumns, first: &NumberColumn, second: &NumberColumn) -> Chart {
    let point = |row: usize| (first.values[row], second.values[row]);
    let best = front(&first.values, &second.values);
    let path: Vec<(f64, f64)> = best.iter().map(|&row| point(row)).collect();
    let shown = sweep.drawn().into_iter().map(point).collect();
    Chart {
        title: format!("{}: {} against {}", sweep.title, second.name, first.name),
        x: Axis::linear(first.label()),
        y: Axis::linear(second.label()),
        series: vec![
            Series::new("no row is better in both", SeriesStyle::Front, path.clone()),
            Series::new("rows", SeriesStyle::Points, shown),
            Series::new("rows of the front", SeriesStyle::Points, path),
        ],
    }
}
