//! How the Study workspace shows trials, and the requests to it.

use crate::document::trials::ModeKind;
use crate::shell::keys::Keys;
use crate::shell::window::Workspace;
use bevy::prelude::*;

pub const WORKSPACE: Workspace = Workspace {
    name: "Study",
    order: 2,
    command: "Study workspace",
    about: "Trial by trial: the motion, the plots, the log",
    keys: &[Keys::control("3")],
    has_gizmo: false,
    shows_trials: true,
    charts_trials: true,
    drop_verb: Some("Read poses from"),
    ..Workspace::NONE
};

/// Trials a second that can be chosen for playing.
pub const PLAY_RATES: [f64; 4] = [5.0, 25.0, 100.0, 500.0];

/// How the panel writes a rotation.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum RotationForm {
    /// Rotations about x, y and z, in this order.
    #[default]
    EulerAngles,
    /// Axis times angle.
    Rodrigues,
}

/// What the right panel of the workspace shows above the result.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Side {
    #[default]
    Trials,
    Inspector,
}

/// A request to the Study workspace.
#[derive(Message, Clone, Debug, PartialEq)]
pub enum StudyRequest {
    Choose(ModeKind),
    /// Puts the tool where it is in a trial; `None` is the design's own pose.
    Show(Option<usize>),
    /// So many trials onward, or back.
    Step(isize),
    ShowWorst,
    /// Plays on, or pauses.
    TogglePlay,
    SetRate(f64),
    ShowSide(Side),
    ShowRotation(RotationForm),
    ShowAxis(&'static str),
    CancelLog,
}

pub fn is_study_shown(workspace: Option<Res<Workspace>>) -> bool {
    workspace.is_some_and(|workspace| *workspace == WORKSPACE)
}

/// How trials are shown.
#[derive(Resource, Clone, Debug)]
pub struct StudyState {
    pub rate_per_s: f64,
    pub side: Side,
    pub rotation: RotationForm,
    /// Along which axis the error is charted.
    pub axis: &'static str,
    /// Whether the worst trial is shown as soon as the study is whole.
    pub awaits_worst: bool,
}

impl Default for StudyState {
    fn default() -> Self {
        Self {
            rate_per_s: PLAY_RATES[1],
            side: Side::default(),
            rotation: RotationForm::default(),
            axis: "x",
            awaits_worst: false,
        }
    }
}
