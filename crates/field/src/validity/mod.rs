//! Model validity: the standard error of a fit, its leverage, and the error of single readings.

mod build;
mod cells;
mod draws;
mod fit_validity;
mod form;
mod model_validity;
mod readings;

pub use build::{FitValidityError, MAX_STORED};
pub use cells::{Cell, Cells, MAX_CELLS};
pub use draws::{DrawError, FieldDraws};
pub use fit_validity::{FitValidity, FitValidityAt, FitValidityParts, FitValidityPartsError};
pub use model_validity::{ModelValidity, SensorPlace, SensorValidity};
pub use readings::Validity;
