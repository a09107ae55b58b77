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
    let poses = extent.of(6, 1);
    let small = cube([-100.0; 3], 200.0);
    let sampled = |order: usize, set, weighting, bounds| {
        (model(order, set, weighting, bounds, order as u64 + 7), poses)
    };
    let usual = |order, bounds| sampled(order, DirectionSet::Fourteen, Weighting::Area, bounds);
    let orders = extent
        .of(vec![1, 2, 4, 6, 9, 12], vec![1, 3])
        .into_iter()
        .map(|order| (format!("order {order}, 14 orientations"), usual(order, small)));
    let sets = extent.of(DirectionSet::ALL.to_vec(), vec![DirectionSet::FortyTwo]);
    let sets = sets.into_iter().flat_map(|set| {
        [Weighting::Area, Weighting::Gnomonic].map(|weighting| {
            let name = format!("order 2, {} orientations, {weighting:?} weights", set.len());
            (name, sampled(2, set, weighting, small))
        })
    });
    let boxes = [
        ("order 3, a box of 1e-6 mm", cube([-5e-7; 3], 1e-6)),
        ("order 3, a box of 1e6 mm", cube([-5e5; 3], 1e6)),
        ("order 3, a box of 300 mm, offset by 1e6 mm", cube([1e6, -1e6, 1e6], 300.0)),
    ]
    .map(|(name, bounds)| (name, usual(3, bounds)));
    Family::new(
        "derivatives",
        "The analytic derivatives of equation (8) by position and along the sphere of \
            axes, against central differences over 1e-20 in 192 bits.",
        &[BY_POSITION, BY_AXIS],
    )
    .with(orders, rows)
    .with(sets, rows)
    .with(boxes, rows)
}

/// At so many poses in a model.
fn rows(methods: &Methods, (model, poses): &(Made, usize)) -> Found {
    let model = &model.clone()?;
    let mut sequence = Sequence::new(41);
    let mut rows = Vec::new();
    for _ in 0..*poses {
        let position = sequence.point_in(model.bounds());
        let axis = sequence.axis();
        let [p, a] = (methods.derivatives)(model, &position, &axis, OutsidePolicy::Clamp);
        let at = Exact { model, position: point3(&position), axis: unit3(&axis3(&axis)) };
        rows.extend([at.by_position(&p), at.by_axis(&a)]);
    }
    Ok(rows)
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

    fn by_position(&self, found: &Matrix6x3) -> Row {
        let order = self.model.order() as f64;
        let (scales, weights) = self.sizes();
        let size = self.model.bounds().size_mm();
        let mut errors = Vec::new();
        for k in 0..3 {
            let step = High::from(size[k]) * STEP;
            let aside = High3::ith(k, step.clone());
            let (a, b) = (&self.position - &aside, &self.position + &aside);
            let slope = self.slope([&a, &self.axis], [&b, &self.axis], &step);
            let column = found.column(k);
            errors.extend(parts(column.as_slice(), &slope, scales.map(|s| s * order / size[k])));
        }
        BY_POSITION.worst(order + weights, &errors)
    }

    fn by_axis(&self, found: &Matrix6x3) -> Row {
        let (scales, weights) = self.sizes();
        let order = self.model.order() as f64;
        let aside = vector3([0.31, -0.42, 0.85]);
        let first = unit3(&self.axis.cross(&aside));
        let second = self.axis.cross(&first);
        let step = High::from(STEP);
        let mut errors = Vec::new();
        for tangent in [first, second] {
            let by = &tangent * step.clone();
            let (a, b) = (&self.axis - &by, &self.axis + &by);
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
        BY_AXIS.worst(weights * weights + order, &errors)
    }
}

/// Errors of three lengths and three angles beside their scales.
fn parts(found: &[f64], expected: &[High], scales: [f64; 2]) -> [(f64, f64); 2] {
    [0, 1].map(|part| {
        let own = 3 * part..3 * part + 3;
        (distance(&found[own.clone()], &expected[own]), scales[part])
    })
}
