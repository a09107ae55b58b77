//! What a study is made of: plain data, every file read and every default decided.

use super::metric::Metric;
use super::motion::{Motion, MotionError, MotionGrid};
use super::requirement::Requirement;
use crate::body::RigidBody;
use std::sync::Arc;
use trackwright_field::{Environment, OutsidePolicy};
use trackwright_geometry::pose::Pose;

/// A tool, perhaps a CRF, and the room they are tracked in.
#[derive(Clone, Debug)]
pub struct Scenario {
    pub environment: Arc<Environment>,
    pub tool: RigidBody,
    /// Without a CRF the reference is the tracker frame.
    pub crf: Option<ScenarioCrf>,
    pub crf_from_tool: Pose,
    pub motion: Option<Motion>,
    pub orientation_weight_mm: f64,
    pub requirement: Option<Requirement>,
    pub outside: OutsidePolicy,
}

impl Scenario {
    /// Whether a mode's study is judged against a bound on a figure: one pose of a range of motion has no
    /// RMS and no percentile to be held against one.
    pub fn judges(&self, mode: &Mode, metric: Metric) -> bool {
        let is_one_pose = matches!(mode, Mode::Single) && self.motion.is_some();
        !is_one_pose || metric.is_extreme()
    }

    /// The poses of the range of motion; nothing where there is none.
    ///
    /// # Errors
    /// See [`Motion::counts`].
    pub fn motion_grid(&self) -> Result<Option<MotionGrid>, MotionError> {
        let tip_in_tool = self.tool.judged_tip_in_body();
        self.motion.map(|motion| motion.grid(&self.crf_from_tool, &tip_in_tool)).transpose()
    }

    /// Where the design has its CRF; the tracker frame itself without one.
    pub fn tracker_from_crf(&self) -> Pose {
        self.crf.as_ref().map_or_else(Pose::identity, |crf| crf.tracker_from_crf)
    }
}

/// A reference body and where it is.
#[derive(Clone, Debug)]
pub struct ScenarioCrf {
    pub body: RigidBody,
    pub tracker_from_crf: Pose,
}

/// The CRF alone against the tracker, judged at one place.
#[derive(Clone, Debug)]
pub struct CrfScenario {
    /// The target's name; `None` at the CRF's tip, or its origin.
    pub target: Option<String>,
    /// With the CRF in the tool's place: its own pose, range of motion and requirement.
    pub scenario: Scenario,
}

/// The paper's three modes.
#[derive(Clone, Debug)]
pub enum Mode {
    /// The design's own pose.
    Single,
    /// The design's range of motion.
    Motion,
    /// Given poses.
    Input(Arc<[InputTrial]>),
}

/// One row of input data.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct InputTrial {
    /// The design's pose where absent; ignored without a CRF.
    pub tracker_from_crf: Option<Pose>,
    pub crf_from_tool: Pose,
}

impl InputTrial {
    /// A pose of the tool with the CRF where the design has it.
    pub fn at(crf_from_tool: Pose) -> Self {
        Self { tracker_from_crf: None, crf_from_tool }
    }
}
