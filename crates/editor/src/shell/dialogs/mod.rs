//! Questions and errors that stand before everything else: open, save as, unsaved changes,
//! bodies that other designs use too, measurements and rooms, and what could not be done.

pub mod body_questions;
pub mod file_dialog;
pub mod folder;
pub mod questions;

use crate::document::body_files::BodyFileRequest;
use crate::document::meshes::MeshRequest;
use crate::document::requests::FileRequest;
use crate::palette;
use crate::palette::ThemedColor;
use crate::shell::dialogs::file_dialog::{FileDialog, FileKind, Wish};
use crate::shell::dialogs::file_dialog::{file_ui, write_to};
use crate::shell::layout::UiSystems;
use crate::workspaces::decide::DecideRequest;
use crate::workspaces::field::desk::TableRole;
use crate::workspaces::field::{FieldRequest, RoomToSave};
use crate::workspaces::live::LiveRequest;
use bevy::ecs::system::SystemParam;
use bevy::prelude::*;
use bevy::window::RequestRedraw;
use bevy_egui::egui::{self, Id, RichText, Ui};
use bevy_egui::{EguiContexts, EguiPrimaryContextPass};
use std::path::PathBuf;
use trackwright_design::BodyRole;
use trackwright_geometry::mesh_report::UnitSuggestion;
use trackwright_project::MeshOwner;

/// The dialog that is open, if any.
#[derive(Resource, Default)]
pub struct Dialogs {
    pub current: Option<Dialog>,
}

impl Dialogs {
    pub fn show(&mut self, dialog: Dialog) {
        self.current = Some(dialog);
    }
}

/// Owns the dialog that is open.
pub struct DialogsPlugin;

impl Plugin for DialogsPlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<Dialogs>();
    }
}

pub(crate) fn plugin(app: &mut App) {
    app.add_systems(EguiPrimaryContextPass, dialogs.in_set(UiSystems::Dialogs));
}

/// Where what a dialog came to goes.
#[derive(SystemParam)]
struct Asked<'w> {
    files: MessageWriter<'w, FileRequest>,
    fields: MessageWriter<'w, FieldRequest>,
    meshes: MessageWriter<'w, MeshRequest>,
    live: MessageWriter<'w, LiveRequest>,
    body_files: MessageWriter<'w, BodyFileRequest>,
    decide: MessageWriter<'w, DecideRequest>,
}

fn dialogs(
    mut contexts: EguiContexts,
    mut dialogs: ResMut<Dialogs>,
    mut asked: Asked,
    mut redraw: MessageWriter<RequestRedraw>,
) -> Result {
    let ctx = contexts.ctx_mut()?;
    // Writing to the resource would mark it as changed in every frame.
    let open = dialogs.bypass_change_detection();
    let Some(dialog) = &mut open.current else {
        return Ok(());
    };
    // egui keeps the size of what it has seen: a short question is no list of files.
    let kind = std::mem::discriminant(&*dialog);
    let modal = egui::Modal::new(Id::new(("dialog", kind)))
        .backdrop_color(palette::SHADOW.color32_alpha(140))
        .show(ctx, |ui| dialog_ui(ui, dialog));
    let is_closed = modal.should_close();
    let answer = match modal.inner {
        None if is_closed => Some(DialogAnswer::Close),
        answer => answer,
    };
    let Some(answer) = answer else { return Ok(()) };
    redraw.write(RequestRedraw);
    open.current = match answer {
        DialogAnswer::Close => None,
        DialogAnswer::Become(dialog) => Some(dialog),
        DialogAnswer::Request(request) => {
            asked.files.write(request);
            None
        }
        DialogAnswer::Mesh(request) => {
            asked.meshes.write(request);
            None
        }
        DialogAnswer::BodyFile(request) => {
            asked.body_files.write(request);
            None
        }
        DialogAnswer::Field(request) => {
            asked.fields.write(request);
            None
        }
        DialogAnswer::Decide(request) => {
            asked.decide.write(request);
            None
        }
        DialogAnswer::Live(request) => {
            asked.live.write(request);
            None
        }
    };
    Ok(())
}

/// A dialog and what was typed into it so far.
#[derive(Clone, Debug, PartialEq)]
pub enum Dialog {
    Open(FileDialog),
    /// Chooses a design to be held against.
    PinDesign(FileDialog),
    /// Chooses a recording of the built tool, or of its CRF.
    OpenRecorded {
        files: FileDialog,
        body: BodyRole,
    },
    /// Chooses a design for the table.
    AddDesign(FileDialog),
    SaveAs(FileDialog),
    /// Chooses a table of poses.
    ReadInput(FileDialog),
    /// Chooses where a report goes.
    Report(FileDialog),
    /// Chooses where a log goes.
    WriteLog(FileDialog),
    /// Chooses where a recording goes.
    Record(FileDialog),
    Error {
        title: String,
        text: String,
    },
    Unsaved {
        file: String,
        then: FileRequest,
    },
    SharedBodies {
        lines: Vec<String>,
    },
    Overwrite {
        path: PathBuf,
        then: FileRequest,
    },
    /// A session that ended badly left this.
    Recover {
        text: String,
        is_usable: bool,
    },
    /// Somebody else changed files of the design; `is_saving` says whether it is about to be
    /// saved over them.
    ChangedOnDisk {
        lines: Vec<String>,
        is_saving: bool,
    },
    Table {
        files: FileDialog,
        role: TableRole,
    },
    /// A second table was dropped.
    WhichTable {
        file: PathBuf,
    },
    SaveRoom {
        files: FileDialog,
        room: RoomToSave,
    },
    ReplaceRoom {
        path: PathBuf,
        room: RoomToSave,
    },
    /// What a new design begins as.
    New,
    /// The design could not be written; it is open as it was.
    NotSaved {
        text: String,
    },
    /// Chooses a mesh for a body or the anatomy.
    Mesh {
        files: FileDialog,
        whose: MeshOwner,
    },
    /// A mesh was dropped with no body selected.
    WhoseMesh {
        file: PathBuf,
        has_crf: bool,
    },
    /// A mesh of a size that no instrument has.
    MeshUnit {
        whose: MeshOwner,
        file: PathBuf,
        sizes: UnitSuggestion,
    },
    /// Chooses a file to be the tool or the CRF.
    OpenBody {
        files: FileDialog,
        body: BodyRole,
    },
    /// Chooses where a body is written, and as what.
    SaveBody {
        files: FileDialog,
        body: BodyRole,
    },
    /// A tool definition was dropped on a design of two bodies.
    ToolOrCrf {
        file: PathBuf,
    },
    /// An image whose bytes are not those that its checksum was made of.
    Checksum {
        body: BodyRole,
        file: PathBuf,
        text: String,
    },
    /// What is lost when a body is written, and what else is written over.
    WriteBody {
        body: BodyRole,
        file: PathBuf,
        /// With its article.
        kind: &'static str,
        notes: Vec<String>,
        exists: bool,
    },
}

/// What a dialog came to.
#[derive(Clone, Debug, PartialEq)]
pub enum DialogAnswer {
    Close,
    Request(FileRequest),
    Field(FieldRequest),
    Mesh(MeshRequest),
    Live(LiveRequest),
    BodyFile(BodyFileRequest),
    Decide(DecideRequest),
    Become(Dialog),
}

impl Dialog {
    pub fn open(folder: PathBuf) -> Self {
        Self::Open(FileDialog::new(FileKind::Design, folder, ""))
    }

    pub fn pin_design(folder: PathBuf) -> Self {
        Self::PinDesign(FileDialog::new(FileKind::Design, folder, ""))
    }

    pub fn open_recorded(folder: PathBuf, body: BodyRole) -> Self {
        Self::OpenRecorded { files: FileDialog::new(FileKind::Table, folder, ""), body }
    }

    pub fn add_design(folder: PathBuf) -> Self {
        Self::AddDesign(FileDialog::new(FileKind::Design, folder, ""))
    }

    pub fn save_as(folder: PathBuf, name: &str) -> Self {
        Self::SaveAs(FileDialog::new(FileKind::Design, folder, name))
    }

    pub fn read_input(folder: PathBuf) -> Self {
        Self::ReadInput(FileDialog::new(FileKind::Table, folder, ""))
    }

    pub fn write_log(folder: PathBuf, name: &str) -> Self {
        Self::WriteLog(FileDialog::new(FileKind::Table, folder, name))
    }

    pub fn write_report(folder: PathBuf, name: &str) -> Self {
        Self::Report(FileDialog::new(FileKind::Page, folder, name))
    }

    pub fn record(folder: PathBuf, name: &str) -> Self {
        Self::Record(FileDialog::new(FileKind::Table, folder, name))
    }

    pub fn open_table(folder: PathBuf, role: TableRole) -> Self {
        Self::Table { files: FileDialog::new(FileKind::Table, folder, ""), role }
    }

    pub fn save_room(folder: PathBuf, name: &str, room: RoomToSave) -> Self {
        Self::SaveRoom { files: FileDialog::new(FileKind::Room, folder, name), room }
    }

    pub fn load_mesh(folder: PathBuf, whose: impl Into<MeshOwner>) -> Self {
        Self::Mesh { files: FileDialog::new(FileKind::Mesh, folder, ""), whose: whose.into() }
    }

    pub fn open_body(folder: PathBuf, body: BodyRole) -> Self {
        Self::OpenBody { files: FileDialog::new(FileKind::Body, folder, ""), body }
    }

    pub fn save_body(folder: PathBuf, name: &str, body: BodyRole) -> Self {
        Self::SaveBody { files: FileDialog::new(FileKind::Body, folder, name), body }
    }
}

impl Dialog {
    /// What the system's own dialog would have to know; `None` where no file is chosen.
    pub fn wish(&mut self) -> Option<Wish<'_>> {
        let (files, title, is_saving) = match self {
            Self::Open(files) => (files, "Open design", false),
            Self::PinDesign(files) => (files, "Pin a design", false),
            Self::OpenRecorded { files, .. } => (files, "Open recorded poses", false),
            Self::AddDesign(files) => (files, "Add a design to the table", false),
            Self::SaveAs(files) => (files, "Save design as", true),
            Self::ReadInput(files) => (files, "Read input data", false),
            Self::WriteLog(files) => (files, "Write the log", true),
            Self::Report(files) => (files, "Write the report", true),
            Self::Record(files) => (files, "Record in", true),
            Self::Table { files, .. } => (files, "Open measurements", false),
            Self::Mesh { files, .. } => (files, "Load a mesh", false),
            Self::OpenBody { files, .. } => (files, "Open tool definition", false),
            Self::SaveBody { files, .. } => (files, "Save tool definition as", true),
            Self::SaveRoom { files, .. } => (files, "Save room and use it", true),
            _ => return None,
        };
        Some(Wish {
            title,
            kind: files.kind,
            folder: files.folder.clone(),
            name: files.name(),
            is_saving,
            choice: &mut files.system,
        })
    }
}

/// Draws a dialog.
pub fn dialog_ui(ui: &mut Ui, dialog: &mut Dialog) -> Option<DialogAnswer> {
    match dialog {
        Dialog::Open(files) => file_ui(ui, files, "Open design", "Open", |path, _| {
            DialogAnswer::Request(FileRequest::Open(path))
        }),
        Dialog::PinDesign(files) => file_ui(ui, files, "Pin a design", "Pin", |path, _| {
            DialogAnswer::Decide(DecideRequest::Pin(path))
        }),
        Dialog::OpenRecorded { files, body } => {
            let title = match body {
                BodyRole::Tool => "Open recorded poses of the built tool",
                BodyRole::Crf => "Open recorded poses of the CRF",
            };
            file_ui(ui, files, title, "Open", |path, _| {
                DialogAnswer::Decide(DecideRequest::Recorded(*body, path))
            })
        }
        Dialog::AddDesign(files) => {
            file_ui(ui, files, "Add a design to the table", "Add", |path, _| {
                DialogAnswer::Decide(DecideRequest::AddDesign(path))
            })
        }
        Dialog::SaveAs(files) => file_ui(ui, files, "Save design as", "Save", |path, exists| {
            write_to(path, exists, FileRequest::SaveAs)
        }),
        Dialog::ReadInput(files) => file_ui(ui, files, "Read input data", "Read", |path, _| {
            DialogAnswer::Request(FileRequest::ReadInput(path))
        }),
        Dialog::WriteLog(files) => file_ui(ui, files, "Write the log", "Write", |path, exists| {
            write_to(path, exists, FileRequest::WriteLog)
        }),
        Dialog::Report(files) => file_ui(ui, files, "Write the report", "Write", |path, exists| {
            write_to(path, exists, FileRequest::WriteReport)
        }),
        Dialog::Record(files) => file_ui(ui, files, "Record in", "Record", |path, _| {
            DialogAnswer::Live(LiveRequest::Record(path))
        }),
        Dialog::Table { files, role } => {
            let role = *role;
            let title = match role {
                TableRole::Training => "Open measurements to fit",
                TableRole::HeldOut => "Open measurements to judge the fit on",
            };
            file_ui(ui, files, title, "Open", |path, _| {
                DialogAnswer::Field(FieldRequest::Open(role, path))
            })
        }
        Dialog::Mesh { files, whose } => {
            let whose = *whose;
            let title = match whose {
                MeshOwner::Anatomy(None) => "Add a mesh as anatomy".to_owned(),
                _ => format!("Load a mesh for the {whose}"),
            };
            file_ui(ui, files, &title, "Load", |file, _| {
                DialogAnswer::Mesh(MeshRequest::load(whose, file))
            })
        }
        Dialog::OpenBody { files, body } => {
            let body = *body;
            let title = format!("Open a tool definition as the {body}");
            file_ui(ui, files, &title, "Open", |file, _| {
                DialogAnswer::BodyFile(BodyFileRequest::open(body, file))
            })
        }
        Dialog::SaveBody { files, body } => {
            let body = *body;
            let title = format!("Save the {body} as a tool definition");
            file_ui(ui, files, &title, "Save", |file, _| {
                DialogAnswer::BodyFile(BodyFileRequest::Save { body, file })
            })
        }
        Dialog::SaveRoom { files, room } => {
            let room = room.clone();
            file_ui(ui, files, "Save room and use it", "Save", move |path, exists| {
                let room = room.clone();
                if exists {
                    DialogAnswer::Become(Dialog::ReplaceRoom { path, room })
                } else {
                    DialogAnswer::Field(FieldRequest::Save(room, path))
                }
            })
        }
        question => body_questions::question_ui(ui, question)
            .unwrap_or_else(|| questions::question_ui(ui, question)),
    }
}

fn title_ui(ui: &mut Ui, title: &str) {
    ui.set_width(WIDTH);
    ui.label(RichText::new(title).strong().color(palette::TEXT_STRONG.color32()));
    ui.add_space(6.0);
}

/// Width of all dialogs.
const WIDTH: f32 = 520.0;
