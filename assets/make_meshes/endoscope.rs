//! A rigid 0 degree sinus endoscope with light post, eyepiece and a camera head behind.

use crate::model::{Model, Part, materials};
use crate::pod::Pod;
use crate::profile::{Corner, RoundedRectangle, at, bezier, cable, lofted, turned};
use crate::shape::Shape;
use crate::vector::{Placement, Vec3, vec3};

pub const ROD_RADIUS_MM: f64 = 2.0;
const LENS_RADIUS_MM: f64 = 1.25;
pub const ROD_END_Z_MM: f64 = 180.0;
pub const BODY_RADIUS_MM: f64 = 8.0;
const BODY_END_Z_MM: f64 = 238.0;
const LIGHT_POST_Z_MM: f64 = 205.0;
const EYEPIECE_RADIUS_MM: f64 = 15.9;
const EYEPIECE_END_Z_MM: f64 = 247.0;
const COUPLER_END_Z_MM: f64 = 259.0;
const CAMERA_END_Z_MM: f64 = 290.0;
const CAMERA_HALF_WIDTH_MM: f64 = 17.0;
const CAMERA_HALF_HEIGHT_MM: f64 = 15.0;

pub fn endoscope() -> Model {
    Model {
        name: "endoscope",
        parts: vec![
            Part::new("rod", materials::STEEL, turned(&rod(), 48)),
            Part::new("lens", materials::GLASS, turned(&lens(), 40)),
            Part::new("body", materials::BRUSHED_STEEL, turned(&body(), 54)),
            Part::new("angle-ring", materials::ANGLE_GREEN, turned(&angle_ring(), 60)),
            Part::new("light-post", materials::STEEL, light_post()),
            Part::new("eyepiece", materials::ANODISED, turned(&eyepiece(), 72)),
            Part::new("coupler", materials::BRUSHED_STEEL, coupler()),
            Part::new("camera-head", materials::ANODISED, camera_head()),
            Part::new("camera-buttons", materials::HOUSING, camera_buttons()),
            Part::new("cable", materials::CABLE, camera_cable()),
        ],
    }
}

/// A tube with a bevelled mouth around its lens; it runs on into the body.
fn rod() -> Vec<Corner> {
    vec![
        at(0.35, LENS_RADIUS_MM - 0.1, 0.0),
        at(0.35, LENS_RADIUS_MM, 0.0),
        at(0.05, LENS_RADIUS_MM + 0.1, 0.0),
        at(0.05, 1.72, 0.06),
        at(0.40, ROD_RADIUS_MM, 0.12),
        at(ROD_END_Z_MM + 2.0, ROD_RADIUS_MM, 0.0),
    ]
}

fn lens() -> Vec<Corner> {
    vec![
        at(0.0, 0.0, 0.0),
        at(0.0, 0.75, 2.0),
        at(0.16, LENS_RADIUS_MM + 0.02, 0.0),
        at(0.6, LENS_RADIUS_MM + 0.02, 0.0),
    ]
}

fn body() -> Vec<Corner> {
    vec![
        at(ROD_END_Z_MM - 8.0, 1.9, 0.0),
        at(ROD_END_Z_MM - 8.0, 2.6, 0.3),
        at(ROD_END_Z_MM - 2.0, 2.6, 1.5),
        at(ROD_END_Z_MM - 1.0, 3.4, 0.4),
        at(ROD_END_Z_MM + 2.0, 3.4, 2.0),
        at(ROD_END_Z_MM + 15.0, BODY_RADIUS_MM, 4.0),
        at(218.0, BODY_RADIUS_MM, 0.4),
        at(218.4, BODY_RADIUS_MM - 0.8, 0.2),
        at(220.6, BODY_RADIUS_MM - 0.8, 0.2),
        at(221.0, BODY_RADIUS_MM, 0.4),
        at(BODY_END_Z_MM - 4.0, BODY_RADIUS_MM, 3.0),
        at(BODY_END_Z_MM, 9.6, 0.0),
    ]
}

/// Lies in the body's groove; its colour shows the direction of view.
fn angle_ring() -> Vec<Corner> {
    vec![
        at(218.3, 6.0, 0.0),
        at(218.3, BODY_RADIUS_MM - 0.3, 0.2),
        at(220.7, BODY_RADIUS_MM - 0.3, 0.2),
        at(220.7, 6.0, 0.0),
    ]
}

/// The stepped connector for the light guide, along +x.
fn light_post() -> Shape {
    let corners = [
        at(5.0, 6.0, 0.0),
        at(8.6, 6.0, 0.5),
        at(8.6, 5.0, 0.3),
        at(13.0, 5.0, 0.5),
        at(13.0, 4.4, 0.2),
        at(14.2, 4.4, 0.2),
        at(14.2, 5.4, 0.5),
        at(19.5, 5.4, 0.5),
        at(19.5, 4.5, 0.3),
        at(21.0, 4.5, 0.3),
        at(21.0, 4.9, 0.3),
        at(26.0, 4.6, 0.6),
        at(26.0, 2.2, 0.2),
        at(24.8, 2.2, 0.0),
    ];
    let along_x = Placement::new(vec3(0.0, 0.0, LIGHT_POST_Z_MM), Vec3::x(), Vec3::z());
    turned(&corners, 32).placed(&along_x)
}

fn eyepiece() -> Vec<Corner> {
    vec![
        at(BODY_END_Z_MM - 0.8, 8.8, 0.0),
        at(BODY_END_Z_MM - 0.8, 10.0, 0.4),
        at(BODY_END_Z_MM + 5.0, EYEPIECE_RADIUS_MM, 1.0),
        at(EYEPIECE_END_Z_MM, EYEPIECE_RADIUS_MM, 0.5),
        at(EYEPIECE_END_Z_MM, 12.0, 0.0),
    ]
}

/// The camera's clamp: a ring with lengthwise flutes for wet gloves.
fn coupler() -> Shape {
    const FLUTES: usize = 24;
    const FLUTE_DEPTH_MM: f64 = 0.55;
    let corners = [
        at(EYEPIECE_END_Z_MM - 0.2, 12.0, 0.0),
        at(EYEPIECE_END_Z_MM - 0.2, 14.0, 0.4),
        at(EYEPIECE_END_Z_MM + 1.6, 14.0, 0.2),
        at(EYEPIECE_END_Z_MM + 1.6, 16.8, 0.7),
        at(COUPLER_END_Z_MM - 1.6, 16.8, 0.7),
        at(COUPLER_END_Z_MM - 1.6, 14.2, 0.3),
        at(COUPLER_END_Z_MM + 0.4, 14.2, 0.0),
    ];
    lofted(&corners, |radius_mm| {
        let depth_mm = FLUTE_DEPTH_MM * ((radius_mm - 14.5) / 1.5).clamp(0.0, 1.0);
        let points = FLUTES * 5;
        let fluted = |i: usize| {
            let turn = i as f64 / points as f64 * std::f64::consts::TAU;
            // Broad lands, narrow round flutes.
            let flute = (0.5 + 0.5 * (turn * FLUTES as f64).cos()).powi(3);
            let (sin, cos) = turn.sin_cos();
            let radius_mm = radius_mm - depth_mm * flute;
            [radius_mm * cos, radius_mm * sin]
        };
        (0..points).map(fluted).collect()
    })
}

fn camera_head() -> Shape {
    let outline = RoundedRectangle {
        half_width_mm: CAMERA_HALF_WIDTH_MM,
        half_height_mm: CAMERA_HALF_HEIGHT_MM,
        corner_mm: 7.0,
        corner_pieces: 9,
        side_pieces: [1, 1],
    };
    let corners = [
        at(COUPLER_END_Z_MM, -5.0, 0.0),
        at(COUPLER_END_Z_MM, 0.0, 1.2),
        at(COUPLER_END_Z_MM + 20.0, 0.0, 20.0),
        at(CAMERA_END_Z_MM, -2.6, 2.5),
        at(CAMERA_END_Z_MM, -6.0, 0.0),
    ];
    lofted(&corners, |outset_mm| outline.outline(outset_mm))
}

/// Two keys on the upper side, the forward one longer so that a thumb can feel which is which.
fn camera_buttons() -> Shape {
    let key = |z_mm: f64, length_mm: f64| Pod {
        placement: Placement::new(
            vec3(0.0, CAMERA_HALF_HEIGHT_MM - 0.6, z_mm),
            Vec3::y(),
            Vec3::z(),
        ),
        length_mm,
        width_mm: 7.0,
        height_mm: 1.8,
        edge_mm: 0.7,
        foot_mm: 0.0,
    };
    key(267.0, 9.0).shape().and(key(277.5, 7.2).shape())
}

fn camera_cable() -> Shape {
    const RIBS: usize = 4;
    let mut relief = vec![at(CAMERA_END_Z_MM - 0.5, 5.2, 0.0), at(CAMERA_END_Z_MM + 1.0, 5.2, 0.4)];
    for rib in 0..RIBS {
        let z_mm = CAMERA_END_Z_MM + 1.4 + rib as f64 * 3.0;
        let radius_mm = 4.8 - 0.4 * rib as f64;
        relief.extend([
            at(z_mm, radius_mm - 0.8, 0.3),
            at(z_mm + 0.9, radius_mm - 0.9, 0.3),
            at(z_mm + 1.0, radius_mm, 0.3),
            at(z_mm + 2.8, radius_mm - 0.1, 0.3),
        ]);
    }
    relief.push(at(CAMERA_END_Z_MM + 13.2, 2.4, 0.0));
    let start = vec3(0.0, 0.0, CAMERA_END_Z_MM + 12.0);
    let path = [
        start,
        start + Vec3::z() * 10.0,
        start + vec3(0.0, -2.0, 19.0),
        start + vec3(0.0, -7.0, 27.0),
    ];
    turned(&relief, 28).and(cable(&bezier(path, 16), 2.6, 20))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::checks::assert_sound;

    #[test]
    fn the_endoscope_has_the_stated_dimensions() {
        assert_sound(&endoscope(), vec3(-17.0, -16.7, 0.0), vec3(26.0, 16.7, 330.7), 0.1);
    }
}
