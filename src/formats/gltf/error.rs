//! Why bytes are not a mesh.

/// Why bytes are not a mesh.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum GltfError {
    #[error("found no glTF ({0}), expected a mesh in glTF 2.0")]
    NotGltf(String),
    #[error("found buffer {0} outside the file, expected all data in one .glb")]
    ExternalBuffer(usize),
    #[error("mesh {mesh:?}: found {found}, expected {expected}")]
    Mesh {
        mesh: String,
        found: String,
        expected: &'static str,
    },
    #[error("node {node:?}: found {found}, expected {expected}")]
    Node {
        node: String,
        found: &'static str,
        expected: &'static str,
    },
    #[error("found no triangles, expected some")]
    Empty,
    #[error("found {found} {what}, expected at most {most}")]
    TooLarge {
        found: usize,
        what: &'static str,
        most: usize,
    },
}
