//! glTF meshes (`.glb`, or `.gltf` with nothing outside it).

mod accessor;
mod error;
mod surface;
#[cfg(test)]
pub(super) mod tests;

pub use error::GltfError;
pub use surface::parse;
