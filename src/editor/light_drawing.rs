//! What a processor that paints by itself leaves out while something moves: smooth edges, and
//! most triangles of large bodies. The first frame at rest has them again.

use super::camera::{Gesture, OrbitRig, Turntable};
use super::convert;
use super::state::{ActiveDrag, EditorSystems, MainCamera};
use crate::geometry::coarse::coarser;
use crate::geometry::mesh::MeshPart;
use bevy::prelude::*;
use bevy::render::renderer::RenderAdapterInfo;

/// Triangles of a body's part that are drawn while something moves. A part that fills half the
/// height of a 720 pixel view has about as many pixels.
const MOVING_TRIANGLES: usize = 40_000;

/// Draws less while something moves, where no graphics card does the work.
pub struct LightDrawingPlugin;

/// Whether less is drawn now.
#[derive(Resource, Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct LightDrawing(pub bool);

/// The two shapes of a large part.
#[derive(Component, Clone, Debug)]
pub struct Shapes {
    fine: Handle<Mesh>,
    coarse: Handle<Mesh>,
}

impl Plugin for LightDrawingPlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<LightDrawing>().add_systems(
            Update,
            (
                notice,
                smooth.run_if(resource_changed::<LightDrawing>),
                choose_shapes,
            )
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

/// The shapes of a part; `None` where it has few triangles, or nobody has to save any.
pub fn shapes(part: &MeshPart, fine: &Handle<Mesh>, meshes: &mut Assets<Mesh>) -> Option<Shapes> {
    Some(Shapes {
        fine: fine.clone(),
        coarse: meshes.add(convert::mesh(&coarser(part, MOVING_TRIANGLES)?)),
    })
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

/// A third of a frame goes into smooth edges.
fn smooth(light: Res<LightDrawing>, mut cameras: Query<&mut Msaa, With<MainCamera>>) {
    let wanted = match light.0 {
        true => Msaa::Off,
        false => Msaa::Sample4,
    };
    for mut msaa in &mut cameras {
        msaa.set_if_neq(wanted);
    }
}

fn choose_shapes(light: Res<LightDrawing>, mut parts: Query<(&Shapes, &mut Mesh3d)>) {
    for (shapes, mut mesh) in &mut parts {
        let wanted = match light.0 {
            true => &shapes.coarse,
            false => &shapes.fine,
        };
        if mesh.0 != *wanted {
            mesh.0 = wanted.clone();
        }
    }
}
