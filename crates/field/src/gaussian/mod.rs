//! A Gaussian process for a room's field: its mean and uncertainty given measurements.
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
mod field;
mod fit;
mod hyper_parameters;
mod kernel;
mod kernel_columns;
mod kriging;
mod model_deviations;
mod neighborhoods;
mod posterior;
mod readings;
mod registration;
mod row;
#[cfg(test)]
mod tests;

pub use amplitude::Amplitude;
pub use field::{GaussianField, Trend};
pub use fit::{GaussianError, MAX_ROWS, TUNING_ROWS, chosen_rows, kept_rows};
pub use kernel::{Kernel, KernelScale};
pub use kriging::Kriging;
pub use posterior::{DrawnErrors, Posterior};
pub use readings::{ReadingDistance, ReadingError, ReadingRms, Readings};
pub use registration::Registration;
pub use row::{ErrorValues, Row};
