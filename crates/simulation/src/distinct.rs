//! Whether an optical tracker can distinguish tools by their markers: it sees places only, so that
//! it knows a tool by the distances and angles between them.

use nalgebra::Point3;
use serde::Serialize;

/// Distances that differ by less may be taken for each other: ten standard deviations of the distance
/// between two markers that are localised to 0.25 mm RMS each.
pub const LEAST_MM: f64 = 3.5;

/// Fewest markers that a pose is computed from.
const MARKERS_OF_POSE: usize = 3;

/// Whether a tracker can distinguish two tools.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Distinction {
    /// Any three markers of one differ from any three of the other.
    Apart,
    /// Where three markers are seen, and others are hidden, one may be taken for the other.
    ThreeMarkersAlike,
    /// All markers of the smaller tool are found in the other.
    Alike,
}

/// Two tools, or two ways to see one.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Comparison {
    pub distinction: Distinction,
    /// The three markers of each that are most alike, from 0, in order.
    pub markers: [[usize; MARKERS_OF_POSE]; 2],
    /// The most that their distances differ by, mm.
    pub distance_mm: f64,
    /// The most that the angles of their triangles differ by, degrees.
    pub angle_deg: f64,
}

/// Compares the markers of two tools; `None` where one of them has fewer than three.
pub fn compare_tools(a: &[Point3<f64>], b: &[Point3<f64>], least_mm: f64) -> Option<Comparison> {
    compare(a, b, least_mm, |_, _| true)
}

/// Compares a tool with itself: whether it looks the same from two sides, so that its pose has two
/// answers; `None` where it has fewer than three markers.
pub fn compare_with_itself(markers: &[Point3<f64>], least_mm: f64) -> Option<Comparison> {
    // Each marker for itself is no other way to see it.
    compare(markers, markers, least_mm, |own, other| own != other)
}

fn compare(
    a: &[Point3<f64>],
    b: &[Point3<f64>],
    least_mm: f64,
    is_another: impl Fn([usize; 3], [usize; 3]) -> bool,
) -> Option<Comparison> {
    let (a, b, is_swapped) = match a.len() <= b.len() {
        true => (a, b, false),
        false => (b, a, true),
    };
    let mut nearest: Option<Comparison> = None;
    let mut is_alike = false;
    for own in triples(a.len()).filter(|t| t[0] < t[1] && t[1] < t[2]) {
        let sides = side_lengths_mm(a, own);
        for other in triples(b.len()).filter(|other| is_another(own, *other)) {
            let theirs = side_lengths_mm(b, other);
            let distance_mm = largest_difference(sides, theirs);
            is_alike |= distance_mm < least_mm && extends((a, own), (b, other), least_mm);
            if nearest.is_none_or(|found| distance_mm < found.distance_mm) {
                let markers = match is_swapped {
                    true => [other, own],
                    false => [own, other],
                };
                nearest = Some(Comparison {
                    distinction: Distinction::Apart,
                    markers,
                    distance_mm,
                    angle_deg: largest_difference(angles_deg(sides), angles_deg(theirs)),
                });
            }
        }
    }
    nearest.map(|found| Comparison {
        distinction: match found.distance_mm < least_mm {
            false => Distinction::Apart,
            true if is_alike => Distinction::Alike,
            true => Distinction::ThreeMarkersAlike,
        },
        ..found
    })
}

/// Three different numbers below `count`, in every order.
fn triples(count: usize) -> impl Iterator<Item = [usize; 3]> {
    let pairs = move |i: usize| (0..count).filter(move |j| *j != i).map(move |j| [i, j]);
    (0..count).flat_map(pairs).flat_map(move |[i, j]| {
        (0..count).filter(move |k| *k != i && *k != j).map(move |k| [i, j, k])
    })
}

/// Opposite to each marker of three.
fn side_lengths_mm(markers: &[Point3<f64>], [i, j, k]: [usize; 3]) -> [f64; 3] {
    let length = |a: usize, b: usize| (markers[a] - markers[b]).norm();
    [length(j, k), length(k, i), length(i, j)]
}

/// At each marker, by the law of cosines.
fn angles_deg([a, b, c]: [f64; 3]) -> [f64; 3] {
    let angle = |opposite: f64, x: f64, y: f64| {
        let cosine = (x * x + y * y - opposite * opposite) / (2.0 * x * y);
        match cosine.is_finite() {
            true => cosine.clamp(-1.0, 1.0).acos().to_degrees(),
            // Two markers in one place.
            false => 0.0,
        }
    };
    [angle(a, b, c), angle(b, c, a), angle(c, a, b)]
}

fn largest_difference(a: [f64; 3], b: [f64; 3]) -> f64 {
    let each = a.iter().zip(b).map(|(a, b)| (a - b).abs());
    each.fold(0.0, f64::max)
}

/// Whether every further marker of the smaller tool is where the other has one, seen from the three
/// that match: its distances to them and the side of their plane that it is on.
fn extends(
    (a, own): (&[Point3<f64>], [usize; 3]),
    (b, other): (&[Point3<f64>], [usize; 3]),
    least_mm: f64,
) -> bool {
    let rest =
        |count: usize, used: [usize; 3]| (0..count).filter(move |marker| !used.contains(marker));
    rest(a.len(), own).all(|mine| {
        rest(b.len(), other).any(|theirs| {
            let distances = own.iter().zip(other).all(|(&o, t)| {
                let [x, y] = [(a[mine] - a[o]).norm(), (b[theirs] - b[t]).norm()];
                (x - y).abs() < least_mm
            });
            let heights = [height_mm(a, own, mine), height_mm(b, other, theirs)];
            distances && (heights[0] - heights[1]).abs() < least_mm
        })
    })
}

/// Of a marker over the plane of three, positive where they run counter-clockwise; a mirrored tool has
/// the other sign.
fn height_mm(markers: &[Point3<f64>], [i, j, k]: [usize; 3], marker: usize) -> f64 {
    let normal = (markers[j] - markers[i]).cross(&(markers[k] - markers[i]));
    let normal = normal.try_normalize(0.0).unwrap_or_default();
    normal.dot(&(markers[marker] - markers[i]))
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};

    fn tool(places: &[[f64; 3]]) -> Vec<Point3<f64>> {
        places.iter().map(|p| Point3::from(*p)).collect()
    }

    fn scalene() -> Vec<Point3<f64>> {
        // No two of its six distances are alike.
        tool(&[[0.0; 3], [50.0, 0.0, 0.0], [0.0, 75.0, 0.0], [-35.0, -20.0, 100.0]])
    }

    #[test]
    fn a_moved_tool_is_alike_and_its_mirror_image_is_not() {
        let turn = UnitQuaternion::new(Vector3::new(0.3, -1.0, 0.5));
        let moved = Isometry3::from_parts(Translation3::new(5.0, 6.0, 7.0), turn);
        let mut copy: Vec<_> = scalene().iter().map(|p| moved * p).collect();
        copy.swap(0, 2);
        let found = compare_tools(&scalene(), &copy, LEAST_MM).unwrap();
        assert_eq!(found.distinction, Distinction::Alike);
        assert!(found.distance_mm < 1e-12 && found.angle_deg < 1e-5, "{found:?}");
        let mirrored: Vec<_> = scalene().iter().map(|p| Point3::new(p.x, p.y, -p.z)).collect();
        let found = compare_tools(&scalene(), &mirrored, LEAST_MM).unwrap();
        assert_eq!(found.distinction, Distinction::ThreeMarkersAlike);
    }

    #[test]
    fn tools_of_other_distances_are_apart() {
        let other = tool(&[[0.0; 3], [110.0, 0.0, 0.0], [0.0, 140.0, 0.0]]);
        let found = compare_tools(&scalene(), &other, LEAST_MM).unwrap();
        assert_eq!(found.distinction, Distinction::Apart);
        // The least by which a side differs at most, whatever the order.
        assert!(found.distance_mm > LEAST_MM, "{found:?}");
        let back = compare_tools(&other, &scalene(), LEAST_MM).unwrap();
        assert_eq!(back.distance_mm, found.distance_mm);
        assert_eq!(compare_tools(&scalene(), &other[..2], LEAST_MM), None);
    }

    #[test]
    fn a_symmetric_tool_is_its_own_double() {
        let square = tool(&[[0.0; 3], [60.0, 0.0, 0.0], [60.0, 60.0, 0.0], [0.0, 60.0, 0.0]]);
        let found = compare_with_itself(&square, LEAST_MM).unwrap();
        assert_eq!((found.distinction, found.distance_mm), (Distinction::Alike, 0.0));
        let found = compare_with_itself(&scalene(), LEAST_MM).unwrap();
        assert_eq!(found.distinction, Distinction::Apart);
    }

    #[test]
    fn angles_of_a_triangle_sum_to_half_a_turn() {
        let [a, b, c] = angles_deg([3.0, 4.0, 5.0]);
        assert!((a + b + c - 180.0).abs() < 1e-12 && (c - 90.0).abs() < 1e-12);
        assert_eq!(angles_deg([0.0; 3]), [0.0; 3]);
    }
}
