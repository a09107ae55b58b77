//! Axis-aligned boxes in millimetres: the model's box, its unit cube, and what lies outside.

use super::limits::{position_problem, short};
use nalgebra::{Point3, Unit, Vector3};
use serde::{Deserialize, Serialize};

/// How far beyond the box, relative to its size, still counts as inside: round-off of the box
/// of the samples themselves.
pub const INSIDE_TOLERANCE: f64 = 1e-9;

/// A box along the tracker's axes, in millimetres.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(from = "([f64; 3], [f64; 3])", into = "([f64; 3], [f64; 3])")]
pub struct Bounds {
    pub min_mm: Point3<f64>,
    pub max_mm: Point3<f64>,
}

/// Why two corners are no box.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum BoundsError {
    #[error("{corner} is ({}), expected {expected}", list(corner_mm))]
    Corner {
        /// "min" or "max".
        corner: &'static str,
        corner_mm: [f64; 3],
        expected: &'static str,
    },
    #[error(
        "min {axis} is {}, max {axis} is {}, expected min at most max",
        short(*min_mm),
        short(*max_mm)
    )]
    Reversed { axis: char, min_mm: f64, max_mm: f64 },
}

fn list(values: &[f64; 3]) -> String {
    values.map(short).join(", ")
}

impl Bounds {
    /// Checks that this is a box where anything is: [`check_finite`](Self::check_finite), and its
    /// corners are positions.
    pub fn check(&self) -> Result<(), BoundsError> {
        for (corner, point) in [("min", self.min_mm), ("max", self.max_mm)] {
            if let Some(expected) = position_problem(&point.coords) {
                return Err(BoundsError::Corner {
                    corner,
                    corner_mm: point.coords.into(),
                    expected,
                });
            }
        }
        self.check_finite()
    }

    /// Checks that this is a box: finite, and no axis reversed. One without extent along an axis is
    /// a box.
    pub fn check_finite(&self) -> Result<(), BoundsError> {
        let size_mm = self.size_mm();
        // Where a corner is not finite, neither is the size.
        if !size_mm.iter().all(|edge| edge.is_finite()) {
            return Err(BoundsError::Corner {
                corner: "max",
                corner_mm: self.max_mm.coords.into(),
                expected: "finite numbers, and edges of finite length",
            });
        }
        for (k, axis) in ['x', 'y', 'z'].into_iter().enumerate() {
            let (min_mm, max_mm) = (self.min_mm[k], self.max_mm[k]);
            if min_mm > max_mm {
                return Err(BoundsError::Reversed { axis, min_mm, max_mm });
            }
        }
        Ok(())
    }

    /// The smallest box around the points; `None` without any.
    ///
    /// ```
    /// use nalgebra::Point3;
    /// use trackwright_geometry::bounds::Bounds;
    ///
    /// let corners = [Point3::new(0.0, 5.0, 2.0), Point3::new(4.0, 1.0, 2.0)];
    /// let bounds = Bounds::around(corners).unwrap();
    /// assert_eq!(bounds.center_mm(), Point3::new(2.0, 3.0, 2.0));
    /// assert!(!bounds.contains(&Point3::origin()));
    /// ```
    pub fn around(points: impl IntoIterator<Item = Point3<f64>>) -> Option<Self> {
        points.into_iter().fold(None, |bounds: Option<Self>, p| {
            Some(match bounds {
                None => Self { min_mm: p, max_mm: p },
                Some(b) => Self { min_mm: b.min_mm.inf(&p), max_mm: b.max_mm.sup(&p) },
            })
        })
    }

    /// What two boxes have in common, if only a face; `None` where they are apart.
    pub fn intersection(&self, other: &Self) -> Option<Self> {
        let (min_mm, max_mm) = (self.min_mm.sup(&other.min_mm), self.max_mm.inf(&other.max_mm));
        (0..3).all(|k| min_mm[k] <= max_mm[k]).then_some(Self { min_mm, max_mm })
    }

    /// The box with a part of its size added at each face.
    pub fn grown(&self, part: f64) -> Self {
        let more_mm = self.size_mm() * part;
        Self { min_mm: self.min_mm - more_mm, max_mm: self.max_mm + more_mm }
    }

    /// Lengths of the edges.
    #[inline]
    pub fn size_mm(&self) -> Vector3<f64> {
        self.max_mm - self.min_mm
    }

    /// Middle of the box.
    #[inline]
    pub fn center_mm(&self) -> Point3<f64> {
        nalgebra::center(&self.min_mm, &self.max_mm)
    }

    /// Length of the diagonal.
    pub fn diagonal_mm(&self) -> f64 {
        self.size_mm().norm()
    }

    /// Position in the unit cube; an axis without extent maps to 0.
    #[inline]
    pub fn to_unit(&self, point_mm: &Point3<f64>) -> Vector3<f64> {
        let size = self.size_mm();
        (point_mm - self.min_mm).zip_map(&size, |d, s| if s > 0.0 { d / s } else { 0.0 })
    }

    /// The nearest point of the closed box; what is not a number stays that.
    #[inline]
    pub fn clamp(&self, point_mm: &Point3<f64>) -> Point3<f64> {
        Point3::from(Vector3::from_fn(|k, _| {
            let (x, min, max) = (point_mm[k], self.min_mm[k], self.max_mm[k]);
            // `f64::max` and `min` would turn NaN into a corner.
            if x < min {
                min
            } else if x > max {
                max
            } else {
                x
            }
        }))
    }

    /// Whether the point is in the box, give or take [`INSIDE_TOLERANCE`] of its size.
    #[inline]
    pub fn contains(&self, point_mm: &Point3<f64>) -> bool {
        let slack = self.size_mm() * INSIDE_TOLERANCE;
        (0..3).all(|k| {
            point_mm[k] >= self.min_mm[k] - slack[k] && point_mm[k] <= self.max_mm[k] + slack[k]
        })
    }

    /// From where to where the box reaches along a direction, from the frame's origin.
    pub fn span_mm(&self, direction: &Unit<Vector3<f64>>) -> [f64; 2] {
        let along = self.corners_mm().map(|corner| direction.dot(&corner.coords));
        [
            along.iter().copied().fold(f64::INFINITY, f64::min),
            along.iter().copied().fold(f64::NEG_INFINITY, f64::max),
        ]
    }

    /// The eight corners, x fastest.
    pub fn corners_mm(&self) -> [Point3<f64>; 8] {
        std::array::from_fn(|i| {
            Point3::from(Vector3::from_fn(|k, _| {
                if i >> k & 1 == 0 { self.min_mm[k] } else { self.max_mm[k] }
            }))
        })
    }
}

impl From<([f64; 3], [f64; 3])> for Bounds {
    fn from((min, max): ([f64; 3], [f64; 3])) -> Self {
        Self { min_mm: min.into(), max_mm: max.into() }
    }
}

impl From<Bounds> for ([f64; 3], [f64; 3]) {
    fn from(b: Bounds) -> Self {
        (b.min_mm.coords.into(), b.max_mm.coords.into())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cube() -> Bounds {
        Bounds::from(([-1.0, -2.0, -3.0], [1.0, 2.0, 3.0]))
    }

    #[test]
    fn boxes_are_finite_in_order_and_in_files_near() {
        let bounds = |min: f64, max: f64| Bounds::from(([0.0, min, 0.0], [1.0, max, 0.0]));
        assert_eq!(bounds(-1.0, -1.0).check(), Ok(()));
        let reversed = bounds(2.5, -1.0).check().unwrap_err().to_string();
        assert_eq!(reversed, "min y is 2.5, max y is -1, expected min at most max");
        let far = bounds(1e6, 1e6 + 300.0);
        assert_eq!(far.check_finite(), Ok(()));
        let far = far.check().unwrap_err().to_string();
        assert_eq!(far, "max is (1, 1000300, 0), expected coordinates of at most 1e6 mm");
        for (min, max) in [(-1.5e308, 1.5e308), (0.0, f64::INFINITY), (f64::NAN, 1.0)] {
            assert!(bounds(min, max).check_finite().is_err());
        }
    }

    #[test]
    fn corners_map_to_the_corners_of_the_unit_cube() {
        let corners = cube().corners_mm();
        assert_eq!(cube().to_unit(&corners[0]), Vector3::zeros());
        assert_eq!(cube().to_unit(&corners[7]), Vector3::repeat(1.0));
    }

    #[test]
    fn only_round_off_outside_counts_as_inside() {
        assert!(cube().contains(&Point3::new(1.0 + 1e-9, 0.0, 0.0)));
        assert!(!cube().contains(&Point3::new(1.0 + 1e-8, 0.0, 0.0)));
        assert!(!cube().contains(&Point3::new(f64::NAN, 0.0, 0.0)));
    }

    #[test]
    fn a_flat_box_still_normalises() {
        let flat = Bounds::from(([0.0; 3], [1.0, 0.0, 1.0]));
        assert_eq!(flat.to_unit(&Point3::new(0.5, 0.0, 1.0)), Vector3::new(0.5, 0.0, 1.0));
    }
}
