//! Spheres in closed form: how they respond to each order of an incident field, and the field that
//! they add beside a dipole.

pub mod multipoles;
pub mod response;
pub mod rule;
pub mod series;

pub use response::{SphereError, SphereResponse, sphere_factor};
pub use series::{SeriesError, SeriesField};
