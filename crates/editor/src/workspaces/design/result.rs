//! What the study comes to: one large figure, and the others below it.

use crate::document::trials::{ModeKind, TrialChoice};
use crate::palette;
use crate::palette::ThemedColor;
use crate::runner::results::Results;
use crate::runner::solved::Extent;
use crate::widgets::basic::{counted, is_zero, quiet_ui, signed, warning_ui, with_unit};
use crate::widgets::theme;
use crate::widgets::tooltip::Explain;
use crate::widgets::verdict::{bound_text, figure_color, interval_text, verdict_text};
use crate::workspaces::design::baseline::Change;
use bevy_egui::egui::{
    self, Align, CollapsingHeader, Color32, Label, Layout, RichText, TextStyle, TextWrapMode, Ui,
    WidgetText,
};
use trackwright_design::Document;
use trackwright_result::{Row, number, with_separators};
use trackwright_simulation::figures::{FreeRotation, capitalised, with_minus_signs};
use trackwright_simulation::{
    ErrorOf, Figure, Figures, Metric, RoomFieldFigures, Study, Undecided, Verdict, figure_rows,
};

/// What the panel shows.
pub struct ResultView<'a> {
    pub results: &'a Results,
    /// What the large figure differs by from what it was before the last change.
    pub change: Option<Change>,
    /// Why the large figure misses its bound, in sentences.
    pub reasons: Vec<String>,
    /// The design changed and its figures are on their way.
    pub is_computing: bool,
    /// Where there is little room: the large figure, and one line of the others.
    pub is_short: bool,
}

/// Whether the figures are of the design as it was, or of another mode.
pub(crate) fn are_figures_old(
    document: &Document,
    results: &Results,
    choice: &TrialChoice,
) -> bool {
    let study = results.study.as_ref();
    study.is_none_or(|study| study.revision != document.revision())
        || results.mode != Some(choice.kind(document.design().motion.is_some()))
}

/// Draws the result.
pub fn result_ui(ui: &mut Ui, result: &ResultView) {
    rows_ui(ui, result, Metric::is_shown);
}

/// Draws the large figure and the few that decide.
pub fn brief_result_ui(ui: &mut Ui, result: &ResultView) {
    rows_ui(ui, result, Metric::is_brief);
}

/// The rows of `figure_rows` that are shown; the command line prints all.
fn rows_ui(ui: &mut Ui, result: &ResultView, is_shown: fn(Metric) -> bool) {
    ui.spacing_mut().item_spacing.y = 2.0;
    if let Some(problem) = &result.results.problem {
        quiet_ui(ui, "no figures");
        warning_ui(ui, problem);
        return;
    }
    let Some(study) = &result.results.study else {
        quiet_ui(ui, "computing…");
        return;
    };
    let (figures, room_field) = (&study.value.figures, &study.value.room_field);
    headline_ui(ui, &study.value, result);
    if result.is_short {
        quiet_ui(ui, in_short(figures));
        counts_ui(ui, room_field, result.results);
        return;
    }
    ui.add_space(6.0);
    figures_ui(ui, figures);
    if let Some(Ok(scatter)) = &result.results.scatter {
        figure_ui(ui, &number("", "tip jitter RMS, this pose", scatter.rms_mm, 4, "mm"));
    }
    ui.add_space(4.0);
    if let Some(why) = &figures.no_interval {
        let what = if figures.all.is_empty() { "No figures" } else { "No interval" };
        warning_ui(ui, &with_minus_signs(&format!("{what}: {why}")));
    }
    counts_ui(ui, room_field, result.results);
    room_field_ui(ui, room_field, is_shown);
}

/// The paper's simulation, folded.
fn room_field_ui(ui: &mut Ui, room_field: &RoomFieldFigures, is_shown: fn(Metric) -> bool) {
    let head = RichText::new("Room's model alone").color(palette::TEXT_QUIET.color32());
    let section = CollapsingHeader::new(head).id_salt("room field").default_open(false);
    let section = section.show(ui, |ui| {
        for row in figure_rows(room_field) {
            // A determined part is no metric, and a count has no key.
            if Metric::named(&row.key).map_or(!row.key.is_empty(), is_shown) {
                figure_ui(ui, &row);
            }
        }
    });
    section.header_response.explained(ROOM_FIELD);
}

/// What the folded figures are.
const ROOM_FIELD: &str = "The paper's simulation: the room's model is taken for its field, without what the measurements leave open";

/// The tip error in one line.
fn in_short(figures: &Figures) -> String {
    let each = figures.bounded().filter(|figure| figure.metric.of == ErrorOf::Position);
    let each = each.map(|f| format!("{} {}", f.metric.summary.label(), f.value_text(2)));
    let each = with_unit(&each.collect::<Vec<_>>().join(", "), "mm");
    format!("tip error: {each}")
}

/// The figures with their intervals, but for the large one.
fn figures_ui(ui: &mut Ui, figures: &Figures) {
    let large = figures.headline().map(|figure| figure.metric);
    for figure in figures.bounded().filter(|figure| Some(figure.metric) != large) {
        ui.horizontal(|ui| {
            figure_label_ui(ui, figure.metric);
            ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
                if let Some(interval) = figure.interval_text(2) {
                    quiet_ui(ui, interval).explained(INTERVAL);
                }
                ui.label(with_unit(&figure.value_text(2), figure.metric.unit()));
            });
        });
    }
}

/// Width of a value with its interval, points.
const VALUE_WIDTH: f32 = 120.0;

/// The label of a figure, or the short one where a value and its interval leave no room for it.
fn figure_label_ui(ui: &mut Ui, figure: Metric) {
    let label = figure.label().to_owned();
    let color = palette::TEXT_QUIET.color32();
    let painted = ui.painter().layout_no_wrap(label, theme::label_font(), color);
    match painted.size().x + VALUE_WIDTH <= ui.available_width() {
        true => quiet_ui(ui, figure.label()).explained(figure.about()),
        false => {
            let about = format!("{}. {}", capitalised(figure.label()), figure.about());
            quiet_ui(ui, figure.short_label()).explained(about)
        }
    };
}

/// What an interval is.
const INTERVAL: &str =
    "95 % interval: how far the figure may be off, from what the room leaves open";

fn headline_ui(ui: &mut Ui, study: &Study, result: &ResultView) {
    let figures = &study.figures;
    let computing_ui = |ui: &mut Ui| {
        if result.is_computing {
            ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
                quiet_ui(ui, "computing…");
            });
        }
    };
    let Some(figure) = figures.headline() else {
        ui.horizontal(|ui| {
            quiet_ui(ui, "no figures");
            computing_ui(ui);
        });
        if let Some(requirement) = &figures.requirement {
            let color = figure_color(Some(requirement.verdict));
            ui.label(RichText::new(verdict_text(requirement.verdict)).color(color));
        }
        return;
    };
    let metric = figure.metric;
    ui.horizontal(|ui| {
        quiet_ui(ui, metric.label()).explained(metric.about());
        computing_ui(ui);
    });
    let bound = figures.requirement.as_ref().and_then(|own| own.bound(metric));
    // One pose against a limit over the range of motion has no verdict.
    let (judged, over_motion) = match bound {
        Some(bound) if bound.reason == Some(Undecided::OnePose) => (None, Some(bound)),
        bound => (bound, None),
    };
    ui.horizontal_wrapped(|ui| {
        large_figure_ui(ui, figure, figure_color(judged.map(|bound| bound.verdict)));
        let change = result.change.and_then(|change| change_text(change, metric.unit()));
        if let Some((text, color)) = change {
            // On the next line as a whole, where it finds no room.
            ui.add(Label::new(RichText::new(text).color(color.color32())).extend())
                .explained("Change since the last edit began");
        }
    });
    if let Some(bound) = judged {
        let text = RichText::new(bound_text(bound)).color(figure_color(Some(bound.verdict)));
        ui.add(Label::new(text).wrap());
    }
    let is_missed = judged.is_some_and(|bound| bound.verdict == Verdict::Missed);
    for reason in result.reasons.iter().filter(|_| is_missed && !result.is_short) {
        ui.add(Label::new(RichText::new(reason).color(palette::TEXT.color32())).wrap());
    }
    if let Some(bound) = over_motion {
        let limit = with_unit(&format!("{:.2}", bound.limit), metric.unit());
        quiet_ui(ui, format!("at most {limit} over the range of motion; one pose is not judged"));
    }
}

fn large_figure_ui(ui: &mut Ui, figure: &Figure, color: Color32) {
    let value = with_unit(&figure.value_text(2), figure.metric.unit());
    ui.label(RichText::new(value).font(theme::figure_font()).color(color));
    if let Some(interval) = interval_text(figure) {
        let text = RichText::new(interval).color(palette::TEXT.color32());
        // On the next line as a whole, where it finds no room.
        ui.add(Label::new(text).extend()).explained(INTERVAL);
    }
}

/// A change of the large figure and its colour; none where it rounds to nothing.
fn change_text(change: Change, unit: &str) -> Option<(String, palette::Rgb)> {
    match change {
        Change::OtherRoom => Some(("another room".to_owned(), palette::TEXT_QUIET)),
        Change::OtherMotion => Some(("another range of motion".to_owned(), palette::TEXT_QUIET)),
        Change::By(by) => {
            let text = signed(by, 2);
            let color = if by < 0.0 { palette::MET } else { palette::MISSED };
            (!is_zero(&text)).then(|| (with_unit(&text, unit), color))
        }
    }
}

fn figure_ui(ui: &mut Ui, row: &Row) {
    let value = with_unit(&row.value_text(), row.unit);
    ui.horizontal(|ui| {
        let width = |text: &str| {
            let text = WidgetText::from(text);
            let mode = Some(TextWrapMode::Extend);
            text.into_galley(ui, mode, f32::INFINITY, TextStyle::Body).size().x
        };
        let most = ui.available_width() - width(&value) - ui.spacing().item_spacing.x;
        let text = RichText::new(&*row.label).color(palette::TEXT_QUIET.color32());
        let label = match width(&row.label) <= most {
            true => ui.label(text),
            // What leaves no room for its value takes two lines.
            false => {
                let two_lines = |ui: &mut Ui| {
                    ui.set_max_width(most);
                    ui.add(Label::new(text).wrap())
                };
                ui.vertical(two_lines).inner
            }
        };
        if let Some(metric) = Metric::named(&row.key) {
            label.explained(metric.about());
        }
        ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
            ui.label(value);
        });
    });
}

fn counts_ui(ui: &mut Ui, figures: &RoomFieldFigures, results: &Results) {
    match results.extent {
        Some(Extent::PreviewOf(whole)) => {
            let part = counted(figures.trials, "trial", "trials");
            warning_ui(
                ui,
                &format!("preview while dragging: {part} of {}", with_separators(whole)),
            );
        }
        Some(Extent::Whole) | None => {
            let trials = counted(figures.trials, "trial", "trials");
            quiet_ui(ui, of_mode(trials, results.mode));
        }
    }
    for text in warnings(figures) {
        warning_ui(ui, &text);
    }
    if let Some(free) = figures.free_axis.filter(|free| !free.reaches_tip()) {
        quiet_ui(ui, with_minus_signs(&capitalised(&free.statement())));
    }
}

/// Which mode the figures are of.
fn of_mode(trials: String, mode: Option<ModeKind>) -> String {
    match mode {
        Some(mode) => format!("{}, {trials}", mode.name()),
        None => trials,
    }
}

/// What is not as it should be, in words.
pub fn warnings(figures: &RoomFieldFigures) -> Vec<String> {
    let mut texts = Vec::new();
    let count = |n: usize| counted(n, "trial has", "trials have");
    if figures.outside > figures.in_metal {
        texts.push(format!("{} a sensor outside the model's box", count(figures.outside)));
    }
    if figures.in_metal > 0 {
        texts.push(format!(
            "{} a sensor in metal, where it has no reading",
            count(figures.in_metal)
        ));
    }
    if figures.out_of_volume > 0 {
        texts
            .push(format!("{} a sensor out of the tracker's volume", count(figures.out_of_volume)));
    }
    if figures.rejected > 0 {
        texts.push(format!("{} left out", counted(figures.rejected, "trial was", "trials were")));
    }
    if let Some(free) = figures.free_axis.filter(FreeRotation::reaches_tip) {
        texts.push(with_minus_signs(&capitalised(&free.statement())));
    }
    if let Some(weak) = &figures.barely_determined {
        texts.push(with_minus_signs(&capitalised(&weak.statement())));
    } else if figures.poorly_determined {
        texts.push("A rotation is poorly determined: noise decides it".to_owned());
    }
    texts
}

/// A frame that sets the result apart from the inspector above.
pub fn frame() -> egui::Frame {
    theme::panel_frame(egui::Margin::symmetric(12, 8))
}
