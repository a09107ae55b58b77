//! What is inside a surface that encloses something: a shell, or several that overlap.

use super::{NodeContent, Ray, STACK, Surface, Triangle, box_distance_along};
use crate::rotation::perpendicular;
use nalgebra::{Point3, Unit, Vector3};
use rayon::slice::ParallelSliceMut;
use std::f64::consts::TAU;

/// Directions that are looked in, none along an axis or a diagonal that meshes have edges in: a ray
/// through an edge counts it twice, so that two of three decide.
const DIRECTIONS: [[f64; 3]; 3] =
    [[0.367_1, 0.812_3, 0.453_9], [-0.713_7, 0.201_1, 0.671_3], [0.531_9, -0.447_7, 0.718_9]];

/// Directions across an axis in which a bore has to have a wall: what is open along its side by more
/// than this part of a turn is no bore.
pub const BORE_DIRECTIONS: u32 = 24;

/// The first of them, in parts of a step: none then runs to a corner of a round part of as many sides.
const OFF_CORNERS: f64 = 0.381_966;

/// Where a line goes through a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Crossing {
    pub distance_mm: f64,
    /// 1 where it goes in, -1 where it comes out.
    pub step: i32,
}

/// The directions across an axis in which a bore has to have a wall.
pub fn bore_directions(axis: &Unit<Vector3<f64>>) -> impl Iterator<Item = Unit<Vector3<f64>>> {
    (0..BORE_DIRECTIONS).map(|k| bore_direction(axis, k))
}

fn bore_direction(axis: &Unit<Vector3<f64>>, number: u32) -> Unit<Vector3<f64>> {
    let x = perpendicular(axis);
    let y = axis.cross(&x);
    let turn_rad = (f64::from(number) + OFF_CORNERS) / f64::from(BORE_DIRECTIONS) * TAU;
    let (sine, cosine) = turn_rad.sin_cos();
    Unit::new_normalize(*x * cosine + y * sine)
}

impl Surface {
    /// Whether it encloses something: every edge has as many triangles that run along it one way as
    /// the other. Parts may overlap, and triangles without an area count.
    pub fn is_closed(&self) -> bool {
        *self.is_closed.get_or_init(|| {
            let mut edges: Vec<(u32, u32, i32)> = self
                .connected()
                .iter()
                .flat_map(|t| [(t[0], t[1]), (t[1], t[2]), (t[2], t[0])])
                .filter(|(from, to)| from != to)
                .map(|(from, to)| (from.min(to), from.max(to), if from < to { 1 } else { -1 }))
                .collect();
            edges.par_sort_unstable();
            let mut shared = edges.chunk_by(|a, b| (a.0, a.1) == (b.0, b.1));
            shared.all(|edge| edge.iter().map(|(_, _, way)| way).sum::<i32>() == 0)
        })
    }

    /// Whether a point is inside a surface that [is closed](Self::is_closed): in any of its shells,
    /// and not in a hollow of it.
    pub fn contains(&self, point_mm: &Point3<f64>) -> bool {
        let winds = |direction: [f64; 3]| {
            let direction = Unit::new_normalize(Vector3::from(direction));
            let ray = Ray { origin_mm: *point_mm, direction };
            // Out of as many as it is in.
            self.crossings(&ray).iter().map(|crossing| crossing.step).sum::<i32>() != 0
        };
        let [first, second] = [winds(DIRECTIONS[0]), winds(DIRECTIONS[1])];
        if first == second { first } else { winds(DIRECTIONS[2]) }
    }

    /// The parts of a piece of a line that are inside a surface that [is closed](Self::is_closed),
    /// from and to so far along it, in their order.
    pub fn inside_along(&self, ray: &Ray, length_mm: f64) -> Vec<[f64; 2]> {
        let mut crossings = self.crossings(ray);
        crossings.retain(|crossing| crossing.distance_mm < length_mm);
        crossings.sort_by(|a, b| a.distance_mm.total_cmp(&b.distance_mm));
        let places = crossings.iter().map(|crossing| crossing.distance_mm);
        let mut ends: Vec<f64> = [0.0].into_iter().chain(places).chain([length_mm]).collect();
        ends.dedup();
        // Each piece is looked at by itself: a crossing that was counted twice spoils no other.
        let mut parts: Vec<[f64; 2]> = Vec::new();
        for pair in ends.windows(2) {
            let [from, to] = [pair[0], pair[1]];
            if !self.contains(&ray.at(f64::midpoint(from, to))) {
                continue;
            }
            match parts.last_mut() {
                Some(last) if last[1] == from => last[1] = to,
                _ => parts.push([from, to]),
            }
        }
        parts
    }

    /// Whether a point that is outside of the solid is in a bore along an axis: square to the axis the
    /// surface is nearer than `reach_mm` all around. A bore may be open at its ends, not along its side.
    ///
    /// The walls of a tube may be one closed shell, so that its bore is as much outside of the solid as
    /// the room is. Its walls are the difference, and the axis has to be known: from side to side of a
    /// groove there are walls as well.
    pub fn is_bore(
        &self,
        point_mm: &Point3<f64>,
        axis: &Unit<Vector3<f64>>,
        reach_mm: f64,
    ) -> bool {
        let has_wall = |k: u32| {
            let hit = self.hit(&Ray { origin_mm: *point_mm, direction: bore_direction(axis, k) });
            hit.is_some_and(|hit| hit.distance_mm <= reach_mm)
        };
        // Opposite ones one after the other: most points outside have one that is free.
        let half = BORE_DIRECTIONS / 2;
        (0..half).all(|k| has_wall(k) && has_wall(k + half)) && !self.contains(point_mm)
    }

    /// Everywhere the ray meets the surface, from either side.
    pub(super) fn crossings(&self, ray: &Ray) -> Vec<Crossing> {
        let inverse = ray.direction.map(|component| 1.0 / component);
        let mut found = Vec::new();
        let mut stack = Vec::with_capacity(STACK);
        stack.push(0);
        while let Some(index) = stack.pop() {
            let bounds = &self.nodes[index].bounds;
            if box_distance_along(bounds, ray, &inverse, f64::INFINITY).is_infinite() {
                continue;
            }
            match self.nodes[index].content {
                NodeContent::Inner { right } => stack.extend([index + right as usize, index + 1]),
                NodeContent::Leaf { first, len } => {
                    let leaf = self.leaf(first, len).iter();
                    found.extend(leaf.filter_map(|triangle| triangle.crossed_by(ray)));
                }
            }
        }
        found
    }
}

impl Triangle {
    fn crossed_by(&self, ray: &Ray) -> Option<Crossing> {
        let from_front = self.meets(ray).map(|(distance_mm, _)| (distance_mm, 1));
        let from_behind = || {
            let [a, b, c] = self.corners;
            let turned = Self { corners: [a, c, b], normals: self.normals };
            turned.meets(ray).map(|(distance_mm, _)| (distance_mm, -1))
        };
        let (distance_mm, step) = from_front.or_else(from_behind)?;
        Some(Crossing { distance_mm, step })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::SurfaceMesh;
    use crate::surface::tests::cylinder;

    fn moved(mut mesh: SurfaceMesh, by: Vector3<f64>) -> SurfaceMesh {
        for position in mesh.parts.iter_mut().flat_map(|part| &mut part.positions_mm) {
            *position += by;
        }
        mesh
    }

    /// A tube with a bore: the inner shell faces the axis.
    fn tube() -> SurfaceMesh {
        let mut mesh = cylinder(2.0, 100.0, 48);
        let mut bore = moved(cylinder(1.0, 80.0, 48), Vector3::z() * 10.0).parts.remove(0);
        for triangle in &mut bore.triangles {
            triangle.swap(1, 2);
        }
        mesh.parts.push(bore);
        mesh
    }

    #[test]
    fn points_of_a_shaft_are_inside_it() {
        let surface = Surface::new(&cylinder(2.0, 100.0, 48)).unwrap();
        assert!(surface.is_closed());
        for i in 0..400 {
            let t = f64::from(i);
            let point = Point3::new((t * 0.37).sin() * 3.0, (t * 0.71).cos() * 3.0, t * 0.3 - 10.0);
            let radius = point.coords.xy().norm();
            // Not where the chords are.
            if (radius - 2.0).abs() > 0.01 {
                let is_inside = radius < 2.0 && (0.0..=100.0).contains(&point.z);
                assert_eq!(surface.contains(&point), is_inside, "{point}");
            }
        }
        // On the axis, where all triangles of the ends meet.
        assert!(surface.contains(&Point3::new(0.0, 0.0, 50.0)));
    }

    #[test]
    fn shells_that_overlap_are_one_body() {
        let mut mesh = cylinder(2.0, 100.0, 24);
        let collar = moved(cylinder(5.0, 20.0, 24), Vector3::z() * 90.0);
        mesh.parts.extend(collar.parts);
        let surface = Surface::new(&mesh).unwrap();
        assert!(surface.is_closed());
        for (point, is_inside) in [
            ([0.5, 0.0, 95.0], true),
            ([4.0, 0.0, 95.0], true),
            ([4.0, 0.0, 85.0], false),
            ([0.0, 0.5, 105.0], true),
        ] {
            assert_eq!(surface.contains(&point.into()), is_inside, "{point:?}");
        }
    }

    #[test]
    fn a_bore_is_no_part_of_the_body() {
        let surface = Surface::new(&tube()).unwrap();
        assert!(surface.is_closed());
        assert!(!surface.contains(&Point3::new(0.0, 0.3, 50.0)));
        assert!(surface.contains(&Point3::new(0.0, 1.5, 50.0)));
        assert!(surface.contains(&Point3::new(0.0, 0.3, 5.0)));
        let across = Ray { origin_mm: Point3::new(-4.5, 0.1, 50.0), direction: Vector3::x_axis() };
        let parts = surface.inside_along(&across, 9.0);
        let expected = [[2.5, 3.5], [5.5, 6.5]];
        assert_eq!(parts.len(), 2, "{parts:?}");
        for (part, expected) in parts.iter().flatten().zip(expected.iter().flatten()) {
            assert!((part - expected).abs() < 0.02, "{parts:?}");
        }
    }

    /// An outline in the plane, drawn out along z, with the triangles of its ends.
    fn drawn_out(outline: &[[f64; 2]], pieces: &[[usize; 3]], length_mm: f64) -> Surface {
        let mut part = crate::mesh::MeshPart::default();
        for z in [0.0, length_mm] {
            part.positions_mm.extend(outline.iter().map(|[x, y]| Point3::new(*x, *y, z)));
        }
        part.normals = vec![Vector3::z(); part.positions_mm.len()];
        let count = outline.len() as u32;
        for i in 0..count {
            let [a, b] = [i, (i + 1) % count];
            part.triangles.extend([[a, b, b + count], [a, b + count, a + count]]);
        }
        for [a, b, c] in pieces.iter().map(|piece| piece.map(|corner| corner as u32)) {
            part.triangles.extend([[a, c, b], [a + count, b + count, c + count]]);
        }
        let surface = Surface::new(&SurfaceMesh { parts: vec![part], ..SurfaceMesh::default() });
        let surface = surface.unwrap();
        assert!(surface.is_closed());
        surface
    }

    #[test]
    fn a_tubes_bore_is_a_bore() {
        let surface = Surface::new(&tube()).unwrap();
        let along = Vector3::z_axis();
        for (x, is_bore) in [(0.0, true), (0.9, true), (1.5, false), (3.0, false)] {
            let point = Point3::new(x, 0.1, 50.0);
            assert_eq!(surface.is_bore(&point, &along, 9.0), is_bore, "{x}");
        }
        assert!(!surface.is_bore(&Point3::new(0.0, 0.1, 50.0), &along, 0.5), "too wide");
    }

    #[test]
    fn a_notch_is_no_bore() {
        // An L: 10 mm wide and high, 3 mm thick.
        let outline = [[0.0, 0.0], [10.0, 0.0], [10.0, 3.0], [3.0, 3.0], [3.0, 10.0], [0.0, 10.0]];
        let pieces = [[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 5]];
        let surface = drawn_out(&outline, &pieces, 40.0);
        for axis in [Vector3::x_axis(), Vector3::y_axis(), Vector3::z_axis()] {
            assert!(!surface.is_bore(&Point3::new(4.0, 4.0, 20.0), &axis, 50.0), "{axis:?}");
        }
        // Nor is it one behind a wall: the room is on the other side.
        assert!(!surface.is_bore(&Point3::new(-1.0, 5.0, 20.0), &Vector3::z_axis(), 50.0));
    }

    #[test]
    fn a_surface_with_a_hole_encloses_nothing() {
        let mut mesh = cylinder(2.0, 100.0, 24);
        mesh.parts[0].triangles.pop();
        assert!(!Surface::new(&mesh).unwrap().is_closed());
        // Two parts of one shell do: sides and ends of different materials.
        let whole = cylinder(2.0, 100.0, 24).parts.remove(0);
        let mut ends = whole.clone();
        let mut sides = whole;
        let is_side = |part: &crate::mesh::MeshPart, triangle: &[u32; 3]| {
            part.normals[triangle[0] as usize].z == 0.0
        };
        let all = ends.clone();
        ends.triangles.retain(|triangle| !is_side(&all, triangle));
        sides.triangles.retain(|triangle| is_side(&all, triangle));
        let mesh = SurfaceMesh { parts: vec![ends, sides], ..SurfaceMesh::default() };
        assert!(Surface::new(&mesh).unwrap().is_closed());
    }

    #[test]
    fn triangles_without_an_area_open_nothing() {
        let mut mesh = cylinder(2.0, 100.0, 24);
        // A side is cut at the middle of an edge, and a sliver closes the cut.
        let part = &mut mesh.parts[0];
        let [a, b, c] = part.triangles[0];
        let middle =
            nalgebra::center(&part.positions_mm[a as usize], &part.positions_mm[b as usize]);
        let new = part.positions_mm.len() as u32;
        part.positions_mm.push(middle);
        part.normals.push(part.normals[a as usize]);
        part.triangles[0] = [a, new, c];
        part.triangles.extend([[new, b, c], [a, b, new]]);
        let surface = Surface::new(&mesh).unwrap();
        assert!(surface.is_closed());
    }
}
