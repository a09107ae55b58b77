//! What a step of the design procedure is decided on: its figures as they were on that day.

use trackwright_calibration::agreement::BuiltRecording;
use trackwright_simulation::requirement::Requirement;
use trackwright_simulation::{Metric, MetricMap, Study, Verdict};

/// The steps at which somebody decides (Fischer & Taylor 2005, section 4.1: 2 and 3, 4 and 5, 6).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Step {
    /// The CRF alone against the tracker.
    Crf,
    /// The tool against that CRF; without one, against the tracker.
    Tool,
    /// What was built, measured, against what was predicted for the same poses.
    Built,
}

/// What a step is decided on.
#[expect(clippy::large_enum_variant, reason = "there is one a step of a design")]
#[derive(Clone, Debug, PartialEq)]
pub enum DecisionBasis {
    /// Of [`Step::Crf`] and [`Step::Tool`].
    Studies(DecidedStudies),
    /// Of [`Step::Built`].
    Recording(Box<DecidedRecording>),
}

/// Studies in the chosen rooms.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct DecidedStudies {
    /// The bounds that the figures were held against.
    pub requirement: Option<Requirement>,
    /// One a room, of a CRF one a room and target.
    pub rows: Vec<DecidedRow>,
}

/// A study in one room.
#[derive(Clone, Debug, PartialEq)]
pub struct DecidedRow {
    pub room: RoomName,
    /// Where the CRF is judged; `None` at its tip or origin, and of a tool.
    pub target: Option<String>,
    /// Or why there were none.
    pub figures: Result<DecidedFigures, String>,
}

/// A room as people and files call it.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct RoomName {
    pub name: String,
    /// As written in the design, relative to it.
    pub file: String,
}

/// The figures of one study that a decision keeps, and what they rest on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DecidedFigures {
    pub trials: usize,
    /// Trials with a sensor where the room has no field.
    pub without_field: usize,
    pub values: MetricMap,
    /// Whether the values are those that were to be expected; older decisions kept those of the room's
    /// own field.
    pub are_expected: bool,
    /// `None` without bounds.
    pub verdict: Option<Verdict>,
}

/// What a recording of the built tool came to.
#[derive(Clone, Debug, PartialEq)]
pub struct DecidedRecording {
    /// The room that the errors were predicted in.
    pub room: RoomName,
    pub recording: BuiltRecording,
    /// Poses that were recorded, and those of them that were compared.
    pub poses: usize,
    pub used: usize,
    pub measured_rms_mm: f64,
    pub predicted_rms_mm: f64,
    /// Of measured minus predicted.
    pub residual_rms_mm: f64,
    /// Part of the squared error that the prediction explains.
    pub explained: Option<f64>,
    /// What the prediction has to be multiplied by to fit best.
    pub slope: Option<f64>,
    pub statement: String,
}

impl Step {
    pub const ALL: [Self; 3] = [Self::Crf, Self::Tool, Self::Built];

    /// Its number where the steps are listed, from 1.
    pub fn number(self) -> usize {
        match self {
            Self::Crf => 1,
            Self::Tool => 2,
            Self::Built => 3,
        }
    }

    /// What files and the command line call it.
    pub fn key(self) -> &'static str {
        match self {
            Self::Crf => "crf",
            Self::Tool => "tool",
            Self::Built => "built",
        }
    }

    /// What a person calls it within a sentence.
    pub fn name(self) -> &'static str {
        match self {
            Self::Crf => "CRF alone",
            Self::Tool => "tool",
            Self::Built => "built tool",
        }
    }
}

impl std::fmt::Display for Step {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.name())
    }
}

impl DecisionBasis {
    /// Every file that they name.
    pub fn references_mut(&mut self) -> impl Iterator<Item = &mut String> {
        let (rows, recording) = match self {
            Self::Studies(studies) => (Some(&mut studies.rows), None),
            Self::Recording(recording) => (None, Some(recording)),
        };
        let of_rows = rows.into_iter().flatten().map(|row| &mut row.room.file);
        let of_recording = recording.into_iter().flat_map(|decided| {
            let files = [&mut decided.room.file];
            files.into_iter().chain(decided.recording.references_mut())
        });
        of_rows.chain(of_recording)
    }
}

impl DecidedFigures {
    /// Those of a study.
    pub fn of(study: &Study) -> Self {
        let value = |metric| Some((metric, study.figures.get(metric)?.value));
        Self {
            trials: study.room_field.trials,
            without_field: study.room_field.without_field,
            values: Metric::decided().filter_map(value).collect(),
            are_expected: true,
            verdict: study.figures.requirement.as_ref().map(|requirement| requirement.verdict),
        }
    }

    /// Those of a study of the kind that these are.
    pub(super) fn of_the_same_kind(&self, study: &Study) -> Self {
        let of_study = Self::of(study);
        let own = |metric| (metric, study.room_field.value(metric));
        match self.are_expected {
            true => of_study,
            false => Self { values: Metric::decided().map(own).collect(), ..of_study },
        }
    }
}
