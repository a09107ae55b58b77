//! The rows of a sweep as a table: a click shows a row's design in the scene, *Open as design* makes it a
//! document of its own.
//!
//! | file | what it does |
//! | --- | --- |
//! | [`state`] | the state: the open sweep, what is read of it, what is under way |
//! | `work` | what the threads do: open, sort, read rows, make a row's design |
//! | `answer` | carries out requests, or hands them to the threads, and takes what those found |
//! | `shown_row` | puts a row into the open design, or opens it |
//! | [`table_ui`] | draws the rows that are in view |

mod answer;
pub mod dialog;
mod shown_row;
pub mod state;
pub mod table_ui;
mod work;

use crate::document::drops::kind_of;
use crate::document::requests::OpenWorld;
use crate::schedule::EditorSystems;
use crate::shell::commands::{AddCommand, Command, CommandsSystems, FILE, write};
use crate::shell::dialogs::file_dialog::FileKind;
use crate::shell::registry::{AddToShell, PanelInfo, Side};
use crate::shell::requests::Requests;
use crate::workspaces::decide::requests::WORKSPACE;
use crate::workspaces::decide::sweep_table::state::{SweepTableRequest, SweepTableState};
use crate::workspaces::decide::sweep_table::table_ui::sweep_table_ui;
use bevy::prelude::*;
use bevy::window::FileDragAndDrop;
use bevy_egui::egui::Ui;

const HEIGHT: f32 = 240.0;

pub const OPEN_SWEEP: Command = Command::new(
    FILE,
    4,
    "Open sweep…",
    "Shows the rows of a sweep as a table whose rows are designs, in the Decide workspace",
);

/// The table with its command; nothing of it runs before a sweep is opened.
pub struct SweepTablePlugin;

impl Plugin for SweepTablePlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<SweepTableState>()
            .add_message::<SweepTableRequest>()
            .add_message::<FileDragAndDrop>()
            .add_command(OPEN_SWEEP, write(SweepTableRequest::ShowOpen))
            .add_panel(
                PanelInfo::new(WORKSPACE, Side::Bottom).high(|_| HEIGHT).shown_if(is_open),
                sweep_table_panel,
            )
            .add_systems(
                Update,
                (
                    receive_drops.run_if(on_message::<FileDragAndDrop>),
                    answer::answer.run_if(on_message::<SweepTableRequest>),
                )
                    .chain()
                    .after(CommandsSystems)
                    .in_set(EditorSystems::Input),
            )
            .add_systems(
                Update,
                // Before requests to the document are applied.
                (answer::receive, shown_row::receive)
                    .run_if(is_busy)
                    .after(CommandsSystems)
                    .in_set(EditorSystems::Input),
            );
    }
}

/// Whether the table stands in the place of the comparison.
pub fn is_open(world: &World) -> bool {
    world.get_resource::<SweepTableState>().is_some_and(|state| state.open.is_some())
}

pub fn is_closed(world: &World) -> bool {
    !is_open(world)
}

fn is_busy(state: Res<SweepTableState>) -> bool {
    state.is_busy()
}

fn receive_drops(
    mut dropped: MessageReader<FileDragAndDrop>,
    mut requests: MessageWriter<SweepTableRequest>,
) {
    for drop in dropped.read() {
        if let FileDragAndDrop::DroppedFile { path_buf, .. } = drop
            && kind_of(path_buf) == Some(FileKind::Sweep)
        {
            requests.write(SweepTableRequest::Open(path_buf.clone()));
        }
    }
}

fn sweep_table_panel(
    mut ui: InMut<Ui>,
    state: Res<SweepTableState>,
    world: Res<OpenWorld>,
    mut requests: Requests<SweepTableRequest>,
) {
    if let Some(open) = &state.open {
        let standing = open.standing(&world.0.document);
        requests.write_all(sweep_table_ui(&mut ui, open, standing));
    }
}
