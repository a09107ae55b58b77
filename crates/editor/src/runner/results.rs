//! The newest results that the panels and the scene show.

use crate::document::trials::ModeKind;
use crate::runner::diagnostics::Diagnostics;
use crate::runner::solved::{Extent, Scatter};
use crate::runner::wake::Waker;
use bevy::prelude::*;
use std::time::Duration;
use trackwright_simulation::{ChartedProfile, PoseDetail, SliceOutcome, Study, TrialSource};

/// The newest results that the panels and the scene show.
#[derive(Resource, Default)]
pub struct Results {
    pub study: Option<Stamped<Study>>,
    /// What the study's figures are of.
    pub extent: Option<Extent>,
    /// The mode that the study's figures are of.
    pub mode: Option<ModeKind>,
    /// The study trial by trial; `None` outside the Study workspace, and where there are too many
    /// trials. While something is dragged it stays what it was.
    pub profile: Option<Stamped<ChartedProfile>>,
    /// Of the shown trial, or of the design's own pose.
    pub pose: Option<Stamped<PoseDetail>>,
    /// The trial that `pose` is of, from 0; `None` for the design's own pose.
    pub pose_trial: Option<usize>,
    /// Serial of the trials that `pose_trial` counts; the trial choice's while they are shown.
    pub pose_serial: u64,
    /// Of the same pose; `None` while its layer is off.
    pub scatter: Option<Scatter>,
    /// What each sensor contributes to the tip error of the shown trial; empty at the design's own
    /// pose and of live poses.
    pub sources: Vec<TrialSource>,
    pub slice: Option<Stamped<SliceOutcome>>,
    /// Why there are no figures, in words.
    pub problem: Option<String>,
}

impl Results {
    /// Whether the study's figures are of all its trials.
    pub fn is_whole(&self) -> bool {
        self.extent == Some(Extent::Whole)
    }
}

/// A result and what it belongs to.
#[derive(Clone, Debug)]
pub struct Stamped<T> {
    /// The document's revision that it was computed for.
    pub revision: u64,
    pub value: T,
    pub took: Duration,
}

/// Owns [`Results`], [`Diagnostics`] and the [`Waker`].
pub struct ResultsPlugin;

impl Plugin for ResultsPlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<Results>().init_resource::<Diagnostics>().init_resource::<Waker>();
    }
}
