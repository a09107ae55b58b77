//! Corners at one place as one vertex, however a file has them.

use nalgebra::Point3;
use rayon::slice::ParallelSliceMut;

/// Coordinates that differ by less than this part of the largest one are the same: a hundred times
/// what computing a corner twice in f64 leaves, and a thousandth of what f32 keeps apart.
const SAME_PART: f64 = 1e-10;

/// The vertex of each point, counted from 0 in the order in which places are first met.
///
/// Points are one vertex where all their coordinates are the same up to round-off. Each coordinate is
/// rounded by itself, along its sorted values, so that no limit between two cells parts what is
/// `1e-16` mm apart.
///
/// ```
/// use nalgebra::Point3;
/// use trackwright_geometry::weld::welded;
///
/// let points = [Point3::new(1.0, 0.0, 5.0), Point3::origin(), Point3::new(1.0, 1e-16, 5.0)];
/// assert_eq!(welded(&points), [0, 1, 0]);
/// ```
pub fn welded(positions_mm: &[Point3<f64>]) -> Vec<u32> {
    let largest = positions_mm.iter().map(|p| p.coords.amax()).filter(|size| size.is_finite());
    let tolerance_mm = largest.fold(0.0, f64::max) * SAME_PART;
    let ranks = [0, 1, 2].map(|axis| ranks(positions_mm, axis, tolerance_mm));
    let place = |index: u32| [0, 1, 2].map(|axis: usize| ranks[axis][index as usize]);
    let mut order: Vec<u32> = (0..positions_mm.len() as u32).collect();
    // The index decides between equals: the first of a place comes first.
    order.par_sort_unstable_by_key(|&index| (place(index), index));
    let mut first = vec![0_u32; positions_mm.len()];
    for same in order.chunk_by(|a, b| place(*a) == place(*b)) {
        for &index in same {
            first[index as usize] = same[0];
        }
    }
    let mut vertices = vec![0_u32; positions_mm.len()];
    let mut count = 0;
    for index in 0..positions_mm.len() {
        let is_first = first[index] as usize == index;
        vertices[index] = if is_first { count } else { vertices[first[index] as usize] };
        count += u32::from(is_first);
    }
    vertices
}

/// For each point the rank of one coordinate among the different values that there are.
fn ranks(positions_mm: &[Point3<f64>], axis: usize, tolerance_mm: f64) -> Vec<u32> {
    let value = |index: u32| positions_mm[index as usize][axis];
    let mut order: Vec<u32> = (0..positions_mm.len() as u32).collect();
    order.par_sort_unstable_by(|&a, &b| value(a).total_cmp(&value(b)));
    let mut ranks = vec![0_u32; positions_mm.len()];
    let mut rank = 0;
    for pair in order.windows(2) {
        // A coordinate that is no number is the same as no other.
        let is_same = value(pair[1]) - value(pair[0]) <= tolerance_mm;
        rank += u32::from(!is_same);
        ranks[pair[1] as usize] = rank;
    }
    ranks
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_at_one_place_are_one_vertex() {
        let turn = std::f64::consts::PI;
        let points = [
            Point3::new(2.0, 0.0, 7.0),
            Point3::new(2.0 * turn.cos(), 2.0 * turn.sin(), 7.0),
            Point3::new(-2.0, 0.0, 7.0),
            Point3::new(2.0, -0.0, 7.0),
            Point3::new(2.0, 1e-6, 7.0),
        ];
        assert_eq!(welded(&points), [0, 1, 1, 0, 2]);
        assert!(welded(&[]).is_empty());
    }

    #[test]
    fn no_limit_parts_what_is_at_one_place() {
        // Around half a unit, where rounding to a grid would part them.
        for base in [0.0, 0.5, 1.5, -2.5, 1e3 + 0.5] {
            let points = [-1e-16, 0.0, 1e-16].map(|off| Point3::new(base + off, 1.0, base - off));
            assert_eq!(welded(&points), [0, 0, 0], "{base}");
        }
    }

    #[test]
    fn points_that_are_no_numbers_stay_apart() {
        let nan = Point3::new(f64::NAN, 0.0, 0.0);
        let points = [nan, Point3::origin(), nan, Point3::new(f64::INFINITY, 0.0, 0.0)];
        let vertices = welded(&points);
        assert_eq!(vertices.len(), 4);
        assert_ne!(vertices[0], vertices[1]);
        assert_ne!(vertices[3], vertices[1]);
    }
}
