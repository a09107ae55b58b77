//! What is not known of the room's model itself, whatever its residuals are: as fields that draws add with
//! independent normal factors.
//!
//! **Refits.** The delete-a-group jackknife (Shao & Tu, *The Jackknife and Bootstrap*, 1995, chapter 2; Kott, J.
//! Official Statistics 17, 2001): with `m_k` the model without group `k` of `K`, `Σ (m_k − m̄)² (K − 1) / K`
//! is the variance of the model. It holds what no residual shows: coefficients that the measured
//! orientations hardly determine, and the coils of a learned generator.
//!
//! **Registration.** Where the reference's frame is off, all rows are off by one rigid motion, which looks like
//! field.

use super::field::GaussianField;
use super::posterior::DrawnErrors;
use super::registration::Registration;
use crate::evaluation::Coefficient;
use crate::field_point::FieldPoint;
use nalgebra::Vector3;
use rayon::prelude::*;

impl GaussianField {
    /// How many fields [`Self::model_deviations`] has.
    pub(super) fn deviation_count(&self) -> usize {
        self.refits.len() + if self.registration.is_some() { 6 } else { 0 }
    }

    /// Fields at some poses whose sum with independent normal factors has the covariance of the model's
    /// errors; mm and rad.
    pub(super) fn model_deviations(&self, at: &[FieldPoint]) -> Vec<DrawnErrors> {
        let mut deviations = self.refit_deviations(at);
        let registration = self.registration.iter();
        let each = registration.flat_map(|of| registration_deviations(of, at, self.has_rotations));
        deviations.extend(each);
        deviations
    }

    /// One for each refit.
    fn refit_deviations(&self, at: &[FieldPoint]) -> Vec<DrawnErrors> {
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

/// The errors at some poses of one standard deviation along and about each axis.
fn registration_deviations(
    of: &Registration,
    at: &[FieldPoint],
    has_rotations: bool,
) -> [DrawnErrors; 6] {
    std::array::from_fn(|k| {
        let unit = Vector3::ith(k % 3, 1.0);
        let each = at.iter().map(|point| match k {
            0..3 => {
                let [x, y, z] = (unit * of.position_std_mm).into();
                [x, y, z, 0.0, 0.0, 0.0]
            }
            _ => {
                let turn = unit * of.angle_std_rad;
                let [x, y, z] =
                    turn.cross(&(point.position_mm.coords - Vector3::from(of.center_mm))).into();
                let [rx, ry, rz] = if has_rotations { turn.into() } else { [0.0; 3] };
                [x, y, z, rx, ry, rz]
            }
        });
        each.collect()
    })
}
