//! Meshes for bodies: read by a thread of its own, asked about where their size is doubtful, and
//! given to the design as one undo step.

use super::background::{Ended, Job};
use super::commands::CommandsSystems;
use super::document::{Notice, WorldGeneration, file_folder};
use super::state::{EditRequest, EditorSystems, OpenWorld, Selected, Selection};
use super::ui::dialogs::{Dialog, Dialogs};
use super::wake::Waker;
use crate::design::{BodyRole, Edit, Origin};
use crate::geometry::mesh_reference::MeshUnit;
use crate::store::{ReadMesh, StoreError, WantedMesh};
use bevy::ecs::system::SystemParam;
use bevy::prelude::*;
use bevy::window::RequestRedraw;
use std::path::{Path, PathBuf};

/// Gives bodies meshes when [`MeshRequest`] asks, in [`EditorSystems::Input`].
pub struct MeshesPlugin;

/// Asks for something with the mesh of a body.
#[derive(Message, Clone, Debug, PartialEq)]
pub enum MeshRequest {
    /// Shows the dialog that chooses a file.
    ShowLoad(BodyRole),
    /// A file was dropped: for the body under selection, or whichever the person says.
    Drop(PathBuf),
    Load {
        body: BodyRole,
        file: PathBuf,
        /// `None` is that of the format, and asked about where the size is doubtful.
        unit: Option<MeshUnit>,
    },
    /// Reads the body's own mesh in another unit, or in that of its format.
    SetUnit {
        body: BodyRole,
        unit: Option<MeshUnit>,
    },
    /// Gives the reading up.
    GiveUp,
}

impl MeshRequest {
    pub fn load(body: BodyRole, file: PathBuf) -> Self {
        Self::Load {
            body,
            file,
            unit: None,
        }
    }
}

/// The mesh that is being read, if any.
#[derive(Resource, Default)]
pub struct MeshLoading(Option<Loading>);

struct Loading {
    file: PathBuf,
    body: BodyRole,
    /// Whether the person knows the size.
    is_settled: bool,
    job: Job<Result<ReadMesh, StoreError>>,
    /// What was open when it began.
    generation: WorldGeneration,
    origin: Origin,
}

impl MeshLoading {
    /// The body that a mesh is read for, and its file.
    pub fn of(&self) -> Option<(BodyRole, &Path)> {
        let loading = self.0.as_ref()?;
        Some((loading.body, &loading.file))
    }
}

/// The body that commands about bodies are about: the selected one, else the tool.
pub fn body_of_selection(selection: &Selection) -> BodyRole {
    selected_body(selection).unwrap_or(BodyRole::Tool)
}

/// The body that is selected, or whose sensor or tip is.
pub(super) fn selected_body(selection: &Selection) -> Option<BodyRole> {
    Some(match selection.primary()? {
        Selected::Body(body) | Selected::Sensor(body, _) | Selected::Tip(body) => body,
    })
}

fn is_loading(loading: Res<MeshLoading>) -> bool {
    loading.0.is_some()
}

impl Plugin for MeshesPlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<MeshLoading>()
            .init_resource::<WorldGeneration>()
            .init_resource::<Selection>()
            .init_resource::<Notice>()
            .init_resource::<Dialogs>()
            .init_resource::<Waker>()
            .add_message::<MeshRequest>()
            .add_message::<EditRequest>()
            .add_message::<RequestRedraw>()
            .add_systems(
                Update,
                (
                    answer.run_if(on_message::<MeshRequest>),
                    // Whatever else a frame asks for, an opened file or to give it up, comes first.
                    hear.run_if(is_loading.and_then(not(on_message::<MeshRequest>))),
                )
                    .chain()
                    .after(CommandsSystems)
                    .in_set(EditorSystems::Input),
            );
    }
}

/// What the requests work on.
#[derive(SystemParam)]
struct Hand<'w> {
    loading: ResMut<'w, MeshLoading>,
    world: Option<ResMut<'w, OpenWorld>>,
    generation: Res<'w, WorldGeneration>,
    selection: ResMut<'w, Selection>,
    waker: Res<'w, Waker>,
    dialogs: ResMut<'w, Dialogs>,
    notice: ResMut<'w, Notice>,
    edits: MessageWriter<'w, EditRequest>,
    redraw: MessageWriter<'w, RequestRedraw>,
}

fn answer(mut requests: MessageReader<MeshRequest>, mut hand: Hand) {
    for request in requests.read() {
        hand.answer(request.clone());
    }
    hand.redraw.write(RequestRedraw);
}

fn hear(mut hand: Hand) {
    let ended = hand.loading.0.as_mut().and_then(|it| it.job.hear());
    let (Some(ended), true) = (ended, hand.loading.0.is_some()) else {
        return;
    };
    if let Some(loading) = hand.loading.0.take() {
        hand.take(&loading, ended);
    }
    hand.redraw.write(RequestRedraw);
}

impl Hand<'_> {
    fn answer(&mut self, request: MeshRequest) {
        match request {
            MeshRequest::ShowLoad(body) => {
                let Some(world) = &self.world else { return };
                let folder = mesh_folder(&world.0, body);
                self.dialogs.show(Dialog::load_mesh(folder, body));
            }
            MeshRequest::Drop(file) => {
                let Some(world) = &self.world else { return };
                let has_crf = world.0.document.design().crf.is_some();
                match (selected_body(&self.selection), has_crf) {
                    (Some(body), _) => self.load(body, file, None),
                    (None, false) => self.load(BodyRole::Tool, file, None),
                    (None, true) => self.dialogs.show(Dialog::WhichBody { file }),
                }
            }
            MeshRequest::Load { body, file, unit } => self.load(body, file, unit),
            MeshRequest::SetUnit { body, unit } => {
                let Some(world) = &self.world else { return };
                let wanted = WantedMesh::in_unit(&world.0, body, unit);
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

    fn load(&mut self, body: BodyRole, file: PathBuf, unit: Option<MeshUnit>) {
        let Some(world) = &self.world else { return };
        let wanted = WantedMesh::of_file(&world.0, body, &file, unit);
        self.start(wanted, file, unit.is_some());
    }

    /// What was being read for a body before is given up.
    fn start(
        &mut self,
        wanted: Result<Option<WantedMesh>, StoreError>,
        file: PathBuf,
        is_settled: bool,
    ) {
        let (Ok(Some(wanted)), Some(world)) = (wanted, &self.world) else {
            *self.notice = Notice::Refused("the design has no such body".to_owned());
            return;
        };
        let body = wanted.body;
        match Job::start("mesh", &self.waker, move |_| wanted.read()) {
            Ok(job) => {
                *self.notice = Notice::Done(format!("Reading {}…", name_of(&file)));
                self.loading.0 = Some(Loading {
                    file,
                    body,
                    is_settled,
                    job,
                    generation: *self.generation,
                    origin: world.0.document.origin().clone(),
                });
            }
            Err(error) => {
                *self.notice = Notice::Refused(format!("cannot start a thread: {error}"));
            }
        }
    }

    /// Gives the body what was read, unless something else is open by now or its size is one to
    /// ask about.
    fn take(&mut self, loading: &Loading, ended: Ended<Result<ReadMesh, StoreError>>) {
        *self.notice = Notice::Nothing;
        let Some(world) = &mut self.world else { return };
        let is_same =
            loading.generation == *self.generation && loading.origin == *world.0.document.origin();
        if !is_same {
            return;
        }
        let read = match ended {
            Ended::Done(Ok(read)) => read,
            Ended::Done(Err(error)) => {
                let title = "The mesh cannot be used";
                self.dialogs.show(Dialog::error(title, &error));
                return;
            }
            Ended::Lost => {
                self.dialogs.show(Dialog::Error {
                    title: "The mesh cannot be used".to_owned(),
                    text: format!("{}: the reading ended badly", loading.file.display()),
                });
                return;
            }
        };
        let doubt = read.report.suggestion.filter(|_| !loading.is_settled);
        let edit = Edit::SetMesh {
            body: loading.body,
            mesh: Some(read.wanted.reference.clone()),
        };
        // Unless it is read again, nothing that is shown changes before the edit does it.
        if world.bypass_change_detection().0.keep_mesh(read) {
            world.set_changed();
        }
        if let Some(sizes) = doubt {
            self.dialogs.show(Dialog::MeshUnit {
                body: loading.body,
                file: loading.file.clone(),
                sizes,
            });
            return;
        }
        self.edits.write(EditRequest::Apply(edit));
        let body = Selection::of(Some(Selected::Body(loading.body)));
        self.selection.set_if_neq(body);
    }
}

/// Beside the body's mesh, if it is on the disk; else beside the design.
fn mesh_folder(world: &crate::store::World, body: BodyRole) -> PathBuf {
    let own = WantedMesh::in_unit(world, body, None).ok().flatten();
    own.and_then(|own| Some(own.file().parent()?.to_path_buf()))
        .filter(|folder| folder.is_absolute() && folder.is_dir())
        .unwrap_or_else(|| file_folder(world))
}

/// A file's name without its folder.
pub fn name_of(file: &Path) -> String {
    file.file_name().map_or_else(
        || file.display().to_string(),
        |name| name.to_string_lossy().into_owned(),
    )
}
