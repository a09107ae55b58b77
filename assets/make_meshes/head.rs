//! A calm, mannequin-like head: one implicit solid, symmetric about x = 0.
//!
//! Axes as in the reference frame: -z out of the face, +y to the crown, +x to the patient's right.
//! The origin is on the skin in the middle of the forehead.

use crate::implicit::{Solid, capsule, common, ellipsoid, grid_lines, meshed, union, without};
use crate::shape::Shape;
use crate::vector::{Placement, Vec3, vec3};

/// Where the neck is cut.
pub const NECK_END_Y_MM: f64 = -190.0;

/// The head, moved along z so that its forehead passes through the origin.
#[derive(Clone, Copy, Debug)]
pub struct Head {
    forehead_z_mm: f64,
}

impl Head {
    pub fn new() -> Self {
        const WELL_OUTSIDE_MM: f64 = 60.0;
        let unshifted = Self { forehead_z_mm: 0.0 };
        let origin = vec3(0.0, 0.0, -WELL_OUTSIDE_MM);
        let hit = unshifted.first_hit_mm(origin, Vec3::z(), 2.0 * WELL_OUTSIDE_MM);
        Self { forehead_z_mm: hit.map_or(0.0, |mm| mm - WELL_OUTSIDE_MM) }
    }

    /// The skin: fine lines across the face and the ears, wide ones over the skull.
    pub fn shape(&self) -> Shape {
        let half_x = [(0.0, 3.6), (26.0, 6.2), (64.0, 4.0)];
        let right = grid_lines(&half_x, 96.0);
        let left = right.iter().skip(1).rev().map(|x| -x);
        let xs: Vec<f64> = left.chain(right.iter().copied()).collect();
        let ys = grid_lines(
            &[
                (-196.0, 3.4),
                (-176.0, 10.5),
                (-142.0, 4.4),
                (-106.0, 3.0),
                (-88.0, 4.0),
                (-16.0, 6.5),
                (6.0, 9.5),
            ],
            98.0,
        );
        let zs = grid_lines(&[(-34.0, 3.7), (24.0, 7.2), (84.0, 4.6), (128.0, 10.0)], 210.0);
        meshed(self, [&xs, &ys, &zs])
    }
}

impl Solid for Head {
    fn value_mm(&self, point: Vec3) -> f64 {
        // Everything is modelled on the patient's right and mirrored.
        let p = vec3(point.x.abs(), point.y, point.z + self.forehead_z_mm);
        let head = union(skull(p), face(p), 26.0);
        let head = with_eyes(p, head);
        let head = union(head, nose(p), 9.0);
        let head = with_mouth(p, head);
        let head = union(head, neck(p), 24.0);
        with_ear(p, head)
    }
}

fn skull(p: Vec3) -> f64 {
    let back = ellipsoid(p, vec3(0.0, 6.0, 106.0), vec3(73.0, 75.0, 81.0));
    let front = ellipsoid(p, vec3(0.0, 2.0, 72.0), vec3(64.0, 70.0, 72.0));
    // As broad as the ears are apart: without it they would stand off the head.
    let base = ellipsoid(p, vec3(0.0, -46.0, 97.0), vec3(68.0, 56.0, 46.0));
    union(union(back, front, 40.0), base, 30.0)
}

fn face(p: Vec3) -> f64 {
    let mid = ellipsoid(p, vec3(0.0, -58.0, 66.0), vec3(58.0, 60.0, 61.0));
    let cheekbone =
        mirrored(p, 20.0, |p| ellipsoid(p, vec3(37.0, -58.0, 36.0), vec3(20.0, 16.0, 20.0)));
    let cheek =
        mirrored(p, 20.0, |p| ellipsoid(p, vec3(30.0, -84.0, 46.0), vec3(22.0, 26.0, 28.0)));
    let jaw = mirrored(p, 20.0, |p| {
        capsule(p, [vec3(44.0, -86.0, 82.0), vec3(13.0, -119.0, 31.0)], [16.0, 13.0])
    });
    let muzzle = ellipsoid(p, vec3(0.0, -93.0, 34.0), vec3(32.0, 28.0, 30.0));
    let chin = ellipsoid(p, vec3(0.0, -120.0, 25.0), vec3(17.0, 13.0, 15.0));
    let lower = union(union(jaw, muzzle, 26.0), chin, 18.0);
    union(union(mid, union(cheekbone, cheek, 30.0), 26.0), lower, 26.0)
}

/// Brow, sockets, and closed lids over the eyeballs.
fn with_eyes(p: Vec3, head: f64) -> f64 {
    let brow = mirrored(p, 14.0, |p| {
        capsule(p, [vec3(9.0, -25.0, 11.5), vec3(40.0, -23.0, 23.0)], [7.4, 7.0])
    });
    let head = union(head, brow, 22.0);
    let socket = ellipsoid(p, vec3(31.5, -40.0, 4.0), vec3(16.0, 10.5, 13.0));
    let head = without(head, socket, 14.0);
    let eyeball = ellipsoid(p, vec3(31.0, -41.0, 25.0), vec3(15.0, 10.0, 11.5));
    union(head, eyeball, 9.0)
}

fn nose(p: Vec3) -> f64 {
    let bridge = capsule(p, [vec3(0.0, -33.0, 13.0), vec3(0.0, -70.0, -5.0)], [5.5, 6.5]);
    let tip = ellipsoid(p, vec3(0.0, -72.0, -5.5), vec3(8.5, 7.5, 8.0));
    let wing = mirrored(p, 6.0, |p| ellipsoid(p, vec3(10.5, -76.0, 5.0), vec3(6.5, 6.5, 9.0)));
    let flank = mirrored(p, 8.0, |p| {
        capsule(p, [vec3(5.0, -38.0, 16.0), vec3(10.0, -72.0, 10.0)], [5.0, 7.0])
    });
    union(union(bridge, flank, 10.0), union(tip, wing, 7.0), 8.0)
}

/// Two lips whose narrow blend leaves the line between them.
fn with_mouth(p: Vec3, head: f64) -> f64 {
    let upper = mirrored(p, 8.0, |p| {
        capsule(p, [vec3(4.5, -92.4, 5.2), vec3(22.0, -96.6, 10.6)], [4.2, 2.4])
    });
    let lower = mirrored(p, 8.0, |p| {
        capsule(p, [vec3(0.0, -101.4, 6.2), vec3(21.0, -98.2, 10.8)], [4.9, 2.6])
    });
    union(head, union(upper, lower, 3.0), 8.0)
}

fn neck(p: Vec3) -> f64 {
    let column = capsule(p, [vec3(0.0, -70.0, 110.0), vec3(0.0, -215.0, 122.0)], [46.0, 55.0]);
    let cut = NECK_END_Y_MM - p.y;
    common(column, cut, 24.0)
}

/// A dished disc that leans back and out, with a lobe below.
fn with_ear(p: Vec3, head: f64) -> f64 {
    /// Rounding of the rim: thick enough for the mesh.
    const RIM_MM: f64 = 3.6;
    // Its own axes: z out of the dish, x towards the top.
    let ear =
        Placement::new(vec3(75.0, -50.0, 105.0), vec3(0.88, 0.08, -0.32), vec3(0.0, 1.0, 0.22));
    let q = ear.part_from_body(p);
    let disc = rounded_disc(q - vec3(2.0, 0.0, 0.0), [23.0, 12.5], RIM_MM);
    let lobe = rounded_disc(q - vec3(-20.0, -4.5, 0.0), [7.0, 5.5], RIM_MM);
    let root = ellipsoid(q, vec3(-3.0, -5.0, -9.0), vec3(24.0, 11.0, 13.0));
    let outer = union(union(disc, lobe, 9.0), root, 8.0);
    let dish = ellipsoid(q, vec3(3.0, -1.0, 7.5), vec3(20.0, 10.5, 7.6));
    union(head, without(outer, dish, 6.0), 12.0)
}

/// An elliptical disc in the xy plane, `rim_mm` thick to either side, its rim fully round.
fn rounded_disc(q: Vec3, [half_x, half_y]: [f64; 2], rim_mm: f64) -> f64 {
    /// Makes the ellipsoid a long cylinder, whose distance does not depend on z.
    const LONG_MM: f64 = 1e6;
    let beside = ellipsoid(vec3(q.x, q.y, 0.0), Vec3::default(), vec3(half_x, half_y, LONG_MM));
    // Softened, so that the disc's faces bulge a little into its rim.
    let beside = (beside + (beside * beside + 4.0).sqrt()) / 2.0;
    beside.hypot(q.z) - rim_mm
}

/// A solid given on the right, blended with its mirror image so that no seam shows at x = 0.
fn mirrored(p: Vec3, blend_mm: f64, solid: impl Fn(Vec3) -> f64) -> f64 {
    union(solid(p), solid(vec3(-p.x, p.y, p.z)), blend_mm)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shape::bounds_mm;

    #[test]
    fn the_forehead_passes_through_the_origin() {
        let head = Head::new();
        assert!(head.value_mm(Vec3::default()).abs() < 1e-6);
        assert!(head.outward(Vec3::default()).z < -0.99);
    }

    #[test]
    fn the_head_is_symmetric() {
        let shape = Head::new().shape();
        let (low, high) = bounds_mm(&shape.points);
        assert!((low.x + high.x).abs() < 1e-6);
        let sum = shape.points.iter().fold(0.0, |sum, point| sum + point.x);
        assert!((sum / shape.points.len() as f64).abs() < 1e-6);
    }
}
