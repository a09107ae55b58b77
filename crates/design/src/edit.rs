//! Edits: the only ways in which a design changes, each checked before it is applied.

use super::anatomy::AnatomyFrame;
use super::arrange::{Arrangement, as_set};
use super::check::{
    check_body, check_length, check_mesh, check_motion, check_not_empty, check_pose,
    check_position, check_requirement, check_sensors,
};
use super::content::{CrfPlacement, Design, DesignBody, Target};
use super::edit_error::EditError;
use super::list_edits::{AnatomyEdit, ProcedureEdit, SlideEdit};
use super::metal_edits::MetalEdit;
use super::things::BodyRole;
use nalgebra::Point3;
use std::sync::Arc;
use trackwright_geometry::mesh_reference::MeshReference;
use trackwright_geometry::pose::Pose;
use trackwright_metal::setup::RoomMetal;
use trackwright_simulation::body::Sensor;
use trackwright_simulation::motion::Motion;
use trackwright_simulation::mounting::Mounting;
use trackwright_simulation::requirement::Requirement;

/// One change of a design.
#[derive(Clone, Debug, PartialEq)]
pub enum Edit {
    /// The design's own.
    SetName(String),
    /// The tool's or the CRF's.
    SetBodyName { body: BodyRole, name: String },
    /// In the place of the one at `index`.
    SetSensor { body: BodyRole, index: usize, sensor: Sensor },
    /// At the end of the list.
    AddSensor { body: BodyRole, sensor: Sensor },
    /// Those behind it move up.
    RemoveSensor { body: BodyRole, index: usize },
    /// Several sensors at once, each put in the place of the one at its index; names may change
    /// hands.
    SetSensors { body: BodyRole, sensors: Vec<(usize, Sensor)> },
    /// At the end of the list, in this order.
    AddSensors { body: BodyRole, sensors: Vec<Sensor> },
    /// Indices as they are before; a set.
    RemoveSensors { body: BodyRole, indices: Vec<usize> },
    /// Copies, mirrors, … the sensors at these indices; see [`Arrangement::arranged`].
    Arrange { body: BodyRole, indices: Vec<usize>, arrangement: Arrangement },
    /// Millimetres; `None` for a body without one.
    SetTip { body: BodyRole, tip_in_body: Option<Point3<f64>> },
    /// `tracker_from_crf`.
    SetCrfPose(Pose),
    /// `crf_from_tool`.
    SetToolPose(Pose),
    /// Of the tool's study.
    SetMotion(Option<Motion>),
    /// Of the tool's study.
    SetRequirement(Option<Requirement>),
    /// Of the CRF's own study.
    SetCrfMotion(Option<Motion>),
    /// Of the CRF's own study.
    SetCrfRequirement(Option<Requirement>),
    /// Of the CRF, at the end of the list.
    AddTarget(Target),
    /// In the place of the one at `index`.
    SetTarget { index: usize, target: Target },
    /// Those behind it move up.
    RemoveTarget { index: usize },
    /// Millimetres.
    SetOrientationWeight(Option<f64>),
    /// A file relative to the design's, and the metal in the room that it holds.
    SetEnvironment { file: String, metal: Option<Arc<RoomMetal>> },
    /// A file relative to the body's.
    SetMesh { body: BodyRole, mesh: Option<MeshReference> },
    /// Where sensors of the body may be put.
    SetMounting { body: BodyRole, mounting: Box<Mounting> },
    /// Another tool or CRF in the place of this one, with all that its file holds, where it is.
    SetBody { body: BodyRole, content: Box<DesignBody> },
    /// A CRF for a design without one. Nothing moves: tool and anatomy are where they were in the
    /// tracker's frame.
    AddCrf(Box<CrfPlacement>),
    /// What is shown beside the bodies.
    Anatomy(AnatomyEdit),
    /// What disturbs the room.
    Metal(MetalEdit),
    /// What is presented.
    Slides(SlideEdit),
    /// Further rooms and decisions.
    Procedure(ProcedureEdit),
}

impl Edit {
    /// Changes the design, or leaves it as it is.
    ///
    /// # Errors
    /// See [`EditError`]; the design is then unchanged.
    pub(super) fn apply_to(self, design: &mut Design) -> Result<(), EditError> {
        match self {
            Self::SetName(name) => {
                check_not_empty("design's name", &name)?;
                design.name = name;
            }
            Self::SetBodyName { body, name } => {
                check_not_empty("body's name", &name)?;
                body_of(design, body)?.rigid.name = name;
            }
            Self::SetSensor { body, index, sensor } => {
                set_sensors(design, body, vec![(index, sensor)])?;
            }
            Self::SetSensors { body, sensors } => set_sensors(design, body, sensors)?,
            Self::AddSensor { body, sensor } => add_sensors(design, body, vec![sensor])?,
            Self::AddSensors { body, sensors } => add_sensors(design, body, sensors)?,
            Self::RemoveSensor { body, index } => remove_sensors(design, body, &[index])?,
            Self::RemoveSensors { body, indices } => remove_sensors(design, body, &indices)?,
            Self::Arrange { body, indices, arrangement } => {
                let sensors = &mut body_of(design, body)?.rigid.sensors;
                let arranged = arrangement.arranged(sensors, &indices)?;
                check_sensors(body, &arranged, 0..arranged.len())?;
                *sensors = arranged;
            }
            Self::SetTip { body, tip_in_body } => {
                let rigid = &mut body_of(design, body)?.rigid;
                if let Some(tip) = &tip_in_body {
                    check_position("the tip", tip.iter())?;
                }
                rigid.tip_in_body = tip_in_body;
            }
            Self::SetCrfPose(pose) => {
                check_pose(&pose)?;
                crf_of(design)?.tracker_from_crf = pose;
            }
            Self::SetToolPose(pose) => {
                check_pose(&pose)?;
                design.tool.crf_from_tool = pose;
            }
            Self::SetMotion(motion) => {
                check_motion(motion.as_ref())?;
                design.motion = motion;
            }
            Self::SetRequirement(requirement) => {
                check_requirement(requirement.as_ref())?;
                design.requirement = requirement;
            }
            Self::SetCrfMotion(motion) => {
                check_motion(motion.as_ref()).map_err(EditError::CrfMotion)?;
                crf_of(design)?.motion = motion;
            }
            Self::SetCrfRequirement(requirement) => {
                check_requirement(requirement.as_ref())?;
                crf_of(design)?.requirement = requirement;
            }
            Self::AddTarget(target) => {
                let targets = &mut crf_of(design)?.targets;
                check_target_name(&target.name, targets)?;
                check_position("the target", target.position_in_crf.iter())?;
                targets.push(target);
            }
            Self::SetTarget { index, target } => {
                let targets = &mut crf_of(design)?.targets;
                check_target_index(index, targets)?;
                // A file may hold names twice; such a target can still be moved.
                if targets[index].name != target.name {
                    check_target_name(&target.name, targets)?;
                }
                check_position("the target", target.position_in_crf.iter())?;
                targets[index] = target;
            }
            Self::RemoveTarget { index } => {
                let targets = &mut crf_of(design)?.targets;
                check_target_index(index, targets)?;
                targets.remove(index);
            }
            Self::SetOrientationWeight(weight_mm) => {
                if let Some(weight_mm) = weight_mm {
                    check_length("the orientation weight", weight_mm)?;
                }
                design.orientation_weight_mm = weight_mm;
            }
            Self::SetEnvironment { file, metal } => {
                check_not_empty("environment's file", &file)?;
                metal.as_ref().map_or(Ok(()), |metal| metal.check())?;
                design.environment = file;
                design.room_metal = metal;
            }
            Self::SetMesh { body, mesh } => {
                let body = body_of(design, body)?;
                if let Some(mesh) = &mesh {
                    check_mesh(mesh)?;
                }
                body.mesh = mesh;
            }
            Self::SetMounting { body, mounting } => {
                let body = body_of(design, body)?;
                mounting.check()?;
                body.mounting = *mounting;
            }
            Self::SetBody { body, content } => {
                let old = body_of(design, body)?;
                check_body(body, &content)?;
                *old = *content;
            }
            Self::AddCrf(crf) => add_crf(design, *crf)?,
            Self::Anatomy(edit) => edit.apply_to(&mut design.anatomy)?,
            Self::Metal(edit) => edit.apply_to(design)?,
            Self::Slides(edit) => edit.apply_to(&mut design.slides)?,
            Self::Procedure(edit) => edit.apply_to(design)?,
        }
        Ok(())
    }

    /// What undo calls it, knowing what it changes.
    pub fn label_for(&self, design: &Design) -> String {
        let named = |what: &str, name: Option<&String>| match name {
            Some(name) => format!("{what} {name}"),
            None => what.to_owned(),
        };
        match self {
            Self::SetName(_) => "Rename design".into(),
            Self::SetBodyName { body, .. } => format!("Rename {body}"),
            Self::SetSensor { body, index, sensor } => {
                change_of_sensor(design, *body, *index, sensor)
            }
            Self::SetSensors { body, sensors } => match &sensors[..] {
                [(index, sensor)] => change_of_sensor(design, *body, *index, sensor),
                sensors => {
                    let before = |index: usize| sensor_at(design, *body, index);
                    let is_retyped = sensors.iter().any(|(index, after)| {
                        before(*index).is_some_and(|before| is_retyped(before, after))
                    });
                    let verb = if is_retyped { "Change" } else { "Move" };
                    format!("{verb} {} sensors", sensors.len())
                }
            },
            Self::AddSensor { sensor, .. } => format!("Add sensor {}", sensor.name),
            Self::AddSensors { sensors, .. } => match &sensors[..] {
                [sensor] => format!("Add sensor {}", sensor.name),
                sensors => format!("Add {} sensors", sensors.len()),
            },
            Self::RemoveSensor { body, index } => {
                named("Remove sensor", sensor_at(design, *body, *index).map(|s| &s.name))
            }
            Self::RemoveSensors { body, indices } => match as_set(indices)[..] {
                [index] => Self::RemoveSensor { body: *body, index }.label_for(design),
                ref indices => format!("Remove {} sensors", indices.len()),
            },
            Self::Arrange { body, indices, arrangement } => {
                let first = indices.first().and_then(|i| sensor_at(design, *body, *i));
                arrangement.label(as_set(indices).len(), first.map(|s| s.name.as_str()))
            }
            Self::SetTip { body, .. } => format!("Move {body} tip"),
            Self::SetCrfPose(_) => "Move CRF".into(),
            Self::SetToolPose(_) => "Move tool".into(),
            Self::SetMotion(_) => "Change range of motion".into(),
            Self::SetRequirement(_) => "Change requirement".into(),
            Self::SetCrfMotion(_) => "Change range of motion of CRF".into(),
            Self::SetCrfRequirement(_) => "Change requirement of CRF".into(),
            Self::AddTarget(target) => format!("Add target {}", target.name),
            Self::SetTarget { index, target } => match target_at(design, *index) {
                Some(before) if before.name != target.name => {
                    format!("Rename target {}", before.name)
                }
                _ => format!("Move target {}", target.name),
            },
            Self::RemoveTarget { index } => {
                named("Remove target", target_at(design, *index).map(|t| &t.name))
            }
            Self::SetOrientationWeight(_) => "Change orientation weight".into(),
            Self::SetEnvironment { .. } => "Change environment".into(),
            Self::SetMesh { body, .. } => format!("Change {body}'s mesh"),
            Self::SetMounting { body, .. } => format!("Change {body}'s mounting regions"),
            Self::SetBody { body, content } => {
                format!("Use {} as the {body}", content.rigid.name)
            }
            Self::AddCrf(crf) => format!("Add {} as the CRF", crf.body.rigid.name),
            Self::Anatomy(edit) => edit.label_for(&design.anatomy),
            Self::Metal(edit) => edit.label_for(design.room_metal.as_deref()),
            Self::Slides(edit) => edit.label_for(&design.slides),
            Self::Procedure(edit) => edit.label(),
        }
    }
}

fn body_of(design: &mut Design, role: BodyRole) -> Result<&mut DesignBody, EditError> {
    design.body_mut(role).ok_or(EditError::NoCrf)
}

fn crf_of(design: &mut Design) -> Result<&mut CrfPlacement, EditError> {
    design.crf.as_mut().ok_or(EditError::NoCrf)
}

fn add_crf(design: &mut Design, crf: CrfPlacement) -> Result<(), EditError> {
    if design.crf.is_some() {
        return Err(EditError::HasCrf);
    }
    check_body(BodyRole::Crf, &crf.body)?;
    check_pose(&crf.tracker_from_crf)?;
    check_motion(crf.motion.as_ref()).map_err(EditError::CrfMotion)?;
    check_requirement(crf.requirement.as_ref())?;
    let crf_from_tracker = crf.tracker_from_crf.inverse();
    design.tool.crf_from_tool = crf_from_tracker * design.tool.crf_from_tool;
    // Without a CRF, what is on it is in the tracker's frame.
    for anatomy in design.anatomy.iter_mut().filter(|own| own.on == AnatomyFrame::Crf) {
        anatomy.frame_from_mesh = crf_from_tracker * anatomy.frame_from_mesh;
    }
    design.crf = Some(crf);
    Ok(())
}

fn set_sensors(
    design: &mut Design,
    body: BodyRole,
    sensors: Vec<(usize, Sensor)>,
) -> Result<(), EditError> {
    let old = &mut body_of(design, body)?.rigid.sensors;
    let mut new = old.clone();
    let mut changed = Vec::with_capacity(sensors.len());
    for (index, sensor) in sensors {
        check_index(body, index, new.len())?;
        new[index] = sensor;
        changed.push(index);
    }
    check_sensors(body, &new, changed.into_iter())?;
    *old = new;
    Ok(())
}

fn add_sensors(design: &mut Design, body: BodyRole, sensors: Vec<Sensor>) -> Result<(), EditError> {
    let old = &mut body_of(design, body)?.rigid.sensors;
    let mut new = old.clone();
    new.extend(sensors);
    check_sensors(body, &new, old.len()..new.len())?;
    *old = new;
    Ok(())
}

fn remove_sensors(design: &mut Design, body: BodyRole, indices: &[usize]) -> Result<(), EditError> {
    let sensors = &mut body_of(design, body)?.rigid.sensors;
    let indices = as_set(indices);
    if let Some(&last) = indices.last() {
        check_index(body, last, sensors.len())?;
    }
    if indices.len() == sensors.len() {
        return Err(EditError::LastSensor);
    }
    for index in indices.into_iter().rev() {
        sensors.remove(index);
    }
    Ok(())
}

fn check_index(body: BodyRole, index: usize, count: usize) -> Result<(), EditError> {
    if index < count { Ok(()) } else { Err(EditError::NoSuchSensor { body, index, count }) }
}

fn check_target_index(index: usize, targets: &[Target]) -> Result<(), EditError> {
    let count = targets.len();
    if index < count { Ok(()) } else { Err(EditError::NoSuchTarget { index, count }) }
}

fn check_target_name(name: &str, others: &[Target]) -> Result<(), EditError> {
    check_not_empty("target's name", name)?;
    if others.iter().any(|other| other.name == name) {
        return Err(EditError::DuplicateTargetName { name: name.to_owned() });
    }
    Ok(())
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
