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
    let places: [(&str, Places); 5] = [
        ("on and opposite to corners", corners),
        ("1e-12 beside corners", beside_corners),
        ("on edges", edges),
        ("1e-12 beside edges", beside_edges),
        ("scattered", scattered),
    ];
    let family = Family::new(
        "weights",
        "Area and gnomonic weights, against Van Oosterom and Strackee's formula with basis \
            orientations that are exact. On an edge the nearest of the triangles that meet there \
            is meant.",
        &[WEIGHTS],
    );
    DirectionSet::ALL.into_iter().skip(1).fold(family, |family, set| {
        let named = |what: &str| format!("{} orientations, {what}", set.len());
        let axes = [Weighting::Area, Weighting::Gnomonic].into_iter().flat_map(|weighting| {
            places.map(|(place, axes)| {
                (named(&format!("{weighting:?}, axes {place}")), (set, weighting, axes(set)))
            })
        });
        family
            .with(axes, rows)
            .with([(named("Area, corners once more"), set)], corners_are_one)
            .with([(named("Area, edges once more"), set)], edges_are_zero)
    })
}

fn corners_are_one(methods: &Methods, set: &DirectionSet) -> Found {
    let weight = |(i, axis)| (methods.weights)(*set, axis, Weighting::Area).of(i);
    let is_one = set.directions().iter().enumerate().all(|corner| weight(corner) == 1.0);
    Ok(vec![must("weight of exactly 1", is_one)])
}

fn edges_are_zero(methods: &Methods, set: &DirectionSet) -> Found {
    let is_zero = edges(*set).iter().zip(set.triangles()).all(|(axis, t)| {
        let w = (methods.weights)(*set, axis, Weighting::Area);
        let others = w.directions.iter().zip(&w.weights);
        others.filter(|(d, _)| **d != t[0] && **d != t[1]).all(|(_, &w)| w == 0.0)
    });
    Ok(vec![must("opposite weight of exactly 0", is_zero)])
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

fn rows(methods: &Methods, (set, weighting, axes): &(DirectionSet, Weighting, Axes)) -> Found {
    let row = |axis: &Unit<Vector3<f64>>| {
        let found = (methods.weights)(*set, axis, *weighting);
        let expected = references::weights(*set, &axis3(axis), *weighting);
        let rows = expected
            .iter()
            .map(|expected| WEIGHTS.row(1.0 / expected.sum, off_by(*set, &found, expected), 1.0));
        Row::nearest(rows, "the axis is in a triangle")
    };
    Ok(axes.iter().map(row).collect())
}

/// Over all orientations: on an edge the order and even the triangle may differ.
fn off_by(set: DirectionSet, found: &DirectionWeights, expected: &references::HighWeights) -> f64 {
    let mut difference: Vec<High> = (0..set.len()).map(|d| High::from(found.of(d))).collect();
    for (&d, w) in expected.directions.iter().zip(&expected.weights) {
        difference[d] -= w.clone();
    }
    norm(&difference).to_f64()
}
