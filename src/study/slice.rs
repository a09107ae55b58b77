//! A slice through the room: position error on a lattice in one plane.

use super::run::StudyError;
use super::statistics::Statistics;
use super::work::Work;
use crate::field::{Environment, OutsidePolicy};
use crate::geometry::bounds::Bounds;
use crate::task::CancelToken;
use nalgebra::{Point3, Unit, Vector3};
use rayon::prelude::*;

/// Rows of points that one core does before it looks whether anyone still wants them.
const BAND: usize = 16;

/// Where to sample: a plane across one of the tracker's axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SlicePlan {
    /// 0, 1 or 2: the plane lies across x, y or z.
    pub normal_axis: usize,
    pub position_mm: f64,
    /// The axis of the sensor that is imagined at each point.
    pub sensor_axis: Unit<Vector3<f64>>,
    /// Points along the two other axes, in the order of the axes; at least 2 each.
    pub counts: [usize; 2],
    /// The lattice spans this box.
    pub bounds: Bounds,
}

/// A sampled slice. Values run along the first of the two axes fastest.
#[derive(Clone, Debug, PartialEq)]
pub struct SliceOutcome {
    pub plan: SlicePlan,
    pub position_error_mm: Vec<f64>,
    /// Whether each point lies in the model's box.
    pub is_inside: Vec<bool>,
    /// Largest error inside the box, 0 where nothing is inside.
    pub max_mm: f64,
    /// 95th percentile of the errors inside the box, 0 where nothing is inside: what a colour map
    /// spans, so that one bad corner of the room does not take all its colours.
    pub p95_mm: f64,
    pub work: Work,
}

impl SlicePlan {
    /// The two axes that the plane spans.
    pub fn plane_axes(&self) -> [usize; 2] {
        match self.normal_axis {
            0 => [1, 2],
            1 => [0, 2],
            _ => [0, 1],
        }
    }

    /// A point of the lattice, tracker frame, mm.
    pub fn point_mm(&self, u: usize, v: usize) -> Point3<f64> {
        let mut point = Point3::origin();
        point[self.normal_axis.min(2)] = self.position_mm;
        for (axis, (index, count)) in self
            .plane_axes()
            .into_iter()
            .zip([(u, self.counts[0]), (v, self.counts[1])])
        {
            let (min, max) = (self.bounds.min_mm[axis], self.bounds.max_mm[axis]);
            // The last point is the box's own number, not one that rounding makes of it.
            point[axis] = if index + 1 == count {
                max
            } else {
                min + (max - min) * index as f64 / (count.max(2) - 1) as f64
            };
        }
        point
    }
}

/// Position error of a sensor at each point of the plan.
///
/// # Errors
/// [`StudyError::Cancelled`].
pub fn sample_slice(
    environment: &Environment,
    plan: &SlicePlan,
    cancel: &CancelToken,
) -> Result<SliceOutcome, StudyError> {
    let [nu, nv] = plan.counts;
    let [axis_u, axis_v] = plan.plane_axes();
    let us: Vec<f64> = (0..nu).map(|u| plan.point_mm(u, 0)[axis_u]).collect();
    let vs: Vec<f64> = (0..nv).map(|v| plan.point_mm(0, v)[axis_v]).collect();
    let across = [plan.position_mm];
    let at_axis = environment.model.at_axis(&plan.sensor_axis);
    let bands: Option<Vec<Vec<(f64, bool)>>> = vs
        .par_chunks(BAND)
        .map_init(Vec::new, |evaluations, vs| {
            if cancel.is_cancelled() {
                return None;
            }
            let mut coordinates = [&across[..]; 3];
            coordinates[axis_u] = &us;
            coordinates[axis_v] = vs;
            at_axis.evaluate_lattice(coordinates, OutsidePolicy::Clamp, evaluations);
            // There u is slower than v, its axis being the earlier one.
            let places = (0..vs.len()).flat_map(|v| (0..nu).map(move |u| (u, v)));
            let values = places.map(|(u, v)| {
                let e = &evaluations[u * vs.len() + v];
                (e.error.position_mm.norm(), e.is_inside)
            });
            Some(values.collect())
        })
        .collect();
    let values = bands.ok_or(StudyError::Cancelled)?.concat();
    let mut inside: Vec<f64> = values
        .iter()
        .filter_map(|&(value, is_inside)| is_inside.then_some(value))
        .collect();
    let statistics = Statistics::of(&mut inside);
    let (position_error_mm, is_inside) = values.into_iter().unzip();
    Ok(SliceOutcome {
        plan: *plan,
        position_error_mm,
        is_inside,
        max_mm: statistics.map_or(0.0, |s| s.max),
        p95_mm: statistics.map_or(0.0, |s| s.p95),
        work: Work {
            slice_evaluations: (nu * nv) as u64,
            coefficient_blends: 1,
            blended_evaluations: (nu * nv) as u64,
            ..Work::default()
        },
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::field::DistortionModel;
    use crate::field::samples::MapKind;
    use crate::geometry::directions::{DirectionSet, Weighting};

    /// A room whose error along x is the position's x in the unit cube.
    fn room() -> Environment {
        let bounds = Bounds::from(([0.0; 3], [100.0; 3]));
        let coefficients = (0..8)
            .map(|i| [f64::from(i / 4), 0.0, 0.0, 0.0, 0.0, 0.0])
            .collect();
        Environment {
            name: "slope".into(),
            model: DistortionModel::new(
                1,
                DirectionSet::One,
                Weighting::Area,
                MapKind::Distortion,
                bounds,
                coefficients,
            )
            .unwrap(),
            volume: None,
            jitter: None,
            provenance: None,
            support: None,
        }
    }

    fn plan(position_mm: f64) -> SlicePlan {
        SlicePlan {
            normal_axis: 2,
            position_mm,
            sensor_axis: Vector3::z_axis(),
            counts: [101, 3],
            bounds: Bounds::from(([0.0; 3], [100.0; 3])),
        }
    }

    #[test]
    fn a_slice_costs_its_points_and_holds_their_errors() {
        let slice = sample_slice(&room(), &plan(50.0), &CancelToken::default()).unwrap();
        assert_eq!(slice.work.slice_evaluations, 303);
        assert!((slice.position_error_mm[25] - 0.25).abs() < 1e-15);
        assert!((slice.max_mm - 1.0).abs() < 1e-15);
        assert!((slice.p95_mm - 0.95).abs() < 0.01);
    }

    #[test]
    fn outside_the_box_a_slice_has_values_and_no_range() {
        let slice = sample_slice(&room(), &plan(150.0), &CancelToken::default()).unwrap();
        assert!(slice.is_inside.iter().all(|inside| !inside));
        assert_eq!((slice.max_mm, slice.p95_mm), (0.0, 0.0));
    }

    #[test]
    fn a_cancelled_slice_has_no_values() {
        let cancel = CancelToken::default();
        cancel.cancel();
        let slice = sample_slice(&room(), &plan(50.0), &cancel);
        assert_eq!(slice, Err(StudyError::Cancelled));
    }
}
