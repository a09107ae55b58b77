//! Files that are dropped onto the window: which kind each is, what will be done with it, and who
//! does it.

use crate::document::meshes::{body_of_selection, selected_body};
use crate::document::requests::BodyFileRequest;
use crate::document::requests::MeshRequest;
use crate::document::requests::{FileRequest, OpenWorld};
use crate::document::selection::Selection;
use crate::document::state::Notice;
use crate::schedule::EditorSystems;
use crate::shell::commands::CommandsSystems;
use crate::shell::dialogs::file_dialog::FileKind;
use crate::shell::window::Workspace;
use bevy::prelude::*;
use bevy::window::{FileDragAndDrop, RequestRedraw};
use std::path::Path;
use trackwright_project::{RoomSource, file_name};

/// Hands dropped files on, in [`EditorSystems::Input`]; tables go to the workspace that is shown.
pub struct DropsPlugin;

/// What is shown while files hover over the window, a line each.
#[derive(Resource, Clone, Debug, Default, PartialEq, Eq)]
pub struct HoveringFiles(pub Vec<String>);

/// What can be dropped, for whoever dropped something else.
pub const WHAT_CAN_BE_DROPPED: &str = "designs (.design.ron), rooms (.env.ron), meshes (.glb, .gltf, .stl, .obj), tool \
     definitions (.rom, .tool, .ini, .json), bodies (.body.ron), sweeps (folders, .parquet) and, in the \
     Field and Study workspaces, tables (.csv) can be dropped";

/// The kind of a file by the end of its name, in any case; a folder is a sweep's.
pub fn kind_of(file: &Path) -> Option<FileKind> {
    if file.is_dir() {
        return Some(FileKind::Sweep);
    }
    let name = file.file_name()?.to_string_lossy().to_lowercase();
    let kinds = [
        FileKind::Design,
        FileKind::Room,
        FileKind::Mesh,
        FileKind::Table,
        FileKind::Body,
        FileKind::Sweep,
    ];
    kinds.into_iter().find(|kind| kind.extensions().iter().any(|end| name.ends_with(end)))
}

/// Whether a dropped file is one for the workspaces that read tables.
pub fn is_table(file: &Path) -> bool {
    kind_of(file) == Some(FileKind::Table)
}

/// What a file will be used for.
pub fn words(file: &Path, workspace: Workspace, selection: &Selection, has_crf: bool) -> String {
    let name = file_name(file);
    match kind_of(file) {
        Some(FileKind::Design) => format!("Open {name}"),
        Some(FileKind::Room) => format!("Put the design into {name}"),
        Some(FileKind::Sweep) => format!("Show the rows of the sweep {name}"),
        Some(FileKind::Mesh) if selected_body(selection).is_none() => match has_crf {
            true => format!("Use {name} as a mesh of tool, CRF or anatomy"),
            false => format!("Use {name} as a mesh of tool or anatomy"),
        },
        Some(FileKind::Mesh) => {
            format!("Use {name} as the {}'s mesh", body_of_selection(selection))
        }
        Some(FileKind::Body) if has_crf && selected_body(selection).is_none() => {
            format!("Use {name} as the tool or the CRF")
        }
        Some(FileKind::Body) => format!("Use {name} as the {}", body_of_selection(selection)),
        Some(FileKind::Table) => match workspace.drop_verb {
            Some(verb) => format!("{verb} {name}"),
            None => format!("{name}: tables are dropped in the Field or Study workspace"),
        },
        _ => {
            format!("{name} cannot be used: {WHAT_CAN_BE_DROPPED}")
        }
    }
}

impl Plugin for DropsPlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<HoveringFiles>()
            .add_message::<FileDragAndDrop>()
            .add_message::<MeshRequest>()
            .add_message::<BodyFileRequest>()
            .add_systems(
                Update,
                receive_drops
                    .run_if(on_message::<FileDragAndDrop>)
                    .before(CommandsSystems)
                    .in_set(EditorSystems::Input),
            );
    }
}

/// Where dropped files go.
#[derive(bevy::ecs::system::SystemParam)]
struct Receivers<'w> {
    files: MessageWriter<'w, FileRequest>,
    meshes: MessageWriter<'w, MeshRequest>,
    body_files: MessageWriter<'w, BodyFileRequest>,
    notice: ResMut<'w, Notice>,
}

fn receive_drops(
    mut dropped: MessageReader<FileDragAndDrop>,
    workspace: Res<Workspace>,
    selection: Res<Selection>,
    world: Option<Res<OpenWorld>>,
    mut hovering: ResMut<HoveringFiles>,
    mut receivers: Receivers,
    mut redraw: MessageWriter<RequestRedraw>,
) {
    let has_crf = world.is_some_and(|world| world.0.document.design().crf.is_some());
    for event in dropped.read() {
        match event {
            FileDragAndDrop::HoveredFile { path_buf, .. } => {
                let words = words(path_buf, *workspace, &selection, has_crf);
                if !hovering.0.contains(&words) {
                    hovering.0.push(words);
                }
            }
            FileDragAndDrop::HoveredFileCanceled { .. } => hovering.0.clear(),
            FileDragAndDrop::DroppedFile { path_buf, .. } => {
                hovering.0.clear();
                receivers.hand_on(path_buf, *workspace);
            }
        }
        redraw.write(RequestRedraw);
    }
}

impl Receivers<'_> {
    fn hand_on(&mut self, file: &Path, workspace: Workspace) {
        let path = file.to_owned();
        let has_tables = workspace.drop_verb.is_some();
        match kind_of(file) {
            Some(FileKind::Design) => {
                self.files.write(FileRequest::Open(path));
            }
            Some(FileKind::Room) => {
                self.files.write(FileRequest::AssignRoom(RoomSource::File(path)));
            }
            Some(FileKind::Mesh) => {
                self.meshes.write(MeshRequest::Drop(path));
            }
            Some(FileKind::Body) => {
                self.body_files.write(BodyFileRequest::Drop(path));
            }
            // The workspaces take them themselves.
            Some(FileKind::Table) if has_tables => {}
            Some(FileKind::Sweep) => {}
            Some(FileKind::Table) => {
                let name = file_name(file);
                *self.notice = Notice::Refused(format!(
                    "{name} was not read: drop tables in the Field workspace to fit a room to \
                     them, or in the Study workspace to study their poses"
                ));
            }
            _ => {
                let name = file_name(file);
                *self.notice =
                    Notice::Refused(format!("{name} cannot be used: {WHAT_CAN_BE_DROPPED}"));
            }
        }
    }
}
