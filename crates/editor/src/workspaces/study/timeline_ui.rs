//! The timeline of the Study workspace: the mode, the error over the trials, and playing them.

use crate::document::shown::ShownTrial;
use crate::document::trials::ModeKind;
use crate::palette;
use crate::palette::ThemedColor;
use crate::shell::commands::Command;
use crate::widgets::axis_ticks::{axis_ticks, mark_text, small_marks};
use crate::widgets::basic::{count, decimal, length, quiet_ui, with_unit};
use crate::widgets::theme;
use crate::widgets::tooltip::{Explain, button_ui};
use crate::workspaces::study::commands::{
    NEXT, OWN_POSE, PLAY, PREVIOUS, READ_INPUT, WORST, WRITE_LOG, choose,
};
use crate::workspaces::study::state::{PLAY_RATES, StudyRequest};
use bevy_egui::egui::{
    self, Align, Button, ComboBox, Layout, Pos2, ProgressBar, Rect, Response, RichText, Sense,
    Shape, Stroke, StrokeKind, Ui, pos2, vec2,
};
use egui_plot::{
    GridMark, HLine, HoverPosition, Line, LineStyle, MarkerShape, Plot, PlotPoint, PlotPoints,
    Points, VLine,
};
use std::ops::RangeInclusive;
use trackwright_project::MeasuredError;
use trackwright_simulation::figures::trial_number;
use trackwright_simulation::profile::{Column, MAX_PROFILED};
use trackwright_simulation::{ChartedProfile, InputTrial};

/// Trials up to so many are drawn as points too: each can be seen and hit.
const POINTS_UP_TO: usize = 60;

/// How far above the largest error the chart goes: the caption stands there.
const HEADROOM: f64 = 1.3;

/// What the panel shows.
pub struct TimelineView<'a> {
    pub kind: ModeKind,
    pub has_motion: bool,
    /// The name of the input data that was read.
    pub input: Option<&'a str>,
    /// Trials of the study that is shown.
    pub trials: usize,
    pub shown: Option<&'a ShownTrial>,
    pub profile: Option<&'a ChartedProfile>,
    /// What was measured at each trial, where they are a recording of the built tool.
    pub measured: Option<&'a [MeasuredError]>,
    /// The design changed, and its profile is on its way.
    pub is_computing: bool,
    pub is_playing: bool,
    pub rate_per_s: f64,
    /// How far the log is that is being written.
    pub log_part: Option<f64>,
}

/// What a person requested there.
#[derive(Clone, Debug, PartialEq)]
pub enum TimelineAction {
    Study(StudyRequest),
    /// A command, by its name.
    Run(&'static str),
}

/// Draws the panel.
pub fn timeline_ui(ui: &mut Ui, view: &TimelineView) -> Vec<TimelineAction> {
    let mut actions = Vec::new();
    ui.add_space(4.0);
    ui.horizontal(|ui| {
        modes_ui(ui, view, &mut actions);
        ui.add_space(10.0);
        buttons_ui(ui, view, &mut actions);
        ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
            log_ui(ui, view, &mut actions);
            ui.with_layout(Layout::left_to_right(Align::Center), |ui| {
                ui.add_space(6.0);
                words_ui(ui, view);
            });
        });
    });
    ui.add_space(2.0);
    match view.profile {
        Some(profile) => small_marks(ui, |ui| chart_ui(ui, profile, view, &mut actions)),
        None => {
            ui.centered_and_justified(|ui| quiet_ui(ui, why_empty(view)));
        }
    }
    actions
}

fn why_empty(view: &TimelineView) -> String {
    if view.is_computing {
        "computing…".to_owned()
    } else if view.trials > MAX_PROFILED {
        format!(
            "{} trials: more than the {} that are kept one by one; the figures and the log are of \
             all of them",
            count(view.trials),
            count(MAX_PROFILED)
        )
    } else {
        "no trials".to_owned()
    }
}

/// `trial 1,203 of 3,375: x −20 mm, rz 45°`.
pub fn trial_words(trial: &ShownTrial) -> String {
    let number = format!("trial {} of {}", trial_number(trial.number), count(trial.of));
    let place: Vec<String> = match trial.kind {
        ModeKind::Motion => trial
            .offsets
            .iter()
            .map(|(axis, value)| {
                let unit = if axis.starts_with('r') { "°" } else { "mm" };
                format!("{axis} {}", with_unit(&short(*value), unit))
            })
            .collect(),
        ModeKind::Single | ModeKind::Input => position(&trial.pose),
    };
    match place.is_empty() {
        true => number,
        false => format!("{number}: {}", place.join(", ")),
    }
}

fn position(pose: &InputTrial) -> Vec<String> {
    let at = pose.crf_from_tool.translation.vector;
    let axes = ["x", "y", "z"].into_iter().zip([at.x, at.y, at.z]);
    axes.map(|(axis, value)| format!("{axis} {}", length(value))).collect()
}

/// Up to two decimals, without zeros at the end.
fn short(value: f64) -> String {
    let text = decimal(value, 2);
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}

fn modes_ui(ui: &mut Ui, view: &TimelineView, actions: &mut Vec<TimelineAction>) {
    ui.spacing_mut().item_spacing.x = 4.0;
    for kind in ModeKind::ALL {
        let (text, command) = match (kind, view.input) {
            (ModeKind::Input, None) => ("Input data…".to_owned(), &READ_INPUT),
            (ModeKind::Input, Some(file)) => {
                let name = format!("Input data: {}", shortened(file));
                (name, choose(kind))
            }
            _ => {
                let command = choose(kind);
                (command.name.to_owned(), command)
            }
        };
        let is_possible = kind != ModeKind::Motion || view.has_motion;
        let button = Button::selectable(kind == view.kind, text);
        let response = ui
            .add_enabled(is_possible, button)
            .explained(command.about)
            .on_disabled_hover_text("The design has no range of motion");
        if response.clicked() && (kind != view.kind || command.name == READ_INPUT.name) {
            actions.push(TimelineAction::Run(command.name));
        }
    }
    if view.input.is_some() {
        let open = ui.button("…").explained(READ_INPUT.about);
        if open.clicked() {
            actions.push(TimelineAction::Run(READ_INPUT.name));
        }
    }
}

/// A file's name that does not push everything else aside.
fn shortened(name: &str) -> String {
    const MOST: usize = 22;
    if name.chars().count() <= MOST {
        return name.to_owned();
    }
    let kept: String = name.chars().take(MOST - 1).collect();
    format!("{kept}…")
}

/// What a button shows; drawn, since fonts differ in what they have.
#[derive(Clone, Copy)]
enum Icon {
    Previous,
    Play,
    Pause,
    Next,
}

fn buttons_ui(ui: &mut Ui, view: &TimelineView, actions: &mut Vec<TimelineAction>) {
    let play = match view.is_playing {
        true => Icon::Pause,
        false => Icon::Play,
    };
    ui.add_enabled_ui(view.kind != ModeKind::Single && view.trials > 1, |ui| {
        for (icon, command) in [(Icon::Previous, &PREVIOUS), (play, &PLAY), (Icon::Next, &NEXT)] {
            if icon_ui(ui, icon, command).clicked() {
                actions.push(TimelineAction::Run(command.name));
            }
        }
        ComboBox::from_id_salt("play rate")
            .width(96.0)
            .selected_text(rate(view.rate_per_s))
            .show_ui(ui, |ui| {
                for each in PLAY_RATES {
                    let is_chosen = each == view.rate_per_s;
                    if ui.selectable_label(is_chosen, rate(each)).clicked() {
                        actions.push(TimelineAction::Study(StudyRequest::SetRate(each)));
                    }
                }
            })
            .response
            .explained("How fast trials play");
        text_button(ui, "Worst", &WORST, true, actions);
    });
    text_button(ui, "Own pose", &OWN_POSE, view.shown.is_some(), actions);
}

fn rate(per_s: f64) -> String {
    format!("{per_s} trials/s")
}

fn text_button(
    ui: &mut Ui,
    text: &str,
    command: &Command,
    is_enabled: bool,
    actions: &mut Vec<TimelineAction>,
) {
    let response = ui.add_enabled(is_enabled, Button::new(text)).explained(about(command));
    if response.clicked() {
        actions.push(TimelineAction::Run(command.name));
    }
}

/// What a command does, with its key.
fn about(command: &Command) -> String {
    match command.keys.first() {
        Some(keys) => format!("{} ({keys})", command.about),
        None => command.about.to_owned(),
    }
}

fn icon_ui(ui: &mut Ui, icon: Icon, command: &Command) -> Response {
    let (rect, response) = ui.allocate_exact_size(vec2(26.0, 20.0), Sense::click());
    let name = command.name;
    response
        .widget_info(|| egui::WidgetInfo::labeled(egui::WidgetType::Button, ui.is_enabled(), name));
    if ui.is_rect_visible(rect) {
        let visuals = ui.style().interact(&response);
        ui.painter().rect(
            rect,
            visuals.corner_radius,
            visuals.weak_bg_fill,
            visuals.bg_stroke,
            StrokeKind::Inside,
        );
        let color = match ui.is_enabled() {
            true => visuals.fg_stroke.color,
            false => palette::TEXT_QUIET.color32_alpha(120),
        };
        paint_icon(ui.painter(), icon, rect.center(), color);
    }
    response.explained(about(command))
}

fn paint_icon(painter: &egui::Painter, icon: Icon, at: Pos2, color: egui::Color32) {
    let triangle = |points| Shape::convex_polygon(points, color, Stroke::NONE);
    let bar = |x: f32| {
        let rect = Rect::from_center_size(pos2(at.x + x, at.y), vec2(2.0, 10.0));
        Shape::rect_filled(rect, 0.0, color)
    };
    let pointing = |to: f32| {
        triangle(vec![
            at + vec2(-4.0 * to, -5.0),
            at + vec2(4.0 * to, 0.0),
            at + vec2(-4.0 * to, 5.0),
        ])
    };
    match icon {
        Icon::Play => {
            painter.add(pointing(1.0));
        }
        Icon::Pause => {
            painter.extend([bar(-3.0), bar(3.0)]);
        }
        Icon::Previous => {
            painter.extend([pointing(-1.0), bar(-6.0)]);
        }
        Icon::Next => {
            painter.extend([pointing(1.0), bar(6.0)]);
        }
    }
}

/// Room that the log's button takes with its whole name, points.
const LOG_WIDTH: f32 = 110.0;

fn log_ui(ui: &mut Ui, view: &TimelineView, actions: &mut Vec<TimelineAction>) {
    match view.log_part {
        Some(part) => {
            if button_ui(ui, "Cancel", "Stops writing the log").clicked() {
                actions.push(TimelineAction::Study(StudyRequest::CancelLog));
            }
            ui.add(ProgressBar::new(part as f32).desired_width(90.0));
            quiet_ui(ui, "writing the log");
        }
        None => {
            let is_narrow = ui.available_width() < LOG_WIDTH;
            let name = if is_narrow { "Log…" } else { WRITE_LOG.name };
            text_button(ui, name, &WRITE_LOG, true, actions);
        }
    }
}

/// Which trial the scene shows.
fn words_ui(ui: &mut Ui, view: &TimelineView) {
    let (text, color) = match view.shown {
        Some(trial) => (trial_words(trial), palette::TEXT_STRONG),
        None => ("the design's own pose".to_owned(), palette::TEXT_QUIET),
    };
    ui.add(egui::Label::new(RichText::new(text).color(color.color32())).truncate());
}

fn chart_ui(
    ui: &mut Ui,
    charted: &ChartedProfile,
    view: &TimelineView,
    actions: &mut Vec<TimelineAction>,
) {
    let profile = &charted.profile;
    let columns = profile.columns(ui.available_width().max(1.0) as usize);
    let limit_mm = charted.within.map(|within| within.limit_mm);
    let measured: Vec<[f64; 2]> = (view.measured.into_iter().flatten().enumerate())
        .map(|(k, measured)| [k as f64 + 1.0, measured.tip_error_in_crf_mm.norm()])
        .collect();
    let largest = columns.iter().map(|c| c.max_mm).fold(0.0, f64::max);
    let largest = measured.iter().map(|[_, error_mm]| *error_mm).fold(largest, f64::max);
    let top = largest.max(limit_mm.unwrap_or(0.0)).max(1e-6) * HEADROOM;
    let trials = profile.len();
    let error_mm = |trial: usize| profile.tip_error_mm.get(trial).copied();
    let chosen = |x: f64| trial_at(&columns, trials, x);
    let plot = Plot::new("timeline")
        .height(ui.available_height())
        .show_grid([false, true])
        .y_grid_spacer(axis_ticks(4))
        .allow_drag(false)
        .allow_zoom(false)
        .allow_scroll(false)
        .allow_boxed_zoom(false)
        .allow_double_click_reset(false)
        .sense(Sense::click_and_drag())
        .y_axis_min_width(48.0)
        .x_axis_formatter(|mark: GridMark, _: &RangeInclusive<f64>| whole(mark.value))
        .y_axis_formatter(|mark: GridMark, _: &RangeInclusive<f64>| {
            with_unit(&mark_text(mark), "mm")
        })
        .label_formatter(|at| {
            let (HoverPosition::NearDataPoint { position, .. }
            | HoverPosition::Elsewhere { position }) = at;
            let trial = chosen(position.x)?;
            let number = trial_number(trial);
            Some(format!("trial {number}\ntip error {}", length(error_mm(trial)?)))
        })
        .show(ui, |plot| {
            plot.set_plot_bounds_x(0.5..=trials as f64 + 0.5);
            plot.set_plot_bounds_y(0.0..=top);
            let color = match view.is_computing {
                true => palette::TEXT_QUIET,
                false => palette::SERIES[0],
            };
            let line = PlotPoints::from(outline(&columns));
            plot.line(Line::new("tip error", line).color(color.color32()).width(1.2));
            if trials <= POINTS_UP_TO {
                let each = profile.tip_error_mm.iter().enumerate();
                let points: Vec<[f64; 2]> = each.map(|(k, e)| [k as f64 + 1.0, *e]).collect();
                plot.points(
                    Points::new("trials", PlotPoints::from(points))
                        .shape(MarkerShape::Circle)
                        .radius(2.5)
                        .color(color.color32()),
                );
            }
            if !measured.is_empty() {
                plot.points(
                    Points::new("measured", PlotPoints::from(measured.clone()))
                        .shape(MarkerShape::Circle)
                        .radius(2.5)
                        .color(palette::MEASURED.color32()),
                );
            }
            if let Some(limit_mm) = limit_mm {
                plot.hline(
                    HLine::new("requirement", limit_mm)
                        .color(palette::MET.color32())
                        .style(LineStyle::dashed_dense())
                        .width(1.0),
                );
            }
            if let Some(trial) = view.shown
                && let Some(error_mm) = error_mm(trial.number)
            {
                let x = trial.number as f64 + 1.0;
                plot.vline(VLine::new("shown", x).color(palette::TEXT_STRONG.color32()).width(1.0));
                plot.points(
                    Points::new("shown", PlotPoints::from(vec![[x, error_mm]]))
                        .radius(4.0)
                        .color(palette::TEXT_STRONG.color32()),
                );
            }
        });
    let rect = plot.response.rect;
    let painter = ui.painter_at(rect);
    let caption = |at, anchor, text: String, color: palette::Rgb| {
        painter.text(at, anchor, text, theme::label_font(), color.color32());
    };
    caption(
        rect.left_top() + vec2(6.0, 2.0),
        egui::Align2::LEFT_TOP,
        match measured.is_empty() {
            true => "tip error over the trials, room's model alone".to_owned(),
            false => "tip error over the trials, room's model alone; points: measured".to_owned(),
        },
        palette::TEXT_QUIET,
    );
    if let Some(within) = charted.within {
        let limit_mm = within.limit_mm;
        let y = plot.transform.position_from_point(&PlotPoint::new(1.0, limit_mm)).y;
        // Above its line where there is room.
        let anchor = match y - rect.top() > 16.0 {
            true => egui::Align2::RIGHT_BOTTOM,
            false => egui::Align2::RIGHT_TOP,
        };
        caption(
            pos2(rect.right() - 6.0, y - 2.0),
            anchor,
            format!("required {} {}", within.metric.summary.label(), length(limit_mm)),
            palette::MET,
        );
    }
    let response = &plot.response;
    if (response.clicked() || response.is_pointer_button_down_on())
        && let Some(pointer) = response.interact_pointer_pos()
        && let Some(trial) = chosen(plot.transform.value_from_position(pointer).x)
        && view.shown.map(|shown| shown.number) != Some(trial)
    {
        actions.push(TimelineAction::Study(StudyRequest::Show(Some(trial))));
    }
}

/// From the least to the largest error of each column, side by side.
fn outline(columns: &[Column]) -> Vec<[f64; 2]> {
    let mut points = Vec::with_capacity(2 * columns.len());
    for column in columns {
        let x = column.first_trial as f64 + 1.0;
        points.push([x, column.min_mm]);
        if column.max_mm > column.min_mm {
            points.push([x, column.max_mm]);
        }
    }
    points
}

/// The trial under the pointer: where several share a column, the worst of them, whose error the
/// column ends at.
fn trial_at(columns: &[Column], trials: usize, x: f64) -> Option<usize> {
    let last = trials.checked_sub(1)?;
    let each = columns.get(1).map_or(1, |column| column.first_trial);
    let nearest = (x - 1.0).round().clamp(0.0, last as f64) as usize;
    match each {
        1 => Some(nearest),
        _ => columns.get(nearest / each).map(|column| column.worst_trial),
    }
}

fn whole(value: f64) -> String {
    let nearest = value.round();
    if (value - nearest).abs() > 1e-6 || nearest < 1.0 {
        return String::new();
    }
    count(nearest as usize)
}

#[cfg(test)]
mod tests {
    use super::*;
    use trackwright_geometry::pose::Pose;

    #[test]
    fn a_trial_is_described_by_number_and_moving_axes() {
        let trial = ShownTrial {
            number: 1202,
            of: 3375,
            kind: ModeKind::Motion,
            offsets: vec![("x", -20.0), ("rz", 22.5)],
            pose: InputTrial::at(Pose::identity()),
        };
        let words = "trial 1,203 of 3,375: x \u{2212}20\u{2009}mm, rz 22.5°";
        assert_eq!(trial_words(&trial), words);
        let given = ShownTrial { kind: ModeKind::Input, ..trial };
        assert!(trial_words(&given).ends_with("z 0.00\u{2009}mm"));
    }

    #[test]
    fn a_column_of_several_trials_selects_the_worst() {
        let column = |first_trial, worst_trial| Column {
            first_trial,
            min_mm: 0.0,
            max_mm: 1.0,
            worst_trial,
        };
        let columns = [column(0, 7), column(10, 12)];
        assert_eq!(trial_at(&columns, 15, 3.0), Some(7));
        assert_eq!(trial_at(&columns, 15, 99.0), Some(12));
        let single = [column(0, 0), column(1, 1)];
        assert_eq!(trial_at(&single, 2, 1.6), Some(1));
        assert_eq!(trial_at(&[], 0, 1.0), None);
    }
}
