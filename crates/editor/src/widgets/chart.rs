//! A chart in a panel: the same series as in the picture that a command writes, to zoom and hover.

use crate::palette;
use crate::palette::ThemedColor;
use crate::widgets::axis_ticks::{axis_ticks, mark_text};
use crate::widgets::basic::decimal;
use crate::widgets::theme;
use bevy_egui::egui::{Color32, Label, Rangef, RichText, Ui};
use egui_plot::{
    AxisHints, GridMark, HLine, HoverPosition, Line, MarkerShape, Plot, PlotPoints, Points,
};
use std::ops::RangeInclusive;
use trackwright_formats::printable::printable;
use trackwright_report::plot::{Axis, Chart, Scale, Series, SeriesStyle};

const MARKER_RADIUS: f32 = 4.0;
const RING_RADIUS: f32 = 8.0;

/// Labels of the x axis fade in between these distances, pixels: a narrow chart keeps its orders.
const X_LABEL_SPACING: Rangef = Rangef { min: 24.0, max: 36.0 };

/// Between the lane of what is exactly zero and the smallest value, in powers of ten.
const LANE_GAP: f64 = 0.7;

const MARKERS: [MarkerShape; 6] = [
    MarkerShape::Circle,
    MarkerShape::Square,
    MarkerShape::Diamond,
    MarkerShape::Up,
    MarkerShape::Down,
    MarkerShape::Cross,
];

/// Steps between the marks of a linear axis, along and up.
const STEPS: [usize; 2] = [5, 4];

/// Draws the chart in the width that there is, its legend below it, where it covers nothing.
pub fn chart_ui(ui: &mut Ui, chart: &Chart, height: f32) {
    plot_ui(ui, chart, height);
    ui.horizontal_wrapped(|ui| {
        let mut number = 0;
        for series in &chart.series {
            let (sign, color) = match series.style {
                SeriesStyle::Front | SeriesStyle::Bound => ("—", palette::TEXT_QUIET.color32()),
                SeriesStyle::Intervals => ("|", palette::TEXT_QUIET.color32()),
                SeriesStyle::Marked => ("○", palette::TEXT_STRONG.color32()),
                SeriesStyle::Line | SeriesStyle::Points => {
                    number += 1;
                    ("—", color(number - 1))
                }
            };
            let name = RichText::new(format!("{sign} {}", printable(&series.name)));
            let name = name.font(theme::label_font()).color(color);
            // A name goes to the next line whole.
            ui.add(Label::new(name).extend());
        }
    });
}

fn plot_ui(ui: &mut Ui, chart: &Chart, height: f32) {
    let x = PlotAxis::new(&chart.x, chart.series.iter().flat_map(|s| &s.points).map(|p| p.0));
    let y = PlotAxis::new(&chart.y, chart.series.iter().flat_map(|s| &s.points).map(|p| p.1));
    let hover = (x, y);
    let names = [chart.x.label.clone(), chart.y.label.clone()];
    let mut plot = Plot::new(&chart.title).height(height);
    if !x.is_logarithmic {
        plot = plot.x_grid_spacer(axis_ticks(STEPS[0]));
    }
    if !y.is_logarithmic {
        plot = plot.y_grid_spacer(axis_ticks(STEPS[1]));
    }
    plot.custom_x_axes(vec![
        AxisHints::new_x()
            .label(&*chart.x.label)
            .formatter(move |mark, _: &RangeInclusive<f64>| x.label(mark))
            .label_spacing(X_LABEL_SPACING),
    ])
    .y_axis_label(&*chart.y.label)
    .y_axis_formatter(move |mark, _: &RangeInclusive<f64>| y.label(mark))
    .label_formatter(move |at| {
        let (series, point) = match at {
            HoverPosition::NearDataPoint { plot_name, position, .. } => {
                (format!("{plot_name}\n"), position)
            }
            HoverPosition::Elsewhere { position } => (String::new(), position),
        };
        let x = with_unit(&names[0], &hover.0.value(point.x));
        let y = with_unit(&names[1], &hover.1.value(point.y));
        Some(format!("{series}{x}\n{y}"))
    })
    .allow_scroll(false)
    .show(ui, |plot| {
        let mut number = 0;
        for series in &chart.series {
            let points = placed(series, x, y);
            match series.style {
                SeriesStyle::Front => {
                    let steps = PlotPoints::from(steps(&points));
                    plot.line(
                        Line::new(&*series.name, steps)
                            .color(palette::TEXT_QUIET.color32())
                            .width(3.0),
                    );
                }
                SeriesStyle::Bound => {
                    if let Some([_, y]) = points.first().copied() {
                        let color = palette::TEXT_QUIET.color32();
                        plot.hline(HLine::new(&*series.name, y).color(color).width(1.2));
                    }
                }
                SeriesStyle::Intervals => {
                    for ends in points.chunks_exact(2) {
                        let bar = PlotPoints::from(ends.to_vec());
                        let color = palette::TEXT_QUIET.color32();
                        plot.line(Line::new(&*series.name, bar).color(color).width(1.2));
                    }
                }
                SeriesStyle::Marked => plot.points(
                    Points::new(&*series.name, PlotPoints::from(points))
                        .shape(MarkerShape::Circle)
                        .filled(false)
                        .radius(RING_RADIUS)
                        .color(palette::TEXT_STRONG.color32()),
                ),
                SeriesStyle::Line | SeriesStyle::Points => {
                    let (color, marker) = (color(number), MARKERS[number % MARKERS.len()]);
                    number += 1;
                    if series.style == SeriesStyle::Line {
                        let line = PlotPoints::from(points.clone());
                        plot.line(Line::new(&*series.name, line).color(color).width(1.2));
                    }
                    plot.points(
                        Points::new(&*series.name, PlotPoints::from(points))
                            .shape(marker)
                            .radius(MARKER_RADIUS)
                            .color(color),
                    );
                }
            }
        }
    });
}

/// A value with the name and the unit of its axis, whose label is `distance, mm`.
fn with_unit(label: &str, value: &str) -> String {
    match label.rsplit_once(", ") {
        Some((name, unit)) => format!("{name}: {value}\u{2009}{unit}"),
        None => format!("{label}: {value}"),
    }
}

fn color(number: usize) -> Color32 {
    palette::SERIES[number % palette::SERIES.len()].color32()
}

/// Where values go along one axis of the plot, which is linear itself.
#[derive(Clone, Copy)]
struct PlotAxis {
    is_logarithmic: bool,
    /// Where exact zeros go.
    lane: Option<f64>,
}

impl PlotAxis {
    fn new(axis: &Axis, values: impl Iterator<Item = f64>) -> Self {
        let is_logarithmic = axis.scale != Scale::Linear;
        let (mut least, mut has_zero) = (f64::INFINITY, false);
        for value in values {
            has_zero |= value == 0.0;
            if value > 0.0 {
                least = least.min(value.log10());
            }
        }
        let has_lane = axis.scale == Scale::LogarithmicAndZero && has_zero && least.is_finite();
        Self { is_logarithmic, lane: has_lane.then(|| least.floor() - LANE_GAP) }
    }

    /// `None` where the axis has no place for the value.
    fn place(self, value: f64) -> Option<f64> {
        match (self.is_logarithmic, self.lane) {
            _ if !value.is_finite() => None,
            (false, _) => Some(value),
            (true, Some(lane)) if value == 0.0 => Some(lane),
            (true, _) => (value > 0.0).then(|| value.log10()),
        }
    }

    /// A value under the pointer, in words.
    fn value(self, at: f64) -> String {
        match self.lane {
            Some(lane) if (at - lane).abs() < LANE_GAP / 2.0 => "0".to_owned(),
            _ if self.is_logarithmic => format!("{:.2e}", 10_f64.powf(at)),
            _ => {
                let decimals = 2.0 - at.abs().max(1e-6).log10().floor();
                decimal(at, decimals.clamp(0.0, 6.0) as usize)
            }
        }
    }

    fn label(self, mark: GridMark) -> String {
        if !self.is_logarithmic {
            return mark_text(mark);
        }
        if self.lane.is_some_and(|lane| mark.value < lane + LANE_GAP) {
            return String::new();
        }
        // Only whole powers of ten are marked.
        let power = mark.value.round();
        if (mark.value - power).abs() > 1e-6 {
            return String::new();
        }
        format!("1e{power:.0}")
    }
}

fn placed(series: &Series, x: PlotAxis, y: PlotAxis) -> Vec<[f64; 2]> {
    let place = |&(at_x, at_y): &(f64, f64)| Some([x.place(at_x)?, y.place(at_y)?]);
    series.points.iter().filter_map(place).collect()
}

/// A front keeps a point's y until the next one's x.
fn steps(points: &[[f64; 2]]) -> Vec<[f64; 2]> {
    let mut steps: Vec<[f64; 2]> = Vec::with_capacity(2 * points.len());
    for point in points {
        if let Some(&[_, last_y]) = steps.last() {
            steps.push([point[0], last_y]);
        }
        steps.push(*point);
    }
    steps
}

#[cfg(test)]
mod tests {
    use super::*;

    fn axis(scale: Scale, values: &[f64]) -> PlotAxis {
        let axis = Axis { label: String::new(), scale };
        PlotAxis::new(&axis, values.iter().copied())
    }

    #[test]
    fn a_logarithmic_axis_places_zero_below_all_powers() {
        let axis = axis(Scale::LogarithmicAndZero, &[0.0, 1e-3, 1.0]);
        assert_eq!(axis.place(1.0), Some(0.0));
        assert!((axis.place(1e-3).unwrap() + 3.0).abs() < 1e-12);
        assert!(axis.place(0.0).unwrap() < -3.0);
        assert_eq!(axis.value(axis.place(0.0).unwrap()), "0");
        assert_eq!(axis.place(-1.0), None);
    }

    #[test]
    fn without_zeros_there_is_no_lane() {
        let axis = axis(Scale::LogarithmicAndZero, &[1e-3, 1.0]);
        assert_eq!(axis.place(0.0), None);
    }

    #[test]
    fn a_value_under_the_pointer_has_name_and_unit() {
        let axis = axis(Scale::Linear, &[1.0, 400.0]);
        assert_eq!(
            with_unit("distance to the tip, mm", &axis.value(225.34)),
            "distance to the tip: 225\u{2009}mm"
        );
        assert_eq!([axis.value(0.001_234), axis.value(-3.5)], ["0.00123", "\u{2212}3.50"]);
        assert_eq!(with_unit("poses", "12"), "poses: 12");
    }

    #[test]
    fn a_front_goes_in_steps() {
        assert_eq!(steps(&[[0.0, 2.0], [1.0, 1.0]]), [[0.0, 2.0], [1.0, 2.0], [1.0, 1.0]]);
    }
}
