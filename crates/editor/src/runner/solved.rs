//! What the solver computes of a design, and what is wanted of it.

use crate::document::trials::ModeKind;
use trackwright_simulation::uncertainty::{TipUncertainty, UncertaintyError, first_order};
use trackwright_simulation::{
    CancelToken, ChartedProfile, InputTrial, Mode, PoseDetail, Quantity, Scenario, SliceOutcome,
    SlicePlan, Study, StudyError, TrialSource, sample_slice, simulate_pose, slice_support, study,
    study_profiled, trial_sources,
};

/// What is wanted of a slice.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SliceWish {
    pub plan: SlicePlan,
    pub quantity: Quantity,
    /// Whether it keeps model validity.
    pub support: bool,
}

/// What is wanted of a pose beside its trial.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct PoseWish {
    /// How far jitter scatters the tip.
    pub scatter: bool,
    /// What each sensor contributes to the tip error.
    pub sources: bool,
    /// The trial whose pose the scenario has; `None` for the design's own.
    pub trial: Option<usize>,
    /// Distinguishes trials of one number where their poses are others.
    pub serial: u64,
}

/// What is wanted of a study.
#[derive(Clone, Debug)]
pub struct StudyWish {
    pub mode: Mode,
    pub of: StudyOf,
    /// Whether its trials are kept one by one.
    pub profile: bool,
}

/// What a study's figures are of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StudyOf {
    /// A preview visits given poses, and stands for the range of motion.
    pub kind: ModeKind,
    pub extent: Extent,
}

/// How much of a range of motion a study visits.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Extent {
    Whole,
    /// A preview of so many poses, while something is dragged.
    PreviewOf(usize),
}

/// Where jitter puts the tip, or why that is not known.
pub type Scatter = Result<TipUncertainty, UncertaintyError>;

/// A pose, and what is wanted beside it.
pub struct SolvedPose {
    pub detail: PoseDetail,
    /// `None` where it is not wanted.
    pub scatter: Option<Scatter>,
    /// Of each sensor to the tip error; empty where they are not wanted.
    pub sources: Vec<TrialSource>,
}

/// A result by kind. Cancelled work reports that, in order that it can be counted.
pub enum Solved {
    Pose(Box<SolvedPose>, PoseWish),
    Study(Result<(Box<Study>, Option<Box<ChartedProfile>>), StudyError>, StudyOf),
    /// `None` where the room has no model validity.
    Slice(Result<Option<Box<SliceOutcome>>, StudyError>, Quantity),
}

impl Solved {
    pub fn pose(scenario: &Scenario, wish: PoseWish) -> Self {
        let own_pose = InputTrial::at(scenario.crf_from_tool);
        let solved = SolvedPose {
            detail: simulate_pose(scenario),
            scatter: wish.scatter.then(|| first_order(scenario)),
            sources: match wish.sources {
                true => trial_sources(scenario, own_pose),
                false => Vec::new(),
            },
        };
        Self::Pose(Box::new(solved), wish)
    }

    /// A study, and what it is charted from where that is wanted.
    pub fn study(scenario: &Scenario, wish: &StudyWish, cancel: &CancelToken) -> Self {
        let charted = |profile| ChartedProfile::new(profile, scenario.requirement.as_ref());
        let study = match wish.profile {
            false => study(scenario, &wish.mode, cancel, None).map(|study| (study, None)),
            true => study_profiled(scenario, &wish.mode, cancel)
                .map(|(study, profile)| (study, profile.map(charted).map(Box::new))),
        };
        let study = study.map(|(study, profile)| (Box::new(study), profile));
        Self::Study(study, wish.of)
    }

    pub fn slice(scenario: &Scenario, wish: &SliceWish, cancel: &CancelToken) -> Self {
        let (quantity, plan) = (wish.quantity, &wish.plan);
        let sampled = sample_slice(scenario, quantity, plan, cancel).and_then(|mut sampled| {
            if let (Some(slice), true) = (&mut sampled, wish.support) {
                slice.is_supported =
                    slice_support(scenario, quantity, plan, cancel)?.unwrap_or_default();
            }
            Ok(sampled.map(Box::new))
        });
        Self::Slice(sampled, quantity)
    }
}
