//! Fit quality of a model on a table: what it leaves of each sample's error.

use trackwright_field::DistortionModel;
use trackwright_field::fit::{Remainder, Residuals, remainders, residuals};
use trackwright_field::model::OutsidePolicy;
use trackwright_field::samples::SampleSet;

/// What is left of a table's errors, beside what there was.
#[derive(Clone, Debug, PartialEq)]
pub struct FitQuality {
    pub before: ErrorSummary,
    pub after: ErrorSummary,
}

/// What is left of a table's errors.
#[derive(Clone, Debug, PartialEq)]
pub struct ErrorSummary {
    pub rms: Residuals,
    pub position_max_mm: f64,
    /// `None` where orientations were not measured.
    pub angle_max_rad: Option<f64>,
    /// 95th percentile: what a colour map spans, whatever stray samples there are.
    pub position_p95_mm: f64,
    /// Length of what is left of each sample's position error.
    pub position_mm: Vec<f64>,
}

/// Judges a model on samples as `fit` does, positions outside its box taken at its border.
pub fn fit_quality(model: &DistortionModel, samples: &SampleSet) -> FitQuality {
    FitQuality { before: measured_errors(samples), after: left(model, samples) }
}

/// The samples' errors as they were measured.
pub fn measured_errors(samples: &SampleSet) -> ErrorSummary {
    let origin = [0.0; 3];
    let nowhere = trackwright_geometry::bounds::Bounds::from((origin, origin));
    left(&DistortionModel::zero(nowhere, trackwright_field::samples::MapKind::Distortion), samples)
}

fn left(model: &DistortionModel, samples: &SampleSet) -> ErrorSummary {
    let each = remainders(model, samples, OutsidePolicy::Clamp);
    let largest = |value: fn(&Remainder) -> f64| each.iter().map(value).fold(0.0, f64::max);
    let position_mm: Vec<f64> = each.iter().map(|r| r.position_mm).collect();
    ErrorSummary {
        rms: residuals(model, samples, OutsidePolicy::Clamp),
        position_max_mm: largest(|r| r.position_mm),
        angle_max_rad: samples.has_rotations.then(|| largest(|r| r.angle_rad)),
        position_p95_mm: percentile_95(&position_mm),
        position_mm,
    }
}

/// 0 of no values.
fn percentile_95(values: &[f64]) -> f64 {
    let mut sorted = values.to_vec();
    if sorted.is_empty() {
        return 0.0;
    }
    let place = (0.95 * (sorted.len() - 1) as f64).round() as usize;
    *sorted.select_nth_unstable_by(place, f64::total_cmp).1
}
