//! What the study comes to: one large figure, and the others below it.

use crate::document::trials::{ModeKind, TrialChoice};
use crate::palette;
use crate::palette::ThemedColor;
use crate::runner::results::Results;
use crate::runner::solved::Extent;
use crate::widgets::basic::{counted, is_zero, quiet_ui, signed, warning_ui, with_unit};
use crate::widgets::theme;
use crate::widgets::tooltip::Explain;
use crate::widgets::verdict::{bound_text, figure_color};
use crate::workspaces::design::baseline::Change;
use bevy_egui::egui::{
    self, Align, Label, Layout, RichText, TextStyle, TextWrapMode, Ui, WidgetText,
};
use trackwright_design::Document;
use trackwright_simulation::figures::{capitalised, with_minus_signs, with_separators};
use trackwright_simulation::{
    ErrorOf, Expected, FigureRow, Figures, Headline, Metric, RowOf, figure_rows, headline,
};

/// What the panel shows.
pub struct ResultView<'a> {
    pub results: &'a Results,
    /// What the large figure differs by from what it was before the last change.
    pub change: Option<Change>,
    /// One pose of a design that is to be judged over its range of motion.
    pub is_one_pose: bool,
    /// Why the large figure misses its bound, in sentences.
    pub reasons: Vec<String>,
    /// The room keeps measurements, so that its figures have expected ones.
    pub has_expected: bool,
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
    let figures = &study.value.figures;
    let expected = result.results.expected_of_study();
    let headline = headline(figures, expected);
    headline_ui(ui, &headline, result);
    if result.is_short {
        quiet_ui(ui, in_short(figures, expected));
        counts_ui(ui, figures, result.results);
        return;
    }
    ui.add_space(6.0);
    if let Some(expected) = expected {
        expected_ui(ui, expected, headline.metric);
        ui.add_space(4.0);
        quiet_ui(ui, OWN_FIELD);
    }
    let is_shown = if expected.is_some() { Metric::is_brief } else { is_shown };
    for row in figure_rows(figures) {
        let shows = match row.of {
            RowOf::Metric(metric) => is_shown(metric),
            RowOf::Determined(_) => true,
            RowOf::Other => false,
        };
        if shows {
            figure_ui(ui, &row);
        }
    }
    if let Some(Ok(scatter)) = &result.results.scatter {
        figure_ui(
            ui,
            &FigureRow {
                of: RowOf::Other,
                label: "tip jitter RMS, this pose".to_owned(),
                value: format!("{:.4}", scatter.rms_mm),
                unit: "mm",
            },
        );
    }
    ui.add_space(4.0);
    counts_ui(ui, figures, result.results);
}

/// Above the figures of the field that was fitted: what its measurements leave open is not in them.
const OWN_FIELD: &str = "in the room's own field";

/// The tip error in one line.
fn in_short(figures: &Figures, expected: Option<&Expected>) -> String {
    let of = |metric: Metric| {
        let found = expected.map(|expected| expected.of(metric));
        let value = found.map_or(figures.value(metric), |(value, _)| value);
        format!("{} {value:.2}", metric.summary.label())
    };
    let each = Metric::bounded().filter(|metric| metric.of == ErrorOf::Position).map(of);
    let each = with_unit(&each.collect::<Vec<_>>().join(", "), "mm");
    let kind = expected.map_or("", |_| "expected ");
    format!("{kind}tip error: {each}")
}

/// `0.46–0.85`: without its unit, which stands beside it.
pub(crate) fn interval_text([low, high]: [f64; 2]) -> String {
    format!("{low:.2}–{high:.2}")
}

/// The expected figures with their intervals, but for the large one.
fn expected_ui(ui: &mut Ui, expected: &Expected, large: Metric) {
    for figure in Metric::bounded().filter(|figure| *figure != large) {
        let (value, interval) = expected.of(figure);
        ui.horizontal(|ui| {
            figure_label_ui(ui, figure);
            ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
                quiet_ui(ui, interval_text(interval)).explained(INTERVAL);
                ui.label(with_unit(&format!("{value:.2}"), figure.unit()));
            });
        });
    }
}

/// Width of a value with its interval, points.
const VALUE_WIDTH: f32 = 110.0;

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
    "95 % interval: how far the figure may be off, from what the room's measurements leave open";

fn headline_ui(ui: &mut Ui, headline: &Headline, result: &ResultView) {
    let is_pending = result.has_expected && headline.interval.is_none();
    ui.horizontal(|ui| {
        let name = headline.metric.label();
        let label = match headline.interval {
            Some(_) => quiet_ui(ui, format!("expected {name}")),
            None => quiet_ui(ui, name),
        };
        label.explained(headline.metric.about());
        if result.is_computing {
            ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
                quiet_ui(ui, "computing…");
            });
        }
    });
    let unit = headline.metric.unit();
    // What is not known for certain yet has no verdict, nor has one pose against an RMS of many.
    let is_judged = !result.is_one_pose || headline.metric.is_extreme();
    let bound = headline.bound.filter(|_| !is_pending && is_judged);
    ui.horizontal_wrapped(|ui| {
        let color = figure_color(bound.map(|bound| bound.verdict));
        let value = with_unit(&format!("{:.2}", headline.value), unit);
        ui.label(RichText::new(value).font(theme::figure_font()).color(color));
        if let Some(interval) = headline.interval {
            let text = RichText::new(interval_text(interval)).color(palette::TEXT.color32());
            ui.label(text).explained(INTERVAL);
        }
        if let Some((text, color)) = result.change.and_then(|change| change_text(change, unit)) {
            // On the next line as a whole, where it finds no room.
            ui.add(Label::new(RichText::new(text).color(color.color32())).extend())
                .explained("Change since the last edit began");
        }
    });
    if is_pending {
        quiet_ui(ui, OWN_FIELD);
    }
    if let Some(bound) = &bound {
        let text = bound_text(bound, unit);
        ui.label(RichText::new(text).color(figure_color(Some(bound.verdict))));
    }
    for reason in result.reasons.iter().filter(|_| bound.is_some() && !result.is_short) {
        ui.add(Label::new(RichText::new(reason).color(palette::TEXT.color32())).wrap());
    }
    if let (Some(bound), false) = (&headline.bound, is_judged) {
        let limit = with_unit(&format!("{:.2}", bound.limit), unit);
        quiet_ui(ui, format!("at most {limit} over the range of motion; one pose is not judged"));
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

fn figure_ui(ui: &mut Ui, row: &FigureRow) {
    let value = with_unit(&row.value, row.unit);
    ui.horizontal(|ui| {
        let width = |text: &str| {
            let text = WidgetText::from(text);
            let mode = Some(TextWrapMode::Extend);
            text.into_galley(ui, mode, f32::INFINITY, TextStyle::Body).size().x
        };
        let most = ui.available_width() - width(&value) - ui.spacing().item_spacing.x;
        let text = RichText::new(&row.label).color(palette::TEXT_QUIET.color32());
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
        if let RowOf::Metric(metric) = row.of {
            label.explained(metric.about());
        }
        ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
            ui.label(value);
        });
    });
}

fn counts_ui(ui: &mut Ui, figures: &Figures, results: &Results) {
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
}

/// Which mode the figures are of.
fn of_mode(trials: String, mode: Option<ModeKind>) -> String {
    match mode {
        Some(mode) => format!("{}, {trials}", mode.name()),
        None => trials,
    }
}

/// What is not as it should be, in words.
pub fn warnings(figures: &Figures) -> Vec<String> {
    let mut texts = Vec::new();
    let count = |n: usize| counted(n, "trial has", "trials have");
    if figures.outside > 0 {
        texts.push(format!("{} a sensor outside the model's box", count(figures.outside)));
    }
    if figures.out_of_volume > 0 {
        texts
            .push(format!("{} a sensor out of the tracker's volume", count(figures.out_of_volume)));
    }
    if figures.rejected > 0 {
        texts.push(format!("{} left out", counted(figures.rejected, "trial was", "trials were")));
    }
    if let Some(free) = &figures.free_axis {
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
