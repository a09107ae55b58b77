//! A surgical navigation pointer: fine probe, cone, shaft and a turned handle.

use std::f64::consts::FRAC_PI_2;

use crate::model::{Model, Part, materials};
use crate::pod::Pod;
use crate::profile::{Corner, at, turned};
use crate::vector::{Placement, Vec3, vec3};

/// The ball that touches tissue; its extremal point is the origin.
const TIP_BALL_RADIUS_MM: f64 = 0.4;
const CONE_END_Z_MM: f64 = 13.0;
const PROBE_RADIUS_MM: f64 = 1.1;
/// From the cone to the handle: the section with a sensor on its axis.
pub const SHAFT_RADIUS_MM: f64 = 2.5;
const SHAFT_START_Z_MM: f64 = 42.0;
const HANDLE_START_Z_MM: f64 = 95.0;
pub const HANDLE_RADIUS_MM: f64 = 7.0;
const WAIST_RADIUS_MM: f64 = 5.7;
pub const TOTAL_LENGTH_MM: f64 = 185.0;

const GRIP_START_Z_MM: f64 = 103.5;
const GRIP_RING_COUNT: usize = 8;
const GRIP_PITCH_MM: f64 = 1.7;
const GRIP_GROOVE_DEPTH_MM: f64 = 0.45;
const GRIP_GROOVE_WIDTH_MM: f64 = 0.7;

pub fn pointer() -> Model {
    Model {
        name: "pointer",
        parts: vec![
            Part::new("probe", materials::STEEL, turned(&probe(), 48)),
            Part::new("collar", materials::BRUSHED_STEEL, turned(&collar(), 64)),
            Part::new("handle", materials::ANODISED, turned(&handle(), 52)),
            Part::new("end-cap", materials::BRUSHED_STEEL, turned(&end_cap(), 64)),
            Part::new("sensor-housing", materials::HOUSING, sensor_housing().shape()),
        ],
    }
}

fn probe() -> Vec<Corner> {
    const BALL_PIECES: usize = 9;
    // The cone leaves the ball along its tangent.
    let cone_rad = ((PROBE_RADIUS_MM - TIP_BALL_RADIUS_MM) / CONE_END_Z_MM).atan();
    let on_ball = |i: usize| {
        let polar_rad = (FRAC_PI_2 - cone_rad) * i as f64 / BALL_PIECES as f64;
        let (sin, cos) = polar_rad.sin_cos();
        at(TIP_BALL_RADIUS_MM * (1.0 - cos), TIP_BALL_RADIUS_MM * sin, 0.0)
    };
    let mut corners: Vec<Corner> = (0..=BALL_PIECES).map(on_ball).collect();
    corners.extend([
        at(CONE_END_Z_MM, PROBE_RADIUS_MM, 60.0),
        at(29.0, PROBE_RADIUS_MM, 70.0),
        at(SHAFT_START_Z_MM, SHAFT_RADIUS_MM, 70.0),
        at(HANDLE_START_Z_MM + 2.0, SHAFT_RADIUS_MM, 0.0),
    ]);
    corners
}

/// The bright ring that leads from the shaft to the handle.
fn collar() -> Vec<Corner> {
    vec![
        at(HANDLE_START_Z_MM - 3.0, 2.4, 0.0),
        at(HANDLE_START_Z_MM - 3.0, 3.4, 0.4),
        at(HANDLE_START_Z_MM + 0.6, 4.6, 0.5),
        at(HANDLE_START_Z_MM + 1.4, 4.6, 0.0),
    ]
}

fn handle() -> Vec<Corner> {
    let mut corners = vec![
        at(HANDLE_START_Z_MM, 4.2, 0.0),
        at(HANDLE_START_Z_MM + 0.8, 5.0, 0.5),
        at(HANDLE_START_Z_MM + 5.0, 6.4, 4.0),
    ];
    for ring in 0..GRIP_RING_COUNT {
        let z_mm = GRIP_START_Z_MM + ring as f64 * GRIP_PITCH_MM;
        let groove_radius_mm = 6.4 - GRIP_GROOVE_DEPTH_MM;
        corners.extend([
            at(z_mm, 6.4, 0.2),
            at(z_mm + 0.15, groove_radius_mm, 0.15),
            at(z_mm + GRIP_GROOVE_WIDTH_MM - 0.15, groove_radius_mm, 0.15),
            at(z_mm + GRIP_GROOVE_WIDTH_MM, 6.4, 0.2),
        ]);
    }
    corners.extend([
        at(119.0, 6.4, 40.0),
        at(128.0, WAIST_RADIUS_MM, 60.0),
        at(142.0, WAIST_RADIUS_MM, 90.0),
        at(163.0, HANDLE_RADIUS_MM, 60.0),
        at(178.0, HANDLE_RADIUS_MM, 0.4),
        at(178.4, HANDLE_RADIUS_MM - 0.4, 0.0),
    ]);
    corners
}

fn end_cap() -> Vec<Corner> {
    vec![
        at(178.0, 6.3, 0.0),
        at(178.9, 6.3, 0.1),
        at(178.9, HANDLE_RADIUS_MM, 0.3),
        at(180.6, HANDLE_RADIUS_MM, 2.0),
        at(TOTAL_LENGTH_MM, 5.2, 3.2),
        at(TOTAL_LENGTH_MM, 0.0, 0.0),
    ]
}

/// A low flat on the back of the handle, where the sensor's leads are potted.
fn sensor_housing() -> Pod {
    Pod {
        placement: Placement::new(vec3(0.0, 4.1, 148.0), Vec3::y(), Vec3::z()),
        length_mm: 36.0,
        width_mm: 7.4,
        height_mm: 3.9,
        edge_mm: 1.7,
        foot_mm: 0.0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::checks::assert_sound;

    #[test]
    fn the_tip_is_the_origin_and_the_length_is_right() {
        assert_sound(&pointer(), vec3(-7.0, -7.0, 0.0), vec3(7.0, 8.0, 185.0), 0.05);
    }

    #[test]
    fn the_tip_ball_is_round() {
        let touching = turned(&probe(), 48).points;
        for point in touching.iter().filter(|point| point.z < 0.3) {
            let centre = vec3(0.0, 0.0, TIP_BALL_RADIUS_MM);
            assert!((*point - centre).norm() < TIP_BALL_RADIUS_MM + 0.02);
        }
    }
}
