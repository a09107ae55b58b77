//! How exactly the equations can hold in double precision, and how exactly they have to.

use super::equations::{Place, Remainder};
use crate::field::DistortionModel;

/// Residual below which a position counts as found, mm, where round-off allows.
pub const POSITION_TOLERANCE_MM: f64 = 1e-9;

/// Residual below which an axis counts as found, radians, where round-off allows.
pub const AXIS_TOLERANCE_RAD: f64 = 1e-12;

/// Roundings that meet in one residual, each half an epsilon of what it rounds: some three of each
/// coordinate (the guess, its sum with the error, the difference), and four more a coefficient
/// than the order, since sums of `(n + 1)³` positive products run three deep.
const ROUNDINGS: f64 = 8.0;

/// Bounds of one reading's residual.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Tolerance {
    /// Round-off: iterating on changes nothing.
    floor_mm: f64,
    floor_rad: f64,
}

/// A model's sizes that round-off grows with.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Magnitudes {
    order: f64,
    position_mm: f64,
    rotation_rad: f64,
    /// Largest slopes by position, mm and radians a mm.
    position_slope: f64,
    rotation_slope: f64,
}

impl Magnitudes {
    pub fn of(model: &DistortionModel) -> Self {
        let largest = |range: std::ops::Range<usize>| {
            let norms = model.coefficients().iter().map(|c| norm(&c[range.clone()]));
            norms.fold(0.0, f64::max)
        };
        let (position_mm, rotation_rad) = (largest(0..3), largest(3..6));
        // Neighbouring coefficients differ by at most twice the largest, over a box's n-th part.
        let order = model.order() as f64;
        let extents = model.bounds().size_mm();
        let least = extents
            .iter()
            .copied()
            .filter(|&s| s > 0.0)
            .fold(f64::INFINITY, f64::min);
        let slope = 2.0 * order / least;
        Self {
            order,
            position_mm,
            rotation_rad,
            position_slope: slope * position_mm,
            rotation_slope: slope * rotation_rad,
        }
    }
}

fn norm(values: &[f64]) -> f64 {
    values.iter().map(|v| v * v).sum::<f64>().sqrt()
}

impl Tolerance {
    pub fn of(magnitudes: &Magnitudes, reading: &Place) -> Self {
        // A guess cannot be written down more exactly than to half an epsilon of its coordinates,
        // and the field turns that into an error as well.
        let m = magnitudes;
        let half = 0.5 * f64::EPSILON;
        let coordinates = reading.position_mm.coords.norm() + m.position_mm;
        let per_coefficient = ROUNDINGS + m.order;
        let floor_mm = half
            * (ROUNDINGS * (1.0 + m.position_slope) * coordinates
                + per_coefficient * m.position_mm);
        let floor_rad = half
            * (ROUNDINGS * (1.0 + m.rotation_slope * coordinates)
                + per_coefficient * m.rotation_rad);
        Self {
            floor_mm,
            floor_rad,
        }
    }

    /// Whether the equations hold as exactly as they can.
    pub fn is_reached(&self, remainder: &Remainder) -> bool {
        remainder.length_mm() <= self.floor_mm && remainder.angle_rad() <= self.floor_rad
    }

    /// Whether the equations hold as exactly as they have to.
    pub fn is_accepted(&self, remainder: &Remainder) -> bool {
        remainder.length_mm() <= POSITION_TOLERANCE_MM.max(self.floor_mm)
            && remainder.angle_rad() <= AXIS_TOLERANCE_RAD.max(self.floor_rad)
    }
}
