//! How the Study workspace shows trials, and what it can be asked for.

use crate::document::trials::ModeKind;
use bevy::prelude::*;

/// Trials a second that can be chosen for playing.
pub const PLAY_RATES: [f64; 4] = [5.0, 25.0, 100.0, 500.0];

/// How the panel writes a rotation.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum RotationForm {
    /// Turns about x, y and z, in this order.
    #[default]
    Turns,
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

/// Asks for something of the Study workspace.
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

/// How trials are shown.
#[derive(Resource, Clone, Debug)]
pub struct StudyState {
    pub rate_per_s: f64,
    pub side: Side,
    pub rotation: RotationForm,
    /// Along which axis the error is charted.
    pub axis: &'static str,
}

impl Default for StudyState {
    fn default() -> Self {
        Self {
            rate_per_s: PLAY_RATES[1],
            side: Side::default(),
            rotation: RotationForm::default(),
            axis: "x",
        }
    }
}
