//! Control charts of several figures, as a result and as one picture: individuals to the left, moving
//! ranges to the right.

use super::plot::{Axis, Chart, Series, SeriesStyle};
use maud::{PreEscaped, html};
use serde_json::json;
use std::collections::BTreeSet;
use trackwright_calibration::protocol::control_chart::{ControlChart, Signal};
use trackwright_result::{Section, Table, data};

/// Size of each chart in pixels.
const WIDTH: u32 = 640;
const HEIGHT: u32 = 360;

/// A figure over the runs.
#[derive(Clone, Debug, PartialEq)]
pub struct FigureChart {
    /// For programs.
    pub key: String,
    pub label: String,
    pub unit: &'static str,
    pub chart: ControlChart,
}

/// The charts in figures; `runs` names the runs.
pub fn section(figures: &[FigureChart], runs: &[String]) -> Section {
    let marked = |figure: &FigureChart| {
        figure.chart.signals.iter().map(|(run, _)| run).collect::<BTreeSet<_>>().len()
    };
    let signals = |figure: &FigureChart| {
        let why =
            |(run, signal): &(usize, Signal)| json!({"run": runs[*run], "why": signal.label()});
        figure.chart.signals.iter().map(why).collect::<Vec<_>>()
    };
    let lines = figures.iter().flat_map(|FigureChart { label, unit, chart, .. }| {
        chart.signals.iter().map(move |(run, signal)| {
            let value = chart.values[*run];
            format!("{label}: {} is {value:.4} {unit}: {}", runs[*run], signal.label())
        })
    });
    let table = Table::of("figures", figures)
        .data("figure", |figure| figure.key.clone())
        .text("", "figure", |figure| figure.label.clone())
        .data("unit", |figure| figure.unit)
        .number("", "runs", 0, |figure| figure.chart.values.len())
        .data("values", |figure| figure.chart.values.clone())
        .data("moving_ranges", |figure| figure.chart.moving_ranges.clone())
        .data("limits", |figure| figure.chart.limits)
        .number("", "mean", 4, |figure| Some(figure.chart.limits?.mean))
        .number("", "lower", 4, |figure| Some(figure.chart.limits?.lower))
        .number("", "upper", 4, |figure| Some(figure.chart.limits?.upper))
        .number("", "range", 4, |figure| Some(figure.chart.limits?.mean_range))
        .number("", "upper", 4, |figure| Some(figure.chart.limits?.upper_range))
        .number("", "out of control", 0, marked)
        .data("out_of_control", signals);
    Section::of([data("runs", runs)]).with(table.done()).with_all(lines)
}

/// Two charts a figure, one below the other; `runs` names the runs, which are numbered from 1.
pub fn svg(figures: &[FigureChart], runs: &[String]) -> String {
    let (width, height) = (2 * WIDTH, HEIGHT * figures.len() as u32);
    let cells = figures.iter().enumerate().flat_map(|(row, figure)| {
        let charts = [individuals(figure, runs), moving_ranges(figure, runs)];
        charts.into_iter().enumerate().map(move |(column, chart)| {
            let at = (column as u32 * WIDTH, row as u32 * HEIGHT);
            (at, chart.to_svg((WIDTH, HEIGHT)))
        })
    });
    let document = html! {
        svg width=(width) height=(height) viewBox=(format!("0 0 {width} {height}"))
            xmlns="http://www.w3.org/2000/svg" {
            @for ((x, y), chart) in cells {
                g transform=(format!("translate({x}, {y})")) { (PreEscaped(chart)) } "\n"
            }
        }
    };
    document.into_string()
}

fn individuals(figure: &FigureChart, runs: &[String]) -> Chart {
    let chart = &figure.chart;
    let points = (1..).map(f64::from).zip(chart.values.iter().copied()).collect();
    let mut series = vec![Series::new("run", SeriesStyle::Line, points)];
    if let Some(limits) = &chart.limits {
        series.extend(levels(&[
            ("mean", limits.mean),
            ("upper limit", limits.upper),
            ("lower limit", limits.lower),
        ]));
    }
    series.extend(marks(chart, runs, &chart.values, 0, |signal| signal != Signal::MovingRange));
    drawn(figure, figure.label.clone(), series)
}

fn moving_ranges(figure: &FigureChart, runs: &[String]) -> Chart {
    let chart = &figure.chart;
    let points = (2..).map(f64::from).zip(chart.moving_ranges.iter().copied()).collect();
    let mut series = vec![Series::new("moving range", SeriesStyle::Line, points)];
    if let Some(limits) = &chart.limits {
        series.extend(levels(&[("mean", limits.mean_range), ("upper limit", limits.upper_range)]));
    }
    series.extend(marks(chart, runs, &chart.moving_ranges, 1, |signal| {
        signal == Signal::MovingRange
    }));
    drawn(figure, format!("{}: change from run to run", figure.label), series)
}

fn drawn(figure: &FigureChart, title: String, series: Vec<Series>) -> Chart {
    Chart { title, x: Axis::linear("run"), y: Axis::linear(figure.unit), series }
}

fn levels(named: &[(&str, f64)]) -> Vec<Series> {
    let bound = |(name, at): &(&str, f64)| {
        Series::new(format!("{name} {at:.4}"), SeriesStyle::Bound, vec![(1.0, *at)])
    };
    named.iter().map(bound).collect()
}

/// A ring for each run that is out of control, with its name; values begin with run `first`.
fn marks(
    chart: &ControlChart,
    runs: &[String],
    values: &[f64],
    first: usize,
    is_shown: impl Fn(Signal) -> bool,
) -> Vec<Series> {
    let mut marked: Vec<usize> =
        chart.signals.iter().filter(|(_, signal)| is_shown(*signal)).map(|(run, _)| *run).collect();
    marked.dedup();
    let ring = |run: usize| {
        let at = (run as f64 + 1.0, *values.get(run.checked_sub(first)?)?);
        let name = runs.get(run).cloned().unwrap_or_default();
        Some(Series::new(name, SeriesStyle::Marked, vec![at]))
    };
    marked.into_iter().filter_map(ring).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use trackwright_calibration::protocol::control_chart::{Rules, control_chart};

    fn figure(values: &[f64]) -> FigureChart {
        let chart = control_chart(values, None, Rules::NelsonFirst).unwrap();
        FigureChart { key: "jitter".to_owned(), label: "jitter".to_owned(), unit: "mm", chart }
    }

    #[test]
    fn runs_out_of_control_are_ringed_and_named() {
        let mut values: Vec<f64> = (0..20).map(|run| 1.0 + 0.01 * f64::from(run % 2)).collect();
        values.push(1.2);
        let runs: Vec<String> = (0..21).map(|run| format!("week-{run} <a>")).collect();
        let picture = svg(&[figure(&values), figure(&values)], &runs);
        // One in each chart of two figures.
        assert_eq!(picture.matches("week-20 &lt;a&gt;").count(), 4);
        assert_eq!(picture.matches("r=\"10\" fill=\"none\"").count(), 4);
        assert_eq!(picture.matches("upper limit").count(), 4);
        assert_eq!(picture.matches("lower limit").count(), 2);
        assert!(!picture.contains("week-19"), "{picture}");
    }

    #[test]
    fn few_runs_are_drawn_without_limits() {
        let picture = svg(&[figure(&[1.0, 1.1, 0.9])], &["a", "b", "c"].map(str::to_owned));
        assert!(picture.starts_with("<svg") && !picture.contains("limit"), "{picture}");
    }
}
