//! Triangle meshes of bodies in f64 millimetres.

use super::bounds::Bounds;
use nalgebra::{Point3, Vector3};

/// How parts that show the patient rather than the instrument are named.
pub const ANATOMY_PREFIX: &str = "anatomy";

/// A body's shape in the body's own frame.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SurfaceMesh {
    pub parts: Vec<MeshPart>,
    pub reading: MeshReading,
}

/// How a mesh was read, and what had to be added and left out.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MeshReading {
    /// Length of the unit that the file was read in.
    pub mm_per_unit: f64,
    /// Whether there were parts without normals, which then got some.
    pub normals_made: bool,
    /// Triangles with a corner that is no finite number.
    pub triangles_left_out: usize,
}

impl Default for MeshReading {
    fn default() -> Self {
        Self { mm_per_unit: 1.0, normals_made: false, triangles_left_out: 0 }
    }
}

/// Triangles of one material.
#[derive(Clone, Debug, PartialEq)]
pub struct MeshPart {
    pub name: String,
    /// Body frame, millimetres.
    pub positions_mm: Vec<Point3<f64>>,
    /// One a position, unit length, outward.
    pub normals: Vec<Vector3<f64>>,
    /// Counter-clockwise seen from outside.
    pub triangles: Vec<[u32; 3]>,
    /// Linear RGBA.
    pub base_color: [f32; 4],
    pub metallic: f32,
    pub roughness: f32,
}

/// An empty part of a plain grey.
impl Default for MeshPart {
    fn default() -> Self {
        Self {
            name: String::new(),
            positions_mm: Vec::new(),
            normals: Vec::new(),
            triangles: Vec::new(),
            base_color: [0.6, 0.6, 0.6, 1.0],
            metallic: 0.0,
            roughness: 0.5,
        }
    }
}

impl SurfaceMesh {
    /// The parts that belong to the instrument: what sensors sit on.
    pub fn body_parts(&self) -> impl Iterator<Item = &MeshPart> {
        self.parts.iter().filter(|part| !part.is_anatomy())
    }

    /// The box around the instrument, without anatomy; `None` for an empty mesh.
    pub fn body_bounds(&self) -> Option<Bounds> {
        Bounds::around(self.body_parts().flat_map(|part| part.positions_mm.iter().copied()))
    }

    /// Direction in which the instrument is longest: a unit axis of the body frame, its sign the
    /// one that points to the farther end from the origin.
    ///
    /// Instruments are modelled along one of their frame's axes, so the box's longest side is
    /// that axis, and unlike a principal axis it does not tilt with a handle to one side.
    pub fn long_axis(&self) -> Vector3<f64> {
        let Some(bounds) = self.body_bounds() else {
            return Vector3::z();
        };
        let longest = bounds.size_mm().imax();
        let mut axis = Vector3::zeros();
        axis[longest] = if bounds.center_mm()[longest] < 0.0 { -1.0 } else { 1.0 };
        axis
    }
}

impl MeshPart {
    /// Whether the part shows the patient: drawn translucent, and nothing is mounted on it.
    pub fn is_anatomy(&self) -> bool {
        self.name.starts_with(ANATOMY_PREFIX)
    }

    /// The corners of a triangle.
    pub fn corners_mm(&self, triangle: usize) -> [Point3<f64>; 3] {
        self.triangles[triangle].map(|i| self.positions_mm[i as usize])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn part(name: &str, corners: &[[f64; 3]]) -> MeshPart {
        MeshPart {
            name: name.to_owned(),
            positions_mm: corners.iter().map(|&c| c.into()).collect(),
            normals: vec![Vector3::z(); corners.len()],
            triangles: vec![[0, 1, 2]],
            ..MeshPart::default()
        }
    }

    #[test]
    fn anatomy_is_not_part_of_the_box() {
        let mesh = SurfaceMesh {
            parts: vec![
                part("shaft", &[[0.0; 3], [2.0, 0.0, 0.0], [0.0, 0.0, 90.0]]),
                part("anatomy-head", &[[0.0; 3], [500.0, 0.0, 0.0], [0.0, 9.0, 0.0]]),
            ],
            ..SurfaceMesh::default()
        };
        assert_eq!(mesh.body_bounds().unwrap().max_mm.z, 90.0);
        assert_eq!(mesh.body_bounds().unwrap().max_mm.x, 2.0);
        assert_eq!(mesh.long_axis(), Vector3::z());
    }

    #[test]
    fn an_empty_mesh_has_no_box() {
        assert!(SurfaceMesh::default().body_bounds().is_none());
        assert_eq!(SurfaceMesh::default().long_axis(), Vector3::z());
    }
}
