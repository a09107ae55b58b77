//! The surfaces of bodies and metal objects, which rays of the pointer are cast on: in f64, in their own
//! frames.

use crate::document::requests::OpenWorld;
use bevy::prelude::*;
use nalgebra::Point3;
use std::sync::{Arc, OnceLock};
use trackwright_design::{BodyRole, Design};
use trackwright_geometry::mesh::SurfaceMesh;
use trackwright_geometry::normals::with_smooth_normals;
use trackwright_geometry::snap::SnapPoints;
use trackwright_geometry::surface::{Ray, Surface, SurfacePoint};
use trackwright_metal::setup::{MetalObject, ObjectShape};

/// The surfaces of both bodies and of the room's metal, made once a shape; and of the anatomy that is
/// painted.
#[derive(Resource, Default)]
pub struct Surfaces {
    bodies: [Option<MeshSurface>; 2],
    anatomy: Option<MeshSurface>,
    /// In the order of the objects; `None` of a shape that cannot be.
    metal: Vec<(ObjectShape, Option<Arc<Surface>>)>,
}

/// A mesh, its surface, and what is made of them on demand.
struct MeshSurface {
    mesh: Arc<SurfaceMesh>,
    /// `None` where the mesh has no area.
    surface: Option<Arc<Surface>>,
    /// With normals that are smooth over shallow edges, made when a drag follows them.
    smooth: OnceLock<Option<Arc<Surface>>>,
    /// Made when a pointer first snaps to them.
    snap_points: OnceLock<SnapPoints>,
}

impl MeshSurface {
    fn of(mesh: &Arc<SurfaceMesh>) -> Self {
        Self {
            mesh: Arc::clone(mesh),
            surface: Surface::new(mesh).map(Arc::new),
            smooth: OnceLock::new(),
            snap_points: OnceLock::new(),
        }
    }
}

impl Surfaces {
    /// The surface of a body; `None` where it has no mesh with an area.
    pub fn of(&self, role: BodyRole) -> Option<&Arc<Surface>> {
        self.bodies[role as usize].as_ref()?.surface.as_ref()
    }

    /// What a pointer snaps to on a body; `None` where it has no mesh.
    pub fn snap_points(&self, role: BodyRole) -> Option<&SnapPoints> {
        let own = self.bodies[role as usize].as_ref()?;
        Some(own.snap_points.get_or_init(|| SnapPoints::of(&own.mesh, own.surface.as_deref())))
    }

    /// The same with normals that are smooth over shallow edges, whatever the mesh has.
    pub fn smooth_of(&self, role: BodyRole) -> Option<&Arc<Surface>> {
        let own = self.bodies[role as usize].as_ref()?;
        let make = || Surface::new(&with_smooth_normals(&own.mesh)).map(Arc::new);
        own.smooth.get_or_init(make).as_ref()
    }

    /// The surface of the anatomy that is painted; `None` of another mesh, and of one without an area.
    pub fn of_anatomy(&self, mesh: &Arc<SurfaceMesh>) -> Option<&Arc<Surface>> {
        let own = self.anatomy.as_ref().filter(|own| Arc::ptr_eq(&own.mesh, mesh))?;
        own.surface.as_ref()
    }

    /// The surface of a metal object.
    pub fn of_metal(&self, index: usize) -> Option<&Arc<Surface>> {
        self.metal.get(index)?.1.as_ref()
    }

    fn keep_metal(&mut self, objects: &[MetalObject]) {
        let mut kept = std::mem::take(&mut self.metal);
        self.metal.extend(objects.iter().map(|object| {
            // They keep their order, but for those that were removed.
            let known = kept.iter().position(|(shape, _)| *shape == object.shape);
            known.map(|index| kept.remove(index)).unwrap_or_else(|| {
                let drawn = object.shape.drawn().ok();
                let surface = drawn.and_then(|mesh| Surface::new(&mesh)).map(Arc::new);
                (object.shape.clone(), surface)
            })
        }));
    }

    /// Makes the surface of a mesh of anatomy, or gives up the one that was made.
    pub fn keep_anatomy(&mut self, mesh: Option<&Arc<SurfaceMesh>>) {
        match (mesh, &self.anatomy) {
            (Some(mesh), Some(own)) if Arc::ptr_eq(&own.mesh, mesh) => {}
            (mesh, _) => self.anatomy = mesh.map(MeshSurface::of),
        }
    }

    /// The nearest point of a body on a ray of the tracker frame.
    pub fn under(&self, design: &Design, ray: &Ray) -> Option<Point3<f64>> {
        let (role, hit) = self.hit(design, ray, &BodyRole::ALL)?;
        Some(design.tracker_from_body(role)? * hit.position_mm)
    }

    /// Which of some bodies a ray of the tracker frame meets first, and where, in its frame.
    pub fn hit(
        &self,
        design: &Design,
        ray: &Ray,
        roles: &[BodyRole],
    ) -> Option<(BodyRole, SurfacePoint)> {
        let hits = roles.iter().filter_map(|role| {
            let pose = design.tracker_from_body(*role)?;
            let in_body = ray.transformed_by(&pose.inverse());
            let hit = self.of(*role)?.cast(&in_body)?;
            let distance = (hit.position_mm - in_body.origin_mm).norm();
            Some((distance, (*role, hit)))
        });
        let nearest = hits.min_by(|a, b| a.0.total_cmp(&b.0));
        nearest.map(|(_, hit)| hit)
    }
}

pub(crate) fn make_surfaces(world: Res<OpenWorld>, mut surfaces: ResMut<Surfaces>) {
    for role in BodyRole::ALL {
        let mesh = world.0.mesh(role);
        let has = surfaces.bodies[role as usize].as_ref().map(|own| &own.mesh);
        let is_current = match (has, mesh) {
            (Some(a), Some(b)) => Arc::ptr_eq(a, b),
            (None, None) => true,
            _ => false,
        };
        if !is_current {
            surfaces.bodies[role as usize] = mesh.map(MeshSurface::of);
        }
    }
    let metal = &world.0.document.design().room_metal;
    surfaces.keep_metal(metal.as_ref().map_or(&[], |metal| &metal.objects));
}
