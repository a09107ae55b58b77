//! Edits: the only ways in which a design changes, each checked before it is applied.

use super::content::{BodyRole, Design, DesignBody};
use crate::geometry::mesh_reference::MeshReference;
use crate::geometry::pose::Pose;
use crate::study::motion::{Motion, MotionError};
use crate::study::requirement::Requirement;
use crate::tracking::body::{Sensor, SensorOrientation};
use nalgebra::Point3;

/// How far from 1 the length of an axis or quaternion may be: round-off of a normalised one.
const UNIT_TOLERANCE: f64 = 1e-9;

/// One change of a design.
#[derive(Clone, Debug, PartialEq)]
pub enum Edit {
    SetName(String),
    SetSensor {
        body: BodyRole,
        index: usize,
        sensor: Sensor,
    },
    AddSensor {
        body: BodyRole,
        sensor: Sensor,
    },
    RemoveSensor {
        body: BodyRole,
        index: usize,
    },
    SetTip {
        body: BodyRole,
        tip_in_body: Option<Point3<f64>>,
    },
    /// `tracker_from_crf`.
    SetCrfPose(Pose),
    /// `crf_from_tool`.
    SetToolPose(Pose),
    SetMotion(Option<Motion>),
    SetRequirement(Option<Requirement>),
    /// Millimetres.
    SetOrientationWeight(Option<f64>),
    /// A file relative to the design's.
    SetEnvironment(String),
    /// A file relative to the body's.
    SetMesh {
        body: BodyRole,
        mesh: Option<MeshReference>,
    },
}

/// Why an edit was not applied; the design is as it was.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum EditError {
    #[error("the design has no CRF")]
    NoCrf,
    #[error("the {body} has no sensor {index}, it has {count}")]
    NoSuchSensor {
        body: BodyRole,
        index: usize,
        count: usize,
    },
    #[error("a body needs at least one sensor")]
    LastSensor,
    #[error("the {what} is empty, expected a name")]
    Empty { what: &'static str },
    #[error("the {body} already has a sensor named {name:?}, expected another name")]
    DuplicateSensorName { body: BodyRole, name: String },
    #[error("{what} is {value}, expected a finite number")]
    NotFinite { what: &'static str, value: f64 },
    #[error("{what} is {value}, expected a number above zero")]
    NotPositive { what: &'static str, value: f64 },
    #[error("{what} is {value}, expected zero or more")]
    Negative { what: &'static str, value: f64 },
    #[error("the {what} has length {length}, expected 1")]
    NotUnit { what: &'static str, length: f64 },
    #[error(transparent)]
    Motion(#[from] MotionError),
}

impl Edit {
    /// What undo calls it, as far as the edit alone tells.
    pub fn label(&self) -> String {
        match self {
            Self::SetName(_) => "Rename design".into(),
            Self::SetSensor { sensor, .. } => format!("Move sensor {}", sensor.name),
            Self::AddSensor { sensor, .. } => format!("Add sensor {}", sensor.name),
            Self::RemoveSensor { .. } => "Remove sensor".into(),
            Self::SetTip { body, .. } => format!("Move {body} tip"),
            Self::SetCrfPose(_) => "Move CRF".into(),
            Self::SetToolPose(_) => "Move tool".into(),
            Self::SetMotion(_) => "Change range of motion".into(),
            Self::SetRequirement(_) => "Change requirement".into(),
            Self::SetOrientationWeight(_) => "Change orientation weight".into(),
            Self::SetEnvironment(_) => "Change environment".into(),
            Self::SetMesh { body, .. } => format!("Change {body}'s mesh"),
        }
    }

    /// What undo calls it, knowing what it changes.
    pub fn label_for(&self, design: &Design) -> String {
        let sensor_at = |body: &BodyRole, index: &usize| {
            design.body(*body).and_then(|b| b.rigid.sensors.get(*index))
        };
        match self {
            Self::SetSensor {
                body,
                index,
                sensor,
            } => match sensor_at(body, index) {
                Some(before) if before.name != sensor.name => {
                    format!("Rename sensor {}", before.name)
                }
                Some(before) if is_retyped(before, sensor) => {
                    format!("Change sensor {}", sensor.name)
                }
                _ => self.label(),
            },
            Self::RemoveSensor { body, index } => match sensor_at(body, index) {
                Some(sensor) => format!("Remove sensor {}", sensor.name),
                None => self.label(),
            },
            _ => self.label(),
        }
    }

    /// Changes the design, or leaves it as it is.
    ///
    /// # Errors
    /// See [`EditError`]; the design is then unchanged.
    pub(super) fn apply_to(self, design: &mut Design) -> Result<(), EditError> {
        match self {
            Self::SetName(name) => design.name = not_empty("design's name", name)?,
            Self::SetSensor {
                body,
                index,
                sensor,
            } => {
                let sensors = &mut body_of(design, body)?.rigid.sensors;
                check_index(body, index, sensors.len())?;
                check_sensor(&sensor)?;
                let others = sensors.iter().enumerate().filter(|(i, _)| *i != index);
                check_name(body, &sensor.name, others.map(|(_, s)| s))?;
                sensors[index] = sensor;
            }
            Self::AddSensor { body, sensor } => {
                let sensors = &mut body_of(design, body)?.rigid.sensors;
                check_sensor(&sensor)?;
                check_name(body, &sensor.name, sensors.iter())?;
                sensors.push(sensor);
            }
            Self::RemoveSensor { body, index } => {
                let sensors = &mut body_of(design, body)?.rigid.sensors;
                check_index(body, index, sensors.len())?;
                if sensors.len() == 1 {
                    return Err(EditError::LastSensor);
                }
                sensors.remove(index);
            }
            Self::SetTip { body, tip_in_body } => {
                let rigid = &mut body_of(design, body)?.rigid;
                if let Some(tip) = &tip_in_body {
                    check_finite("the tip", tip.iter())?;
                }
                rigid.tip_in_body = tip_in_body;
            }
            Self::SetCrfPose(pose) => {
                let crf = design.crf.as_mut().ok_or(EditError::NoCrf)?;
                check_pose(&pose)?;
                crf.tracker_from_crf = pose;
            }
            Self::SetToolPose(pose) => {
                check_pose(&pose)?;
                design.tool.crf_from_tool = pose;
            }
            Self::SetMotion(motion) => {
                if let Some(motion) = &motion {
                    motion.grid(&Pose::identity())?;
                }
                design.motion = motion;
            }
            Self::SetRequirement(requirement) => {
                if let Some(requirement) = &requirement {
                    check_requirement(requirement)?;
                }
                design.requirement = requirement;
            }
            Self::SetOrientationWeight(weight_mm) => {
                if let Some(weight_mm) = weight_mm {
                    check_not_negative("the orientation weight", weight_mm)?;
                }
                design.orientation_weight_mm = weight_mm;
            }
            Self::SetEnvironment(environment) => {
                design.environment = not_empty("environment's file", environment)?;
            }
            Self::SetMesh { body, mesh } => {
                let body = body_of(design, body)?;
                if let Some(mesh) = &mesh {
                    check_mesh(mesh)?;
                }
                body.mesh = mesh;
            }
        }
        Ok(())
    }
}

fn is_retyped(before: &Sensor, after: &Sensor) -> bool {
    before.coil != after.coil
        || before.orientation.degrees_of_freedom() != after.orientation.degrees_of_freedom()
}

fn body_of(design: &mut Design, role: BodyRole) -> Result<&mut DesignBody, EditError> {
    design.body_mut(role).ok_or(EditError::NoCrf)
}

fn check_index(body: BodyRole, index: usize, count: usize) -> Result<(), EditError> {
    if index < count {
        Ok(())
    } else {
        Err(EditError::NoSuchSensor { body, index, count })
    }
}

fn not_empty(what: &'static str, text: String) -> Result<String, EditError> {
    if text.trim().is_empty() {
        Err(EditError::Empty { what })
    } else {
        Ok(text)
    }
}

fn check_name<'a>(
    body: BodyRole,
    name: &str,
    mut others: impl Iterator<Item = &'a Sensor>,
) -> Result<(), EditError> {
    if name.trim().is_empty() {
        return Err(EditError::Empty {
            what: "sensor's name",
        });
    }
    if others.any(|other| other.name == name) {
        return Err(EditError::DuplicateSensorName {
            body,
            name: name.to_owned(),
        });
    }
    Ok(())
}

fn check_sensor(sensor: &Sensor) -> Result<(), EditError> {
    check_finite("the sensor's position", sensor.position_in_body.iter())?;
    match &sensor.orientation {
        SensorOrientation::FiveDof(axis) => check_unit("sensor's axis", axis.norm())?,
        SensorOrientation::SixDof(rotation) => {
            check_unit("sensor's rotation", rotation.quaternion().norm())?;
        }
    }
    if let Some(coil) = &sensor.coil {
        check_positive("the coil's diameter", coil.diameter_mm)?;
        check_positive("the coil's length", coil.length_mm)?;
    }
    Ok(())
}

fn check_pose(pose: &Pose) -> Result<(), EditError> {
    check_finite("the position", pose.translation.vector.iter())?;
    check_unit("rotation", pose.rotation.quaternion().norm())
}

fn check_mesh(mesh: &MeshReference) -> Result<(), EditError> {
    if mesh.file.trim().is_empty() {
        return Err(EditError::Empty {
            what: "mesh's file",
        });
    }
    match mesh.unit {
        Some(unit) => check_positive("the mesh's unit", unit.mm_per_unit()),
        None => Ok(()),
    }
}

fn check_requirement(requirement: &Requirement) -> Result<(), EditError> {
    let limits = [
        ("position_rms", requirement.position_rms_mm),
        ("position_p95", requirement.position_p95_mm),
        ("position_max", requirement.position_max_mm),
        ("angle_rms", requirement.angle_rms_deg),
        ("angle_max", requirement.angle_max_deg),
    ];
    for (name, limit) in limits {
        if let Some(limit) = limit {
            check_not_negative(name, limit)?;
        }
    }
    Ok(())
}

fn check_finite<'a>(
    what: &'static str,
    mut values: impl Iterator<Item = &'a f64>,
) -> Result<(), EditError> {
    match values.find(|v| !v.is_finite()) {
        Some(&value) => Err(EditError::NotFinite { what, value }),
        None => Ok(()),
    }
}

fn check_positive(what: &'static str, value: f64) -> Result<(), EditError> {
    check_finite(what, [value].iter())?;
    if value > 0.0 {
        Ok(())
    } else {
        Err(EditError::NotPositive { what, value })
    }
}

fn check_not_negative(what: &'static str, value: f64) -> Result<(), EditError> {
    check_finite(what, [value].iter())?;
    if value >= 0.0 {
        Ok(())
    } else {
        Err(EditError::Negative { what, value })
    }
}

fn check_unit(what: &'static str, length: f64) -> Result<(), EditError> {
    // A length that is not a number is not within the tolerance either.
    if (length - 1.0).abs() <= UNIT_TOLERANCE {
        Ok(())
    } else {
        Err(EditError::NotUnit { what, length })
    }
}
