//! A room's disturbance as the fields that it is made of: one harmonic function a coil.
//!
//! Where no current flows and no metal is, each coil's `δB_i` is the gradient of a harmonic
//! function, a sum of solid harmonics in a ball around the volume. What a sensor there measures
//! follows from the generator alone, for every axis.

use super::solid_harmonics::{MAX_DEGREE, MAX_TERMS, gradients, terms};
use crate::generator::reading::{
    AxisReading, PoseReading, ReadingError, axis_error, read_axis, read_pose,
};
use crate::generator::{Generator, GeneratorError, MAX_COILS};
use crate::samples::Residuals;
use crate::samples::{Measurement, MeasurementContent, PoseError};
use nalgebra::{Point3, Unit, Vector3};
use trackwright_geometry::limits::{length_above_zero_problem, position_problem, short};
use trackwright_geometry::pose::Pose;
use trackwright_geometry::rotation::{axis_rotation, rotation_angle_rad};

/// `δB_i(p) = Σ a_{i,l,k} ∇Y_{l,k}((p − center) / scale)` of each coil of a generator.
#[derive(Clone, Debug, PartialEq)]
pub struct HarmonicModel {
    pub(super) generator: Generator,
    pub(super) center_mm: Point3<f64>,
    pub(super) scale_mm: f64,
    pub(super) degree: usize,
    /// Coil after coil, [`terms`] each, in the field's unit.
    pub(super) coefficients: Vec<f64>,
}

/// Why numbers are no model.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum HarmonicModelError {
    #[error(transparent)]
    Generator(#[from] GeneratorError),
    #[error("degree is {0}, expected 1 to {MAX_DEGREE}")]
    Degree(usize),
    #[error("scale is {} mm, expected {expected}", short(*scale_mm))]
    Scale { scale_mm: f64, expected: &'static str },
    #[error("center is {center_mm:?}, expected {expected}")]
    Center { center_mm: [f64; 3], expected: &'static str },
    #[error("{found} coefficients, expected {expected}")]
    Coefficients { found: usize, expected: usize },
    #[error("coefficient {0} is not finite")]
    NotFinite(usize),
}

impl HarmonicModel {
    /// # Errors
    /// The first of [`HarmonicModelError`]'s that applies.
    pub fn new(
        generator: Generator,
        center_mm: Point3<f64>,
        scale_mm: f64,
        degree: usize,
        coefficients: Vec<f64>,
    ) -> Result<Self, HarmonicModelError> {
        use HarmonicModelError as Error;
        if let Some(problem) = generator.problem() {
            return Err(problem.into());
        }
        if !(1..=MAX_DEGREE).contains(&degree) {
            return Err(Error::Degree(degree));
        }
        if let Some(expected) = length_above_zero_problem(scale_mm) {
            return Err(Error::Scale { scale_mm, expected });
        }
        if let Some(expected) = position_problem(&center_mm.coords) {
            let center_mm = center_mm.coords.into();
            return Err(Error::Center { center_mm, expected });
        }
        let expected = generator.coils.len() * terms(degree);
        let found = coefficients.len();
        if found != expected {
            return Err(Error::Coefficients { found, expected });
        }
        if let Some(index) = coefficients.iter().position(|v| !v.is_finite()) {
            return Err(Error::NotFinite(index));
        }
        Ok(Self { generator, center_mm, scale_mm, degree, coefficients })
    }

    /// The coils whose fields are disturbed.
    pub fn generator(&self) -> &Generator {
        &self.generator
    }

    /// Where the harmonics are expanded about, tracker frame.
    pub fn center_mm(&self) -> &Point3<f64> {
        &self.center_mm
    }

    /// Length that is 1 in the harmonics' argument.
    pub fn scale_mm(&self) -> f64 {
        self.scale_mm
    }

    /// Highest degree of the harmonics.
    pub fn degree(&self) -> usize {
        self.degree
    }

    /// Coil after coil, [`terms`] each.
    pub fn coefficients(&self) -> &[f64] {
        &self.coefficients
    }

    /// The same room with other coefficients, for example a draw.
    ///
    /// # Errors
    /// [`HarmonicModelError::Coefficients`] and [`HarmonicModelError::NotFinite`].
    pub fn with_coefficients(&self, coefficients: Vec<f64>) -> Result<Self, HarmonicModelError> {
        let generator = self.generator.clone();
        Self::new(generator, self.center_mm, self.scale_mm, self.degree, coefficients)
    }

    /// What the room adds to each coil's field at a point of the tracker frame.
    ///
    /// # Panics
    /// If `out` has another length than the coils.
    #[inline]
    pub fn disturbance(&self, p: &Point3<f64>, out: &mut [Vector3<f64>]) {
        assert_eq!(out.len(), self.generator.coils.len(), "one field a coil");
        let mut slopes = [Vector3::zeros(); MAX_TERMS];
        gradients(self.degree, &((p - self.center_mm) / self.scale_mm), &mut slopes);
        let each = terms(self.degree);
        let slopes = &slopes[..each];
        for (out, coefficients) in out.iter_mut().zip(self.coefficients.chunks_exact(each)) {
            let mut sum = Vector3::zeros();
            for (a, slope) in coefficients.iter().zip(slopes) {
                sum += slope * *a;
            }
            *out = sum;
        }
    }

    /// What the tracker reports of a sensor with one axis.
    pub fn read_axis(
        &self,
        position: &Point3<f64>,
        axis: &Unit<Vector3<f64>>,
    ) -> Result<AxisReading, ReadingError> {
        self.disturbed(position, |d| read_axis(&self.generator, position, axis, d))
    }

    /// What the tracker reports of a sensor with three axes.
    pub fn read_pose(&self, tracker_from_sensor: &Pose) -> Result<PoseReading, ReadingError> {
        let position = tracker_from_sensor.translation.vector.into();
        self.disturbed(&position, |d| read_pose(&self.generator, tracker_from_sensor, d))
    }

    /// Measurement error (1) of a sensor with one axis, at its true pose.
    #[inline]
    pub fn axis_error_at(
        &self,
        position: &Point3<f64>,
        axis: &Unit<Vector3<f64>>,
    ) -> Result<PoseError, ReadingError> {
        self.disturbed(position, |d| axis_error(&self.generator, position, axis, d))
    }

    /// What measurements differ by from what the model predicts at their true poses.
    pub fn residuals<'a>(
        &self,
        measurements: impl IntoIterator<Item = &'a Measurement>,
        content: MeasurementContent,
    ) -> HarmonicResiduals {
        let (mut count, mut without_reading) = (0_usize, 0);
        let (mut positions, mut angles) = (0.0, 0.0);
        for m in measurements {
            let (ideal, measured) = (&m.tracker_from_ideal, &m.tracker_from_measured);
            let position = ideal.translation.vector.into();
            let axis = ideal.rotation * Vector3::z_axis();
            let predicted = if content == MeasurementContent::SixDof {
                self.read_pose(ideal).map(|reading| {
                    let pose = reading.tracker_from_sensor;
                    let turn = pose.rotation.inverse() * measured.rotation;
                    (pose.translation.vector, rotation_angle_rad(&turn))
                })
            } else {
                self.read_axis(&position, &axis).map(|reading| {
                    let axis = measured.rotation * Vector3::z_axis();
                    let turn = axis_rotation(&reading.axis, &axis).vector_rad;
                    (reading.position_mm.coords, turn.norm())
                })
            };
            let Ok((predicted, angle)) = predicted else {
                without_reading += 1;
                continue;
            };
            count += 1;
            positions += (measured.translation.vector - predicted).norm_squared();
            angles += angle * angle;
        }
        let rms = |squares: f64| (squares / count.max(1) as f64).sqrt();
        HarmonicResiduals {
            residuals: Residuals {
                position_rms_mm: rms(positions),
                angle_rms_rad: (content != MeasurementContent::PositionOnly).then(|| rms(angles)),
            },
            measurements: count,
            without_reading,
        }
    }

    #[inline]
    fn disturbed<T>(&self, p: &Point3<f64>, read: impl FnOnce(&[Vector3<f64>]) -> T) -> T {
        let mut disturbance = [Vector3::zeros(); MAX_COILS];
        let disturbance = &mut disturbance[..self.generator.coils.len()];
        self.disturbance(p, disturbance);
        read(disturbance)
    }
}

/// How far measurements are from a model's readings.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HarmonicResiduals {
    /// Zero without any measurement.
    pub residuals: Residuals,
    /// Measurements that the residuals are of.
    pub measurements: usize,
    /// Measurements at whose true poses the tracker reports none.
    pub without_reading: usize,
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::generator::tests::{numbers, physics, point, vector};
    use nalgebra::UnitQuaternion;
    use serde_json::Value;
    use trackwright_geometry::pose::{pose_from_parts, quaternion_from_array};

    fn worked_model(golden: &Value) -> HarmonicModel {
        let coefficients = golden["coefficients"].as_array().unwrap();
        HarmonicModel::new(
            Generator::planar_nine(),
            point(&golden["centre_mm"]),
            golden["scale_mm"].as_f64().unwrap(),
            golden["degree"].as_u64().unwrap() as usize,
            coefficients.iter().flat_map(numbers).collect(),
        )
        .unwrap()
    }

    fn rotation(value: &Value) -> UnitQuaternion<f64> {
        quaternion_from_array(numbers(value).try_into().unwrap()).unwrap()
    }

    #[test]
    fn readings_are_the_worked_ones() {
        let golden = physics();
        let model = worked_model(&golden);
        for case in golden["measured"].as_array().unwrap() {
            let pose = pose_from_parts(vector(&case["position_mm"]), rotation(&case["quaternion"]));
            let position = pose.translation.vector.into();
            let axis = pose.rotation * Vector3::z_axis();
            let five = model.read_axis(&position, &axis).unwrap();
            let worked = &case["five_dof"];
            assert!((five.position_mm - point(&worked["position_mm"])).norm() < 1e-6);
            assert!((five.axis.as_ref() - vector(&worked["axis"])).norm() < 1e-8);
            let six = model.read_pose(&pose).unwrap().tracker_from_sensor;
            let worked = &case["six_dof"];
            assert!((six.translation.vector - vector(&worked["position_mm"])).norm() < 1e-6);
            let turn = six.rotation * rotation(&worked["quaternion"]).inverse();
            assert!(rotation_angle_rad(&turn) < 1e-8);
        }
    }

    #[test]
    fn no_disturbance_is_no_error() {
        let golden = physics();
        let model = worked_model(&golden);
        let model = model.with_coefficients(vec![0.0; model.coefficients().len()]).unwrap();
        let axis = Unit::new_normalize(Vector3::new(0.1, 0.5, -0.3));
        let error = model.axis_error_at(&Point3::new(30.0, 60.0, -200.0), &axis);
        assert!(error.unwrap().position_mm.norm() == 0.0);
    }

    #[test]
    fn models_that_cannot_be_are_refused() {
        let model = worked_model(&physics());
        let with = |scale, degree, count, value| {
            let center = Point3::origin();
            HarmonicModel::new(Generator::planar_nine(), center, scale, degree, vec![value; count])
                .map_err(|error| error.to_string())
        };
        assert!(with(1.0, 4, 216, 0.0).is_ok());
        for (found, message) in [
            (with(1.0, 0, 0, 0.0), "degree is 0, expected 1 to 10"),
            (with(1.0, 11, 0, 0.0), "degree is 11, expected 1 to 10"),
            (with(0.0, 4, 216, 0.0), "scale is 0 mm, expected a length above zero"),
            (with(1.0, 4, 215, 0.0), "215 coefficients, expected 216"),
            (with(1.0, 4, 216, f64::NAN), "coefficient 0 is not finite"),
        ] {
            assert_eq!(found.unwrap_err(), message);
        }
        assert!(model.with_coefficients(vec![0.0]).is_err());
    }
}
