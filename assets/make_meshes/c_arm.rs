//! The C of a mobile X-ray apparatus with its detector and its tube, as one closed surface.
//!
//! The origin is the isocentre. The C lies in the x-z plane and opens towards -x; the beam runs along
//! -z, from the tube at +z to the detector, and +y runs along the patient to the head.

use crate::model::{Material, Model, materials, painted};
use crate::sweep::{Pieces, Section, Station, Sweep, Towards, section, swept};
use crate::vector::{Placement, Vec3, vec3};

const INNER_RADIUS_MM: f64 = 700.0;
/// The section of the C: thickness along its radius, width along y.
const ARM: Section = section(60.0, 120.0, 14.0);
/// Where the C is held: as wide as it, thicker outwards.
const HOLDER: Section = section(150.0, 150.0, 20.0);
const HALF_HOLDER_DEG: f64 = 12.0;
/// From the C's section to the holder's.
const SHOULDER_DEG: f64 = 3.0;

/// How far from the beam the C begins, and how its ends turn into the housings.
const END_DEG: f64 = 8.0;
const ELBOW_INNER_MM: f64 = 20.0;

const DETECTOR_FACE_MM: f64 = 390.0;
const TUBE_FACE_MM: f64 = 430.0;
/// Where both housings have their backs: far enough from the C for coarse triangles between.
const BACK_MM: f64 = 590.0;

const EDGE_MM: f64 = 12.0;
const PIECES: Pieces = Pieces { corner: 3, sides: [2, 2] };

pub fn c_arm() -> Model {
    let regions: [(&str, Material); 4] = [
        ("c", materials::ENAMEL),
        ("holder", materials::HOUSING),
        ("housings", materials::PANEL),
        ("windows", materials::GRAPHITE),
    ];
    // Bands between stations: a triangle's middle is well within one.
    let is_window = |z: f64| z > -DETECTOR_FACE_MM - 24.5 && z < TUBE_FACE_MM + 44.5;
    let region = |p: Vec3| {
        if p.z.atan2(p.x).abs() < (HALF_HOLDER_DEG + SHOULDER_DEG).to_radians() {
            1
        } else if p.x < 165.0 && is_window(p.z) {
            3
        } else if p.x < 165.0 && p.z.abs() < BACK_MM + 25.0 {
            2
        } else {
            0
        }
    };
    Model {
        name: "c-arm",
        parts: painted(&swept(&stations(), PIECES, [EDGE_MM; 2]), &regions, region),
    }
}

/// From the detector's face up, around, and up to the face of the tube.
fn stations() -> Vec<Station> {
    // The axis about which each end of the C turns into its neck.
    let pivot_mm = INNER_RADIUS_MM - ELBOW_INNER_MM;
    let (sin, cos) = END_DEG.to_radians().sin_cos();
    let (pivot_x_mm, pivot_z_mm) = (pivot_mm * sin, pivot_mm * cos);
    let neck = section(2.0 * (pivot_x_mm - ELBOW_INNER_MM), 120.0, 16.0);
    let detector = section(320.0, 320.0, 45.0);
    let chamfered = |body: Section, inset_mm: f64| Section {
        half_mm: body.half_mm.map(|half| half - inset_mm),
        corner_mm: body.corner_mm - 0.5 * inset_mm,
    };
    let tube = section(250.0, 280.0, 60.0);
    let collimator = section(170.0, 170.0, 30.0);
    let elbow_deg = 90.0 + END_DEG;
    let to_x = Towards::PlusX;
    let arc_deg = 90.0 - END_DEG - HALF_HOLDER_DEG - SHOULDER_DEG;
    let start = Placement::new(vec3(0.0, 0.0, -DETECTOR_FACE_MM), -Vec3::z(), Vec3::x());
    let detector_mm = BACK_MM - DETECTOR_FACE_MM;
    Sweep::new(start, chamfered(detector, 10.0))
        .forward(24.0, chamfered(detector, 10.0), 1)
        .forward(10.0, detector, 1)
        .forward(detector_mm - 34.0 - 14.0, detector, 3)
        .forward(14.0, chamfered(detector, 18.0), 2)
        .forward(pivot_z_mm - BACK_MM - 30.0, neck, 2)
        .forward(30.0, neck, 1)
        .turn(to_x, elbow_deg, ELBOW_INNER_MM, ARM, 9)
        .turn(to_x, arc_deg, INNER_RADIUS_MM, ARM, 11)
        .turn(to_x, SHOULDER_DEG, INNER_RADIUS_MM, HOLDER, 2)
        .turn(to_x, 2.0 * HALF_HOLDER_DEG, INNER_RADIUS_MM, HOLDER, 4)
        .turn(to_x, SHOULDER_DEG, INNER_RADIUS_MM, ARM, 2)
        .turn(to_x, arc_deg, INNER_RADIUS_MM, ARM, 11)
        .turn(to_x, elbow_deg, ELBOW_INNER_MM, neck, 9)
        .forward(30.0, neck, 1)
        .forward(pivot_z_mm - BACK_MM - 30.0, chamfered(tube, 18.0), 2)
        .forward(14.0, tube, 2)
        .forward(70.0, tube, 2)
        .forward(20.0, chamfered(tube, 20.0), 2)
        .forward(12.0, collimator, 2)
        .forward(BACK_MM - TUBE_FACE_MM - 116.0, collimator, 2)
        .stations()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::checks::assert_sound_metal;

    #[test]
    fn the_c_is_round_about_the_isocentre() {
        let outer_mm = INNER_RADIUS_MM + 150.0;
        let (low, high) = (vec3(-160.0, -160.0, -773.13), vec3(outer_mm, 160.0, 773.13));
        assert_sound_metal(&c_arm(), low, high, 0.1);
        let shape = swept(&stations(), PIECES, [EDGE_MM; 2]);
        let arc = shape.points.iter().filter(|p| p.x > 200.0);
        let least_mm = arc.map(|p| p.x.hypot(p.z)).fold(f64::INFINITY, f64::min);
        assert!((least_mm - INNER_RADIUS_MM).abs() < 0.01, "{least_mm}");
    }

    #[test]
    fn nothing_is_between_tube_and_detector() {
        let shape = swept(&stations(), PIECES, [EDGE_MM; 2]);
        let between = shape.points.iter().filter(|p| p.x < 300.0);
        let (above, below): (Vec<Vec3>, Vec<Vec3>) = between.partition(|p| p.z < 0.0);
        let nearest_mm =
            |points: &[Vec3]| points.iter().map(|p| p.z.abs()).fold(f64::INFINITY, f64::min);
        assert!((nearest_mm(&above) - DETECTOR_FACE_MM).abs() < 1e-9);
        assert!((nearest_mm(&below) - TUBE_FACE_MM).abs() < 1e-6);
    }
}
