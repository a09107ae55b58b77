//! Puts a row into the open design as one undo step, or opens it as a document of its own.

use crate::document::requests::{EditRequest, FileRequest, OpenWorld};
use crate::document::state::Notice;
use crate::shell::dialogs::{Dialogs, ErrorDialog};
use crate::workspaces::decide::sweep_table::state::{OpenSweep, SweepTableState, step_label};
use crate::workspaces::decide::sweep_table::work::UsableRow;
use bevy::ecs::system::SystemParam;
use bevy::prelude::*;
use bevy::window::RequestRedraw;
use trackwright_design::{Design, Origin};
use trackwright_project::is_same_file;
use trackwright_sweep::{RowDesign, RowDesignError};

/// What rows are put into.
#[derive(SystemParam)]
pub(super) struct Rows<'w> {
    state: ResMut<'w, SweepTableState>,
    world: Option<Res<'w, OpenWorld>>,
    dialogs: ResMut<'w, Dialogs>,
    notice: ResMut<'w, Notice>,
    edits: MessageWriter<'w, EditRequest>,
    files: MessageWriter<'w, FileRequest>,
    redraw: MessageWriter<'w, RequestRedraw>,
}

/// Takes the row that its thread found.
pub(super) fn receive(mut rows: Rows) {
    let answers = rows.state.rows.answers();
    for answer in answers.into_iter().filter(|answer| answer.is_newest) {
        const NO_DESIGN: &str = "The row cannot be shown";
        rows.redraw.write(RequestRedraw);
        let (serial, _) = answer.key;
        let open = rows.state.open.as_mut().filter(|open| open.serial == serial);
        let Some(open) = open else { continue };
        open.awaited_row = None;
        let found = match answer.value {
            Ok(Ok(found)) => found,
            Ok(Err(error)) => {
                rows.dialogs.show(ErrorDialog::new(NO_DESIGN, &error));
                continue;
            }
            Err(lost) => {
                rows.dialogs.show(ErrorDialog::new(NO_DESIGN, &lost));
                continue;
            }
        };
        open.sweep = Some(found.sweep);
        match found.row {
            Ok(UsableRow::Show(row)) => rows.show(row),
            Ok(UsableRow::OpenAsDesign(row, design)) => rows.open_as_design(&row, design),
            Err(problem @ RowDesignError::Problem { .. }) => {
                *rows.notice = Notice::Refused(problem.to_string());
            }
            Err(error) => rows.dialogs.show(ErrorDialog::new(NO_DESIGN, &error)),
        }
    }
}

fn is_of(row: &RowDesign, world: &OpenWorld) -> bool {
    match (&row.origin, world.0.document.origin()) {
        (Origin::File(own), Origin::File(open)) => is_same_file(own, open),
        (own, open) => own == open,
    }
}

impl Rows<'_> {
    /// In the place of the row that was shown before. The design that the row is of is opened first, where
    /// another one is open.
    fn show(&mut self, row: RowDesign) {
        let Some(world) = &self.world else { return };
        if !is_of(&row, world) {
            self.open_then_show(row);
            return;
        }
        let mut before = world.0.clone();
        let replaces = self.standing().is_some();
        if replaces {
            before.document.undo();
        }
        match row.edits(&before) {
            Ok(steps) if steps.is_empty() && !replaces => {
                let text = format!("The open design is row {} already", row.row);
                *self.notice = Notice::Done(text);
            }
            Ok(steps) => {
                if replaces {
                    self.edits.write(EditRequest::Undo);
                }
                self.edits.write_batch(EditRequest::step(step_label(row.row), steps));
                self.shown(row.row);
            }
            Err(RowDesignError::OtherBodies { .. }) => self.open_then_show(row),
            Err(error) => *self.notice = Notice::Refused(error.to_string()),
        }
    }

    fn open_then_show(&mut self, row: RowDesign) {
        match row.edits_of_saved() {
            Ok(edits) => {
                self.take_back();
                let label = step_label(row.row);
                self.files.write(FileRequest::OpenEdited { of: row.origin, label, edits });
                self.shown(row.row);
            }
            Err(error) => *self.notice = Notice::Refused(error.to_string()),
        }
    }

    fn shown(&mut self, row: u64) {
        if let Some(open) = &mut self.state.open {
            open.shown = Some(row);
        }
    }

    /// Takes the shown row back before another document is opened: it is no change that could be lost.
    fn take_back(&mut self) {
        if self.standing().is_some() {
            self.edits.write(EditRequest::Undo);
        }
    }

    fn open_as_design(&mut self, row: &RowDesign, design: Box<Design>) {
        self.take_back();
        self.files.write(FileRequest::OpenVariant {
            of: row.origin.clone(),
            design,
            suffix: format!("row-{}", row.row),
        });
    }

    fn standing(&self) -> Option<u64> {
        let document = &self.world.as_ref()?.0.document;
        let standing = |open: &OpenSweep| open.standing(document);
        self.state.open.as_ref().and_then(standing)
    }
}
