//! What is measured on: the built-in design with a room of order 4, and with a tool of very many
//! triangles.

use crate::app::measure::error::MeasureError;
use nalgebra::{Point3, Vector3};
use std::f64::consts::TAU;
use std::sync::Arc;
use trackwright_design::Document;
use trackwright_geometry::mesh::{MeshPart, SurfaceMesh};
use trackwright_project::World;

/// Order of the rooms that are measured in.
const ORDER: usize = 4;

/// Millimetres, about those of the built-in pointer: a shaft with a ripple, so that no two of its
/// facets look alike.
const SHAFT_LENGTH_MM: f64 = 160.0;
const SHAFT_RADIUS_MM: f64 = 6.0;
const RIPPLE_MM: f64 = 0.6;
const RIPPLES: f64 = 12.0;

/// The built-in design in its own room, carried over to order 4 without a change of the field.
pub fn order_four() -> Result<World, MeasureError> {
    let mut world = trackwright_project::open_builtin(trackwright_project::DEFAULT_BUILTIN)?;
    let mut room = (*world.environment).clone();
    room.model = room.model.elevated(ORDER)?;
    // What the fit knows of its samples belongs to its own order.
    room.fit_validity = None;
    world.is_in_room(Arc::new(room));
    Ok(world)
}

/// The same with another tool mesh.
pub fn with_tool_mesh(world: &World, mesh: SurfaceMesh) -> World {
    let document: Document = world.document.clone();
    let crf = world.mesh(trackwright_design::BodyRole::Crf).cloned();
    World::new(document, Arc::clone(&world.environment), Some(Arc::new(mesh)), crf)
}

/// A rippled tube along z: `around · (along + 1)` vertices, `2 · around · along` triangles.
pub fn tube(around: u32, along: u32) -> SurfaceMesh {
    let mut part = MeshPart {
        name: "tube".to_owned(),
        positions_mm: Vec::new(),
        normals: Vec::new(),
        triangles: Vec::new(),
        base_color: [0.6, 0.6, 0.58, 1.0],
        metallic: 0.0,
        roughness: 0.5,
    };
    for j in 0..=along {
        let part_along = f64::from(j) / f64::from(along);
        let (wave, slope) = (part_along * RIPPLES * TAU).sin_cos();
        let radius_mm = SHAFT_RADIUS_MM + RIPPLE_MM * wave;
        let climb = RIPPLE_MM * slope * RIPPLES * TAU / SHAFT_LENGTH_MM;
        for i in 0..around {
            let (sine, cosine) = (f64::from(i) / f64::from(around) * TAU).sin_cos();
            let outward = Vector3::new(cosine, sine, 0.0);
            let along_mm = Vector3::z() * (part_along * SHAFT_LENGTH_MM);
            part.positions_mm.push(Point3::from(outward * radius_mm + along_mm));
            part.normals.push((outward - Vector3::z() * climb).normalize());
        }
    }
    for j in 0..along {
        for i in 0..around {
            let at = |i: u32, j: u32| j * around + i % around;
            let [a, b] = [at(i, j), at(i + 1, j)];
            let [c, d] = [at(i + 1, j + 1), at(i, j + 1)];
            part.triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
    SurfaceMesh { parts: vec![part], ..SurfaceMesh::default() }
}
