//! What is asked about body files and tool definitions.

use crate::document::body_files::BodyFileRequest;
use crate::document::meshes::name_of;
use crate::shell::dialogs::questions::{buttons_ui, text_ui};
use crate::shell::dialogs::{Dialog, DialogAnswer, title_ui};
use crate::widgets::basic::quiet_ui;
use bevy_egui::egui::Ui;
use trackwright_design::BodyRole;
use trackwright_formats::tool_definition::OnMismatch;

/// Draws such a question; `None` for every other dialog.
pub(crate) fn question_ui(ui: &mut Ui, dialog: &Dialog) -> Option<Option<DialogAnswer>> {
    let ask = DialogAnswer::BodyFile;
    let cancel = ("Cancel", DialogAnswer::Close);
    Some(match dialog {
        Dialog::ToolOrCrf { file } => {
            title_ui(ui, "What is this tool in the design?");
            text_ui(ui, file.display().to_string());
            let open = |body| ask(BodyFileRequest::open(body, file.clone()));
            let tool = ("The tool", open(BodyRole::Tool));
            buttons_ui(ui, &[tool, ("The CRF", open(BodyRole::Crf)), cancel])
        }
        Dialog::Checksum { body, file, text } => {
            title_ui(ui, "The checksum does not match");
            text_ui(ui, text.as_str());
            ui.add_space(4.0);
            quiet_ui(
                ui,
                "The file was changed by something that did not make its checksum new: any number \
                 in it may be another one. Saved as a definition, it gets the right one",
            );
            let anyway = BodyFileRequest::Open {
                body: *body,
                file: file.clone(),
                on_mismatch: OnMismatch::Accept,
            };
            // What Enter does changes nothing.
            let leave = ("Don't use it", DialogAnswer::Close);
            buttons_ui(ui, &[leave, ("Use it anyway", ask(anyway))])
        }
        Dialog::WriteBody { body, file, kind, notes, exists } => {
            let name = name_of(file);
            let verb = if *exists { "Replace" } else { "Save" };
            title_ui(ui, &format!("{verb} {name}?"));
            if *exists {
                text_ui(ui, format!("{} exists already", file.display()));
                ui.add_space(4.0);
            }
            text_ui(ui, format!("The {body} is written as {kind}:"));
            for note in notes {
                text_ui(ui, format!("• {note}"));
            }
            let write = BodyFileRequest::Write { body: *body, file: file.clone() };
            let write = (verb, ask(write));
            // Nobody writes over a maker's file by Enter alone.
            match exists {
                true => buttons_ui(ui, &[cancel, write]),
                false => buttons_ui(ui, &[write, cancel]),
            }
        }
        _ => return None,
    })
}
