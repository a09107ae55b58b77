//! A batch against single evaluations, in every set, weighting, order and instruction set.

use super::*;
use crate::random_models::{Seeded, random_model, room};
use crate::samples::MapKind;
use trackwright_geometry::bounds::Bounds;

fn model(order: usize, set: DirectionSet, weighting: Weighting) -> DistortionModel {
    random_model(order, set, weighting, [1.0, 1.0], order as u64)
}

/// Poses in and around the box, axes everywhere and at all special places.
fn poses(count: usize, set: DirectionSet) -> (Vec<Point3<f64>>, Vec<Unit<Vector3<f64>>>) {
    let mut seeded = Seeded::new(99);
    let corners = set.directions().iter().map(|a| a.into_inner());
    let edges = set
        .triangles()
        .iter()
        .map(|t| set.directions()[t[0]].into_inner() + set.directions()[t[1]].into_inner() * 0.7);
    let special: Vec<_> = corners.chain(edges).collect();
    (0..count)
        .map(|i| {
            let p = seeded.position(&room(), 0.1);
            let anywhere = seeded.normal_vector();
            let axis = match i % 3 {
                0 => special[i / 3 % special.len()],
                _ => anywhere,
            };
            (p, Unit::new_normalize(axis))
        })
        .unzip()
}

const LEVELS: [Instructions; 3] = [Instructions::Best, Instructions::Avx2, Instructions::Portable];

#[test]
fn a_batch_gives_what_single_evaluations_give() {
    for set in DirectionSet::ALL {
        for weighting in [Weighting::Area, Weighting::Gnomonic] {
            for order in 1..=8 {
                let model = model(order, set, weighting);
                let (positions, axes) = poses(150, set);
                for outside in
                    [OutsidePolicy::Clamp, OutsidePolicy::Reject, OutsidePolicy::Extrapolate]
                {
                    // Outside the box a polynomial of order 8 reaches some hundred.
                    let scale = if outside == OutsidePolicy::Extrapolate { 1e3 } else { 1.0 };
                    for level in LEVELS {
                        let mut out = Vec::new();
                        Batch::with_instructions(level)
                            .evaluate(&model, &positions, &axes, outside, &mut out);
                        for ((p, a), found) in positions.iter().zip(&axes).zip(&out) {
                            let expected = model.evaluate(p, a, outside);
                            assert_eq!(found.is_inside, expected.is_inside);
                            let d = found.error.largest_difference(&expected.error);
                            assert!(
                                d <= 1e-13 * scale,
                                "{set:?} {weighting:?} order {order} {outside:?} {level:?} {d}"
                            );
                        }
                    }
                }
            }
        }
    }
}

#[test]
fn results_do_not_depend_on_the_other_poses() {
    for set in [DirectionSet::One, DirectionSet::Fourteen] {
        let model = model(4, set, Weighting::Area);
        let (positions, axes) = poses(2 * CHUNK + 77, set);
        for level in LEVELS {
            let mut batch = Batch::with_instructions(level);
            let (mut all, mut part) = (Vec::new(), Vec::new());
            let outside = OutsidePolicy::Clamp;
            batch.evaluate(&model, &positions, &axes, outside, &mut all);
            for (start, len) in [(0, 1), (5, 2), (13, 8), (100, 17), (CHUNK - 3, 300)] {
                let range = start..start + len;
                let (p, a) = (&positions[range.clone()], &axes[range.clone()]);
                batch.evaluate(&model, p, a, outside, &mut part);
                assert_eq!(part, all[range], "{set:?} {level:?} {start} {len}");
            }
        }
    }
}

/// A model of order 1 whose field is one number an orientation; in a corner of the box, where
/// one product of the basis is 1 and the others are 0, the answer is the blend of those.
fn blend(set: DirectionSet, values: impl Fn(usize) -> f64) -> DistortionModel {
    let coefficients = (0..set.len() * 8).map(|i| [values(i / 8); 6]).collect();
    let bounds = Bounds::from(([0.0; 3], [1.0; 3]));
    let map = MapKind::Distortion;
    DistortionModel::new(1, set, Weighting::Area, map, bounds, coefficients).unwrap()
}

fn blended_in_a_corner(model: &DistortionModel, axis: Vector3<f64>, level: Instructions) -> f64 {
    let mut out = Vec::new();
    Batch::with_instructions(level).evaluate(
        model,
        &[Point3::origin()],
        &[Unit::new_normalize(axis)],
        OutsidePolicy::Clamp,
        &mut out,
    );
    out[0].error.position_mm.x
}

#[test]
fn on_a_corner_its_weight_is_exactly_one() {
    for set in DirectionSet::ALL {
        let model = blend(set, |d| d as f64 + 1.0);
        for (d, axis) in set.directions().iter().enumerate() {
            for level in LEVELS {
                let found = blended_in_a_corner(&model, axis.into_inner(), level);
                assert_eq!(found, d as f64 + 1.0, "{set:?} {level:?}");
            }
        }
    }
}

#[test]
fn on_an_edge_the_opposite_weight_is_exactly_zero() {
    for set in DirectionSet::ALL.into_iter().skip(1) {
        for t in set.triangles() {
            let [a, b] = [t[0], t[1]].map(|i| set.directions()[i].into_inner());
            let on_edge = |d| if d == t[0] || d == t[1] { 1.0 } else { 1e300 };
            let model = blend(set, on_edge);
            for level in LEVELS {
                let found = blended_in_a_corner(&model, a + b * 0.7, level);
                assert!((found - 1.0).abs() < 1e-15, "{set:?} {level:?} {found}");
            }
        }
    }
}

#[test]
fn order_zero_is_no_error_and_still_knows_its_box() {
    let model = DistortionModel::zero(Bounds::from(([0.0; 3], [1.0; 3])), MapKind::Distortion);
    let positions = [Point3::new(0.5, 0.5, 0.5), Point3::new(2.0, 0.5, 0.5)];
    let axes = [Vector3::z_axis(); 2];
    let mut out = Vec::new();
    Batch::default().evaluate(&model, &positions, &axes, OutsidePolicy::Clamp, &mut out);
    assert_eq!(out.len(), 2);
    assert!(out.iter().all(|e| e.error == PoseError::default()));
    assert_eq!([out[0].is_inside, out[1].is_inside], [true, false]);
}

#[test]
fn no_poses_have_no_evaluations() {
    let model = model(2, DirectionSet::Six, Weighting::Area);
    let mut out = vec![model.evaluate(&Point3::origin(), &Vector3::z_axis(), OutsidePolicy::Clamp)];
    Batch::default().evaluate(&model, &[], &[], OutsidePolicy::Clamp, &mut out);
    assert!(out.is_empty());
}

#[test]
fn nan_poses_harm_no_others() {
    for set in DirectionSet::ALL {
        for weighting in [Weighting::Area, Weighting::Gnomonic] {
            let model = model(3, set, weighting);
            let (mut positions, mut axes) = poses(40, set);
            let mut before = Vec::new();
            let mut after = Vec::new();
            let outside = OutsidePolicy::Clamp;
            for level in LEVELS {
                let mut batch = Batch::with_instructions(level);
                batch.evaluate(&model, &positions, &axes, outside, &mut before);
                let kept = (positions[7], axes[9]);
                positions[7] = Point3::new(f64::NAN, f64::INFINITY, 0.0);
                axes[9] = Unit::new_unchecked(Vector3::new(f64::NAN, 0.0, 1.0));
                batch.evaluate(&model, &positions, &axes, outside, &mut after);
                assert!(!after[7].is_inside);
                // No point of the box is nearest to what is no position.
                assert!(after[7].error.position_mm.iter().all(|v| v.is_nan()));
                let is_ignored = set == DirectionSet::One;
                assert_eq!(after[9].error.position_mm.x.is_nan(), !is_ignored);
                for i in (0..40).filter(|i| ![7, 9].contains(i)) {
                    assert_eq!(before[i], after[i]);
                }
                (positions[7], axes[9]) = kept;
            }
        }
    }
}
