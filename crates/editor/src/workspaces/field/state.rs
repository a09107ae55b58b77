//! The state of the Field workspace: tables, settings, the newest fit, found metal, rooms, and what is
//! under way.

use crate::runner::jobs::Job;
use crate::workspaces::field::failure::Failure;
use crate::workspaces::field::kind::FieldKind;
use crate::workspaces::field::metal::MetalSearch;
use bevy::prelude::Resource;
use std::collections::BTreeSet;
use std::path::PathBuf;
use std::sync::Arc;
use trackwright_calibration::fit_quality::{ErrorSummary, FitQuality};
use trackwright_calibration::kind_choice::Decided;
use trackwright_calibration::room_choice::ModelRequest;
use trackwright_calibration::room_fit::RegistrationError;
use trackwright_calibration::room_model::HarmonicReport;
use trackwright_field::Environment;
use trackwright_field::environment::Jitter;
use trackwright_field::fit::{DEFAULT_RCOND, Fit, FitMethod};
use trackwright_field::samples::MapKind;
use trackwright_geometry::directions::Weighting;
use trackwright_geometry::volume::Volume;
use trackwright_project::{MeasurementTable, RoomListing, RoomSource, SampleReading, StoreError};
use trackwright_simulation::Study;
use trackwright_task::Cancelled;

/// A table that several hold at a time: the state, a fit, the thread that fits.
pub type Table = Arc<MeasurementTable>;

/// Which of the two tables.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum TableRole {
    /// The model is fitted to it.
    Training,
    /// The model is judged on it.
    HeldOut,
}

impl TableRole {
    pub const ALL: [Self; 2] = [Self::Training, Self::HeldOut];
}

/// What a room is made with.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FieldSettings {
    pub kind: FieldKind,
    /// Of polynomials; what is left out is chosen by cross-validation. The map is of every kind.
    pub model: ModelRequest,
    /// Of a harmonic model; from the number of measurements where there is none.
    pub degree: Option<usize>,
    /// Whether the tables' quaternions are whole rotations, those of 6-DOF sensors.
    pub has_rolls: bool,
    /// Rows that the measured side is behind the ideal one.
    pub lag_rows: f64,
    /// How far measured positions are along the sensor's axis from ideal ones.
    pub sensor_offset_mm: f64,
    pub volume: Option<Volume>,
    pub jitter: Option<Jitter>,
    /// How well the reference's frame is known, where that is stated.
    pub registration: Option<RegistrationError>,
}

impl Default for FieldSettings {
    /// Those of the command line.
    fn default() -> Self {
        Self {
            kind: FieldKind::default(),
            degree: None,
            model: ModelRequest {
                order: None,
                directions: None,
                ridge: None,
                method: FitMethod::default(),
                map: MapKind::Distortion,
                weighting: Weighting::default(),
                rcond: DEFAULT_RCOND,
            },
            has_rolls: false,
            lag_rows: 0.0,
            sensor_offset_mm: 0.0,
            volume: None,
            jitter: None,
            registration: None,
        }
    }
}

impl FieldSettings {
    /// How tables are read for it.
    pub fn reading(&self) -> SampleReading {
        let Self { has_rolls, lag_rows, sensor_offset_mm, .. } = *self;
        SampleReading { has_rolls, map: self.model.map, lag_rows, sensor_offset_mm }
    }

    /// Whether cross-validation has something to choose, but for what the samples decide.
    pub fn is_open(&self) -> bool {
        let is_model_open = self.model.order.is_none() || self.model.directions.is_none();
        self.kind == FieldKind::Best || (self.kind.is_polynomial() && is_model_open)
    }
}

/// A table's place: what is there, and what is on its way.
#[derive(Default)]
pub struct TableSlot {
    pub table: Option<Table>,
    pub reading: Option<Reading>,
}

/// A table on its way.
pub struct Reading {
    pub file: PathBuf,
    pub how: SampleReading,
    pub job: Job<Result<MeasurementTable, StoreError>>,
}

/// The newest room and its fit quality.
#[derive(Debug)]
pub struct Fitted {
    /// Named after its table until it is saved.
    pub environment: Arc<Environment>,
    pub fit: Fit,
    /// The model, and how it was decided.
    pub decided: Decided,
    pub harmonic: Option<HarmonicReport>,
    pub training_quality: FitQuality,
    pub held_out_quality: Option<FitQuality>,
    pub notes: Vec<String>,
    /// What it was made from.
    pub training: Table,
    pub held_out: Option<Table>,
    pub field_settings: FieldSettings,
}

/// The open design in the present room and in a fitted one.
#[derive(Clone, Debug)]
pub struct Comparison {
    pub present: Study,
    pub tried: Study,
    pub room: Arc<Fitted>,
    pub generation: u64,
    pub revision: u64,
}

/// What the samples in the 3D view are, and what their colours mean.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SamplesShown {
    pub training: bool,
    pub held_out: bool,
    pub value: SampleValue,
}

impl SamplesShown {
    pub fn is_shown(&self, role: TableRole) -> bool {
        match role {
            TableRole::Training => self.training,
            TableRole::HeldOut => self.held_out,
        }
    }
}

impl Default for SamplesShown {
    fn default() -> Self {
        Self { training: true, held_out: true, value: SampleValue::Measured }
    }
}

/// What a sample's colour means.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SampleValue {
    /// Its position error as it was measured.
    Measured,
    /// What the fitted room leaves of it.
    Left,
}

/// How often work was begun; what is hidden begins none.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct FieldCounts {
    pub readings: u64,
    pub fits: u64,
    pub comparisons: u64,
    /// For metal, comparisons of what was found included.
    pub searches: u64,
    pub listings: u64,
    /// Meshes of samples that were built.
    pub sample_meshes: u64,
}

/// Rooms on their way to the list.
pub type Listing = Job<Result<Vec<RoomListing>, Cancelled>>;

/// The workspace's whole state.
#[derive(Resource, Default)]
pub struct FieldState {
    pub training: TableSlot,
    pub held_out: TableSlot,
    /// Tables that are fitted although they are beyond doubt not what they are read as.
    pub as_is: BTreeSet<PathBuf>,
    pub settings: FieldSettings,
    pub fitted: Option<Arc<Fitted>>,
    pub fitting: Option<Job<Result<Fitted, Failure>>>,
    pub comparison: Option<Comparison>,
    pub comparing: Option<Job<Result<Comparison, Failure>>>,
    pub metal: MetalSearch,
    pub rooms: Vec<RoomListing>,
    pub listing: Option<Listing>,
    /// Where the open design's room is.
    pub own: Option<RoomSource>,
    /// The rooms that were assigned while the program runs, the newest first.
    pub recent: Vec<RoomSource>,
    pub shown: SamplesShown,
    /// The window with Fig. 3 and its table.
    pub is_selection_open: bool,
    /// A file is held over the window.
    pub is_drop_near: bool,
    pub counts: FieldCounts,
}

impl FieldState {
    pub fn slot(&self, role: TableRole) -> &TableSlot {
        match role {
            TableRole::Training => &self.training,
            TableRole::HeldOut => &self.held_out,
        }
    }

    pub fn slot_mut(&mut self, role: TableRole) -> &mut TableSlot {
        match role {
            TableRole::Training => &mut self.training,
            TableRole::HeldOut => &mut self.held_out,
        }
    }

    /// How many threads work for it.
    pub fn jobs(&self) -> usize {
        let readings = TableRole::ALL.map(|role| self.slot(role).reading.is_some());
        let others = [
            self.fitting.is_some(),
            self.comparing.is_some(),
            self.metal.searching.is_some(),
            self.listing.is_some(),
        ];
        let all = readings.into_iter().chain(others);
        all.filter(|is_working| *is_working).count()
    }

    /// Whether any thread works for it.
    pub fn is_busy(&self) -> bool {
        self.jobs() > 0
    }

    /// Why nothing can be fitted now; `None` where something can.
    pub fn hindrance(&self) -> Option<&'static str> {
        let slots = TableRole::ALL.map(|role| self.slot(role));
        if self.fitting.is_some() {
            return Some("a room is being fitted already");
        }
        if slots.iter().any(|slot| slot.reading.is_some()) {
            return Some("the measurements are still being read");
        }
        if self.training.table.is_none() {
            return Some("no measurements to fit, open a table first");
        }
        let tables = slots.iter().filter_map(|slot| slot.table.as_ref());
        if tables.clone().any(|table| self.is_refused(table)) {
            return Some("a table is suspected, see its warning");
        }
        None
    }

    /// Whether a table is not to be used until the person confirms that it is meant as it is.
    pub(super) fn is_refused(&self, table: &Table) -> bool {
        table.is_beyond_doubt() && !self.as_is.contains(&table.file)
    }

    /// Forgets metal that was found, or is looked for, in another table than the one that is open.
    pub fn forget_other_tables(&mut self) {
        self.metal.keep_to(self.training.table.as_ref());
    }

    /// Whether the newest fit is not what a fit would give now.
    pub fn is_outdated(&self, fitted: &Fitted) -> bool {
        let is_table = |now: &Option<Table>, then: Option<&Table>| match (now, then) {
            (Some(now), Some(then)) => Arc::ptr_eq(now, then),
            (None, None) => true,
            _ => false,
        };
        fitted.field_settings != self.settings
            || !is_table(&self.training.table, Some(&fitted.training))
            || !is_table(&self.held_out.table, fitted.held_out.as_ref())
    }

    /// What the colours of a table's samples mean: what the fit leaves where that is requested and
    /// known of this very table, else the error as it was measured.
    pub fn sample_values(&self, role: TableRole) -> Option<(SampleValue, &ErrorSummary)> {
        let table = self.slot(role).table.as_ref()?;
        let left = self
            .fitted
            .as_ref()
            .filter(|_| self.shown.value == SampleValue::Left)
            .and_then(|fitted| fitted.left_on(table));
        Some(match left {
            Some(left) => (SampleValue::Left, left),
            None => (SampleValue::Measured, &table.measured),
        })
    }
}

impl Fitted {
    /// What it leaves of a table's errors, if it was judged on that.
    pub fn left_on(&self, table: &Table) -> Option<&ErrorSummary> {
        if Arc::ptr_eq(table, &self.training) {
            return Some(&self.training_quality.after);
        }
        let held_out = self.held_out.as_ref()?;
        Arc::ptr_eq(table, held_out)
            .then(|| self.held_out_quality.as_ref().map(|quality| &quality.after))?
    }
}
