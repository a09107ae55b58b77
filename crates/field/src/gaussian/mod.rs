//! A Gaussian process for a room's field: what the measurements say of it and what they leave open.
//!
//! The six error components at a sensor pose `(p, n)` are `e = t(p, n) + s(p) · g(p, n)`: a trend
//! (nothing, or the room's model), an amplitude that varies over the volume, and a process of unit
//! amplitude with covariance `k((p, n), (p', n')) C`. `k` is a sum of two Matérn 5/2 kernels in
//! position, each times an even kernel in the axis (a coil turned round reads the same), `C` the
//! 6 x 6 covariance of the components (the intrinsic coregionalisation model, Rasmussen & Williams
//! 2006, section 9.1; Alvarez et al., Found. Trends Mach. Learn. 4(3), 2012). Hyper-parameters
//! maximise the marginal likelihood times a broad prior, so that few rows have an answer too.
//!
//! Errors are larger near metal than elsewhere: the amplitude is a log-polynomial fitted to the
//! leave-one-out residuals. What is left of their spread (kurtosis, and dependence of their squares
//! over distance) is an amplitude that a draw varies by chance.

mod amplitude;
mod column_blocks;
mod conditioned;
mod fit;
mod hyper_parameters;
mod kernel;
mod kernel_columns;
mod kriging;
mod posterior;
mod readings;
#[cfg(test)]
mod tests;

pub use amplitude::Amplitude;
pub use fit::{GaussianError, MAX_ROWS, TUNING_ROWS, chosen_rows, kept_rows};
pub use kernel::{FieldPoint, Kernel, KernelScale};
pub use kriging::Kriging;
pub use posterior::{DrawnErrors, Posterior};
pub use readings::{ReadingDistance, ReadingError};

use serde::{Deserialize, Serialize};

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
    /// measurements say; `None` where they were not of several sensors.
    pub sensor_variance: Option<ErrorValues>,
}
