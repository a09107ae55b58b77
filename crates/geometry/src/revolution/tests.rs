//! Needles whose axis is known: turned at random, coarse, open, slanted, with vertices twice.

use super::*;
use crate::placeholder::placeholder;
use crate::surface::tests::cylinder;
use nalgebra::UnitQuaternion;
use std::f64::consts::TAU;

/// What the axis of a shaft has to be found to.
const TOLERANCE_RAD: f64 = 0.01 * std::f64::consts::PI / 180.0;

type Triangle = [Point3<f64>; 3];

/// A needle along z from a slanted tip around the origin to `length_mm`, each corner computed for
/// each triangle by itself. `profile` gives its radius.
#[derive(Clone, Copy)]
struct Needle {
    sides: u32,
    rings: u32,
    length_mm: f64,
    radius_mm: f64,
    /// Slope of the tip against the plane across.
    slant: f64,
    /// Radius at the end over that at the tip.
    taper: f64,
    has_ends: bool,
}

const ROUND: Needle = Needle {
    sides: 24,
    rings: 8,
    length_mm: 120.0,
    radius_mm: 1.0,
    slant: 3.0,
    taper: 1.0,
    has_ends: true,
};

impl Needle {
    fn corner(&self, ring: u32, side: u32) -> Point3<f64> {
        let part = f64::from(ring) / f64::from(self.rings);
        let radius = self.radius_mm * (1.0 + (self.taper - 1.0) * part);
        // Not the same angle to the bit, as a CAD program computes the seam.
        let (y, x) = (f64::from(side) / f64::from(self.sides) * TAU).sin_cos();
        let slant = if ring == 0 { self.slant * x * radius } else { 0.0 };
        Point3::new(x * radius, y * radius, self.length_mm * part + slant)
    }

    fn triangles(&self) -> Vec<Triangle> {
        let mut triangles = Vec::new();
        for side in 0..self.sides {
            for ring in 0..self.rings {
                let [a, b] = [side, side + 1].map(|side| self.corner(ring, side));
                let [d, c] = [side, side + 1].map(|side| self.corner(ring + 1, side));
                triangles.extend([[a, b, c], [a, c, d]]);
            }
            if self.has_ends {
                let end = self.rings;
                let [tip, top] = [0.0, self.length_mm].map(|z| Point3::new(0.0, 0.0, z));
                triangles.extend([
                    [tip, self.corner(0, side + 1), self.corner(0, side)],
                    [top, self.corner(end, side), self.corner(end, side + 1)],
                ]);
            }
        }
        triangles
    }
}

/// Numbers from -1 to 1, the same each time.
fn random(state: u64) -> impl FnMut() -> f64 {
    let mut half = crate::surface::tests::random(state);
    move || 2.0 * half()
}

/// The axis that is found of a needle that is moved at random, against the true one.
fn assert_found(triangles: &[Triangle], seed: u64, what: &str) {
    let mut next = random(seed);
    let turn = UnitQuaternion::from_scaled_axis(Vector3::new(next(), next(), next()) * 3.0);
    let shift = Vector3::new(next(), next(), next()) * 200.0;
    let moved: Vec<Triangle> =
        triangles.iter().map(|t| t.map(|corner| turn * corner + shift)).collect();
    let axis = RevolutionAxis::of(&moved).unwrap_or_else(|| panic!("{what}, {seed}: no axis"));
    let off_rad = axis.direction.cross(&(turn * Vector3::z())).norm();
    assert!(off_rad < TOLERANCE_RAD, "{what}, {seed}: {}°", off_rad.to_degrees());
    let off_mm = axis.arm_mm(&Point3::from(shift)).norm();
    assert!(off_mm < 0.02, "{what}, {seed}: {off_mm} mm beside the axis");
}

#[test]
fn the_axis_of_a_needle_is_found_however_it_is_turned() {
    for seed in 0..12 {
        assert_found(&ROUND.triangles(), seed, "round");
        assert_found(&cylinder_triangles(), seed, "cylinder");
    }
}

fn cylinder_triangles() -> Vec<Triangle> {
    let mesh = cylinder(2.0, 150.0, 96);
    let part = &mesh.parts[0];
    (0..part.triangles.len()).map(|triangle| part.corners_mm(triangle)).collect()
}

#[test]
fn the_axis_of_a_coarse_needle_is_found() {
    for sides in [5, 6, 7, 12] {
        for rings in [1, 3] {
            let needle = Needle { sides, rings, ..ROUND };
            for seed in 0..4 {
                assert_found(&needle.triangles(), seed, &format!("{sides} sides, {rings} rings"));
            }
        }
    }
}

#[test]
fn the_axis_of_an_open_needle_is_found() {
    for sides in [6, 24] {
        let open = Needle { sides, has_ends: false, ..ROUND };
        for seed in 0..6 {
            let mut triangles = open.triangles();
            // Holes: one triangle in eight.
            let mut next = random(seed + 100);
            triangles.retain(|_| next() > -0.75);
            assert_found(&triangles, seed, &format!("open, {sides} sides"));
        }
    }
}

#[test]
fn a_slanted_tip_does_not_tilt_the_axis() {
    for slant in [0.0, 1.0, 3.0, 6.0] {
        for (sides, length_mm) in [(6, 40.0), (32, 40.0), (32, 15.0)] {
            let needle = Needle { sides, slant, length_mm, ..ROUND };
            let what = format!("slant {slant}, {sides} sides, {length_mm} mm");
            assert_found(&needle.triangles(), 3, &what);
        }
    }
}

#[test]
fn the_axis_of_a_cone_is_found() {
    for taper in [0.5, 2.0] {
        for (sides, has_ends) in [(6, true), (6, false), (48, true), (48, false)] {
            let needle = Needle { sides, taper, slant: 0.0, has_ends, ..ROUND };
            for seed in 0..4 {
                let what = format!("taper {taper}, {sides} sides, ends {has_ends}");
                assert_found(&needle.triangles(), seed, &what);
            }
        }
    }
}

#[test]
fn vertices_that_are_there_twice_do_not_matter() {
    for seed in 0..4 {
        let mut next = random(seed + 50);
        let mut triangles = Needle { sides: 6, ..ROUND }.triangles();
        for corner in triangles.iter_mut().flatten() {
            *corner += Vector3::new(next(), next(), next()) * 1e-16;
        }
        // Triangles without an area between them.
        let slivers: Vec<Triangle> = triangles.iter().map(|[a, b, _]| [*a, *b, *a]).collect();
        triangles.extend(slivers);
        assert_found(&triangles, seed, "twice");
    }
}

#[test]
fn a_handle_to_one_side_does_not_tilt_the_axis() {
    let mut triangles = ROUND.triangles();
    // A block on the end, of a quarter of the needle's surface.
    let block = Needle { sides: 4, rings: 1, length_mm: 14.0, radius_mm: 3.0, slant: 0.0, ..ROUND };
    let tilted = UnitQuaternion::from_euler_angles(0.6, 0.3, 0.2);
    let at = Vector3::new(4.0, 1.0, 105.0);
    let on_side = block.triangles().into_iter().map(|t| t.map(|corner| tilted * corner + at));
    triangles.extend(on_side);
    for seed in 0..4 {
        assert_found(&triangles, seed, "handle");
    }
}

#[test]
fn an_axis_of_the_frame_is_exact() {
    // Corners as an STL file has them.
    let in_f32 = |t: Triangle| t.map(|corner| corner.map(|v| f64::from(v as f32)));
    let triangles: Vec<Triangle> = ROUND.triangles().into_iter().map(in_f32).collect();
    let axis = RevolutionAxis::of(&triangles).unwrap().towards(&Vector3::z());
    assert_eq!(axis.direction, Vector3::z_axis());
    assert_eq!(axis.towards(&-Vector3::z()).direction, -Vector3::z_axis());
}

#[test]
fn what_is_of_no_revolution_has_no_axis() {
    assert_eq!(RevolutionAxis::of(&[]), None);
    let ball = crate::solid::Solid::sphere(5.0);
    let corner = |i: u32| ball.positions_mm[i as usize];
    let ball: Vec<Triangle> = ball.triangles.iter().map(|t| t.map(corner)).collect();
    assert_eq!(RevolutionAxis::of(&ball), None, "a ball has many");
    // Three rods that meet in a point.
    let ends = [Vector3::x(), Vector3::y(), Vector3::z()].map(|end| Point3::from(end * 60.0));
    let star = placeholder(&Point3::origin(), &ends);
    let triangles: Vec<Triangle> = star
        .parts
        .iter()
        .flat_map(|part| (0..part.triangles.len()).map(|triangle| part.corners_mm(triangle)))
        .collect();
    assert_eq!(RevolutionAxis::of(&triangles), None, "three rods");
    let nan = [Point3::new(f64::NAN, 0.0, 0.0); 3];
    assert_eq!(RevolutionAxis::of(&[nan]), None);
}
