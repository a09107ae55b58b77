//! Takes what the workspace's threads found. What was there stays until the new is whole.

use crate::document::state::Notice;
use crate::runner::jobs::Job;
use crate::shell::dialogs::{Dialogs, ErrorDialog};
use crate::workspaces::field::failure::Failure;
use crate::workspaces::field::state::{FieldState, TableRole};
use bevy::prelude::*;
use bevy::window::RequestRedraw;
use std::sync::Arc;
use trackwright_project::{MeasurementTable, StoreError};

pub(crate) fn receive_results(
    mut state: ResMut<FieldState>,
    mut dialogs: ResMut<Dialogs>,
    mut notice: ResMut<Notice>,
    mut redraw: MessageWriter<RequestRedraw>,
) {
    let before = state.jobs();
    let mut notices = Vec::new();
    for role in TableRole::ALL {
        receive_table(&mut state, role, &mut notices);
    }
    state.forget_other_tables();
    receive_fit(&mut state, &mut notices, &mut notice);
    receive_comparison(&mut state, &mut notices);
    receive_metal(&mut state, &mut notices, &mut notice);
    if let Some(answer) = state.listing.as_ref().and_then(Job::answer) {
        state.listing = None;
        if let Ok(Ok(rooms)) = answer {
            state.rooms = rooms;
        }
    }
    if state.jobs() < before {
        // What was not there before is laid out in this frame and right in the next.
        redraw.write(RequestRedraw);
    }
    for (title, text) in notices {
        dialogs.show(ErrorDialog { title: title.to_owned(), text });
    }
}

type Notices = Vec<(&'static str, String)>;

fn receive_table(state: &mut FieldState, role: TableRole, notices: &mut Notices) {
    let slot = state.slot_mut(role);
    let Some(answer) = slot.reading.as_ref().and_then(|reading| reading.job.answer()) else {
        return;
    };
    slot.reading = None;
    match answer {
        Ok(Ok(table)) => slot.table = Some(Arc::new(table)),
        Ok(Err(StoreError::Cancelled(_))) => {}
        Ok(Err(error)) => {
            notices.push(("The measurements cannot be used", error.to_string()));
            // What is there was read in another way than was requested.
            let was = slot.table.as_ref().map(|table| table.reading);
            if let Some(was) = was {
                give_up_reading(state, was);
            }
        }
        Err(lost) => notices.push(("The measurements cannot be used", lost.to_string())),
    }
}

/// Sensors and map as they were for what is there, all readings that meant otherwise given up.
fn give_up_reading(state: &mut FieldState, was: trackwright_project::SampleReading) {
    state.settings.has_rolls = was.has_rolls;
    state.settings.model.map = was.map;
    for role in TableRole::ALL {
        let slot = state.slot_mut(role);
        if slot.reading.as_ref().is_some_and(|r| r.how != was) {
            slot.reading = None;
        }
        let is_other = |table: &Arc<MeasurementTable>| table.reading != was;
        if slot.table.as_ref().is_some_and(is_other) {
            slot.table = None;
        }
    }
}

fn receive_fit(state: &mut FieldState, notices: &mut Notices, notice: &mut Notice) {
    let Some(answer) = state.fitting.as_ref().and_then(Job::answer) else {
        return;
    };
    state.fitting = None;
    match answer {
        Ok(Ok(fitted)) => {
            state.fitted = Some(Arc::new(fitted));
            state.comparison = None;
            state.comparing = None;
        }
        Ok(Err(Failure::Cancelled)) => {
            *notice = Notice::Done("The fit was cancelled; everything is as it was".to_owned());
        }
        Ok(Err(Failure::Because(text))) => {
            notices.push(("No room can be fitted", text));
        }
        Err(lost) => notices.push(("No room can be fitted", lost.to_string())),
    }
}

fn receive_metal(state: &mut FieldState, notices: &mut Notices, notice: &mut Notice) {
    let Some(answer) = state.metal.searching.as_ref().and_then(|searching| searching.job.answer())
    else {
        return;
    };
    state.metal.searching = None;
    match answer {
        Ok(Ok(found)) => state.metal.found = Some(Arc::new(found)),
        Ok(Err(Failure::Cancelled)) => {
            *notice = Notice::Done("The search was cancelled; everything is as it was".to_owned());
        }
        Ok(Err(Failure::Because(text))) => notices.push(("No metal can be looked for", text)),
        Err(lost) => notices.push(("No metal can be looked for", lost.to_string())),
    }
}

fn receive_comparison(state: &mut FieldState, notices: &mut Notices) {
    let Some(answer) = state.comparing.as_ref().and_then(Job::answer) else {
        return;
    };
    state.comparing = None;
    match answer {
        Ok(Ok(comparison)) => state.comparison = Some(comparison),
        Ok(Err(Failure::Cancelled)) => {}
        Ok(Err(Failure::Because(text))) => {
            notices.push(("The design has no figures in this room", text));
        }
        Err(lost) => notices.push(("The design has no figures in this room", lost.to_string())),
    }
}
