//! A distorted room: Bernstein basis, distortion model, its fit, and where it came from.

pub mod axis_model;
pub mod batch;
pub mod bernstein;
pub mod compensation;
pub mod compiled;
pub mod computed;
pub mod elevate;
pub mod environment;
mod factored;
pub mod fit;
mod fold;
pub mod gaussian;
pub mod generator;
pub mod harmonic;
pub mod inverse;
pub mod jacobian;
mod jacobian_kernel;
mod joint;
mod kernel;
mod lattice;
pub mod least_squares;
pub mod model;
pub mod random_models;
mod rows;
pub mod samples;
pub mod selection;
mod singular;
pub mod validity;

pub use axis_model::AxisModel;
pub use batch::Batch;
pub use environment::Environment;
pub use model::{DistortionModel, OutsidePolicy};
pub use validity::{FitValidity, Validity};
