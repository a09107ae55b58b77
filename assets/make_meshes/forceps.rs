//! Bayonet forceps: two springy arms that meet at the end, their handles beside the line of sight.
//!
//! The origin is between the tips, +z runs to the handle; the arms are apart along x, and the handle is
//! offset towards +y.

use std::f64::consts::PI;

use crate::model::{Model, materials, painted};
use crate::sweep::{Pieces, Section, Station, along, section, swept};
use crate::vector::{Vec3, vec3};

const LENGTH_MM: f64 = 180.0;
const OFFSET_MM: f64 = 20.0;

/// Half the distance of the arms' middles where they bend into one another, and their section there.
const BEND_RADIUS_MM: f64 = 5.6;
const HANDLE: Section = section(5.0, 10.0, 1.9);
const BEND_PIECES: usize = 10;
const BEND_Z_MM: f64 = LENGTH_MM - BEND_RADIUS_MM - HANDLE.half_mm[0];

const PIECES: Pieces = Pieces { corner: 3, sides: [1, 1] };

/// An arm from its tip: z, x, y and the section.
const ARM: [(f64, f64, f64, Section); 20] = [
    (0.0, 2.6, 0.0, section(3.0, 3.0, 1.3)),
    (5.0, 2.9, 0.0, section(3.2, 3.2, 1.4)),
    (11.0, 3.3, 0.0, section(3.4, 3.4, 1.4)),
    (18.0, 3.8, 0.0, section(3.6, 3.7, 1.5)),
    (26.0, 4.4, 0.0, section(3.8, 4.0, 1.6)),
    (35.0, 5.0, 0.0, section(4.0, 4.4, 1.7)),
    (45.0, 5.7, 0.0, section(4.2, 4.8, 1.7)),
    (55.0, 6.4, 0.0, section(4.4, 5.2, 1.8)),
    (65.0, 7.1, 0.0, section(4.6, 5.6, 1.8)),
    (71.0, 7.4, 1.4, section(4.7, 5.8, 1.8)),
    (76.0, 7.7, 5.0, section(4.8, 6.2, 1.9)),
    (86.0, 8.2, 15.0, section(5.0, 7.2, 1.9)),
    (91.0, 8.5, 18.6, section(5.0, 7.8, 1.9)),
    (97.0, 8.8, OFFSET_MM, section(5.0, 8.6, 1.9)),
    (107.0, 9.2, OFFSET_MM, HANDLE),
    (118.0, 9.3, OFFSET_MM, HANDLE),
    (129.0, 9.1, OFFSET_MM, HANDLE),
    (140.0, 8.5, OFFSET_MM, HANDLE),
    (151.0, 7.5, OFFSET_MM, HANDLE),
    (162.0, 6.4, OFFSET_MM, HANDLE),
];

/// Where a hand holds it.
const GRIP_Z_MM: [f64; 2] = [107.0, 151.0];

pub fn forceps() -> Model {
    let regions = [("forceps", materials::STEEL), ("grip", materials::BRUSHED_STEEL)];
    let region = |p: Vec3| usize::from(p.z > GRIP_Z_MM[0] && p.z < GRIP_Z_MM[1]);
    Model {
        name: "forceps",
        parts: painted(&swept(&stations(), PIECES, [0.6; 2]), &regions, region),
    }
}

fn stations() -> Vec<Station> {
    let arm =
        |side: f64| ARM.iter().map(move |&(z, x, y, section)| (vec3(side * x, y, z), section));
    let bend = (0..=BEND_PIECES).map(|i| {
        let (sin, cos) = (PI * i as f64 / BEND_PIECES as f64).sin_cos();
        let (x, z) = (BEND_RADIUS_MM * cos, BEND_Z_MM + BEND_RADIUS_MM * sin);
        (vec3(x, OFFSET_MM, z), HANDLE)
    });
    let points: Vec<_> = arm(1.0).chain(bend).chain(arm(-1.0).rev()).collect();
    along(&points, Vec3::y())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::checks::assert_sound_metal;

    #[test]
    fn the_origin_is_between_the_tips() {
        let (low, high) = (vec3(-11.8, -2.8, 0.0), vec3(11.8, 25.0, LENGTH_MM));
        assert_sound_metal(&forceps(), low, high, 0.15);
        let shape = swept(&stations(), PIECES, [0.6; 2]);
        let tips = shape.points.iter().filter(|p| p.z < 4.0);
        let gap_mm = tips.map(|p| p.x.abs()).fold(f64::INFINITY, f64::min);
        assert!((0.9..1.5).contains(&gap_mm), "{gap_mm}");
    }
}
