//! Normals for meshes that come without: smooth over shallow edges, sharp over others.

use super::mesh::{MeshPart, SurfaceMesh};
use super::weld::welded;
use nalgebra::{Point3, Vector3};

/// Edges whose triangles turn by more than this stay sharp.
///
/// A round shaft of 10 sides or more (36° each) looks round, and the bevels that CAD programs make
/// at 45° look like bevels.
pub const CREASE_ANGLE_DEG: f64 = 40.0;

/// A vertex whose triangles cancel out has no normal of its own, and then gets z.
const MIN_NORMAL: f64 = 1e-30;

/// A triangle mesh whose vertices were split where its edges are sharp.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Smoothed {
    /// As many as the normals.
    pub positions_mm: Vec<Point3<f64>>,
    /// Unit length.
    pub normals: Vec<Vector3<f64>>,
    /// In the order of the triangles that came in.
    pub triangles: Vec<[u32; 3]>,
}

/// Makes normals for vertices that triangles share; indices must be those of positions.
///
/// Around each vertex, triangles that share an edge and turn by at most [`CREASE_ANGLE_DEG`] over
/// it form a group, and each group gets a vertex of its own, its normal the mean of the triangles'
/// normals weighted by their angles there (Thürmer & Wüthrich, J. Graphics Tools 3(1), 1998), which
/// does not depend on how faces were cut into triangles. Triangles without area count for nothing.
pub fn smoothed(positions_mm: &[Point3<f64>], triangles: &[[u32; 3]]) -> Smoothed {
    let faces: Vec<_> =
        triangles.iter().map(|t| face_normal(t.map(|i| positions_mm[i as usize]))).collect();
    let incident = Incident::new(positions_mm.len(), triangles);
    let mut out = Smoothed {
        positions_mm: Vec::with_capacity(positions_mm.len()),
        normals: Vec::with_capacity(positions_mm.len()),
        triangles: vec![[0; 3]; triangles.len()],
    };
    let mut groups = Groups::default();
    for (vertex, position) in positions_mm.iter().enumerate() {
        let around = incident.around(vertex);
        groups.make(vertex as u32, around, triangles, &faces);
        let first = out.normals.len();
        // A group's vertex is made when its first triangle is met.
        groups.vertices.clear();
        groups.vertices.resize(around.len(), u32::MAX);
        for (local, &triangle) in around.iter().enumerate() {
            let root = groups.root(local);
            if groups.vertices[root] == u32::MAX {
                groups.vertices[root] = out.normals.len() as u32;
                out.positions_mm.push(*position);
                out.normals.push(Vector3::zeros());
            }
            let new = groups.vertices[root];
            let corners = &triangles[triangle as usize];
            for (corner, &index) in corners.iter().enumerate() {
                if index as usize == vertex {
                    out.triangles[triangle as usize][corner] = new;
                    let angle = corner_angle(corners.map(|i| positions_mm[i as usize]), corner);
                    out.normals[new as usize] += faces[triangle as usize] * angle;
                }
            }
        }
        for normal in &mut out.normals[first..] {
            *normal = unit_or_z(*normal);
        }
    }
    out
}

/// The mesh with normals that are smooth over shallow edges, whatever its file has: what drags follow
/// on a round shaft whose facets are drawn flat.
pub fn with_smooth_normals(mesh: &SurfaceMesh) -> SurfaceMesh {
    let smooth = |part: &MeshPart| {
        let places = welded(&part.positions_mm);
        let count = places.iter().max().map_or(0, |last| *last as usize + 1);
        let mut positions_mm = vec![Point3::origin(); count];
        for (position, &place) in part.positions_mm.iter().zip(&places) {
            positions_mm[place as usize] = *position;
        }
        let triangles: Vec<[u32; 3]> =
            part.triangles.iter().map(|t| t.map(|corner| places[corner as usize])).collect();
        let Smoothed { positions_mm, normals, triangles } = smoothed(&positions_mm, &triangles);
        MeshPart { positions_mm, normals, triangles, ..part.clone() }
    };
    SurfaceMesh { parts: mesh.parts.iter().map(smooth).collect(), reading: mesh.reading }
}

/// The vector at length 1, or z where it has no direction.
pub fn unit_or_z(vector: Vector3<f64>) -> Vector3<f64> {
    vector
        .try_normalize(MIN_NORMAL)
        .filter(|n| n.iter().all(|v| v.is_finite()))
        .unwrap_or_else(Vector3::z)
}

/// Zero for a triangle without area.
fn face_normal([a, b, c]: [Point3<f64>; 3]) -> Vector3<f64> {
    (b - a).cross(&(c - a)).try_normalize(MIN_NORMAL).unwrap_or_default()
}

fn corner_angle(corners: [Point3<f64>; 3], corner: usize) -> f64 {
    let [at, next, last] = [0, 1, 2].map(|k| corners[(corner + k) % 3]);
    (next - at).angle(&(last - at))
}

/// The triangles around each vertex, one after the other; one that has a vertex twice counts once.
struct Incident {
    starts: Vec<u32>,
    triangles: Vec<u32>,
}

impl Incident {
    fn new(vertices: usize, triangles: &[[u32; 3]]) -> Self {
        let once = |[a, b, c]: [u32; 3]| {
            [Some(a), (b != a).then_some(b), (c != a && c != b).then_some(c)].into_iter().flatten()
        };
        let mut starts = vec![0; vertices + 1];
        for vertex in triangles.iter().flat_map(|&t| once(t)) {
            starts[vertex as usize + 1] += 1;
        }
        for i in 0..vertices {
            starts[i + 1] += starts[i];
        }
        let mut next = starts.clone();
        let mut sorted = vec![0; starts[vertices] as usize];
        for (triangle, &corners) in triangles.iter().enumerate() {
            for vertex in once(corners) {
                let slot = &mut next[vertex as usize];
                sorted[*slot as usize] = triangle as u32;
                *slot += 1;
            }
        }
        Self { starts, triangles: sorted }
    }

    fn around(&self, vertex: usize) -> &[u32] {
        &self.triangles[self.starts[vertex] as usize..self.starts[vertex + 1] as usize]
    }
}

/// The triangles around one vertex as groups: a forest over their places in the list.
#[derive(Default)]
struct Groups {
    parents: Vec<u32>,
    /// The other end of an edge at the vertex, and the triangle that has it.
    edges: Vec<(u32, u32)>,
    /// The new vertex of each group's root.
    vertices: Vec<u32>,
}

impl Groups {
    fn make(
        &mut self,
        vertex: u32,
        around: &[u32],
        triangles: &[[u32; 3]],
        faces: &[Vector3<f64>],
    ) {
        let least_cosine = CREASE_ANGLE_DEG.to_radians().cos();
        self.parents.clear();
        self.parents.extend(0..around.len() as u32);
        self.edges.clear();
        for (local, &triangle) in around.iter().enumerate() {
            let others = triangles[triangle as usize].into_iter();
            self.edges
                .extend(others.filter(|&other| other != vertex).map(|other| (other, local as u32)));
        }
        // Sorting keeps this quick where a file lets millions of triangles meet in one vertex.
        self.edges.sort_unstable();
        for i in 1..self.edges.len() {
            let ((a_end, a), (b_end, b)) = (self.edges[i - 1], self.edges[i]);
            let face = |local: u32| faces[around[local as usize] as usize];
            if a_end == b_end && face(a).dot(&face(b)) >= least_cosine {
                let (a, b) = (self.root(a as usize), self.root(b as usize));
                let (low, high) = (a.min(b), a.max(b));
                self.parents[high] = low as u32;
            }
        }
    }

    fn root(&mut self, mut local: usize) -> usize {
        loop {
            let parent = self.parents[local] as usize;
            if parent == local {
                return local;
            }
            // Halving the way keeps it short for the next.
            self.parents[local] = self.parents[parent];
            local = parent;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    fn cube() -> (Vec<Point3<f64>>, Vec<[u32; 3]>) {
        let corners = (0..8)
            .map(|i| Point3::new(f64::from(i & 1), f64::from(i >> 1 & 1), f64::from(i >> 2)))
            .collect();
        let sides =
            [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        let triangles = sides.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]);
        (corners, triangles.collect())
    }

    #[test]
    fn a_shaft_drawn_flat_gets_smooth_normals() {
        let sides = 16;
        let mut mesh = crate::surface::tests::cylinder(2.0, 50.0, sides);
        let part = &mut mesh.parts[0];
        // A corner for each triangle, with the triangle's normal, and not at one place to the bit.
        let corners: Vec<_> = (0..part.triangles.len()).map(|i| part.corners_mm(i)).collect();
        part.normals = corners.iter().flat_map(|c| [face_normal(*c); 3]).collect();
        let shifted = corners.iter().flatten().enumerate();
        part.positions_mm =
            shifted.map(|(i, p)| p + Vector3::x() * ((i % 3) as f64 * 1e-16)).collect();
        part.triangles = (0..corners.len() as u32).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
        let smooth = with_smooth_normals(&mesh);
        let part = &smooth.parts[0];
        let on_side = part.positions_mm.iter().zip(&part.normals).filter(|(_, n)| n.z.abs() < 0.5);
        let mut count = 0;
        for (position, normal) in on_side {
            let radial = Vector3::new(position.x, position.y, 0.0).normalize();
            assert!((normal - radial).norm() < 1e-9, "{normal} at {position}");
            count += 1;
        }
        assert_eq!(count, 2 * sides);
    }

    #[test]
    fn a_cube_keeps_its_edges() {
        let (corners, triangles) = cube();
        let out = smoothed(&corners, &triangles);
        assert_eq!(out.positions_mm.len(), 24);
        let center = Vector3::repeat(0.5);
        for (new, old) in out.triangles.iter().zip(&triangles) {
            let places = |t: &[u32; 3], all: &[Point3<f64>]| t.map(|i| all[i as usize]);
            assert_eq!(places(new, &out.positions_mm), places(old, &corners));
            let face = face_normal(places(old, &corners));
            assert!(face.dot(&(corners[old[0] as usize].coords - center)) > 0.0);
            for &i in new {
                assert!((out.normals[i as usize] - face).norm() < 1e-12);
            }
        }
    }

    #[test]
    fn a_tube_is_smooth_from_ten_sides_on() {
        for (sides, is_round) in [(8_u32, false), (10, true), (64, true)] {
            let rim = |i: u32, z: f64| {
                let (sine, cosine) = (TAU * f64::from(i) / f64::from(sides)).sin_cos();
                Point3::new(2.0 * cosine, 2.0 * sine, z)
            };
            let corners: Vec<_> =
                [0.0, 50.0].iter().flat_map(|&z| (0..sides).map(move |i| rim(i, z))).collect();
            let triangles: Vec<_> = (0..sides)
                .flat_map(|i| {
                    let j = (i + 1) % sides;
                    [[i, j, sides + j], [i, sides + j, sides + i]]
                })
                .collect();
            let out = smoothed(&corners, &triangles);
            assert_eq!(out.positions_mm.len() == corners.len(), is_round, "{sides}");
            if is_round {
                // Weighted by angle, one side in two triangles weighs what the other in one does.
                for (position, normal) in out.positions_mm.iter().zip(&out.normals) {
                    let radial = Vector3::new(position.x, position.y, 0.0) / 2.0;
                    assert!((normal - radial).norm() < 1e-12, "{normal} {radial}");
                }
            }
        }
    }

    #[test]
    fn triangles_without_area_turn_no_normal() {
        let corners = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.5, 0.0, 0.0]];
        let corners = corners.map(Point3::from);
        let triangles = [[0, 1, 2], [0, 3, 1], [0, 0, 1], [2, 2, 2]];
        let out = smoothed(&corners, &triangles);
        for &i in &out.triangles[0] {
            assert_eq!(out.normals[i as usize], Vector3::z());
        }
        assert!(out.normals.iter().all(|n| (n.norm() - 1.0).abs() < 1e-12));
        assert!(out.triangles.iter().flatten().all(|&i| (i as usize) < out.normals.len()));
    }

    #[test]
    fn many_triangles_around_a_vertex_are_quick() {
        const COUNT: u32 = 200_000;
        let mut corners = vec![Point3::origin()];
        corners.extend((0..=COUNT).map(|i| {
            let (sine, cosine) = (f64::from(i) * 1e-5).sin_cos();
            Point3::new(cosine, sine, 0.0)
        }));
        let triangles: Vec<_> = (1..=COUNT).map(|i| [0, i, i + 1]).collect();
        let out = smoothed(&corners, &triangles);
        assert_eq!(out.positions_mm.len(), corners.len());
        assert!(out.normals.iter().all(|n| (n - Vector3::z()).norm() < 1e-12));
    }
}
