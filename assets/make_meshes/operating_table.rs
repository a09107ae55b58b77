//! An operating table with a narrow head plate, as one closed surface.
//!
//! The origin is in the middle of the top's head end; axes as a patient on it has them: -z up out of
//! the top, +y to the crown, so that the table runs along -y, and +x to the right of one who lies on
//! the back. The pad is part of the surface: as metal the top is thicker than its frame by that.

use crate::model::{Material, Model, materials, painted};
use crate::profile::skinned;
use crate::shape::Shape;
use crate::vector::{Vec3, VecExt, vec3};

const LENGTH_MM: f64 = 2000.0;
const HALF_WIDTH_MM: f64 = 250.0;
const HEAD_PLATE_HALF_WIDTH_MM: f64 = 140.0;
const HEAD_PLATE_LENGTH_MM: f64 = 330.0;
/// From the pad's surface down.
const PAD_END_Z_MM: f64 = 22.0;
const RAIL_Z_MM: [f64; 2] = [38.0, 62.0];
const FRAME_END_Z_MM: f64 = 80.0;
const BASE_Z_MM: [f64; 2] = [800.0, 880.0];

const COLUMN_Y_MM: f64 = -1050.0;

/// Pieces of each of an outline's corners, and of the sides after them.
const CORNER_PIECES: usize = 3;
const SIDE_PIECES: [usize; CORNERS] = [12, 1, 3, 3, 3, 1, 12, 4];
const CORNERS: usize = 8;

const CAP_RINGS: usize = 6;

/// Corners counter-clockwise seen from above, with own x to the left: the outline of the top, or a
/// rectangle that has four more corners on its side to the head.
#[derive(Clone, Copy)]
struct Outline {
    corners_mm: [[f64; 2]; CORNERS],
    /// From a corner to where its arc begins.
    reach_mm: [f64; CORNERS],
}

impl Outline {
    /// The top, moved outwards by `outset_mm`.
    fn top(outset_mm: f64) -> Self {
        let (wide, narrow) = (HALF_WIDTH_MM + outset_mm, HEAD_PLATE_HALF_WIDTH_MM + outset_mm);
        let (shoulder, end) = (outset_mm - HEAD_PLATE_LENGTH_MM, -LENGTH_MM - outset_mm);
        Self {
            corners_mm: [
                [wide, end],
                [wide, shoulder],
                [narrow, shoulder],
                [narrow, outset_mm],
                [-narrow, outset_mm],
                [-narrow, shoulder],
                [-wide, shoulder],
                [-wide, end],
            ],
            reach_mm: [60.0, 45.0, 30.0, 50.0, 50.0, 30.0, 45.0, 60.0]
                .map(|reach| reach + outset_mm),
        }
    }

    fn rectangle(half_x_mm: f64, [low_y_mm, high_y_mm]: [f64; 2], reach_mm: f64) -> Self {
        let on_side = |part: f64| [half_x_mm * part, high_y_mm];
        let inner_mm = 0.15 * half_x_mm;
        Self {
            corners_mm: [
                [half_x_mm, low_y_mm],
                [half_x_mm, high_y_mm],
                on_side(0.5),
                on_side(0.17),
                on_side(-0.17),
                on_side(-0.5),
                [-half_x_mm, high_y_mm],
                [-half_x_mm, low_y_mm],
            ],
            reach_mm: [
                reach_mm, reach_mm, inner_mm, inner_mm, inner_mm, inner_mm, reach_mm, reach_mm,
            ],
        }
    }

    /// The outline at a height, counter-clockwise seen from above.
    fn ring(&self, z_mm: f64) -> Vec<Vec3> {
        let corner = |i: usize| {
            let [x, y] = self.corners_mm[i % CORNERS];
            vec3(-x, y, z_mm)
        };
        let arc = |i: usize| {
            let (before, middle, after) = (corner(i + CORNERS - 1), corner(i), corner(i + 1));
            let reach_mm = self.reach_mm[i % CORNERS];
            let start = middle + (before - middle).normalized() * reach_mm;
            let end = middle + (after - middle).normalized() * reach_mm;
            (0..=CORNER_PIECES).map(move |k| {
                let t = k as f64 / CORNER_PIECES as f64;
                start.between(middle, t).between(middle.between(end, t), t)
            })
        };
        let mut ring: Vec<Vec3> = Vec::new();
        for (i, &pieces) in SIDE_PIECES.iter().enumerate() {
            ring.extend(arc(i));
            let from = ring[ring.len() - 1];
            let to = arc(i + 1).next().unwrap_or(from);
            ring.extend((1..pieces).map(|k| from.between(to, k as f64 / pieces as f64)));
        }
        ring
    }
}

pub fn operating_table() -> Model {
    let regions: [(&str, Material); 5] = [
        ("pad", materials::GRAPHITE),
        ("frame", materials::BRUSHED_STEEL),
        ("rail", materials::STEEL),
        ("column", materials::BRUSHED_STEEL),
        ("base", materials::PANEL),
    ];
    let region = |p: Vec3| match p.z {
        z if z < PAD_END_Z_MM + 0.1 => 0,
        z if z > RAIL_Z_MM[0] && z < RAIL_Z_MM[1] => 2,
        z if z < FRAME_END_Z_MM + 0.1 => 1,
        z if z < BASE_Z_MM[0] - 20.0 => 3,
        _ => 4,
    };
    Model { name: "operating-table", parts: painted(&shape(), &regions, region) }
}

/// From the floor up.
fn shape() -> Shape {
    let column = |half_x_mm: f64, half_y_mm: f64| {
        Outline::rectangle(half_x_mm, [COLUMN_Y_MM - half_y_mm, COLUMN_Y_MM + half_y_mm], 30.0)
    };
    let base = |outset_mm: f64| {
        let y_mm = [COLUMN_Y_MM - 480.0 - outset_mm, COLUMN_Y_MM + 420.0 + outset_mm];
        Outline::rectangle(230.0 + outset_mm, y_mm, 60.0 + outset_mm)
    };
    let (lower, upper) = (column(130.0, 180.0), column(105.0, 150.0));
    let [base_top_mm, floor_mm] = BASE_Z_MM;
    let column_foot = lower.ring(base_top_mm - 20.0);
    let column_head = upper.ring(FRAME_END_Z_MM);
    let mut rings = vec![
        base(-10.0).ring(floor_mm),
        base(0.0).ring(floor_mm - 10.0),
        base(0.0).ring(base_top_mm + 10.0),
        base(-10.0).ring(base_top_mm),
    ];
    rings.extend(between(&base(-10.0).ring(base_top_mm), &column_foot, &[0.4, 0.75]));
    rings.push(column_foot);
    rings.extend([680.0, 580.0, 500.0, 440.0].map(|z_mm| lower.ring(z_mm)));
    rings.extend([430.0, 340.0, 250.0, 160.0].map(|z_mm| upper.ring(z_mm)));
    let under = Outline::top(-8.0).ring(FRAME_END_Z_MM);
    rings.extend(between(&column_head, &under, &[0.0, 0.2, 0.45, 0.75]));
    rings.push(under);
    let [rail_top_mm, rail_end_mm] = RAIL_Z_MM;
    let top = [
        (0.0, FRAME_END_Z_MM - 8.0),
        (0.0, rail_end_mm),
        (0.0, rail_top_mm),
        (0.0, PAD_END_Z_MM),
        (-8.0, PAD_END_Z_MM),
        (-8.0, 10.0),
        (-12.0, 3.0),
        (-22.0, 0.0),
    ];
    rings.extend(top.map(|(outset_mm, z_mm)| Outline::top(outset_mm).ring(z_mm)));
    skinned(&rings, CAP_RINGS)
}

/// Rings at some parts of the way from one to another.
fn between(from: &[Vec3], to: &[Vec3], parts: &[f64]) -> Vec<Vec<Vec3>> {
    let at = |t: &f64| from.iter().zip(to).map(|(a, b)| a.between(*b, *t)).collect();
    parts.iter().map(at).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::checks::assert_sound_metal;

    #[test]
    fn the_top_is_at_zero_and_runs_to_the_feet() {
        let (low, high) =
            (vec3(-HALF_WIDTH_MM, -LENGTH_MM, 0.0), vec3(HALF_WIDTH_MM, 0.0, BASE_Z_MM[1]));
        assert_sound_metal(&operating_table(), low, high, 0.1);
    }
}
