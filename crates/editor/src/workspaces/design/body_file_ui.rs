//! The maker's definition that the selected body came from: its contents, and ways to another one.

use crate::document::body_files::BodyLoading;
use crate::document::requests::BodyFileRequest;
use crate::widgets::basic::{quiet_ui, section_ui, warning_ui, with_unit};
use crate::widgets::tooltip::{Explain, button_ui};
use crate::workspaces::design::actions::DesignAction;
use bevy_egui::egui::{self, Align, CollapsingHeader, Label, Layout, TextStyle, Ui};
use std::path::Path;
use trackwright_design::BodyRole;
use trackwright_design::definition::DefinitionFile;
use trackwright_formats::tool_definition::{Fact, ToolDefinition};
use trackwright_project::{World, file_name};

/// What the section shows.
pub struct BodyFileView<'a> {
    pub body: BodyRole,
    /// `None` where the body is from no maker's file.
    pub definition: Option<&'a DefinitionFile>,
    /// The file that is being read for this body.
    pub reading: Option<&'a Path>,
}

impl<'a> BodyFileView<'a> {
    /// `None` where there is no such body.
    pub fn of(world: &'a World, body: BodyRole, loading: &'a BodyLoading) -> Option<Self> {
        let own = world.document.design().body(body)?;
        Some(Self {
            body,
            definition: own.definition.as_deref(),
            reading: loading.of().filter(|(of, _)| *of == body).map(|(_, file)| file),
        })
    }
}

/// Draws the section.
pub fn body_file_ui(ui: &mut Ui, view: &BodyFileView) -> Vec<DesignAction> {
    let mut actions = Vec::new();
    section_ui(ui, "Tool definition");
    match view.definition {
        Some(definition) => definition_ui(ui, definition),
        None => {
            quiet_ui(ui, "none: the body came from no maker's file");
        }
    }
    ui.add_space(4.0);
    ui.horizontal(|ui| buttons_ui(ui, view, &mut actions));
    actions
}

fn definition_ui(ui: &mut Ui, file: &DefinitionFile) {
    let kind = file.kind.name();
    let definition = ToolDefinition::carried(Some(file));
    CollapsingHeader::new(format!("From {kind}")).id_salt("tool definition").show_unindented(
        ui,
        |ui| {
            for fact in definition.iter().flat_map(ToolDefinition::facts) {
                fact_ui(ui, &fact);
            }
            quiet_ui(
                ui,
                "as it was read: saved as a definition again, the sensors are as they are now",
            );
        },
    );
    if let Some(doubt) = definition.as_ref().and_then(ToolDefinition::doubt) {
        warning_ui(ui, &doubt);
    }
}

/// What at the left and its value at the right; below it, where there is no room beside it.
fn fact_ui(ui: &mut Ui, fact: &Fact) {
    let value = with_unit(&fact.value, fact.unit);
    let font = TextStyle::Body.resolve(ui.style());
    let width = |text: &str| {
        let galley =
            ui.painter().layout_no_wrap(text.to_owned(), font.clone(), egui::Color32::PLACEHOLDER);
        galley.size().x
    };
    let needed = width(fact.what) + 2.0 * ui.spacing().item_spacing.x + width(&value);
    if needed <= ui.available_width() {
        ui.horizontal(|ui| {
            ui.label(fact.what);
            crate::workspaces::design::rows::right_ui(ui, |ui| ui.label(value));
        });
    } else {
        ui.label(fact.what);
        ui.with_layout(Layout::top_down(Align::Max), |ui| {
            ui.add(Label::new(value).wrap());
        });
    }
}

fn buttons_ui(ui: &mut Ui, view: &BodyFileView, actions: &mut Vec<DesignAction>) {
    if let Some(file) = view.reading {
        ui.label(format!("Reading {}…", file_name(file)));
        if button_ui(ui, "Cancel", "Stops reading the file").clicked() {
            actions.push(DesignAction::BodyFile(BodyFileRequest::GiveUp));
        }
        return;
    }
    let body = view.body;
    let open = ui.button("Open definition…").explained(format!(
        "Uses another file as the {body}: an NDI ROM (.rom, .tool), an Atracsys .ini, a SAW \
             .json or a .body.ron; one can also be dropped onto the window"
    ));
    if open.clicked() {
        actions.push(DesignAction::BodyFile(BodyFileRequest::ShowOpen(body)));
    }
    let save = ui.button("Save definition as…").explained(format!(
        "Writes the {body} as a file of one of these kinds; what it cannot hold is listed first"
    ));
    if save.clicked() {
        actions.push(DesignAction::BodyFile(BodyFileRequest::ShowSave(body)));
    }
}
