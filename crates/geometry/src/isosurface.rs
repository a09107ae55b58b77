//! The surface where a scalar on a lattice has a given value, and the volume where it is at most
//! that.
//!
//! Each cell is cut into six tetrahedra about its diagonal, the same way in every cell, and the
//! scalar is linear in each, so that the surface has no holes, ends exactly on the lattice's faces,
//! and encloses exactly the volume that is reported, in f64 as all of the core. A second scalar, linear
//! in the same tetrahedra, may cut all of it to a part of the box.
//!
//! The scalar is off by at most `Σ |f_kk| h_k² / 8` where its second derivatives along the axes are
//! `f_kk` and it has no others: within a tetrahedron the interpolant of `x²` is `h x`.

mod clip;

use super::bounds::Bounds;
use nalgebra::{Point3, Vector3};
use std::collections::HashMap;

/// A scalar at the points of a lattice over a box, x slowest and z fastest. Infinite values lie
/// above every level.
#[derive(Clone, Debug, PartialEq)]
pub struct ScalarLattice {
    pub bounds: Bounds,
    /// At least 2 along each axis for there to be a cell.
    pub counts: [usize; 3],
    pub values: Vec<f64>,
}

/// Where the scalar passes a level.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Isosurface {
    pub positions_mm: Vec<Point3<f64>>,
    /// Unit length, towards larger values.
    pub normals: Vec<Vector3<f64>>,
    /// Counter-clockwise seen from where values are larger.
    pub triangles: Vec<[u32; 3]>,
    /// Of the part of the box where values are at most the level.
    pub volume_mm3: f64,
}

/// A surface within a part of the box.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ClippedSurface {
    /// Ends where the part does; so does its volume.
    pub surface: Isosurface,
    /// Of the part itself, as the lattice has it.
    pub whole_mm3: f64,
}

/// What a triangle without an area counts for in the normals of its corners, so that those have
/// one; nothing beside any other triangle.
const LEAST_AREA_MM2: f64 = 1e-100;

/// Corners of a cell as bits, 1 for x, 2 for y, 4 for z: the paths along its edges from the first
/// to the last.
const TETRAHEDRA: [[usize; 4]; 6] =
    [[0, 1, 3, 7], [0, 2, 3, 7], [0, 2, 6, 7], [0, 4, 6, 7], [0, 4, 5, 7], [0, 1, 5, 7]];

impl ScalarLattice {
    /// A point of the lattice; the last one along an axis is the box's own number.
    pub fn point_mm(&self, index: [usize; 3]) -> Point3<f64> {
        Point3::from(Vector3::from_fn(|k, _| {
            let (min, max) = (self.bounds.min_mm[k], self.bounds.max_mm[k]);
            match index[k] + 1 == self.counts[k] {
                true => max,
                false => min + (max - min) * index[k] as f64 / (self.counts[k].max(2) - 1) as f64,
            }
        }))
    }

    /// The indices of a point by its place in the list.
    pub fn index(&self, place: usize) -> [usize; 3] {
        let [_, ny, nz] = self.counts;
        [place / (ny * nz), place / nz % ny, place % nz]
    }

    /// Between the lattice's points, trilinearly; at the nearest point of the box beyond it. Points
    /// that do not count are not read, so that they may be infinite.
    pub fn between(&self, point_mm: &Point3<f64>) -> f64 {
        let scaled = self.bounds.to_unit(point_mm);
        let at = [0, 1, 2].map(|k| {
            let cells = self.counts[k].max(2) - 1;
            let place = scaled[k].clamp(0.0, 1.0) * cells as f64;
            let cell = (place as usize).min(cells - 1);
            (cell, place - cell as f64)
        });
        let [_, ny, nz] = self.counts;
        let corners = (0..8).map(|corner| {
            let beyond = [corner >> 2, corner >> 1 & 1, corner & 1];
            let [x, y, z] = [0, 1, 2].map(|k| at[k].0 + beyond[k]);
            let parts = [0, 1, 2].map(|k| match beyond[k] {
                1 => at[k].1,
                _ => 1.0 - at[k].1,
            });
            (parts.iter().product::<f64>(), (x * ny + y) * nz + z)
        });
        corners
            .filter(|(weight, _)| *weight > 0.0)
            .map(|(weight, place)| weight * self.values[place])
            .sum()
    }

    /// The surface where values pass the level. What is not a number counts as infinite.
    ///
    /// ```
    /// use trackwright_geometry::bounds::Bounds;
    /// use trackwright_geometry::isosurface::ScalarLattice;
    ///
    /// // x at the corners of a unit cube, x slowest.
    /// let values = [0.0, 0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 1.0].to_vec();
    /// let bounds = Bounds::from(([0.0; 3], [1.0; 3]));
    /// let surface = ScalarLattice { bounds, counts: [2; 3], values }.isosurface(0.25);
    /// assert!((surface.volume_mm3 - 0.25).abs() < 1e-15);
    /// ```
    pub fn isosurface(&self, level: f64) -> Isosurface {
        self.clipped_isosurface(level, None).surface
    }

    /// The same within the part of the box where `excess`, one number a lattice point, is at most
    /// zero. Values at points of which no neighbour, diagonal ones too, is in the part are not read.
    pub fn clipped_isosurface(&self, level: f64, excess: Option<&[f64]>) -> ClippedSurface {
        let [nx, ny, nz] = self.counts;
        let points = nx * ny * nz;
        if self.counts.iter().any(|n| *n < 2)
            || self.values.len() != points
            || excess.is_some_and(|excess| excess.len() != points)
        {
            return ClippedSurface::default();
        }
        let mut builder = Builder {
            lattice: self,
            level,
            excess,
            vertex_of_edge: HashMap::new(),
            out: Isosurface::default(),
            excess_of_vertex: Vec::new(),
        };
        let mut sixths = [0.0; 2];
        for x in 0..nx - 1 {
            for y in 0..ny - 1 {
                for z in 0..nz - 1 {
                    let of_cell = builder.cell((x * ny + y) * nz + z);
                    sixths = [sixths[0] + of_cell[0], sixths[1] + of_cell[1]];
                }
            }
        }
        let cells = ((nx - 1) * (ny - 1) * (nz - 1)) as f64;
        let mut out = builder.out;
        if excess.is_some() {
            clip::clip(&mut out, &builder.excess_of_vertex);
        }
        let [volume_mm3, whole_mm3] =
            sixths.map(|sixths| self.bounds.size_mm().product() * (sixths / 6.0 / cells));
        out.volume_mm3 = volume_mm3;
        for normal in &mut out.normals {
            *normal = normal.try_normalize(0.0).unwrap_or_else(Vector3::z);
        }
        ClippedSurface { surface: out, whole_mm3 }
    }
}

struct Builder<'a> {
    lattice: &'a ScalarLattice,
    level: f64,
    excess: Option<&'a [f64]>,
    /// By the lattice point where an edge begins and the bits of where it goes.
    vertex_of_edge: HashMap<(usize, usize), u32>,
    out: Isosurface,
    /// Only where there is something to cut with.
    excess_of_vertex: Vec<f64>,
}

impl Builder<'_> {
    /// Adds the surface in a cell; how many of its sixths are at most the level, and how many there
    /// are to be so. Where the part of the box ends in the cell, so do these; its surface is cut
    /// later.
    fn cell(&mut self, first: usize) -> [f64; 2] {
        let [_, ny, nz] = self.lattice.counts;
        let corners: [usize; 8] = std::array::from_fn(|bits| {
            first + (bits & 1) * ny * nz + (bits >> 1 & 1) * nz + (bits >> 2 & 1)
        });
        let is_low = corners.map(|place| self.lattice.values[place] <= self.level);
        let mut whole = 6.0;
        let mut cut_low = None;
        if let Some(excess) = self.excess {
            let excess = corners.map(|place| excess[place]);
            let within = excess.iter().filter(|excess| **excess <= 0.0).count();
            if within == 0 {
                return [0.0, 0.0];
            }
            if within < 8 {
                let values = corners.map(|place| self.lattice.values[place]);
                let cut = TETRAHEDRA.map(|tetrahedron| {
                    let of = |all: &[f64; 8]| tetrahedron.map(|corner| all[corner]);
                    clip::low_and_whole(of(&values), self.level, of(&excess))
                });
                whole = cut.iter().map(|[_, whole]| whole).sum();
                cut_low = Some(cut.iter().map(|[low, _]| low).sum());
            }
        }
        if is_low.iter().all(|low| *low) {
            return [whole, whole];
        }
        if !is_low.iter().any(|low| *low) {
            return [0.0, whole];
        }
        let low: f64 = TETRAHEDRA
            .iter()
            .map(|tetrahedron| {
                let (mut low, mut high) = (Vec::with_capacity(4), Vec::with_capacity(4));
                for &corner in tetrahedron {
                    match is_low[corner] {
                        true => low.push(corner),
                        false => high.push(corner),
                    }
                }
                let uphill = self.uphill(&corners, tetrahedron, &low, &high);
                self.tetrahedron(&corners, &low, &high, &uphill)
            })
            .sum();
        [cut_low.unwrap_or(low), whole]
    }

    /// The direction in which the scalar grows within a tetrahedron, unit length; where it has no
    /// slope, from its low corners to its high ones.
    fn uphill(
        &self,
        corners: &[usize; 8],
        tetrahedron: &[usize; 4],
        low: &[usize],
        high: &[usize],
    ) -> Vector3<f64> {
        // Its path goes along one axis after the other.
        let mut slope = Vector3::zeros();
        let size = self.lattice.bounds.size_mm();
        for step in tetrahedron.windows(2) {
            let axis = (step[0] ^ step[1]).trailing_zeros() as usize;
            let [from, to] = [step[0], step[1]].map(|corner| self.lattice.values[corners[corner]]);
            slope[axis] = (to - from) * (self.lattice.counts[axis] - 1) as f64 / size[axis];
        }
        if slope.iter().all(|v| v.is_finite()) {
            return slope.try_normalize(0.0).unwrap_or_else(Vector3::zeros);
        }
        let mean = |some: &[usize]| {
            let points = some.iter().map(|&corner| {
                let index = self.lattice.index(corners[corner]);
                self.lattice.point_mm(index).coords
            });
            points.sum::<Vector3<f64>>() / some.len().max(1) as f64
        };
        let across = mean(high) - mean(low);
        across.try_normalize(0.0).unwrap_or_else(Vector3::zeros)
    }

    /// Adds the surface in a tetrahedron; which part of it is at most the level.
    fn tetrahedron(
        &mut self,
        corners: &[usize; 8],
        low: &[usize],
        high: &[usize],
        uphill: &Vector3<f64>,
    ) -> f64 {
        match (low, high) {
            (&[a], &[b, c, d]) => self.triangle(corners, [(a, b), (a, c), (a, d)], uphill),
            (&[a, b, c], &[d]) => self.triangle(corners, [(a, d), (b, d), (c, d)], uphill),
            (&[a, b], &[c, d]) => {
                self.triangle(corners, [(a, c), (a, d), (b, d)], uphill);
                self.triangle(corners, [(a, c), (b, d), (b, c)], uphill);
            }
            _ => {}
        }
        low_part(low, high, |a, b| self.part(corners[a], corners[b]))
    }

    /// How far from the low end of an edge the level is, 0 to 1.
    fn part(&self, low: usize, high: usize) -> f64 {
        let values = &self.lattice.values;
        part(values[low], values[high], self.level)
    }

    fn triangle(
        &mut self,
        corners: &[usize; 8],
        edges: [(usize, usize); 3],
        uphill: &Vector3<f64>,
    ) {
        let [a, mut b, mut c] = edges.map(|(from, to)| self.vertex(corners, from, to));
        let at = |vertex: u32, out: &Isosurface| out.positions_mm[vertex as usize];
        let start = at(a, &self.out);
        let area = (at(b, &self.out) - start).cross(&(at(c, &self.out) - start));
        // The slope is well determined even where a sliver's own normal is round-off.
        let weight = area.norm().max(LEAST_AREA_MM2);
        for vertex in [a, b, c] {
            self.out.normals[vertex as usize] += uphill * weight;
        }
        // Where the level is met at a lattice point a triangle may have no area.
        if area == Vector3::zeros() {
            return;
        }
        if area.dot(uphill) < 0.0 {
            std::mem::swap(&mut b, &mut c);
        }
        self.out.triangles.push([a, b, c]);
    }

    /// The vertex on an edge from a low to a high corner, made when first needed.
    fn vertex(&mut self, corners: &[usize; 8], low: usize, high: usize) -> u32 {
        // Edges of the six tetrahedra run from a corner to one with more bits.
        let key = (corners[low.min(high)], low ^ high);
        let next = self.out.positions_mm.len() as u32;
        if let Some(&known) = self.vertex_of_edge.get(&key) {
            return known;
        }
        let part = self.part(corners[low], corners[high]);
        let [from, to] = [low, high].map(|corner| {
            let index = self.lattice.index(corners[corner]);
            self.lattice.point_mm(index)
        });
        self.vertex_of_edge.insert(key, next);
        if let Some(excess) = self.excess {
            let [from, to] = [low, high].map(|corner| excess[corners[corner]]);
            self.excess_of_vertex.push(from + (to - from) * part);
        }
        self.out.positions_mm.push(from + (to - from) * part);
        self.out.normals.push(Vector3::zeros());
        next
    }
}

/// How far from the low end of an edge the level is, 0 to 1, where its ends have these values.
fn part(from: f64, to: f64, level: f64) -> f64 {
    match to.is_finite() {
        true => ((level - from) / (to - from)).clamp(0.0, 1.0),
        false => 0.0,
    }
}

/// Which part of a tetrahedron is at most the level, from how far it is from each low corner to each
/// high one.
fn low_part(low: &[usize], high: &[usize], part: impl Fn(usize, usize) -> f64) -> f64 {
    match (low, high) {
        (&[a], &[b, c, d]) => part(a, b) * part(a, c) * part(a, d),
        (&[a, b, c], &[d]) => 1.0 - (1.0 - part(a, d)) * (1.0 - part(b, d)) * (1.0 - part(c, d)),
        (&[a, b], &[c, d]) => {
            // The prism from the triangle at a to that at b, as three tetrahedra.
            let (ac, ad, bc, bd) = (part(a, c), part(a, d), part(b, c), part(b, d));
            ac * ad + ac * (1.0 - ad) * bd + (1.0 - ac) * bc * bd
        }
        (_, &[]) => 1.0,
        _ => 0.0,
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use std::f64::consts::PI;

    pub(super) fn lattice(counts: [usize; 3], of: impl Fn(&Point3<f64>) -> f64) -> ScalarLattice {
        let mut lattice = ScalarLattice {
            bounds: Bounds::from(([-10.0, -8.0, -12.0], [14.0, 16.0, 12.0])),
            counts,
            values: Vec::new(),
        };
        lattice.values = (0..counts.iter().product())
            .map(|place| of(&lattice.point_mm(lattice.index(place))))
            .collect();
        lattice
    }

    /// Of the solid that the surface bounds, by the divergence theorem.
    fn enclosed_mm3(surface: &Isosurface) -> f64 {
        let at = |i: u32| surface.positions_mm[i as usize].coords;
        let sixth = |t: &[u32; 3]| at(t[0]).dot(&at(t[1]).cross(&at(t[2])));
        surface.triangles.iter().map(sixth).sum::<f64>() / 6.0
    }

    #[test]
    fn a_linear_scalar_gives_an_exact_plane() {
        let normal = Vector3::new(0.3, -0.5, 0.8);
        let center = Point3::new(2.0, 4.0, 0.0);
        let lattice = lattice([5, 7, 4], |p| normal.dot(&(p - center)));
        let surface = lattice.isosurface(0.0);
        assert!(surface.triangles.len() > 50);
        for (p, n) in surface.positions_mm.iter().zip(&surface.normals) {
            assert!(normal.dot(&(p - center)).abs() < 1e-13);
            assert!((n - normal.normalize()).norm() < 1e-9);
        }
        // A plane through the middle of a box halves it.
        let whole = lattice.bounds.size_mm().product();
        assert!((surface.volume_mm3 - 0.5 * whole).abs() < 1e-12 * whole);
        let x = self::lattice([4, 2, 3], |p| p.x).isosurface(-7.0);
        assert!((x.volume_mm3 - 3.0 * 24.0 * 24.0).abs() < 1e-9);
    }

    #[test]
    fn a_ball_is_closed_and_of_its_size() {
        let center = Point3::new(2.5, 3.7, 0.3);
        let radius = 7.0_f64;
        let lattice = lattice([25, 31, 28], |p| (p - center).norm_squared());
        let surface = lattice.isosurface(radius * radius);
        let h2: f64 = (0..3).map(|k| (24.0 / (lattice.counts[k] - 1) as f64).powi(2)).sum();
        // Between the lattice points the scalar is too large by at most Σ h² / 4.
        let least = (radius * radius - h2 / 4.0).sqrt();
        for (p, n) in surface.positions_mm.iter().zip(&surface.normals) {
            let r = (p - center).norm();
            assert!((least..=radius + 1e-12).contains(&r), "{r}");
            assert!(n.dot(&(p - center)) > 0.9 * r);
        }
        let ball = |r: f64| 4.0 / 3.0 * PI * r.powi(3);
        assert!((ball(least)..ball(radius)).contains(&surface.volume_mm3));
        assert!((enclosed_mm3(&surface) - surface.volume_mm3).abs() < 1e-9 * ball(radius));
        // Each edge is that of one triangle there and of one back: nothing is open.
        let mut edges: HashMap<(u32, u32), i32> = HashMap::new();
        for t in &surface.triangles {
            for (a, b) in [(t[0], t[1]), (t[1], t[2]), (t[2], t[0])] {
                *edges.entry((a.min(b), a.max(b))).or_default() += if a < b { 1 } else { -1 };
            }
        }
        assert!(edges.values().all(|turns| *turns == 0));
        let euler =
            surface.positions_mm.len() as i64 - edges.len() as i64 + surface.triangles.len() as i64;
        assert_eq!(euler, 2);
    }

    #[test]
    fn no_crossing_has_no_surface() {
        let lattice = lattice([3, 3, 3], |p| p.x);
        let all = lattice.isosurface(14.0);
        assert!(all.triangles.is_empty());
        assert_eq!(all.volume_mm3, lattice.bounds.size_mm().product());
        assert_eq!(lattice.isosurface(-10.1), Isosurface::default());
        assert_eq!(self::lattice([1, 3, 3], |p| p.x).isosurface(0.0), Isosurface::default());
    }

    #[test]
    fn what_is_infinite_or_no_number_is_never_reached() {
        for beyond in [f64::INFINITY, f64::NAN] {
            let lattice = lattice([5, 3, 3], |p| if p.x > 3.0 { beyond } else { 1.0 });
            let surface = lattice.isosurface(2.0);
            assert!(surface.positions_mm.iter().all(|p| p.x == 2.0));
            let whole = lattice.bounds.size_mm().product();
            assert!((surface.volume_mm3 - 0.5 * whole).abs() < 1e-9);
        }
    }
}
