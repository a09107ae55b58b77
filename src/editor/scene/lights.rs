//! Light that stays with the viewer: a soft key over the shoulder, a weaker fill, a faint room.

use crate::editor::camera::OrbitRig;
use crate::editor::state::{EditorSystems, MainCamera};
use crate::editor::{convert, palette};
use bevy::light::EnvironmentMapLight;
use bevy::prelude::*;

const KEY_LUX: f32 = 2600.0;
const FILL_LUX: f32 = 700.0;
const ROOM_INTENSITY: f32 = 420.0;

/// Lights the scene.
pub struct LightsPlugin;

impl Plugin for LightsPlugin {
    fn build(&self, app: &mut App) {
        app.add_systems(Startup, spawn).add_systems(
            Update,
            turn_room
                .run_if(resource_changed::<OrbitRig>)
                .in_set(EditorSystems::Draw),
        );
    }
}

/// Hangs the lights on the camera: directions are the camera's, x right, y up, z to the viewer.
fn spawn(
    mut commands: Commands,
    mut images: ResMut<Assets<Image>>,
    camera: Single<Entity, With<MainCamera>>,
) {
    let light = |color: palette::Rgb, illuminance: f32, from: Vec3| {
        (
            DirectionalLight {
                color: color.color(),
                illuminance,
                // Software renderers pay dearly for shadows.
                shadow_maps_enabled: false,
                ..default()
            },
            Transform::from_translation(from).looking_at(Vec3::ZERO, Vec3::Y),
        )
    };
    commands
        .entity(*camera)
        .insert(EnvironmentMapLight {
            intensity: ROOM_INTENSITY,
            ..EnvironmentMapLight::hemispherical_gradient(
                &mut images,
                palette::ROOM_ABOVE.color(),
                palette::ROOM_AROUND.color(),
                palette::ROOM_BELOW.color(),
            )
        })
        .with_children(|camera| {
            camera.spawn(light(palette::KEY_LIGHT, KEY_LUX, Vec3::new(0.9, 1.3, 1.2)));
            camera.spawn(light(
                palette::FILL_LIGHT,
                FILL_LUX,
                Vec3::new(-1.4, 0.1, 0.7),
            ));
        });
}

/// The room's light keeps its up: tracker -z, where the cube map has y.
fn turn_room(rig: Res<OrbitRig>, mut room: Query<&mut EnvironmentMapLight, With<MainCamera>>) {
    let viewer = convert::camera_transform(&rig.camera).rotation;
    for mut room in &mut room {
        room.rotation = viewer;
    }
}
