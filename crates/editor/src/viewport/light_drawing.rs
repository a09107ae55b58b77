//! What a processor that paints by itself leaves out while something moves: smooth edges, and
//! most triangles of large bodies. The first frame at rest has them again.

use crate::convert;
use crate::document::requests::ActiveDrag;
use crate::schedule::EditorSystems;
use crate::viewport::camera::MainCamera;
use crate::viewport::camera::{Gesture, OrbitRig, Turntable};
use crate::viewport::egui_camera::{EguiCamera, share_a_picture};
use bevy::prelude::*;
use bevy::render::renderer::RenderAdapterInfo;
use trackwright_geometry::coarse::coarser;
use trackwright_geometry::mesh::MeshPart;

/// Triangles of a body's part that are drawn while something moves: each of those of a part that
/// fills half the height of a 720 pixel view covers a few pixels. With 40,000 a frame of a body and
/// its ghost took 110 ms in software, with 10,000 90 ms.
const MOVING_TRIANGLES: usize = 12_000;

/// Draws less while something moves, where no graphics card does the work.
pub struct LightDrawingPlugin;

/// Whether less is drawn now.
#[derive(Resource, Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct LightDrawing(pub bool);

/// The mesh of a part, and the one that stands for it while something moves.
#[derive(Component, Clone, Debug)]
pub struct Shapes {
    pub fine: Handle<Mesh>,
    coarse: Option<Handle<Mesh>>,
}

impl Shapes {
    /// One mesh for all times.
    pub fn one(fine: Handle<Mesh>) -> Self {
        Self { fine, coarse: None }
    }

    /// Another mesh while something moves.
    pub fn two(fine: Handle<Mesh>, coarse: Handle<Mesh>) -> Self {
        let coarse = Some(coarse);
        Self { fine, coarse }
    }

    /// A coarser one beside it, where the part has many triangles.
    pub fn with_coarse(part: &MeshPart, fine: Handle<Mesh>, meshes: &mut Assets<Mesh>) -> Self {
        let coarse = coarser(part, MOVING_TRIANGLES);
        Self { fine, coarse: coarse.map(|coarse| meshes.add(convert::mesh(&coarse))) }
    }

    /// What is to be drawn.
    pub fn shown(&self, light: LightDrawing) -> &Handle<Mesh> {
        match &self.coarse {
            Some(coarse) if light.0 => coarse,
            _ => &self.fine,
        }
    }
}

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

/// Whether a processor paints.
pub fn paints_in_software(adapter: Option<Res<RenderAdapterInfo>>) -> bool {
    adapter.is_some_and(|adapter| adapter.device_type == wgpu::DeviceType::Cpu)
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

/// The camera that egui is painted with, told apart from the scene's.
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
