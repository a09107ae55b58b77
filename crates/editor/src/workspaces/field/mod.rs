//! The Field workspace: where a room is made from measurements, judged, and given to the design.
//!
//! | file | what it does |
//! | --- | --- |
//! | [`state`] | the state: tables, settings, the newest fit, rooms |
//! | `answer` | carries out the panels' requests, or starts the thread that does |
//! | `receive` | takes what the threads found |
//! | `rooms` | keeps the list of rooms while the workspace is shown |
//! | [`samples`] | draws the measurements while the workspace is shown |
//! | [`metal`] | the search for the metal that disturbs the measurements |
//! | [`found_bodies`] | draws that metal while the workspace is shown |
//! | [`kind`] | the kinds of models that are offered |
//! | [`work`] | what the threads do |

pub mod answer;
pub mod dialog;
pub mod failure;
pub mod found_bodies;
pub mod kind;
pub mod metal;
pub mod panels;
pub mod receive;
pub mod requests;
pub mod rooms;
pub mod samples;
pub mod state;
pub mod work;

pub use requests::{FieldRequest, RoomToSave, WORKSPACE, is_shown};

use crate::document::drops::is_table;
use crate::document::requests::FileRequest;
use crate::schedule::EditorSystems;
use crate::schedule::UiSystems;
use crate::shell::commands::{AddCommand, Command, CommandsSystems, EDIT, FILE};
use crate::shell::registry::{AddToShell, PanelInfo, Side};
use crate::shell::window::Workspace;
use crate::workspaces::design::panels::brief_result_panel;
use crate::workspaces::field::panels::systems::{
    fit_panel, is_selection_open, metal_panel, rooms_panel, selection_page, tables_panel,
};
use crate::workspaces::field::state::{FieldState, TableRole};
use crate::workspaces::layers_panel::room_layers_panel;
use bevy::prelude::*;
use bevy::window::{FileDragAndDrop, RequestRedraw};
use bevy_egui::EguiPrimaryContextPass;

const OPEN_TRAINING: Command = Command::new(
    FILE,
    100,
    "Open measurements…",
    "Opens a measurement table in the Field workspace, to fit a room to",
);
const OPEN_HELD_OUT: Command = Command::new(
    FILE,
    101,
    "Open held-out measurements…",
    "Opens a second table in the Field workspace, to judge the fit on",
);
const USE_ROOM: Command = Command::new(
    FILE,
    102,
    "Use the fitted room…",
    "Saves the room that was fitted last and puts the design into it",
);
const FIT_ROOM: Command = Command::new(
    EDIT,
    101,
    "Fit a room",
    "Fits a room to the measurements that are open in the Field workspace",
);
const FIND_METAL: Command = Command::new(
    EDIT,
    102,
    "Find metal",
    "Finds the pieces of metal that disturb the measurements that are open in the Field workspace",
);
const USE_METAL: Command = Command::new(
    FILE,
    103,
    "Use as room with metal…",
    "Saves a room with the metal that was found and puts the design into it",
);

/// Makes rooms on [`FieldRequest`]; nothing is read or computed before.
///
/// Answers in [`EditorSystems::Input`], so that an assigned room is applied in the same frame, and
/// takes results in [`EditorSystems::Solve`].
pub struct FieldPlugin;

fn is_busy(state: Res<FieldState>) -> bool {
    state.is_busy()
}

impl Plugin for FieldPlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<FieldState>()
            .add_message::<FieldRequest>()
            .add_message::<FileDragAndDrop>()
            .add_workspace(WORKSPACE)
            .add_panel(PanelInfo::new(WORKSPACE, Side::Left).fixed(), brief_result_panel)
            .add_panel(PanelInfo::new(WORKSPACE, Side::Left), tables_panel)
            .add_panel(PanelInfo::new(WORKSPACE, Side::Left), rooms_panel)
            .add_panel(PanelInfo::new(WORKSPACE, Side::Left), room_layers_panel)
            .add_panel(PanelInfo::new(WORKSPACE, Side::Right), fit_panel)
            .add_panel(PanelInfo::new(WORKSPACE, Side::Right), metal_panel)
            .add_command(OPEN_TRAINING, request(FieldRequest::ShowOpen(TableRole::Training)))
            .add_command(OPEN_HELD_OUT, request(FieldRequest::ShowOpen(TableRole::HeldOut)))
            .add_command(USE_ROOM, request(FieldRequest::ShowSave(RoomToSave::Fitted)))
            .add_command(FIT_ROOM, request(FieldRequest::Fit))
            .add_command(FIND_METAL, request(FieldRequest::FindMetal))
            .add_command(USE_METAL, request(FieldRequest::ShowSave(RoomToSave::Metal)))
            .add_systems(
                EguiPrimaryContextPass,
                selection_page
                    .run_if(is_shown.and_then(is_selection_open))
                    .in_set(UiSystems::Dialogs),
            )
            .add_systems(
                Update,
                (
                    (
                        receive_drops.run_if(on_message::<FileDragAndDrop>),
                        assign_rooms.run_if(on_message::<FileRequest>),
                        answer::answer.run_if(on_message::<FieldRequest>),
                    )
                        .chain()
                        .after(CommandsSystems)
                        .in_set(EditorSystems::Input),
                    (
                        receive::receive_results.run_if(is_busy),
                        rooms::keep_list
                            .run_if(is_shown.or_else(crate::workspaces::decide::is_shown)),
                    )
                        .chain()
                        .in_set(EditorSystems::Solve),
                ),
            );
    }
}

/// Rooms that others request, as by dropping their files.
fn assign_rooms(mut files: MessageReader<FileRequest>, mut requests: MessageWriter<FieldRequest>) {
    for request in files.read() {
        if let FileRequest::AssignRoom(room) = request {
            requests.write(FieldRequest::Assign(room.clone()));
        }
    }
}

/// A request of a command, made where what comes of it can be seen.
fn request(request: FieldRequest) -> impl FnMut(ResMut<Workspace>, MessageWriter<FieldRequest>) {
    move |mut shown: ResMut<Workspace>, mut requests: MessageWriter<FieldRequest>| {
        shown.set_if_neq(WORKSPACE);
        requests.write(request.clone());
    }
}

/// Tables that are dropped onto the window while the workspace is shown.
fn receive_drops(
    mut dropped: MessageReader<FileDragAndDrop>,
    workspace: Res<Workspace>,
    mut state: ResMut<FieldState>,
    mut requests: MessageWriter<FieldRequest>,
    mut redraw: MessageWriter<RequestRedraw>,
) {
    let is_shown = *workspace == WORKSPACE;
    for drop in dropped.read() {
        let is_near = is_shown
            && matches!(drop, FileDragAndDrop::HoveredFile { path_buf, .. } if is_table(path_buf));
        if state.is_drop_near != is_near {
            state.is_drop_near = is_near;
            redraw.write(RequestRedraw);
        }
        if let (true, FileDragAndDrop::DroppedFile { path_buf, .. }) = (is_shown, drop)
            && is_table(path_buf)
        {
            requests.write(FieldRequest::Drop(path_buf.clone()));
            redraw.write(RequestRedraw);
        }
    }
}
