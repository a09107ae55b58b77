//! The bodies' meshes as the renderer has them: made once, for body and ghost alike.

use crate::convert;
use crate::scene::bodies::is_same_mesh;
use crate::viewport::light_drawing::Shapes;
use bevy::prelude::*;
use std::sync::Arc;
use trackwright_design::BodyRole;
use trackwright_geometry::mesh::{MeshPart, SurfaceMesh};

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
                shapes: mesh
                    .parts
                    .iter()
                    .map(|part| {
                        let fine = meshes.add(convert::mesh(part));
                        match is_software {
                            true => Shapes::with_coarse(part, fine, meshes),
                            false => Shapes::one(fine),
                        }
                    })
                    .collect(),
            }),
        };
        mesh.parts.iter().zip(made.shapes.iter().cloned()).collect()
    }
}
