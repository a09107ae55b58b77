//! Bodies from files and back: makers' tool definitions and body files, read by a thread of its
//! own, confirmed where a checksum does not match, and given to the design as one undo step;
//! and the selected body written as such a file, once what is lost was read.

use crate::document::body_dialogs::BodyDialog;
use crate::document::file_names::file_folder;
use crate::document::meshes::selected_body;
use crate::document::requests::{BodyFileRequest, EditRequest, OpenWorld};
use crate::document::selection::{Selected, Selection};
use crate::document::state::{Notice, WorldGeneration};
use crate::runner::jobs::{Job, Lost};
use crate::runner::wake::Waker;
use crate::schedule::EditorSystems;
use crate::shell::commands::CommandsSystems;
use crate::shell::dialogs::{Dialogs, ErrorDialog};
use bevy::ecs::system::SystemParam;
use bevy::prelude::*;
use bevy::window::RequestRedraw;
use std::path::{Path, PathBuf};
use trackwright_design::{BodyRole, CrfPlacement, Design, DesignBody, Edit, Origin};
use trackwright_formats::tool_definition::OnMismatch;
use trackwright_project::{BodyExport, BodyImport, ImportedBody, StoreError, file_name};

/// Carries out [`BodyFileRequest`], in [`EditorSystems::Input`].
pub struct BodyFilesPlugin;

/// The file that is being read, if any.
#[derive(Resource, Default)]
pub struct BodyLoading {
    reading: Option<Loading>,
    /// Where a file was chosen last: makers' files are rarely beside the design.
    folder: Option<PathBuf>,
}

struct Loading {
    file: PathBuf,
    body: BodyRole,
    job: Job<Result<ImportedBody, StoreError>>,
    /// What was open when it began.
    generation: WorldGeneration,
    origin: Origin,
}

impl BodyLoading {
    /// The body that a file is read for, and the file.
    pub fn of(&self) -> Option<(BodyRole, &Path)> {
        let loading = self.reading.as_ref()?;
        Some((loading.body, &loading.file))
    }
}

fn is_loading(loading: Res<BodyLoading>) -> bool {
    loading.reading.is_some()
}

impl Plugin for BodyFilesPlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<BodyLoading>().add_message::<BodyFileRequest>().add_systems(
            Update,
            (
                answer.run_if(on_message::<BodyFileRequest>),
                // Whatever else a frame requests, an opened file or to give it up, comes first.
                receive.run_if(is_loading.and_then(not(on_message::<BodyFileRequest>))),
            )
                .chain()
                .after(CommandsSystems)
                .in_set(EditorSystems::Input),
        );
    }
}

/// What the requests work on.
#[derive(SystemParam)]
struct Requested<'w> {
    loading: ResMut<'w, BodyLoading>,
    world: Option<ResMut<'w, OpenWorld>>,
    generation: Res<'w, WorldGeneration>,
    selection: ResMut<'w, Selection>,
    waker: Res<'w, Waker>,
    dialogs: ResMut<'w, Dialogs>,
    notice: ResMut<'w, Notice>,
    edits: MessageWriter<'w, EditRequest>,
    redraw: MessageWriter<'w, RequestRedraw>,
}

fn answer(mut requests: MessageReader<BodyFileRequest>, mut requested: Requested) {
    for request in requests.read() {
        requested.answer(request.clone());
    }
    requested.redraw.write(RequestRedraw);
}

fn receive(mut requested: Requested) {
    // Receiving alone is no change.
    let loading = &mut requested.loading.bypass_change_detection().reading;
    let Some(answer) = loading.as_ref().and_then(|it| it.job.answer()) else {
        return;
    };
    if let Some(loading) = requested.loading.reading.take() {
        requested.take(loading, answer);
    }
    requested.redraw.write(RequestRedraw);
}

impl Requested<'_> {
    fn answer(&mut self, request: BodyFileRequest) {
        let Some(world) = &self.world else { return };
        let design = world.0.document.design();
        match request {
            BodyFileRequest::ShowOpen(body) => {
                let last = self.loading.folder.clone().filter(|folder| folder.is_dir());
                let folder = last.unwrap_or_else(|| file_folder(&world.0));
                self.dialogs.show(BodyDialog::open(folder, body));
            }
            BodyFileRequest::Drop(file) => {
                match (selected_body(&self.selection), design.crf.is_some()) {
                    (Some(body), _) => self.open(body, file, OnMismatch::Refuse),
                    (None, false) => self.open(BodyRole::Tool, file, OnMismatch::Refuse),
                    (None, true) => self.dialogs.show(BodyDialog::ToolOrCrf { file }),
                }
            }
            BodyFileRequest::Open { body, file, on_mismatch } => self.open(body, file, on_mismatch),
            BodyFileRequest::GiveUp => {
                self.loading.reading = None;
                *self.notice = Notice::Nothing;
            }
            BodyFileRequest::ShowSave(body) => {
                let Some(own) = design.body(body) else {
                    *self.notice = Notice::Refused(NO_SUCH_BODY.to_owned());
                    return;
                };
                let folder = file_folder(&world.0);
                let name = trackwright_project::definition_name(own, &folder);
                self.dialogs.show(BodyDialog::save(folder, &name, body));
            }
            BodyFileRequest::Save { body, file } => self.save(body, &file, false),
            BodyFileRequest::Write { body, file } => self.save(body, &file, true),
        }
    }

    /// What was being read before is given up.
    fn open(&mut self, body: BodyRole, file: PathBuf, on_mismatch: OnMismatch) {
        let Some(world) = &self.world else { return };
        let wanted = match BodyImport::of_file(&world.0, body, &file, on_mismatch) {
            Ok(wanted) => wanted,
            Err(error) => {
                self.dialogs.show(ErrorDialog::new(NOT_USABLE, &error));
                return;
            }
        };
        *self.notice = Notice::Done(format!("Reading {}…", file_name(&file)));
        self.loading.folder = file.parent().map(Path::to_path_buf);
        self.loading.reading = Some(Loading {
            file,
            body,
            job: Job::start("body", &self.waker, move |_| wanted.read()),
            generation: *self.generation,
            origin: world.0.document.origin().clone(),
        });
    }

    /// Puts what was read into the design, unless something else is open by now or its bytes are
    /// ones to confirm.
    fn take(&mut self, loading: Loading, answer: Result<Result<ImportedBody, StoreError>, Lost>) {
        *self.notice = Notice::Nothing;
        let Some(world) = &mut self.world else { return };
        let is_same =
            loading.generation == *self.generation && loading.origin == *world.0.document.origin();
        if !is_same {
            return;
        }
        let Loading { file, body, .. } = loading;
        let taken = match answer {
            Ok(Ok(taken)) => taken,
            Ok(Err(error)) if error.is_checksum() => {
                let text = error.to_string();
                self.dialogs.show(BodyDialog::Checksum { body, file, text });
                return;
            }
            Ok(Err(error)) => {
                self.dialogs.show(ErrorDialog::new(NOT_USABLE, &error));
                return;
            }
            Err(lost) => {
                let text = format!("{}: {lost}", file.display());
                self.dialogs.show(ErrorDialog { title: NOT_USABLE.to_owned(), text });
                return;
            }
        };
        if world.0.document.design().body(body) == Some(&taken.body) {
            let name = file_name(&file);
            *self.notice = Notice::Done(format!("The {body} already matches {name}"));
        } else {
            // Nothing that is shown changes before the edit does it.
            world.bypass_change_detection().0.keep_body(&taken);
            let edit = edit_of(world.0.document.design(), body, taken.body);
            self.edits.write(EditRequest::Apply(edit));
        }
        let selected = Selection::of(Some(Selected::Body(body)));
        self.selection.set_if_neq(selected);
    }

    /// Writes a body, once what is lost by it, and that something else is, was agreed to.
    fn save(&mut self, body: BodyRole, file: &Path, is_agreed: bool) {
        let Some(world) = &self.world else { return };
        let export = match BodyExport::of(&world.0, body, file) {
            Ok(Some(export)) => export,
            Ok(None) => {
                *self.notice = Notice::Refused(NO_SUCH_BODY.to_owned());
                return;
            }
            Err(error) => {
                self.dialogs.show(ErrorDialog::new(NOT_WRITTEN, &error));
                return;
            }
        };
        let (notes, exists) = (export.notes(), file.exists());
        if !is_agreed && (exists || !notes.is_empty()) {
            self.dialogs.show(BodyDialog::Write {
                body,
                file: file.to_owned(),
                kind: export.kind_name(),
                notes,
                exists,
            });
            return;
        }
        match export.write() {
            Ok(()) => {
                let (kind, file) = (export.kind_name(), file.display());
                *self.notice = Notice::Done(format!("Wrote the {body} as {kind} to {file}"));
            }
            Err(error) => self.dialogs.show(ErrorDialog::new(NOT_WRITTEN, &error)),
        }
    }
}

/// Puts a body in the place of the present one, or gives the design the CRF that it lacks.
fn edit_of(design: &Design, role: BodyRole, body: DesignBody) -> Edit {
    if design.body(role).is_some() {
        return Edit::SetBody { body: role, content: Box::new(body) };
    }
    Edit::AddCrf(Box::new(CrfPlacement {
        body,
        tracker_from_crf: design.pose_of_new_crf(),
        targets: Vec::new(),
        motion: None,
        requirement: None,
    }))
}

const NO_SUCH_BODY: &str = "the design has no such body";
const NOT_USABLE: &str = "The tool definition cannot be used";
const NOT_WRITTEN: &str = "The tool definition cannot be written";
