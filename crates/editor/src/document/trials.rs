//! Which trials a study has and which of them is wanted: what the Study workspace chooses and the
//! solver, the scene and the panels follow. All of it belongs to the editor and none to the design.

use bevy::prelude::*;
use std::sync::Arc;
use trackwright_project::{MeasuredError, RecordedPoses};
use trackwright_simulation::{InputTrial, Mode, Scenario};

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

/// Input data that was read.
#[derive(Clone, Debug)]
pub struct InputData {
    /// The file's name.
    pub name: String,
    pub trials: Arc<[InputTrial]>,
    /// What was measured at each, where they are a recording of the built tool.
    pub measured: Option<Arc<[MeasuredError]>>,
}

/// The mode of the study, and the trial that is wanted of it.
#[derive(Resource, Clone, Debug, Default)]
pub struct TrialChoice {
    chosen: Option<ModeKind>,
    input: Option<InputData>,
    /// The trial that the tool is shown in; `None` is the design's own pose.
    pub(crate) trial: Option<usize>,
    /// The trial that plays, between two of them.
    pub(crate) playing: Option<f64>,
    serial: u64,
}

impl TrialChoice {
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

    /// The trial that is wanted where trials are shown; `None` is the design's own pose.
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

    /// Input data is studied as soon as it is there.
    pub fn take_input(&mut self, name: String, trials: Arc<[InputTrial]>) {
        self.input = Some(InputData { name, trials, measured: None });
        self.choose(ModeKind::Input);
    }

    /// A recording of the built tool is studied pose by pose.
    pub fn take_recording(&mut self, name: String, poses: RecordedPoses) {
        let RecordedPoses { trials, measured } = poses;
        let measured = Some(measured.into());
        self.input = Some(InputData { name, trials: trials.into(), measured });
        self.choose(ModeKind::Input);
    }

    /// What was measured at each trial, where the studied trials are a recording.
    pub fn measured(&self, has_motion: bool) -> Option<&[MeasuredError]> {
        let input = self.input.as_ref().filter(|_| self.kind(has_motion) == ModeKind::Input)?;
        input.measured.as_deref()
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
