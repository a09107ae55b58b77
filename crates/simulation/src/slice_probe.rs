//! What a sampled slice shows at a place: interpolated between its points, never computed anew.

use super::slice::SliceOutcome;
use super::slice_plan::SlicePlan;
use nalgebra::Point3;
use trackwright_geometry::surface::Ray;

/// Slack at the lattice's edges, in cells: the round-off of finding a place.
const EDGE_SLACK: f64 = 1e-9;

/// What a slice shows at a place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Reading {
    /// In the quantity's unit.
    Value(f64),
    /// The model has no value there: outside its box, or of the tip error a sensor is.
    Outside,
    /// Inside, but the quantity has no value there.
    Undetermined,
}

/// Where a ray meets a slice.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SliceHit {
    pub distance_mm: f64,
    pub reading: Reading,
    /// Whether the model is valid there; true where that was not requested.
    pub is_supported: bool,
}

impl SlicePlan {
    /// A point's place in cells of the lattice along the plane's axes; what is off the plane falls on
    /// it along the normal.
    pub fn place_of(&self, point_mm: &Point3<f64>) -> [f64; 2] {
        let from_origin = point_mm - self.point_mm(0, 0);
        let (axes, sizes_mm) = (self.plane.axes(), self.plane.sizes_mm());
        [0, 1].map(|k| match sizes_mm[k] > 0.0 {
            true => axes[k].dot(&from_origin) / sizes_mm[k] * (self.counts[k] - 1) as f64,
            false => 0.0,
        })
    }

    /// The point at a place in cells of the lattice, tracker frame, mm.
    pub fn point_at(&self, place: [f64; 2]) -> Point3<f64> {
        let (axes, sizes_mm) = (self.plane.axes(), self.plane.sizes_mm());
        let [along_u, along_v] = [0, 1].map(|k| {
            let part = place[k] / (self.counts[k].max(2) - 1) as f64;
            axes[k].into_inner() * (sizes_mm[k] * part)
        });
        self.point_mm(0, 0) + along_u + along_v
    }

    /// Between neighbours of the lattice, along the plane's axes.
    pub fn cell_mm(&self) -> [f64; 2] {
        let sizes_mm = self.plane.sizes_mm();
        [0, 1].map(|k| sizes_mm[k] / (self.counts[k].max(2) - 1) as f64)
    }
}

impl SliceOutcome {
    /// At a place in cells of the lattice: bilinear between the points around it, as it is drawn.
    /// What is outside is decided by the box where it can be, else by the nearest point. `None` off
    /// the lattice.
    pub fn reading(&self, place: [f64; 2]) -> Option<Reading> {
        let nearest = self.nearest(place)?;
        let [nu, nv] = self.plan.counts;
        let (is_inside, value) = (*self.is_inside.get(nearest)?, *self.values.get(nearest)?);
        let is_outside = match &self.bounds {
            Some(bounds) => !bounds.contains(&self.plan.point_at(place)),
            None => !(is_inside || value.is_nan()),
        };
        if is_outside {
            return Some(Reading::Outside);
        }
        if value.is_nan() {
            return Some(Reading::Undetermined);
        }
        let cell = |at: f64, count: usize| {
            let first = (at.max(0.0) as usize).min(count - 1);
            (first, (at - first as f64).clamp(0.0, 1.0))
        };
        let ((u, fu), (v, fv)) = (cell(place[0], nu), cell(place[1], nv));
        let value = |u: usize, v: usize| self.values[v.min(nv - 1) * nu + u.min(nu - 1)];
        // A neighbour that counts for nothing may have no value.
        let mix = |a: f64, b: f64, f: f64| if f == 0.0 { a } else { a + (b - a) * f };
        let lower = mix(value(u, v), value(u + 1, v), fu);
        let upper = mix(value(u, v + 1), value(u + 1, v + 1), fu);
        let mixed = mix(lower, upper, fv);
        Some(match mixed.is_finite() {
            true => Reading::Value(mixed),
            false => Reading::Undetermined,
        })
    }

    /// The value at a place, where it has one.
    pub fn value_at(&self, place: [f64; 2]) -> Option<f64> {
        match self.reading(place)? {
            Reading::Value(value) => Some(value),
            Reading::Outside | Reading::Undetermined => None,
        }
    }

    /// Whether the model is valid at the nearest point of the lattice; true where that was not
    /// requested.
    pub fn is_supported_at(&self, place: [f64; 2]) -> bool {
        self.nearest(place)
            .and_then(|nearest| self.is_supported.get(nearest).copied())
            .unwrap_or(true)
    }

    /// How far a place is from where the value passes a level, in cells, by the slope there;
    /// differences are taken `step` cells to each side. `None` without values around it.
    pub fn cells_to_level(&self, place: [f64; 2], level: f64, step: f64) -> Option<f64> {
        let value = self.value_at(place)?;
        let slope = |du: f64, dv: f64| {
            let at = |sign: f64| self.value_at([place[0] + sign * du, place[1] + sign * dv]);
            match (at(-1.0), at(1.0)) {
                (Some(below), Some(above)) => Some((above - below) / (2.0 * step)),
                (Some(below), None) => Some((value - below) / step),
                (None, Some(above)) => Some((above - value) / step),
                (None, None) => None,
            }
        };
        let steepness = slope(step, 0.0)?.hypot(slope(0.0, step)?);
        let distance = (value - level).abs() / steepness;
        distance.is_finite().then_some(distance)
    }

    /// Where a ray meets the slice; `None` where it passes by.
    pub fn hit(&self, ray: &Ray) -> Option<SliceHit> {
        let normal = self.plan.plane.normal();
        let point_mm = ray.meets_plane(&self.plan.point_mm(0, 0), &normal)?;
        let place = self.plan.place_of(&point_mm);
        Some(SliceHit {
            distance_mm: (point_mm - ray.origin_mm).norm(),
            reading: self.reading(place)?,
            is_supported: self.is_supported_at(place),
        })
    }

    /// The point of the lattice nearest to a place; `None` off the lattice.
    fn nearest(&self, place: [f64; 2]) -> Option<usize> {
        let [nu, nv] = self.plan.counts;
        let nearest = |at: f64, count: usize| {
            let last = (count - 1) as f64;
            (-EDGE_SLACK..=last + EDGE_SLACK)
                .contains(&at)
                .then(|| ((at.max(0.0) + 0.5) as usize).min(count - 1))
        };
        Some(nearest(place[1], nv)? * nu + nearest(place[0], nu)?)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Quantity, SlicePlane, Work};
    use nalgebra::{Unit, Vector3};
    use trackwright_geometry::bounds::Bounds;

    /// `1 + 2 u + 3 v` in cells, with a corner that is outside.
    fn slice(plane: SlicePlane) -> SliceOutcome {
        SliceOutcome {
            plan: SlicePlan { plane, sensor_axis: Vector3::z_axis(), counts: [3, 2] },
            quantity: Quantity::PositionErrorMm,
            values: vec![1.0, 3.0, 5.0, 4.0, 6.0, 8.0],
            is_inside: vec![true, true, true, true, true, false],
            bounds: None,
            is_supported: vec![true, true, false, true, true, true],
            max: 6.0,
            p95: 6.0,
            work: Work::default(),
        }
    }

    fn across() -> SlicePlane {
        SlicePlane::Across {
            normal_axis: 2,
            position_mm: 5.0,
            bounds: Bounds::from(([10.0, 20.0, 0.0], [30.0, 40.0, 30.0])),
        }
    }

    #[test]
    fn readings_are_bilinear_or_outside_at_nearest_points() {
        let slice = slice(across());
        let value = |u, v| slice.value_at([u, v]);
        assert_eq!(value(0.25, 0.5), Some(1.0 + 0.5 + 1.5));
        assert_eq!(value(2.0, 0.0), Some(5.0));
        assert_eq!(slice.reading([1.6, 0.6]), Some(Reading::Outside));
        assert_eq!(value(1.4, 0.6), Some(1.0 + 2.8 + 1.8));
        assert_eq!(slice.reading([2.1, 0.0]), None);
        assert_eq!(slice.reading([0.0, f64::NAN]), None);
        assert!(slice.is_supported_at([1.4, 0.0]) && !slice.is_supported_at([1.6, 0.2]));
    }

    #[test]
    fn where_a_box_decides_its_face_is_where_values_end() {
        let mut slice = slice(across());
        // Up to x = 26 mm, which is 1.6 cells; the last points are outside.
        slice.bounds = Some(Bounds::from(([10.0, 20.0, 0.0], [26.0, 40.0, 30.0])));
        (slice.is_inside[2], slice.is_inside[5]) = (false, false);
        let almost = slice.value_at([1.59, 0.5]).unwrap();
        assert!((almost - (1.0 + 3.18 + 1.5)).abs() < 1e-12, "{almost}");
        assert_eq!(slice.reading([1.61, 0.5]), Some(Reading::Outside));
    }

    #[test]
    fn missing_values_of_nonzero_weight_are_undetermined() {
        let mut slice = slice(across());
        (slice.values[2], slice.is_inside[2]) = (f64::NAN, false);
        assert_eq!(slice.reading([1.0, 0.0]), Some(Reading::Value(3.0)));
        assert_eq!(slice.reading([1.2, 0.0]), Some(Reading::Undetermined));
        assert_eq!(slice.reading([2.0, 0.0]), Some(Reading::Undetermined));
    }

    #[test]
    fn a_ray_reads_the_slice_at_its_intersection() {
        let turned = SlicePlane::Free {
            origin_mm: Point3::new(10.0, 20.0, 5.0),
            axes: [Unit::new_normalize(Vector3::new(0.6, 0.0, 0.8)), Vector3::y_axis()],
            sizes_mm: [20.0, 20.0],
        };
        for plane in [across(), turned] {
            let slice = slice(plane);
            let [u, v] = slice.plan.plane.axes().map(|axis| axis.into_inner());
            let at = slice.plan.point_mm(0, 0) + u * 2.5 + v * 10.0;
            let from = at + Vector3::new(7.0, -30.0, 60.0);
            let ray = Ray { origin_mm: from, direction: Unit::new_normalize(at - from) };
            let hit = slice.hit(&ray).unwrap();
            let Reading::Value(value) = hit.reading else {
                panic!("{hit:?}");
            };
            // A quarter of the first cell, half of the second.
            assert!((value - (1.0 + 0.5 + 1.5)).abs() < 1e-12, "{value}");
            assert!((hit.distance_mm - (at - from).norm()).abs() < 1e-12);
            let beside = Ray { origin_mm: from + u * 100.0, ..ray };
            assert_eq!(slice.hit(&beside), None);
        }
    }

    #[test]
    fn distance_to_a_level_is_difference_over_slope() {
        let slice = slice(across());
        let far = slice.cells_to_level([0.5, 0.5], 2.5, 0.25).unwrap();
        assert!((far - (1.0 + 1.0 + 1.5 - 2.5) / 13f64.sqrt()).abs() < 1e-12, "{far}");
        // At the edge differences are taken to one side.
        let far = slice.cells_to_level([0.0, 0.0], 1.0, 0.25).unwrap();
        assert_eq!(far, 0.0);
    }
}
