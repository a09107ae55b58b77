//! Fields of a tracker's generator, of what has no sources, and of a metal sphere.

use crate::arrays::{points, vector};
use crate::errors::{Done, TrackwrightError};
use crate::long_work;
use nalgebra::{Point3, Vector3};
use numpy::{IntoPyArray, PyArray2, PyArray3, PyArrayMethods};
use pyo3::prelude::*;
use pyo3::types::{PyComplex, PyString};
use std::path::PathBuf;
use trackwright_field::generator::{self, BUILT_IN};
use trackwright_field::harmonic::solid_harmonics::{MAX_DEGREE, gradients, terms};
use trackwright_metal::material::{Material, NAMED_MATERIALS};
use trackwright_metal::sphere::{self, SphereResponse};
use trackwright_project::Files;

/// Vectors of several kinds at each of some positions.
type Vectors<'py> = Bound<'py, PyArray3<f64>>;

fn vectors<'py>(py: Python<'py>, rows: usize, found: Vec<Vector3<f64>>) -> Done<Vectors<'py>> {
    let columns = found.len() / rows;
    let numbers: Vec<f64> = found.iter().flatten().copied().collect();
    Ok(numbers.into_pyarray(py).reshape([rows, columns, 3])?)
}

/// The coils of a tracker's field generator, whose fields in the empty room are known.
#[pyclass(frozen, module = "trackwright")]
pub struct Generator(generator::Generator);

#[pymethods]
impl Generator {
    /// A built-in generator: planar-nine or anser.
    #[staticmethod]
    fn builtin(name: &str) -> Done<Self> {
        match generator::Generator::built_in(name) {
            Some(found) => Ok(Self(found)),
            None => {
                let known = BUILT_IN.join(", ");
                let text = format!("generator: found {name:?}, expected one of {known}");
                Err(TrackwrightError::new_err(text).into())
            }
        }
    }

    /// Opens a generator (`*.generator.ron`).
    #[staticmethod]
    fn load(py: Python<'_>, path: PathBuf) -> Done<Self> {
        Ok(Self(long_work::run(py, |_| Ok(Files::default().read_generator(&path)?))?))
    }

    /// The generator's name.
    #[getter]
    fn name(&self) -> &str {
        &self.0.name
    }

    /// Number of coils.
    #[getter]
    fn coils(&self) -> usize {
        self.0.coils.len()
    }

    /// The fields of all coils, shape (n, coils, 3), tracker's frame, in mm⁻³ of a unit dipole; not finite at
    /// a dipole and on a wire.
    ///
    /// positions: shape (n, 3), mm, tracker's frame.
    fn field<'py>(&self, py: Python<'py>, positions: &Bound<'py, PyAny>) -> Done<Vectors<'py>> {
        let positions = points(positions, "positions")?;
        let mut found = vec![Vector3::zeros(); positions.len() * self.0.coils.len()];
        for (at, out) in positions.iter().zip(found.chunks_mut(self.0.coils.len())) {
            self.0.field(at, out);
        }
        vectors(py, positions.len(), found)
    }

    fn __repr__(&self) -> String {
        format!("<trackwright.Generator {:?}>", self.0.name)
    }
}

/// Gradients of the real solid harmonics of degrees 1 to `degree`, shape (n, (degree + 1)² − 1, 3): the fields
/// that a disturbance without sources is a sum of, as in harmonic rooms.
///
/// positions: shape (n, 3), relative to the centre and in parts of the scale. The harmonics are those without
/// normalisation, of each degree in the order m = 0; m = 1 cos, sin; m = 2 cos, sin; …
#[pyfunction]
pub fn solid_harmonic_gradients<'py>(
    py: Python<'py>,
    positions: &Bound<'py, PyAny>,
    degree: usize,
) -> Done<Vectors<'py>> {
    if !(1..=MAX_DEGREE).contains(&degree) {
        let text = format!("degree: found {degree}, expected 1 to {MAX_DEGREE}");
        return Err(TrackwrightError::new_err(text).into());
    }
    let positions = points(positions, "positions")?;
    let mut found = vec![Vector3::zeros(); positions.len() * terms(degree)];
    for (at, out) in positions.iter().zip(found.chunks_mut(terms(degree))) {
        gradients(degree, &at.coords, out);
    }
    vectors(py, positions.len(), found)
}

/// The dipole that a uniform alternating field induces in a metal sphere, over the field and the cube of the
/// radius: complex, as it lags behind.
///
/// radius_mm in mm, frequency_hz in Hz. material: a name, such as "aluminium" or "steel-304", or conductivity
/// in S/m and relative permeability.
#[pyfunction]
pub fn sphere_factor<'py>(
    py: Python<'py>,
    radius_mm: f64,
    material: &Bound<'py, PyAny>,
    frequency_hz: f64,
) -> Done<Bound<'py, PyComplex>> {
    let factor = sphere::sphere_factor(radius_mm, &material_of(material)?, frequency_hz)?;
    Ok(PyComplex::from_doubles(py, factor.re, factor.im))
}

/// What a metal sphere about the origin adds to the field of a dipole beside it, in phase with the dipole:
/// shape (n, 3), in the unit of the moment over mm³.
///
/// dipole_at: shape (3,), mm. moment: shape (3,). positions: shape (n, 3), mm, outside of the sphere. material
/// as for `sphere_factor`; None for a perfect conductor, which no flux enters at any frequency.
#[pyfunction]
#[pyo3(signature = (radius_mm, dipole_at, moment, positions, *, material = None, frequency_hz = 0.0))]
pub fn sphere_field<'py>(
    py: Python<'py>,
    radius_mm: f64,
    dipole_at: &Bound<'py, PyAny>,
    moment: &Bound<'py, PyAny>,
    positions: &Bound<'py, PyAny>,
    material: Option<&Bound<'py, PyAny>>,
    frequency_hz: f64,
) -> Done<Bound<'py, PyArray2<f64>>> {
    let dipole_at = Point3::from(vector::<3>(dipole_at, "dipole_at")?);
    let moment = Vector3::from(vector::<3>(moment, "moment")?);
    let positions = points(positions, "positions")?;
    let material = material.map(material_of).transpose()?;
    let found = long_work::run(py, |task| {
        let sphere = match &material {
            Some(material) => SphereResponse::new(radius_mm, material, frequency_hz)?,
            None => SphereResponse::perfect_conductor(radius_mm)?,
        };
        let mut found: Vec<[f64; 3]> = Vec::with_capacity(positions.len());
        for (row, at) in positions.iter().enumerate() {
            task.step(row, positions.len())?;
            found.push(sphere.field_of_dipole(&dipole_at, &moment, at)?.field.into());
        }
        Ok(found)
    })?;
    crate::arrays::matrix(py, found)
}

/// A material by its name, or by conductivity and permeability.
fn material_of(given: &Bound<'_, PyAny>) -> Done<Material> {
    if given.is_instance_of::<PyString>() {
        let name: String = given.extract()?;
        return Ok(Material::named(&name).ok_or_else(|| {
            let known: Vec<&str> = NAMED_MATERIALS.iter().map(|named| named.key).collect();
            let known = known.join(", ");
            TrackwrightError::new_err(format!("material: found {name:?}, expected one of {known}"))
        })?);
    }
    let Ok((conductivity, permeability)) = given.extract::<(f64, f64)>() else {
        let text = format!(
            "material: found {given}, expected a name, or conductivity in S/m and relative permeability"
        );
        return Err(TrackwrightError::new_err(text).into());
    };
    Ok(Material::new(conductivity, permeability)?)
}
