//! A distorted room: Bernstein basis, distortion model, its fit, and where it came from.

pub mod batch;
pub mod bernstein;
pub mod environment;
pub mod fit;
mod kernel;
pub mod least_squares;
pub mod model;
pub mod samples;
pub mod selection;

pub use batch::Batch;
pub use environment::Environment;
pub use model::{DistortionModel, OutsidePolicy};
