//! glTF: meshes of bodies are read (`.glb`, or `.gltf` with all data inside it), scenes are written.

mod accessor;
mod buffer;
pub(super) mod error;
mod surface;
#[cfg(test)]
pub(super) mod tests;
pub mod write;
#[cfg(test)]
mod write_tests;

pub use error::{GltfError, GltfWriteError};
pub use surface::parse;
