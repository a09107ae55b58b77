//! The Live workspace: a tracker's poses received over the network, its tools shown where they are,
//! recorded, and sent on.
//!
//! | file | what it does |
//! | --- | --- |
//! | [`state`] | the state: what was requested, the session, what was last seen of it |
//! | `answer` | carries out the panels' requests |
//! | `follow` | looks at the session once a frame, and keeps it in the design's room |
//! | [`collected`] | where samples were taken, counted in the session's thread |
//! | [`cells`] | draws that |

pub mod answer;
pub mod cells;
pub mod collected;
pub mod dialog;
pub mod follow;
pub mod panels;
pub mod requests;
pub mod state;

pub use requests::{LiveRequest, WORKSPACE, is_shown};

use crate::schedule::EditorSystems;
use crate::shell::commands::CommandsSystems;
use crate::shell::registry::{AddToShell, PanelInfo, Side};
use crate::workspaces::layers_panel::layers_panel;
use crate::workspaces::live::panels::{collecting_panel, note_tools, pose_panel, tracker_panel};
use crate::workspaces::live::state::LiveState;
use bevy::prelude::*;

/// Receives a tracker's poses on [`LiveRequest`]; no thread, socket or file is there before.
///
/// Answers in [`EditorSystems::Input`], follows the session there too, so that bodies are drawn in
/// the frame in which their poses were received.
pub struct LivePlugin;

fn is_connected(state: Res<LiveState>) -> bool {
    state.is_connected()
}

impl Plugin for LivePlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<LiveState>()
            .add_message::<LiveRequest>()
            .add_workspace(WORKSPACE)
            .add_panel(PanelInfo::new(WORKSPACE, Side::Left), tracker_panel)
            .add_panel(PanelInfo::new(WORKSPACE, Side::Left), layers_panel)
            .add_panel(PanelInfo::new(WORKSPACE, Side::Right), pose_panel)
            .add_panel(PanelInfo::new(WORKSPACE, Side::Right), collecting_panel)
            .add_systems(Update, note_tools.in_set(EditorSystems::Draw))
            .add_systems(
                Update,
                (
                    answer::answer.run_if(on_message::<LiveRequest>),
                    follow::follow_session.run_if(is_connected),
                )
                    .chain()
                    .after(CommandsSystems)
                    .in_set(EditorSystems::Input),
            )
            .add_systems(
                Update,
                follow::keep_room.run_if(is_connected).in_set(EditorSystems::Solve),
            )
            .add_systems(Update, follow::keep_troubles.in_set(EditorSystems::Draw));
    }
}
