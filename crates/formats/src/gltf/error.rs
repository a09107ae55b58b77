//! Why bytes are not a mesh, and why a scene cannot be written.

/// Why bytes are not a mesh.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum GltfError {
    #[error("found no glTF ({0}), expected a mesh in glTF 2.0")]
    NotGltf(String),
    #[error(
        "found buffer {buffer} in a file of its own, {file:?}, expected all data in this one: write it as .glb, or as .gltf with its data embedded"
    )]
    ExternalBuffer { buffer: usize, file: String },
    #[error("buffer {buffer}: found {found}, expected its bytes in base64")]
    Base64 { buffer: usize, found: String },
    #[error("mesh {mesh:?}: found {found}, expected {expected}")]
    Mesh { mesh: String, found: String, expected: &'static str },
    #[error("node {node:?}: found {found}, expected {expected}")]
    Node { node: String, found: &'static str, expected: &'static str },
    #[error("found no triangles, expected some")]
    Empty,
    #[error("found {found} {what}, expected at most {most}")]
    TooLarge { found: usize, what: &'static str, most: usize },
}

impl GltfError {
    /// What a mesh of this name holds that it should not.
    pub(super) fn mesh(name: &str, found: impl Into<String>, expected: &'static str) -> Self {
        Self::Mesh { mesh: name.to_owned(), found: found.into(), expected }
    }
}

/// Why a scene cannot be written.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum GltfWriteError {
    #[error("{name:?}: found a {what} that 32-bit numbers cannot hold, expected one within 1e38")]
    NotFinite { name: String, what: &'static str },
    #[error("{name:?}: found {found} {what} for {expected} positions")]
    Counts { name: String, what: &'static str, found: usize, expected: usize },
    #[error(
        "found {bytes} bytes, expected at most the 4 GiB that a .glb can state; fewer triangles take less"
    )]
    TooLarge { bytes: usize },
    #[error("not written as JSON: {0}")]
    NotWritten(String),
}
