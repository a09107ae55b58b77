//! Dialogs of the Field workspace: measurements and generators to open, and where a room is saved.

use crate::shell::dialogs::file_dialog::{FileDialog, FileKind};
use crate::shell::dialogs::{Dialog, DialogAnswer, buttons_ui, text_ui, title_ui};
use crate::workspaces::field::metal::GeneratorSource;
use crate::workspaces::field::requests::{FieldRequest, RoomToSave};
use crate::workspaces::field::state::TableRole;
use bevy_egui::egui::Ui;
use std::path::PathBuf;

#[derive(Clone, Debug, PartialEq)]
pub enum FieldDialog {
    Table {
        files: FileDialog,
        role: TableRole,
    },
    /// A second table was dropped.
    WhichTable {
        file: PathBuf,
    },
    Generator {
        files: FileDialog,
    },
    SaveRoom {
        files: FileDialog,
        room: RoomToSave,
    },
    ReplaceRoom {
        path: PathBuf,
        room: RoomToSave,
    },
}

impl FieldDialog {
    pub fn open_table(folder: PathBuf, role: TableRole) -> Self {
        let title = match role {
            TableRole::Training => "Open measurements to fit",
            TableRole::HeldOut => "Open measurements to judge the fit on",
        };
        let files = FileDialog::new(FileKind::Table, folder, "").titled(title, "Open");
        Self::Table { files, role }
    }

    pub fn open_generator(folder: PathBuf) -> Self {
        let files = FileDialog::new(FileKind::Generator, folder, "");
        Self::Generator { files: files.titled("Open the tracker's field generator", "Open") }
    }

    pub fn save_room(folder: PathBuf, name: &str, room: RoomToSave) -> Self {
        let files = FileDialog::new(FileKind::Room, folder, name);
        Self::SaveRoom { files: files.titled("Save room and use it", "Save").saving(), room }
    }
}

impl Dialog for FieldDialog {
    type Request = FieldRequest;

    fn name(&self) -> &'static str {
        match self {
            Self::Table { .. } => "open measurements",
            Self::WhichTable { .. } => "which table",
            Self::Generator { .. } => "open generator",
            Self::SaveRoom { .. } => "save room",
            Self::ReplaceRoom { .. } => "replace room",
        }
    }

    fn files(&mut self) -> Option<&mut FileDialog> {
        match self {
            Self::Table { files, .. }
            | Self::Generator { files }
            | Self::SaveRoom { files, .. } => Some(files),
            _ => None,
        }
    }

    fn ui(&mut self, ui: &mut Ui) -> Option<DialogAnswer<Self>> {
        let request = DialogAnswer::Request;
        let cancel = ("Cancel", DialogAnswer::Close);
        match self {
            Self::Table { files, role } => {
                files.ui(ui, |path, _| request(FieldRequest::Open(*role, path)))
            }
            Self::Generator { files } => files
                .ui(ui, |path, _| request(FieldRequest::UseGenerator(GeneratorSource::File(path)))),
            Self::SaveRoom { files, room } => files.ui(ui, |path, exists| match exists {
                true => DialogAnswer::Become(Self::ReplaceRoom { path, room: *room }),
                false => request(FieldRequest::Save(*room, path)),
            }),
            Self::WhichTable { file } => {
                title_ui(ui, "What are these measurements for?");
                text_ui(ui, file.display().to_string());
                let open = |role| request(FieldRequest::Open(role, file.clone()));
                let judge = ("To judge the fit on", open(TableRole::HeldOut));
                let fit = ("To fit, instead", open(TableRole::Training));
                buttons_ui(ui, &[judge, fit, cancel])
            }
            Self::ReplaceRoom { path, room } => {
                title_ui(ui, "Replace the room's file?");
                let text = format!(
                    "{} exists already; designs that refer to it would be in another room",
                    path.display()
                );
                text_ui(ui, text);
                let save = request(FieldRequest::Save(*room, path.clone()));
                buttons_ui(ui, &[("Replace", save), cancel])
            }
        }
    }
}
