//! Carries out requests to the table, or hands them to its threads, and takes what those found.

use crate::document::file_names::{file_folder, working_folder};
use crate::document::requests::{EditRequest, OpenWorld};
use crate::runner::jobs::{JobInfo, Work};
use crate::shell::dialogs::{Dialogs, ErrorDialog};
use crate::shell::window::Workspace;
use crate::workspaces::decide::requests::WORKSPACE;
use crate::workspaces::decide::sweep_table::dialog::SweepDialog;
use crate::workspaces::decide::sweep_table::state::{
    OpenSweep, Page, Sorting, SweepTableRequest, SweepTableState,
};
use crate::workspaces::decide::sweep_table::work::{
    self, FoundRow, Opened, RowJobError, RowUse, TableFound,
};
use bevy::prelude::*;
use bevy::window::RequestRedraw;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use trackwright_project::file_name;
use trackwright_sweep::Direction;

/// Kinds of jobs: what is smaller goes first.
const OPEN: u8 = 0;
const SORT: u8 = 1;
const PAGE: u8 = 2;

const NOT_OPENED: &str = "The sweep cannot be opened";
const NOT_READ: &str = "The rows cannot be read";

pub(super) fn answer(
    mut requests: MessageReader<SweepTableRequest>,
    mut state: ResMut<SweepTableState>,
    mut dialogs: ResMut<Dialogs>,
    world: Option<Res<OpenWorld>>,
    mut edits: MessageWriter<EditRequest>,
) {
    for request in requests.read() {
        match request.clone() {
            SweepTableRequest::ShowOpen => {
                let chosen = state.folder.clone().filter(|folder| folder.is_dir());
                let beside = || world.as_ref().map(|world| file_folder(&world.0));
                let folder = chosen.or_else(beside).unwrap_or_else(working_folder);
                dialogs.show(SweepDialog::open(folder));
            }
            SweepTableRequest::Open(path) => open(&mut state, path),
            SweepTableRequest::Close => close(&mut state),
            SweepTableRequest::View(places) => view(&mut state, places),
            SweepTableRequest::SortBy(column) => sort_by(&mut state, column),
            SweepTableRequest::ShowRow(row) => find_row(&mut state, row, RowUse::Show),
            SweepTableRequest::OpenAsDesign(row) => {
                find_row(&mut state, row, RowUse::OpenAsDesign);
            }
            SweepTableRequest::TakeBack => {
                let standing = state
                    .open
                    .as_ref()
                    .zip(world.as_ref())
                    .and_then(|(open, world)| open.standing(&world.0.document));
                if standing.is_some() {
                    edits.write(EditRequest::Undo);
                }
            }
        }
    }
}

/// What is open stays until the new one is.
fn open(state: &mut SweepTableState, path: PathBuf) {
    state.folder = path.parent().map(Path::to_path_buf);
    state.opening = Some(path.clone());
    state.serial += 1;
    let key = (state.serial, 0);
    let work: Work<TableFound> =
        Box::new(move |task, _| Some(TableFound::Opened(work::open(&path, &task.cancel))));
    state.tables.submit(JobInfo { kind: OPEN, ..JobInfo::default() }, key, work);
}

fn close(state: &mut SweepTableState) {
    state.open = None;
    [SORT, PAGE].into_iter().for_each(|kind| state.tables.give_up(kind));
    state.rows.give_up(0);
}

/// Reads the rows in view, with as many above and below them as are in view: who scrolls a little finds them
/// there.
fn view(state: &mut SweepTableState, places: Range<u64>) {
    let Some(open) = &mut state.open else { return };
    let is_awaited = open.awaited_page.as_ref().is_some_and(|awaited| {
        awaited.start <= places.start && places.end.min(open.rows) <= awaited.end
    });
    if open.page.has(&places) || is_awaited {
        return;
    }
    let in_view = places.end.saturating_sub(places.start);
    let wanted =
        places.start.saturating_sub(in_view)..places.end.saturating_add(in_view).min(open.rows);
    open.awaited_page = Some(wanted.clone());
    let (table, order) = (Arc::clone(&open.table), open.order.clone());
    let work: Work<TableFound> = Box::new(move |task, _| {
        let order = order.as_ref().map(|order| order.as_slice());
        Some(TableFound::Page(work::page(&table, order, wanted, &task.cancel)))
    });
    let key = (open.serial, open.orders);
    state.tables.submit(JobInfo { kind: PAGE, ..JobInfo::default() }, key, work);
}

fn sort_by(state: &mut SweepTableState, column: usize) {
    let Some(open) = &mut state.open else { return };
    let before = open.awaited_sorting.unwrap_or(open.sorting);
    let sorting = match before.filter(|sorting| sorting.column == column) {
        None => Some(Sorting { column, direction: Direction::Ascending }),
        Some(Sorting { direction: Direction::Ascending, .. }) => {
            Some(Sorting { column, direction: Direction::Descending })
        }
        Some(_) => None,
    };
    open.awaited_sorting = Some(sorting);
    let (table, key) = (Arc::clone(&open.table), (open.serial, open.orders));
    let work: Work<TableFound> = Box::new(move |task, _| {
        Some(TableFound::Sorted(sorting, work::sort(&table, sorting, &task.cancel)))
    });
    state.tables.submit(JobInfo { kind: SORT, ..JobInfo::default() }, key, work);
}

fn find_row(state: &mut SweepTableState, row: u64, wanted: RowUse) {
    let Some(open) = &mut state.open else { return };
    open.selected = Some(row);
    open.awaited_row = Some(row);
    let (table, sweep) = (Arc::clone(&open.table), open.sweep.clone());
    let work: Work<Result<FoundRow, RowJobError>> =
        Box::new(move |_, _| Some(work::find_row(&table, sweep, (row, wanted))));
    state.rows.submit(JobInfo::default(), (open.serial, row), work);
}

/// Takes what the table's thread found.
pub(super) fn receive(
    mut state: ResMut<SweepTableState>,
    mut dialogs: ResMut<Dialogs>,
    mut workspace: ResMut<Workspace>,
    mut redraw: MessageWriter<RequestRedraw>,
) {
    let state = state.bypass_change_detection();
    for answer in state.tables.answers().into_iter().filter(|answer| answer.is_newest) {
        redraw.write(RequestRedraw);
        let found = match answer.value {
            Ok(found) => found,
            Err(lost) => {
                give_up(state, answer.kind);
                dialogs.show(ErrorDialog::new(NOT_READ, &lost));
                continue;
            }
        };
        match found {
            TableFound::Opened(Ok(opened)) => {
                close(state);
                state.opening = None;
                state.open = Some(opened_sweep(answer.key.0, opened));
                workspace.set_if_neq(WORKSPACE);
            }
            TableFound::Opened(Err(error)) => {
                state.opening = None;
                dialogs.show(ErrorDialog::new(NOT_OPENED, &error));
            }
            TableFound::Sorted(sorting, Ok((order, page))) => {
                let Some(open) = of_key(state, answer.key) else { continue };
                open.awaited_sorting = None;
                open.awaited_page = None;
                open.orders += 1;
                (open.sorting, open.order, open.page) = (sorting, order, page);
            }
            TableFound::Page(Ok(page)) => {
                let Some(open) = of_key(state, answer.key) else { continue };
                open.awaited_page = None;
                open.page = page;
                state.pages += 1;
            }
            TableFound::Sorted(_, Err(error)) | TableFound::Page(Err(error)) => {
                give_up(state, answer.kind);
                dialogs.show(ErrorDialog::new(NOT_READ, &error));
            }
        }
    }
}

/// What cannot be read is not requested again in each frame: its rows are empty.
fn give_up(state: &mut SweepTableState, kind: u8) {
    state.opening = state.opening.take().filter(|_| kind != OPEN);
    let Some(open) = &mut state.open else { return };
    match kind {
        SORT => open.awaited_sorting = None,
        PAGE => {
            if let Some(places) = open.awaited_page.take() {
                open.page = Page { places, cells: Vec::new() };
            }
        }
        _ => {}
    }
}

/// The sweep that an answer is of, in the order that it is in.
fn of_key(state: &mut SweepTableState, (serial, orders): (u64, u64)) -> Option<&mut OpenSweep> {
    state.open.as_mut().filter(|open| (open.serial, open.orders) == (serial, orders))
}

fn opened_sweep(serial: u64, opened: Opened) -> OpenSweep {
    OpenSweep {
        serial,
        name: file_name(opened.table.path()),
        rows: opened.table.rows(),
        table: Arc::new(opened.table),
        columns: opened.columns,
        sorting: None,
        order: None,
        orders: 0,
        awaited_sorting: None,
        page: opened.page,
        awaited_page: None,
        selected: None,
        awaited_row: None,
        shown: None,
        sweep: None,
    }
}
