//! Why an edit is refused, and how many of each there may be.

use super::arrange::ArrangeError;
use super::procedure::DecisionError;
use super::things::BodyRole;
use super::view::ViewError;
use trackwright_geometry::limits::short;
use trackwright_metal::setup::SetupError;
use trackwright_procedure::Step;
use trackwright_simulation::motion::MotionError;
use trackwright_simulation::mounting::MountingError;

/// More than any tracker has channels for, a hundred times; files hold no more either, as the time and
/// memory of results grow with them.
pub const MAX_SENSORS: usize = 1_000;

// A file may hold any number of these; edits stop here.

/// More than a scene has room for.
pub const MAX_ANATOMY: usize = 100;

/// More than anybody presents.
pub const MAX_SLIDES: usize = 100;

/// More rooms than anybody measures for one design.
pub const MAX_FURTHER_ROOMS: usize = 32;

/// Why an edit was not applied; the design is as it was.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum EditError {
    #[error("the design has no CRF")]
    NoCrf,
    #[error("the design has a CRF already")]
    HasCrf,
    #[error("the {body} has no sensor {index}, it has {count}")]
    NoSuchSensor { body: BodyRole, index: usize, count: usize },
    #[error("the CRF has no target {index}, it has {count}")]
    NoSuchTarget { index: usize, count: usize },
    #[error("the CRF already has a target named {name:?}, expected another name")]
    DuplicateTargetName { name: String },
    #[error("the {body} would have {count} sensors, expected at most {MAX_SENSORS}")]
    TooManySensors { body: BodyRole, count: usize },
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
    Mounting(#[from] MountingError),
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
    #[error("the room has no metal")]
    NoMetal,
    #[error("the room has no metal object {index}, it has {count}")]
    NoSuchMetal { index: usize, count: usize },
    #[error(transparent)]
    Metal(#[from] SetupError),
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
