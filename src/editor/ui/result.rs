//! What the study comes to: one large figure, and the others below it.

use super::theme;
use super::widgets::{
    MET_SIGN, MISSED_SIGN, THIN_SPACE, counted, quiet_ui, signed, warning_ui, with_unit,
};
use crate::editor::palette;
use crate::editor::solver::Extent;
use crate::editor::state::Results;
use crate::editor::study::ModeKind;
use crate::study::figures::with_separators;
use crate::study::{FigureRow, Figures, figure_rows};
use bevy_egui::egui::{self, Align, Layout, RichText, Ui};

/// What the panel shows.
pub struct ResultView<'a> {
    pub results: &'a Results,
    /// The large figure as it was before the last change.
    pub before: Option<f64>,
    /// The design changed and its figures are on their way.
    pub is_computing: bool,
    /// Where there is little room: the large figure, and one line of the others.
    pub is_short: bool,
}

/// The one figure that counts: the first bound that is missed, else the first bound, else the
/// RMS of the tip error.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Headline {
    pub name: &'static str,
    pub value: f64,
    pub unit: &'static str,
    /// The bound, and whether the value keeps it.
    pub limit: Option<(f64, bool)>,
}

/// The one figure that counts.
pub fn headline(figures: &Figures) -> Headline {
    let missed = figures.checks.iter().find(|check| !check.met);
    match missed.or_else(|| figures.checks.first()) {
        None => Headline {
            name: "tip error RMS",
            value: figures.position_mm.rms,
            unit: "mm",
            limit: None,
        },
        Some(check) => {
            let (name, unit) = match check.name {
                "position_rms" => ("tip error RMS", "mm"),
                "position_p95" => ("tip error 95th percentile", "mm"),
                "position_max" => ("tip error max", "mm"),
                "angle_rms" => ("angle error RMS", "°"),
                "angle_max" => ("angle error max", "°"),
                other => (other, ""),
            };
            Headline {
                name,
                value: check.value,
                unit,
                limit: Some((check.limit, check.met)),
            }
        }
    }
}

/// The rows of `figure_rows` that the panel shows; the command line prints all.
const SHOWN: [&str; 8] = [
    "tip error RMS",
    "tip error mean",
    "tip error 95th percentile",
    "tip error max",
    "angle error RMS",
    "angle error mean",
    "angle error 95th percentile",
    "angle error max",
];

const DETERMINED: [&str; 2] = [
    "tip error RMS, determined part",
    "tip error max, determined part",
];

/// What is shown where the result stands below something else.
const BRIEF: [&str; 4] = [
    "tip error RMS",
    "tip error max",
    "angle error RMS",
    "angle error max",
];

/// Draws the result.
pub fn result_ui(ui: &mut Ui, result: &ResultView) {
    rows_ui(ui, result, &[&SHOWN[..], &DETERMINED].concat());
}

/// Draws the large figure and the few that decide.
pub fn brief_result_ui(ui: &mut Ui, result: &ResultView) {
    rows_ui(ui, result, &BRIEF);
}

fn rows_ui(ui: &mut Ui, result: &ResultView, shown: &[&str]) {
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
    headline_ui(ui, &headline(figures), result);
    if result.is_short {
        quiet_ui(ui, in_short(figures));
        counts_ui(ui, figures, result.results);
        return;
    }
    ui.add_space(6.0);
    for row in figure_rows(figures) {
        if shown.contains(&row.label) {
            figure_ui(ui, &row);
        }
    }
    if let Some(Ok(scatter)) = &result.results.scatter {
        figure_ui(
            ui,
            &FigureRow {
                label: "tip jitter RMS, this pose",
                value: format!("{:.4}", scatter.rms_mm),
                unit: "mm",
            },
        );
    }
    ui.add_space(4.0);
    counts_ui(ui, figures, result.results);
}

/// The tip error in one line.
fn in_short(figures: &Figures) -> String {
    let error = &figures.position_mm;
    let [rms, p95, max] = [error.rms, error.p95, error.max].map(|mm| format!("{mm:.2}"));
    let max = with_unit(&max, "mm");
    format!("tip error: RMS {rms}, 95th percentile {p95}, max {max}")
}

fn headline_ui(ui: &mut Ui, headline: &Headline, result: &ResultView) {
    ui.horizontal(|ui| {
        quiet_ui(ui, headline.name);
        if result.is_computing {
            ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
                quiet_ui(ui, "computing…");
            });
        }
    });
    ui.horizontal(|ui| {
        let color = theme::verdict_color(headline.limit.map(|(_, is_met)| is_met));
        let value = with_unit(&format!("{:.2}", headline.value), headline.unit);
        ui.label(RichText::new(value).font(theme::figure_font()).color(color));
        if let Some(before) = result.before {
            let change = headline.value - before;
            let text = with_unit(&signed(change, 2), headline.unit);
            let color = if text.starts_with('±') {
                palette::TEXT_QUIET
            } else if change < 0.0 {
                palette::MET
            } else {
                palette::MISSED
            };
            ui.label(RichText::new(text).color(color.color32()))
                .on_hover_text("Change since the last edit began");
        }
    });
    if let Some((limit, is_met)) = headline.limit {
        let limit = with_unit(&format!("{limit:.2}"), headline.unit);
        let text = if is_met {
            format!("{MET_SIGN} met: at most {limit}")
        } else {
            format!("{MISSED_SIGN} missed: at most {limit}")
        };
        ui.label(RichText::new(text).color(theme::verdict_color(Some(is_met))));
    }
}

fn figure_ui(ui: &mut Ui, row: &FigureRow) {
    ui.horizontal(|ui| {
        ui.label(RichText::new(row.label).color(palette::TEXT_QUIET.color32()));
        ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
            ui.label(with_unit(&row.value, row.unit));
        });
    });
}

fn counts_ui(ui: &mut Ui, figures: &Figures, results: &Results) {
    match results.extent {
        Some(Extent::PreviewOf(whole)) => {
            let part = counted(figures.trials, "trial", "trials");
            warning_ui(
                ui,
                &format!(
                    "preview while dragging: {part} of {}",
                    with_separators(whole)
                ),
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
        texts.push(format!(
            "{} a sensor outside the model's box",
            count(figures.outside)
        ));
    }
    if figures.out_of_volume > 0 {
        texts.push(format!(
            "{} a sensor out of the tracker's volume",
            count(figures.out_of_volume)
        ));
    }
    if figures.rejected > 0 {
        texts.push(format!(
            "{} left out",
            counted(figures.rejected, "trial was", "trials were")
        ));
    }
    if let Some(free) = &figures.free_axis {
        let body = if free.body == "crf" { "CRF" } else { free.body };
        texts.push(match free.axis_in_body {
            Some([x, y, z]) => format!(
                "The {body}'s rotation about ({x:.2},{THIN_SPACE}{y:.2},{THIN_SPACE}{z:.2}) is \
                 not determined by its sensors"
            ),
            None => format!("The {body}'s rotation is not determined by its sensors"),
        });
    }
    if figures.poorly_determined {
        texts.push("A rotation is poorly determined: noise decides it".to_owned());
    }
    texts
}

/// A frame that sets the result apart from the inspector above.
pub fn frame() -> egui::Frame {
    theme::panel_frame(egui::Margin::symmetric(12, 8))
}
