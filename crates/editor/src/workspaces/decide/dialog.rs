//! Dialogs of the Decide workspace: designs to compare with, and recordings of the built tool.

use crate::shell::dialogs::file_dialog::{FileDialog, FileKind};
use crate::shell::dialogs::{Dialog, DialogAnswer};
use crate::workspaces::decide::requests::DecideRequest;
use bevy_egui::egui::Ui;
use std::path::PathBuf;
use trackwright_design::BodyRole;

#[derive(Clone, Debug, PartialEq)]
pub enum DecideDialog {
    /// Chooses the baseline.
    Pin(FileDialog),
    /// Chooses designs for the table.
    AddDesign(FileDialog),
    /// Chooses a recording of the built tool, or of its CRF.
    OpenRecorded { files: FileDialog, body: BodyRole },
}

impl DecideDialog {
    pub fn pin(folder: PathBuf) -> Self {
        let files = FileDialog::new(FileKind::Design, folder, "");
        Self::Pin(files.titled("Pin a design", "Pin"))
    }

    pub fn add_design(folder: PathBuf) -> Self {
        let files = FileDialog::new(FileKind::Design, folder, "");
        Self::AddDesign(files.titled("Add designs to the table", "Add").several())
    }

    pub fn open_recorded(folder: PathBuf, body: BodyRole) -> Self {
        let title = match body {
            BodyRole::Tool => "Open recorded poses of the built tool",
            BodyRole::Crf => "Open recorded poses of the CRF",
        };
        let files = FileDialog::new(FileKind::Table, folder, "").titled(title, "Open");
        Self::OpenRecorded { files, body }
    }
}

impl Dialog for DecideDialog {
    type Request = DecideRequest;

    fn name(&self) -> &'static str {
        match self {
            Self::Pin(_) => "pin a design",
            Self::AddDesign(_) => "add a design",
            Self::OpenRecorded { .. } => "open recorded poses",
        }
    }

    fn files(&mut self) -> Option<&mut FileDialog> {
        let (Self::Pin(files) | Self::AddDesign(files) | Self::OpenRecorded { files, .. }) = self;
        Some(files)
    }

    fn ui(&mut self, ui: &mut Ui) -> Option<DialogAnswer<Self>> {
        let request = DialogAnswer::Request;
        match self {
            Self::Pin(files) => files.ui(ui, |path, _| request(DecideRequest::Pin(path))),
            Self::AddDesign(files) => {
                files.several_ui(ui, |paths| request(DecideRequest::AddDesigns(paths)))
            }
            Self::OpenRecorded { files, body } => {
                files.ui(ui, |path, _| request(DecideRequest::Recorded(*body, path)))
            }
        }
    }
}
