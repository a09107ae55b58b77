//! What a person looks at of a study: its mode, the trial shown, whether trials play. All of it
//! belongs to the editor and none to the design.

use bevy::prelude::*;
use std::sync::Arc;
use trackwright_simulation::{InputTrial, Mode, Scenario};

/// Trials a second that can be chosen for playing.
pub const PLAY_RATES: [f64; 4] = [5.0, 25.0, 100.0, 500.0];

/// Which of the three modes, without what it takes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum ModeKind {
    #[default]
    Single,
    Motion,
    Input,
}

impl ModeKind {
    pub const ALL: [Self; 3] = [Self::Single, Self::Motion, Self::Input];

    /// What a person calls it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Single => "single pose",
            Self::Motion => "range of motion",
            Self::Input => "input data",
        }
    }
}

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

/// Input data that was read.
#[derive(Clone, Debug)]
pub struct InputData {
    /// The file's name.
    pub name: String,
    pub trials: Arc<[InputTrial]>,
}

/// What is looked at.
#[derive(Resource, Clone, Debug)]
pub struct StudyDesk {
    chosen: Option<ModeKind>,
    input: Option<InputData>,
    /// The trial that the tool is shown in; `None` is the design's own pose.
    pub(crate) trial: Option<usize>,
    /// The trial that plays, between two of them.
    pub(crate) playing: Option<f64>,
    pub rate_per_s: f64,
    pub side: Side,
    pub rotation: RotationForm,
    /// Along which axis the error is charted.
    pub axis: &'static str,
    serial: u64,
}

impl Default for StudyDesk {
    fn default() -> Self {
        Self {
            chosen: None,
            input: None,
            trial: None,
            playing: None,
            rate_per_s: PLAY_RATES[1],
            side: Side::default(),
            rotation: RotationForm::default(),
            axis: "x",
            serial: 0,
        }
    }
}

impl StudyDesk {
    /// The mode that figures are of: the chosen one where it can be, else the range of motion
    /// where the design has one.
    pub fn kind(&self, has_motion: bool) -> ModeKind {
        match self.chosen {
            Some(ModeKind::Input) if self.input.is_some() => ModeKind::Input,
            Some(ModeKind::Single) => ModeKind::Single,
            _ if has_motion => ModeKind::Motion,
            _ => ModeKind::Single,
        }
    }

    /// The same with its trials.
    pub fn mode(&self, scenario: &Scenario) -> Mode {
        match (self.kind(scenario.motion.is_some()), &self.input) {
            (ModeKind::Single, _) | (ModeKind::Input, None) => Mode::Single,
            (ModeKind::Motion, _) => Mode::Motion,
            (ModeKind::Input, Some(input)) => Mode::Input(Arc::clone(&input.trials)),
        }
    }

    pub fn input(&self) -> Option<&InputData> {
        self.input.as_ref()
    }

    /// The trial that is shown in the Study workspace; `None` is the design's own pose.
    pub fn trial(&self) -> Option<usize> {
        self.trial
    }

    pub fn is_playing(&self) -> bool {
        self.playing.is_some()
    }

    /// Grows whenever the trials of one and the same design become others.
    pub fn serial(&self) -> u64 {
        self.serial
    }

    pub(crate) fn choose(&mut self, kind: ModeKind) {
        self.chosen = Some(kind);
        self.trials_are_others();
    }

    /// Input data is looked at as soon as it is there.
    pub fn take_input(&mut self, name: String, trials: Arc<[InputTrial]>) {
        self.input = Some(InputData { name, trials });
        self.choose(ModeKind::Input);
    }

    /// Another design was opened: its trials are others, and input data may not be about it.
    pub(crate) fn forget_trials(&mut self) {
        self.chosen = None;
        self.input = None;
        self.trials_are_others();
    }

    pub(crate) fn show(&mut self, trial: Option<usize>) {
        self.trial = trial;
        self.playing = None;
    }

    fn trials_are_others(&mut self) {
        self.show(None);
        self.serial += 1;
    }
}
