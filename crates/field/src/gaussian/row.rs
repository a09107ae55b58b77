//! What a process is conditioned on.

use crate::field_point::FieldPoint;

/// Position in mm, then rotation vector in radians.
pub type ErrorValues = [f64; 6];

/// A row that the process is conditioned on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Row {
    pub point: FieldPoint,
    /// Measured error less the trend, mm and rad, tracker axes.
    pub error: ErrorValues,
    /// Variance of its noise over that of the others; large for an outlier.
    pub noise_factor: f64,
}
