//! The phases of a frame.

use bevy::ecs::schedule::ScheduleConfigs;
use bevy::ecs::system::ScheduleSystem;
use bevy::prelude::*;
use bevy::window::RequestRedraw;
use bevy_egui::EguiPrimaryContextPass;

/// Phases of a frame, in order, chained in [`Update`].
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum EditorSystems {
    /// Turns keys and pointer into requests.
    Input,
    /// Applies requests to the open document.
    Edit,
    /// Hands changed designs to the solver thread and takes its results.
    Solve,
    /// Turns results into what glyphs and maps are made of.
    Sample,
    /// Writes entities, cameras and meshes.
    Draw,
}

/// Order of what is drawn with egui, chained in [`EguiPrimaryContextPass`].
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum UiSystems {
    Panels,
    /// What is clicked over the 3D view.
    SceneControls,
    Overlay,
    Dialogs,
}

/// What requests background work or cancels it, then what receives its answers, in
/// [`EditorSystems::Solve`].
pub fn request_then_receive<M, N>(
    request: impl IntoScheduleConfigs<ScheduleSystem, M>,
    receive: impl IntoScheduleConfigs<ScheduleSystem, N>,
) -> ScheduleConfigs<ScheduleSystem> {
    (request, receive).chain().in_set(EditorSystems::Solve)
}

/// Chains [`EditorSystems`] in [`Update`], and registers the request for a frame, which headless apps
/// lack.
pub struct SchedulePlugin;

impl Plugin for SchedulePlugin {
    fn build(&self, app: &mut App) {
        app.add_message::<RequestRedraw>().configure_sets(
            Update,
            (
                EditorSystems::Input,
                EditorSystems::Edit,
                EditorSystems::Solve,
                EditorSystems::Sample,
                EditorSystems::Draw,
            )
                .chain(),
        );
        app.configure_sets(
            EguiPrimaryContextPass,
            (UiSystems::Panels, UiSystems::SceneControls, UiSystems::Overlay, UiSystems::Dialogs)
                .chain(),
        );
    }
}
