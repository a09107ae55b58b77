//! Basis orientations on the sphere, their triangles, and spherical weights (paper, section 2.2).

use super::direction_search::{Candidates, TriangleTable, cell_codes};
use nalgebra::{Matrix3, Unit, Vector3};
use pulp::{Scalar, Simd};
use serde::{Deserialize, Serialize};
use std::sync::LazyLock;

/// Triple products below this are round-off: the axis lies on the edge, and the weight of the
/// corner opposite is exactly 0. Products of unit vectors carry errors of 2e-16.
pub const ON_EDGE: f64 = 1e-15;

/// How far outside a triangle an axis may be, in gnomonic coordinates, and still belong to it.
const IN_TRIANGLE: f64 = 1e-14;

/// A shipped set of basis orientations.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(try_from = "usize", into = "usize")]
pub enum DirectionSet {
    /// Orientation is ignored.
    One,
    /// Octahedron.
    Six,
    /// Icosahedron.
    Twelve,
    /// Six axes and eight cube corners, the paper's.
    Fourteen,
    /// The fourteen and twelve edge middles.
    TwentySix,
    /// Icosahedron and its edge middles.
    FortyTwo,
}

/// How the three corners of a triangle share an axis.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum Weighting {
    /// Areas of the spherical triangles opposite each corner, the paper's. Jumps slightly across
    /// an edge between unlike triangles (4e-5 for the set of 42).
    #[default]
    Area,
    /// Coordinates in the plane through the corners; continuous for every set.
    Gnomonic,
}

/// An axis as a mean of at most three basis orientations; weights add to 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DirectionWeights {
    pub directions: [usize; 3],
    pub weights: [f64; 3],
}

impl DirectionWeights {
    /// The weight of one basis orientation, 0 for one that is not a corner.
    pub fn of(&self, direction: usize) -> f64 {
        // The set of one names its only orientation three times, with one weight that counts.
        (0..3).filter(|&k| self.directions[k] == direction).map(|k| self.weights[k]).sum()
    }
}

#[derive(Clone, Debug, thiserror::Error, PartialEq)]
#[error("no set of {0} basis orientations, expected 1, 6, 12, 14, 26 or 42")]
pub struct UnknownDirectionSet(pub usize);

impl DirectionSet {
    pub const ALL: [Self; 6] =
        [Self::One, Self::Six, Self::Twelve, Self::Fourteen, Self::TwentySix, Self::FortyTwo];

    /// Number of basis orientations.
    pub fn len(self) -> usize {
        match self {
            Self::One => 1,
            Self::Six => 6,
            Self::Twelve => 12,
            Self::Fourteen => 14,
            Self::TwentySix => 26,
            Self::FortyTwo => 42,
        }
    }

    /// No set is empty.
    pub fn is_empty(self) -> bool {
        false
    }

    /// Of each basis orientation and its opposite the one whose first component that is not 0 is above it.
    pub fn up_to_sign(self) -> impl Iterator<Item = &'static Unit<Vector3<f64>>> {
        let is_first =
            |n: &&Unit<Vector3<f64>>| n.iter().find(|v| v.abs() > 1e-9).is_some_and(|v| *v > 0.0);
        self.directions().iter().filter(is_first)
    }

    /// The basis orientations; for the set of one, z, which nothing depends on.
    pub fn directions(self) -> &'static [Unit<Vector3<f64>>] {
        &self.sphere().directions
    }

    /// Faces of the convex hull, corners counter-clockwise seen from outside; none for one.
    pub fn triangles(self) -> &'static [[usize; 3]] {
        &self.sphere().triangles
    }

    /// The weights of an axis in its triangle.
    pub fn weights(self, axis: &Unit<Vector3<f64>>, weighting: Weighting) -> DirectionWeights {
        if self == Self::One {
            return DirectionWeights { directions: [0; 3], weights: [1.0, 0.0, 0.0] };
        }
        let sphere = self.sphere();
        let triangle = sphere.find(axis);
        let directions = sphere.triangles[triangle];
        let weights = match weighting {
            Weighting::Gnomonic => {
                let gnomonic: [f64; 3] = (sphere.inverses[triangle] * axis.as_ref()).into();
                normalised(gnomonic.map(|w| w.max(0.0)))
            }
            Weighting::Area => {
                let [a, b, c] = directions.map(|d| sphere.directions[d].as_ref());
                let n = axis.as_ref();
                normalised([half_area_rad(n, b, c), half_area_rad(a, n, c), half_area_rad(a, b, n)])
            }
        };
        DirectionWeights { directions, weights }
    }

    /// The set's triangles with what finds that of an axis.
    pub fn sphere(self) -> &'static Sphere {
        static SPHERES: LazyLock<[Sphere; 6]> =
            LazyLock::new(|| DirectionSet::ALL.map(|set| Sphere::new(corners(set))));
        &SPHERES[self as usize]
    }
}

impl TryFrom<usize> for DirectionSet {
    type Error = UnknownDirectionSet;

    fn try_from(len: usize) -> Result<Self, Self::Error> {
        Self::ALL.into_iter().find(|set| set.len() == len).ok_or(UnknownDirectionSet(len))
    }
}

impl From<DirectionSet> for usize {
    fn from(set: DirectionSet) -> usize {
        set.len()
    }
}

/// Half the signed area of a spherical triangle, as an angle (Van Oosterom & Strackee, IEEE
/// TBME 30(2), 1983); the factor two cancels in the weights.
fn half_area_rad(a: &Vector3<f64>, b: &Vector3<f64>, c: &Vector3<f64>) -> f64 {
    let triple = a.dot(&b.cross(c)).abs();
    if triple < ON_EDGE {
        return 0.0;
    }
    triple.atan2(1.0 + a.dot(b) + b.dot(c) + c.dot(a))
}

fn normalised(weights: [f64; 3]) -> [f64; 3] {
    let sum: f64 = weights.iter().sum();
    weights.map(|w| w / sum)
}

/// A set's corners and faces, with what finds the face of an axis.
pub struct Sphere {
    directions: Vec<Unit<Vector3<f64>>>,
    triangles: Vec<[usize; 3]>,
    /// `[b1 b2 b3]⁻¹` of each triangle: takes an axis to its gnomonic coordinates.
    inverses: Vec<Matrix3<f64>>,
    shapes: Vec<TriangleShape>,
    table: TriangleTable,
}

/// The constants of a triangle's weights, by corner.
pub struct TriangleShape {
    pub corners: [Vector3<f64>; 3],
    /// Vector products of the two other corners, in turn: their product with an axis is the
    /// triple product of `half_area_rad`.
    pub normals: [Vector3<f64>; 3],
    /// Scalar products of the two other corners.
    pub opposite_cosines: [f64; 3],
    /// An axis' coordinate at a corner is the product with this.
    pub gnomonic_rows: [Vector3<f64>; 3],
}

impl TriangleShape {
    fn new(corners: [Vector3<f64>; 3], inverse: &Matrix3<f64>) -> Self {
        let [a, b, c] = corners;
        Self {
            corners,
            normals: [b.cross(&c), c.cross(&a), a.cross(&b)],
            opposite_cosines: [b.dot(&c), c.dot(&a), a.dot(&b)],
            gnomonic_rows: [0, 1, 2].map(|row| inverse.row(row).transpose()),
        }
    }
}

impl Sphere {
    fn new(directions: Vec<Unit<Vector3<f64>>>) -> Self {
        let triangles = hull_triangles(&directions);
        let inverses: Vec<_> = triangles
            .iter()
            .map(|t| {
                Matrix3::from_columns(&t.map(|i| directions[i].into_inner()))
                    .try_inverse()
                    .expect("a face of the hull does not contain the origin")
            })
            .collect();
        let shapes = triangles.iter().zip(&inverses);
        Self {
            shapes: shapes
                .map(|(t, inverse)| TriangleShape::new(t.map(|i| *directions[i]), inverse))
                .collect(),
            directions,
            triangles,
            table: TriangleTable::new(&inverses),
            inverses,
        }
    }

    /// What the weights in a triangle are made of.
    pub fn shape(&self, triangle: usize) -> &TriangleShape {
        &self.shapes[triangle]
    }

    /// The triangle that holds the axis, the first of equals.
    fn find(&self, axis: &Unit<Vector3<f64>>) -> usize {
        let code = cell_codes(Scalar::new(), axis.into_inner().into());
        self.find_by_code(code, axis)
    }

    /// The triangles of axes, at most `triangle_of.len()` of them.
    #[inline(always)]
    pub fn find_all<S: Simd>(&self, simd: S, axes: &[Unit<Vector3<f64>>], triangle_of: &mut [u8]) {
        // Strips are long enough that what was written by component is in the cache when it is
        // read by lane.
        const STRIP: usize = 256;
        let mut components = [[0.0; STRIP]; 3];
        let mut codes = [0_u64; STRIP];
        for (axes, triangle_of) in axes.chunks(STRIP).zip(triangle_of.chunks_mut(STRIP)) {
            let [xs, ys, zs] = &mut components;
            for (((axis, x), y), z) in axes.iter().zip(&mut *xs).zip(&mut *ys).zip(&mut *zs) {
                [*x, *y, *z] = [axis.x, axis.y, axis.z];
            }
            let (xs, ys, zs) =
                (S::as_simd_f64s(xs).0, S::as_simd_f64s(ys).0, S::as_simd_f64s(zs).0);
            let vectors = axes.len().div_ceil(S::F64_LANES);
            let found = S::as_mut_simd_u64s(&mut codes).0;
            for (((code, &x), &y), &z) in found.iter_mut().zip(xs).zip(ys).zip(zs).take(vectors) {
                *code = cell_codes(simd, [x, y, z]);
            }
            for ((axis, &code), triangle) in axes.iter().zip(&codes).zip(triangle_of) {
                *triangle = self.find_by_code(code, axis) as u8;
            }
        }
    }

    #[inline(always)]
    fn find_by_code(&self, code: u64, axis: &Unit<Vector3<f64>>) -> usize {
        match self.table.candidates(code) {
            Candidates::One(triangle) => triangle,
            Candidates::Several(triangles) => triangles
                .iter()
                .map(|&t| usize::from(t))
                .find(|&t| (self.inverses[t] * axis.as_ref()).min() >= -IN_TRIANGLE)
                .unwrap_or_else(|| self.find_in_all(axis)),
        }
    }

    /// The first triangle in which the axis lies, or else the one that it misses by least.
    #[cold]
    fn find_in_all(&self, axis: &Unit<Vector3<f64>>) -> usize {
        let mut best = (0, f64::NEG_INFINITY);
        for (i, inverse) in self.inverses.iter().enumerate() {
            let least = (inverse * axis.as_ref()).min();
            if least >= -IN_TRIANGLE {
                return i;
            }
            if least > best.1 {
                best = (i, least);
            }
        }
        best.0
    }
}

/// Faces of the convex hull of points on the sphere, by trying all triples: the sets are small,
/// and no four of their points share a face.
fn hull_triangles(points: &[Unit<Vector3<f64>>]) -> Vec<[usize; 3]> {
    let mut triangles = Vec::new();
    for i in 0..points.len() {
        for j in i + 1..points.len() {
            for k in j + 1..points.len() {
                let normal = (points[j].as_ref() - points[i].as_ref())
                    .cross(&(points[k].as_ref() - points[i].as_ref()));
                let offset = normal.dot(&points[i]);
                let is_face = points.iter().enumerate().all(|(m, p)| {
                    [i, j, k].contains(&m) || (offset - normal.dot(p)) * offset > 0.0
                });
                if is_face && offset != 0.0 {
                    triangles.push(if offset > 0.0 { [i, j, k] } else { [i, k, j] });
                }
            }
        }
    }
    triangles
}

fn corners(set: DirectionSet) -> Vec<Unit<Vector3<f64>>> {
    let axes = || {
        (0..3).flat_map(|k| {
            [1.0, -1.0].map(|sign| {
                let mut v = Vector3::zeros();
                v[k] = sign;
                v
            })
        })
    };
    let cube_corners =
        || (0..8).map(|i| Vector3::from_fn(|k, _| if i >> k & 1 == 0 { 1.0 } else { -1.0 }));
    let vectors: Vec<Vector3<f64>> = match set {
        DirectionSet::One => vec![Vector3::z()],
        DirectionSet::Six => axes().collect(),
        DirectionSet::Twelve => icosahedron(),
        DirectionSet::Fourteen => axes().chain(cube_corners()).collect(),
        DirectionSet::TwentySix => {
            axes().chain(cube_corners()).chain(cube_edge_middles()).collect()
        }
        DirectionSet::FortyTwo => {
            let corners = icosahedron();
            let middles = icosahedron_edge_middles(&corners);
            corners.into_iter().chain(middles).collect()
        }
    };
    vectors.into_iter().map(Unit::new_normalize).collect()
}

fn cube_edge_middles() -> impl Iterator<Item = Vector3<f64>> {
    (0..3).flat_map(|k| {
        [(1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)].map(|(a, b)| {
            let mut v = Vector3::zeros();
            v[(k + 1) % 3] = a;
            v[(k + 2) % 3] = b;
            v
        })
    })
}

/// `(0, ±1, ±φ)` and its cyclic permutations.
fn icosahedron() -> Vec<Vector3<f64>> {
    let golden = (1.0 + 5.0_f64.sqrt()) / 2.0;
    (0..3)
        .flat_map(|k| {
            [(1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)].map(|(a, b)| {
                let mut v = Vector3::zeros();
                v[(k + 1) % 3] = a;
                v[(k + 2) % 3] = b * golden;
                v
            })
        })
        .collect()
}

/// Middles of neighbouring corners: edges are 2 long, everything else is longer.
fn icosahedron_edge_middles(corners: &[Vector3<f64>]) -> Vec<Vector3<f64>> {
    let mut middles = Vec::new();
    for (i, a) in corners.iter().enumerate() {
        for b in &corners[i + 1..] {
            if (a - b).norm() < 2.0 + 1e-9 {
                middles.push(a + b);
            }
        }
    }
    middles
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Some hundred axes that lie on no special place, and all the special ones.
    fn axes(set: DirectionSet) -> Vec<Unit<Vector3<f64>>> {
        let mut axes: Vec<_> = (0..200)
            .map(|i| {
                let z = 1.0 - (2.0 * f64::from(i) + 1.0) / 200.0;
                let turn = f64::from(i) * 2.399_963_229_728_653;
                let r = (1.0 - z * z).sqrt();
                Unit::new_normalize(Vector3::new(r * turn.cos(), r * turn.sin(), z))
            })
            .collect();
        axes.extend(set.directions());
        axes
    }

    #[test]
    fn sets_have_eulers_number_of_faces() {
        for set in DirectionSet::ALL.into_iter().skip(1) {
            assert_eq!(set.directions().len(), set.len());
            assert_eq!(set.triangles().len(), 2 * set.len() - 4, "{set:?}");
        }
    }

    #[test]
    fn weights_are_a_partition_of_unity() {
        for set in DirectionSet::ALL {
            for axis in axes(set) {
                for weighting in [Weighting::Area, Weighting::Gnomonic] {
                    let w = set.weights(&axis, weighting).weights;
                    assert!(w.iter().all(|&w| (0.0..=1.0).contains(&w)), "{w:?}");
                    assert!((w.iter().sum::<f64>() - 1.0).abs() < 1e-15);
                }
            }
        }
    }

    #[test]
    fn gnomonic_weights_point_back_along_the_axis() {
        for axis in axes(DirectionSet::FortyTwo) {
            let w = DirectionSet::FortyTwo.weights(&axis, Weighting::Gnomonic);
            let sum: Vector3<f64> = (0..3)
                .map(|k| {
                    DirectionSet::FortyTwo.directions()[w.directions[k]].into_inner() * w.weights[k]
                })
                .sum();
            assert!(sum.normalize().cross(&axis).norm() < 1e-14);
        }
    }

    #[test]
    fn on_a_corner_one_weight_is_exactly_one() {
        for set in DirectionSet::ALL {
            for (i, axis) in set.directions().iter().enumerate() {
                for weighting in [Weighting::Area, Weighting::Gnomonic] {
                    let w = set.weights(axis, weighting);
                    let own = (0..3).find(|&k| w.directions[k] == i).unwrap();
                    assert!((w.weights[own] - 1.0).abs() < 1e-15, "{set:?} {i} {w:?}");
                    if weighting == Weighting::Area {
                        assert_eq!(w.weights[own], 1.0, "{set:?} {i} {w:?}");
                    }
                }
            }
        }
    }

    #[test]
    fn on_an_edge_the_opposite_area_weight_is_zero() {
        for set in DirectionSet::ALL.into_iter().skip(1) {
            for t in set.triangles() {
                let [a, b, c] = t.map(|i| set.directions()[i].into_inner());
                let middle = Unit::new_normalize(a + b * 0.7);
                let w = set.weights(&middle, Weighting::Area);
                for k in 0..3 {
                    let corner = set.directions()[w.directions[k]].into_inner();
                    if corner != a && corner != b {
                        assert_eq!(w.weights[k], 0.0, "{set:?} opposite {c:?}");
                    }
                }
            }
        }
    }

    /// Where a search could go wrong: corners, edges, borders of the table's cells, and next to
    /// all of these.
    fn special_axes(set: DirectionSet) -> Vec<Unit<Vector3<f64>>> {
        let mut vectors: Vec<Vector3<f64>> = axes(set).iter().map(|a| a.into_inner()).collect();
        for t in set.triangles() {
            let [a, b, c] = t.map(|i| set.directions()[i].into_inner());
            for part in [0.0, 1e-9, 0.1, 0.5, 0.7, 1.0] {
                vectors.extend([(a, b), (b, c), (c, a)].map(|(a, b)| a + (b - a) * part));
            }
            vectors.push(a + b + c);
        }
        for i in -32_i32..=32 {
            for j in -32_i32..=32 {
                let (u, v) = (f64::from(i) / 32.0, f64::from(j) / 32.0);
                vectors.extend([
                    Vector3::new(1.0, u, v),
                    Vector3::new(u, -1.0, v),
                    Vector3::new(u, v, 1.0),
                ]);
            }
        }
        let mut all = Vec::new();
        for v in vectors {
            all.push(v);
            for step in [1e-16, 3e-15, 1e-14, 2e-14, 1e-13] {
                all.push(v + Vector3::new(step, -step, 0.5 * step));
                all.push(v + Vector3::new(-0.3 * step, step, -step));
            }
        }
        all.into_iter().map(Unit::new_normalize).collect()
    }

    #[test]
    fn the_table_agrees_with_a_full_search() {
        for set in DirectionSet::ALL.into_iter().skip(1) {
            let sphere = set.sphere();
            let axes = special_axes(set);
            let mut found = vec![0; axes.len()];
            sphere.find_all(Scalar::new(), &axes, &mut found);
            for (axis, &triangle) in axes.iter().zip(&found) {
                let exhaustive = sphere.find_in_all(axis);
                assert_eq!(usize::from(triangle), exhaustive, "{set:?} {axis:?}");
                assert_eq!(sphere.find(axis), exhaustive);
            }
        }
    }

    #[test]
    fn a_set_that_is_not_shipped_is_refused() {
        assert_eq!(DirectionSet::try_from(13), Err(UnknownDirectionSet(13)));
    }
}
