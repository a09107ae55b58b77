//! Designs and rooms in one table: a row for every design in every room, a click opens it.

use crate::palette;
use crate::palette::ThemedColor;
use crate::widgets::basic::right_text_ui;
use crate::widgets::basic::{counted, quiet_ui, short_name, signed, warning_ui, with_unit};
use crate::widgets::tooltip::{Explain, button_ui, main_button_ui};
use crate::widgets::verdict::{verdict_mark, verdict_text};
use crate::workspaces::decide::panels::DecideView;
use crate::workspaces::decide::panels::baseline_ui::verdict;
use crate::workspaces::decide::requests::DecideRequest;
use crate::workspaces::decide::table::{AddedDesign, Compare, Compared};
use bevy_egui::egui::{Align, Button, Grid, Layout, ProgressBar, RichText, ScrollArea, Ui, vec2};
use std::path::Path;
use trackwright_formats::comparison_table::Names;
use trackwright_project::file_name;
use trackwright_simulation::Metric;
use trackwright_simulation::comparison::{
    Row, difference_words, notes, worst_place_words, worst_words,
};
use trackwright_simulation::figures::with_minus_signs;

/// Longest name that a row shows whole.
const MOST_CHARS: usize = 34;

/// Draws what is compared, and the table.
pub fn table_ui(ui: &mut Ui, view: &DecideView) -> Vec<DecideRequest> {
    let mut requests = Vec::new();
    ui.add_space(4.0);
    head_ui(ui, view, &mut requests);
    ui.add_space(4.0);
    let Some(compared) = &view.state.compared else {
        if view.state.comparing.is_none() {
            quiet_ui(
                ui,
                "Every design in every room of this one: figures, requirement, worst pose. This design and the \
                 baseline are in it; add others, then compare.",
            );
        }
        return requests;
    };
    // A decision is an edit that no figure depends on.
    let is_current = compared.generation == view.generation
        && compared.open.has_studies_of(view.document.design());
    ScrollArea::both().auto_shrink(false).show(ui, |ui| {
        if !is_current {
            warning_ui(ui, "This design has changed since; compare again");
        }
        for missing in &compared.missing {
            warning_ui(ui, missing);
        }
        rows_ui(ui, compared, &mut requests);
    });
    requests
}

fn head_ui(ui: &mut Ui, view: &DecideView, requests: &mut Vec<DecideRequest>) {
    ui.horizontal(|ui| {
        ui.label(RichText::new("Compare").strong().color(palette::TEXT_STRONG.color32()));
        ui.add_space(6.0);
        if button_ui(ui, "Add design…", "Adds another design to the table").clicked() {
            requests.push(DecideRequest::ShowAddDesign);
        }
        let built_in = ui.menu_button("Add built-in", |ui| {
            for name in trackwright_project::builtin_names() {
                if ui.button(name).clicked() {
                    requests.push(DecideRequest::AddBuiltIn(name));
                    ui.close();
                }
            }
        });
        built_in.response.explained("Adds a design that comes with the program");
        for added in &view.state.designs {
            let name = match added {
                AddedDesign::File(file) => file_stem(file),
                AddedDesign::BuiltIn(name) => (*name).to_owned(),
            };
            let name = short_name(&name, MOST_CHARS);
            let chip = ui
                .button(format!("{name}  ×"))
                .explained(format!("{added}\nTakes it out of the table"));
            if chip.clicked() {
                requests.push(DecideRequest::RemoveDesign(added.clone()));
            }
        }
        ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
            ui.add_space(4.0);
            match &view.state.comparing {
                None => {
                    let about = "Studies each design in each room; differences get intervals";
                    if main_button_ui(ui, "Compare", about).clicked() {
                        requests.push(DecideRequest::Compare);
                    }
                }
                Some(job) => {
                    if button_ui(ui, "Cancel", "Stops comparing").clicked() {
                        requests.push(DecideRequest::CancelCompare);
                    }
                    let bar = ProgressBar::new(job.progress() as f32);
                    ui.add_sized(vec2(140.0, 14.0), bar.show_percentage());
                }
            }
        });
    });
}

/// The heads of the columns, and whether numbers stand below them.
fn heads() -> Vec<(String, bool)> {
    let rms = Metric::TIP_RMS.short_label();
    let mut heads = vec![("design".to_owned(), false), ("room".to_owned(), false)];
    heads.extend(Metric::bounded().map(|metric| (metric.short_label(), true)));
    heads.extend([
        (format!("{rms}, 95\u{2009}%"), true),
        ("required".to_owned(), true),
        (format!("{rms} less the baseline's"), false),
        ("worst pose".to_owned(), false),
    ]);
    heads
}

fn rows_ui(ui: &mut Ui, compared: &Compared, requests: &mut Vec<DecideRequest>) {
    let heads = heads();
    Grid::new("compared").num_columns(heads.len()).spacing([14.0, 3.0]).striped(true).show(
        ui,
        |ui| {
            for (head, is_number) in &heads {
                match is_number {
                    false => quiet_ui(ui, head),
                    true => right_text_ui(ui, head, palette::TEXT_QUIET.color32()),
                };
            }
            ui.end_row();
            for (number, row) in compared.comparison.rows.iter().enumerate() {
                row_ui(ui, compared, (number, row), requests);
                ui.end_row();
            }
        },
    );
}

fn row_ui(
    ui: &mut Ui,
    compared: &Compared,
    (number, row): (usize, &Row),
    requests: &mut Vec<DecideRequest>,
) {
    let names = &compared.names;
    let what = compared.designs.get(row.design);
    let name = match what {
        Some(Compare::Open) => "this design".to_owned(),
        _ => short_name(Names::of(&names.designs, row.design), MOST_CHARS),
    };
    let color = match what {
        Some(Compare::Pinned) => palette::BASELINE.color32(),
        _ => palette::TEXT_STRONG.color32(),
    };
    let room = Names::of(&names.rooms, row.room);
    let about = about(what, compared.rooms.get(row.room).is_some_and(Option::is_some));
    let button = Button::new(RichText::new(name).color(color)).frame(false);
    let opened =
        ui.add(button).explained(format!("{}\n{about}", Names::of(&names.designs, row.design)));
    if opened.clicked() {
        requests.push(DecideRequest::OpenRow(number));
    }
    ui.label(short_name(room, MOST_CHARS)).explained(room);
    let measured = match &row.measured {
        Ok(measured) => measured,
        Err(why) => {
            ui.label(RichText::new("no figures").color(palette::MISSED.color32()))
                .explained(why.to_string());
            return;
        }
    };
    let figures = &measured.study.figures;
    for figure in figures.bounded() {
        let text = with_unit(&figure.value_text(3), figure.metric.unit());
        right_text_ui(ui, &text, palette::TEXT.color32());
    }
    let rms = figures.get(Metric::TIP_RMS);
    let interval = rms.and_then(|figure| figure.interval_text(2));
    let interval =
        interval.map(|ends| with_unit(&ends, Metric::TIP_RMS.unit())).unwrap_or_default();
    right_text_ui(ui, &interval, palette::TEXT.color32());
    let (word, color) = match measured.verdict() {
        None => ("none".to_owned(), palette::TEXT_QUIET.color32()),
        Some(verdict) => (verdict_text(verdict), verdict_mark(verdict).1),
    };
    let each = figures.bounded().map(|f| format!("{} {}", f.metric.label(), f.words(4, " ")));
    right_text_ui(ui, &word, color).explained(each.collect::<Vec<_>>().join("\n"));
    let rms = (row.against_baseline.as_ref()).and_then(|against| against.differences.first());
    match rms {
        None => {
            quiet_ui(ui, if row.design == compared.comparison.baseline { "baseline" } else { "" });
        }
        Some(difference) => {
            let (word, color) = verdict(difference.verdict);
            let text = format!("{} {word}", with_unit(&signed(difference.difference, 3), "mm"));
            let baseline = Names::of(&names.designs, compared.comparison.baseline);
            ui.label(RichText::new(text).color(color))
                .explained(with_minus_signs(&difference_words(difference, baseline)));
        }
    }
    // Its size is that of the largest tip error.
    let place = with_minus_signs(&worst_place_words(measured));
    let worst = with_minus_signs(&worst_words(measured));
    let notes = notes(measured, row.against_baseline.as_ref());
    let text = match notes.is_empty() {
        true => place,
        false => format!("{place}  ({})", counted(notes.len(), "remark", "remarks")),
    };
    ui.label(RichText::new(text).color(palette::TEXT_QUIET.color32()))
        .explained([&[worst], notes.as_slice()].concat().join("\n"));
}

/// What a click on a row does.
fn about(what: Option<&Compare>, is_other_room: bool) -> &'static str {
    match (what, is_other_room) {
        (Some(Compare::Open), false) => "Shows its worst trial in the Study workspace",
        (Some(Compare::Open), true) => "Puts the design into this room",
        (Some(Compare::Pinned), _) => "Opens the baseline's file",
        (_, false) => "Opens this design",
        (_, true) => "Opens this design and puts it into this room",
    }
}

/// `shaver` of `folder/shaver.design.ron`.
fn file_stem(file: &Path) -> String {
    let name = file_name(file);
    let stem = name.strip_suffix(".ron").unwrap_or(&name);
    stem.strip_suffix(".design").unwrap_or(stem).to_owned()
}
