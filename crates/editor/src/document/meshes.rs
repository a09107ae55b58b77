//! Meshes for bodies, the anatomy and metal objects: read by a thread of its own, confirmed where their size is
//! doubtful, and given to the design as one undo step.

use crate::document::awaited_meshes;
use crate::document::body_dialogs::MeshDialog;
use crate::document::file_names::file_folder;
use crate::document::requests::{EditRequest, FileRequest, MeshRequest, OpenWorld, ViewRequest};
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
use std::collections::HashSet;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use trackwright_design::{
    Anatomy, AnatomyEdit, AnatomyFrame, BodyRole, Design, Edit, Origin, fresh_name,
};
use trackwright_geometry::mesh_reference::MeshUnit;
use trackwright_geometry::pose::Pose;
use trackwright_metal::setup::{ObjectMesh, ObjectShape};
use trackwright_project::{ImportedMesh, MeshImport, MeshOwner, Starter, StoreError, file_name};

/// Gives bodies meshes, and the design its anatomy, on [`MeshRequest`], in
/// [`EditorSystems::Input`]; reads what an opened design leaves to be read.
pub struct MeshesPlugin;

/// The mesh that is being read, if any.
#[derive(Resource, Default)]
pub struct MeshLoading(Option<Loading>);

struct Loading {
    file: PathBuf,
    whose: MeshOwner,
    /// The anatomy's name: its place in the list may be another one by then.
    name: Option<String>,
    /// Whether the person knows the size.
    is_settled: bool,
    job: Job<Result<Read, StoreError>>,
    /// What was open when it began.
    generation: WorldGeneration,
    origin: Origin,
}

/// What was read, and the edits of a design that is made for it.
type Read = (ImportedMesh, Option<Vec<Edit>>);

fn read(wanted: &MeshImport) -> Result<Read, StoreError> {
    let mesh = wanted.read()?;
    let edits = match wanted.whose {
        MeshOwner::NewTool => {
            let name = stem_of(wanted.file(), "tool");
            Some(trackwright_project::new_tool_of_mesh(&mesh, &name)?)
        }
        _ => None,
    };
    Ok((mesh, edits))
}

impl MeshLoading {
    /// Whose a mesh is going to be, and its file.
    pub fn of(&self) -> Option<(MeshOwner, &Path)> {
        let loading = self.0.as_ref()?;
        Some((loading.whose, &loading.file))
    }
}

/// The body that commands about bodies are about: the selected one, else the tool.
pub fn body_of_selection(selection: &Selection) -> BodyRole {
    selected_body(selection).unwrap_or(BodyRole::Tool)
}

/// The body that is selected, or whose sensor or tip is.
pub(crate) fn selected_body(selection: &Selection) -> Option<BodyRole> {
    match selection.primary()? {
        Selected::Body(body) | Selected::Sensor(body, _) | Selected::Tip(body) => Some(body),
        Selected::Anatomy(_) | Selected::Metal(_) => None,
    }
}

fn is_loading(loading: Res<MeshLoading>) -> bool {
    loading.0.is_some()
}

impl Plugin for MeshesPlugin {
    fn build(&self, app: &mut App) {
        app.add_plugins(awaited_meshes::plugin);
        app.init_resource::<MeshLoading>().add_message::<MeshRequest>().add_systems(
            Update,
            (
                answer.run_if(on_message::<MeshRequest>),
                // Whatever else a frame requests, an opened file or to give it up, comes first.
                receive.run_if(is_loading.and_then(not(on_message::<MeshRequest>))),
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
    loading: ResMut<'w, MeshLoading>,
    world: Option<ResMut<'w, OpenWorld>>,
    generation: Res<'w, WorldGeneration>,
    selection: ResMut<'w, Selection>,
    waker: Res<'w, Waker>,
    dialogs: ResMut<'w, Dialogs>,
    notice: ResMut<'w, Notice>,
    edits: MessageWriter<'w, EditRequest>,
    files: MessageWriter<'w, FileRequest>,
    views: MessageWriter<'w, ViewRequest>,
    redraw: MessageWriter<'w, RequestRedraw>,
}

fn answer(mut requests: MessageReader<MeshRequest>, mut requested: Requested) {
    for request in requests.read() {
        requested.answer(request.clone());
    }
    requested.redraw.write(RequestRedraw);
}

fn receive(mut requested: Requested) {
    let loading = &mut requested.loading.bypass_change_detection().0;
    let Some(answer) = loading.as_ref().and_then(|it| it.job.answer()) else {
        return;
    };
    if let Some(loading) = requested.loading.0.take() {
        requested.take(&loading, answer);
    }
    requested.redraw.write(RequestRedraw);
}

impl Requested<'_> {
    fn answer(&mut self, request: MeshRequest) {
        match request {
            MeshRequest::ShowLoad(whose) => {
                let Some(world) = &self.world else { return };
                let folder = mesh_folder(&world.0, whose);
                self.dialogs.show(MeshDialog::load(folder, whose));
            }
            MeshRequest::Drop(file) => {
                let Some(world) = &self.world else { return };
                let has_crf = world.0.document.design().crf.is_some();
                match selected_body(&self.selection) {
                    Some(body) => self.load(body.into(), file, None),
                    None => self.dialogs.show(MeshDialog::Whose { file, has_crf }),
                }
            }
            MeshRequest::Load { whose, file, unit } => self.load(whose, file, unit),
            MeshRequest::SetUnit { whose, unit } => {
                let Some(world) = &self.world else { return };
                let wanted = MeshImport::in_unit(&world.0, whose, unit);
                let file = match &wanted {
                    Ok(Some(wanted)) => wanted.file().to_owned(),
                    _ => return,
                };
                self.start(wanted, file, true);
            }
            MeshRequest::GiveUp => {
                self.loading.0 = None;
                *self.notice = Notice::Nothing;
            }
        }
    }

    fn load(&mut self, whose: MeshOwner, file: PathBuf, unit: Option<MeshUnit>) {
        let Some(world) = &self.world else { return };
        let wanted = MeshImport::of_file(&world.0, whose, &file, unit);
        self.start(wanted, file, unit.is_some());
    }

    /// What was being read for a body before is given up.
    fn start(
        &mut self,
        wanted: Result<Option<MeshImport>, StoreError>,
        file: PathBuf,
        is_settled: bool,
    ) {
        let (Ok(Some(wanted)), Some(world)) = (wanted, &self.world) else {
            *self.notice = Notice::Refused("the design has no such body".to_owned());
            return;
        };
        let whose = wanted.whose;
        *self.notice = Notice::Done(format!("Reading {}…", file_name(&file)));
        self.loading.0 = Some(Loading {
            file,
            whose,
            name: anatomy_at(world.0.document.design(), whose).map(|a| a.name.clone()),
            is_settled,
            job: Job::start("mesh", &self.waker, move |_| read(&wanted)),
            generation: *self.generation,
            origin: world.0.document.origin().clone(),
        });
    }

    /// Gives the body or the anatomy what was read, unless something else is open by now or its size
    /// is one to confirm.
    fn take(&mut self, loading: &Loading, answer: Result<Result<Read, StoreError>, Lost>) {
        *self.notice = Notice::Nothing;
        let Some(world) = &mut self.world else { return };
        let is_same =
            loading.generation == *self.generation && loading.origin == *world.0.document.origin();
        if !is_same {
            return;
        }
        let (read, of_new_design) = match answer {
            Ok(Ok(read)) => read,
            Ok(Err(error)) => {
                self.dialogs.show(ErrorDialog::new(NOT_USABLE, &error));
                return;
            }
            Err(lost) => {
                let text = format!("{}: {lost}", loading.file.display());
                self.dialogs.show(ErrorDialog { title: NOT_USABLE.to_owned(), text });
                return;
            }
        };
        let doubt = read.report.suggestion.filter(|_| !loading.is_settled);
        if let (Some(edits), None) = (of_new_design, &doubt) {
            let of = Origin::BuiltIn(Starter::Tool.name());
            let label = format!("New tool from {}", file_name(&loading.file));
            self.files.write(FileRequest::OpenEdited { of, label, edits });
        }
        let edit = edit_of(&world.0, loading, &read);
        // Unless it is read again, nothing that is shown changes before the edit does it.
        if world.bypass_change_detection().0.keep_mesh(read) {
            world.set_changed();
        }
        if let Some(sizes) = doubt {
            self.dialogs.show(MeshDialog::Unit {
                whose: loading.whose,
                file: loading.file.clone(),
                sizes,
            });
            return;
        }
        if loading.whose == MeshOwner::NewTool {
            return;
        }
        let Some(edit) = edit else {
            *self.notice = Notice::Refused("the anatomy is not there any more".to_owned());
            return;
        };
        let mut view = world.0.document.view().clone();
        self.edits.write(EditRequest::Apply(edit));
        match loading.whose {
            MeshOwner::Body(role) => {
                let body = Selection::of(Some(Selected::Body(role)));
                self.selection.set_if_neq(body);
            }
            // Nobody adds what is not to be seen.
            MeshOwner::Anatomy(_) if !view.layers.anatomy => {
                view.layers.anatomy = true;
                self.views.write(ViewRequest::Set(view));
            }
            MeshOwner::Anatomy(_) | MeshOwner::NewMetal | MeshOwner::NewTool => {}
        }
    }
}

/// A name from the file's.
fn stem_of(file: &Path, otherwise: &str) -> String {
    let stem = file.file_stem().unwrap_or_default().to_string_lossy();
    match stem.trim() {
        "" => otherwise.to_owned(),
        stem => stem.to_owned(),
    }
}

const NOT_USABLE: &str = "The mesh cannot be used";

/// The edit that gives a mesh to whom it was read for; `None` where that is gone meanwhile.
fn edit_of(
    world: &trackwright_project::World,
    loading: &Loading,
    read: &ImportedMesh,
) -> Option<Edit> {
    let design = world.document.design();
    let mesh = read.request.reference.clone();
    let named = |otherwise: &str| stem_of(&loading.file, otherwise);
    Some(match loading.whose {
        MeshOwner::Body(body) => Edit::SetMesh { body, mesh: Some(mesh) },
        MeshOwner::Anatomy(Some(_)) => {
            let name = loading.name.as_ref()?;
            let index = design.anatomy.iter().position(|a| a.name == *name)?;
            let anatomy = design.anatomy[index].clone();
            Edit::Anatomy(AnatomyEdit::Set {
                index,
                anatomy: Box::new(Anatomy { mesh, ..anatomy }),
            })
        }
        MeshOwner::Anatomy(None) => {
            let name = named("anatomy");
            let taken: HashSet<String> = design.anatomy.iter().map(|a| a.name.clone()).collect();
            Edit::Anatomy(AnatomyEdit::Add(Box::new(Anatomy {
                name: match taken.contains(&name) {
                    true => fresh_name(&name, &taken),
                    false => name,
                },
                mesh,
                on: match design.crf {
                    Some(_) => AnatomyFrame::Crf,
                    None => AnatomyFrame::Tracker,
                },
                frame_from_mesh: Pose::identity(),
                color: None,
                crf_patch: Vec::new(),
            })))
        }
        MeshOwner::NewTool => return None,
        MeshOwner::NewMetal => {
            let surface = Arc::clone(&read.surface);
            let shape = ObjectShape::Mesh(ObjectMesh { reference: mesh, surface });
            world.added_metal(shape, &named("mesh"))
        }
    })
}

/// The anatomy that a mesh is read for, where it is in the design already.
fn anatomy_at(design: &Design, whose: MeshOwner) -> Option<&Anatomy> {
    match whose {
        MeshOwner::Anatomy(index) => design.anatomy.get(index?),
        MeshOwner::Body(_) | MeshOwner::NewMetal | MeshOwner::NewTool => None,
    }
}

/// Beside the present mesh, or that of the anatomy that came last, if it is on the disk; else beside
/// the design.
fn mesh_folder(world: &trackwright_project::World, whose: MeshOwner) -> PathBuf {
    let last = world.document.design().anatomy.len().checked_sub(1);
    let whose = match whose {
        MeshOwner::Anatomy(None) => MeshOwner::Anatomy(last),
        other => other,
    };
    let own = MeshImport::in_unit(world, whose, None).ok().flatten();
    own.and_then(|own| Some(own.file().parent()?.to_path_buf()))
        .filter(|folder| folder.is_absolute() && folder.is_dir())
        .unwrap_or_else(|| file_folder(world))
}
