//! Chooses a model's order, orientations and ridge by what they leave of samples they have not
//! seen: k-fold cross-validation by row, by groups of rows that belong together, and by sensor.
//!
//! Where groups are known they decide unless sensors are requested: neighbours of a held-out row
//! would predict its error.

mod choice;
pub mod clusters;
mod cross_validation;
pub mod folds;
mod hold_outs;
pub mod other;
pub mod path;
pub mod places;
pub mod scoring;
mod select;
pub mod sensors;
mod settings;
#[cfg(test)]
mod tests;

pub use choice::{Choice, Contender, TOLERANCE, choose};
pub use hold_outs::{HoldOut, HoldOutBy, HoldOuts};
pub use scoring::Scores;
pub use select::{Scored, Selection, select, select_by};
pub use settings::{
    Candidate, DEFAULT_FOLDS, DEFAULT_RIDGES, DEFAULT_SEED, SelectError, SelectSettings,
};
