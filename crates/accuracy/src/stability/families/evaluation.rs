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

pub(super) fn family(extent: Extent) -> Family {
    let poses = if extent.is_full() { 8 } else { 2 };
    let mut cases: Vec<Case> = extent
        .of(&(1..=MAX_ORDER).collect::<Vec<_>>(), &[1, 2, 4, 8])
        .into_iter()
        .map(|order| {
            Case::new(format!("order {order}, 14 orientations"), move |m, case| {
                let bounds = Bounds::from(([-250.0, -250.0, -600.0], [250.0, 250.0, -100.0]));
                let at = scattered(&bounds, poses, order as u64);
                rows(m, case, order, Weighting::Area, DirectionSet::Fourteen, bounds, &at)
            })
        })
        .collect();
    for set in DirectionSet::ALL {
        for weighting in [Weighting::Area, Weighting::Gnomonic] {
            let name = format!("order 2, {} orientations, {weighting:?} weights", set.len());
            cases.push(Case::new(name, move |m, case| {
                let bounds = cube([-100.0; 3], 200.0);
                let at = scattered(&bounds, poses, 77);
                rows(m, case, 2, weighting, set, bounds, &at)
            }));
        }
    }
    let boxes = [
        ("box of 1e-6 mm", cube([-5e-7; 3], 1e-6)),
        ("box of 1e6 mm", cube([-5e5; 3], 1e6)),
        ("box of 300 mm, offset by 1e6 mm", cube([1e6, -1e6, 1e6], 300.0)),
        ("box of 1e-3 mm, offset by 1e6 mm", cube([1e6, -1e6, 1e6], 1e-3)),
        ("box without height", Bounds::from(([-100.0, -100.0, -300.0], [100.0, 100.0, -300.0]))),
        ("box of 1e-9 mm height", Bounds::from(([-100.0, -100.0, 0.0], [100.0, 100.0, 1e-9]))),
    ];
    for (name, bounds) in boxes {
        cases.push(Case::new(format!("order 4, {name}"), move |m, case| {
            let at = scattered(&bounds, poses, 5);
            rows(m, case, 4, Weighting::Area, DirectionSet::Fourteen, bounds, &at)
        }));
    }
    cases.push(Case::new("order 12, corners and faces of the box", |m, case| {
        let bounds = cube([0.1, 0.2, 0.3], 99.7);
        let at = bounds.corners_mm().map(|p| (p, Vector3::y_axis()));
        rows(m, case, 12, Weighting::Area, DirectionSet::Fourteen, bounds, &at)
    }));
    for order in [2, 6] {
        let name = format!("order {order}, extrapolated by half a box");
        cases.push(Case::new(name, move |m, case| {
            let bounds = cube([-100.0; 3], 200.0);
            let around = cube([-200.0; 3], 400.0);
            let at = scattered(&around, poses, 9);
            let model = model(order, DirectionSet::Fourteen, Weighting::Area, bounds, 3);
            model.map_or_else(
                |_| vec![Row::behaviour(case, "is a model", false)],
                |model| measured(m, case, &model, &at, OutsidePolicy::Extrapolate),
            )
        }));
    }
    Family {
        name: "evaluation",
        about: "Equation (8): six values at a pose, in batches by each set of vector instructions, \
            and with one axis blended beforehand, against the sum of binomials times powers times \
            weights as it is written.",
        quantities: WAYS.concat(),
        cases,
    }
}

type PoseInField = (Point3<f64>, Unit<Vector3<f64>>);

fn scattered(bounds: &Bounds, count: usize, seed: u64) -> Vec<PoseInField> {
    let mut sequence = Sequence::new(seed);
    (0..count).map(|_| (sequence.point_in(bounds), sequence.axis())).collect()
}

fn rows(
    methods: &Methods,
    case: &str,
    order: usize,
    weighting: Weighting,
    set: DirectionSet,
    bounds: Bounds,
    poses: &[PoseInField],
) -> Vec<Row> {
    match model(order, set, weighting, bounds, order as u64) {
        Ok(model) => measured(methods, case, &model, poses, OutsidePolicy::Clamp),
        Err(_) => vec![Row::behaviour(case, "is a model", false)],
    }
}

/// The pose that comes nearest to its bound, for position and rotation, by each way.
fn measured(
    methods: &Methods,
    case: &str,
    model: &DistortionModel,
    poses: &[PoseInField],
    outside: OutsidePolicy,
) -> Vec<Row> {
    let (positions, axes): (Vec<_>, Vec<_>) = poses.iter().copied().unzip();
    let together = (methods.evaluate_together)(model, &positions, &axes, outside);
    let mut all: [[Vec<Row>; 2]; 3] = Default::default();
    for (i, (position, axis)) in poses.iter().enumerate() {
        let ways = [
            vec![(methods.evaluate)(model, position, axis, outside)],
            together.iter().map(|answers| answers[i]).collect(),
            (methods.evaluate_along)(model, position, axis, outside),
        ];
        let expected = references::evaluate(model, &point3(position), &axis3(axis), outside);
        for ((rows, quantities), answers) in all.iter_mut().zip(&WAYS).zip(&ways) {
            for answer in answers {
                let found = [answer.position_mm, answer.rotation_rad];
                for part in 0..2 {
                    rows[part].push(nearest(
                        &quantities[part],
                        case,
                        found[part].as_slice(),
                        part,
                        &expected,
                    ));
                }
            }
        }
    }
    let all = all.into_iter().flatten();
    all.filter_map(Row::worst_of).collect()
}

/// On an edge both triangles are right; the nearer one is meant.
fn nearest(
    quantity: &Quantity,
    case: &str,
    found: &[f64],
    part: usize,
    expected: &[HighEvaluation],
) -> Row {
    expected
        .iter()
        .map(|r| {
            let error = distance(found, &r.values[3 * part..3 * part + 3]);
            quantity.row(case, r.conditions[part], error, r.scales[part])
        })
        .min_by(|a, b| a.badness().total_cmp(&b.badness()))
        .unwrap_or_else(|| Row::behaviour(case, "the axis is in a triangle", false))
}
