//! How exactly the equations can hold in double precision, and how exactly they have to.

use super::equations::Place;
use super::regions::Regions;
use crate::DistortionModel;

/// Residual below which a position counts as found, mm, where round-off allows.
pub const POSITION_TOLERANCE_MM: f64 = 1e-9;

/// Residual below which an axis counts as found, radians, where round-off allows.
pub const AXIS_TOLERANCE_RAD: f64 = 1e-12;

/// How much further than the tolerances the search goes where it can: an answer is off by its
/// residual times what the inverse magnifies.
const FURTHER: f64 = 1e-2;

/// Roundings of a coordinate that meet in one residual, each half an epsilon of it: the guess, its
/// sum with the error, the difference from the reading, and on the way to the unit cube a
/// difference and a quotient, with room for the norm of three.
const ROUNDINGS: f64 = 8.0;

/// Bounds of one reading's residual.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Tolerance {
    reached_mm: f64,
    reached_rad: f64,
    accepted_mm: f64,
    accepted_rad: f64,
}

impl Tolerance {
    pub fn of(model: &DistortionModel, regions: &Regions, reading: &Place) -> Self {
        let half = 0.5 * f64::EPSILON;
        let errors = &regions.errors;
        let error_mm = errors.least_mm.abs().sup(&errors.largest_mm.abs()).norm();
        let slopes = &regions.everywhere;
        // A guess cannot be written down more exactly than to half an epsilon of its coordinates,
        // and the field turns that into an error as well.
        let coordinates = ROUNDINGS * (reading.position_mm.coords.norm() + error_mm);
        // Sums over i, j, k are sums of n + 1 products three deep, the bases take n steps each.
        let per_value = ROUNDINGS + 6.0 * model.order() as f64;
        let floor_mm = half * ((1.0 + slopes.pp) * coordinates + per_value * error_mm);
        let floor_rad =
            half * (ROUNDINGS + slopes.np * coordinates + per_value * errors.largest_rad);
        Self {
            reached_mm: floor_mm.max(FURTHER * POSITION_TOLERANCE_MM),
            reached_rad: floor_rad.max(FURTHER * AXIS_TOLERANCE_RAD),
            accepted_mm: floor_mm.max(POSITION_TOLERANCE_MM),
            accepted_rad: floor_rad.max(AXIS_TOLERANCE_RAD),
        }
    }

    /// Whether going on is not worth it.
    pub fn is_reached(&self, residual_mm: f64, residual_rad: f64) -> bool {
        residual_mm <= self.reached_mm && residual_rad <= self.reached_rad
    }

    /// The same for squares.
    #[inline]
    pub fn is_reached_squared(&self, residual_mm2: f64, residual_rad2: f64) -> bool {
        residual_mm2 <= self.reached_mm * self.reached_mm
            && residual_rad2 <= self.reached_rad * self.reached_rad
    }

    /// Whether the equations hold as exactly as they have to.
    pub fn is_accepted(&self, residual_mm: f64, residual_rad: f64) -> bool {
        residual_mm <= self.accepted_mm && residual_rad <= self.accepted_rad
    }
}
