//! The panel in which slides are made.

use crate::widgets::basic::{Row, main_button, quiet_ui, row_ui, section_ui, warning_ui};
use crate::widgets::tooltip::{Explain, button_ui, checkbox_ui};
use crate::workspaces::present::panels::StageView;
use crate::workspaces::present::requests::PresentRequest;
use bevy_egui::egui::Ui;
use trackwright_design::{Slide, SlideFigure};

/// Draws the slides, and what the shown one has.
pub fn slides_ui(ui: &mut Ui, view: &StageView) -> Vec<PresentRequest> {
    let (slide, index, count) = view.slide();
    let slides = &view.document.design().slides;
    let mut requests = Vec::new();
    section_ui(ui, "Slides");
    ui.scope(|ui| {
        ui.spacing_mut().item_spacing.y = 0.0;
        for (number, slide) in slides.iter().enumerate() {
            if row_ui(ui, &row_of(slide, number == index)).clicked() {
                requests.push(PresentRequest::Show(number));
            }
        }
        // A row for the first slide before there is one: what is below it must not move when the
        // first change makes it, between the press and the release of a click.
        if slides.is_empty() {
            row_ui(ui, &Row { note: "not made yet", ..row_of(&slide, true) });
        }
    });
    ui.horizontal(|ui| {
        let about = "Another slide after this one, looked at as now";
        if ui.button("Add").explained(about).clicked() {
            requests.push(PresentRequest::Add);
        }
        ui.add_enabled_ui(!slides.is_empty(), |ui| {
            if button_ui(ui, "Remove", "Takes the slide out of the design").clicked() {
                requests.push(PresentRequest::Remove);
            }
        });
        for (sign, by, is_possible) in [("⏶", -1, index > 0), ("⏷", 1, index + 1 < count)] {
            ui.add_enabled_ui(is_possible && !slides.is_empty(), |ui| {
                if ui.button(sign).explained("Moves it among the slides").clicked() {
                    requests.push(PresentRequest::Move(by));
                }
            });
        }
    });
    section_ui(ui, "View");
    let is_kept = slides.get(index).is_some_and(|slide| is_looked_at_so(view, slide));
    ui.horizontal(|ui| {
        ui.add_enabled_ui(!is_kept, |ui| {
            let about = "The slide is looked at as now: camera, layers, slice, magnification";
            if ui.add(main_button("Keep this view")).explained(about).clicked() {
                requests.push(PresentRequest::KeepView);
            }
            if ui.button("Back").explained("As the slide is looked at").clicked() {
                requests.push(PresentRequest::BackToView);
            }
        });
    });
    for missing in &slide.view.missing_layers(view.document.design(), view.environment, true) {
        warning_ui(ui, &format!("Shown without the {missing}."));
    }
    section_ui(ui, "Figures");
    for figure in SlideFigure::ALL {
        let mut is_on = slide.figures.contains(&figure);
        let about = "Shows the figure on the slide, in words for people who do not design";
        if checkbox_ui(ui, &mut is_on, figure.name(), about).changed() {
            requests.push(PresentRequest::SetFigure(figure, is_on));
        }
    }
    ui.add_space(6.0);
    if ui.button("Done").explained("As others see it").clicked() {
        requests.push(PresentRequest::ToggleEditing);
    }
    if slides.is_empty() {
        ui.add_space(6.0);
        quiet_ui(
            ui,
            "The design has no slides yet: it is shown with this one until the first is made.",
        );
    }
    requests
}

fn is_looked_at_so(view: &StageView, slide: &Slide) -> bool {
    let now = view.document.view();
    match slide.view.camera {
        Some(_) => slide.view == *now,
        None => false,
    }
}

fn row_of(slide: &Slide, is_selected: bool) -> Row<'_> {
    let is_named = !slide.title.trim().is_empty();
    Row { label: if is_named { &slide.title } else { "untitled" }, is_selected, ..Row::default() }
}
