//! Chooses a file to open or a place to save: a field for the name above a list of the folder.

use crate::document::file_names::{DESIGN_EXTENSION, with_extension};
use crate::palette;
use crate::palette::ThemedColor;
use crate::shell::dialogs::folder::{self, Entry};
use crate::shell::dialogs::{Dialog, DialogAnswer, title_ui};
use crate::widgets::basic::{Row, main_button, quiet_ui, row_ui, warning_ui};
use crate::widgets::theme;
use bevy_egui::egui::text::{CCursor, CCursorRange};
use bevy_egui::egui::{
    self, Align, FocusDirection, Id, Key, Label, Layout, Modifiers, Response, RichText, ScrollArea,
    TextEdit, Ui, vec2,
};
use std::ops::Range;
use std::path::{Path, PathBuf, is_separator};
use trackwright_formats::printable::printable;
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
    pub takes_several: bool,
    /// The folder that is listed: where what is typed leads.
    pub folder: PathBuf,
    /// What a typed name counts from.
    base: PathBuf,
    pub entries: Vec<Entry>,
    /// The field: a name, or a path from the folder.
    pub text: String,
    /// The name that the field began with.
    suggestion: String,
    /// The files that were clicked, where several are taken.
    pub marked: Vec<PathBuf>,
    /// What the list is narrowed to; a name that was only suggested narrows nothing.
    filter: String,
    /// The next of the names that Tab goes through, where they agree no further.
    next_match: usize,
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
    ChosenSeveral(Vec<PathBuf>),
    /// Why there is no choice, in words.
    Nothing(String),
}

/// What kind of file a dialog lists.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FileKind {
    Design,
    Table,
    Room,
    /// A field generator.
    Generator,
    Mesh,
    /// A report.
    Page,
    /// A tool definition or a body file.
    Body,
    /// The field on a lattice, for other programs.
    Lattice,
    /// The tips of a study, for other programs.
    Tips,
    /// The 3D view, for other programs.
    Scene,
    /// The rows of a sweep: a merged table, or the plan in their folder.
    Sweep,
}

impl FileKind {
    /// How such files' names end; the first is that of a name without an ending.
    pub fn extensions(self) -> &'static [&'static str] {
        match self {
            Self::Design => &[DESIGN_EXTENSION],
            Self::Table => &[".csv"],
            Self::Room => &[ENVIRONMENT_EXTENSION],
            Self::Generator => &[".generator.ron"],
            Self::Mesh => &[".glb", ".gltf", ".stl", ".obj"],
            Self::Page => &[".html"],
            Self::Body => &[".rom", ".tool", ".ini", ".json", ".body.ron"],
            Self::Lattice => &[".nrrd", ".mha", ".vti", ".csv"],
            Self::Tips => &[".mrk.json", ".csv"],
            Self::Scene => &[".glb"],
            Self::Sweep => &[".parquet", ".sweep.ron"],
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
            Self::Generator => "field generator",
            Self::Mesh => "mesh",
            Self::Page => "page",
            Self::Body => "tool definition",
            Self::Lattice => "field",
            Self::Tips => "tips",
            Self::Scene => "scene",
            Self::Sweep => "sweep",
        }
    }

    /// A file to write, with the ending that a person left out. That of a tool definition is a choice
    /// of its format.
    fn named(self, file: PathBuf) -> PathBuf {
        let file = self.with_one_ending(file);
        match self {
            Self::Design => with_extension(&file),
            Self::Body => file,
            _ if file.extension().is_some() => file,
            _ => ending_with(&file, self.extensions()[0]),
        }
    }

    /// Only the letters before the ending are selected: whoever types a whole name has its ending twice.
    fn with_one_ending(self, file: PathBuf) -> PathBuf {
        let Some(text) = file.to_str() else { return file };
        let doubled = self.extensions().iter().find(|end| text.ends_with(&end.repeat(2)));
        match doubled {
            Some(end) => text[..text.len() - end.len()].into(),
            None => file,
        }
    }

    /// A file to open: one of this kind, where a person left its ending out.
    fn found(self, file: PathBuf) -> PathBuf {
        let mut others = self.extensions().iter().map(|end| ending_with(&file, end));
        match file.exists() {
            true => file,
            false => others.find(|other| other.exists()).unwrap_or(file),
        }
    }

    /// The letters of a name without its ending.
    fn stem(self, name: &str) -> Range<usize> {
        let lower = name.to_lowercase();
        let own = self.extensions().iter().filter(|end| lower.ends_with(*end));
        let ending = own.map(|end| end.chars().count()).max();
        let all = name.chars().count();
        let first_dot = name.chars().position(|letter| letter == '.').filter(|dot| *dot > 0);
        0..ending.map_or(first_dot.unwrap_or(all), |ending| all - ending)
    }
}

fn ending_with(file: &Path, end: &str) -> PathBuf {
    let mut name = file.as_os_str().to_owned();
    name.push(end);
    name.into()
}

/// What is typed, as a folder's part with its separator and a name.
fn parts(text: &str) -> (&str, &str) {
    text.split_at(text.rfind(is_separator).map_or(0, |at| at + 1))
}

impl FileDialog {
    pub(crate) fn new(kind: FileKind, folder: PathBuf, name: &str) -> Self {
        let mut dialog = Self {
            kind,
            title: String::new(),
            verb: "Open",
            is_saving: false,
            takes_several: false,
            text: String::new(),
            suggestion: name.to_owned(),
            folder: PathBuf::new(),
            base: PathBuf::new(),
            entries: Vec::new(),
            marked: Vec::new(),
            filter: String::new(),
            next_match: 0,
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

    /// To open several files at once.
    pub(crate) fn several(self) -> Self {
        Self { takes_several: true, ..self }
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
        self.text = name.to_owned();
        self.base.clone_from(&folder);
        self.folder = folder;
        self.filter.clear();
        self.next_match = 0;
        self.marked.clear();
        self.wants_focus = true;
    }

    /// Lists the folder that is typed as soon as there is one of that name, and what the name can
    /// mean there.
    fn follow_text(&mut self) {
        let (folder, name) = parts(self.text.trim());
        self.filter = name.to_owned();
        self.next_match = 0;
        self.problem = None;
        let folder = match folder {
            "" => self.base.clone(),
            folder => self.base.join(folder),
        };
        if folder == self.folder {
            return;
        }
        if let Ok(entries) = folder::list(&folder, self.kind.extensions()) {
            self.folder = folder;
            self.entries = entries;
        }
    }

    /// Completes what is typed as far as all names agree that begin with it; from there on it takes
    /// one of them after the other. Whether there was anything to complete.
    fn complete(&mut self) -> bool {
        let (folder, name) = parts(&self.text);
        let folder = folder.to_owned();
        // With nothing typed, the key goes on to the list.
        if name.is_empty() || (self.filter.is_empty() && name == self.suggestion) {
            return false;
        }
        if let Some(completed) =
            folder::completed(&self.entries, name).filter(|_| self.next_match == 0)
        {
            self.text = folder + &completed;
            self.follow_text();
            return true;
        }
        let all = folder::beginning_with(&self.entries, &self.filter);
        if all.len() < 2 {
            return false;
        }
        self.text = folder + all[self.next_match % all.len()].name();
        self.next_match += 1;
        true
    }

    /// The name in the field, kept while a person looks through folders.
    pub(crate) fn name(&self) -> String {
        if self.path().is_none_or(|path| path.is_dir()) {
            return match self.is_saving {
                true => self.suggestion.clone(),
                false => String::new(),
            };
        }
        parts(self.text.trim()).1.to_owned()
    }

    /// Where what is typed leads; `None` with nothing typed.
    fn path(&self) -> Option<PathBuf> {
        let text = self.text.trim();
        (!text.is_empty()).then(|| self.base.join(text))
    }
}

/// What a dialog's frame came to.
enum Picked {
    Close,
    Files(Vec<PathBuf>),
}

impl FileDialog {
    /// Draws the dialog; `choose` gets the path and whether something is there.
    pub(crate) fn ui<D: Dialog>(
        &mut self,
        ui: &mut Ui,
        choose: impl Fn(PathBuf, bool) -> DialogAnswer<D>,
    ) -> Option<DialogAnswer<D>> {
        match self.picked_ui(ui)? {
            Picked::Close => Some(DialogAnswer::Close),
            Picked::Files(files) => {
                let file = files.into_iter().next()?;
                let exists = file.exists();
                Some(choose(file, exists))
            }
        }
    }

    /// The same where several files can be chosen.
    pub(crate) fn several_ui<D: Dialog>(
        &mut self,
        ui: &mut Ui,
        choose: impl Fn(Vec<PathBuf>) -> DialogAnswer<D>,
    ) -> Option<DialogAnswer<D>> {
        Some(match self.picked_ui(ui)? {
            Picked::Close => DialogAnswer::Close,
            Picked::Files(files) => choose(files),
        })
    }

    fn picked_ui(&mut self, ui: &mut Ui) -> Option<Picked> {
        title_ui(ui, &self.title);
        let folder = printable(&self.folder.display().to_string()).into_owned();
        let quiet = RichText::new(folder).font(theme::label_font());
        ui.add(Label::new(quiet.color(palette::TEXT_QUIET.color32())).truncate());
        let field = field_ui(ui, self);
        let is_entered = field.lost_focus() && ui.input(|i| i.key_pressed(Key::Enter));
        ui.add_space(6.0);
        let mut chosen = list_ui(ui, self).or(system_choice(self));
        if let Some(problem) = &self.problem {
            warning_ui(ui, problem);
        } else {
            let clicks = if self.takes_several { "Clicks mark files; " } else { "" };
            let enter = self.verb.to_lowercase();
            quiet_ui(ui, format!("{clicks}Tab completes a name; Enter: {enter}; Esc closes"));
        }
        ui.add_space(8.0);
        let mut is_closed = false;
        ui.horizontal(|ui| {
            system_ui(ui, self);
            ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
                is_closed = ui.button("Cancel").clicked();
                let verb = match self.marked.len() {
                    0 | 1 => self.verb.to_owned(),
                    many => format!("{} {many}", self.verb),
                };
                if ui.add(main_button(&verb)).clicked() || is_entered {
                    let mut files = std::mem::take(&mut self.marked);
                    files.extend(self.path());
                    chosen = Some(files);
                }
            });
        });
        if is_closed {
            return Some(Picked::Close);
        }
        self.checked(chosen?).map(Picked::Files)
    }

    /// The files that were chosen, unless there are none, one is a folder to go to, or cannot be
    /// written: nothing is lost by that, and the dialog stays.
    fn checked(&mut self, files: Vec<PathBuf>) -> Option<Vec<PathBuf>> {
        let is_one = files.len() == 1;
        if let Some(folder) = files.first().filter(|file| is_one && file.is_dir()) {
            let name = self.name();
            self.go_to(folder.clone(), &name);
            return None;
        }
        self.problem = None;
        let whole = |file| match self.is_saving {
            true => self.kind.named(file),
            false => self.kind.found(file),
        };
        let files: Vec<PathBuf> = files.into_iter().map(whole).collect();
        if files.is_empty() {
            self.problem =
                Some(format!("no name, expected that of a {} file", self.kind.pattern()));
        } else if self.is_saving {
            let written = files.iter().map(|file| trackwright_project::check_place(file));
            let refused = written.filter_map(Result::err).next();
            self.problem = refused.map(|why| format!("{why}; choose another folder"));
        }
        match self.problem {
            None => Some(files),
            Some(_) => {
                self.wants_focus = true;
                None
            }
        }
    }
}

/// The field for the name, which has the keys and its name selected from the start.
fn field_ui(ui: &mut Ui, files: &mut FileDialog) -> Response {
    let id = ui.make_persistent_id("file name");
    if ui.memory(|memory| memory.has_focus(id)) {
        tab_ui(ui, id, files);
    }
    let field = ui.add(
        TextEdit::singleline(&mut files.text)
            .id(id)
            .desired_width(f32::INFINITY)
            .hint_text(format!("name of a {} file, or a path", files.kind.pattern()))
            // Tab completes.
            .lock_focus(true),
    );
    field.widget_info(|| {
        egui::WidgetInfo::labeled(egui::WidgetType::TextEdit, ui.is_enabled(), "path")
    });
    if field.changed() {
        files.follow_text();
    }
    if files.wants_focus {
        files.wants_focus = false;
        field.request_focus();
        let before = parts(&files.text).0.chars().count();
        let stem = files.kind.stem(parts(&files.text).1);
        select(ui, id, before + stem.start..before + stem.end);
    }
    field
}

/// Completes what is typed; where there is nothing to complete, the focus moves on.
fn tab_ui(ui: &Ui, id: Id, files: &mut FileDialog) {
    let (is_back, is_on) = ui.input_mut(|input| {
        let is_back = input.consume_key(Modifiers::SHIFT, Key::Tab);
        (is_back, input.consume_key(Modifiers::NONE, Key::Tab))
    });
    if is_back {
        ui.memory_mut(|memory| memory.move_focus(FocusDirection::Previous));
    } else if is_on && files.complete() {
        let end = files.text.chars().count();
        select(ui, id, end..end);
    } else if is_on {
        ui.memory_mut(|memory| memory.move_focus(FocusDirection::Next));
    }
}

/// Selects letters of a field; egui would keep what was selected when it was shown last.
fn select(ui: &Ui, id: Id, letters: Range<usize>) {
    let mut state = TextEdit::load_state(ui.ctx(), id).unwrap_or_default();
    let range = CCursorRange::two(CCursor::new(letters.start), CCursor::new(letters.end));
    state.cursor.set_char_range(Some(range));
    state.store(ui.ctx(), id);
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
fn system_choice(files: &mut FileDialog) -> Option<Vec<PathBuf>> {
    match std::mem::take(&mut files.system) {
        SystemChoice::Chosen(path) => Some(vec![path]),
        SystemChoice::ChosenSeveral(paths) => Some(paths),
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

/// The folder's list, as far as it can be meant; what was clicked.
fn list_ui(ui: &mut Ui, files: &mut FileDialog) -> Option<Vec<PathBuf>> {
    let mut clicked: Option<(PathBuf, bool)> = None;
    let shown = folder::filtered(&files.entries, &files.filter);
    egui::Frame::new().fill(palette::FIELD.color32()).corner_radius(3.0).show(ui, |ui| {
        ScrollArea::vertical().max_height(LIST_HEIGHT).auto_shrink(false).show(ui, |ui| {
            ui.spacing_mut().item_spacing = vec2(0.0, 0.0);
            for entry in &shown {
                let path = entry.path(&files.folder);
                let row = Row {
                    label: entry.name(),
                    note: match entry {
                        Entry::Up => "folder above",
                        Entry::Folder(_) => "folder",
                        Entry::File(_) => files.kind.note(),
                    },
                    is_selected: files.marked.contains(&path),
                    ..Row::default()
                };
                if row_ui(ui, &row).clicked() {
                    clicked = Some((path, matches!(entry, Entry::File(_))));
                }
            }
            if shown.iter().all(|entry| **entry == Entry::Up) && !files.filter.is_empty() {
                quiet_ui(ui, format!("  nothing here has {:?} in its name", files.filter));
            }
        });
    });
    ui.add_space(theme::ROW_HEIGHT / 4.0);
    let (path, is_file) = clicked?;
    if !(files.takes_several && is_file) {
        return Some(vec![path]);
    }
    match files.marked.iter().position(|marked| *marked == path) {
        Some(at) => {
            files.marked.remove(at);
        }
        None => files.marked.push(path),
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_stem_is_what_a_person_would_change() {
        let stem = |kind: FileKind, name: &str| kind.stem(name).end;
        assert_eq!(stem(FileKind::Design, "pointer.design.ron"), 7);
        assert_eq!(stem(FileKind::Body, "pointer.body.ron"), 7);
        assert_eq!(stem(FileKind::Tips, "größe.mrk.json"), 5);
        assert_eq!(stem(FileKind::Table, "a.log.csv"), 5);
        assert_eq!(stem(FileKind::Design, "a.txt"), 1);
        assert_eq!(stem(FileKind::Design, "plain"), 5);
    }

    #[test]
    fn an_ending_that_was_left_out_is_added() {
        let named = |kind: FileKind, name: &str| kind.named(name.into());
        assert_eq!(named(FileKind::Design, "a"), Path::new("a.design.ron"));
        let twice = "b/a.design.ron.design.ron";
        assert_eq!(named(FileKind::Design, twice), Path::new("b/a.design.ron"));
        assert_eq!(named(FileKind::Page, "a"), Path::new("a.html"));
        assert_eq!(named(FileKind::Lattice, "a.vti"), Path::new("a.vti"));
        assert_eq!(named(FileKind::Body, "a"), Path::new("a"));
    }
}
