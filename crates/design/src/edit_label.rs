//! What undo calls an edit.

use super::arrange::as_set;
use super::content::{BodyRole, Design, Target};
use super::edit::Edit;
use trackwright_simulation::body::Sensor;

impl Edit {
    /// What undo calls it, as far as the edit alone tells.
    pub fn label(&self) -> String {
        match self {
            Self::SetName(_) => "Rename design".into(),
            Self::SetBodyName { body, .. } => format!("Rename {body}"),
            Self::SetSensor { sensor, .. } => format!("Move sensor {}", sensor.name),
            Self::SetSensors { sensors, .. } => match &sensors[..] {
                [(_, sensor)] => format!("Move sensor {}", sensor.name),
                sensors => format!("Move {} sensors", sensors.len()),
            },
            Self::AddSensor { sensor, .. } => format!("Add sensor {}", sensor.name),
            Self::AddSensors { sensors, .. } => match &sensors[..] {
                [sensor] => format!("Add sensor {}", sensor.name),
                sensors => format!("Add {} sensors", sensors.len()),
            },
            Self::RemoveSensor { .. } => "Remove sensor".into(),
            Self::RemoveSensors { indices, .. } => {
                format!("Remove {} sensors", as_set(indices).len())
            }
            Self::Arrange { indices, arrangement, .. } => {
                arrangement.label(as_set(indices).len(), None)
            }
            Self::SetTip { body, .. } => format!("Move {body} tip"),
            Self::SetCrfPose(_) => "Move CRF".into(),
            Self::SetToolPose(_) => "Move tool".into(),
            Self::SetMotion(_) => "Change range of motion".into(),
            Self::SetRequirement(_) => "Change requirement".into(),
            Self::SetCrfMotion(_) => "Change range of motion of CRF".into(),
            Self::SetCrfRequirement(_) => "Change requirement of CRF".into(),
            Self::AddTarget(target) => format!("Add target {}", target.name),
            Self::SetTarget { target, .. } => format!("Move target {}", target.name),
            Self::RemoveTarget { .. } => "Remove target".into(),
            Self::SetOrientationWeight(_) => "Change orientation weight".into(),
            Self::SetEnvironment(_) => "Change environment".into(),
            Self::SetMesh { body, .. } => format!("Change {body}'s mesh"),
            Self::SetBody { body, content } => {
                format!("Use {} as the {body}", content.rigid.name)
            }
            Self::Anatomy(edit) => edit.label_for(&[]),
            Self::Slides(edit) => edit.label_for(&[]),
            Self::Procedure(edit) => edit.label(),
        }
    }

    /// What undo calls it, knowing what it changes.
    pub fn label_for(&self, design: &Design) -> String {
        match self {
            Self::SetSensor { body, index, sensor } => {
                change_of_sensor(design, *body, *index, sensor)
            }
            Self::SetSensors { body, sensors } => match &sensors[..] {
                [(index, sensor)] => change_of_sensor(design, *body, *index, sensor),
                _ => self.label(),
            },
            Self::RemoveSensor { body, index } => match sensor_at(design, *body, *index) {
                Some(sensor) => format!("Remove sensor {}", sensor.name),
                None => self.label(),
            },
            Self::RemoveSensors { body, indices } => match as_set(indices)[..] {
                [index] => Self::RemoveSensor { body: *body, index }.label_for(design),
                _ => self.label(),
            },
            Self::Arrange { body, indices, arrangement } => {
                let first = indices.first().and_then(|i| sensor_at(design, *body, *i));
                arrangement.label(as_set(indices).len(), first.map(|s| s.name.as_str()))
            }
            Self::Anatomy(edit) => edit.label_for(&design.anatomy),
            Self::Slides(edit) => edit.label_for(&design.slides),
            Self::SetTarget { index, target } => match target_at(design, *index) {
                Some(before) if before.name != target.name => {
                    format!("Rename target {}", before.name)
                }
                _ => self.label(),
            },
            Self::RemoveTarget { index } => match target_at(design, *index) {
                Some(target) => format!("Remove target {}", target.name),
                None => self.label(),
            },
            _ => self.label(),
        }
    }
}

fn change_of_sensor(design: &Design, body: BodyRole, index: usize, after: &Sensor) -> String {
    match sensor_at(design, body, index) {
        Some(before) if before.name != after.name => format!("Rename sensor {}", before.name),
        Some(before) if is_retyped(before, after) => format!("Change sensor {}", after.name),
        _ => format!("Move sensor {}", after.name),
    }
}

fn is_retyped(before: &Sensor, after: &Sensor) -> bool {
    before.coil != after.coil
        || before.orientation.degrees_of_freedom() != after.orientation.degrees_of_freedom()
}

fn sensor_at(design: &Design, body: BodyRole, index: usize) -> Option<&Sensor> {
    design.body(body)?.rigid.sensors.get(index)
}

fn target_at(design: &Design, index: usize) -> Option<&Target> {
    design.crf.as_ref()?.targets.get(index)
}
