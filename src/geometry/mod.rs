//! Poses, rotations, basis orientations and their spherical weights, volumes, surfaces: f64, mm.

pub mod bounds;
pub mod coarse;
pub mod color;
pub mod colormap;
mod direction_search;
pub mod directions;
pub mod domed_cylinder;
pub mod gizmo;
pub mod isosurface;
pub mod magnification;
pub mod mesh;
pub mod mesh_reference;
pub mod mesh_report;
pub mod movement;
pub mod normals;
pub mod orbit;
pub mod outline;
pub mod pointing;
pub mod pose;
pub mod rotation;
pub mod solid;
pub mod spread;
pub mod stand_in;
pub mod surface;
pub mod surface_drag;
pub mod svd3;
pub mod volume;
