//! Edits: the only ways in which a design changes, each checked before it is applied.

use super::anatomy::{AnatomyEdit, MAX_ANATOMY};
use super::arrange::{ArrangeError, Arrangement, as_set};
use super::check::{
    check_body, check_length, check_mesh, check_motion, check_not_empty, check_pose,
    check_position, check_requirement, check_sensors,
};
use super::content::{BodyRole, CrfPlacement, Design, DesignBody, Target};
use super::procedure::{DecisionError, MAX_FURTHER_ROOMS, ProcedureEdit};
use super::slides::{MAX_SLIDES, SlideEdit};
use super::view::ViewError;
use nalgebra::Point3;
use trackwright_geometry::limits::short;
use trackwright_geometry::mesh_reference::MeshReference;
use trackwright_geometry::pose::Pose;
use trackwright_procedure::Step;
use trackwright_simulation::body::Sensor;
use trackwright_simulation::motion::{Motion, MotionError};
use trackwright_simulation::requirement::Requirement;

/// One change of a design.
#[derive(Clone, Debug, PartialEq)]
pub enum Edit {
    SetName(String),
    SetBodyName {
        body: BodyRole,
        name: String,
    },
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
    /// Several sensors at once, each put in the place of the one at its index; names may change
    /// hands.
    SetSensors {
        body: BodyRole,
        sensors: Vec<(usize, Sensor)>,
    },
    /// At the end of the list, in this order.
    AddSensors {
        body: BodyRole,
        sensors: Vec<Sensor>,
    },
    /// Indices as they are before; a set.
    RemoveSensors {
        body: BodyRole,
        indices: Vec<usize>,
    },
    /// Copies, mirrors, … the sensors at these indices; see [`Arrangement::arranged`].
    Arrange {
        body: BodyRole,
        indices: Vec<usize>,
        arrangement: Arrangement,
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
    /// Of the CRF's own study.
    SetCrfMotion(Option<Motion>),
    /// Of the CRF's own study.
    SetCrfRequirement(Option<Requirement>),
    AddTarget(Target),
    SetTarget {
        index: usize,
        target: Target,
    },
    RemoveTarget {
        index: usize,
    },
    /// Millimetres.
    SetOrientationWeight(Option<f64>),
    /// A file relative to the design's.
    SetEnvironment(String),
    /// A file relative to the body's.
    SetMesh {
        body: BodyRole,
        mesh: Option<MeshReference>,
    },
    /// Another tool or CRF in the place of this one, with all that its file says, where it is.
    SetBody {
        body: BodyRole,
        content: Box<DesignBody>,
    },
    Anatomy(AnatomyEdit),
    Slides(SlideEdit),
    Procedure(ProcedureEdit),
}

/// Why an edit was not applied; the design is as it was.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum EditError {
    #[error("the design has no CRF")]
    NoCrf,
    #[error("the {body} has no sensor {index}, it has {count}")]
    NoSuchSensor { body: BodyRole, index: usize, count: usize },
    #[error("the CRF has no target {index}, it has {count}")]
    NoSuchTarget { index: usize, count: usize },
    #[error("the CRF already has a target named {name:?}, expected another name")]
    DuplicateTargetName { name: String },
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
    #[error("{what} is {}, expected {expected}", short(*value))]
    Number { what: &'static str, value: f64, expected: &'static str },
    #[error("the {what} has length {length}, expected 1")]
    NotUnit { what: &'static str, length: f64 },
    #[error(transparent)]
    Motion(#[from] MotionError),
    #[error("crf.{0}")]
    CrfMotion(MotionError),
    #[error(transparent)]
    Arrange(#[from] ArrangeError),
    #[error("the design has no anatomy at {index}, it has {count}")]
    NoSuchAnatomy { index: usize, count: usize },
    #[error("the design has {MAX_ANATOMY} meshes of anatomy, which is as many as there may be")]
    TooMuchAnatomy,
    #[error("the design already has anatomy named {name:?}, expected another name")]
    DuplicateAnatomyName { name: String },
    #[error("a part of the colour is {value}, expected a number from 0 to 1")]
    NoColor { value: f64 },
    #[error("the design has no slide at {index}, it has {count}")]
    NoSuchSlide { index: usize, count: usize },
    #[error("the design has {MAX_SLIDES} slides, which is as many as there may be")]
    TooManySlides,
    #[error("slide: {0}")]
    SlideView(#[from] ViewError),
    #[error("the design is judged in {file} already")]
    RoomTwice { file: String },
    #[error("the design is not judged in {file:?}, expected one of its further rooms")]
    NoSuchRoom { file: String },
    #[error("the design has {MAX_FURTHER_ROOMS} further rooms, which is as many as there may be")]
    TooManyRooms,
    #[error("nothing is decided on the {step}")]
    NotDecided { step: Step },
    #[error("decision: {0}")]
    Decision(#[from] DecisionError),
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
            Self::SetEnvironment(environment) => {
                check_not_empty("environment's file", &environment)?;
                design.environment = environment;
            }
            Self::SetMesh { body, mesh } => {
                let body = body_of(design, body)?;
                if let Some(mesh) = &mesh {
                    check_mesh(mesh)?;
                }
                body.mesh = mesh;
            }
            Self::SetBody { body, content } => {
                let old = body_of(design, body)?;
                check_body(body, &content)?;
                *old = *content;
            }
            Self::Anatomy(edit) => edit.apply_to(design)?,
            Self::Slides(edit) => edit.apply_to(design)?,
            Self::Procedure(edit) => edit.apply_to(design)?,
        }
        Ok(())
    }
}

fn body_of(design: &mut Design, role: BodyRole) -> Result<&mut DesignBody, EditError> {
    design.body_mut(role).ok_or(EditError::NoCrf)
}

fn crf_of(design: &mut Design) -> Result<&mut CrfPlacement, EditError> {
    design.crf.as_mut().ok_or(EditError::NoCrf)
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
