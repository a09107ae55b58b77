//! Chooses a file to open or a place to save: a path field above a list of the folder.

use crate::document::file_names::DESIGN_EXTENSION;
use crate::palette;
use crate::palette::ThemedColor;
use crate::shell::dialogs::folder::{self, Entry};
use crate::shell::dialogs::{Dialog, DialogAnswer, title_ui};
use crate::widgets::basic::{Row, quiet_ui, row_ui, warning_ui};
use crate::widgets::theme;
use bevy_egui::egui::{self, Align, Key, Layout, RichText, ScrollArea, TextEdit, Ui, vec2};
use std::path::{Path, PathBuf};
use trackwright_project::ENVIRONMENT_EXTENSION;

const LIST_HEIGHT: f32 = 260.0;

/// Chooses a file.
#[derive(Clone, Debug, PartialEq)]
pub struct FileDialog {
    pub kind: FileKind,
    pub title: String,
    /// What its button does.
    verb: &'static str,
    pub is_saving: bool,
    pub folder: PathBuf,
    pub entries: Vec<Entry>,
    /// The path field.
    pub text: String,
    pub problem: Option<String>,
    pub system: SystemChoice,
    wants_focus: bool,
}

/// Whether the system's own dialog is requested instead.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub enum SystemChoice {
    #[default]
    Ours,
    Requested,
    Open,
    Chosen(PathBuf),
    /// Why there is no choice, in words.
    Nothing(String),
}

/// What kind of file a dialog lists.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FileKind {
    Design,
    Table,
    Room,
    Mesh,
    /// A report.
    Page,
    /// A tool definition or a body file.
    Body,
}

impl FileKind {
    /// How such files' names end.
    pub fn extensions(self) -> &'static [&'static str] {
        match self {
            Self::Design => &[DESIGN_EXTENSION],
            Self::Table => &[".csv"],
            Self::Room => &[ENVIRONMENT_EXTENSION],
            Self::Mesh => &[".glb", ".gltf", ".stl", ".obj"],
            Self::Page => &[".html"],
            Self::Body => &[".rom", ".tool", ".ini", ".json", ".body.ron"],
        }
    }

    /// `*.csv`.
    fn pattern(self) -> String {
        let patterns: Vec<String> = self.extensions().iter().map(|e| format!("*{e}")).collect();
        patterns.join(", ")
    }

    /// Behind each file of the list.
    pub fn note(self) -> &'static str {
        match self {
            Self::Design => "design",
            Self::Table => "table",
            Self::Room => "room",
            Self::Mesh => "mesh",
            Self::Page => "page",
            Self::Body => "tool definition",
        }
    }
}

impl FileDialog {
    pub(crate) fn new(kind: FileKind, folder: PathBuf, name: &str) -> Self {
        let mut dialog = Self {
            kind,
            title: String::new(),
            verb: "Open",
            is_saving: false,
            text: String::new(),
            folder: PathBuf::new(),
            entries: Vec::new(),
            problem: None,
            system: SystemChoice::Ours,
            wants_focus: true,
        };
        dialog.go_to(folder, name);
        dialog
    }

    /// With a heading, and what its button does.
    pub(crate) fn titled(self, title: &str, verb: &'static str) -> Self {
        Self { title: title.to_owned(), verb, ..self }
    }

    /// To write a file.
    pub(crate) fn saving(self) -> Self {
        Self { is_saving: true, ..self }
    }

    fn go_to(&mut self, folder: PathBuf, name: &str) {
        // A relative folder has no folder above it.
        let folder = std::path::absolute(&folder).unwrap_or(folder);
        match folder::list(&folder, self.kind.extensions()) {
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

    /// Lists the folder that is typed as soon as there is one of that name.
    fn follow_text(&mut self) {
        let typed = Path::new(self.text.trim());
        let is_whole = self.text.trim_end().ends_with(std::path::is_separator);
        let folder = match is_whole {
            true => Some(typed),
            false => typed.parent(),
        };
        let Some(folder) = folder.filter(|f| f.is_absolute() && **f != *self.folder) else {
            return;
        };
        if let Ok(entries) = folder::list(folder, self.kind.extensions()) {
            self.folder = folder.to_owned();
            self.entries = entries;
            self.problem = None;
        }
    }

    /// The name in the path field, kept while a person looks through folders.
    pub(crate) fn name(&self) -> String {
        let path = Path::new(&self.text);
        if path.is_dir() {
            return String::new();
        }
        path.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default()
    }
}

impl FileDialog {
    /// Draws the dialog; `choose` gets the path and whether something is there.
    pub(crate) fn ui<D: Dialog>(
        &mut self,
        ui: &mut Ui,
        choose: impl Fn(PathBuf, bool) -> DialogAnswer<D>,
    ) -> Option<DialogAnswer<D>> {
        title_ui(ui, &self.title);
        let field = ui.add(
            TextEdit::singleline(&mut self.text)
                .desired_width(f32::INFINITY)
                .hint_text(format!("path of a {} file", self.kind.pattern())),
        );
        field.widget_info(|| {
            egui::WidgetInfo::labeled(egui::WidgetType::TextEdit, ui.is_enabled(), "path")
        });
        if field.changed() {
            self.follow_text();
        }
        if self.wants_focus {
            field.request_focus();
            self.wants_focus = false;
        }
        let is_entered = field.lost_focus() && ui.input(|i| i.key_pressed(Key::Enter));
        ui.add_space(6.0);
        let mut chosen = list_ui(ui, self).or(system_choice(self));
        if let Some(problem) = &self.problem {
            warning_ui(ui, problem);
        } else {
            quiet_ui(ui, "Tab and Enter choose; Esc closes");
        }
        ui.add_space(8.0);
        let mut is_closed = false;
        ui.horizontal(|ui| {
            system_ui(ui, self);
            ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
                is_closed = ui.button("Cancel").clicked();
                if ui.button(self.verb).clicked() || is_entered {
                    chosen = Some(PathBuf::from(self.text.trim()));
                }
            });
        });
        if is_closed {
            return Some(DialogAnswer::Close);
        }
        let path = chosen?;
        if path.is_dir() {
            let name = self.name();
            self.go_to(path, &name);
            return None;
        }
        if path.as_os_str().is_empty() {
            self.problem = Some(format!("no path, expected a {} file", self.kind.pattern()));
            self.wants_focus = true;
            return None;
        }
        let exists = path.exists();
        Some(choose(path, exists))
    }
}

/// The way to the system's own dialog.
fn system_ui(ui: &mut Ui, files: &mut FileDialog) {
    let is_open = files.system == SystemChoice::Open;
    let text = RichText::new(match is_open {
        true => "The system dialog is open",
        false => "System dialog…",
    });
    let quiet = text.color(palette::TEXT_QUIET.color32());
    let button = egui::Button::new(quiet).frame(false);
    let response = ui
        .add_enabled(!is_open, button)
        .on_hover_text("The file dialog of this system, where it has one");
    if response.clicked() {
        files.system = SystemChoice::Requested;
        // Whoever answers runs before the next frame is drawn.
        ui.ctx().request_repaint();
    }
}

/// What the system's dialog came to.
fn system_choice(files: &mut FileDialog) -> Option<PathBuf> {
    match std::mem::take(&mut files.system) {
        SystemChoice::Chosen(path) => Some(path),
        SystemChoice::Nothing(why) => {
            files.problem = Some(why);
            None
        }
        waiting => {
            files.system = waiting;
            None
        }
    }
}

/// The folder's list; what was clicked.
fn list_ui(ui: &mut Ui, files: &FileDialog) -> Option<PathBuf> {
    let mut chosen = None;
    egui::Frame::new().fill(palette::FIELD.color32()).corner_radius(3.0).show(ui, |ui| {
        ScrollArea::vertical().max_height(LIST_HEIGHT).auto_shrink(false).show(ui, |ui| {
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
