//! The part of the patient's surface that the CRF may stand on.

use nalgebra::Point3;
use std::sync::Arc;
use trackwright_geometry::bounds::Bounds;
use trackwright_geometry::mesh::SurfaceMesh;
use trackwright_geometry::pose::Pose;
use trackwright_geometry::surface::Surface;
use trackwright_simulation::placement::placement_mesh;

/// The part of an anatomy's surface that the CRF may stand on.
#[derive(Clone, Debug)]
pub struct CrfPatch {
    /// Its name.
    pub anatomy: String,
    /// Of the whole mesh, in its own frame; `None` of one that has no triangle or was not read.
    pub(crate) surface: Option<Arc<Surface>>,
    /// Mesh frame: what of the surface is in one of them.
    boxes: Vec<Bounds>,
    /// Points of the surface in the boxes, close enough to stand for all of it.
    pub(crate) points_mm: Arc<[Point3<f64>]>,
    /// At the start.
    pub(crate) crf_from_mesh: Pose,
}

impl CrfPatch {
    /// The patch in these boxes of the mesh's own frame, where the CRF sees the mesh now.
    pub fn of_mesh(
        anatomy: &str,
        mesh: Option<&SurfaceMesh>,
        boxes: &[Bounds],
        crf_from_mesh: Pose,
    ) -> Self {
        let mut patch = Self {
            anatomy: anatomy.to_owned(),
            surface: None,
            boxes: boxes.to_vec(),
            points_mm: Arc::new([]),
            crf_from_mesh,
        };
        if let Some(mesh) = mesh {
            // All of it is surface here, whatever its parts are called.
            let mut mesh = mesh.clone();
            mesh.parts.iter_mut().for_each(|part| part.name.clear());
            patch.surface = Surface::new(&mesh).map(Arc::new);
            let fine = placement_mesh(&mesh).unwrap_or(mesh);
            patch.points_mm = fine.patch(boxes, 0.0).positions_mm.into();
        }
        patch
    }

    pub(crate) fn contains(&self, point_mm: &Point3<f64>) -> bool {
        self.boxes.iter().any(|own| own.contains(point_mm))
    }

    /// The point of the boxes that is nearest to a point.
    pub(crate) fn clamped(&self, point_mm: &Point3<f64>) -> Option<Point3<f64>> {
        let each = self.boxes.iter().map(|own| own.clamp(point_mm));
        each.min_by(|a, b| (a - point_mm).norm().total_cmp(&(b - point_mm).norm()))
    }

    /// How far the patch is from the corners of a surface no point of which is in it.
    pub(crate) fn off_mm(&self, surface: &Surface) -> f64 {
        let corners = surface.triangles().flatten().map(|(at, _)| at);
        let away = corners.filter_map(|at| Some((self.clamped(&at)? - at).norm()));
        away.fold(f64::INFINITY, f64::min)
    }
}
