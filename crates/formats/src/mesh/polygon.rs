//! Polygons to triangles: a fan where that is right, ears cut off where it would cross itself.

use earcut::Earcut;
use earcut::utils3d::project3d_to_2d;
use nalgebra::{Point3, Vector3};

/// Cuts polygons, one after the other, with memory that it keeps.
#[derive(Default)]
pub(super) struct Cutter {
    earcut: Option<Earcut<f64>>,
    corners: Vec<[f64; 3]>,
    flat: Vec<[f64; 2]>,
    cut: Vec<u32>,
}

impl Cutter {
    /// The triangles of a polygon as places in its list of corners, which are finite; they turn as
    /// it does. Fewer than three corners make none.
    pub(super) fn triangles(&mut self, polygon_mm: &[Point3<f64>]) -> &[u32] {
        let count = polygon_mm.len() as u32;
        self.cut.clear();
        if count > 3 && !is_convex(polygon_mm) {
            self.cut_ears(polygon_mm);
        }
        // A polygon that crosses itself, or has no area, may come back incomplete.
        if self.cut.len() != 3 * polygon_mm.len().saturating_sub(2) {
            self.cut.clear();
            self.cut.extend((2..count).flat_map(|k| [0, k - 1, k]));
        }
        &self.cut
    }

    fn cut_ears(&mut self, polygon_mm: &[Point3<f64>]) {
        self.corners.clear();
        self.corners.extend(polygon_mm.iter().map(|p| <[f64; 3]>::from(p.coords)));
        let corners = &self.corners;
        if !project3d_to_2d(corners, corners.len(), &mut self.flat) {
            return;
        }
        let earcut = self.earcut.get_or_insert_with(Earcut::new);
        earcut.earcut(self.flat.iter().copied(), &[], &mut self.cut);
        let corner = |k: usize| polygon_mm[self.cut[k] as usize];
        let area: Vector3<f64> = (0..self.cut.len() / 3)
            .map(|t| doubled_area(corner(3 * t), corner(3 * t + 1), corner(3 * t + 2)))
            .sum();
        if area.dot(&polygon_area(polygon_mm)) < 0.0 {
            for triangle in self.cut.chunks_exact_mut(3) {
                triangle.swap(1, 2);
            }
        }
    }
}

/// Whether the triangles of a fan all turn as the polygon does.
fn is_convex(polygon_mm: &[Point3<f64>]) -> bool {
    let area = polygon_area(polygon_mm);
    let first = polygon_mm[0];
    polygon_mm[1..].windows(2).all(|pair| doubled_area(first, pair[0], pair[1]).dot(&area) >= 0.0)
}

/// Twice its area along its normal (Newell).
fn polygon_area(polygon_mm: &[Point3<f64>]) -> Vector3<f64> {
    let first = polygon_mm[0];
    polygon_mm[1..].windows(2).map(|pair| doubled_area(first, pair[0], pair[1])).sum()
}

fn doubled_area(a: Point3<f64>, b: Point3<f64>, c: Point3<f64>) -> Vector3<f64> {
    (b - a).cross(&(c - a))
}
