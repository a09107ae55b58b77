//! A characterised room: its distortion model, where it may be used, and where it came from.

use super::fit::{FitMethod, Residuals};
use super::model::DistortionModel;
use super::support::Support;
use crate::geometry::volume::Volume;
use serde::{Deserialize, Serialize};

/// A room that designs are simulated in.
#[derive(Clone, Debug, PartialEq)]
pub struct Environment {
    pub name: String,
    pub model: DistortionModel,
    /// Where the tracker promises to measure, if that is known.
    pub volume: Option<Volume>,
    /// What the tracker's readings scatter by when nothing moves, if that is known.
    pub jitter: Option<Jitter>,
    /// `None` for an ideal room that was never measured.
    pub provenance: Option<Provenance>,
    /// Where the model may be believed, if its fit kept that.
    pub support: Option<Support>,
}

/// Standard deviations of a still sensor's readings.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Jitter {
    pub position_mm: f64,
    pub angle_rad: f64,
}

/// Where a model came from and how well it fits.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Provenance {
    /// Name of the measurement table, without its folder.
    pub data: String,
    pub samples: usize,
    pub method: FitMethod,
    pub ridge: f64,
    pub train_before: Residuals,
    pub train_after: Residuals,
    pub holdout: Option<HoldoutProvenance>,
}

/// How the model does on measurements that it was not fitted to.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct HoldoutProvenance {
    pub data: String,
    pub samples: usize,
    pub before: Residuals,
    pub after: Residuals,
}

/// Orientation weight where neither design nor environment says one, in millimetres (the paper's).
pub const DEFAULT_ORIENTATION_WEIGHT_MM: f64 = 100.0;

impl Environment {
    /// The weight of an axis against a position in frame fitting: `sigma_pos / sigma_ori` where
    /// the jitter is known (DOMAIN 0.3), else the paper's 100 mm.
    pub fn orientation_weight_mm(&self) -> f64 {
        self.jitter
            .filter(|j| j.position_mm > 0.0 && j.angle_rad > 0.0)
            .map_or(DEFAULT_ORIENTATION_WEIGHT_MM, |j| {
                j.position_mm / j.angle_rad
            })
    }
}
