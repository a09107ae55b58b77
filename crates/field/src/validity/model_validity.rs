//! Model validity of a room of any kind at sensors, made ready for many of them: of a fit that kept its
//! standard error and leverage by these, else by the process of the measurements.

use super::fit_validity::FitValidity;
use super::readings::{error_share, nearest_mm};
use crate::environment::Environment;
use crate::evaluation::OutsidePolicy;
use crate::field_point::FieldPoint;
use crate::gaussian::{GaussianField, ReadingRms, Readings};
use nalgebra::{Point3, Unit, Vector3};
use rayon::prelude::*;

/// Where a sensor is, tracker frame; a marker has no axis.
pub type SensorPlace = (Point3<f64>, Option<Unit<Vector3<f64>>>);

/// A room's model validity, made ready.
pub struct ModelValidity<'a> {
    environment: &'a Environment,
    outside: OutsidePolicy,
    source: Source<'a>,
}

enum Source<'a> {
    Fit(&'a FitValidity),
    Process(&'a GaussianField, Box<Readings<'a>>),
}

/// What is known of the model at one sensor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SensorValidity {
    /// RMS length of the error of the field's position, mm; infinite where nothing determines it. Of a fit
    /// that kept its standard error that; else with the model's misfit.
    pub position_error_mm: f64,
    /// Likewise of the rotation, rad; `None` where orientations were not measured.
    pub angle_error_rad: Option<f64>,
    /// As [`super::Validity::is_supported`].
    pub is_supported: bool,
}

impl Environment {
    /// Model validity made ready; `None` where the room keeps neither its measurements nor the standard
    /// error of its fit.
    pub fn model_validity(&self, outside: OutsidePolicy) -> Option<ModelValidity<'_>> {
        let source = match (&self.fit_validity, &self.process) {
            (Some(validity), _) => Source::Fit(validity),
            (None, Some(process)) => Source::Process(process, Box::new(Readings::new(process))),
            (None, None) => return None,
        };
        Some(ModelValidity { environment: self, outside, source })
    }
}

impl ModelValidity<'_> {
    /// At each sensor. A marker is as uncertain as the worst of some axes. Where no process can be factored
    /// nothing is known.
    pub fn at(&self, sensors: &[SensorPlace]) -> Vec<SensorValidity> {
        match &self.source {
            Source::Fit(validity) => {
                let each = sensors.par_iter().map(|(position_mm, axis)| {
                    let at = validity.at_sensor(position_mm, axis.as_ref(), self.outside);
                    SensorValidity {
                        position_error_mm: at.position_std_error_mm,
                        angle_error_rad: at.angle_std_error_rad,
                        is_supported: at.is_valid,
                    }
                });
                each.collect()
            }
            Source::Process(process, readings) => {
                let bounds = self.environment.model.bounds();
                let errors = self.reading_errors(sensors, process, readings);
                let each = sensors.iter().zip(errors).map(|((position_mm, _), error)| {
                    let share = error_share(error.position_mm, process);
                    SensorValidity {
                        position_error_mm: error.position_mm,
                        angle_error_rad: error.angle_rad,
                        is_supported: share <= 1.0 && bounds.contains(position_mm),
                    }
                });
                each.collect()
            }
        }
    }

    /// At one sensor.
    pub fn at_sensor(&self, sensor: &SensorPlace) -> SensorValidity {
        self.at(std::slice::from_ref(sensor)).remove(0)
    }

    /// [`SensorValidity::is_supported`] of each sensor.
    pub fn is_supported(&self, sensors: &[SensorPlace]) -> Vec<bool> {
        match &self.source {
            Source::Fit(validity) => {
                let each = sensors.par_iter();
                each.map(|(at, axis)| validity.is_sensor_valid(at, axis.as_ref())).collect()
            }
            Source::Process(..) => self.at(sensors).iter().map(|at| at.is_supported).collect(),
        }
    }

    /// How near each sensor is to where support ends: supported up to 1, and infinite outside the model's
    /// box and where nothing determines the field. Of a fit its leverage against the greatest of its samples,
    /// else the error of a reading against the greatest of a supported one.
    pub fn shares(&self, positions_mm: &[Point3<f64>], axis: &Unit<Vector3<f64>>) -> Vec<f64> {
        match &self.source {
            Source::Fit(validity) => {
                let each = positions_mm.par_iter().map(|at| validity.leverage_share(at, axis));
                each.collect()
            }
            Source::Process(process, readings) => {
                let bounds = self.environment.model.bounds();
                let sensors: Vec<_> = positions_mm.iter().map(|at| (*at, Some(*axis))).collect();
                let errors = self.reading_errors(&sensors, process, readings);
                let each = positions_mm.iter().zip(errors).map(|(at, error)| {
                    let is_inside = bounds.contains(at);
                    if is_inside { error_share(error.position_mm, process) } else { f64::INFINITY }
                });
                each.collect()
            }
        }
    }

    /// Distance to the nearest measurement, mm; of a fit as in [`super::FitValidityAt::distance_mm`].
    pub fn distance_mm(&self, (position_mm, axis): &SensorPlace) -> f64 {
        match &self.source {
            Source::Fit(validity) => validity.sensor_distance_mm(position_mm, axis.as_ref()),
            Source::Process(process, _) => nearest_mm(process, position_mm),
        }
    }

    /// What measurements scatter by at a place, RMS lengths of vectors: noise, and of a fit that kept its
    /// standard error what the model does not follow. `None` where a fit has no residual to estimate it from.
    pub fn scatter_at(&self, position_mm: &Point3<f64>) -> Option<ReadingRms> {
        match &self.source {
            Source::Fit(validity) => {
                let parts = validity.parts();
                Some(ReadingRms {
                    position_mm: rms(&parts.position_std_mm)?,
                    angle_rad: parts.angle_std_rad.as_deref().and_then(rms),
                })
            }
            Source::Process(_, readings) => Some(readings.noise_at(position_mm)),
        }
    }

    fn reading_errors(
        &self,
        sensors: &[SensorPlace],
        process: &GaussianField,
        readings: &Readings,
    ) -> Vec<ReadingRms> {
        let axes_of = |axis: &Option<Unit<Vector3<f64>>>| match axis {
            Some(axis) => vec![*axis],
            // A coil that is turned round reads the same.
            None if process.has_rotations => {
                vec![Vector3::x_axis(), Vector3::y_axis(), Vector3::z_axis()]
            }
            None => vec![Vector3::z_axis()],
        };
        let axes: Vec<_> = sensors.iter().map(|(_, axis)| axes_of(axis)).collect();
        let each = sensors.iter().zip(&axes);
        let points: Vec<FieldPoint> = each
            .flat_map(|((at, _), axes)| axes.iter().map(|axis| FieldPoint::new(*at, *axis)))
            .collect();
        let model_errors = self.environment.measured_errors(&points, self.outside);
        let Ok(found) = readings.rms(&points, &model_errors) else {
            let angle_rad = process.has_rotations.then_some(f64::INFINITY);
            return vec![ReadingRms { position_mm: f64::INFINITY, angle_rad }; sensors.len()];
        };
        let mut found = found.into_iter();
        let worst = sensors.iter().zip(&axes).map(|((_, axis), axes)| {
            let of_sensor = found.by_ref().take(axes.len());
            let nothing = ReadingRms { position_mm: 0.0, angle_rad: None };
            let worst = of_sensor.fold(nothing, |a, b| ReadingRms {
                position_mm: a.position_mm.max(b.position_mm),
                angle_rad: b.angle_rad,
            });
            ReadingRms { angle_rad: worst.angle_rad.filter(|_| axis.is_some()), ..worst }
        });
        worst.collect()
    }
}

fn rms(values: &[Option<f64>]) -> Option<f64> {
    let squares: Option<f64> = values.iter().map(|v| v.map(|v| v * v)).sum();
    squares.filter(|_| !values.is_empty()).map(|sum| (sum / values.len() as f64).sqrt())
}
