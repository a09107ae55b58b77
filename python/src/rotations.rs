//! Basis orientations of polynomial rooms, and rotation vectors.

use crate::arrays::{matrix, rotation, rows};
use crate::choices::one_of;
use crate::errors::{Done, TrackwrightError};
use anyhow::Context;
use nalgebra::{Unit, Vector3};
use numpy::{IntoPyArray, PyArray2, PyArrayMethods};
use pyo3::prelude::*;
use trackwright_geometry::directions::{DirectionSet, Weighting};
use trackwright_geometry::rotation::log_quaternion;

/// A room's basis orientations, shape (directions, 3): unit vectors, tracker's frame.
#[pyfunction]
pub fn basis_orientations(py: Python<'_>, directions: usize) -> Done<Bound<'_, PyArray2<f64>>> {
    let set = DirectionSet::try_from(directions).context("directions")?;
    let each = set.directions().iter().map(|own| <[f64; 3]>::from(own.into_inner()));
    matrix(py, each.collect())
}

/// How axes of sensors are shared among a room's basis orientations: weights, shape (n, directions), of which
/// at most three of a row are not zero and whose sum is 1.
///
/// axes: shape (n, 3), of any length, tracker's frame. directions: 1, 6, 12, 14, 26 or 42. weights: "area" or
/// "gnomonic", as for Environment.fit.
#[pyfunction]
#[pyo3(signature = (axes, directions = 14, *, weights = "area"))]
pub fn orientation_weights<'py>(
    py: Python<'py>,
    axes: &Bound<'py, PyAny>,
    directions: usize,
    weights: &str,
) -> Done<Bound<'py, PyArray2<f64>>> {
    let set = DirectionSet::try_from(directions).context("directions")?;
    let known = [("area", Weighting::Area), ("gnomonic", Weighting::Gnomonic)];
    let weighting = one_of("weights", weights, &known)?;
    let axes = rows::<3>(axes, "axes")?;
    let mut found = Vec::with_capacity(axes.len() * set.len());
    for (row, axis) in axes.iter().enumerate() {
        let Some(axis) = Unit::try_new(Vector3::from(*axis), 0.0) else {
            let text = format!("axes, row {row}: found the length 0, expected one above zero");
            return Err(TrackwrightError::new_err(text).into());
        };
        let own = set.weights(&axis, weighting);
        found.extend((0..set.len()).map(|direction| own.of(direction)));
    }
    Ok(found.into_pyarray(py).reshape([axes.len(), set.len()])?)
}

/// The rotation vectors of quaternions: the unit axis times the angle in radians, from 0 to π, shape (n, 3).
///
/// quaternions: shape (n, 4), of unit length, scalar first.
#[pyfunction]
pub fn rotation_vectors<'py>(
    py: Python<'py>,
    quaternions: &Bound<'py, PyAny>,
) -> Done<Bound<'py, PyArray2<f64>>> {
    let each = rows::<4>(quaternions, "quaternions")?.into_iter().enumerate();
    let vectors = each.map(|(row, quaternion)| {
        let rotation = rotation(quaternion, "quaternions", row)?;
        Ok(log_quaternion(&rotation).into())
    });
    matrix(py, vectors.collect::<Done<Vec<[f64; 3]>>>()?)
}
