//! glTF: meshes of bodies are read (`.glb`, or `.gltf` with nothing outside it), scenes are written.

mod accessor;
mod error;
mod surface;
#[cfg(test)]
pub(super) mod tests;
pub mod write;
#[cfg(test)]
mod write_tests;

pub use error::{GltfError, GltfWriteError};
pub use surface::parse;
