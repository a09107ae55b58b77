//! The dialog that chooses a sweep.

use crate::shell::dialogs::file_dialog::{FileDialog, FileKind};
use crate::shell::dialogs::{Dialog, DialogAnswer};
use crate::workspaces::decide::sweep_table::state::SweepTableRequest;
use bevy_egui::egui::Ui;
use std::path::PathBuf;

/// Chooses a merged table, or the plan in a sweep's folder.
#[derive(Clone, Debug, PartialEq)]
pub struct SweepDialog(FileDialog);

impl SweepDialog {
    pub fn open(folder: PathBuf) -> Self {
        Self(FileDialog::new(FileKind::Sweep, folder, "").titled("Open sweep", "Open"))
    }
}

impl Dialog for SweepDialog {
    type Request = SweepTableRequest;

    fn name(&self) -> &'static str {
        "open a sweep"
    }

    fn files(&mut self) -> Option<&mut FileDialog> {
        Some(&mut self.0)
    }

    fn ui(&mut self, ui: &mut Ui) -> Option<DialogAnswer<Self>> {
        self.0.ui(ui, |path, _| DialogAnswer::Request(SweepTableRequest::Open(path)))
    }
}
