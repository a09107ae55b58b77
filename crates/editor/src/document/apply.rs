//! Applies requests to the open document, and does what the File menu requests.

use crate::document::autosave::Leftovers;
use crate::document::dialog::DesignDialog;
use crate::document::file_names::{
    default_file_name, file_folder, origin_name, saved_words, with_extension, working_folder,
};
use crate::document::recent::RecentDesigns;
use crate::document::requests::{EditRequest, FileRequest, OpenWorld, SharedChoice, ViewRequest};
use crate::document::selection::{Selected, Selection};
use crate::document::state::{Notice, WorldGeneration};
use crate::runner::results::Results;
use crate::schedule::EditorSystems;
use crate::shell::dialogs::{Dialogs, ErrorDialog};
use bevy::prelude::*;
use bevy::window::{PrimaryWindow, RequestRedraw, WindowCloseRequested, WindowFocused};
use std::path::{Path, PathBuf};
use trackwright_design::{AnatomyEdit, Design, Edit, MetalEdit, Origin};
use trackwright_formats::printable::printable;
use trackwright_project::{SaveReport, StoreError};
use trackwright_simulation::Metric;

/// Applies [`EditRequest`], [`ViewRequest`] and [`FileRequest`] in [`EditorSystems::Edit`], keeps
/// the window's title, and confirms before anything unsaved is lost.
pub struct DocumentPlugin;

/// What to go on with once the design is saved.
#[derive(Resource, Default)]
struct AfterSave(Option<FileRequest>);

impl Plugin for DocumentPlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<AfterSave>()
            .init_resource::<Leftovers>()
            .init_resource::<RecentDesigns>()
            .add_message::<WindowCloseRequested>()
            .add_message::<WindowFocused>()
            .add_systems(
                Update,
                (
                    request_quit,
                    notice_changed_files.run_if(on_message::<WindowFocused>),
                    apply_edits,
                    apply_views,
                    apply_files,
                    drop_lost_selection,
                )
                    .chain()
                    .in_set(EditorSystems::Edit),
            )
            // After the results: no later frame may come to correct it.
            .add_systems(Update, show_title.in_set(EditorSystems::Draw));
    }
}

fn request_quit(
    mut closed: MessageReader<WindowCloseRequested>,
    mut files: MessageWriter<FileRequest>,
) {
    if closed.read().last().is_some() {
        files.write(FileRequest::Quit);
    }
}

/// Whoever comes back to the window may have changed its files elsewhere.
fn notice_changed_files(
    mut focused: MessageReader<WindowFocused>,
    world: Option<Res<OpenWorld>>,
    mut dialogs: ResMut<Dialogs>,
) {
    let is_back = focused.read().last().is_some_and(|window| window.focused);
    let (true, Some(world), None) = (is_back, world, &dialogs.current) else {
        return;
    };
    let changes = trackwright_project::changes(&world.0);
    if !changes.is_empty() {
        dialogs.show(DesignDialog::changed_on_disk(&changes, false));
    }
}

fn apply_edits(
    mut requests: MessageReader<EditRequest>,
    world: Option<ResMut<OpenWorld>>,
    mut selection: ResMut<Selection>,
    mut notice: ResMut<Notice>,
    mut dialogs: ResMut<Dialogs>,
) {
    let Some(mut world) = world else {
        requests.clear();
        return;
    };
    // What was noted together with the request stays.
    let is_noted_now = notice.is_changed();
    for request in requests.read() {
        // The world counts as changed only if it did: the scene is rebuilt from that.
        let document = &mut world.bypass_change_detection().0.document;
        let before = document.shared_design();
        let outcome = match request.clone() {
            EditRequest::Begin(label) => {
                document.begin(label);
                Ok(false)
            }
            EditRequest::Apply(edit) => document.apply(edit),
            EditRequest::Commit => Ok(document.commit()),
            EditRequest::Cancel => Ok(document.cancel()),
            EditRequest::Undo => Ok(document.undo().is_some()),
            EditRequest::Redo => Ok(document.redo().is_some()),
            EditRequest::JumpTo(state) => Ok(document.jump_to(state)),
        };
        match outcome {
            Ok(is_changed) => {
                if !is_noted_now {
                    notice.set_if_neq(Notice::Nothing);
                }
                if is_changed {
                    let after = document.shared_design();
                    let selected = selected_after(&selection, request, &before, &after);
                    selection.set_if_neq(selected);
                    world.set_changed();
                    refresh(&mut world, &mut dialogs);
                }
            }
            Err(error) => {
                notice.set_if_neq(Notice::Refused(error.to_string()));
            }
        }
    }
}

/// What is selected after a request changed the design: the sensors or the body that it added, and after a
/// removal the body that is left; else what was selected before, as far as it is there.
fn selected_after(
    selection: &Selection,
    request: &EditRequest,
    before: &Design,
    after: &Design,
) -> Selection {
    let mut followed = selection.clone();
    followed.follow(before, after);
    match request {
        EditRequest::Apply(
            Edit::Arrange { body, .. }
            | Edit::AddSensor { body, .. }
            | Edit::AddSensors { body, .. },
        ) => {
            let count = |design: &Design| design.body(*body).map_or(0, |b| b.rigid.sensors.len());
            let added = count(before)..count(after);
            if !added.is_empty() {
                return Selection::of_sensors(*body, added);
            }
        }
        EditRequest::Apply(Edit::Anatomy(AnatomyEdit::Add(_))) => {
            let added = after.anatomy.len().checked_sub(1);
            return Selection::of(added.map(Selected::Anatomy));
        }
        EditRequest::Apply(Edit::Metal(MetalEdit::Add(_) | MetalEdit::Replace(Some(_)))) => {
            let count = |design: &Design| design.room_metal.as_ref().map_or(0, |m| m.objects.len());
            if count(after) == count(before) + 1 {
                return Selection::of(Some(Selected::Metal(count(before))));
            }
        }
        EditRequest::Apply(Edit::SetBody { body, .. }) => {
            let file = |design: &Design| design.body(*body).map(|body| body.reference.clone());
            if file(before) != file(after) {
                return Selection::of(Some(Selected::Body(*body)));
            }
        }
        EditRequest::Apply(Edit::RemoveSensor { body, .. } | Edit::RemoveSensors { body, .. })
            if followed.primary().is_none() =>
        {
            return Selection::of(Some(Selected::Body(*body)));
        }
        _ => {}
    }
    followed
}

/// Another room or mesh is read when an edit, or its undo, names it.
fn refresh(world: &mut OpenWorld, dialogs: &mut Dialogs) {
    if let Err(error) = trackwright_project::refresh_environment(&mut world.0) {
        dialogs.show(ErrorDialog::new("The room cannot be opened", &error));
    }
    if let Err(error) = trackwright_project::refresh_meshes(&mut world.0) {
        dialogs.show(ErrorDialog::new("The mesh cannot be opened", &error));
    }
}

fn apply_views(mut requests: MessageReader<ViewRequest>, world: Option<ResMut<OpenWorld>>) {
    let Some(mut world) = world else {
        requests.clear();
        return;
    };
    for request in requests.read() {
        if let ViewRequest::Set(view) = request
            && world.bypass_change_detection().0.document.set_view(view.clone())
        {
            world.set_changed();
        }
    }
}

/// What the file commands work on.
#[derive(bevy::ecs::system::SystemParam)]
struct FileState<'w> {
    world: Option<ResMut<'w, OpenWorld>>,
    generation: ResMut<'w, WorldGeneration>,
    selection: ResMut<'w, Selection>,
    dialogs: ResMut<'w, Dialogs>,
    notice: ResMut<'w, Notice>,
    after_save: ResMut<'w, AfterSave>,
    leftovers: ResMut<'w, Leftovers>,
    recent: ResMut<'w, RecentDesigns>,
    /// Are applied in the next frame.
    edits: MessageWriter<'w, EditRequest>,
    redraw: MessageWriter<'w, RequestRedraw>,
    exit: MessageWriter<'w, AppExit>,
}

fn opened(origin: &Origin) -> Result<trackwright_project::World, StoreError> {
    match origin {
        Origin::File(path) => trackwright_project::open_design_to_show(path),
        Origin::BuiltIn(name) => trackwright_project::open_builtin(name),
    }
}

fn apply_files(mut requests: MessageReader<FileRequest>, mut state: FileState) {
    let requests: Vec<FileRequest> = requests.read().cloned().collect();
    for request in requests {
        state.answer(request);
    }
}

impl FileState<'_> {
    fn answer(&mut self, request: FileRequest) {
        // Another request no longer waits for a save to be done.
        let goes_on = matches!(
            request,
            FileRequest::SaveAs(_) | FileRequest::SaveShared(_) | FileRequest::SaveOver
        );
        if !goes_on {
            self.after_save.0 = None;
        }
        match request {
            // What only shows a dialog loses nothing: the question comes once, with the choice made there.
            FileRequest::New(_)
            | FileRequest::Open(_)
            | FileRequest::OpenBuiltIn(_)
            | FileRequest::OpenEdited { .. }
            | FileRequest::OpenVariant { .. }
            | FileRequest::Reload
            | FileRequest::Quit
                if self.is_dirty() =>
            {
                let file = self.name();
                self.dialogs.show(DesignDialog::unsaved(file, request));
            }
            FileRequest::Discard(then) => self.go_on(*then),
            FileRequest::SaveThen(then) => {
                self.after_save.0 = Some(*then);
                self.save();
            }
            FileRequest::Save => self.save(),
            FileRequest::SaveShared(choice) => self.save_shared(choice),
            FileRequest::ShowSaveAs => self.show_save_as(),
            FileRequest::SaveAs(path) => self.save_as(&path),
            FileRequest::Recover => self.recover(),
            FileRequest::DropLeftover => self.drop_leftover(),
            FileRequest::KeepMine => self.accept_changes(),
            FileRequest::SaveOver => {
                self.accept_changes();
                self.save();
            }
            other => self.go_on(other),
        }
    }

    /// Does what loses the open document, which was saved or given up.
    fn go_on(&mut self, request: FileRequest) {
        match request {
            FileRequest::ShowNew => self.dialogs.show(DesignDialog::New),
            FileRequest::New(starter) => {
                self.open(trackwright_project::open_builtin(starter.name()));
            }
            FileRequest::Reload => self.reload(),
            FileRequest::ShowOpen => {
                let folder = self.folder();
                self.dialogs.show(DesignDialog::open(folder));
            }
            FileRequest::Open(path) => {
                self.open(trackwright_project::open_design_to_show(&path));
            }
            FileRequest::OpenBuiltIn(name) => {
                self.open(trackwright_project::open_builtin(&name));
            }
            FileRequest::OpenEdited { of, label, edits } => {
                let is_open = self.open(opened(&of));
                self.edits.write_batch(EditRequest::step(label, edits).filter(|_| is_open));
                self.redraw.write(RequestRedraw);
            }
            FileRequest::OpenVariant { of, design, suffix } => {
                self.open(trackwright_project::open_variant(&of, *design, &suffix));
            }
            FileRequest::Quit => {
                self.exit.write(AppExit::Success);
            }
            _ => {}
        }
    }

    /// Whether it is open.
    fn open(&mut self, opened: Result<trackwright_project::World, StoreError>) -> bool {
        match opened {
            Ok(mut opened) => {
                let Some(world) = &mut self.world else { return false };
                opened.inherit_meshes(&world.0);
                *self.notice = what_is_missing(&opened);
                world.0 = opened;
                self.generation.0 += 1;
                *self.selection = Selection::default();
                self.remember();
                true
            }
            Err(error) => {
                self.dialogs.show(ErrorDialog::new("The design cannot be opened", &error));
                false
            }
        }
    }

    fn recover(&mut self) {
        let Some(leftover) = self.leftovers.0.first() else {
            return;
        };
        let opened = leftover.open();
        let is_open = opened.is_ok();
        self.open(opened);
        if is_open {
            // The file stays until this session has written its own.
            let leftover = self.leftovers.0.remove(0);
            self.leftovers.1.push(leftover);
        }
    }

    fn drop_leftover(&mut self) {
        if self.leftovers.0.is_empty() {
            return;
        }
        if let Err(error) = self.leftovers.0.remove(0).discard() {
            *self.notice = Notice::Refused(error.to_string());
        }
        if let Some(next) = DesignDialog::recover(&self.leftovers.0) {
            self.dialogs.show(next);
        }
    }

    fn reload(&mut self) {
        let Some(world) = &self.world else { return };
        let origin = world.0.document.origin().clone();
        self.open(opened(&origin));
    }

    fn accept_changes(&mut self) {
        if let Some(world) = &mut self.world {
            trackwright_project::accept_changes(&mut world.0);
        }
    }

    /// A body without its mesh is drawn by its sensors, which is reported.
    fn remember(&mut self) {
        if let Some(world) = &self.world
            && let Origin::File(path) = world.0.document.origin()
            && path.exists()
        {
            self.recent.remember(path);
        }
    }

    fn save(&mut self) {
        let Some(world) = &self.world else { return };
        if matches!(world.0.document.origin(), Origin::BuiltIn(_)) {
            self.show_save_as();
            return;
        }
        let shared = trackwright_project::shared_bodies(&world.0);
        if !shared.is_empty() {
            self.dialogs.show(DesignDialog::shared_bodies(&shared));
            return;
        }
        self.write(trackwright_project::save);
    }

    fn save_as(&mut self, path: &Path) {
        let path = with_extension(path);
        self.write(|world| trackwright_project::save_as(world, &path));
    }

    fn write(
        &mut self,
        write: impl FnOnce(&mut trackwright_project::World) -> Result<SaveReport, StoreError>,
    ) {
        let Some(world) = &mut self.world else { return };
        match write(&mut world.0) {
            Ok(report) => {
                let saved = saved_words(origin_name(world.0.document.origin()), &report.written);
                let kept = report.kept.iter().map(|kept| format!("; {kept}"));
                *self.notice = Notice::Done(format!("{saved}{}", kept.collect::<String>()));
                self.remember();
                if let Some(then) = self.after_save.0.take() {
                    self.go_on(then);
                }
            }
            Err(StoreError::ChangedOnDisk { .. }) => {
                let changes = trackwright_project::changes(&world.0);
                self.dialogs.show(DesignDialog::changed_on_disk(&changes, true));
            }
            Err(error) => {
                self.after_save.0 = None;
                self.dialogs.show(DesignDialog::not_saved(&error));
            }
        }
    }

    fn save_shared(&mut self, choice: SharedChoice) {
        match choice {
            SharedChoice::Overwrite => self.write(trackwright_project::save),
            SharedChoice::Copy => self.write(trackwright_project::save_with_copies),
        }
    }

    fn show_save_as(&mut self) {
        let Some(world) = &self.world else { return };
        let name = default_file_name(&world.0.document);
        let folder = self.folder();
        self.dialogs.show(DesignDialog::save_as(folder, &name));
    }

    fn is_dirty(&self) -> bool {
        self.world.as_ref().is_some_and(|w| w.0.document.is_dirty())
    }

    fn name(&self) -> String {
        self.world.as_ref().map(|w| origin_name(w.0.document.origin())).unwrap_or_default()
    }

    fn folder(&self) -> PathBuf {
        match &self.world {
            Some(world) => file_folder(&world.0),
            None => working_folder(),
        }
    }
}

/// What a design that was opened is shown without: meshes that could not be read, layers of slides
/// that are gone.
pub(crate) fn what_is_missing(world: &trackwright_project::World) -> Notice {
    let meshes = world.mesh_problems();
    let meshes = meshes.iter().map(ToString::to_string);
    let layers = world.document.missing_layers(&world.environment);
    let missing: Vec<String> = meshes.chain(layers).collect();
    match missing.is_empty() {
        true => Notice::Nothing,
        false => Notice::Refused(missing.join("; ")),
    }
}

/// Nothing is selected that is not there, whoever selected it.
fn drop_lost_selection(world: Option<Res<OpenWorld>>, mut selection: ResMut<Selection>) {
    let Some(world) = world else { return };
    let design = world.0.document.design();
    let mut kept = selection.clone();
    kept.follow(design, design);
    selection.set_if_neq(kept);
}

fn show_title(
    world: Option<Res<OpenWorld>>,
    results: Res<Results>,
    window: Option<Single<&mut Window, With<PrimaryWindow>>>,
) {
    let (Some(world), Some(mut window)) = (world, window) else {
        return;
    };
    let title = printable(&title(&world.0.document, &results)).into_owned();
    if window.title != title {
        window.title = title;
    }
}

/// `pointer.design.ron * — 0.49 mm RMS — trackwright`.
pub fn title(document: &trackwright_design::Document, results: &Results) -> String {
    let mut title = origin_name(document.origin());
    if document.is_dirty() {
        title.push_str(" *");
    }
    let study = results.study.as_ref();
    if let Some(rms) = study.and_then(|study| study.value.figures.get(Metric::TIP_RMS)) {
        title.push_str(&format!(" — {} RMS", rms.amount(2, " ")));
    }
    title + " — trackwright"
}
