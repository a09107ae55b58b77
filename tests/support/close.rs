//! Comparisons that report by how much they fail.

/// Relative tolerance of the worked cases (`tests/data/golden`).
const GOLDEN: f64 = 1e-9;

/// Panics unless `found` agrees with `expected` to `relative` of the larger of `expected` and
/// `floor`, the size below which a value of this kind is round-off.
#[track_caller]
pub fn assert_close(what: &str, found: f64, expected: f64, relative: f64, floor: f64) {
    let allowed = relative * expected.abs().max(floor);
    let off = (found - expected).abs();
    assert!(
        off <= allowed,
        "{what}: found {found:e}, expected {expected:e}, off by {off:e}, allowed {allowed:e}"
    );
}

/// [`assert_close`] for each pair, relative to the largest expected magnitude: components of a
/// vector share their scale.
#[track_caller]
pub fn assert_all_close(what: &str, found: &[f64], expected: &[f64], relative: f64, floor: f64) {
    assert_eq!(found.len(), expected.len(), "{what}: lengths");
    let scale = expected.iter().fold(floor, |m, v| m.max(v.abs()));
    for (i, (f, e)) in found.iter().zip(expected).enumerate() {
        assert_close(&format!("{what}[{i}]"), *f, *e, relative, scale);
    }
}

/// [`assert_close`] with the tolerance of the worked cases.
#[track_caller]
pub fn assert_golden(what: &str, found: f64, expected: f64, floor: f64) {
    assert_close(what, found, expected, GOLDEN, floor);
}

/// [`assert_all_close`] with the tolerance of the worked cases.
#[track_caller]
pub fn assert_all_golden(what: &str, found: &[f64], expected: &[f64], floor: f64) {
    assert_all_close(what, found, expected, GOLDEN, floor);
}
