//! What a processor that paints by itself leaves out while something moves: smooth edges, and
//! most triangles of large bodies. The first frame at rest has them again.

use crate::document::requests::ActiveDrag;
use crate::scene::body_meshes::{LightDrawing, Shapes, paints_in_software};
use crate::schedule::EditorSystems;
use crate::shell::egui_camera::{EguiCamera, share_a_picture};
use crate::viewport::camera::MainCamera;
use crate::viewport::camera::OrbitRig;
use crate::viewport::camera_gestures::{Gesture, Turntable};
use bevy::prelude::*;

/// Draws less while something moves, where no graphics card does the work.
pub struct LightDrawingPlugin;

impl Plugin for LightDrawingPlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<LightDrawing>().add_systems(
            Update,
            (notice, smooth.run_if(resource_changed::<LightDrawing>), choose_shapes)
                .chain()
                .run_if(paints_in_software)
                .in_set(EditorSystems::Draw),
        );
    }
}

fn notice(
    gesture: Res<Gesture>,
    drag: Res<ActiveDrag>,
    rig: Res<OrbitRig>,
    turntable: Res<Turntable>,
    mut light: ResMut<LightDrawing>,
) {
    let is_moving = gesture.is_on() || drag.0 || rig.is_gliding() || turntable.0.is_some();
    light.set_if_neq(LightDrawing(is_moving));
}

/// The camera that egui is painted with, distinguished from the scene's.
type OfEgui = (With<EguiCamera>, Without<MainCamera>);

/// A third of a frame goes into smooth edges; without them one picture will do for scene and panels.
fn smooth(
    light: Res<LightDrawing>,
    scene: Option<Single<(&mut Camera, &mut Msaa), With<MainCamera>>>,
    egui: Option<Single<&mut Camera, OfEgui>>,
) {
    let Some(scene) = scene else { return };
    let (mut camera, mut msaa) = scene.into_inner();
    msaa.set_if_neq(match light.0 {
        true => Msaa::Off,
        false => Msaa::Sample4,
    });
    if let Some(egui) = egui {
        share_a_picture(&mut camera, &mut egui.into_inner(), light.0);
    }
}

fn choose_shapes(light: Res<LightDrawing>, mut parts: Query<(&Shapes, &mut Mesh3d)>) {
    for (shapes, mut mesh) in &mut parts {
        let wanted = shapes.shown(*light);
        if mesh.0 != *wanted {
            mesh.0 = wanted.clone();
        }
    }
}
