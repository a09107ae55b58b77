//! Unions of boxes, kept short: what a brush adds to them, and an eraser takes out of them, as it is
//! dragged over a surface.

use super::bounds::Bounds;
use nalgebra::{Point3, Vector3};

/// Middles of brushed boxes are rounded to this part of their edge, so that strokes that run beside
/// each other share sides and become one box.
const GRID_PER_EDGE: f64 = 0.25;

/// Boxes of a stroke are this part of their edge apart.
const STEP_PER_EDGE: f64 = 0.5;

/// A stroke has no more boxes than this: a pointer that jumps far leaves a gap rather than a pause.
const MOST_STEPS: f64 = 200.0;

/// What is thinner is round-off, and is not left of a box that is cut.
const SLIVER_MM: f64 = 1e-6;

/// The cubes of an edge that a stroke from one point to another covers. Where they begin is the same
/// for every stroke: all are on one grid.
///
/// ```
/// use nalgebra::Point3;
/// use trackwright_geometry::box_union::stroke;
///
/// let [from, to] = [Point3::origin(), Point3::new(10.0, 0.0, 0.0)];
/// let cubes: Vec<_> = stroke(&from, &to, 4.0).collect();
/// assert!(cubes[0].contains(&from) && cubes[5].contains(&to));
/// ```
pub fn stroke(
    from_mm: &Point3<f64>,
    to_mm: &Point3<f64>,
    edge_mm: f64,
) -> impl Iterator<Item = Bounds> + use<> {
    let (from_mm, along) = (*from_mm, to_mm - from_mm);
    let steps = (along.norm() / (edge_mm * STEP_PER_EDGE)).ceil().clamp(1.0, MOST_STEPS);
    let grid_mm = edge_mm * GRID_PER_EDGE;
    (0..=steps as u32).map(move |step| {
        let at = from_mm + along * (f64::from(step) / steps);
        let middle = at.map(|x| (x / grid_mm).round() * grid_mm);
        let half = Vector3::repeat(edge_mm / 2.0);
        Bounds { min_mm: middle - half, max_mm: middle + half }
    })
}

/// Adds a box to a union: nothing where another contains it, and in place of those that it contains.
/// Boxes that make one box together become that one.
pub fn add_box(union: &mut Vec<Bounds>, new: Bounds) {
    let mut new = new;
    // Each box that is merged away leaves a shorter union.
    loop {
        if union.iter().any(|own| is_within(&new, own)) {
            return;
        }
        union.retain(|own| !is_within(own, &new));
        let Some((index, both)) =
            union.iter().enumerate().find_map(|(index, own)| Some((index, joined(own, &new)?)))
        else {
            break;
        };
        union.remove(index);
        new = both;
    }
    union.push(new);
}

/// Takes a box out of a union: in place of those that reach into it comes what is left of them.
pub fn remove_box(union: &mut Vec<Bounds>, removed: &Bounds) {
    let reaches_in = |own: &Bounds| {
        (0..3).all(|k| {
            own.max_mm[k] - removed.min_mm[k] > SLIVER_MM
                && removed.max_mm[k] - own.min_mm[k] > SLIVER_MM
        })
    };
    let (cut, kept) = union.iter().partition(|own| reaches_in(own));
    let cut: Vec<Bounds> = cut;
    *union = kept;
    for piece in cut.iter().flat_map(|own| pieces(own, removed)) {
        add_box(union, piece);
    }
}

/// What is left of a box without another that reaches into it: at most six boxes.
fn pieces(own: &Bounds, removed: &Bounds) -> Vec<Bounds> {
    let (mut left, mut pieces) = (*own, Vec::new());
    for axis in 0..3 {
        let [from, to] = [removed.min_mm[axis], removed.max_mm[axis]];
        if from - left.min_mm[axis] > SLIVER_MM {
            let mut piece = left;
            (piece.max_mm[axis], left.min_mm[axis]) = (from, from);
            pieces.push(piece);
        }
        if left.max_mm[axis] - to > SLIVER_MM {
            let mut piece = left;
            (piece.min_mm[axis], left.max_mm[axis]) = (to, to);
            pieces.push(piece);
        }
    }
    pieces
}

/// The box around two points with at least an edge along each axis, half of it on either side of them.
pub fn box_between(a_mm: &Point3<f64>, b_mm: &Point3<f64>, edge_mm: f64) -> Bounds {
    let half = Vector3::repeat(edge_mm / 2.0);
    Bounds { min_mm: a_mm.inf(b_mm) - half, max_mm: a_mm.sup(b_mm) + half }
}

fn is_within(inner: &Bounds, outer: &Bounds) -> bool {
    inner.min_mm >= outer.min_mm && inner.max_mm <= outer.max_mm
}

/// The box that two boxes make together; `None` where theirs is another shape.
fn joined(a: &Bounds, b: &Bounds) -> Option<Bounds> {
    let is_same = |k: usize| a.min_mm[k] == b.min_mm[k] && a.max_mm[k] == b.max_mm[k];
    let meets = |k: usize| a.min_mm[k] <= b.max_mm[k] && b.min_mm[k] <= a.max_mm[k];
    let is_box = (0..3).any(|k| meets(k) && (0..3).all(|other| other == k || is_same(other)));
    is_box.then(|| Bounds { min_mm: a.min_mm.inf(&b.min_mm), max_mm: a.max_mm.sup(&b.max_mm) })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(min: [f64; 3], max: [f64; 3]) -> Bounds {
        Bounds::from((min, max))
    }

    fn union(boxes: &[Bounds]) -> Vec<Bounds> {
        let mut union = Vec::new();
        for own in boxes {
            add_box(&mut union, *own);
        }
        union
    }

    #[test]
    fn contained_boxes_are_merged() {
        let [small, large] = [of([1.0; 3], [2.0; 3]), of([0.0; 3], [3.0; 3])];
        assert_eq!(union(&[small, large]), [large]);
        assert_eq!(union(&[large, small]), [large]);
        let far = of([5.0; 3], [6.0; 3]);
        assert_eq!(union(&[small, far, large]), [far, large]);
    }

    #[test]
    fn boxes_that_make_a_box_become_one() {
        let row = [0.0, 2.0, 1.0].map(|x| of([x, 0.0, 0.0], [x + 1.0, 1.0, 1.0]));
        assert_eq!(union(&row), [of([0.0; 3], [3.0, 1.0, 1.0])]);
        // A corner between them is in neither.
        let bent = [of([0.0; 3], [2.0, 1.0, 1.0]), of([0.0; 3], [1.0, 2.0, 1.0])];
        assert_eq!(union(&bent), bent);
        let apart = [0.0, 1.5].map(|x| of([x, 0.0, 0.0], [x + 1.0, 1.0, 1.0]));
        assert_eq!(union(&apart), apart);
    }

    #[test]
    fn a_stroke_covers_its_line_without_gaps() {
        let [from, to] = [Point3::new(0.3, -7.1, 4.0), Point3::new(9.0, 3.0, -2.5)];
        const EDGE_MM: f64 = 3.0;
        let cubes: Vec<Bounds> = stroke(&from, &to, EDGE_MM).collect();
        for step in 0..=1000 {
            let at = from + (to - from) * (f64::from(step) / 1000.0);
            assert!(cubes.iter().any(|cube| cube.contains(&at)), "{at}");
        }
        let sizes = cubes.iter().map(|cube| cube.size_mm());
        assert!(sizes.into_iter().all(|size| (size - Vector3::repeat(EDGE_MM)).norm() < 1e-12));
        let dot: Vec<Bounds> = stroke(&from, &from, EDGE_MM).collect();
        assert_eq!(union(&dot).len(), 1);
    }

    #[test]
    fn a_stroke_along_an_axis_is_one_box() {
        let [from, to] = [Point3::origin(), Point3::new(0.0, 0.0, 60.0)];
        let cubes: Vec<Bounds> = stroke(&from, &to, 4.0).collect();
        assert_eq!(union(&cubes), [of([-2.0; 3], [2.0, 2.0, 62.0])]);
    }

    #[test]
    fn a_removed_box_is_out_and_the_rest_stays() {
        let whole = of([0.0; 3], [10.0; 3]);
        let beside = of([10.0, 0.0, 0.0], [14.0, 10.0, 5.0]);
        for removed in [
            of([3.0; 3], [6.0; 3]),
            of([-5.0, 2.0, 2.0], [5.0, 4.0, 20.0]),
            of([8.0, -1.0, -1.0], [12.0, 11.0, 11.0]),
            of([1.0, 9.0, 4.0], [20.0, 30.0, 7.0]),
        ] {
            let mut left = union(&[whole, beside]);
            remove_box(&mut left, &removed);
            assert!(left.iter().all(|own| own.check().is_ok()), "{left:?}");
            // On a grid that lies on no face.
            for index in 0..20 * 20 * 20 {
                let at = [index % 20, index / 20 % 20, index / 400];
                let at = Point3::from(at.map(|k| f64::from(k) * 0.83 - 0.41));
                let was = [whole, beside].iter().any(|own| own.contains(&at));
                let is = left.iter().any(|own| own.contains(&at));
                assert_eq!(is, was && !removed.contains(&at), "{at} {removed:?}");
            }
        }
    }

    #[test]
    fn what_a_removed_box_misses_is_unchanged() {
        let own = union(&[of([0.0; 3], [1.0; 3]), of([3.0; 3], [4.0; 3])]);
        let mut left = own.clone();
        // Beside the first: they have a side in common.
        remove_box(&mut left, &of([1.0, 0.0, 0.0], [2.0, 1.0, 1.0]));
        assert_eq!(left, own);
        remove_box(&mut left, &of([-1.0; 3], [2.0; 3]));
        assert_eq!(left, own[1..]);
        remove_box(&mut left, &of([3.0 - 1e-9, 3.0, 3.0], [4.0, 4.0, 4.0 - 1e-9]));
        assert_eq!(left, []);
    }

    #[test]
    fn a_stroke_back_over_a_stroke_removes_it() {
        let [from, to] = [Point3::new(0.3, -7.1, 4.0), Point3::new(9.0, 3.0, -2.5)];
        let cubes: Vec<Bounds> = stroke(&from, &to, 3.0).collect();
        let mut left = union(&cubes);
        for cube in &cubes {
            remove_box(&mut left, cube);
        }
        assert_eq!(left, []);
    }

    #[test]
    fn a_box_between_points_has_an_extent() {
        let point = Point3::new(1.0, 2.0, 3.0);
        assert_eq!(box_between(&point, &point, 2.0), of([0.0, 1.0, 2.0], [2.0, 3.0, 4.0]));
        let [a, b] = [Point3::new(0.0, 5.0, 0.0), Point3::new(4.0, 0.0, 0.0)];
        assert_eq!(box_between(&a, &b, 2.0), of([-1.0, -1.0, -1.0], [5.0, 6.0, 1.0]));
    }
}
