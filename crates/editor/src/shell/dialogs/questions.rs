//! What is asked, and what could not be done, in words.

use crate::document::meshes::MeshRequest;
use crate::document::requests::{FileRequest, SharedChoice};
use crate::shell::dialogs::{Dialog, DialogAnswer, title_ui};
use crate::widgets::basic::{count, length, quiet_ui, with_unit};
use crate::workspaces::field::FieldRequest;
use crate::workspaces::field::desk::TableRole;
use bevy_egui::egui::{self, Align, Layout, Ui, vec2};
use std::path::{Path, PathBuf};
use std::time::Duration;
use trackwright_design::BodyRole;
use trackwright_formats::recovery_file::RecoveryOrigin;
use trackwright_geometry::mesh_report::UnitSuggestion;
use trackwright_project::{
    ChangedFile, FileChange, Leftover, MeshOwner, SharedBody, Starter, StoreError,
};

impl Dialog {
    /// What went wrong, in the words of the command line.
    pub fn error(title: &str, error: &dyn std::error::Error) -> Self {
        let mut text = error.to_string();
        let mut source = error.source();
        while let Some(cause) = source {
            let cause_text = cause.to_string();
            // A transparent cause has been said already.
            if !text.contains(&cause_text) {
                text = format!("{text}: {cause_text}");
            }
            source = cause.source();
        }
        Self::Error { title: title.to_owned(), text }
    }

    /// What is open is not lost by it, and that is said.
    pub fn not_saved(error: &StoreError) -> Self {
        Self::NotSaved { text: error.to_string() }
    }

    pub fn unsaved(file: String, then: FileRequest) -> Self {
        Self::Unsaved { file, then }
    }

    /// Offers the first of what crashed sessions left.
    pub fn recover(leftovers: &[Leftover]) -> Option<Self> {
        let first = leftovers.first()?;
        Some(match first.content() {
            Ok(content) => {
                let from = match &content.origin {
                    RecoveryOrigin::BuiltIn(name) if is_new(name) => {
                        "a new design, never saved".to_owned()
                    }
                    RecoveryOrigin::BuiltIn(name) => format!("the built-in design {name}"),
                    RecoveryOrigin::File(file) => file.display().to_string(),
                };
                let age = content.written().elapsed().ok().map(ago);
                Self::Recover {
                    text: format!(
                        "The last session ended without saving changes of {:?} ({from}), kept {}.",
                        content.design.name,
                        age.unwrap_or_else(|| "just now".to_owned()),
                    ),
                    is_usable: true,
                }
            }
            Err(error) => Self::Recover {
                text: format!("A recovery file cannot be read: {error}"),
                is_usable: false,
            },
        })
    }

    /// What somebody else changed.
    pub fn changed_on_disk(changes: &[ChangedFile], is_saving: bool) -> Self {
        let line = |changed: &ChangedFile| {
            let what = match changed.change {
                FileChange::Content => "was changed",
                FileChange::Gone => "is gone",
            };
            format!("{} ({}) {what}", changed.file.display(), changed.part)
        };
        Self::ChangedOnDisk { lines: changes.iter().map(line).collect(), is_saving }
    }

    /// Names the designs that a save would change too.
    pub fn shared_bodies(shared: &[SharedBody]) -> Self {
        let name = |path: &PathBuf| {
            path.file_name().map_or_else(
                || path.display().to_string(),
                |name| name.to_string_lossy().into_owned(),
            )
        };
        let lines = shared
            .iter()
            .map(|body| {
                let designs: Vec<String> = body.designs.iter().map(name).collect();
                format!("{} is also used by {}", name(&body.file), designs.join(", "))
            })
            .collect();
        Self::SharedBodies { lines }
    }
}

/// Draws a question; nothing of dialogs that choose files, nor of those in `body_questions`.
pub(crate) fn question_ui(ui: &mut Ui, dialog: &Dialog) -> Option<DialogAnswer> {
    let request = DialogAnswer::Request;
    let field = DialogAnswer::Field;
    let cancel = ("Cancel", DialogAnswer::Close);
    match dialog {
        Dialog::Error { title, text } => {
            title_ui(ui, title);
            ui.add(egui::Label::new(text.as_str()).wrap().selectable(true));
            buttons_ui(ui, &[("OK", DialogAnswer::Close)])
        }
        Dialog::NotSaved { text } => {
            title_ui(ui, "The design cannot be saved");
            ui.add(egui::Label::new(text.as_str()).wrap().selectable(true));
            ui.add_space(4.0);
            quiet_ui(
                ui,
                "Nothing is lost: every change is still open here, and can be saved elsewhere",
            );
            let elsewhere = ("Save as…", request(FileRequest::ShowSaveAs));
            buttons_ui(ui, &[elsewhere, ("Close", DialogAnswer::Close)])
        }
        Dialog::Unsaved { file, then } => {
            title_ui(ui, "Save changes?");
            text_ui(ui, format!("{file} has changes that are not saved"));
            let then = Box::new(then.clone());
            let save = request(FileRequest::SaveThen(then.clone()));
            let discard = request(FileRequest::Discard(then));
            buttons_ui(ui, &[("Save", save), ("Don't save", discard), cancel])
        }
        Dialog::SharedBodies { lines } => {
            title_ui(ui, "Other designs use a body that changed");
            lines_ui(ui, lines);
            let save = |choice| request(FileRequest::SaveShared(choice));
            let copy = ("Save a copy of the body", save(SharedChoice::Copy));
            let all = ("Change it for all", save(SharedChoice::Overwrite));
            buttons_ui(ui, &[copy, all, cancel])
        }
        Dialog::Recover { text, is_usable } => {
            title_ui(ui, "Recover unsaved changes?");
            text_ui(ui, text.as_str());
            let drop = ("Give them up", request(FileRequest::DropLeftover));
            let later = ("Ask again next time", DialogAnswer::Close);
            match is_usable {
                true => {
                    let recover = ("Recover", request(FileRequest::Recover));
                    buttons_ui(ui, &[recover, drop, later])
                }
                false => buttons_ui(ui, &[later, drop]),
            }
        }
        Dialog::ChangedOnDisk { lines, is_saving } => {
            title_ui(ui, "Somebody else changed files of this design");
            lines_ui(ui, lines);
            match is_saving {
                true => {
                    let drop = FileRequest::Discard(Box::new(FileRequest::Reload));
                    let elsewhere = ("Save as…", request(FileRequest::ShowSaveAs));
                    let over = ("Write over them", request(FileRequest::SaveOver));
                    let drop = ("Drop my changes", request(drop));
                    buttons_ui(ui, &[elsewhere, cancel, drop, over])
                }
                false => {
                    let keep = ("Keep what is open", request(FileRequest::KeepMine));
                    buttons_ui(ui, &[("Read them again", request(FileRequest::Reload)), keep])
                }
            }
        }
        Dialog::Overwrite { path, then } => {
            title_ui(ui, "Replace the file?");
            text_ui(ui, format!("{} exists already", path.display()));
            buttons_ui(ui, &[("Replace", request(then.clone())), cancel])
        }
        Dialog::WhichTable { file } => {
            title_ui(ui, "What are these measurements for?");
            text_ui(ui, file.display().to_string());
            let open = |role| field(FieldRequest::Open(role, file.clone()));
            let judge = ("To judge the fit on", open(TableRole::HeldOut));
            let fit = ("To fit, instead", open(TableRole::Training));
            buttons_ui(ui, &[judge, fit, cancel])
        }
        Dialog::ReplaceRoom { path, room } => {
            title_ui(ui, "Replace the room's file?");
            let text = format!(
                "{} exists already; designs that refer to it would be in another room",
                path.display()
            );
            text_ui(ui, text);
            let save = field(FieldRequest::Save(room.clone(), path.clone()));
            buttons_ui(ui, &[("Replace", save), cancel])
        }
        Dialog::New => {
            title_ui(ui, "New design");
            text_ui(
                ui,
                "A tool with two 5-DOF sensors in the built-in room, to be changed from there; \
                 on a CRF with three, where errors are wanted relative to the patient",
            );
            let begin = |starter| request(FileRequest::New(starter));
            let on_crf = ("Tool and CRF", begin(Starter::ToolOnCrf));
            let alone = ("Tool alone", begin(Starter::Tool));
            buttons_ui(ui, &[on_crf, alone, cancel])
        }
        Dialog::WhoseMesh { file, has_crf } => {
            title_ui(ui, "Whose mesh is this?");
            text_ui(ui, file.display().to_string());
            ui.add_space(4.0);
            quiet_ui(ui, "Anatomy is shown translucent beside them; no figure depends on it");
            let load = |whose| DialogAnswer::Mesh(MeshRequest::load(whose, file.clone()));
            let tool = ("The tool's", load(BodyRole::Tool.into()));
            let crf = ("The CRF's", load(BodyRole::Crf.into()));
            let anatomy = ("Anatomy", load(MeshOwner::Anatomy(None)));
            match has_crf {
                true => buttons_ui(ui, &[tool, crf, anatomy, cancel]),
                false => buttons_ui(ui, &[tool, anatomy, cancel]),
            }
        }
        Dialog::MeshUnit { whose, file, sizes } => mesh_unit_ui(ui, *whose, file, sizes),
        Dialog::Open(_)
        | Dialog::SaveAs(_)
        | Dialog::ReadInput(_)
        | Dialog::WriteLog(_)
        | Dialog::Record(_)
        | Dialog::Report(_)
        | Dialog::PinDesign(_)
        | Dialog::AddDesign(_)
        | Dialog::OpenRecorded { .. }
        | Dialog::Table { .. }
        | Dialog::SaveRoom { .. }
        | Dialog::Mesh { .. }
        | Dialog::OpenBody { .. }
        | Dialog::SaveBody { .. }
        | Dialog::ToolOrCrf { .. }
        | Dialog::Checksum { .. }
        | Dialog::WriteBody { .. } => None,
    }
}

/// The sizes that a mesh would have, one below the other, each a button.
fn mesh_unit_ui(
    ui: &mut Ui,
    whose: MeshOwner,
    file: &Path,
    sizes: &UnitSuggestion,
) -> Option<DialogAnswer> {
    title_ui(ui, "Which unit is this mesh in?");
    let name = file.file_name().unwrap_or(file.as_os_str());
    text_ui(
        ui,
        format!(
            "{} is {} long if it is in {}. How long should the {whose} be?",
            name.to_string_lossy(),
            size_text(sizes.found_mm),
            sizes.read_in,
        ),
    );
    ui.add_space(8.0);
    let mut answer = None;
    for (number, (unit, size_mm)) in sizes.choices().into_iter().enumerate() {
        let text = format!("in {unit}: {}", size_text(size_mm));
        let button = egui::Button::new(text).min_size(vec2(ui.available_width(), 26.0));
        let response = ui.add(button);
        if number == 0 && ui.memory(|m| m.focused().is_none()) {
            response.request_focus();
        }
        if response.clicked() {
            answer = Some(DialogAnswer::Mesh(MeshRequest::Load {
                whose,
                file: file.to_owned(),
                unit: Some(unit),
            }));
        }
    }
    answer.or(buttons_ui(ui, &[("Cancel", DialogAnswer::Close)]))
}

/// `2,000 mm`, and below that two decimals.
fn size_text(size_mm: f64) -> String {
    if (1000.0..1e15).contains(&size_mm) {
        with_unit(&count(size_mm.round() as usize), "mm")
    } else {
        length(size_mm)
    }
}

fn is_new(builtin: &str) -> bool {
    Starter::ALL.iter().any(|starter| starter.name() == builtin)
}

pub(crate) fn text_ui(ui: &mut Ui, text: impl Into<String>) {
    ui.add(egui::Label::new(text.into()).wrap());
}

fn lines_ui(ui: &mut Ui, lines: &[String]) {
    for line in lines {
        text_ui(ui, line.as_str());
    }
}

/// `3 minutes ago`.
fn ago(age: Duration) -> String {
    let (count, unit) = match age.as_secs() {
        0..60 => return "less than a minute ago".to_owned(),
        s @ 60..3600 => (s / 60, "minute"),
        s @ 3600..86_400 => (s / 3600, "hour"),
        s => (s / 86_400, "day"),
    };
    let plural = if count == 1 { "" } else { "s" };
    format!("{count} {unit}{plural} ago")
}

/// Buttons at the right, the first the one that Enter presses.
pub(crate) fn buttons_ui(ui: &mut Ui, buttons: &[(&str, DialogAnswer)]) -> Option<DialogAnswer> {
    let mut answer = None;
    ui.add_space(12.0);
    ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
        for (index, (text, then)) in buttons.iter().enumerate().rev() {
            let response = ui.button(*text);
            let is_default = index == 0;
            if is_default && ui.memory(|m| m.focused().is_none()) {
                response.request_focus();
            }
            if response.clicked() {
                answer = Some(then.clone());
            }
        }
    });
    answer
}
