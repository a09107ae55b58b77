//! Model validity at poses of a sensor: the error of a reading, and what the fit depends on there.

use super::fit_validity::{FitValidity, FitValidityAt};
use crate::environment::Environment;
use crate::evaluation::OutsidePolicy;
use crate::field_point::FieldPoint;
use crate::gaussian::{GaussianError, GaussianField, Readings};
use crate::samples::PoseError;
use nalgebra::Point3;
use rayon::prelude::*;

/// How many times the RMS of measurements left out the error of a supported reading may be, where no leverage
/// states it. Chosen, not tuned: the model is then half as good as it is among its measurements.
const MOST_ERROR: f64 = 2.0;

/// The error of a reading at one pose, and what the fit depends on there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Validity {
    /// RMS distance of the tracker's reading from the model's, mm; misfit included where
    /// the room keeps its measurements, else the standard error of the fit.
    pub position_error_mm: f64,
    /// Likewise of the orientation, rad; `None` where orientations were not measured.
    pub angle_error_rad: Option<f64>,
    /// 95 % of readings are within so much of the model's, mm and rad; `None` where the room
    /// does not keep its measurements.
    pub position_95_mm: Option<f64>,
    pub angle_95_rad: Option<f64>,
    /// Whether the measurements determine the field there: in the model's box, and by the fit's leverage; of
    /// models that are no polynomials where the error is at most twice the RMS that is left of
    /// measurements left out.
    pub is_supported: bool,
    /// To the nearest measurement; of polynomials as in [`FitValidityAt::distance_mm`].
    pub distance_mm: f64,
    /// Standard error and leverage of the fit at the pose; `None` for models that are no polynomials, and where the fit
    /// kept nothing.
    pub fit: Option<FitValidityAt>,
}

impl Environment {
    /// Whether [`Environment::validity`] returns anything.
    pub fn has_validity(&self) -> bool {
        self.process.is_some() || self.fit_validity.is_some()
    }

    /// Model validity at each point; `None` where the room keeps neither its
    /// measurements nor the standard error of its fit.
    ///
    /// # Errors
    /// Measurements from which no process can be factored.
    pub fn validity(
        &self,
        points: &[FieldPoint],
        outside: OutsidePolicy,
    ) -> Result<Option<Vec<Validity>>, GaussianError> {
        let fit_validity = self.fit_validity.as_ref();
        let fit_at = |validity: &FitValidity, point: &FieldPoint| {
            validity.at(&point.position_mm, &point.axis, outside)
        };
        let Some(process) = &self.process else {
            let of_fit = fit_validity.map(|validity| {
                let each = points.par_iter().map(|point| {
                    let at = fit_at(validity, point);
                    Validity {
                        position_error_mm: at.position_std_error_mm,
                        angle_error_rad: at.angle_std_error_rad,
                        position_95_mm: None,
                        angle_95_rad: None,
                        is_supported: at.is_valid,
                        distance_mm: at.distance_mm,
                        fit: Some(at),
                    }
                });
                each.collect()
            });
            return Ok(of_fit);
        };
        let errors =
            Readings::new(process).errors(points, &self.measured_errors(points, outside))?;
        let each = points.par_iter().zip(errors).map(|(point, error)| {
            let fit = fit_validity.map(|validity| fit_at(validity, point));
            let share = error_share(error.position_mm.rms, process);
            let is_determined = share <= 1.0 && self.model.bounds().contains(&point.position_mm);
            Validity {
                position_error_mm: error.position_mm.rms,
                angle_error_rad: error.angle_rad.map(|angle| angle.rms),
                position_95_mm: Some(error.position_mm.within_95),
                angle_95_rad: error.angle_rad.map(|angle| angle.within_95),
                is_supported: fit.map_or(is_determined, |fit| fit.is_valid),
                distance_mm: fit
                    .map_or_else(|| nearest_mm(process, &point.position_mm), |fit| fit.distance_mm),
                fit,
            }
        });
        Ok(Some(each.collect()))
    }

    /// What the room's model gives at points as the room was measured: what is not known of added metal is
    /// not in its process.
    pub(super) fn measured_errors(
        &self,
        points: &[FieldPoint],
        outside: OutsidePolicy,
    ) -> Vec<PoseError> {
        let measured = self.metal.as_ref().map_or(&self.model, |metal| &metal.bare);
        points.par_iter().map(|point| measured.evaluate_point(point, outside).error).collect()
    }
}

/// RMS error of a reading against the greatest at which it counts as supported.
pub(super) fn error_share(position_rms_mm: f64, process: &GaussianField) -> f64 {
    // Of measurements that leave nothing a share of zero is zero.
    position_rms_mm / (MOST_ERROR * process.left_out_rms_mm).max(f64::MIN_POSITIVE)
}

/// Distance to the nearest measurement; infinite without any.
pub(super) fn nearest_mm(process: &GaussianField, position_mm: &Point3<f64>) -> f64 {
    let squares =
        process.rows.iter().map(|row| (row.point.position_mm - position_mm).norm_squared());
    squares.fold(f64::INFINITY, f64::min).sqrt()
}
