//! The state of the Decide workspace.

use crate::runner::jobs::Job;
use crate::workspaces::decide::table::{AddedDesign, Compared, Failure};
use bevy::prelude::Resource;
use std::path::PathBuf;
use std::sync::Arc;
use trackwright_calibration::agreement::BuiltRecording;
use trackwright_design::Design;
use trackwright_geometry::mesh::SurfaceMesh;
use trackwright_procedure::Step;
use trackwright_project::{RecordedPoses, RecordedPosesError, RoomSource, StoreError};

/// What is compared, and what it came to.
#[derive(Resource, Default)]
pub struct DecideState {
    /// What the design is held against.
    pub pinned: Option<Pinned>,
    /// A baseline on its way.
    pub pinning: Option<Job<Result<Pinned, StoreError>>>,
    /// Pins so far, so that two of them are never taken for one.
    pub serial: u64,
    /// Designs of the table, beside the open one and the baseline.
    pub designs: Vec<AddedDesign>,
    /// Where designs were chosen last, and recordings: beside the open design before the first.
    pub designs_folder: Option<PathBuf>,
    pub recordings_folder: Option<PathBuf>,
    /// Recorded poses of the built tool.
    pub recorded: Option<BuiltRecording>,
    /// A recording that is read to be looked at pose by pose.
    pub reading_poses: Option<Job<Result<RecordedPoses, RecordedPosesError>>>,
    /// Reasons as they are typed, of each step.
    pub notes: [String; 3],
    pub comparing: Option<Job<Result<Compared, Failure>>>,
    /// The newest table.
    pub compared: Option<Compared>,
    pub shows_all_figures: bool,
    /// The room that a design is put into once it is open, and the design.
    pub(crate) then_assign: Option<(AddedDesign, RoomSource)>,
    pub counts: DecideCounts,
}

/// A design that others are held against: as it was when it was pinned, whatever became of its file.
#[derive(Clone, Debug)]
pub struct Pinned {
    pub design: Arc<Design>,
    /// `None` for a state of the open design.
    pub file: Option<PathBuf>,
    pub tool_mesh: Option<Arc<SurfaceMesh>>,
    pub serial: u64,
    /// Whether its file was gone when it was looked for last.
    pub is_gone: bool,
}

/// Work that was started, for tests.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct DecideCounts {
    pub tables: usize,
    /// Comparisons with the baseline.
    pub baselines: usize,
    pub statuses: usize,
}

impl DecideState {
    /// What is typed as the reason of a step's decision.
    pub fn note(&self, step: Step) -> &str {
        &self.notes[step.number() - 1]
    }

    pub fn is_busy(&self) -> bool {
        self.pinning.is_some() || self.comparing.is_some() || self.reading_poses.is_some()
    }
}

impl Pinned {
    /// What stands above its figures.
    pub fn name(&self) -> String {
        match &self.file {
            None => format!("{} (as pinned)", self.design.name),
            Some(_) => self.design.name.clone(),
        }
    }
}
