//! Dialogs about meshes, body files and tool definitions.

use crate::document::requests::BodyFileRequest;
use crate::document::requests::MeshRequest;
use crate::shell::dialogs::file_dialog::{FileDialog, FileKind};
use crate::shell::dialogs::{Dialog, DialogAnswer, buttons_ui, text_ui, title_ui};
use crate::widgets::basic::{count, length, quiet_ui, with_unit};
use bevy_egui::egui::{Button, Ui, vec2};
use std::path::{Path, PathBuf};
use trackwright_design::BodyRole;
use trackwright_formats::tool_definition::OnMismatch;
use trackwright_geometry::mesh_report::UnitSuggestion;
use trackwright_project::{MeshOwner, file_name};

/// Dialogs about meshes.
#[derive(Clone, Debug, PartialEq)]
#[expect(clippy::large_enum_variant, reason = "one dialog is open at a time")]
pub enum MeshDialog {
    /// Chooses a mesh for a body, the anatomy or a metal object.
    Load { files: FileDialog, whose: MeshOwner },
    /// A mesh was dropped with no body selected.
    Whose { file: PathBuf, has_crf: bool },
    /// A mesh of a size that no instrument has.
    Unit { whose: MeshOwner, file: PathBuf, sizes: UnitSuggestion },
}

impl MeshDialog {
    pub fn load(folder: PathBuf, whose: impl Into<MeshOwner>) -> Self {
        let whose = whose.into();
        let title = match whose {
            MeshOwner::Anatomy(None) => "Add a mesh as anatomy".to_owned(),
            MeshOwner::NewMetal => "Add a closed mesh as metal".to_owned(),
            MeshOwner::NewTool => "Begin a design with a mesh as its tool".to_owned(),
            _ => format!("Load a mesh for the {whose}"),
        };
        let files = FileDialog::new(FileKind::Mesh, folder, "").titled(&title, "Load");
        Self::Load { files, whose }
    }
}

impl Dialog for MeshDialog {
    type Request = MeshRequest;

    fn name(&self) -> &'static str {
        match self {
            Self::Load { .. } => "load mesh",
            Self::Whose { .. } => "whose mesh",
            Self::Unit { .. } => "mesh unit",
        }
    }

    fn files(&mut self) -> Option<&mut FileDialog> {
        match self {
            Self::Load { files, .. } => Some(files),
            _ => None,
        }
    }

    fn ui(&mut self, ui: &mut Ui) -> Option<DialogAnswer<Self>> {
        match self {
            Self::Load { files, whose } => {
                files.ui(ui, |file, _| DialogAnswer::Request(MeshRequest::load(*whose, file)))
            }
            Self::Whose { file, has_crf } => {
                title_ui(ui, "Whose mesh is this?");
                text_ui(ui, file.display().to_string());
                ui.add_space(4.0);
                quiet_ui(ui, "Anatomy is shown translucent beside them; no figure depends on it");
                let load = |whose| DialogAnswer::Request(MeshRequest::load(whose, file.clone()));
                let tool = ("The tool's", load(BodyRole::Tool.into()));
                let crf = ("The CRF's", load(BodyRole::Crf.into()));
                let anatomy = ("Anatomy", load(MeshOwner::Anatomy(None)));
                let new = ("A new tool's", load(MeshOwner::NewTool));
                let cancel = ("Cancel", DialogAnswer::Close);
                match has_crf {
                    true => buttons_ui(ui, &[tool, crf, anatomy, new, cancel]),
                    false => buttons_ui(ui, &[tool, anatomy, new, cancel]),
                }
            }
            Self::Unit { whose, file, sizes } => unit_ui(ui, *whose, file, sizes),
        }
    }
}

/// The sizes that a mesh would have, one below the other, each a button.
fn unit_ui(
    ui: &mut Ui,
    whose: MeshOwner,
    file: &Path,
    sizes: &UnitSuggestion,
) -> Option<DialogAnswer<MeshDialog>> {
    title_ui(ui, "Which unit is this mesh in?");
    text_ui(
        ui,
        format!(
            "{} is {} long if it is in {}. How long should the {whose} be?",
            file_name(file),
            size_text(sizes.found_mm),
            sizes.read_in,
        ),
    );
    ui.add_space(8.0);
    let mut answer = None;
    for (number, (unit, size_mm)) in sizes.choices().into_iter().enumerate() {
        let text = format!("in {unit}: {}", size_text(size_mm));
        let button = Button::new(text).min_size(vec2(ui.available_width(), 26.0));
        let response = ui.add(button);
        if number == 0 && ui.memory(|m| m.focused().is_none()) {
            response.request_focus();
        }
        if response.clicked() {
            answer = Some(DialogAnswer::Request(MeshRequest::Load {
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

/// Dialogs about body files and tool definitions.
#[derive(Clone, Debug, PartialEq)]
pub enum BodyDialog {
    /// Chooses a file to be the tool or the CRF.
    Open { files: FileDialog, body: BodyRole },
    /// Chooses where a body is written, and as what.
    Save { files: FileDialog, body: BodyRole },
    /// A tool definition was dropped on a design of two bodies.
    ToolOrCrf { file: PathBuf },
    /// An image whose bytes are not those that its checksum was made of.
    Checksum { body: BodyRole, file: PathBuf, text: String },
    /// What is lost when a body is written, and what else is written over.
    Write {
        body: BodyRole,
        file: PathBuf,
        /// With its article.
        kind: &'static str,
        notes: Vec<String>,
        exists: bool,
    },
}

impl BodyDialog {
    pub fn open(folder: PathBuf, body: BodyRole) -> Self {
        let files = FileDialog::new(FileKind::Body, folder, "");
        let title = format!("Open a tool definition as the {body}");
        Self::Open { files: files.titled(&title, "Open"), body }
    }

    pub fn save(folder: PathBuf, name: &str, body: BodyRole) -> Self {
        let files = FileDialog::new(FileKind::Body, folder, name);
        let title = format!("Save the {body} as a tool definition");
        Self::Save { files: files.titled(&title, "Save").saving(), body }
    }
}

impl Dialog for BodyDialog {
    type Request = BodyFileRequest;

    fn name(&self) -> &'static str {
        match self {
            Self::Open { .. } => "open tool definition",
            Self::Save { .. } => "save tool definition",
            Self::ToolOrCrf { .. } => "tool or CRF",
            Self::Checksum { .. } => "checksum",
            Self::Write { .. } => "write tool definition",
        }
    }

    fn files(&mut self) -> Option<&mut FileDialog> {
        match self {
            Self::Open { files, .. } | Self::Save { files, .. } => Some(files),
            _ => None,
        }
    }

    fn ui(&mut self, ui: &mut Ui) -> Option<DialogAnswer<Self>> {
        let request = DialogAnswer::Request;
        let cancel = ("Cancel", DialogAnswer::Close);
        match self {
            Self::Open { files, body } => {
                files.ui(ui, |file, _| request(BodyFileRequest::open(*body, file)))
            }
            Self::Save { files, body } => {
                files.ui(ui, |file, _| request(BodyFileRequest::Save { body: *body, file }))
            }
            Self::ToolOrCrf { file } => {
                title_ui(ui, "What is this tool in the design?");
                text_ui(ui, file.display().to_string());
                let open = |body| request(BodyFileRequest::open(body, file.clone()));
                let tool = ("The tool", open(BodyRole::Tool));
                buttons_ui(ui, &[tool, ("The CRF", open(BodyRole::Crf)), cancel])
            }
            Self::Checksum { body, file, text } => {
                title_ui(ui, "The checksum does not match");
                text_ui(ui, text.as_str());
                ui.add_space(4.0);
                quiet_ui(
                    ui,
                    "The file was changed by something that did not make its checksum new: any \
                     number in it may be another one. Saved as a definition, it gets the right one",
                );
                let anyway = BodyFileRequest::Open {
                    body: *body,
                    file: file.clone(),
                    on_mismatch: OnMismatch::Accept,
                };
                // What Enter does changes nothing.
                let leave = ("Don't use it", DialogAnswer::Close);
                buttons_ui(ui, &[leave, ("Use it anyway", request(anyway))])
            }
            Self::Write { body, file, kind, notes, exists } => {
                let name = file_name(file);
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
                let write = (verb, request(write));
                // Nobody writes over a maker's file by Enter alone.
                match exists {
                    true => buttons_ui(ui, &[cancel, write]),
                    false => buttons_ui(ui, &[write, cancel]),
                }
            }
        }
    }
}
