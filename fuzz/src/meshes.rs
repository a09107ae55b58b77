//! Surfaces of bodies: STL, OBJ, glTF.

use super::read;
use trackwright_formats::mesh::{self, MAX_COORDINATE_MM};
use trackwright_geometry::mesh::SurfaceMesh;

/// An STL or OBJ file, recognised by how it begins: no more comes of it than it has bytes.
pub fn mesh(bytes: &[u8]) -> bool {
    let Some(mesh) = read(mesh::read(bytes, "", None)) else {
        return false;
    };
    assert_sound(&mesh);
    // A glTF file may show the same numbers several times.
    if !bytes.trim_ascii_start().starts_with(b"{") && !bytes.starts_with(b"glTF") {
        let triangles: usize = mesh.parts.iter().map(|part| part.triangles.len()).sum();
        let corners: usize = mesh.parts.iter().map(|part| part.positions_mm.len()).sum();
        assert!(triangles + mesh.reading.triangles_left_out <= bytes.len());
        assert!(corners <= 3 * triangles);
    }
    true
}

/// A glTF file, binary or not.
pub fn gltf(bytes: &[u8]) -> bool {
    let mesh = read(mesh::read(bytes, "gltf", None));
    mesh.inspect(assert_sound).is_some()
}

/// Every corner is one that there is, every number one that can be drawn.
fn assert_sound(mesh: &SurfaceMesh) {
    assert!(mesh.parts.iter().any(|part| !part.triangles.is_empty()));
    for part in &mesh.parts {
        let count = part.positions_mm.len();
        assert_eq!(part.normals.len(), count);
        let mut corners = part.triangles.iter().flatten();
        assert!(corners.all(|corner| (*corner as usize) < count));
        let mut numbers = part.positions_mm.iter().flat_map(|p| p.iter());
        assert!(numbers.all(|v| v.abs() <= MAX_COORDINATE_MM));
        let is_unit = |length: f64| (length - 1.0).abs() < 1e-6;
        assert!(part.normals.iter().all(|n| is_unit(n.norm())));
    }
}
