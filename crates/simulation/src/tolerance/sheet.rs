//! What a workshop is given: where each sensor sits, and how far off it may be.

use crate::body::Coil;
use crate::coil_fit::CoilFinding;
use crate::figures::FreeRotation;
use crate::judgement::Judgement;
use crate::requirement::Check;
use crate::weak_rotation::WeakRotation;
use crate::work::Work;
use serde::Serialize;

/// A tool and its CRF as they are to be built. Lengths are in mm, angles in degrees, and everything
/// of a body is in its own frame.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ManufacturingSheet {
    /// Poses that tolerances were looked for at.
    pub poses: usize,
    /// Poses of the design's study, of which the above are a part where it is long.
    pub study_poses: usize,
    /// Poses of the design's study with a sensor outside the room's box.
    pub study_outside: usize,
    /// The requirement with every sensor where it is drawn; `None` where there is none, or no study.
    pub requirement: Option<Judgement>,
    /// Its bounds against the figures of the room's model alone, in which tolerances are found.
    pub as_drawn: Vec<Check>,
    /// Why there are no tolerances.
    pub no_tolerances: Option<String>,
    /// A rotation that a body's sensors leave free: figures and tolerances take the true one.
    pub free_axis: Option<FreeRotation>,
    /// A rotation is so weakly determined that noise decides it.
    pub poorly_determined: bool,
    /// A rotation that multiplies the errors of its sensors.
    pub barely_determined: Option<WeakRotation>,
    /// Coils that do not fit, as whoever has the bodies' meshes finds them.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub coils: Vec<CoilFinding>,
    /// The tool, and the CRF where there is one.
    pub bodies: Vec<SheetBody>,
    /// The requirement in the worst case that was found with every sensor of every body as far off
    /// as [`SheetBody::together`] allows, in position and in angle.
    pub together_worst: Vec<Check>,
    /// Studies simulated with sensors that are off.
    pub simulations: u64,
    /// What it took in all.
    pub work: Work,
}

/// Which of a design's bodies.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum BuiltBody {
    Tool,
    Crf,
}

/// One body of the sheet.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SheetBody {
    pub role: BuiltBody,
    pub name: String,
    /// `None` where the body states none: then its origin is what a tool is judged by.
    pub tip_in_body_mm: Option<[f64; 3]>,
    /// Mean of the sensors' positions.
    pub centroid_in_body_mm: Option<[f64; 3]>,
    pub sensors: Vec<SheetSensor>,
    /// Every two sensors once.
    pub pairs: Vec<SheetPair>,
    /// Holds with all sensors of all bodies off at once, in position and in angle.
    pub together: Option<Tolerances>,
}

/// One sensor of the sheet.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SheetSensor {
    pub name: String,
    /// `marker`, `5 DOF` or `6 DOF`.
    pub kind: &'static str,
    pub position_in_body_mm: [f64; 3],
    /// From the tip, or from the origin where a tool states no tip; `None` for a CRF without a tip.
    pub position_from_tip_mm: Option<[f64; 3]>,
    pub distance_from_tip_mm: Option<f64>,
    /// The sensor's own z; `None` for a marker.
    pub axis: Option<SheetAxis>,
    /// Of a 6-DOF sensor, from its own axes to the body's: w, x, y, z.
    pub rotation: Option<[f64; 4]>,
    pub coil: Option<Coil>,
    /// Holds with this sensor off alone, in one of the two at a time.
    pub alone: Option<Tolerances>,
}

/// An axis as a unit vector and as two angles.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct SheetAxis {
    pub direction: [f64; 3],
    /// From the body's z, 0 to 180.
    pub polar_deg: f64,
    /// About the body's z, from x towards y, -180 to 180; `None` of an axis along z.
    pub azimuth_deg: Option<f64>,
}

/// Two sensors by their numbers in the body.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct SheetPair {
    pub a: usize,
    pub b: usize,
    pub distance_mm: f64,
    /// Between their axes, 0 to 180; `None` where one of them has none.
    pub angle_deg: Option<f64>,
}

/// How far off sensors may be.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Tolerances {
    /// Distance in mm from where it is drawn, in any direction.
    pub position_mm: Tolerance,
    /// Turn in degrees from how it is drawn: of a 5-DOF sensor the tilt of its axis to any side, of
    /// a 6-DOF sensor a turn about any axis.
    pub angle_deg: Tolerance,
}

/// A tolerance, or why there is none.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(untagged)]
pub enum Tolerance {
    Within(Within),
    None { none: NoTolerance },
}

/// A tolerance, mm or degrees.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Within {
    /// To be stated: what was found by simulation, rounded down.
    pub value: f64,
    /// What was found by simulation.
    pub simulated: f64,
    /// What the first order finds.
    pub first_order: f64,
    /// The bound that is missed beyond `simulated`, with its figure at `value` in the direction that
    /// misses it; `None` where no bound was reached as far as was looked, which `value` is then.
    pub limited_by: Option<Check>,
    /// Of one sensor: which way it is worst, body frame; for an angle the axis of the turn.
    pub worst_direction: Option<[f64; 3]>,
}

/// Why something has no tolerance though others have.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum NoTolerance {
    /// A marker has no axis; nor has a body of markers.
    NoAxis,
    /// The requirement leaves less than can be stated.
    NothingLeft,
}

impl Tolerance {
    pub fn within(&self) -> Option<&Within> {
        match self {
            Self::Within(within) => Some(within),
            Self::None { .. } => None,
        }
    }

    /// What is stated; 0 where there is none.
    pub fn value(&self) -> f64 {
        self.within().map_or(0.0, |within| within.value)
    }
}

/// Decimals that a tolerance is stated with: a tenth above 1, a hundredth above 0.1, else a
/// thousandth.
pub fn stated_decimals(value: f64) -> usize {
    match value {
        v if v >= 1.0 => 1,
        v if v >= 0.1 => 2,
        _ => 3,
    }
}

/// Rounds a tolerance down to what is stated; 0 below a thousandth.
pub fn rounded_down(value: f64) -> f64 {
    let unit = 10.0_f64.powi(stated_decimals(value) as i32);
    let rounded = (value * unit).floor() / unit;
    // The product may round up to the next whole number.
    if rounded > value { ((value * unit).floor() - 1.0) / unit } else { rounded }
}

/// The next smaller number that can be stated.
pub fn next_below(stated: f64) -> f64 {
    let unit = 10.0_f64.powi(stated_decimals(stated) as i32);
    (((stated * unit).round() - 1.0) / unit).max(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn tolerances_are_stated_with_about_two_digits() {
        for (found, stated) in [
            (10.0, 10.0),
            (1.39, 1.3),
            (1.0, 1.0),
            (0.999, 0.99),
            (0.4273, 0.42),
            (0.0999, 0.099),
            (0.0012, 0.001),
            (0.0009, 0.0),
            (0.0, 0.0),
        ] {
            assert_eq!(rounded_down(found), stated, "{found}");
        }
        assert_eq!(next_below(1.0), 0.9);
        assert_eq!(next_below(0.42), 0.41);
        assert_eq!(next_below(0.001), 0.0);
    }

    proptest! {
        #[test]
        fn what_is_stated_is_never_more_than_what_was_found(found in 0.0..20.0_f64) {
            let stated = rounded_down(found);
            prop_assert!(stated <= found && found - stated < 0.1 * found.max(0.01) + 1e-12);
        }
    }
}
