//! A self-retaining retractor: two blades on a bow with a ratchet.
//!
//! The origin is between the ends of the blades, +z runs up out of the wound; the blades are apart
//! along x, and the bow lies towards +y.

use crate::model::{Model, materials, painted};
use crate::sweep::{Pieces, Section, Station, Sweep, Towards, section, swept};
use crate::vector::{Placement, Vec3, vec3};

const BLADE: Section = section(5.0, 22.0, 2.0);
const ARM: Section = section(9.0, 9.0, 3.0);
const RATCHET: Section = section(18.0, 16.0, 3.5);

const LIP_DEG: f64 = 35.0;
const HALF_SPREAD_MM: f64 = 22.0;
const BLADE_LENGTH_MM: f64 = 34.0;
const FLARE_DEG: f64 = 22.0;
const HALF_RATCHET_MM: f64 = 15.0;
const EDGE_MM: f64 = 1.6;
const PIECES: Pieces = Pieces { corner: 3, sides: [1, 2] };

pub fn retractor() -> Model {
    let regions = [("retractor", materials::STEEL), ("ratchet", materials::BRUSHED_STEEL)];
    let region = |p: Vec3| usize::from(p.y > 60.0 && p.x.abs() < HALF_RATCHET_MM + 0.1);
    Model {
        name: "retractor",
        parts: painted(&swept(&stations(), PIECES, [EDGE_MM; 2]), &regions, region),
    }
}

/// One blade's end, its arm, the bow, and the same back.
fn stations() -> Vec<Station> {
    let (sin, cos) = LIP_DEG.to_radians().sin_cos();
    // The lip leads outwards below the wound's edge; its rounded lower edge is at z = 0.
    let lowest_mm = (BLADE.half_mm[0] - EDGE_MM) * sin + EDGE_MM * (1.0 - cos);
    let start = vec3(HALF_SPREAD_MM + 8.0, 0.0, lowest_mm);
    let start = Placement::new(start, vec3(-sin, 0.0, cos), vec3(cos, 0.0, sin));
    let arm = Sweep::new(start, BLADE)
        .forward(6.0, BLADE, 1)
        .turn(Towards::PlusX, LIP_DEG, 6.0, BLADE, 3)
        .forward(BLADE_LENGTH_MM, BLADE, 4)
        .turn(Towards::PlusY, 90.0, 4.0, ARM, 6)
        .forward(12.0, ARM, 1)
        .turn(Towards::PlusX, FLARE_DEG, 20.0, ARM, 2)
        .forward(76.0, ARM, 8)
        .turn(Towards::MinusX, FLARE_DEG + 90.0, 12.0, ARM, 7);
    let to_middle_mm = arm.clone().stations().last().map_or(0.0, |last| last.placement.origin.x);
    let step_mm = 4.0;
    arm.forward(to_middle_mm - HALF_RATCHET_MM - step_mm, ARM, 3)
        .forward(step_mm, RATCHET, 1)
        .forward(HALF_RATCHET_MM, RATCHET, 2)
        .mirrored()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::checks::assert_sound_metal;

    #[test]
    fn the_origin_is_between_the_blades() {
        let (low, high) = (vec3(-60.86, -11.0, 0.0), vec3(60.86, 138.32, 61.1));
        assert_sound_metal(&retractor(), low, high, 0.1);
    }
}
