//! How far a room's model itself is determined: what it would be without one group of its measurements.
//!
//! The delete-a-group jackknife (Shao & Tu, *The Jackknife and Bootstrap*, 1995, chapter 2; Kott, J.
//! Official Statistics 17, 2001): with `m_k` the model without group `k` of `K`, `Σ (m_k − m̄)² (K − 1) / K`
//! is the variance of the model. It holds what no residual shows: coefficients that the measured
//! orientations hardly determine, and the coils of a learned generator.

use super::field::GaussianField;
use super::kernel::FieldPoint;
use super::posterior::DrawnErrors;
use crate::evaluation::Coefficient;
use rayon::prelude::*;

impl GaussianField {
    /// A field at some poses for each refit, so that their sum with independent normal factors has the
    /// covariance of the model's errors; mm and rad. Nothing where the room keeps no refits.
    pub(super) fn model_deviations(&self, at: &[FieldPoint]) -> Vec<DrawnErrors> {
        let positions_mm: Vec<_> = at.iter().map(|point| point.position_mm).collect();
        let axes: Vec<_> = at.iter().map(|point| point.axis).collect();
        let of_refit = |model: &crate::harmonic::HarmonicModel| -> Vec<Option<Coefficient>> {
            let mut errors = vec![None; at.len()];
            model.axis_errors(&positions_mm, &axes, &mut errors);
            errors
        };
        let each: Vec<_> = self.refits.par_iter().map(of_refit).collect();
        let count = each.len() as f64;
        let factor = ((count - 1.0) / count).sqrt();
        let mut deviations = vec![vec![[0.0; 6]; at.len()]; each.len()];
        for i in 0..at.len() {
            // Where a refit has no reading the pose is hardly determined; the others tell.
            let known: Vec<&Coefficient> = each.iter().filter_map(|of| of[i].as_ref()).collect();
            for c in 0..6 {
                let mean = known.iter().map(|of| of[c]).sum::<f64>() / known.len().max(1) as f64;
                for (deviation, of) in deviations.iter_mut().zip(&each) {
                    deviation[i][c] = of[i].map_or(0.0, |of| factor * (of[c] - mean));
                }
            }
        }
        deviations
    }
}
