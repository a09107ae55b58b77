//! Where a slice is sampled: a lattice in a plane across one of the tracker's axes, or in any plane.

use nalgebra::{Point3, Unit, Vector3};
use trackwright_geometry::bounds::Bounds;

/// Shortest part of a direction that still turns a plane about its normal.
const MIN_UP: f64 = 1e-9;

/// Where to sample, and for which sensor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SlicePlan {
    pub plane: SlicePlane,
    /// The axis of the sensor that is imagined at each point, tracker frame; quantities of the
    /// tool have no use for it.
    pub sensor_axis: Unit<Vector3<f64>>,
    /// Points along the plane's two axes; at least 2 each.
    pub counts: [usize; 2],
}

/// A rectangle in the tracker frame, mm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SlicePlane {
    /// Across one of the tracker's axes, over a box.
    Across {
        /// 0, 1 or 2: the plane lies across x, y or z.
        normal_axis: usize,
        position_mm: f64,
        bounds: Bounds,
    },
    /// Any rectangle.
    Free {
        /// The corner where the lattice begins.
        origin_mm: Point3<f64>,
        /// Perpendicular to each other.
        axes: [Unit<Vector3<f64>>; 2],
        /// Length of the sides along the axes.
        sizes_mm: [f64; 2],
    },
}

impl SlicePlane {
    /// The plane through a point that faces along `normal`, its second axis as near to `up` as
    /// that allows, and just large enough to hold the shadow of a box along the normal.
    pub fn facing(
        bounds: &Bounds,
        through_mm: &Point3<f64>,
        normal: &Unit<Vector3<f64>>,
        up: &Vector3<f64>,
    ) -> Self {
        let upright = up - normal.into_inner() * normal.dot(up);
        let v = Unit::try_new(upright, MIN_UP * up.norm())
            .unwrap_or_else(|| trackwright_geometry::rotation::perpendicular(normal));
        let axes = [Unit::new_normalize(v.cross(normal)), v];
        let spans = axes.map(|axis| {
            let along = bounds.corners_mm().map(|corner| axis.dot(&(corner - through_mm)));
            (
                along.iter().copied().fold(f64::INFINITY, f64::min),
                along.iter().copied().fold(f64::NEG_INFINITY, f64::max),
            )
        });
        let [from_u, from_v] = [0, 1].map(|k| axes[k].into_inner() * spans[k].0);
        Self::Free {
            origin_mm: through_mm + from_u + from_v,
            axes,
            sizes_mm: spans.map(|(from, to)| to - from),
        }
    }

    /// The directions in which the lattice runs.
    pub fn axes(&self) -> [Unit<Vector3<f64>>; 2] {
        match self {
            Self::Across { normal_axis, .. } => others(*normal_axis).map(unit),
            Self::Free { axes, .. } => *axes,
        }
    }

    pub fn normal(&self) -> Unit<Vector3<f64>> {
        match self {
            Self::Across { normal_axis, .. } => unit((*normal_axis).min(2)),
            Self::Free { axes: [u, v], .. } => Unit::new_normalize(u.cross(v)),
        }
    }

    /// Length of the sides along the axes.
    pub fn sizes_mm(&self) -> [f64; 2] {
        match self {
            Self::Across { normal_axis, bounds, .. } => {
                others(*normal_axis).map(|axis| bounds.size_mm()[axis])
            }
            Self::Free { sizes_mm, .. } => *sizes_mm,
        }
    }

    /// So many points along the longer side, and along the other as many as make cells square; at
    /// least 2.
    pub fn square_counts(&self, longest: usize) -> [usize; 2] {
        let sizes = self.sizes_mm();
        let largest = sizes[0].max(sizes[1]);
        if largest <= 0.0 {
            return [longest.max(2); 2];
        }
        let cells = longest.max(2) - 1;
        sizes.map(|size| ((size / largest * cells as f64).round() as usize + 1).max(2))
    }
}

impl SlicePlan {
    /// A point of the lattice, tracker frame, mm.
    pub fn point_mm(&self, u: usize, v: usize) -> Point3<f64> {
        match &self.plane {
            SlicePlane::Across { normal_axis, position_mm, bounds } => {
                let mut point = Point3::origin();
                point[(*normal_axis).min(2)] = *position_mm;
                let [axis_u, axis_v] = others(*normal_axis);
                for (axis, index, count) in
                    [(axis_u, u, self.counts[0]), (axis_v, v, self.counts[1])]
                {
                    let (min, max) = (bounds.min_mm[axis], bounds.max_mm[axis]);
                    // The last point is the box's own number, not one that rounding makes of it.
                    point[axis] = if index + 1 == count {
                        max
                    } else {
                        min + (max - min) * part(index, count)
                    };
                }
                point
            }
            SlicePlane::Free { origin_mm, axes, sizes_mm } => {
                let [along_u, along_v] = [(u, 0), (v, 1)].map(|(index, k)| {
                    axes[k].into_inner() * (sizes_mm[k] * part(index, self.counts[k]))
                });
                origin_mm + along_u + along_v
            }
        }
    }

    /// Number of points.
    pub fn points(&self) -> usize {
        self.counts[0] * self.counts[1]
    }
}

/// How far along its side a point is, 0 to 1.
fn part(index: usize, count: usize) -> f64 {
    index as f64 / (count.max(2) - 1) as f64
}

/// The two axes that a plane across another spans, in their order.
pub(super) fn others(normal_axis: usize) -> [usize; 2] {
    match normal_axis {
        0 => [1, 2],
        1 => [0, 2],
        _ => [0, 1],
    }
}

fn unit(axis: usize) -> Unit<Vector3<f64>> {
    Unit::new_unchecked(Vector3::ith(axis, 1.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_facing_plane_contains_the_projected_box() {
        let bounds = Bounds::from(([-10.0, -20.0, -30.0], [10.0, 40.0, 5.0]));
        let through = Point3::new(3.0, 4.0, 5.0);
        let normal = Unit::new_normalize(Vector3::new(0.3, -0.5, 0.7));
        let plane = SlicePlane::facing(&bounds, &through, &normal, &Vector3::z());
        let SlicePlane::Free { origin_mm, axes: [u, v], sizes_mm } = plane else {
            panic!("{plane:?}");
        };
        assert!(u.dot(&v).abs() < 1e-15 && v.z > 0.0);
        assert!((plane.normal().into_inner() - normal.into_inner()).norm() < 1e-15);
        assert!(normal.dot(&(origin_mm - through)).abs() < 1e-13);
        for (axis, size) in [(u, sizes_mm[0]), (v, sizes_mm[1])] {
            let along = bounds.corners_mm().map(|c| axis.dot(&(c - origin_mm)));
            let least = along.iter().copied().fold(f64::INFINITY, f64::min);
            let most = along.iter().copied().fold(f64::NEG_INFINITY, f64::max);
            assert!(least.abs() < 1e-13 && (most - size).abs() < 1e-13);
        }
        // Looking along `up` leaves any turn.
        let above = SlicePlane::facing(&bounds, &through, &Vector3::z_axis(), &Vector3::z());
        assert!((above.normal().into_inner() - Vector3::z()).norm() < 1e-15);
    }

    #[test]
    fn cells_are_as_square_as_whole_counts_permit() {
        let plane = SlicePlane::Across {
            normal_axis: 1,
            position_mm: 0.0,
            bounds: Bounds::from(([0.0; 3], [200.0, 50.0, 100.0])),
        };
        assert_eq!(plane.square_counts(81), [81, 41]);
        let flat = SlicePlane::Across {
            normal_axis: 1,
            position_mm: 0.0,
            bounds: Bounds::from(([0.0; 3], [0.0, 50.0, 0.0])),
        };
        assert_eq!(flat.square_counts(81), [81, 81]);
    }
}
