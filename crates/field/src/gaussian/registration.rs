//! The error of the reference's frame, as data.

use serde::{Deserialize, Serialize};

/// How well the reference's frame is known in the tracker's: standard deviations of each component.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Registration {
    /// Of the place of `center_mm`.
    pub position_std_mm: f64,
    pub angle_std_rad: f64,
    /// Middle of the measurements, tracker frame.
    pub center_mm: [f64; 3],
}
