//! What sensors look like: a coil with one axis (5-DOF) or a triad (6-DOF), a ball for a marker, and
//! slanted discs through what is outside. Sizes are true within bounds on the screen.

use nalgebra::{Point3, Vector3};
use trackwright_geometry::solid::Solid;
use trackwright_simulation::body::{Coil, Sensor};

/// The coil that is drawn where a body file states none: a common 5-DOF sensor.
const USUAL_COIL: Coil = Coil { diameter_mm: 0.8, length_mm: 9.0 };

/// Diameter of the ball that a marker is drawn as: the common passive sphere.
const MARKER_MM: f64 = 11.5;
const MARKER_PX: [f64; 2] = [12.0, 80.0];

/// On the screen a coil is at least this wide and long, and at most this.
const COIL_WIDTH_PX: [f64; 2] = [8.0, 60.0];
const COIL_LENGTH_PX: [f64; 2] = [20.0, 220.0];

/// How long axes are, in coil lengths and on the screen.
const AXIS_TO_COIL: f64 = 1.25;
const AXIS_LENGTH_PX: [f64; 2] = [30.0, 260.0];

/// Widths and lengths in axis lengths.
pub const AXIS_WIDTH: f64 = 0.085;
pub const AXIS_HEAD_WIDTH: f64 = 0.26;
pub const AXIS_HEAD_LENGTH: f64 = 0.30;

/// Hatching of a coil that is outside: slanted discs through it, in coil lengths and widths; where
/// their middles are, how large they are across and along, and how they are turned about x.
pub const HATCH_AT: [f64; 3] = [-0.3, 0.0, 0.3];
pub const HATCH_SCALE: [f64; 3] = [1.35, 1.35, 0.11];
pub const HATCH_SLANT_RAD: f64 = 0.2;

/// A true length and how small and large it may get on the screen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SizeBounds {
    pub true_mm: f64,
    pub least_px: f64,
    pub most_px: f64,
    /// Added on the screen, whatever the size: the width of an outline.
    pub extra_px: f64,
}

impl SizeBounds {
    /// The length to draw, in millimetres.
    pub fn mm(&self, mm_per_px: f64) -> f64 {
        let (least, most) = (self.least_px * mm_per_px, self.most_px * mm_per_px);
        self.true_mm.max(least).min(most.max(self.true_mm)) + self.extra_px * mm_per_px
    }

    fn of(true_mm: f64, [least_px, most_px]: [f64; 2]) -> Self {
        Self { true_mm, least_px, most_px, extra_px: 0.0 }
    }
}

/// What a sensor is drawn as.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SensorLook {
    pub degrees_of_freedom: u8,
    pub coil: Coil,
}

impl SensorLook {
    /// The look of a sensor: its own coil, or the usual one.
    pub fn of(sensor: &Sensor) -> Self {
        Self {
            degrees_of_freedom: sensor.orientation.degrees_of_freedom(),
            coil: sensor.coil.unwrap_or(USUAL_COIL),
        }
    }

    /// Whether the sensor has a position alone, and is drawn as a ball.
    pub fn is_marker(&self) -> bool {
        self.degrees_of_freedom == 3
    }

    /// How wide and how long: the coil, or a marker's ball.
    pub fn drawn_size(&self) -> (SizeBounds, SizeBounds) {
        if self.is_marker() {
            let size = SizeBounds::of(MARKER_MM, MARKER_PX);
            return (size, size);
        }
        (
            SizeBounds::of(self.coil.diameter_mm, COIL_WIDTH_PX),
            SizeBounds::of(self.coil.length_mm, COIL_LENGTH_PX),
        )
    }

    /// How long its axes are.
    pub fn axis_size(&self) -> SizeBounds {
        SizeBounds::of(self.coil.length_mm * AXIS_TO_COIL, AXIS_LENGTH_PX)
    }
}

/// A sensor's axis, one long, from the origin along z.
pub fn axis_solid() -> Solid {
    let rod_length = 1.0 - AXIS_HEAD_LENGTH;
    let mut axis = Solid::default();
    let parts = [
        (Solid::cylinder(), AXIS_WIDTH, rod_length, rod_length / 2.0),
        (Solid::cone(), AXIS_HEAD_WIDTH, AXIS_HEAD_LENGTH, rod_length),
    ];
    for (solid, across, along, from) in parts {
        let scale = Vector3::new(across, across, along);
        axis.push(
            &solid,
            |p| Point3::from(p.coords.component_mul(&scale) + Vector3::z() * from),
            |n| n.component_div(&scale).normalize(),
        );
    }
    axis
}

/// The discs that mark a sensor which is outside, about a coil of unit size.
pub fn hatch_solid() -> Solid {
    let mut hatch = Solid::default();
    let (scale, disc) = (Vector3::from(HATCH_SCALE), Solid::cylinder());
    let turn = nalgebra::UnitQuaternion::from_axis_angle(&Vector3::x_axis(), HATCH_SLANT_RAD);
    for at in HATCH_AT {
        hatch.push(
            &disc,
            |p| Point3::from(turn * p.coords.component_mul(&scale) + Vector3::z() * at),
            |n| turn * n.component_div(&scale).normalize(),
        );
    }
    hatch
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn small_coils_are_drawn_larger() {
        let coil = SizeBounds::of(0.8, [8.0, 40.0]);
        assert_eq!(coil.mm(0.5), 4.0);
        assert_eq!(coil.mm(0.05), 0.8);
        // Nearer than true size it never shrinks.
        assert_eq!(coil.mm(0.001), 0.8);
        let outline = SizeBounds { extra_px: 4.0, ..coil };
        assert_eq!(outline.mm(0.5), 6.0);
    }
}
