//! A process conditioned on a room's measurements, as data.

use super::amplitude::Amplitude;
use super::kernel::Kernel;
use super::registration::Registration;
use super::row::{ErrorValues, Row};
use crate::harmonic::HarmonicModel;
use serde::{Deserialize, Serialize};

/// What the process is added to.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Trend {
    /// Rows are the measured errors.
    None,
    /// Rows are what the room's model leaves of them.
    Model,
}

/// A process conditioned on a room's measurements.
#[derive(Clone, Debug, PartialEq)]
pub struct GaussianField {
    pub trend: Trend,
    pub kernel: Kernel,
    pub amplitude: Amplitude,
    /// Covariance of the components of unit amplitude: mm², mm rad, rad².
    pub component_covariance: [ErrorValues; 6],
    pub rows: Vec<Row>,
    /// Whether rotation errors and axes were measured.
    pub has_rotations: bool,
    /// Rows that were measured; more than are kept where there were too many.
    pub measured_rows: usize,
    /// RMS of what is left of a row's position error where the row is left out, mm, outliers not
    /// counted; by 1,000 rows at most.
    pub left_out_rms_mm: f64,
    /// Variance of what another sensor is off by at every pose, a component (mm², rad²), beyond what the
    /// measurements determine; `None` where they were not of several sensors.
    pub sensor_variance: Option<ErrorValues>,
    /// The room's model fitted without one group of its measurements each; none of a model that the
    /// process is not added to, and of polynomials, whose error is in the process.
    pub refits: Vec<HarmonicModel>,
    /// How well the reference's frame is known, where that is stated.
    pub registration: Option<Registration>,
}
