//! Distortion models of a tracker's field: evaluated, fitted, selected, inverted, and how valid they are.
//!
//! Lengths are in mm, angles in radians, poses in the tracker frame.
//!
//! ```
//! use nalgebra::{Point3, Unit, Vector3};
//! use trackwright_field::fit::{FitSettings, fit};
//! use trackwright_field::random_models::{Seeded, room};
//! use trackwright_field::samples::{PoseError, Sample, SampleSet};
//! use trackwright_field::OutsidePolicy;
//! use trackwright_geometry::directions::DirectionSet;
//!
//! // A tracker that reads x two per cent too far from the middle.
//! let mut seeded = Seeded::new(1);
//! let error = |p: &Point3<f64>| Vector3::x() * (0.02 * p.x);
//! let samples = (0..200).map(|_| {
//!     let position_mm = seeded.position(&room(), 0.0);
//!     let axis = Unit::new_normalize(seeded.normal_vector());
//!     let error = PoseError { position_mm: error(&position_mm), ..PoseError::default() };
//!     Sample::new(position_mm, axis, error)
//! });
//! let set = SampleSet { samples: samples.collect(), has_rotations: true, ambiguous: 0 };
//! let fitted = fit(&set, &FitSettings::new(1, DirectionSet::One), Some(room()))?;
//! assert!(fitted.after.position_rms_mm < 1e-9);
//!
//! let at = Point3::new(100.0, 0.0, -300.0);
//! let read = fitted.model.evaluate(&at, &Vector3::z_axis(), OutsidePolicy::Clamp);
//! assert!((read.error.position_mm - error(&at)).norm() < 1e-9 && read.is_inside);
//! # Ok::<(), trackwright_field::fit::FitError>(())
//! ```

pub mod axis_model;
pub mod batch;
pub mod bernstein;
pub mod compensation;
pub mod compiled;
pub mod computed;
pub mod elevate;
pub mod environment;
pub mod evaluation;
mod factored;
mod field_point;
pub mod fit;
pub mod gaussian;
pub mod generator;
pub mod harmonic;
pub mod inverse;
mod jacobian;
mod joint;
mod kernel;
mod lattice;
pub mod least_squares;
mod made_once;
pub mod model;
mod qr_update;
pub mod random_models;
mod rows;
pub mod samples;
pub mod selection;
mod singular;
pub mod validity;

pub use axis_model::AxisModel;
pub use batch::Batch;
pub use environment::Environment;
pub use field_point::FieldPoint;
pub use model::{DistortionModel, OutsidePolicy};
pub use validity::{FitValidity, Validity};
