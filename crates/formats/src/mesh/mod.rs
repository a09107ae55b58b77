//! Meshes of bodies in any of the formats that CAD and imaging programs write: bytes to a surface
//! in millimetres.
//!
//! glTF is read as [`super::gltf`] does. STL and OBJ are read here: the crates at hand lose what
//! follows the first solid of a text STL, read a binary one that begins with `solid` as text, and
//! overflow on indices of an OBJ (stl_io 0.11, tobj 4.0), and none of them names a line.

mod builder;
pub(super) mod error;
mod obj;
mod polygon;
mod stl;
#[cfg(test)]
pub(super) mod tests;

pub use error::{MAX_COORDINATE_MM, MAX_TRIANGLES, MeshError};

use super::gltf;
use trackwright_geometry::mesh::SurfaceMesh;
use trackwright_geometry::mesh_reference::MeshUnit;

/// The formats that meshes are read in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MeshFormat {
    Gltf,
    Stl,
    Obj,
}

impl MeshFormat {
    /// The format that a file's extension names, in any case and without its dot.
    pub fn of_extension(extension: &str) -> Option<Self> {
        match extension.to_ascii_lowercase().as_str() {
            "glb" | "gltf" => Some(Self::Gltf),
            "stl" => Some(Self::Stl),
            "obj" => Some(Self::Obj),
            _ => None,
        }
    }

    /// What one unit is by default: glTF's by its specification, for the others
    /// what CAD programs mean.
    pub fn unit(self) -> MeshUnit {
        match self {
            Self::Gltf => MeshUnit::Metre,
            Self::Stl | Self::Obj => MeshUnit::Millimetre,
        }
    }

    /// The format of a file: what a binary glTF or STL file shows by itself, else what its
    /// extension states, else what its beginning looks like.
    fn of(bytes: &[u8], extension: &str) -> Option<Self> {
        if bytes.starts_with(b"glTF") {
            return Some(Self::Gltf);
        }
        Self::of_extension(extension).or_else(|| {
            let start = bytes.trim_ascii_start();
            if start.starts_with(b"{") {
                Some(Self::Gltf)
            } else if stl::is_stl(bytes) {
                Some(Self::Stl)
            } else {
                obj::is_obj(bytes).then_some(Self::Obj)
            }
        })
    }
}

impl std::fmt::Display for MeshFormat {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::Gltf => "glTF",
            Self::Stl => "STL",
            Self::Obj => "OBJ",
        })
    }
}

/// Reads a mesh. `extension` is that of its file, without the dot; `unit` overrides that of the
/// format.
///
/// Solids of an STL and groups of an OBJ are parts with their names, so `anatomy…` is recognised
/// as in glTF. STL and OBJ without normals get those of [`trackwright_geometry::normals`]; triangles
/// with a corner that is no finite number are left out and counted.
///
/// ```
/// use trackwright_formats::mesh;
///
/// let mesh = mesh::read(b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", "obj", None)?;
/// assert_eq!(mesh.parts[0].triangles, [[0, 1, 2]]);
/// # Ok::<(), trackwright_formats::mesh::MeshError>(())
/// ```
pub fn read(
    bytes: &[u8],
    extension: &str,
    unit: Option<MeshUnit>,
) -> Result<SurfaceMesh, MeshError> {
    if let Some((unit, expected)) = unit.and_then(|unit| Some((unit, unit.problem()?))) {
        return Err(MeshError::Unit { unit, expected });
    }
    let format =
        MeshFormat::of(bytes, extension).ok_or_else(|| MeshError::Unknown(extension.to_owned()))?;
    let mm_per_unit = unit.unwrap_or(format.unit()).mm_per_unit();
    let mut mesh = match format {
        MeshFormat::Gltf => gltf::parse(bytes, mm_per_unit)?,
        MeshFormat::Stl => stl::parse(bytes, mm_per_unit)?,
        MeshFormat::Obj => obj::parse(bytes, mm_per_unit)?,
    };
    let farthest_mm = mesh
        .parts
        .iter()
        .flat_map(|part| &part.positions_mm)
        .fold(0.0_f64, |far, p| far.max(p.coords.amax()));
    if farthest_mm > MAX_COORDINATE_MM {
        return Err(MeshError::TooFar(farthest_mm));
    }
    mesh.reading.mm_per_unit = mm_per_unit;
    Ok(mesh)
}
