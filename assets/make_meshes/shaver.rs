//! A tissue shaver: a tube with a toothed side window on a handpiece with suction and a cable.

use crate::model::{Model, Part, materials};
use crate::profile::{Corner, at, bezier, cable, circle, rounded, skinned, turned};
use crate::shape::Shape;
use crate::vector::{Placement, Vec3, vec3};
use crate::windowed_tube::WindowedTube;

pub const TUBE_RADIUS_MM: f64 = 2.0;
pub const TUBE_END_Z_MM: f64 = 110.0;
const HUB_START_Z_MM: f64 = 103.0;
const HANDPIECE_START_Z_MM: f64 = 118.0;
pub const HANDPIECE_END_Z_MM: f64 = 250.0;

/// The outer blade is a polished tube; its window shows the toothed inner one.
const OUTER_BLADE: WindowedTube = WindowedTube {
    tip_z_mm: 0.0,
    end_z_mm: TUBE_END_Z_MM,
    radius_mm: TUBE_RADIUS_MM,
    window_start_z_mm: 2.0,
    window_end_z_mm: 9.6,
    window_half_angle_rad: 1.15,
    floor_radius_mm: 0.45,
    teeth: 0,
};
const INNER_BLADE: WindowedTube = WindowedTube {
    tip_z_mm: 0.35,
    end_z_mm: 30.0,
    radius_mm: 1.68,
    window_start_z_mm: 2.2,
    window_end_z_mm: 9.2,
    window_half_angle_rad: 1.0,
    floor_radius_mm: 0.55,
    teeth: 7,
};
/// Inside the inner blade it is dark.
const BORE_RADIUS_MM: f64 = 0.62;

/// Centres of the two lines that leave the handpiece at its back.
const SUCTION_Y_MM: f64 = 4.2;
const CABLE_Y_MM: f64 = -4.4;

pub fn shaver() -> Model {
    Model {
        name: "shaver",
        parts: vec![
            Part::new("outer-blade", materials::STEEL, OUTER_BLADE.shape()),
            Part::new("inner-blade", materials::DARK_STEEL, INNER_BLADE.shape()),
            Part::new("bore", materials::BORE, turned(&bore(), 24)),
            Part::new("hub", materials::BRUSHED_STEEL, hub()),
            Part::new("handpiece", materials::ANODISED, handpiece()),
            Part::new("grip-band", materials::GRIP, grip_band()),
            Part::new("back-ring", materials::BRUSHED_STEEL, back_ring()),
            Part::new("suction-port", materials::STEEL, suction_port()),
            Part::new("cable", materials::CABLE, power_cable()),
        ],
    }
}

fn bore() -> Vec<Corner> {
    let (start, end) = (INNER_BLADE.window_start_z_mm, INNER_BLADE.window_end_z_mm);
    vec![
        at(start - 0.2, 0.0, 0.0),
        at(start - 0.2, BORE_RADIUS_MM, 0.2),
        at(end + 0.2, BORE_RADIUS_MM, 0.2),
        at(end + 0.2, 0.0, 0.0),
    ]
}

/// The blade's hub with its coupling rings and an irrigation nipple on top.
fn hub() -> Shape {
    let body = turned(
        &[
            at(HUB_START_Z_MM, 1.9, 0.0),
            at(HUB_START_Z_MM, 3.0, 0.5),
            at(107.0, 3.6, 3.0),
            at(110.0, 6.6, 2.0),
            at(113.2, 7.2, 0.5),
            at(113.2, 6.3, 0.3),
            at(114.4, 6.3, 0.3),
            at(114.4, 7.9, 0.5),
            at(117.2, 8.2, 0.5),
            at(117.2, 7.4, 0.3),
            at(HANDPIECE_START_Z_MM + 1.0, 7.4, 0.0),
        ],
        40,
    );
    let nipple = [
        at(0.0, 1.5, 0.0),
        at(9.0, 1.5, 0.4),
        at(9.0, 2.0, 0.2),
        at(11.0, 1.4, 0.2),
        at(11.0, 1.9, 0.2),
        at(13.0, 1.2, 0.4),
        at(13.0, 0.0, 0.0),
    ];
    let leaning = Placement::new(vec3(0.0, 3.0, 111.5), vec3(0.0, 1.0, 0.55), Vec3::x());
    body.and(turned(&nipple, 20).placed(&leaning))
}

/// Turned, then bent a little off the axis: a belly for the palm, a waist for the fingers.
fn handpiece() -> Shape {
    let corners = [
        at(HANDPIECE_START_Z_MM, 7.6, 0.0),
        at(HANDPIECE_START_Z_MM, 8.8, 0.6),
        at(128.0, 9.6, 12.0),
        at(137.0, 9.6, 1.0),
        at(138.0, 9.2, 0.6),
        at(162.0, 8.9, 0.6),
        at(163.0, 9.4, 1.0),
        at(174.0, 9.6, 50.0),
        at(200.0, 11.4, 110.0),
        at(222.0, 11.2, 80.0),
        at(246.5, 9.4, 0.5),
        at(246.5, 8.8, 0.2),
        at(247.5, 8.8, 0.0),
    ];
    bellied(&corners)
}

/// Fine rings for the thumb and two fingers.
fn grip_band() -> Shape {
    const RIDGES: usize = 8;
    const PITCH_MM: f64 = 2.85;
    let start_mm = 138.6;
    let radius_mm = |z_mm: f64| 9.75 - 0.3 * (z_mm - start_mm) / (RIDGES as f64 * PITCH_MM);
    let mut corners = vec![at(start_mm - 0.2, 8.6, 0.0)];
    for ridge in 0..RIDGES {
        let z_mm = start_mm + ridge as f64 * PITCH_MM;
        corners.extend([
            at(z_mm, radius_mm(z_mm) - 0.5, 0.0),
            at(z_mm + 0.4, radius_mm(z_mm), 0.35),
            at(z_mm + PITCH_MM - 0.4, radius_mm(z_mm), 0.35),
        ]);
    }
    let end_mm = start_mm + RIDGES as f64 * PITCH_MM;
    corners.extend([at(end_mm, radius_mm(end_mm) - 0.5, 0.2), at(end_mm + 0.2, 8.6, 0.0)]);
    bellied(&corners)
}

fn back_ring() -> Shape {
    bellied(&[
        at(247.0, 7.0, 0.0),
        at(247.0, 9.2, 0.3),
        at(248.4, 9.2, 0.8),
        at(HANDPIECE_END_Z_MM, 7.6, 0.8),
        at(HANDPIECE_END_Z_MM, 3.0, 0.0),
    ])
}

/// A barbed port for the suction hose, open at its end.
fn suction_port() -> Shape {
    let corners = [
        at(HANDPIECE_END_Z_MM - 1.0, 3.0, 0.0),
        at(HANDPIECE_END_Z_MM + 2.0, 3.0, 0.3),
        at(HANDPIECE_END_Z_MM + 5.0, 2.6, 1.0),
        at(HANDPIECE_END_Z_MM + 6.0, 3.4, 0.3),
        at(HANDPIECE_END_Z_MM + 10.0, 2.7, 0.3),
        at(HANDPIECE_END_Z_MM + 10.6, 3.3, 0.3),
        at(HANDPIECE_END_Z_MM + 15.0, 2.5, 0.3),
        at(HANDPIECE_END_Z_MM + 15.0, 1.8, 0.2),
        at(HANDPIECE_END_Z_MM + 8.0, 1.8, 0.0),
    ];
    turned(&corners, 28).mapped(|point| point + Vec3::y() * SUCTION_Y_MM)
}

fn power_cable() -> Shape {
    let relief = [
        at(HANDPIECE_END_Z_MM - 1.0, 3.2, 0.0),
        at(HANDPIECE_END_Z_MM + 1.5, 3.2, 0.5),
        at(HANDPIECE_END_Z_MM + 2.0, 2.8, 0.2),
        at(HANDPIECE_END_Z_MM + 14.0, 2.0, 0.5),
        at(HANDPIECE_END_Z_MM + 14.0, 1.2, 0.0),
    ];
    let start = vec3(0.0, CABLE_Y_MM, HANDPIECE_END_Z_MM + 12.0);
    let path = [
        start,
        start + Vec3::z() * 12.0,
        start + vec3(0.0, -3.0, 22.0),
        start + vec3(0.0, -9.0, 32.0),
    ];
    turned(&relief, 36).mapped(|point| point + Vec3::y() * CABLE_Y_MM).and(cable(
        &bezier(path, 18),
        1.7,
        18,
    ))
}

/// A body turned around an axis that sags towards -y where the palm lies, and is wider there.
fn bellied(corners: &[Corner]) -> Shape {
    /// Longer pieces would show the bend as corners.
    const MAX_PIECE_MM: f64 = 6.0;
    let mut profile: Vec<[f64; 2]> = Vec::new();
    for point in rounded(corners) {
        if let Some(&last) = profile.last() {
            let pieces = ((point[0] - last[0]).abs() / MAX_PIECE_MM).ceil().max(1.0);
            for i in 1..pieces as usize {
                let t = i as f64 / pieces;
                profile.push([0, 1].map(|k| last[k] + (point[k] - last[k]) * t));
            }
        }
        profile.push(point);
    }
    let ring = |&[z_mm, radius_mm]: &[f64; 2]| {
        let belly = belly(z_mm);
        let lift = |&[x, y]: &[f64; 2]| {
            let below = if y < 0.0 { 1.0 + 0.13 * belly } else { 1.0 };
            vec3(x, y * below, z_mm)
        };
        circle(radius_mm, 46).iter().map(lift).collect::<Vec<_>>()
    };
    skinned(&profile.iter().map(ring).collect::<Vec<_>>(), 1)
}

/// 0 outside the palm's section, 1 in its middle, smooth between.
fn belly(z_mm: f64) -> f64 {
    let t = ((z_mm - 206.0) / 40.0).clamp(-1.0, 1.0);
    (1.0 - t * t).powi(2)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::checks::assert_sound;

    #[test]
    fn the_shaver_has_the_stated_dimensions() {
        assert_sound(&shaver(), vec3(-11.4, -14.9, 0.0), vec3(11.4, 14.9, 295.1), 0.1);
    }
}
