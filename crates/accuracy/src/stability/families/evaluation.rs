//! Equation (8) at one pose.

use super::prelude::*;
use crate::references::HighEvaluation;
use trackwright_field::bernstein::MAX_ORDER;

const CONDITION: &str = "how the answer reacts to relative errors of coefficients and normalised \
    position, and to errors of the axis: sum of absolute terms over the scale, plus one over the \
    sum of the triangle's half areas";

/// Roundings of the factors are independent and mostly cancel; those of the last sums remain.
const fn position(name: &'static str) -> Quantity {
    Quantity::new(name, 4.0, CONDITION, "largest position coefficient, mm")
}

const fn rotation(name: &'static str) -> Quantity {
    Quantity { scale: "largest rotation coefficient, rad", ..position(name) }
}

/// Position and rotation by each way of evaluating.
const WAYS: [[Quantity; 2]; 3] = [
    [position("position error, mm"), rotation("rotation error, rad")],
    [position("position error in a batch, mm"), rotation("rotation error in a batch, rad")],
    [position("position error along one axis, mm"), rotation("rotation error along one axis, rad")],
];

/// Poses in a model's field.
struct Input {
    model: Made,
    poses: Vec<PoseInField>,
    outside: OutsidePolicy,
}

type PoseInField = (Point3<f64>, Unit<Vector3<f64>>);

impl Input {
    /// In the model's own box.
    fn inside(model: Made, poses: Vec<PoseInField>) -> Self {
        Self { model, poses, outside: OutsidePolicy::Clamp }
    }
}

pub(super) fn family(extent: Extent) -> Family {
    let poses = extent.of(8, 2);
    let usual = |order: usize, bounds: Bounds| {
        model(order, DirectionSet::Fourteen, Weighting::Area, bounds, order as u64)
    };
    let room = cube([-250.0, -250.0, -600.0], 500.0);
    let orders = extent.of((1..=MAX_ORDER).collect(), vec![1, 2, 4, 8]).into_iter().map(|order| {
        let at = scattered(&room, poses, order as u64);
        (format!("order {order}, 14 orientations"), Input::inside(usual(order, room), at))
    });
    let small = cube([-100.0; 3], 200.0);
    let sets = DirectionSet::ALL.into_iter().flat_map(|set| {
        [Weighting::Area, Weighting::Gnomonic].map(|weighting| {
            let name = format!("order 2, {} orientations, {weighting:?} weights", set.len());
            let model = model(2, set, weighting, small, 2);
            (name, Input::inside(model, scattered(&small, poses, 77)))
        })
    });
    let boxes = [
        ("box of 1e-6 mm", cube([-5e-7; 3], 1e-6)),
        ("box of 1e6 mm", cube([-5e5; 3], 1e6)),
        ("box of 300 mm, offset by 1e6 mm", cube([1e6, -1e6, 1e6], 300.0)),
        ("box of 1e-3 mm, offset by 1e6 mm", cube([1e6, -1e6, 1e6], 1e-3)),
        ("box without height", Bounds::from(([-100.0, -100.0, -300.0], [100.0, 100.0, -300.0]))),
        ("box of 1e-9 mm height", Bounds::from(([-100.0, -100.0, 0.0], [100.0, 100.0, 1e-9]))),
    ]
    .map(|(name, bounds)| {
        let at = scattered(&bounds, poses, 5);
        (format!("order 4, {name}"), Input::inside(usual(4, bounds), at))
    });
    let odd = cube([0.1, 0.2, 0.3], 99.7);
    let corners = odd.corners_mm().map(|p| (p, Vector3::y_axis())).to_vec();
    let corners = Input::inside(usual(12, odd), corners);
    let extrapolated = [2, 6].map(|order| {
        let input = Input {
            model: model(order, DirectionSet::Fourteen, Weighting::Area, small, 3),
            poses: scattered(&cube([-200.0; 3], 400.0), poses, 9),
            outside: OutsidePolicy::Extrapolate,
        };
        (format!("order {order}, extrapolated by half a box"), input)
    });
    Family::new(
        "evaluation",
        "Equation (8): six values at a pose, in batches by each set of vector instructions, \
            and with one axis blended beforehand, against the sum of binomials times powers times \
            weights as it is written.",
        &WAYS.concat(),
    )
    .with(orders, rows)
    .with(sets, rows)
    .with(boxes, rows)
    .with([("order 12, corners and faces of the box", corners)], rows)
    .with(extrapolated, rows)
}

fn scattered(bounds: &Bounds, count: usize, seed: u64) -> Vec<PoseInField> {
    let mut sequence = Sequence::new(seed);
    (0..count).map(|_| (sequence.point_in(bounds), sequence.axis())).collect()
}

/// Position and rotation of all poses by each way.
fn rows(methods: &Methods, input: &Input) -> Found {
    let (model, outside) = (&input.model.clone()?, input.outside);
    let (positions, axes): (Vec<_>, Vec<_>) = input.poses.iter().copied().unzip();
    let together = (methods.evaluate_together)(model, &positions, &axes, outside);
    let mut rows = Vec::new();
    for (i, (position, axis)) in input.poses.iter().enumerate() {
        let ways = [
            vec![(methods.evaluate)(model, position, axis, outside)],
            together.iter().map(|answers| answers[i]).collect(),
            (methods.evaluate_along)(model, position, axis, outside),
        ];
        let expected = references::evaluate(model, &point3(position), &axis3(axis), outside);
        for (quantities, answers) in WAYS.iter().zip(&ways) {
            for answer in answers {
                for (part, found) in [answer.position_mm, answer.rotation_rad].iter().enumerate() {
                    rows.push(nearest(&quantities[part], found.as_slice(), part, &expected));
                }
            }
        }
    }
    Ok(rows)
}

/// On an edge both triangles are right; the nearer one is meant.
fn nearest(quantity: &Quantity, found: &[f64], part: usize, expected: &[HighEvaluation]) -> Row {
    let row = |r: &HighEvaluation| {
        let error = distance(found, &r.values[3 * part..3 * part + 3]);
        quantity.row(r.conditions[part], error, r.scales[part])
    };
    Row::nearest(expected.iter().map(row), "the axis is in a triangle")
}
