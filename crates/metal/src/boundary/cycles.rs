//! Currents around the holes that go through a body.
//!
//! A cycle is a flux of 1 along a closed chain of triangles: even on each of them, and without divergence. Two for
//! each hole are no sum of loops about corners: those along the edges that neither a tree of all triangles nor one of
//! all corners has (Eppstein, Proc. ACM-SIAM Symposium on Discrete Algorithms, 2003). Where no current flows outside,
//! that of the magnetic field on the surface circulates only along those sums of cycles which outside bound a
//! surface: by Alexander's duality those that no cycle links which is drawn a little into the body. They are one for
//! each hole.

use crate::panel::Panel;
use faer::Mat;
use nalgebra::{Point3, Vector3};
use std::collections::HashMap;
use std::f64::consts::PI;

/// How far curves are drawn into the body and out of it, in sizes of their triangles.
const DRAWN: f64 = 1e-3;

/// The cycles of a surface.
#[derive(Clone, Debug)]
pub(super) struct Cycles {
    pub count: usize,
    /// Of each triangle: numbers of cycles, and their currents in it.
    pub currents_of: Vec<Vec<(usize, Vector3<f64>)>>,
    /// What flows around each hole, a column a hole and a row a cycle.
    pub around: Mat<f64>,
    /// How often each cycle, drawn out of the body, links what flows around each hole.
    pub links: Mat<f64>,
    /// Triangles that span what flows around each hole, with their shares.
    pub spans: Vec<Vec<(f64, Panel)>>,
}

/// The triangle that each is joined to by the tree of all, and the edge between them.
pub(super) type Tree = Vec<Option<(usize, [usize; 2])>>;

/// A closed curve from edge to edge, and the normals where it is.
struct Curve {
    points_mm: Vec<Point3<f64>>,
    normals: Vec<Vector3<f64>>,
    size_mm: f64,
}

impl Cycles {
    pub fn new(
        panels: &[Panel],
        corners: &[[usize; 3]],
        triangles_at: &HashMap<[usize; 2], Vec<usize>>,
        tree: &Tree,
    ) -> Self {
        let mut edges: Vec<[usize; 2]> = triangles_at.keys().copied().collect();
        edges.sort_unstable();
        let is_joined = |edge: &[usize; 2]| {
            let by = |t: usize| tree[t].is_some_and(|(_, own)| own == *edge);
            triangles_at[edge].iter().any(|&t| by(t))
        };
        edges.retain(|edge| !is_joined(edge));
        let mut joined = Joined::of(corners.iter().flatten().max().map_or(0, |most| most + 1));
        edges.retain(|[a, b]| !joined.join(*a, *b));
        let count = edges.len();
        let mut currents_of = vec![Vec::new(); panels.len()];
        let mut curves = Vec::new();
        for (number, edge) in edges.iter().enumerate() {
            let chain = chain(tree, *edge, &triangles_at[edge]);
            curves.push(add(&mut currents_of, number, &chain, panels, corners));
        }
        let linking = |side: f64| {
            let linked = |a: usize, b: usize| curves[a].drawn(side).links(&curves[b]);
            Mat::from_fn(count, count, linked)
        };
        let around = null_space(linking(-1.0));
        let links = linking(1.0) * &around;
        let spans = (0..around.ncols())
            .map(|hole| {
                let shares = (0..count).map(|cycle| around[(cycle, hole)]);
                let with = shares.zip(&curves).filter(|(share, _)| *share != 0.0);
                with.flat_map(|(share, curve)| curve.spanned().map(move |of| (share, of))).collect()
            })
            .collect();
        Self { count, currents_of, around, links, spans }
    }

    pub fn holes(&self) -> usize {
        self.around.ncols()
    }

    /// What flows around each hole in a triangle.
    pub fn around_in(&self, triangle: usize) -> Vec<Vector3<f64>> {
        let of_hole = |hole: usize| {
            let own = self.currents_of[triangle].iter();
            own.map(|(cycle, current)| current * self.around[(*cycle, hole)]).sum()
        };
        (0..self.holes()).map(of_hole).collect()
    }
}

/// Adds the currents of a chain of triangles, each with the edges by which it is entered and left.
fn add(
    currents_of: &mut [Vec<(usize, Vector3<f64>)>],
    number: usize,
    chain: &[(usize, [usize; 2], [usize; 2])],
    panels: &[Panel],
    corners: &[[usize; 3]],
) -> Curve {
    let mut curve = Curve { points_mm: Vec::new(), normals: Vec::new(), size_mm: 0.0 };
    let mut last = chain.last().map_or(Vector3::zeros(), |(t, ..)| *panels[*t].normal().as_ref());
    for (triangle, entered, left) in chain {
        let panel = &panels[*triangle];
        let opposite = |edge: &[usize; 2]| {
            let at = corners[*triangle].iter().position(|corner| !edge.contains(corner));
            panel.corners_mm()[at.unwrap_or(0)]
        };
        let (a, b) = (opposite(entered), opposite(left));
        let current = (a - b) / (2.0 * panel.area_mm2());
        currents_of[*triangle].push((number, current));
        // Where it is entered is in the middle between the other corners.
        let sum: Vector3<f64> = panel.corners_mm().iter().map(|corner| corner.coords).sum();
        curve.points_mm.push(Point3::from((sum - a.coords) / 2.0));
        curve.normals.push((last + panel.normal().as_ref()).normalize());
        curve.size_mm = if curve.size_mm == 0.0 {
            panel.radius_mm()
        } else {
            curve.size_mm.min(panel.radius_mm())
        };
        last = *panel.normal().as_ref();
    }
    curve
}

/// Which corners edges join.
struct Joined(Vec<usize>);

impl Joined {
    fn of(count: usize) -> Self {
        Self((0..count).collect())
    }

    fn root(&mut self, mut of: usize) -> usize {
        while self.0[of] != of {
            self.0[of] = self.0[self.0[of]];
            of = self.0[of];
        }
        of
    }

    /// Whether they were not joined before.
    fn join(&mut self, a: usize, b: usize) -> bool {
        let (a, b) = (self.root(a), self.root(b));
        self.0[a] = b;
        a != b
    }
}

/// Triangles from one side of an edge along the tree to the other, with the edges by which each is entered and left.
fn chain(tree: &Tree, edge: [usize; 2], between: &[usize]) -> Vec<(usize, [usize; 2], [usize; 2])> {
    let up = |from: usize| {
        let mut path = vec![from];
        while let Some((parent, _)) = tree[path[path.len() - 1]] {
            path.push(parent);
        }
        path
    };
    let (mut down, mut path) = (up(between[0]), up(between[1]));
    // What both have in common, but for the triangle where they meet, is not gone along.
    while path.len() > 1 && down.len() > 1 && path[path.len() - 2] == down[down.len() - 2] {
        path.pop();
        down.pop();
    }
    let to_parent = |triangle: &usize| tree[*triangle].map_or(edge, |(_, edge)| edge);
    let mut crossed: Vec<[usize; 2]> = path[..path.len() - 1].iter().map(to_parent).collect();
    crossed.extend(down[..down.len() - 1].iter().rev().map(to_parent));
    path.extend(down[..down.len() - 1].iter().rev());
    let entered = std::iter::once(&edge).chain(&crossed);
    let left = crossed.iter().chain([&edge]);
    path.iter().zip(entered.zip(left)).map(|(t, (entered, left))| (*t, *entered, *left)).collect()
}

impl Curve {
    /// A little out of the body, or into it where the side is −1.
    fn drawn(&self, side: f64) -> Self {
        let by_mm = side * DRAWN * self.size_mm;
        let each = self.points_mm.iter().zip(&self.normals);
        let points_mm = each.map(|(p, normal)| p + normal * by_mm).collect();
        Self { points_mm, normals: self.normals.clone(), size_mm: self.size_mm }
    }

    fn sides(&self) -> impl Iterator<Item = [Point3<f64>; 2]> + '_ {
        let ends = self.points_mm.iter().cycle().skip(1);
        self.points_mm.iter().zip(ends).map(|(from, to)| [*from, *to])
    }

    /// How often another curve goes around this one.
    fn links(&self, other: &Self) -> f64 {
        let pairs = self.sides().flat_map(|a| other.sides().map(move |b| (a, b)));
        (pairs.map(|(a, b)| seen_along(&a, &b)).sum::<f64>() / (4.0 * PI)).round()
    }

    /// Triangles from its middle to its sides.
    fn spanned(&self) -> impl Iterator<Item = Panel> + '_ {
        let sum: Vector3<f64> = self.points_mm.iter().map(|p| p.coords).sum();
        let middle = Point3::from(sum / self.points_mm.len() as f64);
        self.sides().filter_map(move |[from, to]| Panel::new([middle, from, to]))
    }
}

/// The integral of Gauss over two straight pieces (Klenin and Langowski, Biopolymers 54, 2000).
fn seen_along([a, b]: &[Point3<f64>; 2], [c, d]: &[Point3<f64>; 2]) -> f64 {
    let [ac, ad, bd, bc] = [c - a, d - a, d - b, c - b];
    let normal = |u: Vector3<f64>, v: Vector3<f64>| {
        u.cross(&v).try_normalize(f64::MIN_POSITIVE).unwrap_or_default()
    };
    let normals = [normal(ac, ad), normal(ad, bd), normal(bd, bc), normal(bc, ac)];
    let angle = |k: usize| normals[k].dot(&normals[(k + 1) % 4]).clamp(-1.0, 1.0).asin();
    let whole: f64 = (0..4).map(angle).sum();
    let side = (d - c).cross(&(b - a)).dot(&ac);
    if side == 0.0 { 0.0 } else { whole * side.signum() }
}

/// A basis of what a matrix of whole numbers makes zero, a column each.
fn null_space(mut matrix: Mat<f64>) -> Mat<f64> {
    let (rows, columns) = (matrix.nrows(), matrix.ncols());
    let mut pivots: Vec<usize> = Vec::new();
    for column in 0..columns {
        let first = pivots.len();
        let largest = (first..rows)
            .max_by(|a, b| matrix[(*a, column)].abs().total_cmp(&matrix[(*b, column)].abs()));
        let Some(pivot) = largest.filter(|row| matrix[(*row, column)].abs() > 1e-9) else {
            continue;
        };
        let value = matrix[(pivot, column)];
        for j in 0..columns {
            let swapped = matrix[(first, j)];
            matrix[(first, j)] = matrix[(pivot, j)] / value;
            if pivot != first {
                matrix[(pivot, j)] = swapped;
            }
        }
        for row in (0..rows).filter(|row| *row != first) {
            let times = matrix[(row, column)];
            for j in 0..columns {
                let above = matrix[(first, j)];
                matrix[(row, j)] -= times * above;
            }
        }
        pivots.push(column);
    }
    let free: Vec<usize> = (0..columns).filter(|column| !pivots.contains(column)).collect();
    Mat::from_fn(columns, free.len(), |row, k| match pivots.iter().position(|own| *own == row) {
        Some(pivot) => -matrix[(pivot, free[k])],
        None => f64::from(u8::from(free[k] == row)),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn circle(center: [f64; 3], u: [f64; 3], v: [f64; 3]) -> Curve {
        let at = |k: usize| {
            let (s, c) = (PI * k as f64 / 6.0).sin_cos();
            Point3::from(center) + Vector3::from(u) * c + Vector3::from(v) * s
        };
        let points_mm: Vec<_> = (0..12).map(at).collect();
        Curve { normals: vec![Vector3::z(); points_mm.len()], points_mm, size_mm: 1.0 }
    }

    #[test]
    fn curves_link_as_amperes_law_has_it() {
        let ring = circle([0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]);
        // Upward within the ring, as the field of its current is there.
        let around = circle([1.0, 0.0, 0.0], [-0.5, 0.0, 0.0], [0.0, 0.0, 0.5]);
        assert_eq!((ring.links(&around), around.links(&ring)), (1.0, 1.0));
        let beside = circle([4.0, 0.0, 0.0], [-0.5, 0.0, 0.0], [0.0, 0.0, 0.5]);
        assert_eq!(ring.links(&beside), 0.0);
    }

    #[test]
    fn null_spaces_are_made_zero() {
        let rows = [[0.0, 2.0, -1.0, 0.0], [0.0, 0.0, 0.0, 3.0], [0.0, 2.0, -1.0, 3.0]];
        let matrix = Mat::from_fn(3, 4, |i, j| rows[i][j]);
        let found = null_space(matrix.clone());
        assert_eq!(found.ncols(), 2);
        assert!((matrix * found).norm_max() < 1e-12);
    }
}
