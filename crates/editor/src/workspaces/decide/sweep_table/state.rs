//! The state of a sweep's table: what is open, which rows are read, what is under way.

use crate::runner::jobs::Runner;
use crate::runner::wake::Waker;
use crate::workspaces::decide::sweep_table::work::{FoundRow, RowJobError, TableFound};
use bevy::prelude::*;
use std::ops::Range;
use std::path::PathBuf;
use std::sync::Arc;
use trackwright_design::Document;
use trackwright_sweep::{Cell, Column, Direction, PROBLEM, ROW, Sweep, SweepTable};

/// A request to the table. Places count the rows in the order that is shown; numbers are the plan's.
#[derive(Message, Clone, Debug, PartialEq)]
pub enum SweepTableRequest {
    /// Shows the dialog that chooses a sweep.
    ShowOpen,
    /// A folder, the plan's file in it, or a merged table.
    Open(PathBuf),
    Close,
    /// The places that are in view.
    View(Range<u64>),
    /// By a column; once more in the other direction, then in the table's own order again.
    SortBy(usize),
    /// Gives the open design the numbers of a row.
    ShowRow(u64),
    /// Undoes that.
    TakeBack,
    /// Opens a row as a document of its own.
    OpenAsDesign(u64),
}

/// What a job of the table was submitted for: the sweep, and the order of its rows.
pub type TableKey = (u64, u64);

/// What a row's job was submitted for.
pub type RowKey = (u64, u64);

#[derive(Resource)]
pub struct SweepTableState {
    /// Where a sweep was chosen last.
    pub folder: Option<PathBuf>,
    pub open: Option<OpenSweep>,
    /// On its way.
    pub opening: Option<PathBuf>,
    /// Sweeps so far.
    pub serial: u64,
    pub(super) tables: Runner<TableKey, TableFound>,
    /// Of their own: the rooms of a plan may have metal that takes its time.
    pub(super) rows: Runner<RowKey, Result<FoundRow, RowJobError>>,
    /// Pages that were read, for tests.
    pub pages: usize,
}

/// An open sweep.
pub struct OpenSweep {
    pub serial: u64,
    pub name: String,
    pub table: Arc<SweepTable>,
    pub columns: Vec<Column>,
    pub rows: u64,
    pub sorting: Option<Sorting>,
    /// The rows' places in the table, where they are sorted.
    pub order: Option<Arc<Vec<u64>>>,
    /// Orders so far.
    pub orders: u64,
    /// Is being computed.
    pub awaited_sorting: Option<Option<Sorting>>,
    pub page: Page,
    /// Places that are being read.
    pub awaited_page: Option<Range<u64>>,
    /// The number of the row that was clicked last.
    pub selected: Option<u64>,
    /// Is being made a design.
    pub awaited_row: Option<u64>,
    /// Was put into a document last.
    pub shown: Option<u64>,
    /// The plan with all that it refers to, once a row was shown.
    pub sweep: Option<Arc<Sweep>>,
}

/// What rows are sorted by.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Sorting {
    pub column: usize,
    pub direction: Direction,
}

/// Rows that are in memory, with all columns.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Page {
    pub places: Range<u64>,
    pub cells: Vec<Vec<Cell>>,
}

impl Page {
    pub fn has(&self, places: &Range<u64>) -> bool {
        places.is_empty() || (self.places.start <= places.start && places.end <= self.places.end)
    }

    /// `None` of a row that is not in memory.
    pub fn cell(&self, column: usize, place: u64) -> Option<&Cell> {
        let at = place.checked_sub(self.places.start)?;
        self.cells.get(column)?.get(usize::try_from(at).ok()?)
    }
}

/// What undo calls the step.
pub fn step_label(row: u64) -> String {
    format!("Show row {row} of the sweep")
}

impl OpenSweep {
    /// A row's number in the plan, where it is in memory.
    pub fn row_number(&self, place: u64) -> Option<u64> {
        let column = self.columns.iter().position(|column| column.name == ROW)?;
        match self.page.cell(column, place)? {
            Cell::Number(number) => Some(*number as u64),
            _ => None,
        }
    }

    /// Why a row has no figures.
    pub fn problem(&self, place: u64) -> Option<&str> {
        let column = self.columns.iter().position(|column| column.name == PROBLEM)?;
        match self.page.cell(column, place)? {
            Cell::Text(problem) => Some(problem),
            _ => None,
        }
    }

    /// The row that the open design was given last, unless that was undone or edited since.
    pub fn standing(&self, document: &Document) -> Option<u64> {
        self.shown.filter(|row| document.undo_label() == Some(&step_label(*row)))
    }

    /// Whether the files that the plan refers to, or the program, are others than its rows were computed
    /// with.
    pub fn is_outdated(&self) -> bool {
        self.sweep.as_ref().is_some_and(|sweep| sweep.hash() != self.table.hash())
    }
}

impl SweepTableState {
    pub fn is_busy(&self) -> bool {
        let is_awaited = self.open.as_ref().is_some_and(|open| {
            open.awaited_sorting.is_some()
                || open.awaited_page.is_some()
                || open.awaited_row.is_some()
        });
        self.opening.is_some() || is_awaited
    }
}

impl FromWorld for SweepTableState {
    fn from_world(world: &mut World) -> Self {
        let waker = world.get_resource_or_init::<Waker>().clone();
        Self {
            folder: None,
            open: None,
            opening: None,
            serial: 0,
            tables: Runner::new("sweep table", waker.clone()),
            rows: Runner::new("sweep row", waker),
            pages: 0,
        }
    }
}
