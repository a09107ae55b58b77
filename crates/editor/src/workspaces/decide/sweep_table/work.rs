//! What the table's threads do: open a sweep, sort its rows, read some of them, make one a design.

use crate::workspaces::decide::sweep_table::state::{Page, Sorting};
use std::ops::Range;
use std::path::Path;
use std::sync::Arc;
use trackwright_design::Design;
use trackwright_formats::{FormatError, sweep_plan};
use trackwright_project::StoreError;
use trackwright_sweep::{Column, RowDesign, RowDesignError, Sweep, SweepError, SweepTable};
use trackwright_task::CancelToken;

/// Rows that are read before it is known how many are in view.
const FIRST_ROWS: u64 = 64;

/// What comes of a job.
pub enum TableFound {
    Opened(Result<Opened, SweepError>),
    Sorted(Option<Sorting>, Result<Sorted, SweepError>),
    Page(Result<Page, SweepError>),
}

/// A sweep with its first rows.
pub struct Opened {
    pub table: SweepTable,
    pub columns: Vec<Column>,
    pub page: Page,
}

/// The rows' places in the table in an order, with the first of them; no places in the table's own.
pub type Sorted = (Option<Arc<Vec<u64>>>, Page);

pub fn open(path: &Path, cancel: &CancelToken) -> Result<Opened, SweepError> {
    let table = SweepTable::open(path)?;
    let columns = table.columns_to_compare();
    let page = page(&table, None, 0..FIRST_ROWS, cancel)?;
    Ok(Opened { table, columns, page })
}

/// The rows' order with the first of them; `None` is the table's own.
pub fn sort(
    table: &SweepTable,
    sorting: Option<Sorting>,
    cancel: &CancelToken,
) -> Result<Sorted, SweepError> {
    let columns = table.columns_to_compare();
    let order = sorting.and_then(|by| Some((columns.get(by.column)?, by.direction)));
    let order = order.map(|(column, direction)| table.sorted_rows(&column.name, direction, cancel));
    let order = order.transpose()?;
    let first = page(table, order.as_deref(), 0..FIRST_ROWS, cancel)?;
    Ok((order.map(Arc::new), first))
}

/// All columns of the rows at some places of an order.
pub fn page(
    table: &SweepTable,
    order: Option<&[u64]>,
    places: Range<u64>,
    cancel: &CancelToken,
) -> Result<Page, SweepError> {
    let end = places.end.min(table.rows());
    let places = places.start.min(end)..end;
    let rows: Vec<u64> = match order {
        None => places.clone().collect(),
        Some(order) => order[places.start as usize..places.end as usize].to_vec(),
    };
    let columns = table.columns_to_compare();
    let names: Vec<&str> = columns.iter().map(|column| column.name.as_str()).collect();
    Ok(Page { cells: table.cells(&names, &rows, cancel)?, places })
}

/// What is to become of a row.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RowUse {
    Show,
    OpenAsDesign,
}

/// A row as a design, or why it is none.
pub struct FoundRow {
    pub sweep: Arc<Sweep>,
    pub row: Result<UsableRow, RowDesignError>,
}

/// What is needed to use a row.
pub enum UsableRow {
    Show(RowDesign),
    OpenAsDesign(RowDesign, Box<Design>),
}

/// Why no row of a sweep can be a design.
#[derive(Debug, thiserror::Error)]
pub enum RowJobError {
    #[error("the plan of the sweep: {0}")]
    Plan(#[from] FormatError),
    #[error(transparent)]
    Store(#[from] StoreError),
}

/// Makes a row a design; opens the plan with all that it refers to where it is not open yet.
pub fn find_row(
    table: &SweepTable,
    sweep: Option<Arc<Sweep>>,
    (row, wanted): (u64, RowUse),
) -> Result<FoundRow, RowJobError> {
    let sweep = match sweep {
        Some(sweep) => sweep,
        None => {
            let plan = sweep_plan::parse(table.plan().as_bytes())?;
            Arc::new(Sweep::of_plan(plan, Path::new(""))?)
        }
    };
    let row = sweep.row_design(row).and_then(|row| {
        Ok(match wanted {
            RowUse::Show => UsableRow::Show(row),
            RowUse::OpenAsDesign => {
                let design = Box::new(row.whole()?);
                UsableRow::OpenAsDesign(row, design)
            }
        })
    });
    Ok(FoundRow { sweep, row })
}
