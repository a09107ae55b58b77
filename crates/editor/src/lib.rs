//! The editor: everything that knows Bevy or egui, and nothing that computes.

pub mod app;
pub mod convert;
pub mod document;
pub mod layers;
pub mod palette;
pub mod runner;
pub mod scene;
pub mod schedule;
pub mod shell;
pub mod viewport;
pub mod widgets;
pub mod workspaces;

use bevy::app::{App, Plugin, PluginGroup, PluginGroupBuilder};

/// The editor, on top of Bevy's default plugins and bevy_egui.
///
/// | plugin | what it adds |
/// | --- | --- |
/// | [`StatePlugin`] | the phases of a frame, requests, selection, results |
/// | [`document::apply::DocumentPlugin`] | the only place where the open document changes |
/// | [`document::autosave::AutosavePlugin`] | what is unsaved outlasts a crash |
/// | [`runner::metal::MetalPlugin`] | the thread that solves for a room's metal |
/// | [`runner::solve::SolverPlugin`] | the solver thread and its results |
/// | [`runner::diagnostics::DiagnosticsPlugin`] | counts of frames and evaluations |
/// | [`document::commands::DocumentCommandsPlugin`] | commands for files and edits |
/// | [`viewport::commands::ViewportCommandsPlugin`] | commands of the 3D view |
/// | [`workspaces::design::DesignPlugin`] | the Design workspace: bodies, sensors, the result |
/// | [`workspaces::design::placement_search::ghosts::PlacementGhostsPlugin`] | places that a search found, in the scene |
/// | [`workspaces::study::StudyPlugin`] | the Study workspace: modes, trials shown and played, the log |
/// | [`workspaces::study::precision::PrecisionPlugin`] | error against run time, measured on request |
/// | [`workspaces::study::measured_ghost::MeasuredGhostPlugin`] | a recorded pose as it was measured |
/// | [`workspaces::field::FieldPlugin`] | rooms from measurements |
/// | [`workspaces::live::LivePlugin`] | the Live workspace: a tracker over the network |
/// | [`workspaces::live::cells::CellsPlugin`] | where samples were taken, in the scene |
/// | [`workspaces::decide::DecidePlugin`] | the Decide workspace: a pinned baseline, designs and rooms in one table |
/// | [`workspaces::decide::baseline_ghost::BaselineGhostPlugin`] | the baseline in the scene |
/// | [`workspaces::present::PresentPlugin`] | the Present workspace: slides instead of panels |
/// | [`document::own_program::OwnProgramPlugin`] | files that this program writes in another process |
/// | [`document::report::ReportPlugin`] | the design's report, by a process of its own |
/// | [`document::exports::ExportsPlugin`] | files for 3D Slicer, ParaView and others, likewise |
/// | [`document::open_outside::OpenOutsidePlugin`] | files that other programs show |
/// | [`document::meshes::MeshesPlugin`] | meshes for bodies |
/// | [`document::body_files::BodyFilesPlugin`] | bodies from makers' files and back |
/// | [`document::drops::DropsPlugin`] | files dropped onto the window |
/// | [`shell::system_dialog::SystemDialogPlugin`] | the system's own file dialog |
/// | [`shell::preferences::PreferencesPlugin`] | window and layout as they were left |
/// | [`workspaces::field::samples::SamplesPlugin`] | the measurements in the scene |
/// | [`workspaces::field::found_bodies::FoundBodiesPlugin`] | the metal that was found in them |
/// | [`viewport::camera::CameraPlugin`] | the 3D camera |
/// | [`viewport::camera_gestures::CameraGesturesPlugin`] | what the mouse and a trackpad do to it |
/// | [`viewport::picking::PickPlugin`] | what is under the pointer |
/// | [`viewport::coil_fit::CoilFitPlugin`] | coils that do not fit |
/// | [`viewport::sensor_drag::DragPlugin`] | hovering, selecting, dragging sensors |
/// | [`viewport::gizmo::GizmoPlugin`] | handles that move and turn what is selected |
/// | [`viewport::tool::ToolPlugin`] | what a click in the scene does beside selecting |
/// | [`viewport::tip_drag::TipDragPlugin`] | the ball by which a selected tip is dragged |
/// | [`viewport::mounting::MountingPlugin`] | a brush and drawing tools for mounting regions |
/// | [`viewport::pointer_hint::PointerHintPlugin`] | what the pointer can do now, in words |
/// | [`scene::materials::MaterialsPlugin`] | what surfaces look like |
/// | [`scene::ScenePlugin`] | bodies, sensors, volume, generator, ground |
/// | [`layers::GlyphsPlugin`] | magnified errors and the ghost |
/// | [`layers::commands::LayersCommandsPlugin`] | commands of layers |
/// | [`layers::LayersPlugin`] | arrows, placement, mounting regions, usable region, model support |
/// | [`viewport::ball_handle::HandlePlugin`] | balls in the scene that are dragged |
/// | [`layers::motion::MotionPlugin`] | balls that set the ends of the range of motion |
/// | [`layers::slice::SlicePlugin`] | the coloured plane through the room |
/// | [`viewport::light_drawing::LightDrawingPlugin`] | less is drawn in software while something moves |
/// | [`layers::probe::ProbePlugin`] | the value under the pointer |
/// | [`shell::egui_camera::EguiCameraPlugin`] | the camera above the scene that egui is painted with |
/// | [`shell::explain_controls::ExplainControlsPlugin`] | names and places of controls, on request |
/// | [`shell::painted_text::PaintedTextPlugin`] | what is written and where, on request |
/// | [`shell::ShellPlugin`] | what is drawn around the 3D view, and its commands |
/// | [`viewport::view_axes::ViewAxesPlugin`] | the axes in the corner that turn the view |
/// | [`viewport::overlay::OverlayPlugin`] | labels and legends over the scene |
/// | [`shell::shortcuts::ShortcutsPlugin`] | keys |
/// | [`runner::wake::WakePlugin`] | rest while nothing changes |
/// | [`app::lost_device::LostDevicePlugin`] | an adapter that fails loses nobody's work |
pub struct EditorPlugins;

impl PluginGroup for EditorPlugins {
    fn build(self) -> PluginGroupBuilder {
        PluginGroupBuilder::start::<Self>()
            .add(StatePlugin)
            .add(document::apply::DocumentPlugin)
            .add(document::autosave::AutosavePlugin)
            .add(runner::metal::MetalPlugin)
            .add(runner::solve::SolverPlugin)
            .add(runner::diagnostics::DiagnosticsPlugin)
            .add(document::commands::DocumentCommandsPlugin)
            .add(viewport::commands::ViewportCommandsPlugin)
            .add(workspaces::design::DesignPlugin)
            .add(workspaces::design::placement_search::ghosts::PlacementGhostsPlugin)
            .add(workspaces::study::StudyPlugin)
            .add(workspaces::study::precision::PrecisionPlugin)
            .add(workspaces::study::measured_ghost::MeasuredGhostPlugin)
            .add(workspaces::field::FieldPlugin)
            .add(workspaces::field::samples::SamplesPlugin)
            .add(workspaces::field::found_bodies::FoundBodiesPlugin)
            .add(workspaces::live::LivePlugin)
            .add(workspaces::live::cells::CellsPlugin)
            .add(workspaces::decide::DecidePlugin)
            .add(workspaces::decide::baseline_ghost::BaselineGhostPlugin)
            .add(workspaces::present::PresentPlugin)
            .add(document::own_program::OwnProgramPlugin)
            .add(document::report::ReportPlugin)
            .add(document::exports::ExportsPlugin)
            .add(document::open_outside::OpenOutsidePlugin)
            .add(document::meshes::MeshesPlugin)
            .add(document::body_files::BodyFilesPlugin)
            .add(document::drops::DropsPlugin)
            .add(shell::system_dialog::SystemDialogPlugin)
            .add(shell::preferences::PreferencesPlugin)
            .add(viewport::camera::CameraPlugin)
            .add(viewport::camera_gestures::CameraGesturesPlugin)
            .add(viewport::picking::PickPlugin)
            .add(viewport::coil_fit::CoilFitPlugin)
            .add(viewport::sensor_drag::DragPlugin)
            .add(viewport::gizmo::GizmoPlugin)
            .add(viewport::tool::ToolPlugin)
            .add(viewport::tip_drag::TipDragPlugin)
            .add(viewport::mounting::MountingPlugin)
            .add(viewport::pointer_hint::PointerHintPlugin)
            .add(scene::materials::MaterialsPlugin)
            .add(scene::ScenePlugin)
            .add(layers::commands::LayersCommandsPlugin)
            .add(layers::GlyphsPlugin)
            .add(viewport::ball_handle::HandlePlugin)
            .add(layers::motion::MotionPlugin)
            .add(layers::slice::SlicePlugin)
            .add(layers::LayersPlugin)
            .add(viewport::light_drawing::LightDrawingPlugin)
            .add(layers::probe::ProbePlugin)
            .add(shell::egui_camera::EguiCameraPlugin)
            .add(shell::explain_controls::ExplainControlsPlugin)
            .add(shell::painted_text::PaintedTextPlugin)
            .add(shell::ShellPlugin)
            .add(viewport::view_axes::ViewAxesPlugin)
            .add(viewport::overlay::OverlayPlugin)
            .add(shell::shortcuts::ShortcutsPlugin)
            .add(runner::wake::WakePlugin)
            .add(app::lost_device::LostDevicePlugin)
    }
}

/// What most plugins expect: the phases of a frame, requests to the document, the selection, the
/// newest results, the shown workspace and the shown design.
pub struct StatePlugin;

impl Plugin for StatePlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<palette::Theme>().add_plugins((
            schedule::SchedulePlugin,
            document::requests::RequestsPlugin,
            document::state::DocumentStatePlugin,
            document::selection::SelectionPlugin,
            runner::results::ResultsPlugin,
            shell::window::WindowStatePlugin,
            shell::dialogs::DialogsPlugin,
            document::shown::ShownPlugin,
            layers::RegistryPlugin,
        ));
    }
}
