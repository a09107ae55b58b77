//! Why bytes are not a mesh.

use crate::gltf::error::GltfError;
use trackwright_geometry::mesh_reference::MeshUnit;

/// Most triangles of a mesh. CAD models of instruments have up to some hundred thousand, scans of
/// anatomy a few million; this many fill about 2 GB while they are read, drawn and picked.
pub const MAX_TRIANGLES: usize = 10_000_000;

/// Farthest corner from the origin: a thousand kilometres. What is computed from products of
/// coordinates stays far from overflow.
pub const MAX_COORDINATE_MM: f64 = 1e9;

/// Why bytes are not a mesh.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum MeshError {
    #[error(transparent)]
    Gltf(#[from] GltfError),
    #[error("line {line}: found {found}, expected {expected}")]
    Line { line: usize, found: String, expected: &'static str },
    #[error(
        "found an STL of {found} bytes, expected {expected} for the {triangles} triangles announced"
    )]
    Length { found: usize, expected: u64, triangles: u32 },
    #[error("found no triangles, expected some")]
    Empty,
    #[error("found {left_out} triangles, all with corners that are no numbers, expected some")]
    NoNumbers { left_out: usize },
    #[error("found {0} triangles, expected at most {MAX_TRIANGLES}")]
    TooLarge(usize),
    /// A text does not state how much there is to come.
    #[error("line {line}: found more than {MAX_TRIANGLES} {what} so far, expected fewer")]
    TooLargeAt { line: usize, what: &'static str },
    #[error("found a corner {0:.3e} mm from the origin, expected at most {MAX_COORDINATE_MM:.0e}")]
    TooFar(f64),
    #[error("the unit is {unit}, expected {expected}")]
    Unit { unit: MeshUnit, expected: &'static str },
    /// With the file's extension.
    #[error("found a file {}, expected a mesh as .glb, .gltf, .stl or .obj", called(.0))]
    Unknown(String),
}

fn called(extension: &str) -> String {
    if extension.is_empty() {
        "of no known format".to_owned()
    } else {
        format!("of no known format named .{extension}")
    }
}
