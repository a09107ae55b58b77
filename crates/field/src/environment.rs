//! A characterised room: its distortion model, where it may be used, and where it came from.

use super::computed::PoseErrors;
use super::field_point::FieldPoint;
use super::fit::{FitMethod, Residuals};
use super::gaussian::{GaussianField, Trend};
use super::model::{DistortionModel, OutsidePolicy};
use super::samples::PoseError;
use super::validity::FitValidity;
use nalgebra::Point3;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use std::sync::Arc;
use trackwright_geometry::limits::{angle_problem, length_above_zero_problem, length_problem};
use trackwright_geometry::volume::Volume;

/// Poses that a thread evaluates at a time.
const PARTS: usize = 16;

/// A room that designs are simulated in.
#[derive(Clone, Debug, PartialEq)]
pub struct Environment {
    pub name: String,
    pub model: DistortionModel,
    /// The tracker's specified measurement volume, if that is known.
    pub volume: Option<Volume>,
    /// What the tracker's readings scatter by when nothing moves, if that is known.
    pub jitter: Option<Jitter>,
    /// `None` for an ideal room that was never measured.
    pub provenance: Option<Provenance>,
    /// Standard error and leverage of the model, if its fit kept that.
    pub fit_validity: Option<FitValidity>,
    /// The process of the field given the measurements, if the fit kept it.
    pub process: Option<Arc<GaussianField>>,
    /// Metal whose errors were computed and are part of the model, if there is any.
    pub metal: Option<ComputedMetal>,
}

/// Errors of metal that were computed from its shape and material, and how far they may be off.
#[derive(Clone, Debug, PartialEq)]
pub struct ComputedMetal {
    /// The room without the metal.
    pub bare: DistortionModel,
    /// Standard deviation of the logarithm of the size of all errors of the metal: what is not known of
    /// its material.
    pub material_std: f64,
    /// Another solution; without one the parts of all poses are off by themselves.
    pub other: Option<OtherSolution>,
    /// Standard deviation of what the solution is off by at one pose, as a part of the metal's error there.
    pub solution_std: f64,
    /// Likewise of what the evaluation is off by, mm.
    pub position_std_mm: f64,
}

/// The errors of the whole room by another solution of its metal. What it differs by, so many times, is one standard
/// deviation of what the first one is off by, at all poses alike.
#[derive(Clone, Debug)]
pub struct OtherSolution {
    pub errors: Arc<dyn PoseErrors>,
    pub times: f64,
}

impl PartialEq for OtherSolution {
    /// What is computed is the same where it is the same computation.
    fn eq(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.errors, &other.errors) && self.times == other.times
    }
}

impl ComputedMetal {
    /// What another solution changes of the errors of the whole room at some poses; nothing where it has no reading.
    pub fn solution_errors(&self, wholes: &[PoseError], at: &[FieldPoint]) -> Vec<PoseError> {
        let mut found = vec![PoseError::of_values([0.0; 6]); wholes.len()];
        let Some(other) = &self.other else { return found };
        let bounds = self.bare.bounds();
        let positions: Vec<_> = at.iter().map(|at| bounds.clamp(&at.position_mm)).collect();
        let axes: Vec<_> = at.iter().map(|at| at.axis).collect();
        let mut read = vec![None; wholes.len()];
        // Near metal a reading takes up to a tenth of a millisecond.
        let parts = positions.par_chunks(PARTS).zip(axes.par_chunks(PARTS));
        parts.zip(read.par_chunks_mut(PARTS)).for_each(|((positions, axes), read)| {
            other.errors.axis_errors(positions, axes, read);
        });
        for ((found, whole), read) in found.iter_mut().zip(wholes).zip(read) {
            let Some(read) = read.map(PoseError::of_values) else { continue };
            *found = PoseError {
                position_mm: (read.position_mm - whole.position_mm) * other.times,
                rotation_rad: (read.rotation_rad - whole.rotation_rad) * other.times,
            };
        }
        found
    }

    /// The metal's part of an error of the whole room.
    pub fn part(&self, whole: &PoseError, at: &FieldPoint) -> PoseError {
        let bare = self.bare.evaluate(&at.position_mm, &at.axis, OutsidePolicy::Clamp).error;
        PoseError {
            position_mm: whole.position_mm - bare.position_mm,
            rotation_rad: whole.rotation_rad - bare.rotation_rad,
        }
    }
}

/// Standard deviations of a still sensor's readings: position per axis, orientation per component
/// of the rotation vector.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Jitter {
    pub position_mm: f64,
    pub angle_rad: f64,
    /// How they grow away from the generator; the same everywhere where absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub growth: Option<JitterGrowth>,
}

/// Growth of the jitter with the distance `r` from the generator, the tracker frame's origin:
/// `sigma(r) = sigma · sqrt(1 + (r / r0)^(2 p))`, a floor and a part that grows, independent of
/// each other.
///
/// A dipole's field falls with `r³` while the noise of coil and amplifier stays, so that angles
/// scatter with `r³` and positions, angles times the distance, with `r⁴` (Raab et al., IEEE
/// Trans. Aerospace and Electronic Systems 15(5), 1979; Nixon et al., Presence 7(2), 1998).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct JitterGrowth {
    /// `r0`: where the part that grows is as large as the floor.
    pub distance_mm: f64,
    #[serde(default = "dipole_position_exponent")]
    pub position_exponent: f64,
    #[serde(default = "dipole_angle_exponent")]
    pub angle_exponent: f64,
}

fn dipole_position_exponent() -> f64 {
    JitterGrowth::DIPOLE_POSITION_EXPONENT
}

fn dipole_angle_exponent() -> f64 {
    JitterGrowth::DIPOLE_ANGLE_EXPONENT
}

impl JitterGrowth {
    pub const DIPOLE_POSITION_EXPONENT: f64 = 4.0;
    pub const DIPOLE_ANGLE_EXPONENT: f64 = 3.0;

    /// A dipole's growth beyond a distance.
    pub fn dipole(distance_mm: f64) -> Self {
        Self {
            distance_mm,
            position_exponent: Self::DIPOLE_POSITION_EXPONENT,
            angle_exponent: Self::DIPOLE_ANGLE_EXPONENT,
        }
    }
}

/// The jitter at one place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LocalJitter {
    /// Standard deviation per axis.
    pub position_mm: f64,
    /// Standard deviation per component of the rotation vector.
    pub angle_rad: f64,
}

impl Jitter {
    /// The same everywhere.
    pub fn uniform(position_mm: f64, angle_rad: f64) -> Self {
        Self { position_mm, angle_rad, growth: None }
    }

    /// The same everywhere, or with a dipole's growth beyond a distance.
    pub fn stated(position_mm: f64, angle_rad: f64, growth_mm: Option<f64>) -> Self {
        Self {
            growth: growth_mm.map(JitterGrowth::dipole),
            ..Self::uniform(position_mm, angle_rad)
        }
    }

    /// The jitter of a sensor at a position in the tracker frame.
    pub fn at(&self, position_in_tracker: &Point3<f64>) -> LocalJitter {
        let factor = |exponent: f64| match &self.growth {
            None => 1.0,
            Some(growth) => {
                let ratio = position_in_tracker.coords.norm() / growth.distance_mm;
                1.0_f64.hypot(ratio.powf(exponent))
            }
        };
        let exponents = self.growth.map_or((0.0, 0.0), |g| (g.position_exponent, g.angle_exponent));
        LocalJitter {
            position_mm: self.position_mm * factor(exponents.0),
            angle_rad: self.angle_rad * factor(exponents.1),
        }
    }

    /// `sigma_pos / sigma_ori` in mm, the best weight of an axis against a position;
    /// `None` where one of them is zero. It is the ratio of the stated values, before they grow:
    /// one number for the whole room, so that a body keeps its weight while it moves.
    pub fn orientation_weight_mm(&self) -> Option<f64> {
        (self.position_mm > 0.0 && self.angle_rad > 0.0)
            .then(|| self.position_mm / self.angle_rad)
            .filter(|weight_mm| weight_mm.is_finite())
    }

    /// The first value that cannot be: its name, what it is, and what was expected.
    pub fn problem(&self) -> Option<(&'static str, f64, &'static str)> {
        let named = |name, value: f64, problem: Option<&'static str>| {
            problem.map(|expected| (name, value, expected))
        };
        let growth = self.growth.as_ref();
        let (position_mm, angle_rad) = (self.position_mm, self.angle_rad);
        named("jitter.position_mm", position_mm, length_problem(position_mm))
            .or_else(|| {
                let problem = angle_problem(angle_rad.to_degrees());
                named("jitter.angle_rad", angle_rad, problem)
            })
            .or_else(|| {
                let distance_mm = growth?.distance_mm;
                let problem = length_above_zero_problem(distance_mm);
                named("jitter.growth.distance_mm", distance_mm, problem)
            })
            .or_else(|| {
                let exponents = [
                    ("jitter.growth.position_exponent", growth?.position_exponent),
                    ("jitter.growth.angle_exponent", growth?.angle_exponent),
                ];
                exponents
                    .into_iter()
                    .find(|(_, value)| !(0.0..=MAX_GROWTH_EXPONENT).contains(value))
                    .map(|(name, value)| (name, value, "0 to 8"))
            })
    }
}

/// Where a model came from and how well it fits.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
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
#[serde(deny_unknown_fields)]
pub struct HoldoutProvenance {
    pub data: String,
    pub samples: usize,
    pub before: Residuals,
    pub after: Residuals,
}

/// Orientation weight where neither design nor environment states one, in millimetres (the
/// paper's).
pub const DEFAULT_ORIENTATION_WEIGHT_MM: f64 = 100.0;

/// Twice the steepest law that physics gives, a dipole's `r⁴`.
const MAX_GROWTH_EXPONENT: f64 = 8.0;

/// The weight of an axis against a position in frame fitting, and who decided it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OrientationWeight {
    pub value_mm: f64,
    pub source: OrientationWeightSource,
}

/// Who decided the weight of an axis, the first of these that can.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum OrientationWeightSource {
    /// The design states it.
    Design,
    /// `sigma_pos / sigma_ori` of the environment's jitter.
    Jitter,
    /// The paper's.
    Default,
}

impl OrientationWeightSource {
    /// For a person.
    pub fn label(self) -> &'static str {
        match self {
            Self::Design => "design",
            Self::Jitter => "derived from jitter",
            Self::Default => "default",
        }
    }
}

impl Environment {
    /// A room of which nothing but the model of its field is known.
    pub fn of_model(name: impl Into<String>, model: DistortionModel) -> Self {
        Self {
            name: name.into(),
            model,
            volume: None,
            jitter: None,
            provenance: None,
            fit_validity: None,
            process: None,
            metal: None,
        }
    }

    /// Whether the room states how far its field may be off.
    pub fn states_uncertainty(&self) -> bool {
        self.process.is_some() || self.metal.is_some()
    }

    /// Whether the room states its field at a sensor that is, or is not, outside the model's box and
    /// outside the tracker's measurement volume. Out of the volume no tracker measures. Outside the box
    /// a polynomial has no meaning; a process that is the whole field is as uncertain there as if nothing
    /// had been measured, as long as the volume is known.
    pub fn states_field(&self, is_outside: bool, is_out_of_volume: bool) -> bool {
        let is_whole = |process: &Arc<GaussianField>| process.trend == Trend::None;
        let is_wide = self.volume.is_some() && self.process.as_ref().is_some_and(is_whole);
        !is_out_of_volume && (!is_outside || is_wide)
    }

    /// The same of a sensor at a position.
    pub fn states_field_at(&self, position_in_tracker: &Point3<f64>) -> bool {
        let is_in_volume = |volume: &Volume| volume.contains(position_in_tracker);
        let is_outside = !self.model.bounds().contains(position_in_tracker);
        self.states_field(is_outside, !self.volume.as_ref().is_none_or(is_in_volume))
    }

    /// The weight of an axis against a position where the design states none: `sigma_pos /
    /// sigma_ori` where the jitter is known, else the paper's 100 mm.
    pub fn orientation_weight_mm(&self) -> f64 {
        self.orientation_weight(None).value_mm
    }

    /// The weight that a design is simulated with, and where it comes from.
    pub fn orientation_weight(&self, design_mm: Option<f64>) -> OrientationWeight {
        use OrientationWeightSource as Source;
        let derived_mm = self.jitter.and_then(|j| j.orientation_weight_mm());
        let (value_mm, source) = match (design_mm, derived_mm) {
            (Some(value_mm), _) => (value_mm, Source::Design),
            (None, Some(value_mm)) => (value_mm, Source::Jitter),
            (None, None) => (DEFAULT_ORIENTATION_WEIGHT_MM, Source::Default),
        };
        OrientationWeight { value_mm, source }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn jitter_is_a_floor_and_then_a_power_law() {
        let jitter =
            Jitter { growth: Some(JitterGrowth::dipole(200.0)), ..Jitter::uniform(0.1, 0.002) };
        let at = |r: f64| jitter.at(&Point3::new(0.0, 0.6 * r, -0.8 * r));
        assert_eq!(at(0.0).position_mm, 0.1);
        assert!((at(200.0).position_mm - 0.1 * 2.0_f64.sqrt()).abs() < 1e-15);
        // The floor's share is half of (1 / 10)^(2 p).
        let (near, far) = (at(2_000.0), at(4_000.0));
        assert!((far.position_mm / near.position_mm - 16.0).abs() < 16.0 * 1e-8);
        assert!((far.angle_rad / near.angle_rad - 8.0).abs() < 8.0 * 1e-6);
    }

    #[test]
    fn weight_is_of_design_then_jitter_then_paper() {
        let bounds = trackwright_geometry::volume::Volume::AuroraCube.bounds();
        let model = DistortionModel::zero(bounds, crate::samples::MapKind::Distortion);
        let mut room = Environment::of_model("", model);
        let weight = |room: &Environment, design| {
            let weight = room.orientation_weight(design);
            (weight.value_mm, weight.source)
        };
        assert_eq!(weight(&room, None), (100.0, OrientationWeightSource::Default));
        room.jitter = Some(Jitter::uniform(0.5, 0.3_f64.to_radians()));
        let (derived_mm, source) = weight(&room, None);
        assert!((derived_mm - 95.493).abs() < 1e-3, "{derived_mm}");
        assert_eq!(source, OrientationWeightSource::Jitter);
        assert_eq!(weight(&room, Some(30.0)), (30.0, OrientationWeightSource::Design));
        // Without a scatter of the angles there is no ratio.
        room.jitter = Some(Jitter::uniform(0.5, 0.0));
        assert_eq!(weight(&room, None), (100.0, OrientationWeightSource::Default));
    }
}
