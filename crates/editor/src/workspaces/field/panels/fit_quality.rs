//! The quality of the newest fit, beside the settings and tables it was made from, and the design's
//! figures in it.

use crate::palette;
use crate::palette::ThemedColor;
use crate::widgets::basic::{
    count, fact_ui, main_button, quiet_ui, section_ui, signed, warning_ui, with_unit,
};
use crate::widgets::theme;
use crate::widgets::tooltip::{Explain, button_ui};
use crate::widgets::verdict::{verdict_mark, verdict_text};
use crate::workspaces::field::panels::{cell_ui, good_ui, head_ui};
use crate::workspaces::field::requests::{FieldRequest, RoomToSave};
use crate::workspaces::field::state::FieldState;
use crate::workspaces::field::state::{Comparison, Fitted};
use bevy_egui::egui::{Grid, Label, RichText, Ui};
use trackwright_calibration::fit_quality::FitQuality;
use trackwright_calibration::room_model::RoomModel;
use trackwright_field::computed::ModelKind;
use trackwright_field::selection::Candidate;
use trackwright_report::kinds::decided_reason;
use trackwright_report::room::{fit_warnings, harmonic_text, method_name};
use trackwright_report::selection::candidate_text;
use trackwright_simulation::Metric;
use trackwright_simulation::{Study, Verdict};

/// Every coefficient is determined by its samples.
const ENOUGH_SAMPLES: &str = "Enough samples for this model";

/// Draws the quality of the newest fit, and what can be done with it.
pub fn fit_quality_ui(ui: &mut Ui, state: &FieldState) -> Vec<FieldRequest> {
    let mut requests = Vec::new();
    section_ui(ui, "Fit quality");
    let Some(fitted) = &state.fitted else {
        quiet_ui(ui, "Nothing is fitted yet");
        return requests;
    };
    title_ui(ui, fitted);
    if state.is_outdated(fitted) {
        warning_ui(ui, "Tables or settings have changed since this fit");
    }
    ui.add_space(2.0);
    figures_ui(ui, fitted);
    if fitted.held_out_quality.is_none() {
        quiet_ui(ui, "Open held-out measurements for its model error on unseen data");
    }
    ui.add_space(4.0);
    if fitted.decided.model.kind() == ModelKind::Bernstein {
        systems_ui(ui, fitted);
    }
    let warnings = fit_warnings(&fitted.fit);
    for warning in warnings.iter().chain(&fitted.notes) {
        warning_ui(ui, warning);
    }
    if warnings.is_empty() && fitted.decided.settings.order > 0 {
        good_ui(ui, ENOUGH_SAMPLES);
    }
    ui.add_space(6.0);
    ui.horizontal(|ui| {
        let use_it = ui
            .add(main_button("Use in this design…"))
            .explained("Saves the room to a file and puts the design into it");
        if use_it.clicked() {
            requests.push(FieldRequest::ShowSave(RoomToSave::Fitted));
        }
        match &state.comparing {
            Some(_) => {
                if button_ui(ui, "Cancel", "Stops trying the room").clicked() {
                    requests.push(FieldRequest::CancelTry);
                }
                quiet_ui(ui, "computing…");
            }
            None => {
                let try_it = ui
                    .button("Try")
                    .explained("Shows the design's figures in this room; the design stays");
                if try_it.clicked() {
                    requests.push(FieldRequest::Try);
                }
            }
        }
    });
    requests
}

fn title_ui(ui: &mut Ui, fitted: &Fitted) {
    let settings = &fitted.decided.settings;
    let candidate =
        Candidate { order: settings.order, directions: settings.directions, ridge: settings.ridge };
    let of_polynomials =
        format!("{}, {}", candidate_text(&candidate), method_name(settings.method));
    let title = match (&fitted.harmonic, &fitted.decided.model) {
        (Some(harmonic), _) => harmonic_text(harmonic),
        (None, RoomModel::Bernstein { is_symmetric: true }) => {
            format!("{of_polynomials}, symmetric")
        }
        (None, RoomModel::Bernstein { is_symmetric: false }) => of_polynomials,
        (None, model) => model.kind().name().to_owned(),
    };
    let title = RichText::new(title).color(palette::TEXT_STRONG.color32());
    ui.add(Label::new(title).wrap());
    if let Some(why) = decided_reason(&fitted.decided) {
        let why = RichText::new(why).font(theme::label_font()).color(palette::TEXT_QUIET.color32());
        ui.add(Label::new(why).wrap());
    }
}

/// A row of the table of figures: its name, and its value where a table has it.
type FigureOf = (&'static str, &'static str, fn(&FitQuality) -> Option<[f64; 2]>);

const FIGURES: [FigureOf; 4] = [
    ("position RMS", "mm", |quality| {
        Some([quality.before.rms.position_rms_mm, quality.after.rms.position_rms_mm])
    }),
    ("position max", "mm", |quality| {
        Some([quality.before.position_max_mm, quality.after.position_max_mm])
    }),
    ("angle RMS", "°", |quality| {
        Some([
            quality.before.rms.angle_rms_rad?.to_degrees(),
            quality.after.rms.angle_rms_rad?.to_degrees(),
        ])
    }),
    ("angle max", "°", |quality| {
        Some([
            quality.before.angle_max_rad?.to_degrees(),
            quality.after.angle_max_rad?.to_degrees(),
        ])
    }),
];

/// Training and held-out error, before and after.
fn figures_ui(ui: &mut Ui, fitted: &Fitted) {
    let qualities = [Some(&fitted.training_quality), fitted.held_out_quality.as_ref()];
    Grid::new("fit quality").num_columns(5).spacing([8.0, 3.0]).show(ui, |ui| {
        quiet_ui(ui, "");
        quiet_ui(ui, "fitted");
        head_ui(ui, "");
        if qualities[1].is_some() {
            quiet_ui(ui, "unseen data");
            head_ui(ui, "");
        }
        ui.end_row();
        quiet_ui(ui, "");
        for _ in qualities.into_iter().flatten() {
            head_ui(ui, "before");
            head_ui(ui, "after");
        }
        ui.end_row();
        for (name, unit, value) in FIGURES {
            let values = qualities.map(|quality| quality.and_then(value));
            if values.iter().all(Option::is_none) {
                continue;
            }
            ui.label(RichText::new(name).color(palette::TEXT_QUIET.color32()));
            for [before, after] in values.into_iter().flatten() {
                let text = |value: f64| with_unit(&format!("{value:.2}"), unit);
                cell_ui(ui, text(before), palette::TEXT_QUIET.color32());
                cell_ui(ui, text(after), palette::TEXT_STRONG.color32());
            }
            ui.end_row();
        }
    });
}

/// Rank and condition of the systems.
fn systems_ui(ui: &mut Ui, fitted: &Fitted) {
    let systems = &fitted.fit.systems;
    let by = |value: fn(&trackwright_field::fit::SystemReport) -> usize| {
        systems.iter().map(value).min().unwrap_or(0)
    };
    let Some(first) = systems.first() else {
        quiet_ui(ui, "order 0 has no coefficients");
        return;
    };
    let rank = format!("{} of {}", count(by(|s| s.rank)), count(first.unknowns));
    fact_ui(ui, "independent equations, least", &rank);
    fact_ui(ui, "samples, least", &count(by(|s| s.samples)));
    let conditions = systems.iter().map(|s| s.condition);
    let least = conditions.clone().fold(f64::INFINITY, f64::min);
    let most = conditions.fold(0.0, f64::max);
    let text = match systems.len() {
        1 => format!("{most:.1}"),
        _ => format!("{least:.1} to {most:.1}"),
    };
    fact_ui(ui, "condition number", &text);
}

/// Draws the design's figures in the present room beside those in the fitted one.
pub fn comparison_ui(ui: &mut Ui, comparison: &Comparison, is_current: bool) {
    section_ui(ui, "The design in this room");
    if !is_current {
        warning_ui(ui, "The design or its room has changed since");
    }
    Grid::new("comparison").num_columns(4).spacing([10.0, 3.0]).show(ui, |ui| {
        quiet_ui(ui, "");
        for head in ["present", "fitted", "difference"] {
            head_ui(ui, head);
        }
        ui.end_row();
        let rooms = [&comparison.present, &comparison.tried];
        for figure in Metric::bounded() {
            let [present, tried] = rooms.map(|study| study.figures.get(figure));
            let name = figure.label().replace("95th percentile", "95 %");
            ui.label(RichText::new(name).color(palette::TEXT_QUIET.color32()));
            for (known, color) in [(present, palette::TEXT_QUIET), (tried, palette::TEXT_STRONG)] {
                let Some(known) = known else { continue };
                let text = with_unit(&known.value_text(2), figure.unit());
                let cell = cell_ui(ui, text, color.color32());
                if let Some(interval) = known.interval_text(2) {
                    cell.explained(format!("95 %: {}", with_unit(&interval, figure.unit())));
                }
            }
            if let Some((present, tried)) = present.zip(tried) {
                // No colour: a smaller error in another room is no better design.
                let difference = signed(tried.value - present.value, 2);
                cell_ui(ui, difference, palette::TEXT_QUIET.color32());
            }
            ui.end_row();
        }
        if let [Some(present), Some(tried)] = rooms.map(verdict) {
            ui.label(RichText::new("requirement").color(palette::TEXT_QUIET.color32()));
            for verdict in [present, tried] {
                cell_ui(ui, verdict_text(verdict), verdict_mark(verdict).1);
            }
            ui.end_row();
        }
    });
    quiet_ui(ui, "Another room: no verdict on the design");
}

fn verdict(study: &Study) -> Option<Verdict> {
    Some(study.figures.requirement.as_ref()?.verdict)
}
