//! Chooses where a recording goes.

use crate::shell::dialogs::file_dialog::{FileDialog, FileKind};
use crate::shell::dialogs::{Dialog, DialogAnswer};
use crate::workspaces::live::requests::LiveRequest;
use bevy_egui::egui::Ui;
use std::path::PathBuf;

#[derive(Clone, Debug, PartialEq)]
pub struct RecordDialog(FileDialog);

impl RecordDialog {
    pub fn new(folder: PathBuf, name: &str) -> Self {
        let files = FileDialog::new(FileKind::Table, folder, name);
        Self(files.titled("Record in", "Record").saving())
    }
}

impl Dialog for RecordDialog {
    type Request = LiveRequest;

    fn name(&self) -> &'static str {
        "record"
    }

    fn files(&mut self) -> Option<&mut FileDialog> {
        Some(&mut self.0)
    }

    fn ui(&mut self, ui: &mut Ui) -> Option<DialogAnswer<Self>> {
        self.0.ui(ui, |path, _| DialogAnswer::Request(LiveRequest::Record(path)))
    }
}
