//! The editor: everything that knows Bevy or egui, and nothing that computes.

pub mod app;
pub mod autosave;
pub mod background;
pub mod body_files;
pub mod camera;
pub mod command_table;
pub mod commands;
pub mod convert;
pub mod decide;
pub mod diagnostics;
pub mod document;
pub mod drag;
pub mod drag_edits;
pub mod drops;
pub mod egui_camera;
pub mod field;
pub mod film;
pub mod fine_pointer;
pub mod gizmo;
pub mod glyphs;
pub mod handle;
pub mod keys;
pub mod layers;
pub mod light_drawing;
pub mod live;
pub mod lost_device;
pub mod materials;
pub mod measure;
pub mod meshes;
pub mod motion;
pub mod overlay;
pub mod palette;
pub mod pick;
pub mod picture;
pub mod pointer_hint;
pub mod precision;
pub mod preferences;
pub mod preflight;
pub mod present;
pub mod probe;
pub mod recent;
pub mod report;
pub mod scene;
pub mod selection;
pub mod sensor_commands;
pub mod shortcuts;
pub mod slice;
pub mod slice_picture;
pub mod solve;
pub mod solver;
pub mod state;
pub mod study;
pub mod system_dialog;
pub mod tool;
pub mod ui;
pub mod wake;

use bevy::app::{PluginGroup, PluginGroupBuilder};

/// The editor, on top of Bevy's default plugins and bevy_egui.
///
/// | plugin | what it adds |
/// | --- | --- |
/// | [`state::StatePlugin`] | shared resources, requests, the phases of a frame |
/// | [`document::DocumentPlugin`] | the only place where the open document changes |
/// | [`autosave::AutosavePlugin`] | what is unsaved outlasts a crash |
/// | [`solve::SolverPlugin`] | the solver thread and its results |
/// | [`diagnostics::DiagnosticsPlugin`] | counts of frames and evaluations |
/// | [`study::StudyPlugin`] | the Study workspace: modes, trials shown and played, the log |
/// | [`precision::PrecisionPlugin`] | error against run time, measured when asked for |
/// | [`field::FieldPlugin`] | rooms from measurements |
/// | [`live::LivePlugin`] | the Live workspace: a tracker over the network |
/// | [`live::cells::CellsPlugin`] | where samples were taken, in the scene |
/// | [`decide::DecidePlugin`] | the Decide workspace: a pinned baseline, designs and rooms in one table |
/// | [`decide::baseline_ghost::BaselineGhostPlugin`] | the baseline in the scene |
/// | [`present::PresentPlugin`] | the Present workspace: slides instead of panels |
/// | [`report::ReportPlugin`] | the design's report, by a process of its own |
/// | [`meshes::MeshesPlugin`] | meshes for bodies |
/// | [`body_files::BodyFilesPlugin`] | bodies from makers' files and back |
/// | [`drops::DropsPlugin`] | files dropped onto the window |
/// | [`system_dialog::SystemDialogPlugin`] | the system's own file dialog |
/// | [`preferences::PreferencesPlugin`] | window and layout as they were left |
/// | [`field::samples::SamplesPlugin`] | the measurements in the scene |
/// | [`camera::CameraPlugin`] | the 3D camera and its gestures |
/// | [`pick::PickPlugin`] | what is under the pointer |
/// | [`drag::DragPlugin`] | hovering, selecting, dragging sensors |
/// | [`gizmo::GizmoPlugin`] | handles that move and turn what is selected |
/// | [`tool::ToolPlugin`] | what a click in the scene does beside selecting |
/// | [`pointer_hint::PointerHintPlugin`] | what the pointer can do now, in words |
/// | [`materials::MaterialsPlugin`] | what surfaces look like |
/// | [`scene::ScenePlugin`] | bodies, sensors, volume, generator, ground |
/// | [`glyphs::GlyphsPlugin`] | magnified errors and the ghost |
/// | [`layers::LayersPlugin`] | arrows, placement, usable region, model support |
/// | [`handle::HandlePlugin`] | balls in the scene that are dragged |
/// | [`motion::MotionPlugin`] | what the range of motion runs through, and its handles |
/// | [`slice::SlicePlugin`] | the coloured plane through the room |
/// | [`light_drawing::LightDrawingPlugin`] | less is drawn in software while something moves |
/// | [`probe::ProbePlugin`] | the value under the pointer |
/// | [`egui_camera::EguiCameraPlugin`] | the camera above the scene that egui is painted with |
/// | [`ui::UiPlugin`] | the panels |
/// | [`overlay::OverlayPlugin`] | labels and legends over the scene |
/// | [`commands::CommandsPlugin`] | everything that has a name |
/// | [`shortcuts::ShortcutsPlugin`] | keys |
/// | [`wake::WakePlugin`] | rest while nothing changes |
/// | [`lost_device::LostDevicePlugin`] | an adapter that fails loses nobody's work |
pub struct EditorPlugins;

impl PluginGroup for EditorPlugins {
    fn build(self) -> PluginGroupBuilder {
        PluginGroupBuilder::start::<Self>()
            .add(state::StatePlugin)
            .add(document::DocumentPlugin)
            .add(autosave::AutosavePlugin)
            .add(solve::SolverPlugin)
            .add(diagnostics::DiagnosticsPlugin)
            .add(study::StudyPlugin)
            .add(precision::PrecisionPlugin)
            .add(field::FieldPlugin)
            .add(field::samples::SamplesPlugin)
            .add(live::LivePlugin)
            .add(live::cells::CellsPlugin)
            .add(decide::DecidePlugin)
            .add(decide::baseline_ghost::BaselineGhostPlugin)
            .add(present::PresentPlugin)
            .add(report::ReportPlugin)
            .add(meshes::MeshesPlugin)
            .add(body_files::BodyFilesPlugin)
            .add(drops::DropsPlugin)
            .add(system_dialog::SystemDialogPlugin)
            .add(preferences::PreferencesPlugin)
            .add(camera::CameraPlugin)
            .add(pick::PickPlugin)
            .add(drag::DragPlugin)
            .add(gizmo::GizmoPlugin)
            .add(tool::ToolPlugin)
            .add(pointer_hint::PointerHintPlugin)
            .add(materials::MaterialsPlugin)
            .add(scene::ScenePlugin)
            .add(glyphs::GlyphsPlugin)
            .add(handle::HandlePlugin)
            .add(motion::MotionPlugin)
            .add(slice::SlicePlugin)
            .add(layers::LayersPlugin)
            .add(light_drawing::LightDrawingPlugin)
            .add(probe::ProbePlugin)
            .add(egui_camera::EguiCameraPlugin)
            .add(ui::UiPlugin)
            .add(overlay::OverlayPlugin)
            .add(commands::CommandsPlugin)
            .add(shortcuts::ShortcutsPlugin)
            .add(wake::WakePlugin)
            .add(lost_device::LostDevicePlugin)
    }
}
