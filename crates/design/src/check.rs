//! What an edit may put into a design.

use super::content::DesignBody;
use super::edit_error::{EditError, MAX_SENSORS};
use super::things::BodyRole;
use std::collections::HashSet;
use trackwright_geometry::limits::{length_above_zero_problem, length_problem, position_problem};
use trackwright_geometry::mesh_reference::MeshReference;
use trackwright_geometry::pose::Pose;
use trackwright_simulation::body::{Sensor, SensorOrientation};
use trackwright_simulation::motion::{Motion, MotionError};
use trackwright_simulation::requirement::Requirement;

/// How far from 1 the length of an axis or quaternion may be: round-off of a normalised one.
const UNIT_TOLERANCE: f64 = 1e-9;

pub(super) fn check_not_empty(what: &'static str, text: &str) -> Result<(), EditError> {
    if text.trim().is_empty() { Err(EditError::Empty { what }) } else { Ok(()) }
}

/// Checks a list of sensors in which those at `changed` are new or were changed: what they hold,
/// and that no name is there twice.
pub(super) fn check_sensors(
    body: BodyRole,
    sensors: &[Sensor],
    changed: impl Iterator<Item = usize>,
) -> Result<(), EditError> {
    if sensors.len() > MAX_SENSORS {
        return Err(EditError::TooManySensors { body, count: sensors.len() });
    }
    for sensor in changed.filter_map(|index| sensors.get(index)) {
        check_not_empty("sensor's name", &sensor.name)?;
        check_sensor(sensor)?;
    }
    let mut names = HashSet::with_capacity(sensors.len());
    match sensors.iter().find(|s| !names.insert(s.name.as_str())) {
        None => Ok(()),
        Some(sensor) => Err(EditError::DuplicateSensorName { body, name: sensor.name.clone() }),
    }
}

/// Checks a whole body. Any name will do, as in a file.
pub(super) fn check_body(role: BodyRole, body: &DesignBody) -> Result<(), EditError> {
    check_not_empty("body's file", &body.reference)?;
    let sensors = &body.rigid.sensors;
    if sensors.is_empty() {
        return Err(EditError::LastSensor);
    }
    check_sensors(role, sensors, 0..sensors.len())?;
    if let Some(tip) = &body.rigid.tip_in_body {
        check_position("the tip", tip.iter())?;
    }
    body.mounting.check()?;
    body.mesh.as_ref().map_or(Ok(()), check_mesh)
}

pub(super) fn check_motion(motion: Option<&Motion>) -> Result<(), MotionError> {
    motion.map_or(Ok(()), |motion| motion.trials().map(|_| ()))
}

fn check_sensor(sensor: &Sensor) -> Result<(), EditError> {
    check_position("the sensor's position", sensor.position_in_body.iter())?;
    match &sensor.orientation {
        SensorOrientation::Marker => {}
        SensorOrientation::FiveDof(axis) => check_unit("sensor's axis", axis.norm())?,
        SensorOrientation::SixDof(rotation) => {
            check_unit("sensor's rotation", rotation.quaternion().norm())?;
        }
    }
    if let Some(coil) = &sensor.coil {
        check_length_above_zero("the coil's diameter", coil.diameter_mm)?;
        check_length_above_zero("the coil's length", coil.length_mm)?;
    }
    Ok(())
}

pub(super) fn check_pose(pose: &Pose) -> Result<(), EditError> {
    check_position("the position", pose.translation.vector.iter())?;
    check_unit("rotation", pose.rotation.quaternion().norm())
}

pub(super) fn check_requirement(requirement: Option<&Requirement>) -> Result<(), EditError> {
    let Some(requirement) = requirement else {
        return Ok(());
    };
    for (metric, limit) in requirement.bounds() {
        check_finite(metric.name(), [limit].iter())?;
        check_number(metric.name(), limit, Requirement::bound_problem(metric, limit))?;
    }
    Ok(())
}

/// Checks the coordinates of a position.
pub(super) fn check_position<'a>(
    what: &'static str,
    mut coordinates_mm: impl Iterator<Item = &'a f64>,
) -> Result<(), EditError> {
    coordinates_mm.try_for_each(|&value| match position_problem(&[value]) {
        None => Ok(()),
        Some(_) if !value.is_finite() => Err(EditError::NotFinite { what, value }),
        Some(expected) => Err(EditError::Number { what, value, expected }),
    })
}

pub(super) fn check_finite<'a>(
    what: &'static str,
    mut values: impl Iterator<Item = &'a f64>,
) -> Result<(), EditError> {
    match values.find(|v| !v.is_finite()) {
        Some(&value) => Err(EditError::NotFinite { what, value }),
        None => Ok(()),
    }
}

pub(super) fn check_mesh(mesh: &MeshReference) -> Result<(), EditError> {
    check_not_empty("mesh's file", &mesh.file)?;
    let unit_mm = mesh.unit.map(|unit| unit.mm_per_unit());
    unit_mm.map_or(Ok(()), |unit_mm| check_length_above_zero("the mesh's unit", unit_mm))
}

fn check_length_above_zero(what: &'static str, value: f64) -> Result<(), EditError> {
    check_finite(what, [value].iter())?;
    if value > 0.0 {
        check_number(what, value, length_above_zero_problem(value))
    } else {
        Err(EditError::NotPositive { what, value })
    }
}

/// Checks a length of zero or more.
pub(super) fn check_length(what: &'static str, value: f64) -> Result<(), EditError> {
    check_finite(what, [value].iter())?;
    check_number(what, value, length_problem(value))
}

fn check_number(
    what: &'static str,
    value: f64,
    problem: Option<&'static str>,
) -> Result<(), EditError> {
    problem.map_or(Ok(()), |expected| Err(EditError::Number { what, value, expected }))
}

fn check_unit(what: &'static str, length: f64) -> Result<(), EditError> {
    // A length that is not a number is not within the tolerance either.
    if (length - 1.0).abs() <= UNIT_TOLERANCE {
        Ok(())
    } else {
        Err(EditError::NotUnit { what, length })
    }
}
