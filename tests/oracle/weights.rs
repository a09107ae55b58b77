//! Spherical weights and rotation vectors.

use crate::support::close::{assert_all_golden, assert_golden};
use crate::support::golden::{GOLDEN, axis, count, list, matrix, number, vector};
use serde_json::Value;
use trackwright_geometry::directions::{DirectionSet, Weighting};
use trackwright_geometry::rotation::log_matrix;

/// Weights below this are not listed.
const LISTED: f64 = 1e-15;

fn check(set: DirectionSet, at: &Value, weighting: Weighting, parts: &[Value]) {
    let found = set.weights(&axis(at), weighting);
    let mut listed = 0;
    for (&direction, &weight) in found.directions.iter().zip(&found.weights) {
        let own = set.directions()[direction];
        let part = parts.iter().find(|p| (vector(&p["direction"]) - own.as_ref()).norm() < 1e-12);
        match part {
            Some(part) => {
                listed += 1;
                assert_golden("weight", weight, number(&part["weight"]), 1e-6);
            }
            None => assert!(weight <= 10.0 * LISTED, "{weight} of {own:?} is not listed"),
        }
    }
    assert_eq!(listed, parts.len(), "{set:?} {at}");
}

#[test]
fn area_weights_of_the_papers_set_agree() {
    for case in list(&GOLDEN, "weights") {
        check(DirectionSet::Fourteen, &case["axis"], Weighting::Area, list(case, "parts"));
    }
}

#[test]
fn weights_of_every_set_agree() {
    for case in list(&GOLDEN, "weight_sets") {
        let set = DirectionSet::try_from(count(&case["directions"])).unwrap();
        check(set, &case["axis"], Weighting::Area, list(case, "area"));
        check(set, &case["axis"], Weighting::Gnomonic, list(case, "gnomonic"));
    }
}

#[test]
fn rotation_vectors_agree() {
    for case in list(&GOLDEN, "rotation_log") {
        let found = log_matrix(&matrix(&case["rotation"]));
        let expected = vector(&case["log"]);
        assert_all_golden("log", found.as_slice(), expected.as_slice(), 1e-12);
    }
}
