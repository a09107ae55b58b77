//! The weights of an axis between basis orientations.

use super::prelude::*;
use trackwright_geometry::directions::DirectionWeights;

const WEIGHTS: Quantity = Quantity::new(
    "weights",
    8.0,
    "one over the sum that the weights are divided by: half areas in steradians, or \
        gnomonic coordinates",
    "1",
);

/// How far axes are moved off corners and edges.
const NEAR: f64 = 1e-12;

type Axes = Vec<Unit<Vector3<f64>>>;

type Places = fn(DirectionSet) -> Axes;

pub(super) fn family(_: Extent) -> Family {
    let mut cases = Vec::new();
    for set in DirectionSet::ALL.into_iter().skip(1) {
        for weighting in [Weighting::Area, Weighting::Gnomonic] {
            let places: [(&str, Places); 5] = [
                ("on and opposite to corners", corners),
                ("1e-12 beside corners", beside_corners),
                ("on edges", edges),
                ("1e-12 beside edges", beside_edges),
                ("scattered", scattered),
            ];
            for (place, axes) in places {
                let name = format!("{} orientations, {weighting:?}, axes {place}", set.len());
                cases.push(Case::new(name, move |m, case| {
                    let axes = axes(set);
                    let rows = axes.iter().map(|axis| weights(m, case, set, axis, weighting));
                    Row::worst_of(rows.collect()).into_iter().collect()
                }));
            }
        }
        let name = format!("{} orientations, Area, corners once more", set.len());
        cases.push(Case::new(name, move |m, case| {
            let is_one = (0..set.len()).all(|i| {
                let axis = set.directions()[i];
                (m.weights)(set, &axis, Weighting::Area).of(i) == 1.0
            });
            vec![Row::behaviour(case, "weight of exactly 1", is_one)]
        }));
        let name = format!("{} orientations, Area, edges once more", set.len());
        cases.push(Case::new(name, move |m, case| {
            let is_zero = edges(set).iter().zip(set.triangles()).all(|(axis, t)| {
                let w = (m.weights)(set, axis, Weighting::Area);
                let others = w.directions.iter().zip(&w.weights);
                others.filter(|(d, _)| **d != t[0] && **d != t[1]).all(|(_, &w)| w == 0.0)
            });
            vec![Row::behaviour(case, "opposite weight of exactly 0", is_zero)]
        }));
    }
    Family {
        name: "weights",
        about: "Area and gnomonic weights, against Van Oosterom and Strackee's formula with basis \
            orientations that are exact. On an edge the nearest of the triangles that meet there \
            is meant.",
        quantities: vec![WEIGHTS],
        cases,
    }
}

fn corners(set: DirectionSet) -> Axes {
    let own = set.directions().iter();
    own.flat_map(|d| [*d, -*d]).collect()
}

fn beside_corners(set: DirectionSet) -> Axes {
    let mut sequence = Sequence::new(3);
    let own = set.directions().iter();
    own.map(|d| Unit::new_normalize(d.as_ref() + sequence.vector() * NEAR)).collect()
}

/// One axis an edge, in the order of the triangles.
fn edges(set: DirectionSet) -> Axes {
    let point = |t: &[usize; 3]| {
        let [a, b, _] = t.map(|i| set.directions()[i].into_inner());
        Unit::new_normalize(a + b * 0.7)
    };
    set.triangles().iter().map(point).collect()
}

fn beside_edges(set: DirectionSet) -> Axes {
    let mut sequence = Sequence::new(4);
    edges(set)
        .into_iter()
        .map(|axis| Unit::new_normalize(axis.as_ref() + sequence.vector() * NEAR))
        .collect()
}

fn scattered(_: DirectionSet) -> Axes {
    let mut sequence = Sequence::new(5);
    (0..40).map(|_| sequence.axis()).collect()
}

fn weights(
    methods: &Methods,
    case: &str,
    set: DirectionSet,
    axis: &Unit<Vector3<f64>>,
    weighting: Weighting,
) -> Row {
    let found = (methods.weights)(set, axis, weighting);
    references::weights(set, &axis3(axis), weighting)
        .into_iter()
        .map(|expected| {
            let error = off_by(set, &found, &expected);
            WEIGHTS.row(case, 1.0 / expected.sum, error, 1.0)
        })
        .min_by(|a, b| a.badness().total_cmp(&b.badness()))
        .unwrap_or_else(|| Row::behaviour(case, "the axis is in a triangle", false))
}

/// Over all orientations: on an edge the order and even the triangle may differ.
fn off_by(set: DirectionSet, found: &DirectionWeights, expected: &references::HighWeights) -> f64 {
    let mut difference: Vec<High> = (0..set.len()).map(|d| High::from(found.of(d))).collect();
    for (&d, w) in expected.directions.iter().zip(&expected.weights) {
        difference[d] -= w.clone();
    }
    norm(&difference).to_f64()
}
