//! A room's disturbance as the fields that it is made of: one harmonic function a coil.

mod batch;
pub mod fit;
pub mod learn;
mod model;
mod normal;
pub mod rows;
pub mod solid_harmonics;
mod variable_projection;

pub use fit::{
    DEFAULT_RIDGE, HarmonicFit, HarmonicFitError, HarmonicFitSettings, HarmonicRows, Loss,
    huber_weights,
};
pub use learn::{LearnError, LearnSettings, LearnedGenerator, learn, learn_again};
pub use model::{HarmonicModel, HarmonicModelError, HarmonicResiduals};
