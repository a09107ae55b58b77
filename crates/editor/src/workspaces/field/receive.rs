//! Takes what the workspace's threads found. What was there stays until the new is whole.

use crate::document::state::Notice;
use crate::runner::jobs::Job;
use crate::shell::dialogs::{Dialogs, ErrorDialog};
use crate::workspaces::field::state::{FieldState, TableRole};
use crate::workspaces::field::work::Failure;
use bevy::prelude::*;
use bevy::window::RequestRedraw;
use std::sync::Arc;
use trackwright_project::{MeasurementTable, StoreError};

pub(crate) fn receive_results(
    mut desk: ResMut<FieldState>,
    mut dialogs: ResMut<Dialogs>,
    mut notice: ResMut<Notice>,
    mut redraw: MessageWriter<RequestRedraw>,
) {
    let before = desk.jobs();
    let mut told = Vec::new();
    for role in TableRole::ALL {
        receive_table(&mut desk, role, &mut told);
    }
    receive_fit(&mut desk, &mut told, &mut notice);
    receive_comparison(&mut desk, &mut told);
    if let Some(answer) = desk.listing.as_ref().and_then(Job::answer) {
        desk.listing = None;
        if let Ok(Ok(rooms)) = answer {
            desk.rooms = rooms;
        }
    }
    if desk.jobs() < before {
        // What was not there before is laid out in this frame and right in the next.
        redraw.write(RequestRedraw);
    }
    for (title, text) in told {
        dialogs.show(ErrorDialog { title: title.to_owned(), text });
    }
}

type Told = Vec<(&'static str, String)>;

fn receive_table(desk: &mut FieldState, role: TableRole, told: &mut Told) {
    let slot = desk.slot_mut(role);
    let Some(answer) = slot.reading.as_ref().and_then(|reading| reading.job.answer()) else {
        return;
    };
    slot.reading = None;
    match answer {
        Ok(Ok(table)) => slot.table = Some(Arc::new(table)),
        Ok(Err(StoreError::Cancelled(_))) => {}
        Ok(Err(error)) => {
            told.push(("The measurements cannot be used", error.to_string()));
            // What is there was read in another way than was asked for.
            let was = slot.table.as_ref().map(|table| table.reading);
            if let Some(was) = was {
                give_up_reading(desk, was);
            }
        }
        Err(lost) => told.push(("The measurements cannot be used", lost.to_string())),
    }
}

/// Sensors and map as they were for what is there, all readings that meant otherwise given up.
fn give_up_reading(desk: &mut FieldState, was: trackwright_project::SampleReading) {
    desk.settings.has_rolls = was.has_rolls;
    desk.settings.model.map = was.map;
    for role in TableRole::ALL {
        let slot = desk.slot_mut(role);
        if slot.reading.as_ref().is_some_and(|r| r.how != was) {
            slot.reading = None;
        }
        let is_other = |table: &Arc<MeasurementTable>| table.reading != was;
        if slot.table.as_ref().is_some_and(is_other) {
            slot.table = None;
        }
    }
}

fn receive_fit(desk: &mut FieldState, told: &mut Told, notice: &mut Notice) {
    let Some(answer) = desk.fitting.as_ref().and_then(Job::answer) else {
        return;
    };
    desk.fitting = None;
    match answer {
        Ok(Ok(fitted)) => {
            desk.fitted = Some(Arc::new(fitted));
            desk.comparison = None;
            desk.comparing = None;
        }
        Ok(Err(Failure::Cancelled)) => {
            *notice = Notice::Done("The fit was cancelled; everything is as it was".to_owned());
        }
        Ok(Err(Failure::Because(text))) => {
            told.push(("No room can be fitted", text));
        }
        Err(lost) => told.push(("No room can be fitted", lost.to_string())),
    }
}

fn receive_comparison(desk: &mut FieldState, told: &mut Told) {
    let Some(answer) = desk.comparing.as_ref().and_then(Job::answer) else {
        return;
    };
    desk.comparing = None;
    match answer {
        Ok(Ok(comparison)) => desk.comparison = Some(comparison),
        Ok(Err(Failure::Cancelled)) => {}
        Ok(Err(Failure::Because(text))) => {
            told.push(("The design has no figures in this room", text));
        }
        Err(lost) => told.push(("The design has no figures in this room", lost.to_string())),
    }
}
