//! NumPy arrays of positions and quaternions as points and poses, and back.

use crate::errors::Done;
use nalgebra::{Point3, UnitQuaternion, Vector3};
use numpy::ndarray::ArrayView2;
use numpy::{
    Element, IntoPyArray, PyArray1, PyArray2, PyArrayDyn, PyArrayMethods, PyReadonlyArrayDyn,
    PyUntypedArrayMethods,
};
use pyo3::prelude::*;
use trackwright_formats::table::{NotUnit, unit_rotation};
use trackwright_geometry::pose::{Pose, pose_from_parts, pose_to_array, quaternion_to_array};

/// Rows of numbers that go out.
pub type Matrix<'py> = Bound<'py, PyArray2<f64>>;

/// Numbers that go out.
pub type Column<'py> = Bound<'py, PyArray1<f64>>;

/// Why an array is not what it has to be. Rows are counted from 0, as Python counts.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ArrayError {
    #[error("{what}: found the dtype {found}, expected real numbers")]
    Dtype { what: String, found: String },
    #[error("{what}: found the shape {found}, expected {expected}")]
    Shape { what: String, found: String, expected: String },
    #[error("{what}: found {found} rows, expected {expected}, one for each of {of}")]
    Rows { what: String, found: usize, expected: usize, of: String },
    #[error("{what}: found masked cells, expected none")]
    Masked { what: String },
    #[error("{what}: found no rows, expected at least one")]
    NoRows { what: String },
    #[error("{what}, row {row}: found {found}, expected {expected}")]
    Number { what: String, row: usize, found: f64, expected: &'static str },
    #[error("{what}, row {row}: length of the quaternion is {length}, expected {expected}")]
    Quaternion { what: String, row: usize, length: f64, expected: &'static str },
}

/// Real numbers of any shape: the array itself where it has 64-bit floats already, whatever its
/// strides.
///
/// # Errors
/// What is no array of real numbers.
pub fn floats<'py>(given: &Bound<'py, PyAny>, what: &str) -> Done<PyReadonlyArrayDyn<'py, f64>> {
    let numpy = given.py().import("numpy")?;
    // A plain array would have some number in the place of what is masked.
    if numpy.getattr("ma")?.call_method1("is_masked", (given,))?.is_truthy()? {
        return Err(ArrayError::Masked { what: what.to_owned() }.into());
    }
    let array = numpy.call_method1("asarray", (given,))?;
    let dtype = array.getattr("dtype")?;
    let kind: String = dtype.getattr("kind")?.extract()?;
    if !["f", "i", "u"].contains(&kind.as_str()) {
        return Err(ArrayError::Dtype { what: what.to_owned(), found: dtype.to_string() }.into());
    }
    let array = numpy.call_method1("asarray", (array, "float64"))?;
    let array = array.cast_into::<PyArrayDyn<f64>>().map_err(PyErr::from)?;
    Ok(array.try_readonly()?)
}

/// An array's shape as Python writes it.
fn shape_text(shape: &[usize]) -> String {
    match shape {
        [one] => format!("({one},)"),
        shape => {
            let sizes: Vec<String> = shape.iter().map(ToString::to_string).collect();
            format!("({})", sizes.join(", "))
        }
    }
}

/// The rows of a matrix, each with finite numbers.
///
/// # Errors
/// Another shape, no rows, numbers that are not finite.
pub fn rows<const N: usize>(given: &Bound<'_, PyAny>, what: &str) -> Done<Vec<[f64; N]>> {
    let array = floats(given, what)?;
    let shape_error = || ArrayError::Shape {
        what: what.to_owned(),
        found: shape_text(array.shape()),
        expected: format!("(n, {N})"),
    };
    let view = array.as_array();
    let view: ArrayView2<f64> = view.into_dimensionality().map_err(|_| shape_error())?;
    if view.ncols() != N {
        return Err(shape_error().into());
    }
    if view.nrows() == 0 {
        return Err(ArrayError::NoRows { what: what.to_owned() }.into());
    }
    let mut found = Vec::with_capacity(view.nrows());
    for (row, values) in view.rows().into_iter().enumerate() {
        let values: [f64; N] = std::array::from_fn(|k| values[k]);
        check_finite(&values, what, row)?;
        found.push(values);
    }
    Ok(found)
}

fn check_finite(values: &[f64], what: &str, row: usize) -> Result<(), ArrayError> {
    match values.iter().find(|value| !value.is_finite()) {
        None => Ok(()),
        Some(&found) => {
            let what = what.to_owned();
            Err(ArrayError::Number { what, row, found, expected: "a finite number" })
        }
    }
}

/// One row of numbers that need not be finite: what takes them checks them.
///
/// # Errors
/// Another shape.
pub fn vector<const N: usize>(given: &Bound<'_, PyAny>, what: &str) -> Done<[f64; N]> {
    let array = floats(given, what)?;
    let view = array.as_array();
    if view.shape() != [N] {
        return Err(ArrayError::Shape {
            what: what.to_owned(),
            found: shape_text(view.shape()),
            expected: format!("({N},)"),
        }
        .into());
    }
    Ok(std::array::from_fn(|k| view[[k]]))
}

/// A rotation from a quaternion, scalar first, whose length is 1 within a thousandth.
///
/// # Errors
/// Another length.
pub fn rotation(
    quaternion: [f64; 4],
    what: &str,
    row: usize,
) -> Result<UnitQuaternion<f64>, ArrayError> {
    unit_rotation(quaternion).map_err(|NotUnit { length, expected }| ArrayError::Quaternion {
        what: what.to_owned(),
        row,
        length,
        expected,
    })
}

/// One pose: x, y, z in mm and a unit quaternion, scalar first.
///
/// # Errors
/// Another shape, or a quaternion that is not of unit length.
pub fn pose(given: &Bound<'_, PyAny>, what: &str) -> Done<Pose> {
    let [x, y, z, quaternion @ ..] = vector::<7>(given, what)?;
    Ok(pose_from_parts(Vector3::new(x, y, z), rotation(quaternion, what, 0)?))
}

/// Points, in mm.
///
/// # Errors
/// Those of [`rows`].
pub fn points(given: &Bound<'_, PyAny>, what: &str) -> Done<Vec<Point3<f64>>> {
    Ok(rows::<3>(given, what)?.into_iter().map(Point3::from).collect())
}

/// Poses of positions and as many quaternions.
///
/// # Errors
/// Those of [`rows`], and another number of quaternions.
pub fn poses(positions: &Bound<'_, PyAny>, quaternions: &Bound<'_, PyAny>) -> Done<Vec<Pose>> {
    let positions = rows::<3>(positions, "positions")?;
    let quaternions = rows::<4>(quaternions, "quaternions")?;
    if positions.len() != quaternions.len() {
        return Err(ArrayError::Rows {
            what: "quaternions".to_owned(),
            found: quaternions.len(),
            expected: positions.len(),
            of: "positions".to_owned(),
        }
        .into());
    }
    let each = positions.into_iter().zip(quaternions).enumerate();
    let poses = each.map(|(row, (position, quaternion))| {
        let rotation = rotation(quaternion, "quaternions", row)?;
        Ok(pose_from_parts(position.into(), rotation))
    });
    poses.collect()
}

/// A matrix of rows, without a copy.
pub fn matrix<T: Element, const N: usize>(
    py: Python<'_>,
    rows: Vec<[T; N]>,
) -> Done<Bound<'_, PyArray2<T>>> {
    let count = rows.len();
    Ok(rows.into_flattened().into_pyarray(py).reshape([count, N])?)
}

/// Where no number is known.
const NONE: [f64; 7] = [f64::NAN; 7];

/// Positions and quaternions of poses; those of none are not a number.
pub fn parts<'py>(
    py: Python<'py>,
    poses: impl IntoIterator<Item = Option<Pose>>,
) -> Done<(Matrix<'py>, Matrix<'py>)> {
    let mut positions: Vec<[f64; 3]> = Vec::new();
    let mut quaternions: Vec<[f64; 4]> = Vec::new();
    for pose in poses {
        let [x, y, z, quaternion @ ..] = pose.as_ref().map_or(NONE, pose_to_array);
        positions.push([x, y, z]);
        quaternions.push(quaternion);
    }
    Ok((matrix(py, positions)?, matrix(py, quaternions)?))
}

/// One pose as a row of seven.
pub fn pose_array<'py>(py: Python<'py>, pose: &Pose) -> Column<'py> {
    pose_to_array(pose).to_vec().into_pyarray(py)
}

/// A quaternion, scalar first.
pub fn quaternion_array<'py>(py: Python<'py>, rotation: &UnitQuaternion<f64>) -> Column<'py> {
    quaternion_to_array(rotation).to_vec().into_pyarray(py)
}

/// A point or direction.
pub fn vector_array<'py>(py: Python<'py>, values: [f64; 3]) -> Column<'py> {
    values.to_vec().into_pyarray(py)
}
