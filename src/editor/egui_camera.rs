//! The camera that paints panels and overlay above the 3D view.

use super::state::Presentation;
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

/// Where egui is painted if not in the window: the offscreen picture. Insert before startup.
#[derive(Resource, Clone, Debug)]
pub struct EguiTarget(pub RenderTarget);

impl Plugin for EguiCameraPlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<Presentation>().add_systems(
            PreStartup,
            spawn_camera.before(EguiStartupSet::InitContexts),
        );
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
        Camera {
            order: 1,
            output_mode: CameraOutputMode::Write {
                blend_state: Some(BlendState::ALPHA_BLENDING),
                clear_color: ClearColorConfig::None,
            },
            clear_color: ClearColorConfig::Custom(Color::NONE),
            ..default()
        },
    ));
    if let Some(target) = target {
        camera.insert(target.0.clone());
    }
}
