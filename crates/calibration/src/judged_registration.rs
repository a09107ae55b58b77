//! A registration of points in two frames, judged: who contradicts the others, and how far off other
//! points are to be expected.

use super::fiducial_outliers::{OutlyingPoint, register_without_outliers};
use super::registration::{Registration, RegistrationError, register};
use super::registration_error::{PointSpread, fle_rms_mm};
use nalgebra::Point3;
use trackwright_geometry::pose::pose_to_array;
use trackwright_result::{Note, Remedy, Section, Table, count, data, deg, mm, vector};

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
    fn suspicions(&self) -> impl Iterator<Item = Note> {
        self.suspected.iter().map(|point| {
            let text = format!(
                "point {} is {:.2} mm off where the others, without it, leave {:.2} mm RMS: is it an outlier?",
                point.index + 1,
                point.off_mm,
                self.fre_without_suspected_mm
            );
            let remedy = Remedy::new("leave_out_outliers", "{} registers without it");
            Note::warning(text).lifted_by(remedy)
        })
    }

    /// All that is known of it.
    pub fn section(&self) -> Section {
        let pose = pose_to_array(&self.registration.target_from_source);
        let [x, y, z, quaternion @ ..] = pose;
        let is_left_out = |index: usize| self.left_out.iter().any(|point| point.index == index);
        let kept = (0..self.residuals_mm.len()).filter(|&k| !is_left_out(k));
        let worst_mm = kept.map(|k| self.residuals_mm[k]).fold(0.0, f64::max);
        let used = self.residuals_mm.len() - self.left_out.len();
        let of_all = if self.left_out.is_empty() { "" } else { "with all points" };
        let left_out = Table::of("left_out", &self.left_out)
            .number("point", "left out: point", 0, |point| point.index + 1)
            .number("off_mm", "off, mm", 3, |point| point.off_mm)
            .number("chance", "chance", 4, |point| point.chance)
            .done();
        Section::of([
            count("points", "points", used),
            vector::<3>("", "shift to the target frame", [x, y, z], 3, "mm"),
            vector::<4>("", "rotation, scalar first", quaternion, 6, ""),
            data("target_from_source", pose),
            mm("fre_rms_mm", "left at the points, RMS (FRE)", self.registration.fre_rms_mm),
            mm("max_mm", "largest", worst_mm).part(),
            mm("fre_of_all_rms_mm", of_all, self.fre_of_all_mm).part(),
            data("residuals_mm", &self.residuals_mm),
            mm("fle_rms_mm", "localisation of a point, RMS (FLE)", self.fle_mm),
            mm("off_line_mm", "points from one line, RMS", self.spread.off_line_mm()),
            deg(
                "turn_std_error_deg",
                "standard error of the rotation about it",
                self.spread.turn_std_error_rad(self.fle_mm),
            ),
        ])
        .with(left_out)
        .noting(self.suspicions())
    }
}
