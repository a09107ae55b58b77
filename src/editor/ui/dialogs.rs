//! Questions and errors that stand before everything else: open, save as, unsaved changes,
//! bodies that other designs use too, measurements and rooms, and what could not be done.

use super::folder::{self, Entry};
use super::theme;
use super::widgets::{Row, quiet_ui, row_ui, warning_ui};
use crate::editor::document::DESIGN_EXTENSION;
use crate::editor::field::{FieldRequest, RoomToSave, TableRole};
use crate::editor::palette;
use crate::editor::state::{FileRequest, SharedChoice};
use crate::formats::recovery_file::RecoveryOrigin;
use crate::store::{ChangedFile, ENVIRONMENT_EXTENSION, FileChange, Leftover, SharedBody};
use bevy::prelude::Resource;
use bevy_egui::egui::{self, Align, Key, Layout, RichText, ScrollArea, TextEdit, Ui, vec2};
use std::path::{Path, PathBuf};
use std::time::Duration;

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

/// A dialog and what was typed into it so far.
#[derive(Clone, Debug, PartialEq)]
pub enum Dialog {
    Open(FileDialog),
    SaveAs(FileDialog),
    /// Chooses a table of poses.
    ReadInput(FileDialog),
    /// Chooses where a log goes.
    WriteLog(FileDialog),
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
}

/// Chooses a file.
#[derive(Clone, Debug, PartialEq)]
pub struct FileDialog {
    pub kind: FileKind,
    pub folder: PathBuf,
    pub entries: Vec<Entry>,
    /// The path field.
    pub text: String,
    pub problem: Option<String>,
    wants_focus: bool,
}

/// What kind of file a dialog lists.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FileKind {
    Design,
    Table,
    Room,
}

impl FileKind {
    fn extension(self) -> &'static str {
        match self {
            Self::Design => DESIGN_EXTENSION,
            Self::Table => ".csv",
            Self::Room => ENVIRONMENT_EXTENSION,
        }
    }

    /// Behind each file of the list.
    fn note(self) -> &'static str {
        match self {
            Self::Design => "design",
            Self::Table => "table",
            Self::Room => "room",
        }
    }
}

/// What a dialog came to.
#[derive(Clone, Debug, PartialEq)]
pub enum DialogAnswer {
    Close,
    Request(FileRequest),
    Field(FieldRequest),
    Become(Dialog),
}

impl Dialog {
    pub fn open(folder: PathBuf) -> Self {
        Self::Open(FileDialog::new(FileKind::Design, folder, ""))
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

    pub fn open_table(folder: PathBuf, role: TableRole) -> Self {
        Self::Table {
            files: FileDialog::new(FileKind::Table, folder, ""),
            role,
        }
    }

    pub fn save_room(folder: PathBuf, name: &str, room: RoomToSave) -> Self {
        Self::SaveRoom {
            files: FileDialog::new(FileKind::Room, folder, name),
            room,
        }
    }

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
        Self::Error {
            title: title.to_owned(),
            text,
        }
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
        Self::ChangedOnDisk {
            lines: changes.iter().map(line).collect(),
            is_saving,
        }
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
                format!(
                    "{} is also used by {}",
                    name(&body.file),
                    designs.join(", ")
                )
            })
            .collect();
        Self::SharedBodies { lines }
    }
}

impl FileDialog {
    fn new(kind: FileKind, folder: PathBuf, name: &str) -> Self {
        let mut dialog = Self {
            kind,
            text: String::new(),
            folder: PathBuf::new(),
            entries: Vec::new(),
            problem: None,
            wants_focus: true,
        };
        dialog.go_to(folder, name);
        dialog
    }

    fn go_to(&mut self, folder: PathBuf, name: &str) {
        // A relative folder has no folder above it.
        let folder = std::path::absolute(&folder).unwrap_or(folder);
        match folder::list(&folder, self.kind.extension()) {
            Ok(entries) => {
                self.entries = entries;
                self.problem = None;
            }
            Err(problem) => {
                self.entries = vec![Entry::Up];
                self.problem = Some(problem);
            }
        }
        self.text = folder.join(name).display().to_string();
        self.folder = folder;
        self.wants_focus = true;
    }

    /// The name in the path field, kept while a person looks through folders.
    fn name(&self) -> String {
        let path = Path::new(&self.text);
        if path.is_dir() {
            return String::new();
        }
        path.file_name()
            .map(|name| name.to_string_lossy().into_owned())
            .unwrap_or_default()
    }
}

/// Draws a dialog.
pub fn dialog_ui(ui: &mut Ui, dialog: &mut Dialog) -> Option<DialogAnswer> {
    match dialog {
        Dialog::Open(files) => file_ui(ui, files, "Open design", "Open", |path, _| {
            DialogAnswer::Request(FileRequest::Open(path))
        }),
        Dialog::SaveAs(files) => file_ui(ui, files, "Save design as", "Save", |path, exists| {
            write_to(path, exists, FileRequest::SaveAs)
        }),
        Dialog::ReadInput(files) => file_ui(ui, files, "Read input data", "Read", |path, _| {
            DialogAnswer::Request(FileRequest::ReadInput(path))
        }),
        Dialog::WriteLog(files) => file_ui(ui, files, "Write the log", "Write", |path, exists| {
            write_to(path, exists, FileRequest::WriteLog)
        }),
        Dialog::Error { title, text } => {
            title_ui(ui, title);
            ui.add(egui::Label::new(text.as_str()).wrap().selectable(true));
            buttons_ui(ui, &[("OK", DialogAnswer::Close)])
        }
        Dialog::Unsaved { file, then } => {
            title_ui(ui, "Save changes?");
            ui.add(egui::Label::new(format!("{file} has changes that are not saved")).wrap());
            let then = Box::new(then.clone());
            buttons_ui(
                ui,
                &[
                    (
                        "Save",
                        DialogAnswer::Request(FileRequest::SaveThen(then.clone())),
                    ),
                    (
                        "Don't save",
                        DialogAnswer::Request(FileRequest::Discard(then)),
                    ),
                    ("Cancel", DialogAnswer::Close),
                ],
            )
        }
        Dialog::SharedBodies { lines } => {
            title_ui(ui, "Other designs use a body that changed");
            for line in lines.iter() {
                ui.add(egui::Label::new(line.as_str()).wrap());
            }
            let save = |choice| DialogAnswer::Request(FileRequest::SaveShared(choice));
            buttons_ui(
                ui,
                &[
                    ("Save a copy of the body", save(SharedChoice::Copy)),
                    ("Change it for all", save(SharedChoice::Overwrite)),
                    ("Cancel", DialogAnswer::Close),
                ],
            )
        }
        Dialog::Recover { text, is_usable } => {
            title_ui(ui, "Recover unsaved changes?");
            ui.add(egui::Label::new(text.as_str()).wrap());
            let drop = (
                "Give them up",
                DialogAnswer::Request(FileRequest::DropLeftover),
            );
            let later = ("Ask again next time", DialogAnswer::Close);
            match is_usable {
                true => {
                    let recover = ("Recover", DialogAnswer::Request(FileRequest::Recover));
                    buttons_ui(ui, &[recover, drop, later])
                }
                false => buttons_ui(ui, &[later, drop]),
            }
        }
        Dialog::ChangedOnDisk { lines, is_saving } => {
            title_ui(ui, "Somebody else changed files of this design");
            for line in lines.iter() {
                ui.add(egui::Label::new(line.as_str()).wrap());
            }
            let reload = (
                "Read them again",
                DialogAnswer::Request(FileRequest::Reload),
            );
            match is_saving {
                true => buttons_ui(
                    ui,
                    &[
                        ("Cancel", DialogAnswer::Close),
                        reload,
                        (
                            "Write over them",
                            DialogAnswer::Request(FileRequest::SaveOver),
                        ),
                    ],
                ),
                false => buttons_ui(
                    ui,
                    &[
                        reload,
                        (
                            "Keep what is open",
                            DialogAnswer::Request(FileRequest::KeepMine),
                        ),
                    ],
                ),
            }
        }
        Dialog::Overwrite { path, then } => {
            title_ui(ui, "Replace the file?");
            ui.add(egui::Label::new(format!("{} exists already", path.display())).wrap());
            let write = DialogAnswer::Request(then.clone());
            buttons_ui(ui, &[("Replace", write), ("Cancel", DialogAnswer::Close)])
        }
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
        Dialog::WhichTable { file } => {
            title_ui(ui, "What are these measurements for?");
            ui.add(egui::Label::new(file.display().to_string()).wrap());
            let open = |role| DialogAnswer::Field(FieldRequest::Open(role, file.clone()));
            buttons_ui(
                ui,
                &[
                    ("To judge the fit on", open(TableRole::HeldOut)),
                    ("To fit, instead", open(TableRole::Training)),
                    ("Cancel", DialogAnswer::Close),
                ],
            )
        }
        Dialog::SaveRoom { files, room } => {
            let room = room.clone();
            file_ui(
                ui,
                files,
                "Save room and use it",
                "Save",
                move |path, exists| {
                    let room = room.clone();
                    if exists {
                        DialogAnswer::Become(Dialog::ReplaceRoom { path, room })
                    } else {
                        DialogAnswer::Field(FieldRequest::Save(room, path))
                    }
                },
            )
        }
        Dialog::ReplaceRoom { path, room } => {
            title_ui(ui, "Replace the room's file?");
            let text = format!(
                "{} exists already; designs that refer to it would be in another room",
                path.display()
            );
            ui.add(egui::Label::new(text).wrap());
            let save = DialogAnswer::Field(FieldRequest::Save(room.clone(), path.clone()));
            buttons_ui(ui, &[("Replace", save), ("Cancel", DialogAnswer::Close)])
        }
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

/// What is there already is asked about first.
fn write_to(path: PathBuf, exists: bool, write: fn(PathBuf) -> FileRequest) -> DialogAnswer {
    let then = write(path.clone());
    match exists {
        true => DialogAnswer::Become(Dialog::Overwrite { path, then }),
        false => DialogAnswer::Request(then),
    }
}

fn title_ui(ui: &mut Ui, title: &str) {
    ui.set_width(WIDTH);
    ui.label(
        RichText::new(title)
            .strong()
            .color(palette::TEXT_STRONG.color32()),
    );
    ui.add_space(6.0);
}

/// Width of all dialogs.
const WIDTH: f32 = 520.0;
const LIST_HEIGHT: f32 = 260.0;

/// Buttons at the right, the first the one that Enter presses.
fn buttons_ui(ui: &mut Ui, buttons: &[(&str, DialogAnswer)]) -> Option<DialogAnswer> {
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

fn file_ui(
    ui: &mut Ui,
    files: &mut FileDialog,
    title: &str,
    verb: &str,
    choose: impl Fn(PathBuf, bool) -> DialogAnswer,
) -> Option<DialogAnswer> {
    title_ui(ui, title);
    let field = ui.add(
        TextEdit::singleline(&mut files.text)
            .desired_width(f32::INFINITY)
            .hint_text(format!("path of a *{} file", files.kind.extension())),
    );
    field.widget_info(|| {
        egui::WidgetInfo::labeled(egui::WidgetType::TextEdit, ui.is_enabled(), "path")
    });
    if files.wants_focus {
        field.request_focus();
        files.wants_focus = false;
    }
    let is_entered = field.lost_focus() && ui.input(|i| i.key_pressed(Key::Enter));
    ui.add_space(6.0);
    let mut chosen = list_ui(ui, files);
    if let Some(problem) = &files.problem {
        warning_ui(ui, problem);
    } else {
        quiet_ui(ui, "Tab and Enter choose; Esc closes");
    }
    ui.add_space(8.0);
    let mut is_closed = false;
    ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
        is_closed = ui.button("Cancel").clicked();
        if ui.button(verb).clicked() || is_entered {
            chosen = Some(PathBuf::from(files.text.trim()));
        }
    });
    if is_closed {
        return Some(DialogAnswer::Close);
    }
    let path = chosen?;
    if path.is_dir() {
        let name = files.name();
        files.go_to(path, &name);
        return None;
    }
    if path.as_os_str().is_empty() {
        files.problem = Some(format!(
            "no path, expected a *{} file",
            files.kind.extension()
        ));
        files.wants_focus = true;
        return None;
    }
    let exists = path.exists();
    Some(choose(path, exists))
}

/// The folder's list; what was clicked.
fn list_ui(ui: &mut Ui, files: &FileDialog) -> Option<PathBuf> {
    let mut chosen = None;
    egui::Frame::new()
        .fill(palette::FIELD.color32())
        .corner_radius(3.0)
        .show(ui, |ui| {
            ScrollArea::vertical()
                .max_height(LIST_HEIGHT)
                .auto_shrink(false)
                .show(ui, |ui| {
                    ui.spacing_mut().item_spacing = vec2(0.0, 0.0);
                    for entry in &files.entries {
                        let row = Row {
                            label: entry.name(),
                            note: match entry {
                                Entry::Up => "folder above",
                                Entry::Folder(_) => "folder",
                                Entry::File(_) => files.kind.note(),
                            },
                            ..Row::default()
                        };
                        if row_ui(ui, &row).clicked() {
                            chosen = Some(entry.path(&files.folder));
                        }
                    }
                });
        });
    ui.add_space(theme::ROW_HEIGHT / 4.0);
    chosen
}
