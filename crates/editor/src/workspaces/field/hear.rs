//! Takes what the workspace's threads found. What was there stays until the new is whole.

use crate::document::apply::Notice;
use crate::runner::job::Ended;
use crate::shell::dialogs::{Dialog, Dialogs};
use crate::workspaces::field::desk::{FieldDesk, TableRole};
use crate::workspaces::field::work::Failure;
use bevy::prelude::*;
use bevy::window::RequestRedraw;
use std::sync::Arc;
use trackwright_project::{MeasurementTable, StoreError};

/// Said where a thread is gone without an answer.
const LOST: &str = "the work ended without an answer";

pub(crate) fn hear(
    mut desk: ResMut<FieldDesk>,
    mut dialogs: ResMut<Dialogs>,
    mut notice: ResMut<Notice>,
    mut redraw: MessageWriter<RequestRedraw>,
) {
    let before = desk.jobs();
    let mut told = Vec::new();
    for role in TableRole::ALL {
        hear_table(&mut desk, role, &mut told);
    }
    hear_fit(&mut desk, &mut told, &mut notice);
    hear_comparison(&mut desk, &mut told);
    if let Some(ended) = desk.listing.as_mut().and_then(|job| job.hear()) {
        desk.listing = None;
        if let Ended::Done(Ok(rooms)) = ended {
            desk.rooms = rooms;
        }
    }
    if desk.jobs() < before {
        // What was not there before is laid out in this frame and right in the next.
        redraw.write(RequestRedraw);
    }
    for (title, text) in told {
        dialogs.show(Dialog::Error { title: title.to_owned(), text });
    }
}

type Told = Vec<(&'static str, String)>;

fn hear_table(desk: &mut FieldDesk, role: TableRole, told: &mut Told) {
    let slot = desk.slot_mut(role);
    let Some(ended) = slot.reading.as_mut().and_then(|reading| reading.job.hear()) else {
        return;
    };
    slot.reading = None;
    match ended {
        Ended::Done(Ok(table)) => slot.table = Some(Arc::new(table)),
        Ended::Done(Err(StoreError::Cancelled(_))) => {}
        Ended::Done(Err(error)) => {
            told.push(("The measurements cannot be used", error.to_string()));
            // What is there was read in another way than was asked for.
            let was = slot.table.as_ref().map(|table| table.reading);
            if let Some(was) = was {
                give_up_reading(desk, was);
            }
        }
        Ended::Lost => told.push(("The measurements cannot be used", LOST.to_owned())),
    }
}

/// Sensors and map as they were for what is there, all readings that meant otherwise given up.
fn give_up_reading(desk: &mut FieldDesk, was: trackwright_project::SampleReading) {
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

fn hear_fit(desk: &mut FieldDesk, told: &mut Told, notice: &mut Notice) {
    let Some(ended) = desk.fitting.as_mut().and_then(|job| job.hear()) else {
        return;
    };
    desk.fitting = None;
    match ended {
        Ended::Done(Ok(fitted)) => {
            desk.fitted = Some(Arc::new(fitted));
            desk.comparison = None;
            desk.comparing = None;
        }
        Ended::Done(Err(Failure::Cancelled)) => {
            *notice = Notice::Done("The fit was cancelled; everything is as it was".to_owned());
        }
        Ended::Done(Err(Failure::Because(text))) => {
            told.push(("No room can be fitted", text));
        }
        Ended::Lost => told.push(("No room can be fitted", LOST.to_owned())),
    }
}

fn hear_comparison(desk: &mut FieldDesk, told: &mut Told) {
    let Some(ended) = desk.comparing.as_mut().and_then(|job| job.hear()) else {
        return;
    };
    desk.comparing = None;
    match ended {
        Ended::Done(Ok(comparison)) => desk.comparison = Some(comparison),
        Ended::Done(Err(Failure::Cancelled)) => {}
        Ended::Done(Err(Failure::Because(text))) => {
            told.push(("The design has no figures in this room", text));
        }
        Ended::Lost => told.push(("The design has no figures in this room", LOST.to_owned())),
    }
}
