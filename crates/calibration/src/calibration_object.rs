//! What the EM markers of a calibration object should read, from an optical tracker (paper,
//! section 2.1; the object and its data are those of the JHU course).

use super::registration::{RegistrationError, register};
use nalgebra::Point3;
use trackwright_field::samples::{Measurement, MeasurementContent, MeasurementSet};
use trackwright_geometry::pose::Pose;

/// Known geometry, mm: markers on the EM base and on the calibration object, each in its body.
#[derive(Clone, Debug, PartialEq)]
pub struct CalibrationBody {
    /// Optical markers on the EM tracker's base, EM frame.
    pub optical_on_base: Vec<Point3<f64>>,
    /// Optical markers on the object, object frame.
    pub optical_on_object: Vec<Point3<f64>>,
    /// EM markers on the object, object frame.
    pub em_on_object: Vec<Point3<f64>>,
}

/// What both trackers read at one pose of the object, mm.
#[derive(Clone, Debug, PartialEq)]
pub struct CalibrationFrame {
    /// Optical frame.
    pub optical_on_base: Vec<Point3<f64>>,
    /// Optical frame.
    pub optical_on_object: Vec<Point3<f64>>,
    /// EM frame, distorted.
    pub em_on_object: Vec<Point3<f64>>,
}

/// A frame that could not be registered.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum CalibrationError {
    #[error("frame {frame}, {markers}: {source}")]
    Registration { frame: usize, markers: &'static str, source: RegistrationError },
    #[error("frame {frame}: {found} EM readings, expected {expected}")]
    MarkerCount { frame: usize, found: usize, expected: usize },
    #[error("no frames")]
    NoFrames,
}

/// Where each EM marker should have been read: `F_D⁻¹ F_A c`, EM frame, mm; `frame` is for errors.
pub fn expected_positions(
    body: &CalibrationBody,
    readings: &CalibrationFrame,
    frame: usize,
) -> Result<Vec<Point3<f64>>, CalibrationError> {
    let named = |markers| move |source| CalibrationError::Registration { frame, markers, source };
    let optical_from_em = register(&body.optical_on_base, &readings.optical_on_base)
        .map_err(named("optical markers on the base"))?
        .target_from_source;
    let optical_from_object = register(&body.optical_on_object, &readings.optical_on_object)
        .map_err(named("optical markers on the object"))?
        .target_from_source;
    let em_from_object = optical_from_em.inverse() * optical_from_object;
    Ok(body.em_on_object.iter().map(|c| em_from_object * c).collect())
}

/// A position-only measurement set: one row an EM marker and frame, frame by frame.
pub fn measurements(
    body: &CalibrationBody,
    frames: &[CalibrationFrame],
) -> Result<MeasurementSet, CalibrationError> {
    if frames.is_empty() {
        return Err(CalibrationError::NoFrames);
    }
    let mut measurements = Vec::new();
    for (frame, readings) in frames.iter().enumerate() {
        let expected = expected_positions(body, readings, frame)?;
        if expected.len() != readings.em_on_object.len() {
            return Err(CalibrationError::MarkerCount {
                frame,
                found: readings.em_on_object.len(),
                expected: expected.len(),
            });
        }
        measurements.extend(expected.iter().zip(&readings.em_on_object).map(|(ideal, read)| {
            Measurement {
                tracker_from_ideal: Pose::translation(ideal.x, ideal.y, ideal.z),
                tracker_from_measured: Pose::translation(read.x, read.y, read.z),
            }
        }));
    }
    Ok(MeasurementSet { measurements, content: MeasurementContent::PositionOnly })
}
