//! A surgical mallet: a round head across a handle, as one closed surface.
//!
//! The origin is in the middle of the head's side that is away from the handle, +z runs to the handle's
//! end; the two faces that strike look along x.

use crate::model::{Model, materials, painted};
use crate::sweep::{Pieces, Section, Station, section, swept};
use crate::vector::{Placement, Vec3, vec3};

const LENGTH_MM: f64 = 200.0;
const HEAD_RADIUS_MM: f64 = 15.0;
const HEAD_LENGTH_MM: f64 = 62.0;
/// Around the head from its underside; the last is where the handle begins.
const HEAD_ANGLES_DEG: [f64; 11] =
    [20.0, 35.0, 50.0, 65.0, 80.0, 95.0, 110.0, 125.0, 138.0, 148.0, 155.0];

/// The handle from the head: z and the section.
const HANDLE: [(f64, Section); 12] = [
    (28.0, section(12.0, 12.0, 5.0)),
    (31.0, section(11.0, 11.0, 4.8)),
    (55.0, section(10.0, 10.0, 4.4)),
    (85.0, section(10.0, 10.0, 4.4)),
    (92.0, section(11.0, 11.0, 4.6)),
    (96.0, section(14.0, 15.0, 5.6)),
    (100.0, section(16.0, 18.0, 6.2)),
    (120.0, section(17.0, 20.0, 6.6)),
    (150.0, section(15.0, 18.0, 6.2)),
    (180.0, section(17.0, 20.0, 6.6)),
    (192.0, section(18.0, 21.0, 6.8)),
    (LENGTH_MM, section(17.0, 20.0, 6.6)),
];
const PIECES: Pieces = Pieces { corner: 3, sides: [4, 2] };
const GRIP_START_Z_MM: f64 = 96.0;

pub fn mallet() -> Model {
    let regions = [("mallet", materials::STEEL), ("grip", materials::BRUSHED_STEEL)];
    let region = |p: Vec3| usize::from(p.z > GRIP_START_Z_MM);
    Model {
        name: "mallet",
        parts: painted(&swept(&stations(), PIECES, [0.3, 2.5]), &regions, region),
    }
}

fn stations() -> Vec<Station> {
    let at = |z_mm: f64, section: Section| Station {
        placement: Placement::new(vec3(0.0, 0.0, z_mm), Vec3::z(), Vec3::x()),
        section,
    };
    let lowest_mm = HEAD_RADIUS_MM * HEAD_ANGLES_DEG[0].to_radians().cos();
    let head = HEAD_ANGLES_DEG.iter().map(|degrees| {
        let (sin, cos) = degrees.to_radians().sin_cos();
        let chord_mm = 2.0 * HEAD_RADIUS_MM * sin;
        at(lowest_mm - HEAD_RADIUS_MM * cos, section(HEAD_LENGTH_MM, chord_mm, 0.25 * chord_mm))
    });
    head.chain(HANDLE.iter().map(|&(z_mm, section)| at(z_mm, section))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::checks::assert_sound_metal;

    #[test]
    fn the_origin_is_below_the_head() {
        let half_mm = HEAD_LENGTH_MM / 2.0;
        let (low, high) = (vec3(-half_mm, -15.0, 0.0), vec3(half_mm, 15.0, LENGTH_MM));
        assert_sound_metal(&mallet(), low, high, 0.1);
    }
}
