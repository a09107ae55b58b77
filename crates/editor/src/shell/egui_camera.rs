//! The camera that paints panels and overlay above the 3D view.

use bevy::camera::visibility::RenderLayers;
use bevy::camera::{CameraOutputMode, ClearColorConfig, RenderTarget};
use bevy::prelude::*;
use bevy::render::render_resource::BlendState;
use bevy_egui::{EguiGlobalSettings, EguiStartupSet, PrimaryEguiContext};

/// Spawns a camera of its own for egui, above the 3D camera.
///
/// egui would otherwise attach itself to whichever camera comes first, and be cut to its
/// viewport.
pub struct EguiCameraPlugin;

/// The camera that egui is painted with.
#[derive(Component, Clone, Copy, Debug)]
pub struct EguiCamera;

/// By itself egui is painted on nothing, and laid over what is on the screen.
const CLEAR: ClearColorConfig = ClearColorConfig::Custom(Color::NONE);

fn over_the_scene() -> CameraOutputMode {
    CameraOutputMode::Write {
        blend_state: Some(BlendState::ALPHA_BLENDING),
        clear_color: ClearColorConfig::None,
    }
}

/// Whether both cameras paint one picture that goes to the screen once, instead of one each: they
/// can while neither is smoothed, since they then share their textures.
pub fn share_a_picture(scene: &mut Camera, egui: &mut Camera, do_share: bool) {
    let to_screen =
        CameraOutputMode::Write { blend_state: None, clear_color: ClearColorConfig::None };
    (scene.output_mode, egui.output_mode, egui.clear_color) = match do_share {
        true => (CameraOutputMode::Skip, to_screen, ClearColorConfig::None),
        false => (CameraOutputMode::default(), over_the_scene(), CLEAR),
    };
}

/// Where egui is painted if not in the window: the offscreen picture. Insert before startup.
#[derive(Resource, Clone, Debug)]
pub struct EguiTarget(pub RenderTarget);

impl Plugin for EguiCameraPlugin {
    fn build(&self, app: &mut App) {
        app.add_systems(PreStartup, spawn_camera.before(EguiStartupSet::InitContexts));
    }
}

fn spawn_camera(
    mut commands: Commands,
    settings: Option<ResMut<EguiGlobalSettings>>,
    target: Option<Res<EguiTarget>>,
) {
    if let Some(mut settings) = settings {
        settings.auto_create_primary_context = false;
    }
    let mut camera = commands.spawn((
        Name::new("egui camera"),
        PrimaryEguiContext,
        Camera2d,
        RenderLayers::none(),
        // A full-screen resolve is dear in software.
        Msaa::Off,
        EguiCamera,
        Camera { order: 1, output_mode: over_the_scene(), clear_color: CLEAR, ..default() },
    ));
    if let Some(target) = target {
        camera.insert(target.0.clone());
    }
}
