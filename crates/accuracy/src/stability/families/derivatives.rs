//! Derivatives of equation (8), on which Newton's steps and determinants depend.

use super::prelude::*;
use trackwright_field::evaluation::Matrix6x3;

const BY_POSITION: Quantity = Quantity::new(
    "derivatives by position, mm or rad a mm",
    4.0,
    "order, plus one over the sum of the triangle's half areas",
    "order times the largest coefficient over the box's extent",
);

const BY_AXIS: Quantity = Quantity::new(
    "derivatives by the axis, mm or rad a rad",
    8.0,
    "one over the sum of the triangle's half areas, squared, plus the order",
    "the largest coefficient",
);

/// Step of the differences, in units of the box or radians: its square is far below epsilon, and
/// 192 bits hold the difference of two values to 1e-37 of them.
const STEP: f64 = 1e-20;

pub(super) fn family(extent: Extent) -> Family {
    let poses = if extent.is_full() { 6 } else { 1 };
    let mut cases = Vec::new();
    for order in extent.of(&[1, 2, 4, 6, 9, 12], &[1, 3]) {
        cases.push(case(format!("order {order}, 14 orientations"), move || {
            SampledModel::new(
                order,
                DirectionSet::Fourteen,
                Weighting::Area,
                cube([-100.0; 3], 200.0),
                poses,
            )
        }));
    }
    for set in extent.of(&DirectionSet::ALL, &[DirectionSet::FortyTwo]) {
        for weighting in [Weighting::Area, Weighting::Gnomonic] {
            let name = format!("order 2, {} orientations, {weighting:?} weights", set.len());
            cases.push(case(name, move || {
                SampledModel::new(2, set, weighting, cube([-100.0; 3], 200.0), poses)
            }));
        }
    }
    for (name, bounds) in [
        ("a box of 1e-6 mm", cube([-5e-7; 3], 1e-6)),
        ("a box of 1e6 mm", cube([-5e5; 3], 1e6)),
        ("a box of 300 mm, offset by 1e6 mm", cube([1e6, -1e6, 1e6], 300.0)),
    ] {
        cases.push(case(format!("order 3, {name}"), move || {
            SampledModel::new(3, DirectionSet::Fourteen, Weighting::Area, bounds, poses)
        }));
    }
    Family {
        name: "derivatives",
        about: "The analytic derivatives of equation (8) by position and along the sphere of \
            axes, against central differences over 1e-20 in 192 bits.",
        quantities: vec![BY_POSITION, BY_AXIS],
        cases,
    }
}

/// A model, and how many poses in it.
struct SampledModel {
    model: Option<DistortionModel>,
    bounds: Bounds,
    poses: usize,
}

impl SampledModel {
    fn new(
        order: usize,
        set: DirectionSet,
        weighting: Weighting,
        bounds: Bounds,
        poses: usize,
    ) -> Self {
        Self { model: model(order, set, weighting, bounds, order as u64 + 7).ok(), bounds, poses }
    }
}

fn case(name: String, make: impl Fn() -> SampledModel + Send + Sync + 'static) -> Case {
    Case::new(name, move |m, case| {
        let sampled = make();
        let Some(model) = &sampled.model else {
            return vec![Row::behaviour(case, "is a model", false)];
        };
        let mut sequence = Sequence::new(41);
        let (mut by_position, mut by_axis) = (Vec::new(), Vec::new());
        for _ in 0..sampled.poses {
            let position = sequence.point_in(&sampled.bounds);
            let axis = sequence.axis();
            let [p, a] = (m.derivatives)(model, &position, &axis, OutsidePolicy::Clamp);
            let at = Exact { model, position: point3(&position), axis: unit3(&axis3(&axis)) };
            by_position.push(at.by_position(case, &p));
            by_axis.push(at.by_axis(case, &a));
        }
        let both = [by_position, by_axis].into_iter();
        both.filter_map(Row::worst_of).collect()
    })
}

/// A pose in a field, to all digits.
struct Exact<'a> {
    model: &'a DistortionModel,
    position: High3,
    axis: High3,
}

impl Exact<'_> {
    /// Central difference of the six values between two poses `2 · step` apart.
    fn slope(&self, a: [&High3; 2], b: [&High3; 2], step: &High) -> Vec<High> {
        let at = |[p, n]: [&High3; 2]| {
            let all = references::evaluate(self.model, p, n, OutsidePolicy::Clamp);
            all.into_iter().next().map(|e| e.values)
        };
        match (at(a), at(b)) {
            (Some(a), Some(b)) => (0..6).map(|k| (&b[k] - &a[k]) / (step * 2.0)).collect(),
            _ => vec![High::from(f64::NAN); 6],
        }
    }

    /// Largest position and rotation coefficient, and one over the weights' sum.
    fn sizes(&self) -> ([f64; 2], f64) {
        let all =
            references::evaluate(self.model, &self.position, &self.axis, OutsidePolicy::Clamp);
        let set = self.model.directions();
        let weights = references::weights(set, &self.axis, self.model.weighting());
        let sum = weights.first().map_or(f64::NAN, |w| w.sum);
        (all.first().map_or([f64::NAN; 2], |e| e.scales), 1.0 / sum)
    }

    fn by_position(&self, case: &str, found: &Matrix6x3) -> Row {
        let order = self.model.order() as f64;
        let (scales, weights) = self.sizes();
        let size = self.model.bounds().size_mm();
        let mut errors = Vec::new();
        for k in 0..3 {
            let step = High::from(size[k]) * STEP;
            let mut aside = vector3([0.0; 3]);
            aside[k] = step.clone();
            let (a, b) = (sub3(&self.position, &aside), add3(&self.position, &aside));
            let slope = self.slope([&a, &self.axis], [&b, &self.axis], &step);
            let column = found.column(k);
            errors.extend(parts(column.as_slice(), &slope, scales.map(|s| s * order / size[k])));
        }
        BY_POSITION.worst(case, order + weights, &errors)
    }

    fn by_axis(&self, case: &str, found: &Matrix6x3) -> Row {
        let (scales, weights) = self.sizes();
        let order = self.model.order() as f64;
        let aside = vector3([0.31, -0.42, 0.85]);
        let first = unit3(&cross3(&self.axis, &aside));
        let second = cross3(&self.axis, &first);
        let step = High::from(STEP);
        let mut errors = Vec::new();
        for tangent in [first, second] {
            let by = scale3(&tangent, &step);
            let (a, b) = (sub3(&self.axis, &by), add3(&self.axis, &by));
            let slope = self.slope([&self.position, &a], [&self.position, &b], &step);
            // Exactly along the tangent: its rounding to f64 would be an error of the step.
            let along: Vec<f64> = (0..6)
                .map(|row| {
                    let terms = (0..3).map(|k| &tangent[k] * found[(row, k)]);
                    terms.sum::<High>().to_f64()
                })
                .collect();
            errors.extend(parts(&along, &slope, scales));
        }
        BY_AXIS.worst(case, weights * weights + order, &errors)
    }
}

/// Errors of three lengths and three angles beside their scales.
fn parts(found: &[f64], expected: &[High], scales: [f64; 2]) -> [(f64, f64); 2] {
    [0, 1].map(|part| {
        let own = 3 * part..3 * part + 3;
        (distance(&found[own.clone()], &expected[own]), scales[part])
    })
}
