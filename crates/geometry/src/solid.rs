//! Small solids that glyphs are made of: outlines turned around an axis, spheres, arrows.

use super::bounds::Bounds;
use super::rotation::perpendicular;
use nalgebra::{Matrix3, Point3, Unit, Vector3};
use std::f64::consts::{PI, TAU};

/// Sides of what is turned, and of arrows, which are many.
const SIDES: u32 = 28;
const ARROW_SIDES: u32 = 16;

/// Rings of a sphere from pole to pole.
const RINGS: u32 = 16;

/// Windings of a coil.
const WINDINGS: u32 = 7;

/// Triangles with their normals, outward; counter-clockwise seen from outside.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Solid {
    pub positions_mm: Vec<Point3<f64>>,
    /// One a position, unit length.
    pub normals: Vec<Vector3<f64>>,
    pub triangles: Vec<[u32; 3]>,
}

/// How thick an arrow is, and how long it may get.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ArrowSize {
    pub shaft_mm: f64,
    pub head_width_mm: f64,
    pub head_length_mm: f64,
    /// Longer arrows are cut here and end in two heads.
    pub most_mm: f64,
}

impl Solid {
    /// A bobbin along z, one long and one across, centred: collars at both ends and the windings
    /// between them.
    pub fn coil() -> Self {
        let mut outline = vec![[0.0, -0.5], [0.5, -0.5], [0.5, -0.42]];
        for i in 0..WINDINGS {
            let from = -0.42 + 0.84 * f64::from(i) / f64::from(WINDINGS);
            let step = 0.84 / f64::from(WINDINGS);
            outline.extend([
                [0.36, from + 0.04 * step],
                [0.43, from + 0.5 * step],
                [0.36, from + 0.96 * step],
            ]);
        }
        outline.extend([[0.5, 0.42], [0.5, 0.5], [0.0, 0.5]]);
        Self::turned(&outline)
    }

    /// Along z, one long and one across, centred.
    pub fn cylinder() -> Self {
        Self::turned(&[[0.0, -0.5], [0.5, -0.5], [0.5, 0.5], [0.0, 0.5]])
    }

    /// Along z, one across its base at 0, its point at 1.
    pub fn cone() -> Self {
        Self::turned(&[[0.0, 0.0], [0.5, 0.0], [0.0, 1.0]])
    }

    /// About the origin.
    pub fn sphere(radius_mm: f64) -> Self {
        let mut sphere = Self::default();
        for ring in 0..=RINGS {
            let (sine, height) = (PI * f64::from(ring) / f64::from(RINGS)).sin_cos();
            for side in 0..=SIDES {
                let (y, x) = (TAU * f64::from(side) / f64::from(SIDES)).sin_cos();
                let out = Vector3::new(sine * x, sine * y, height);
                sphere.positions_mm.push(Point3::from(out * radius_mm));
                sphere.normals.push(out);
            }
        }
        let row = SIDES + 1;
        for ring in 0..RINGS {
            for side in 0..SIDES {
                let a = ring * row + side;
                if ring > 0 {
                    sphere.triangles.push([a, a + row, a + 1]);
                }
                if ring + 1 < RINGS {
                    sphere.triangles.push([a + 1, a + row, a + row + 1]);
                }
            }
        }
        sphere
    }

    /// Turns an outline of `[radius, z]`, from the lower to the upper end, around z; flat-shaded
    /// along the outline, smooth around it.
    pub fn turned(outline: &[[f64; 2]]) -> Self {
        let mut solid = Self::default();
        for pair in outline.windows(2) {
            let ([r0, z0], [r1, z1]) = (pair[0], pair[1]);
            let (out, up) = (z1 - z0, r0 - r1);
            let base = solid.positions_mm.len() as u32;
            for i in 0..=SIDES {
                let (sine, cosine) = (f64::from(i) / f64::from(SIDES) * TAU).sin_cos();
                let normal = Vector3::new(cosine * out, sine * out, up).normalize();
                for (r, z) in [(r0, z0), (r1, z1)] {
                    solid.positions_mm.push(Point3::new(cosine * r, sine * r, z));
                    solid.normals.push(normal);
                }
            }
            for i in 0..SIDES {
                let a = base + 2 * i;
                if r0 > 0.0 {
                    solid.triangles.push([a, a + 2, a + 1]);
                }
                if r1 > 0.0 {
                    solid.triangles.push([a + 1, a + 2, a + 3]);
                }
            }
        }
        solid
    }

    /// A box with its six sides.
    pub fn cuboid(bounds: &Bounds) -> Self {
        let mut solid = Self::default();
        let (size_mm, corner) = (bounds.size_mm(), bounds.min_mm);
        for axis in 0..3 {
            for side in [0.0, 1.0] {
                let [mut u, mut v] =
                    [(axis + 1) % 3, (axis + 2) % 3].map(|k| Vector3::ith(k, size_mm[k]));
                if side == 0.0 {
                    std::mem::swap(&mut u, &mut v);
                }
                let from = corner + Vector3::ith(axis, side * size_mm[axis]);
                let base = solid.positions_mm.len() as u32;
                solid.positions_mm.extend([from, from + u, from + u + v, from + v]);
                solid.normals.extend([Vector3::ith(axis, 2.0 * side - 1.0); 4]);
                solid.triangles.extend([[base, base + 1, base + 2], [base, base + 2, base + 3]]);
            }
        }
        solid
    }

    /// Adds a tube around a line through points, open at both ends, with a ball where it bends.
    pub fn push_tube(&mut self, points_mm: &[Point3<f64>], radius_mm: f64) {
        let piece = Self::turned(&[[1.0, 0.0], [1.0, 1.0]]);
        for pair in points_mm.windows(2) {
            let along = pair[1] - pair[0];
            let Some(z) = Unit::try_new(along, 0.0) else { continue };
            let x = perpendicular(&z);
            let turn = Matrix3::from_columns(&[*x, z.cross(&x), *z]);
            let scale = Vector3::new(radius_mm, radius_mm, along.norm());
            let place = |p: &Point3<f64>| pair[0] + turn * p.coords.component_mul(&scale);
            self.push(&piece, place, |n| turn * n);
        }
        let bends = points_mm.get(1..points_mm.len().saturating_sub(1)).unwrap_or_default();
        for bend in bends {
            self.push(&Self::sphere(radius_mm), |p| bend + p.coords, |n| *n);
        }
    }

    /// Adds an arrow from a point; none where the vector has no direction.
    pub fn push_arrow(
        &mut self,
        start_mm: &Point3<f64>,
        vector_mm: &Vector3<f64>,
        size: &ArrowSize,
    ) {
        let whole = vector_mm.norm();
        let Some(axis) = Unit::try_new(*vector_mm, 0.0).filter(|_| whole.is_finite()) else {
            return;
        };
        let length = whole.min(size.most_mm);
        let end = start_mm + axis.into_inner() * length;
        // A short arrow is all head, in proportion.
        let head = size.head_length_mm.min(length);
        let shrink = head / size.head_length_mm;
        let head_radius = size.head_width_mm / 2.0 * shrink;
        let shaft_radius = size.shaft_mm / 2.0 * shrink;
        let neck = start_mm + axis.into_inner() * (length - head);
        if length < whole {
            let second = axis.into_inner() * (0.8 * head);
            self.push_cone([neck - second, neck - second], &axis, [shaft_radius, head_radius]);
            self.push_cone([neck - second, end - second], &axis, [head_radius, 0.0]);
        }
        self.push_cone([*start_mm, neck], &axis, [0.0, shaft_radius]);
        self.push_cone([*start_mm, neck], &axis, [shaft_radius, shaft_radius]);
        self.push_cone([neck, neck], &axis, [shaft_radius, head_radius]);
        self.push_cone([neck, end], &axis, [head_radius, 0.0]);
    }

    /// Adds a piece of a cone between two radii; between growing ones a disc at its start that
    /// faces backwards, which from radius 0 closes the start.
    fn push_cone(
        &mut self,
        [from, to]: [Point3<f64>; 2],
        axis: &Unit<Vector3<f64>>,
        [r0, r1]: [f64; 2],
    ) {
        let is_disc = r0 < r1;
        let to = if is_disc { from } else { to };
        let length = (to - from).norm();
        let x = perpendicular(axis);
        let y = axis.cross(&x);
        let base = self.positions_mm.len() as u32;
        for i in 0..=ARROW_SIDES {
            let (sine, cosine) = (f64::from(i) / f64::from(ARROW_SIDES) * TAU).sin_cos();
            let out = x.into_inner() * cosine + y * sine;
            let normal = if is_disc {
                -axis.into_inner()
            } else {
                (out * length + axis.into_inner() * (r0 - r1)).normalize()
            };
            self.positions_mm.extend([from + out * r0, to + out * r1]);
            self.normals.extend([normal, normal]);
        }
        for i in 0..ARROW_SIDES {
            let a = base + 2 * i;
            self.triangles.extend([[a, a + 2, a + 1], [a + 1, a + 2, a + 3]]);
        }
    }

    /// Adds another solid, its points and normals moved.
    pub fn push(
        &mut self,
        other: &Self,
        point: impl Fn(&Point3<f64>) -> Point3<f64>,
        normal: impl Fn(&Vector3<f64>) -> Vector3<f64>,
    ) {
        let base = self.positions_mm.len() as u32;
        self.positions_mm.extend(other.positions_mm.iter().map(point));
        self.normals.extend(other.normals.iter().map(normal));
        let triangles = other.triangles.iter();
        self.triangles.extend(triangles.map(|corners| corners.map(|corner| corner + base)));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Of the triangles, in mm³: positive where they are seen from outside.
    fn volume_mm3(solid: &Solid) -> f64 {
        let corner = |i: u32| solid.positions_mm[i as usize].coords;
        let of = |[a, b, c]: &[u32; 3]| corner(*a).dot(&corner(*b).cross(&corner(*c))) / 6.0;
        solid.triangles.iter().map(of).sum()
    }

    /// Area of a regular polygon over that of its circle.
    fn polygon(sides: u32) -> f64 {
        let angle = TAU / f64::from(sides);
        angle.sin() / angle
    }

    #[test]
    fn solids_are_closed_and_show_their_outside() {
        let turned = polygon(SIDES);
        let quarter = PI / 4.0 * turned;
        assert!((volume_mm3(&Solid::cylinder()) - quarter).abs() < 1e-12);
        assert!((volume_mm3(&Solid::cone()) - quarter / 3.0).abs() < 1e-12);
        let ball = volume_mm3(&Solid::sphere(3.0)) / (4.0 / 3.0 * PI * 27.0);
        // Rings of 11.25 degrees take 1 % off, sides of 12.9 degrees another 0.8 %.
        assert!((0.97..0.99).contains(&ball), "{ball}");
    }

    #[test]
    fn an_arrow_reaches_its_end_or_is_cut() {
        let size =
            ArrowSize { shaft_mm: 1.0, head_width_mm: 3.0, head_length_mm: 4.0, most_mm: 50.0 };
        let start = Point3::new(1.0, 2.0, 3.0);
        for (length, reach) in [(2.0, 2.0), (30.0, 30.0), (80.0, 50.0)] {
            let along = Vector3::new(2.0, -1.0, 2.0) / 3.0;
            let mut arrow = Solid::default();
            arrow.push_arrow(&start, &(along * length), &size);
            let heights = arrow.positions_mm.iter().map(|p| (p - start).dot(&along));
            let (low, high) = heights.fold((f64::MAX, f64::MIN), |(a, b), h| (a.min(h), b.max(h)));
            assert!((low.abs() < 1e-12) && (high - reach).abs() < 1e-12, "{length}");
            assert!(volume_mm3(&arrow) > 0.0);
        }
        let mut none = Solid::default();
        none.push_arrow(&start, &Vector3::zeros(), &size);
        none.push_arrow(&start, &Vector3::repeat(f64::NAN), &size);
        assert_eq!(none, Solid::default());
    }

    #[test]
    fn a_cuboid_is_seen_from_outside() {
        let bounds = Bounds::from(([1.0, 2.0, 3.0], [3.0, 5.0, 7.0]));
        let solid = Solid::cuboid(&bounds);
        assert!((volume_mm3(&solid) - 24.0).abs() < 1e-12);
        assert_eq!(Bounds::around(solid.positions_mm.iter().copied()), Some(bounds));
        for triangle in &solid.triangles {
            let [a, b, c] = triangle.map(|i| solid.positions_mm[i as usize]);
            let own = (b - a).cross(&(c - a)).normalize();
            assert!((own - solid.normals[triangle[0] as usize]).norm() < 1e-12);
        }
    }

    #[test]
    fn a_tube_is_at_its_radius_from_the_line() {
        const RADIUS_MM: f64 = 0.5;
        let points = [[0.0, 0.0, 0.0], [0.0, 0.0, 10.0], [6.0, 0.0, 18.0]].map(Point3::from);
        let mut solid = Solid::default();
        solid.push_tube(&points, RADIUS_MM);
        let off = |at: &Point3<f64>| {
            let pieces = points.windows(2).map(|pair| {
                let along = pair[1] - pair[0];
                let part = (at - pair[0]).dot(&along) / along.norm_squared();
                (at - (pair[0] + along * part.clamp(0.0, 1.0))).norm()
            });
            pieces.fold(f64::INFINITY, f64::min)
        };
        for at in &solid.positions_mm {
            assert!(off(at) <= RADIUS_MM + 1e-9, "{at}");
        }
        // Its end stands square on the line.
        assert!(
            solid.positions_mm.iter().any(|at| at.z == 0.0 && (off(at) - RADIUS_MM).abs() < 1e-9)
        );
        let mut none = Solid::default();
        none.push_tube(&points[..1], RADIUS_MM);
        none.push_tube(&[], RADIUS_MM);
        assert!(none.triangles.is_empty());
    }
}
