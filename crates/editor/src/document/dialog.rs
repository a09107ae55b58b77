//! Dialogs about designs and their files.

use crate::document::requests::{Export, FileRequest, SharedChoice};
use crate::shell::dialogs::file_dialog::{FileDialog, FileKind};
use crate::shell::dialogs::{Dialog, DialogAnswer, buttons_ui, overwrite_ui, text_ui, title_ui};
use crate::widgets::basic::quiet_ui;
use bevy_egui::egui::{Label, Ui};
use std::path::PathBuf;
use std::time::Duration;
use trackwright_formats::recovery_file::RecoveryOrigin;
use trackwright_project::{
    ChangedFile, FileChange, Leftover, SharedBody, Starter, StoreError, file_name,
};

/// Dialogs about designs.
#[derive(Clone, Debug, PartialEq)]
pub enum DesignDialog {
    /// What a new design begins as.
    New,
    Open(FileDialog),
    SaveAs(FileDialog),
    /// Chooses where a report goes.
    Report(FileDialog),
    /// Chooses where something goes for other programs.
    Export {
        files: FileDialog,
        export: Export,
    },
    Unsaved {
        file: String,
        then: FileRequest,
    },
    /// The design could not be written; it is open as it was.
    NotSaved {
        text: String,
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
    /// Another program changed files of the design; `is_saving`: the design is about to be saved
    /// over them.
    ChangedOnDisk {
        lines: Vec<String>,
        is_saving: bool,
    },
}

impl DesignDialog {
    pub fn open(folder: PathBuf) -> Self {
        Self::Open(FileDialog::new(FileKind::Design, folder, "").titled("Open design", "Open"))
    }

    pub fn save_as(folder: PathBuf, name: &str) -> Self {
        let files = FileDialog::new(FileKind::Design, folder, name);
        Self::SaveAs(files.titled("Save design as", "Save").saving())
    }

    pub fn write_report(folder: PathBuf, name: &str) -> Self {
        let files = FileDialog::new(FileKind::Page, folder, name);
        Self::Report(files.titled("Write the report", "Write").saving())
    }

    pub fn export(folder: PathBuf, stem: &str, export: Export) -> Self {
        let (kind, what) = match export {
            Export::Field => (FileKind::Lattice, "the room's error field"),
            Export::Tips => (FileKind::Tips, "the tips of the study"),
            Export::Scene => (FileKind::Scene, "the 3D view"),
        };
        let name = format!("{stem}-{}{}", export.name(), kind.extensions()[0]);
        let files = FileDialog::new(kind, folder, &name);
        Self::Export { files: files.titled(&format!("Export {what}"), "Export").saving(), export }
    }

    /// What is open is not lost by it, which is reported.
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

    /// What another program changed.
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
        let lines = shared
            .iter()
            .map(|body| {
                let designs: Vec<String> =
                    body.designs.iter().map(|file| file_name(file)).collect();
                format!("{} is also used by {}", file_name(&body.file), designs.join(", "))
            })
            .collect();
        Self::SharedBodies { lines }
    }
}

type Answer = DialogAnswer<DesignDialog>;

impl Dialog for DesignDialog {
    type Request = FileRequest;

    fn name(&self) -> &'static str {
        match self {
            Self::New => "new",
            Self::Open(_) => "open",
            Self::SaveAs(_) => "save as",
            Self::Report(_) => "write report",
            Self::Export { .. } => "export",
            Self::Unsaved { .. } => "unsaved changes",
            Self::NotSaved { .. } => "not saved",
            Self::SharedBodies { .. } => "shared bodies",
            Self::Overwrite { .. } => "overwrite",
            Self::Recover { .. } => "recover",
            Self::ChangedOnDisk { .. } => "changed on disk",
        }
    }

    fn files(&mut self) -> Option<&mut FileDialog> {
        match self {
            Self::Open(files) | Self::SaveAs(files) | Self::Report(files) => Some(files),
            Self::Export { files, .. } => Some(files),
            _ => None,
        }
    }

    fn description(&self) -> String {
        match self {
            Self::NotSaved { text } => format!("not saved: {text}"),
            _ => self.name().to_owned(),
        }
    }

    fn ui(&mut self, ui: &mut Ui) -> Option<Answer> {
        match self {
            Self::Open(files) => files.ui(ui, |path, _| request(FileRequest::Open(path))),
            Self::SaveAs(files) => {
                files.ui(ui, |path, exists| write_to(path, exists, FileRequest::SaveAs))
            }
            Self::Report(files) => {
                files.ui(ui, |path, exists| write_to(path, exists, FileRequest::WriteReport))
            }
            Self::Export { files, export } => {
                let request = |path| FileRequest::Export(*export, path);
                files.ui(ui, |path, exists| write_to(path, exists, request))
            }
            Self::Overwrite { path, then } => overwrite_ui(ui, path, then.clone()),
            question => question.question_ui(ui),
        }
    }
}

fn request(request: FileRequest) -> Answer {
    DialogAnswer::Request(request)
}

/// What is there already is overwritten only after confirmation.
fn write_to(path: PathBuf, exists: bool, write: impl Fn(PathBuf) -> FileRequest) -> Answer {
    let then = write(path.clone());
    match exists {
        true => DialogAnswer::Become(DesignDialog::Overwrite { path, then }),
        false => DialogAnswer::Request(then),
    }
}

impl DesignDialog {
    fn question_ui(&self, ui: &mut Ui) -> Option<Answer> {
        let cancel = ("Cancel", DialogAnswer::Close);
        match self {
            Self::New => {
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
            Self::NotSaved { text } => {
                title_ui(ui, "The design cannot be saved");
                ui.add(Label::new(text.as_str()).wrap().selectable(true));
                ui.add_space(4.0);
                quiet_ui(
                    ui,
                    "Nothing is lost: every change is still open here, and can be saved elsewhere",
                );
                let elsewhere = ("Save as…", request(FileRequest::ShowSaveAs));
                buttons_ui(ui, &[elsewhere, ("Close", DialogAnswer::Close)])
            }
            Self::Unsaved { file, then } => {
                title_ui(ui, "Save changes?");
                text_ui(ui, format!("{file} has changes that are not saved"));
                let then = Box::new(then.clone());
                let save = request(FileRequest::SaveThen(then.clone()));
                let discard = request(FileRequest::Discard(then));
                buttons_ui(ui, &[("Save", save), ("Don't save", discard), cancel])
            }
            Self::SharedBodies { lines } => {
                title_ui(ui, "Other designs use a body that changed");
                lines.iter().for_each(|line| text_ui(ui, line));
                let save = |choice| request(FileRequest::SaveShared(choice));
                let copy = ("Save a copy of the body", save(SharedChoice::Copy));
                let all = ("Change it for all", save(SharedChoice::Overwrite));
                buttons_ui(ui, &[copy, all, cancel])
            }
            Self::Recover { text, is_usable } => {
                title_ui(ui, "Recover unsaved changes?");
                text_ui(ui, text);
                let drop = ("Discard", request(FileRequest::DropLeftover));
                let later = ("Decide next time", DialogAnswer::Close);
                match is_usable {
                    true => {
                        let recover = ("Recover", request(FileRequest::Recover));
                        buttons_ui(ui, &[recover, drop, later])
                    }
                    false => buttons_ui(ui, &[later, drop]),
                }
            }
            Self::ChangedOnDisk { lines, is_saving } => {
                title_ui(ui, "Files of this design were changed by another program");
                lines.iter().for_each(|line| text_ui(ui, line));
                let reload = FileRequest::Reload;
                if *is_saving {
                    let elsewhere = ("Save as…", request(FileRequest::ShowSaveAs));
                    let over = ("Write over them", request(FileRequest::SaveOver));
                    let drop = request(FileRequest::Discard(Box::new(reload)));
                    buttons_ui(ui, &[elsewhere, cancel, ("Discard my changes", drop), over])
                } else {
                    let keep = ("Keep what is open", request(FileRequest::KeepMine));
                    buttons_ui(ui, &[("Read them again", request(reload)), keep])
                }
            }
            Self::Open(_)
            | Self::SaveAs(_)
            | Self::Report(_)
            | Self::Export { .. }
            | Self::Overwrite { .. } => None,
        }
    }
}

fn is_new(builtin: &str) -> bool {
    Starter::ALL.iter().any(|starter| starter.name() == builtin)
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
