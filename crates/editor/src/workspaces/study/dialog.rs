//! Dialogs of the Study workspace: the table of poses to read, and where the log goes.

use crate::document::requests::FileRequest;
use crate::shell::dialogs::file_dialog::{FileDialog, FileKind};
use crate::shell::dialogs::{Dialog, DialogAnswer, overwrite_ui};
use bevy_egui::egui::Ui;
use std::path::PathBuf;

#[derive(Clone, Debug, PartialEq)]
pub enum StudyDialog {
    /// Chooses a table of poses.
    ReadInput(FileDialog),
    /// Chooses where a log goes.
    WriteLog(FileDialog),
    /// Something is there already.
    Overwrite(PathBuf),
}

impl StudyDialog {
    pub fn read_input(folder: PathBuf) -> Self {
        let files = FileDialog::new(FileKind::Table, folder, "");
        Self::ReadInput(files.titled("Read input data", "Read"))
    }

    pub fn write_log(folder: PathBuf, name: &str) -> Self {
        let files = FileDialog::new(FileKind::Table, folder, name);
        Self::WriteLog(files.titled("Save all trials", "Save").saving())
    }
}

impl Dialog for StudyDialog {
    type Request = FileRequest;

    fn name(&self) -> &'static str {
        match self {
            Self::ReadInput(_) => "read input",
            Self::WriteLog(_) => "write log",
            Self::Overwrite(_) => "overwrite",
        }
    }

    fn files(&mut self) -> Option<&mut FileDialog> {
        match self {
            Self::ReadInput(files) | Self::WriteLog(files) => Some(files),
            Self::Overwrite(_) => None,
        }
    }

    fn ui(&mut self, ui: &mut Ui) -> Option<DialogAnswer<Self>> {
        match self {
            Self::ReadInput(files) => {
                files.ui(ui, |path, _| DialogAnswer::Request(FileRequest::ReadInput(path)))
            }
            Self::WriteLog(files) => files.ui(ui, |path, exists| match exists {
                true => DialogAnswer::Become(Self::Overwrite(path)),
                false => DialogAnswer::Request(FileRequest::WriteLog(path)),
            }),
            Self::Overwrite(path) => overwrite_ui(ui, path, FileRequest::WriteLog(path.clone())),
        }
    }
}
