//! The bodies' meshes as the renderer has them: made once, for body and ghost alike, with a coarser one
//! for what a processor that paints by itself draws while something moves.

use crate::convert;
use bevy::prelude::*;
use bevy::render::renderer::RenderAdapterInfo;
use std::sync::Arc;
use trackwright_design::BodyRole;
use trackwright_geometry::coarse::coarser;
use trackwright_geometry::mesh::{MeshPart, SurfaceMesh};

/// Triangles of a body's part that are drawn while something moves: each of those of a part that
/// fills half the height of a 720 pixel view covers a few pixels. With 40,000 a frame of a body and
/// its ghost took 110 ms in software, with 10,000 90 ms.
const MOVING_TRIANGLES: usize = 12_000;

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

    /// Of a part; in software with a coarser one beside it, where the part has many triangles.
    pub fn of_part(part: &MeshPart, meshes: &mut Assets<Mesh>, is_software: bool) -> Self {
        let coarse = is_software.then(|| coarser(part, MOVING_TRIANGLES)).flatten();
        Self {
            fine: meshes.add(convert::mesh(part)),
            coarse: coarse.map(|coarse| meshes.add(convert::mesh(&coarse))),
        }
    }

    /// Of each part of a mesh.
    pub fn of_parts(mesh: &SurfaceMesh, meshes: &mut Assets<Mesh>, is_software: bool) -> Vec<Self> {
        mesh.parts.iter().map(|part| Self::of_part(part, meshes, is_software)).collect()
    }

    /// What is to be drawn.
    pub fn shown(&self, light: LightDrawing) -> &Handle<Mesh> {
        match &self.coarse {
            Some(coarse) if light.0 => coarse,
            _ => &self.fine,
        }
    }
}

/// Whether a processor paints.
pub fn paints_in_software(adapter: Option<Res<RenderAdapterInfo>>) -> bool {
    adapter.is_some_and(|adapter| adapter.device_type == wgpu::DeviceType::Cpu)
}

/// Whether two meshes are one; a placeholder is made anew each time.
pub fn is_same_mesh(a: &Arc<SurfaceMesh>, b: &Arc<SurfaceMesh>) -> bool {
    Arc::ptr_eq(a, b) || a == b
}

/// What each body's mesh was made into.
#[derive(Resource, Default)]
pub struct BodyMeshes([Option<Made>; 2]);

struct Made {
    from: Arc<SurfaceMesh>,
    /// One a part.
    shapes: Vec<Shapes>,
}

impl BodyMeshes {
    /// The parts of a body's mesh with their shapes; made anew where it is another mesh than
    /// before.
    pub fn of<'m>(
        &mut self,
        role: BodyRole,
        mesh: &'m Arc<SurfaceMesh>,
        meshes: &mut Assets<Mesh>,
        is_software: bool,
    ) -> Vec<(&'m MeshPart, Shapes)> {
        let made = &mut self.0[role as usize];
        let made = match made {
            Some(made) if is_same_mesh(&made.from, mesh) => made,
            _ => made.insert(Made {
                from: Arc::clone(mesh),
                shapes: Shapes::of_parts(mesh, meshes, is_software),
            }),
        };
        mesh.parts.iter().zip(made.shapes.iter().cloned()).collect()
    }
}
