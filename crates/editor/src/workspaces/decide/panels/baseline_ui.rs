//! The design beside its baseline: every figure of both, and what of their difference is one.

use crate::palette;
use crate::palette::ThemedColor;
use crate::widgets::basic::{
    decimal, fact_ui, main_button, quiet_ui, right_text_ui, section_ui, signed, warning_ui,
    with_unit,
};
use crate::widgets::tooltip::{Explain, button_ui, checkbox_ui};
use crate::widgets::verdict::{interval_text, verdict_text};
use crate::workspaces::decide::against::Found;
use crate::workspaces::decide::panels::DecideView;
use crate::workspaces::decide::requests::DecideRequest;
use bevy_egui::egui::{Color32, Grid, Label, RichText, Ui};
use trackwright_formats::printable::printable;
use trackwright_simulation::Figures;
use trackwright_simulation::METRICS;
use trackwright_simulation::Metric;
use trackwright_simulation::comparison::{Difference, DifferenceVerdict, difference_words, notes};
use trackwright_simulation::figures::capitalised;
use trackwright_simulation::figures::with_minus_signs;

/// Draws the baseline and the differences from it.
pub fn baseline_ui(ui: &mut Ui, view: &DecideView) -> Vec<DecideRequest> {
    let mut requests = Vec::new();
    section_ui(ui, "Baseline");
    match (&view.state.pinned, &view.state.pinning) {
        (_, Some(_)) => {
            quiet_ui(ui, "reading…");
        }
        (None, None) => {
            let text = "Nothing is pinned. A pinned design stays beside this one, figure by figure and in the \
                        scene.";
            ui.add(Label::new(RichText::new(text).color(palette::TEXT_QUIET.color32())).wrap());
        }
        (Some(pinned), None) => {
            let name = RichText::new(printable(&pinned.name())).color(palette::BASELINE.color32());
            let about = match &pinned.file {
                Some(file) => file.display().to_string(),
                None => "A state of the open design".to_owned(),
            };
            ui.add(Label::new(name.strong()).wrap()).explained(about);
            if pinned.is_gone {
                warning_ui(
                    ui,
                    "Its file has been deleted or moved; it is compared as it was when it was pinned",
                );
            }
        }
    }
    ui.add_space(4.0);
    ui.horizontal(|ui| {
        let here = ui
            .add(main_button("Pin this state"))
            .explained("Holds the design against what it is now");
        if here.clicked() {
            requests.push(DecideRequest::PinHere);
        }
        let file = ui.button("Pin a file…").explained("Holds the design against another one");
        if file.clicked() {
            requests.push(DecideRequest::ShowPin);
        }
        if view.state.pinned.is_some()
            && button_ui(ui, "Unpin", "Holds the design against nothing").clicked()
        {
            requests.push(DecideRequest::Unpin);
        }
    });
    if let Some(pinned) = &view.state.pinned {
        ui.add_space(6.0);
        match view.found(pinned) {
            None => {
                quiet_ui(ui, "computing…");
            }
            Some((found, is_current)) => {
                found_ui(ui, view, (found, is_current), &mut requests);
            }
        }
    }
    requests
}

fn found_ui(
    ui: &mut Ui,
    view: &DecideView,
    (found, is_current): (&Found, bool),
    requests: &mut Vec<DecideRequest>,
) {
    let rows = &found.comparison.rows;
    let measured = |row: usize| rows.get(row).map(|row| row.measured.as_ref());
    let before = match measured(0) {
        Some(Ok(before)) => before,
        Some(Err(why)) => {
            warning_ui(ui, &format!("the baseline has no figures here: {why}"));
            return;
        }
        None => return,
    };
    if let Some(Err(why)) = measured(1) {
        warning_ui(ui, &format!("the design has no figures: {why}"));
        return;
    }
    // While a hand moves something the figures follow it, and what of a difference is one does not.
    let study = (view.results.study.as_ref()).filter(|_| view.results.is_whole());
    let (now, against) = match (is_current, measured(1)) {
        (true, Some(Ok(now))) => (&now.study, rows[1].against_baseline.as_ref()),
        _ => match study {
            Some(study) => (&study.value, None),
            None => {
                quiet_ui(ui, "computing…");
                return;
            }
        },
    };
    let before = &before.study;
    let differences = against.map(|against| against.differences.as_slice());
    table_ui(ui, view.state.shows_all_figures, [&before.figures, &now.figures], differences);
    ui.add_space(4.0);
    let mut all = view.state.shows_all_figures;
    let about = "Shows every figure, not only those that a requirement can bound";
    if checkbox_ui(ui, &mut all, "All figures", about).changed() {
        requests.push(DecideRequest::ShowAllFigures(all));
    }
    ui.add_space(4.0);
    for (name, figures) in [("baseline", &before.figures), ("this design", &now.figures)] {
        let figure = figures.get(Metric::TIP_RMS);
        if let Some((figure, interval)) = figure.and_then(|f| Some((f, interval_text(f)?))) {
            let value = with_unit(&figure.value_text(2), "mm");
            let name = format!("{}, {name}", Metric::TIP_RMS.short_label());
            fact_ui(ui, &name, &format!("{value}, {interval}"));
        }
        if let Some(requirement) = &figures.requirement {
            let text = verdict_text(requirement.verdict);
            fact_ui(ui, &format!("requirement, {name}"), &text);
        }
    }
    if let Some(headline) = differences.and_then(<[Difference]>::first) {
        let words = with_minus_signs(&difference_words(headline, "the baseline"));
        let words = format!("{}: {words}.", capitalised(Metric::TIP_RMS.label()));
        ui.add_space(4.0);
        ui.add(Label::new(RichText::new(words).color(palette::TEXT.color32())).wrap());
    }
    if let Some(Ok(now)) = measured(1).filter(|_| is_current) {
        for note in notes(now, against) {
            warning_ui(ui, &note);
        }
    }
    if let Some(Some(why)) = found.comparison.rooms_unknown.first() {
        warning_ui(ui, &format!("the uncertainty of the room's field is unknown: {why}"));
    }
}

fn table_ui(
    ui: &mut Ui,
    shows_all: bool,
    figures: [&Figures; 2],
    differences: Option<&[Difference]>,
) {
    let [before, now] = figures.map(|figures| {
        let each = METRICS.into_iter().map(|metric| figures.get(metric).map(|f| f.value));
        each.map(|value| value.unwrap_or(f64::NAN)).collect::<Vec<f64>>()
    });
    Grid::new("baseline figures").num_columns(5).spacing([7.0, 3.0]).show(ui, |ui| {
        quiet_ui(ui, "");
        for head in ["baseline", "this", "change", ""] {
            right_text_ui(ui, head, palette::TEXT_QUIET.color32());
        }
        ui.end_row();
        for (index, figure) in METRICS.iter().enumerate() {
            if !shows_all && figure.first_bound().is_none() {
                continue;
            }
            // There is little room beside four columns: the unit stands once.
            let name = format!("{}, {}", figure.short_label(), figure.unit());
            ui.label(RichText::new(name).color(palette::TEXT_QUIET.color32()));
            let text = |value: f64| decimal(value, 3);
            right_text_ui(ui, &text(before[index]), palette::BASELINE.color32());
            right_text_ui(ui, &text(now[index]), palette::TEXT_STRONG.color32());
            let change = signed(now[index] - before[index], 3);
            match differences.and_then(|all| all.get(index)) {
                None => {
                    right_text_ui(ui, &change, palette::TEXT_QUIET.color32());
                    quiet_ui(ui, "");
                }
                Some(difference) => {
                    let (word, color) = verdict(difference.verdict);
                    let about = with_minus_signs(&difference_words(difference, "the baseline"));
                    right_text_ui(ui, &change, color);
                    ui.label(RichText::new(word).color(color)).explained(about);
                }
            }
            ui.end_row();
        }
    });
}

/// A difference in a word, and its colour.
pub fn verdict(verdict: DifferenceVerdict) -> (&'static str, Color32) {
    match verdict {
        DifferenceVerdict::Better => ("better", palette::MET.color32()),
        DifferenceVerdict::Worse => ("worse", palette::MISSED.color32()),
        DifferenceVerdict::NotTold => ("not significant", palette::TEXT_QUIET.color32()),
        DifferenceVerdict::Negligible => ("negligible", palette::TEXT_QUIET.color32()),
        DifferenceVerdict::OtherRoom => ("another room", palette::TEXT_QUIET.color32()),
        DifferenceVerdict::RoomUnknown => ("room unsure", palette::TEXT_QUIET.color32()),
        DifferenceVerdict::Unsettled => ("undetermined", palette::TEXT_QUIET.color32()),
    }
}
