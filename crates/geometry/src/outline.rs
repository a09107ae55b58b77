//! Lines that show where a volume ends, and the lengths that give its size.

use super::bounds::Bounds;
use nalgebra::Point3;

/// How much of an edge of a box, or of a quarter of a rim or the wall between rims, a bracket covers.
pub(super) const BRACKET_SHARE: f64 = 0.09;

/// What a volume is drawn with: polylines in the tracker frame, mm.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Outline {
    pub lines: Vec<Vec<Point3<f64>>>,
    /// Short pieces of them that make corners and rims stand out.
    pub brackets: Vec<Vec<Point3<f64>>>,
}

/// A length of a volume, and where on its outline it may be written.
#[derive(Clone, Debug, PartialEq)]
pub struct Dimension {
    pub kind: DimensionKind,
    pub length_mm: f64,
    /// Tracker frame; they are equivalent.
    pub places_mm: Vec<Point3<f64>>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DimensionKind {
    Side,
    Diameter,
    /// From the top to the farthest point.
    Depth,
}

impl Outline {
    /// The twelve edges of a box, and brackets at its corners.
    pub fn of_box(bounds: &Bounds) -> Self {
        let corners = bounds.corners_mm();
        let edges = (0..8usize).flat_map(|i| {
            [1, 2, 4].into_iter().filter(move |bit| i & bit == 0).map(move |bit| [i, i | bit])
        });
        let mut outline = Self::default();
        for [i, j] in edges {
            let [a, b] = [corners[i], corners[j]];
            outline.lines.push(vec![a, b]);
            for (corner, other) in [(a, b), (b, a)] {
                let end = corner + (other - corner) * BRACKET_SHARE;
                outline.brackets.push(vec![corner, end]);
            }
        }
        outline
    }
}

impl Dimension {
    /// The three sides of a box, each at the middles of its four edges.
    pub fn of_box(bounds: &Bounds) -> Vec<Self> {
        let corners = [bounds.min_mm, bounds.max_mm];
        [0, 1, 2]
            .map(|axis| {
                let [u, v] = [(axis + 1) % 3, (axis + 2) % 3];
                let middle = |k: usize| {
                    let mut middle = bounds.center_mm();
                    middle[u] = corners[k & 1][u];
                    middle[v] = corners[k >> 1][v];
                    middle
                };
                Self {
                    kind: DimensionKind::Side,
                    length_mm: bounds.size_mm()[axis],
                    places_mm: (0..4).map(middle).collect(),
                }
            })
            .to_vec()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_box_has_twelve_edges_along_its_axes() {
        let outline = Outline::of_box(&Bounds::from(([0.0; 3], [1.0, 2.0, 3.0])));
        assert_eq!(outline.lines.len(), 12);
        let length = |lines: &[Vec<Point3<f64>>]| -> f64 {
            lines.iter().map(|line| (line[1] - line[0]).norm()).sum()
        };
        assert_eq!(length(&outline.lines), 4.0 * (1.0 + 2.0 + 3.0));
        let brackets = 2.0 * BRACKET_SHARE * length(&outline.lines);
        assert!((length(&outline.brackets) - brackets).abs() < 1e-12);
    }
}
