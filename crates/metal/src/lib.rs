//! What metal does to the field of a tracker's coils: materials, spheres in closed form, closed surfaces
//! of any material by boundary elements, and several bodies in each other's fields.
//!
//! Trackers use 1 to 30 kHz, where fields around metal are quasi-static: each coil's field induces
//! currents and magnetisation, and these add a field of their own, the disturbance. A tracker that
//! demodulates in phase measures its real part. Lengths are in mm, fields in the unit of
//! `trackwright_field::generator` (mm⁻³ for a unit dipole), poses in the tracker frame.
//!
//! ```
//! use nalgebra::{Point3, Vector3};
//! use std::sync::Arc;
//! use trackwright_field::generator::Generator;
//! use trackwright_geometry::pose::Pose;
//! use trackwright_metal::body::{MetalBody, MetalShape};
//! use trackwright_metal::boundary::BoundaryShape;
//! use trackwright_metal::material::Material;
//! use trackwright_metal::room::{MetalRoom, PlacedBody};
//! use trackwright_metal::shapes::cuboid;
//! use trackwright_metal::surface::ClosedSurface;
//! use trackwright_task::Task;
//!
//! // An aluminium plate beside the patient, at the frequency of a tracker.
//! let mesh = cuboid(&Vector3::new(150.0, 150.0, 10.0), 300)?;
//! let task = Task::default();
//! let shape = Arc::new(BoundaryShape::new(ClosedSurface::new(&mesh)?, &task)?);
//! let aluminium = Material::named("aluminium").unwrap();
//! let plate = Arc::new(MetalBody::new(MetalShape::Surface(shape), aluminium, 10e3, &task)?);
//! let at = |x: f64| Pose::translation(x, 0.0, -200.0);
//! let placed = PlacedBody { body: plate, tracker_from_body: at(250.0) };
//! let room = MetalRoom::new(Generator::planar_nine(), None, vec![placed], &task)?;
//!
//! // A sensor that is in truth in the middle.
//! let sensor = Point3::new(0.0, 0.0, -200.0);
//! let error_mm = |room: &MetalRoom| -> Result<f64, Box<dyn std::error::Error>> {
//!     Ok((room.read_axis(&sensor, &Vector3::x_axis())?.position_mm - sensor).norm())
//! };
//! // Nearer metal makes a larger error; what was factored for the plate is used again.
//! assert!(error_mm(&room.with_pose(0, at(150.0), &task)?)? > 2.0 * error_mm(&room)?);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

pub mod body;
pub mod boundary;
mod cells;
mod crossing;
pub mod exchange;
mod factors;
pub mod furnished;
mod harmonics;
pub mod identify;
pub mod material;
mod mixing;
pub mod new_object;
pub mod panel;
mod panel_lanes;
mod phase;
pub mod room;
pub mod setup;
pub mod shapes;
pub mod sphere;
pub mod surface;
mod uncertainty;

#[cfg(test)]
mod tests;
