//! Reads the worked cases.

use super::data::own;
use nalgebra::{Matrix3, Point3, Unit, UnitQuaternion, Vector3};
use serde_json::Value;
use std::sync::LazyLock;
use trackwright_geometry::pose::{Pose, pose_from_array, quaternion_from_matrix};

/// All worked cases.
pub static GOLDEN: LazyLock<Value> = LazyLock::new(|| {
    let text = std::fs::read_to_string(own("golden/golden.json")).unwrap();
    serde_json::from_str(&text).unwrap()
});

pub fn list<'a>(value: &'a Value, key: &str) -> &'a [Value] {
    value[key].as_array().unwrap_or_else(|| panic!("{key} is a list"))
}

pub fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or_else(|| panic!("{value} is a number"))
}

pub fn count(value: &Value) -> usize {
    usize::try_from(value.as_u64().unwrap_or_else(|| panic!("{value} is a count"))).unwrap()
}

pub fn numbers<const N: usize>(value: &Value) -> [f64; N] {
    let all: Vec<f64> = value.as_array().unwrap().iter().map(number).collect();
    all.try_into().unwrap_or_else(|all| panic!("{all:?} has {N} numbers"))
}

pub fn vector(value: &Value) -> Vector3<f64> {
    numbers::<3>(value).into()
}

pub fn point(value: &Value) -> Point3<f64> {
    numbers::<3>(value).into()
}

pub fn axis(value: &Value) -> Unit<Vector3<f64>> {
    Unit::new_normalize(vector(value))
}

/// Row by row.
pub fn matrix(value: &Value) -> Matrix3<f64> {
    Matrix3::from_row_slice(&numbers::<9>(value))
}

pub fn rotation(value: &Value) -> UnitQuaternion<f64> {
    quaternion_from_matrix(&matrix(value))
}

pub fn pose(value: &Value) -> Pose {
    pose_from_array(numbers(value)).unwrap()
}
