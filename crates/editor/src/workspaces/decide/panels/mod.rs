//! The panels of the Decide workspace: pure functions from its state to the person's requests.

pub mod baseline_ui;
pub mod recorded_ui;
pub mod steps_ui;
pub mod systems;
pub mod table_ui;

use crate::runner::results::Results;
use crate::workspaces::decide::against::{Against, Found};
use crate::workspaces::decide::judged::Judged;
use crate::workspaces::decide::state::DecideState;
use crate::workspaces::decide::state::Pinned;
use trackwright_design::Document;
use trackwright_procedure::StepStatus;
use trackwright_project::RoomListing;

/// What the panels are drawn from.
#[derive(Clone, Copy)]
pub struct DecideView<'a> {
    pub document: &'a Document,
    pub generation: u64,
    pub results: &'a Results,
    pub state: &'a DecideState,
    pub against: Option<&'a Against>,
    pub judged: Option<&'a Judged>,
    /// The name of the design's own room.
    pub environment: &'a str,
    /// Rooms that there are.
    pub rooms: &'a [RoomListing],
    /// Whether the room list is being read.
    pub is_listing: bool,
}

impl<'a> DecideView<'a> {
    /// Where the design stands, as it was computed last.
    fn status(&self) -> Option<&'a StepStatus> {
        self.judged?.found().map(|(status, _)| status)
    }

    /// What there is to know of the built tool's tables.
    fn notes(&self) -> &'a [String] {
        self.judged.map_or(&[], Judged::notes)
    }

    /// The newest comparison with the baseline, and whether it is of the design as it is now.
    fn found(&self, pinned: &Pinned) -> Option<(&'a Found, bool)> {
        let (key, found) = self.against?.found(pinned.serial)?;
        let is_current = key.generation == self.generation
            && found.design.has_studies_of(self.document.design());
        Some((found, is_current))
    }
}
