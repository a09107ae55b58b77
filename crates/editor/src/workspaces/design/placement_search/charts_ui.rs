//! The charts of a search: the best value over time, and the best of each number of sensors or cost.

use crate::palette::{self, ThemedColor};
use crate::widgets::axis_ticks::{mark_text, small_marks, small_plot};
use crate::widgets::basic::{counted, decimal, quiet_ui, section_ui, with_unit};
use crate::workspaces::design::placement_search::state::{
    AnswerId, PlacementSearchRequest, SearchResult,
};
use bevy_egui::egui::{Button, Ui};
use egui_plot::{GridMark, HLine, HoverPosition, Line, LineStyle, MarkerShape, PlotPoints, Points};
use std::ops::RangeInclusive;
use trackwright_optimization::{Goal, Layout};
use trackwright_simulation::Sensor;

const HEIGHT: f32 = 92.0;

/// What is left free above and below the values, as a part of their range, and at least of them.
const HEADROOM: f64 = 0.12;
const LEAST_HEADROOM: f64 = 0.01;

/// Of a layout in all.
pub fn sensor_count(layout: &Layout) -> usize {
    layout.tool.sensors.len() + layout.crf.as_ref().map_or(0, |crf| crf.sensors.len())
}

/// What a search makes least, with its unit: `0.49 mm`, `0.83 of the requirement`.
pub fn objective_text(goal: Goal, value: f64) -> String {
    match goal {
        Goal::Requirement(_) => format!("{} of the requirement", decimal(value, 2)),
        Goal::Figure(metric) => with_unit(&decimal(value, 3), metric.unit()),
    }
}

/// What stands along y.
fn goal_words(goal: Goal) -> String {
    match goal {
        Goal::Requirement(_) => "largest ratio to the requirement".to_owned(),
        Goal::Figure(metric) => format!("{} in {}", metric.label(), metric.unit()),
    }
}

/// The ends of an axis around values.
fn around(values: impl Iterator<Item = f64>) -> RangeInclusive<f64> {
    let (low, high) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| {
        (low.min(value), high.max(value))
    });
    let room = (HEADROOM * (high - low)).max(LEAST_HEADROOM * high.abs()).max(1e-9);
    low - room..=high + room
}

/// The best value so far over the time of the search, in steps up to its end; `start` is the design's
/// own, once it is known.
pub fn curve_ui(
    ui: &mut Ui,
    goal: Goal,
    curve: &[[f64; 2]],
    start: Option<f64>,
    end_secs: Option<f64>,
) {
    let Some(&[last_secs, last_value]) = curve.last() else {
        return;
    };
    let end_secs = end_secs.unwrap_or(last_secs).max(last_secs).max(1e-3);
    let mut steps: Vec<[f64; 2]> = Vec::with_capacity(2 * curve.len() + 1);
    for point in curve {
        if let Some(&[_, before]) = steps.last() {
            steps.push([point[0], before]);
        }
        steps.push(*point);
    }
    steps.push([end_secs, last_value]);
    let values = around(curve.iter().map(|point| point[1]).chain(start));
    small_marks(ui, |ui| {
        small_plot("best over time", HEIGHT)
            .label_formatter(|at| {
                let (HoverPosition::NearDataPoint { position, .. }
                | HoverPosition::Elsewhere { position }) = at;
                let so_far = curve.iter().rev().find(|point| point[0] <= position.x)?;
                let seconds = with_unit(&decimal(position.x, 1), "s");
                Some(format!("{seconds}\n{}", objective_text(goal, so_far[1])))
            })
            .show(ui, |plot| {
                plot.set_plot_bounds_x(0.0..=end_secs);
                plot.set_plot_bounds_y(values);
                let color = palette::SERIES[0].color32();
                let line = Line::new("best so far", PlotPoints::from(steps));
                plot.line(line.color(color).width(1.6));
                if let Some(start) = start {
                    let line = HLine::new("start", start).color(palette::TEXT_QUIET.color32());
                    plot.hline(line.style(LineStyle::dashed_dense()).width(1.0));
                }
            });
    });
    let dashes = if start.is_some() { "; dashes: the start" } else { "" };
    quiet_ui(ui, format!("{} over seconds{dashes}", goal_words(goal)));
}

/// What a front is drawn over.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum FrontAxis {
    Sensors,
    Cost,
}

impl FrontAxis {
    fn of(front: &[Layout]) -> Self {
        match front.iter().all(|layout| layout.cost.is_some()) {
            true => Self::Cost,
            false => Self::Sensors,
        }
    }

    fn value(self, layout: &Layout) -> f64 {
        match self {
            Self::Sensors => sensor_count(layout) as f64,
            Self::Cost => layout.cost.unwrap_or(0.0),
        }
    }

    fn title(self) -> &'static str {
        match self {
            Self::Sensors => "By number of sensors",
            Self::Cost => "By cost",
        }
    }

    /// What stands along x.
    fn words(self) -> &'static str {
        match self {
            Self::Sensors => "sensors in all",
            Self::Cost => "cost of the sensors that move, in your unit; each point is a design",
        }
    }
}

/// The best designs by their number of sensors, or by their cost; a click selects one.
pub fn pareto_ui(
    ui: &mut Ui,
    (goal, result): (Goal, &SearchResult),
    selected: AnswerId,
    requests: &mut Vec<PlacementSearchRequest>,
) {
    let front = &result.optimized.pareto;
    if front.len() < 2 {
        return;
    }
    let axis = FrontAxis::of(front);
    section_ui(ui, axis.title());
    let points: Vec<[f64; 2]> =
        front.iter().map(|layout| [axis.value(layout), layout.objective]).collect();
    let ends = [0, 1].map(|k| around(points.iter().map(|point| point[k])));
    let ends = match axis {
        FrontAxis::Sensors => {
            let [counts, values] = ends;
            [(counts.start() - 0.3)..=(counts.end() + 0.3), values]
        }
        FrontAxis::Cost => ends,
    };
    let span = ends.each_ref().map(|ends| ends.end() - ends.start());
    let nearest = |at: [f64; 2]| {
        let off = |k: &usize| {
            let [along, up] = [0, 1].map(|side| (points[*k][side] - at[side]) / span[side]);
            along.hypot(up)
        };
        (0..points.len()).min_by(|a, b| off(a).total_cmp(&off(b)))
    };
    let chosen = match selected {
        AnswerId::Pareto(index) => points.get(index).copied(),
        AnswerId::Candidate(_) => None,
    };
    let plot = small_marks(ui, |ui| {
        small_plot(axis.title(), HEIGHT)
            .x_axis_formatter(move |mark: GridMark, _: &RangeInclusive<f64>| {
                let is_whole = (mark.value - mark.value.round()).abs() < 1e-6;
                match is_whole || axis == FrontAxis::Cost {
                    true => mark_text(mark),
                    false => String::new(),
                }
            })
            .label_formatter(|at| {
                let (HoverPosition::NearDataPoint { position, .. }
                | HoverPosition::Elsewhere { position }) = at;
                Some(front_words(goal, &front[nearest([position.x, position.y])?]))
            })
            .show(ui, |plot| {
                let [along, up] = ends;
                plot.set_plot_bounds_x(along);
                plot.set_plot_bounds_y(up);
                let color = palette::SERIES[0].color32();
                let own = Points::new("best designs", PlotPoints::from(points.clone()));
                plot.points(own.shape(MarkerShape::Circle).radius(4.0).color(color));
                if let Some(chosen) = chosen {
                    let ring = Points::new("chosen", PlotPoints::from(vec![chosen]));
                    let ring = ring.shape(MarkerShape::Circle).filled(false).radius(7.0);
                    plot.points(ring.color(palette::TEXT_STRONG.color32()));
                }
            })
    });
    let under_pointer = plot.response.hover_pos().map(|at| plot.transform.value_from_position(at));
    if let Some(index) = under_pointer.and_then(|at| nearest([at.x, at.y])) {
        let answer = AnswerId::Pareto(index);
        requests.push(PlacementSearchRequest::Hover(Some(answer)));
        if plot.response.clicked() {
            requests.push(PlacementSearchRequest::Show(answer));
        }
    }
    quiet_ui(ui, format!("{} over {}", goal_words(goal), axis.words()));
    ui.horizontal_wrapped(|ui| {
        for (index, layout) in front.iter().enumerate() {
            let answer = AnswerId::Pareto(index);
            let response = ui.add(Button::selectable(selected == answer, front_name(layout)));
            let response = response.on_hover_text(front_words(goal, layout));
            if response.clicked() {
                requests.push(PlacementSearchRequest::Show(answer));
            }
            if response.hovered() {
                requests.push(PlacementSearchRequest::Hover(Some(answer)));
            }
        }
    });
}

/// `3 sensors, cost 420`.
fn front_name(layout: &Layout) -> String {
    let cost = layout.cost.map(|cost| {
        let decimals = if cost.fract() == 0.0 { 0 } else { 2 };
        format!(", cost {}", decimal(cost, decimals))
    });
    let sensors = counted(sensor_count(layout), "sensor", "sensors");
    format!("{sensors}{}", cost.unwrap_or_default())
}

/// With its value, and which sensors it has where they differ in cost.
fn front_words(goal: Goal, layout: &Layout) -> String {
    let value = objective_text(goal, layout.objective);
    let kinds = layout.cost.map(|_| format!("{}\n", kinds_words(layout))).unwrap_or_default();
    format!("{}\n{kinds}{value}", front_name(layout))
}

/// `2 of 5-DOF, 1 of 6-DOF`.
fn kinds_words(layout: &Layout) -> String {
    let sensors =
        || layout.tool.sensors.iter().chain(layout.crf.iter().flat_map(|crf| &crf.sensors));
    let of = |degrees: u8| {
        let own = |sensor: &&Sensor| sensor.orientation.degrees_of_freedom() == degrees;
        let number = sensors().filter(own).count();
        (number > 0).then(|| format!("{number} of {degrees}-DOF"))
    };
    [3, 5, 6].into_iter().filter_map(of).collect::<Vec<_>>().join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;
    use trackwright_simulation::{Metric, Requirement};

    #[test]
    fn values_state_what_they_are_of() {
        let figure = Goal::Figure(Metric::TIP_RMS);
        assert_eq!(objective_text(figure, 0.4913), "0.491\u{2009}mm");
        let bounds = Requirement::at_most([(Metric::TIP_RMS, 1.0)]);
        assert_eq!(objective_text(Goal::Requirement(bounds), 0.834), "0.83 of the requirement");
        assert_eq!(goal_words(figure), "tip error RMS in mm");
    }

    #[test]
    fn an_axis_has_room_around_equal_values() {
        let ends = around([2.0, 2.0].into_iter());
        assert!(*ends.start() < 2.0 && *ends.end() > 2.0);
    }
}
