//! What several files' tests share.

use nalgebra::Vector3;
use serde_json::Value;

/// The worked cases.
pub fn physics() -> Value {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/data/golden/physics.json");
    serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap()
}

/// Three numbers of a worked case.
pub fn vector(value: &Value) -> Vector3<f64> {
    let all = value.as_array().unwrap();
    Vector3::from_iterator(all.iter().map(|v| v.as_f64().unwrap()))
}
