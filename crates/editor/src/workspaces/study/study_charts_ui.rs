//! Charts of a study: how many trials have which tip error, and how that goes with the motion.

use crate::palette;
use crate::palette::ThemedColor;
use crate::widgets::axis_ticks::{mark_text, small_marks, small_plot};
use crate::widgets::basic::{count, counted, decimal, length, quiet_ui, section_ui, with_unit};
use crate::widgets::theme;
use crate::widgets::tooltip::Explain;
use crate::workspaces::study::state::StudyRequest;
use bevy_egui::egui::{self, Response, RichText, Ui};
use egui_plot::{
    Bar, BarChart, GridMark, HLine, HoverPosition, Line, LineStyle, MarkerShape, PlotPoints,
    Points, VLine,
};
use std::ops::RangeInclusive;
use trackwright_simulation::profile::{AxisProfile, ORIENTATION, POSITION};
use trackwright_simulation::{AlongShaft, ChartedProfile, Metric};

const HEIGHT: f32 = 92.0;

/// How far above the largest value a chart goes.
const HEADROOM: f64 = 1.1;

/// How opaque bars are: the curve over them has to be seen.
const BAR_ALPHA: u8 = 150;

/// Values up to so many are drawn as points too.
const POINTS_UP_TO: usize = 40;

/// What the panel shows.
pub struct StudyChartsView<'a> {
    pub charted: &'a ChartedProfile,
    /// Along which axis the error is drawn, where the motion has it.
    pub axis: &'static str,
    /// The trial in the scene, from 0.
    pub shown: Option<usize>,
}

/// Draws the charts.
pub fn study_charts_ui(ui: &mut Ui, view: &StudyChartsView) -> Vec<StudyRequest> {
    let mut actions = Vec::new();
    section_ui(ui, "Tip error of all trials, room's model alone");
    small_marks(ui, |ui| histogram_ui(ui, view, &mut actions));
    if !view.charted.profile.axes.is_empty() {
        axes_ui(ui, view, &mut actions);
    }
    if let Some(along) = &view.charted.profile.along_shaft {
        let limit = view.charted.within.filter(|within| within.metric == Metric::TIP_RMS);
        section_ui(ui, "RMS error along the shaft, room's model alone");
        small_marks(ui, |ui| shaft_ui(ui, along, limit.map(|within| within.limit_mm)));
    }
    actions
}

fn histogram_ui(ui: &mut Ui, view: &StudyChartsView, actions: &mut Vec<StudyRequest>) {
    let charted = view.charted;
    let (width, counts) = (charted.histogram.width, &charted.histogram.counts);
    let most = counts.iter().copied().max().unwrap_or(0).max(1) as f64;
    let limit_mm = charted.within.map(|within| within.limit_mm);
    let right = (counts.len() as f64 * width).max(limit_mm.unwrap_or(0.0) * 1.03);
    let bars = counts.iter().enumerate().map(|(k, &trials)| {
        let middle = (k as f64 + 0.5) * width;
        Bar::new(middle, trials as f64).width(0.9 * width)
    });
    let bars: Vec<Bar> = bars.collect();
    let bar_at = move |x: f64| (x / width).floor().max(0.0) as usize;
    let plot = small_plot("histogram", HEIGHT)
        .y_axis_formatter(|mark: GridMark, _: &RangeInclusive<f64>| whole(mark.value))
        .label_formatter(|at| {
            let (HoverPosition::NearDataPoint { position, .. }
            | HoverPosition::Elsewhere { position }) = at;
            let bar = bar_at(position.x);
            let within = 100.0 * charted.profile.part_within(position.x);
            let trials = counts.get(bar).copied().unwrap_or(0);
            Some(format!(
                "{} to {}: {}\n{} within {}",
                decimal(bar as f64 * width, 3),
                with_unit(&decimal((bar + 1) as f64 * width, 3), "mm"),
                counted(trials, "trial", "trials"),
                with_unit(&decimal(within, 1), "%"),
                length(position.x),
            ))
        })
        .show(ui, |plot| {
            plot.set_plot_bounds_x(0.0..=right);
            plot.set_plot_bounds_y(0.0..=most * HEADROOM);
            plot.bar_chart(
                BarChart::new("trials", bars)
                    .color(palette::SERIES[0].color32_alpha(BAR_ALPHA))
                    .allow_hover(false),
            );
            // All trials are as high as the highest bar.
            let curve = charted.cumulative.iter().map(|&(e, part)| [e, part * most]);
            let curve = PlotPoints::from(curve.collect::<Vec<[f64; 2]>>());
            plot.line(Line::new("cumulative", curve).color(palette::TEXT.color32()).width(1.2));
            if let Some(limit_mm) = limit_mm {
                let line = VLine::new("requirement", limit_mm).color(palette::MET.color32());
                plot.vline(line.style(LineStyle::dashed_dense()).width(1.0));
            }
            let shown = view.shown.and_then(|t| charted.profile.tip_error_mm.get(t));
            if let Some(error_mm) = shown {
                let line = VLine::new("shown", *error_mm).color(palette::TEXT_STRONG.color32());
                plot.vline(line.width(1.0));
            }
        });
    let hint = "Bars: trials by tip error. Curve: the part of the trials with at most so much. A \
                click shows the worst trial of a bar";
    quiet_ui(ui, "mm; curve: part of the trials with at most so much").explained(hint);
    let clicked = clicked_at(&plot.response, |at| plot.transform.value_from_position(at).x);
    if let Some(trial) = clicked.and_then(|x| charted.worst_of_bar(bar_at(x))) {
        actions.push(StudyRequest::Show(Some(trial)));
    }
}

/// Where a chart was clicked, along x.
fn clicked_at(response: &Response, x: impl Fn(egui::Pos2) -> f64) -> Option<f64> {
    response.clicked().then(|| response.interact_pointer_pos().map(x)).flatten()
}

fn axes_ui(ui: &mut Ui, view: &StudyChartsView, actions: &mut Vec<StudyRequest>) {
    let axes = &view.charted.profile.axes;
    let chosen = axes.iter().find(|a| a.axis == view.axis).unwrap_or(&axes[0]);
    section_ui(ui, "Tip error along the motion, room's model alone");
    ui.horizontal_wrapped(|ui| {
        ui.spacing_mut().item_spacing.x = 2.0;
        for axis in axes {
            let label = egui::Button::selectable(axis.axis == chosen.axis, axis.axis);
            let response = ui.add(label).explained(match axis.axis {
                POSITION => "Each position with all its orientations",
                ORIENTATION => "Each orientation at all positions",
                _ => "Each value of this axis with all values of the others",
            });
            if response.clicked() && axis.axis != chosen.axis {
                actions.push(StudyRequest::ShowAxis(axis.axis));
            }
        }
    });
    let limit_mm = view.charted.within.map(|within| within.limit_mm);
    small_marks(ui, |ui| axis_ui(ui, chosen, limit_mm, actions));
}

fn axis_ui(
    ui: &mut Ui,
    axis: &AxisProfile,
    limit_mm: Option<f64>,
    actions: &mut Vec<StudyRequest>,
) {
    let largest = axis.max_mm.iter().copied().fold(0.0, f64::max);
    let top = largest.max(limit_mm.unwrap_or(0.0)).max(1e-6) * HEADROOM;
    let (first, last) = match axis.values.as_slice() {
        [first, .., last] => (*first, *last),
        _ => return,
    };
    let margin = 0.02 * (last - first);
    let nearest = |x: f64| {
        let distance = |k: &usize| (axis.values[*k] - x).abs();
        (0..axis.values.len()).min_by(|a, b| distance(a).total_cmp(&distance(b)))
    };
    let is_number = matches!(axis.axis, POSITION | ORIENTATION);
    let value = |k: usize| match is_number {
        true => format!("{} {}", axis.axis, count(axis.values[k] as usize)),
        false => format!("{} {}", axis.axis, with_unit(&decimal(axis.values[k], 2), unit(axis))),
    };
    let plot = small_plot("along the motion", HEIGHT)
        .x_axis_formatter(move |mark: GridMark, _: &RangeInclusive<f64>| {
            let is_whole = (mark.value - mark.value.round()).abs() < 1e-6;
            match is_number {
                true if !is_whole => String::new(),
                _ => mark_text(mark),
            }
        })
        .label_formatter(|at| {
            let (HoverPosition::NearDataPoint { position, .. }
            | HoverPosition::Elsewhere { position }) = at;
            let k = nearest(position.x)?;
            let (rms, max) = (length(axis.rms_mm[k]), length(axis.max_mm[k]));
            Some(format!("{}\nRMS {rms}, max {max}", value(k)))
        })
        .show(ui, |plot| {
            plot.set_plot_bounds_x(first - margin..=last + margin);
            plot.set_plot_bounds_y(0.0..=top);
            for (name, errors, color) in [
                ("max", &axis.max_mm, palette::SERIES[1]),
                ("RMS", &axis.rms_mm, palette::SERIES[0]),
            ] {
                let points = axis.values.iter().zip(errors).map(|(v, e)| [*v, *e]);
                let points: Vec<[f64; 2]> = points.collect();
                if points.len() <= POINTS_UP_TO {
                    plot.points(
                        Points::new(name, PlotPoints::from(points.clone()))
                            .shape(MarkerShape::Circle)
                            .radius(2.5)
                            .color(color.color32()),
                    );
                }
                plot.line(
                    Line::new(name, PlotPoints::from(points)).color(color.color32()).width(1.2),
                );
            }
            if let Some(limit_mm) = limit_mm {
                let line = HLine::new("requirement", limit_mm).color(palette::MET.color32());
                plot.hline(line.style(LineStyle::dashed_dense()).width(1.0));
            }
        });
    ui.horizontal(|ui| {
        let legend = |ui: &mut Ui, text: &str, color: palette::Rgb| {
            let text = RichText::new(text).font(theme::label_font());
            ui.label(text.color(color.color32()));
        };
        legend(ui, "max", palette::SERIES[1]);
        legend(ui, "RMS", palette::SERIES[0]);
        quiet_ui(ui, along(axis)).explained("A click shows the worst trial of a value");
    });
    let clicked = clicked_at(&plot.response, |at| plot.transform.value_from_position(at).x);
    if let Some(k) = clicked.and_then(nearest) {
        let trial = axis.worst_trial[k];
        actions.push(StudyRequest::Show(Some(trial)));
    }
}

/// Points of the curve along the shaft: more than it has bends.
const SHAFT_POINTS: usize = 60;

/// How far off each point of the tool's long axis is, from the tip to the rearmost sensor.
fn shaft_ui(ui: &mut Ui, along: &AlongShaft, limit_mm: Option<f64>) {
    let curve: Vec<[f64; 2]> =
        along.curve(SHAFT_POINTS).into_iter().map(|(at_mm, rms_mm)| [at_mm, rms_mm]).collect();
    let sensors = along.sensors_mm.iter().map(|&at_mm| [at_mm, along.rms_mm(at_mm)]);
    let sensors: Vec<[f64; 2]> = sensors.collect();
    let largest = curve.iter().map(|[_, rms_mm]| *rms_mm).fold(0.0, f64::max);
    let top = largest.max(limit_mm.unwrap_or(0.0)).max(1e-6) * HEADROOM;
    let margin = 0.02 * along.length_mm;
    small_plot("along the shaft", HEIGHT)
        .label_formatter(|at| {
            let (HoverPosition::NearDataPoint { position, .. }
            | HoverPosition::Elsewhere { position }) = at;
            let at_mm = position.x.clamp(0.0, along.length_mm);
            Some(format!("{} from the tip\nRMS {}", length(at_mm), length(along.rms_mm(at_mm))))
        })
        .show(ui, |plot| {
            plot.set_plot_bounds_x(-margin..=along.length_mm + margin);
            plot.set_plot_bounds_y(0.0..=top);
            let line = Line::new("RMS", PlotPoints::from(curve));
            plot.line(line.color(palette::SERIES[0].color32()).width(1.2));
            plot.points(
                Points::new("sensors", PlotPoints::from(sensors))
                    .shape(MarkerShape::Circle)
                    .radius(3.0)
                    .color(palette::SENSOR.color32()),
            );
            if let Some(limit_mm) = limit_mm {
                let line = HLine::new("requirement", limit_mm).color(palette::MET.color32());
                plot.hline(line.style(LineStyle::dashed_dense()).width(1.0));
            }
        });
    quiet_ui(ui, "mm, over mm from the tip; points: sensors").on_hover_text(
        "The error at each point of the tool's long axis, from the tip to the rearmost sensor",
    );
}

/// What stands along x.
fn along(axis: &AxisProfile) -> String {
    match axis.axis {
        POSITION => "by number of the position".to_owned(),
        ORIENTATION => "by number of the orientation".to_owned(),
        name => format!("over {name} in {}", unit(axis)),
    }
}

fn unit(axis: &AxisProfile) -> &'static str {
    match axis.axis.starts_with('r') {
        true => "°",
        false => "mm",
    }
}

fn whole(value: f64) -> String {
    let nearest = value.round();
    match (value - nearest).abs() < 1e-6 && nearest >= 0.0 {
        true => count(nearest as usize),
        false => String::new(),
    }
}
