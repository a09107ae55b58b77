//! Poses, rotations, basis orientations, boxes and volumes, surfaces and rays: f64, mm, rad, no files.
//!
//! ```
//! use nalgebra::{Unit, Vector3};
//! use trackwright_geometry::directions::{DirectionSet, Weighting};
//! use trackwright_geometry::rotation::{axis_rotation, exp_vector};
//!
//! let axis = Unit::new_normalize(Vector3::new(0.2, -0.5, 0.3));
//! // The axis as a mean of the three basis orientations around it.
//! let weights = DirectionSet::Fourteen.weights(&axis, Weighting::Area).weights;
//! assert!((weights.iter().sum::<f64>() - 1.0).abs() < 1e-15);
//! // The smallest rotation that takes z to it.
//! let turn = axis_rotation(&Vector3::z_axis(), &axis).vector_rad;
//! assert!((exp_vector(&turn) * Vector3::z() - axis.into_inner()).norm() < 1e-15);
//! ```

pub mod bounds;
pub mod box_face;
pub mod box_union;
pub mod coarse;
pub mod color;
pub mod colormap;
mod direction_search;
pub mod directions;
pub mod domed_cylinder;
mod finer;
pub mod gizmo;
pub mod isosurface;
pub mod limits;
pub mod long_body;
pub mod magnification;
pub mod mesh;
pub mod mesh_reference;
pub mod mesh_report;
pub mod movement;
pub mod normals;
pub mod number;
pub mod orbit;
pub mod outline;
mod patch;
pub mod placeholder;
pub mod pointing;
pub mod pose;
pub mod revolution;
pub mod rotation;
pub mod snap;
pub mod solid;
pub mod spread;
pub mod surface;
pub mod surface_drag;
pub mod svd3;
pub mod volume;
pub mod weld;
