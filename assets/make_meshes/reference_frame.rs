//! The coordinate reference frame (CRF) worn on the forehead, and the head that wears it.
//!
//! The origin is where the pad's underside touches the forehead; axes as in `head`.

use std::f64::consts::TAU;

use crate::head::Head;
use crate::implicit::Solid;
use crate::model::{Model, Part, materials};
use crate::pod::Pod;
use crate::profile::{Corner, RoundedRectangle, at, rounded, skinned, skinned_loop};
use crate::shape::Shape;
use crate::vector::{Placement, Vec3, vec3};

const PLATE_HALF_WIDTH_MM: f64 = 23.0;
const PLATE_HALF_HEIGHT_MM: f64 = 15.0;
const PAD_THICKNESS_MM: f64 = 2.2;
const PLATE_THICKNESS_MM: f64 = 2.6;
/// Height of the plate's outer face above the skin: where the housings stand.
const PLATE_TOP_MM: f64 = PAD_THICKNESS_MM + PLATE_THICKNESS_MM;

/// Where a housing stands on the plate, and the angle of its coil's axis from +x towards +y.
///
/// A triangle as wide as the plate allows; axes 60 degrees apart, so that no two are parallel.
pub const HOUSINGS_MM_DEG: [([f64; 2], f64); 3] =
    [([13.5, -6.2], 60.0), ([-13.5, -6.2], -60.0), ([0.0, 8.4], 0.0)];
const HOUSING_LENGTH_MM: f64 = 13.0;
const HOUSING_WIDTH_MM: f64 = 6.4;
const HOUSING_HEIGHT_MM: f64 = 4.8;
/// The foot's rim sinks into the plate, so that no gap shows.
const HOUSING_SINK_MM: f64 = 0.1;

const STRAP_HALF_WIDTH_MM: f64 = 9.0;
const STRAP_THICKNESS_MM: f64 = 1.7;
const STRAP_STATIONS: usize = 120;
/// The strap sinks this far into the skin, so that no gap shows between its straight pieces.
const STRAP_SINK_MM: f64 = 0.6;

pub fn head_crf() -> Model {
    let head = Head::new();
    Model {
        name: "head-crf",
        parts: vec![
            Part::new("crf-plate", materials::TEAL, plate(&head)),
            Part::new("crf-pad", materials::PAD, pad(&head)),
            Part::new("crf-housings", materials::DARK_TEAL, housings(&head)),
            Part::new("crf-strap", materials::FABRIC, strap(&head)),
            Part::new("anatomy-head", materials::BONE, head.shape()),
        ],
    }
}

fn plate(head: &Head) -> Shape {
    let corners = [
        at(PAD_THICKNESS_MM - 0.2, -3.0, 0.0),
        at(PAD_THICKNESS_MM - 0.2, 0.0, 0.7),
        at(PLATE_TOP_MM, 0.0, 1.4),
        at(PLATE_TOP_MM, -3.0, 0.0),
    ];
    plate_moulding(head, &corners)
}

fn pad(head: &Head) -> Shape {
    let corners = [at(0.0, -5.0, 0.0), at(0.0, -1.2, 0.6), at(PAD_THICKNESS_MM, -1.2, 0.0)];
    plate_moulding(head, &corners)
}

/// A flat moulding with the plate's outline, laid onto the forehead.
fn plate_moulding(head: &Head, corners: &[Corner]) -> Shape {
    let outline = RoundedRectangle {
        half_width_mm: PLATE_HALF_WIDTH_MM,
        half_height_mm: PLATE_HALF_HEIGHT_MM,
        corner_mm: 10.0,
        corner_pieces: 8,
        side_pieces: [8, 5],
    };
    let ring = |&[height_mm, outset_mm]: &[f64; 2]| {
        let lift = |&[x, y]: &[f64; 2]| vec3(x, y, height_mm);
        outline.outline(outset_mm).iter().map(lift).collect::<Vec<_>>()
    };
    let rings: Vec<Vec<Vec3>> = rounded(corners).iter().map(ring).collect();
    on_forehead(head, skinned(&rings, 5))
}

/// The three sensor housings, bent with the plate.
fn housings(head: &Head) -> Shape {
    let housing = |&([x_mm, y_mm], angle_deg): &([f64; 2], f64)| {
        let (sin, cos) = angle_deg.to_radians().sin_cos();
        let foot = vec3(x_mm, -y_mm, PLATE_TOP_MM - HOUSING_SINK_MM);
        let pod = Pod {
            placement: Placement::new(foot, Vec3::z(), vec3(cos, -sin, 0.0)),
            length_mm: HOUSING_LENGTH_MM,
            width_mm: HOUSING_WIDTH_MM,
            height_mm: HOUSING_HEIGHT_MM,
            edge_mm: 1.9,
            foot_mm: 1.1,
        };
        on_forehead(head, pod.shape())
    };
    HOUSINGS_MM_DEG.iter().map(housing).fold(Shape::default(), Shape::and)
}

/// Lays a flat part onto the skin: its heights become heights above the skin, along -z.
///
/// y is mirrored along with z, so that outsides stay outside.
fn on_forehead(head: &Head, flat: Shape) -> Shape {
    flat.mapped(|point| skin_point(head, point.x, -point.y) - Vec3::z() * point.z)
}

/// A band around the head, lying on the skin, that runs under the plate into the pad.
fn strap(head: &Head) -> Shape {
    /// The band's section: `[across, height]` as fractions of its half width and its thickness.
    const SECTION: [[f64; 2]; 12] = [
        [-0.93, 0.0],
        [0.0, 0.0],
        [0.93, 0.0],
        [0.99, 0.15],
        [1.0, 0.5],
        [0.99, 0.78],
        [0.93, 1.0],
        [0.4, 1.0],
        [-0.4, 1.0],
        [-0.93, 1.0],
        [-0.99, 0.78],
        [-1.0, 0.3],
    ];
    let rings: Vec<Vec<Vec3>> = (0..STRAP_STATIONS)
        .map(|station| {
            let turn = station as f64 / STRAP_STATIONS as f64 * TAU;
            let (sin, cos) = turn.sin_cos();
            let inwards = vec3(-sin, 0.0, cos);
            let point = |&[across, height]: &[f64; 2]| {
                let y_mm = across * STRAP_HALF_WIDTH_MM + strap_y_mm(cos);
                let from = vec3(0.0, y_mm, STRAP_AXIS_Z_MM) - inwards * 150.0;
                let reach_mm = head.first_hit_mm(from, inwards, 150.0).unwrap_or(150.0);
                let skin = from + inwards * reach_mm;
                let height_mm = height * (STRAP_THICKNESS_MM + STRAP_SINK_MM) - STRAP_SINK_MM;
                skin + head.outward(skin) * height_mm
            };
            // From front to right to back the stations run clockwise seen from above.
            SECTION.iter().rev().map(point).collect()
        })
        .collect();
    skinned_loop(&rings)
}

/// The strap is laid out around a vertical axis through the middle of the skull.
const STRAP_AXIS_Z_MM: f64 = 95.0;

/// Level on the forehead, a little lower where it holds on the back of the head.
fn strap_y_mm(cos_turn: f64) -> f64 {
    const BACK_DROP_MM: f64 = 8.0;
    -BACK_DROP_MM * (1.0 - cos_turn) / 2.0
}

/// The skin in front of a point of the plate's plane.
fn skin_point(head: &Head, x_mm: f64, y_mm: f64) -> Vec3 {
    const IN_FRONT_MM: f64 = 40.0;
    let from = vec3(x_mm, y_mm, -IN_FRONT_MM);
    let reach_mm = head.first_hit_mm(from, Vec3::z(), 2.0 * IN_FRONT_MM).unwrap_or(IN_FRONT_MM);
    from + Vec3::z() * reach_mm
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::checks::assert_sound;

    #[test]
    fn head_and_frame_fit_their_bounds() {
        let model = head_crf();
        assert_sound(&model, vec3(-82.7, -190.0, -13.2), vec3(82.7, 82.8, 188.8), 0.5);
        let head = &model.parts[4];
        assert!(head.name.starts_with("anatomy") && head.shape.triangles.len() <= 15_000);
    }

    #[test]
    fn the_pad_touches_the_skin_at_the_origin() {
        let pad = pad(&Head::new());
        let nearest_mm = pad.points.iter().map(|point| point.norm());
        assert!(nearest_mm.fold(f64::INFINITY, f64::min) < 1e-6);
    }

    #[test]
    fn every_coil_fits_its_housing() {
        /// A coil's axis above its housing's foot.
        const COIL_HEIGHT_MM: f64 = 1.9;
        const COIL_LENGTH_MM: f64 = 9.0;
        const COIL_RADIUS_MM: f64 = 0.9;
        const WALL_MM: f64 = 0.6;
        const { assert!(HOUSING_LENGTH_MM - COIL_LENGTH_MM > 2.0 * WALL_MM) };
        const { assert!(COIL_HEIGHT_MM - COIL_RADIUS_MM > 0.0) };
        const { assert!(COIL_HEIGHT_MM + COIL_RADIUS_MM + WALL_MM < HOUSING_HEIGHT_MM) };
        let head = Head::new();
        for ([x_mm, y_mm], angle_deg) in HOUSINGS_MM_DEG {
            let skin = skin_point(&head, x_mm, y_mm);
            let coil = skin - Vec3::z() * (PLATE_TOP_MM - HOUSING_SINK_MM + COIL_HEIGHT_MM);
            let (sin, cos) = angle_deg.to_radians().sin_cos();
            let axis = Placement::new(coil, head.outward(skin), vec3(cos, sin, 0.0)).x_axis;
            // Both ends stay below the housing's roof and above the skin.
            for end in [COIL_LENGTH_MM / 2.0, -COIL_LENGTH_MM / 2.0].map(|mm| coil + axis * mm) {
                let height_mm = skin_point(&head, end.x, end.y).z - end.z;
                assert!(height_mm > PAD_THICKNESS_MM + COIL_RADIUS_MM);
                assert!(height_mm + COIL_RADIUS_MM < PLATE_TOP_MM + HOUSING_HEIGHT_MM - WALL_MM);
            }
        }
    }
}
