//! Poses, rotations, basis orientations and their spherical weights, volumes, surfaces: f64, mm.

pub mod bounds;
pub mod directions;
pub mod mesh;
pub mod pose;
pub mod rotation;
pub mod svd3;
pub mod volume;
