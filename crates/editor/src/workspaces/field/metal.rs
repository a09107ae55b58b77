//! The search for the metal that disturbs the measurements: its settings, and what it found.

use crate::runner::jobs::Job;
use crate::workspaces::field::failure::Failure;
use crate::workspaces::field::state::{FieldState, Table};
use std::path::PathBuf;
use std::sync::Arc;
use trackwright_field::generator::Generator;
use trackwright_field::samples::MeasurementSet;
use trackwright_metal::identify::compare::Compared;
use trackwright_metal::identify::{Identification, IdentifySettings};
use trackwright_project::RoomContent;

/// Where the tracker's field generator comes from.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum GeneratorSource {
    /// One of [`trackwright_field::generator::BUILT_IN`].
    BuiltIn(&'static str),
    /// That of the open design's room.
    Room,
    File(PathBuf),
}

/// The metal that explains a table.
#[derive(Clone, Debug)]
pub struct FoundMetal {
    pub found: Identification,
    /// Models of the same measurements; none before they are requested.
    pub compared: Vec<Compared>,
    pub generator: Generator,
    pub settings: IdentifySettings,
    pub measurements: Arc<MeasurementSet>,
    /// The bodies that are determined, in a room of their own.
    pub room: Option<RoomContent>,
    /// What it was found in.
    pub table: Table,
}

/// A search, or a comparison of what was found, under way.
pub struct Searching {
    pub table: Table,
    pub is_comparison: bool,
    pub job: Job<Result<FoundMetal, Failure>>,
}

/// The state of the search.
#[derive(Default)]
pub struct MetalSearch {
    /// As the person chose it.
    pub generator: Option<GeneratorSource>,
    pub searching: Option<Searching>,
    pub found: Option<Arc<FoundMetal>>,
}

impl MetalSearch {
    /// The chosen generator; without a choice that of the room, where it is known.
    pub fn generator(&self, of_room: Option<&Generator>) -> Option<GeneratorSource> {
        let default = of_room.map(|_| GeneratorSource::Room);
        let chosen = self.generator.clone();
        chosen.filter(|chosen| *chosen != GeneratorSource::Room || of_room.is_some()).or(default)
    }

    /// Forgets what belongs to another table than the one that is open.
    pub fn keep_to(&mut self, open: Option<&Table>) {
        let is_open = |table: &Table| open.is_some_and(|open| Arc::ptr_eq(open, table));
        if self.searching.as_ref().is_some_and(|searching| !is_open(&searching.table)) {
            self.searching = None;
        }
        if self.found.as_ref().is_some_and(|found| !is_open(&found.table)) {
            self.found = None;
        }
    }
}

impl FieldState {
    /// Why metal cannot be looked for now; `None` where it can.
    pub fn metal_hindrance(&self, generator: Option<&GeneratorSource>) -> Option<&'static str> {
        let slot = &self.training;
        if self.metal.searching.is_some() {
            return Some("metal is being looked for already");
        }
        if slot.reading.is_some() {
            return Some("the measurements are still being read");
        }
        let Some(table) = &slot.table else {
            return Some("no measurements to look for metal in, open a table first");
        };
        if self.is_refused(table) {
            return Some("the table is suspected, see its warning");
        }
        generator.is_none().then_some("choose the tracker's field generator first")
    }
}
