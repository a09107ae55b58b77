//! A planar electromagnetic field generator, in the tracker frame.
//!
//! Its front face is at z = 0 and looks along -z, where the measurement volume is.

use crate::model::{Model, Part, materials};
use crate::profile::{RoundedRectangle, at, bezier, cable, lofted, turned};
use crate::shape::Shape;
use crate::vector::{Placement, Vec3, vec3};

pub const HALF_SIZE_MM: f64 = 100.0;
pub const DEPTH_MM: f64 = 70.0;

/// The panel lies a little below the rim; the mark rises back to the rim's height.
const PANEL_Z_MM: f64 = 0.8;
const PANEL_INSET_MM: f64 = 14.0;
const GROOVE_WIDTH_MM: f64 = 1.2;

const MARK_RING_RADIUS_MM: f64 = 34.0;
const MARK_LINE_HALF_WIDTH_MM: f64 = 0.6;

const HOUSING: RoundedRectangle = RoundedRectangle {
    half_width_mm: HALF_SIZE_MM,
    half_height_mm: HALF_SIZE_MM,
    corner_mm: 26.0,
    corner_pieces: 16,
    side_pieces: [1, 1],
};

pub fn field_generator() -> Model {
    Model {
        name: "field-generator",
        parts: vec![
            Part::new("housing", materials::GRAPHITE, housing()),
            Part::new("front-panel", materials::PANEL, front_panel()),
            Part::new("front-mark", materials::MARK, front_mark()),
            Part::new("cable", materials::CABLE, generator_cable()),
        ],
    }
}

fn housing() -> Shape {
    let corners = [
        at(3.0, -PANEL_INSET_MM - 3.0, 0.0),
        at(3.0, -PANEL_INSET_MM + GROOVE_WIDTH_MM, 0.3),
        at(0.0, -PANEL_INSET_MM + GROOVE_WIDTH_MM, 0.6),
        at(0.0, 0.0, 9.0),
        at(46.0, 0.0, 0.6),
        at(46.6, -0.8, 0.3),
        at(48.0, -0.8, 0.3),
        at(48.6, 0.0, 0.6),
        at(DEPTH_MM, -5.0, 14.0),
        at(DEPTH_MM, -24.0, 0.0),
    ];
    lofted(&corners, |outset_mm| HOUSING.outline(outset_mm))
}

fn front_panel() -> Shape {
    let corners = [
        at(PANEL_Z_MM, -PANEL_INSET_MM - 4.0, 0.0),
        at(PANEL_Z_MM, -PANEL_INSET_MM, 0.6),
        at(3.5, -PANEL_INSET_MM, 0.0),
    ];
    lofted(&corners, |outset_mm| HOUSING.outline(outset_mm))
}

/// A ring around the origin and four strokes along x and y; the one along +y is the longest.
fn front_mark() -> Shape {
    let (r, w) = (MARK_RING_RADIUS_MM, MARK_LINE_HALF_WIDTH_MM);
    let low_mm = PANEL_Z_MM + 0.6;
    let ring_section = [
        [low_mm, r - w],
        [0.15, r - w],
        [0.0, r - w + 0.15],
        [0.0, r + w - 0.15],
        [0.15, r + w],
        [low_mm, r + w],
    ];
    let ring = ring_around_z(&ring_section, 96);
    let dot = turned(&[at(0.0, 0.0, 0.0), at(0.0, 2.2, 0.2), at(low_mm, 2.2, 0.0)], 40);
    let strokes = [(Vec3::x(), 12.0), (Vec3::y(), 30.0), (-Vec3::x(), 12.0), (-Vec3::y(), 12.0)];
    strokes.iter().fold(ring.and(dot), |mark, &(direction, length_mm)| {
        mark.and(stroke(direction, r + 6.0, length_mm, low_mm))
    })
}

/// A thin bar from `start_mm` outwards along `direction`.
fn stroke(direction: Vec3, start_mm: f64, length_mm: f64, low_mm: f64) -> Shape {
    let bar = RoundedRectangle {
        half_width_mm: length_mm / 2.0,
        half_height_mm: MARK_LINE_HALF_WIDTH_MM,
        corner_mm: MARK_LINE_HALF_WIDTH_MM - 0.02,
        corner_pieces: 5,
        side_pieces: [1, 1],
    };
    let corners = [at(0.0, -0.15, 0.0), at(0.15, 0.0, 0.0), at(low_mm, 0.0, 0.0)];
    let middle = direction * (start_mm + length_mm / 2.0);
    lofted(&corners, |outset_mm| bar.outline(outset_mm)).placed(&Placement::new(
        middle,
        Vec3::z(),
        direction,
    ))
}

/// A closed section of `[z, radius]` points turned around z; the section runs as a profile does.
fn ring_around_z(section: &[[f64; 2]], segments: usize) -> Shape {
    let rings: Vec<Vec<Vec3>> = (section.iter())
        .map(|&[z, r]| {
            crate::profile::circle(r, segments).iter().map(|&[x, y]| vec3(x, y, z)).collect()
        })
        .collect();
    crate::profile::skinned_loop(&rings)
}

fn generator_cable() -> Shape {
    let out_of_side = Placement::new(vec3(HALF_SIZE_MM - 2.0, -62.0, 35.0), Vec3::x(), Vec3::z());
    let gland = [
        at(0.0, 10.0, 0.0),
        at(4.0, 10.0, 0.8),
        at(4.0, 8.0, 0.3),
        at(7.0, 8.0, 0.6),
        at(24.0, 5.4, 0.8),
        at(24.0, 3.0, 0.0),
    ];
    let start = vec3(HALF_SIZE_MM + 20.0, -62.0, 35.0);
    let path = [
        start,
        start + Vec3::x() * 14.0,
        start + vec3(24.0, -5.0, 3.0),
        start + vec3(32.0, -17.0, 6.0),
    ];
    turned(&gland, 40).placed(&out_of_side).and(cable(&bezier(path, 24), 4.0, 28))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::checks::assert_sound;
    use crate::shape::bounds_mm;

    #[test]
    fn the_front_face_is_at_zero() {
        assert_sound(&field_generator(), vec3(-100.0, -100.0, 0.0), vec3(155.5, 100.0, 70.0), 0.1);
    }

    #[test]
    fn the_mark_lies_in_the_front_face() {
        let (low, high) = bounds_mm(&front_mark().points);
        assert!(low.z.abs() < 1e-9 && high.z < 2.0);
        assert!((high.y - 70.0).abs() < 1e-9 && (high.x - 52.0).abs() < 1e-9);
    }
}
