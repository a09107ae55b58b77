//! A registration of points in two frames, judged: who contradicts the others, and how far off other
//! points are to be expected.

use super::fiducial_outliers::{OutlyingPoint, register_without_outliers};
use super::registration::{Registration, RegistrationError, register};
use super::registration_error::{PointSpread, fle_rms_mm};
use nalgebra::Point3;

/// Above this a registration determines a turn so poorly that it is refused by default: a
/// target 50 mm away is off by 9 mm.
pub const MAX_TURN_ERROR_DEG: f64 = 10.0;

/// A registration, and what it predicts of other points.
#[derive(Clone, Debug)]
pub struct JudgedRegistration {
    pub registration: Registration,
    /// FRE with the points that were left out.
    pub fre_of_all_mm: f64,
    pub left_out: Vec<OutlyingPoint>,
    /// Points that the others contradict and that were not left out.
    pub suspected: Vec<OutlyingPoint>,
    /// FRE without those.
    pub fre_without_suspected_mm: f64,
    /// Of all points, those left out too.
    pub residuals_mm: Vec<f64>,
    /// Of the points that were used, in the source frame.
    pub spread: PointSpread,
    /// How well a point was localised, RMS.
    pub fle_mm: f64,
}

/// Points that determine the turn about the line that they are near too poorly.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error(
    "the points are {off_line_mm:.2} mm RMS from one line and were localised to {fle_mm:.2} mm, so that the rotation \
     about it is known to {turn_error_deg:.1}° only, expected {max_deg:.1}° at most; take points farther apart"
)]
pub struct LooseTurn {
    pub off_line_mm: f64,
    pub fle_mm: f64,
    pub turn_error_deg: f64,
    pub max_deg: f64,
}

impl JudgedRegistration {
    /// Registers points, those that the others contradict left out on request; `fle_mm` is estimated
    /// from what the registration leaves where it is not known.
    ///
    /// # Errors
    /// See [`RegistrationError`].
    pub fn of(
        source: &[Point3<f64>],
        target: &[Point3<f64>],
        leave_out_outliers: bool,
        fle_mm: Option<f64>,
    ) -> Result<Self, RegistrationError> {
        let all = register(source, target)?;
        let (cleaned, outlying) = register_without_outliers(source, target)?;
        let (registration, left_out, suspected) = match leave_out_outliers {
            true => (cleaned, outlying, Vec::new()),
            false => (all, Vec::new(), outlying),
        };
        let is_used = |index: usize| left_out.iter().all(|point| point.index != index);
        let used: Vec<Point3<f64>> =
            (0..source.len()).filter(|&k| is_used(k)).map(|k| source[k]).collect();
        let fle_mm = fle_mm.unwrap_or_else(|| fle_rms_mm(registration.fre_rms_mm, used.len()));
        Ok(Self {
            residuals_mm: source
                .iter()
                .zip(target)
                .map(|(s, t)| (registration.target_from_source * s - t).norm())
                .collect(),
            fre_of_all_mm: all.fre_rms_mm,
            fre_without_suspected_mm: cleaned.fre_rms_mm,
            registration,
            left_out,
            suspected,
            spread: PointSpread::of(&used),
            fle_mm,
        })
    }

    /// Standard error of the turn that is known least.
    pub fn turn_error_deg(&self) -> f64 {
        self.spread.turn_std_error_rad(self.fle_mm).to_degrees()
    }

    /// # Errors
    /// A turn that is known worse than that.
    pub fn check_turn(&self, max_deg: f64) -> Result<(), LooseTurn> {
        let turn_error_deg = self.turn_error_deg();
        // An error that is not a number is not within the bound either.
        match turn_error_deg <= max_deg {
            true => Ok(()),
            false => Err(LooseTurn {
                off_line_mm: self.spread.off_line_mm(),
                fle_mm: self.fle_mm,
                turn_error_deg,
                max_deg,
            }),
        }
    }

    /// A sentence for each point that the others contradict.
    pub fn suspicions(&self) -> impl Iterator<Item = String> {
        self.suspected.iter().map(|point| {
            format!(
                "point {} is {:.2} mm off where the others, without it, leave {:.2} mm RMS: is it an outlier?",
                point.index + 1,
                point.off_mm,
                self.fre_without_suspected_mm
            )
        })
    }
}
