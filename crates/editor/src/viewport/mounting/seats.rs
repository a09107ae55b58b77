//! The places of selected sensors as seats.

use crate::document::requests::{EditRequest, OpenWorld};
use crate::document::selection::Selection;
use crate::shell::commands::{AddCommand, Command, EDIT};
use bevy::prelude::*;
use trackwright_design::{Design, Edit};
use trackwright_simulation::MountingRegion;

pub const ADD_SEATS: Command = Command::new(
    EDIT,
    57,
    "Add mounting seats at sensors",
    "Makes the places and axes of the selected sensors fixed seats of their body",
)
.available_if(|now| {
    now.world.is_some() && now.workspace.edits_design && now.selection.sensors().is_some()
});

pub(super) fn plugin(app: &mut App) {
    app.add_command(ADD_SEATS, add_seats);
}

fn add_seats(
    world: Option<Res<OpenWorld>>,
    selection: Res<Selection>,
    mut edits: MessageWriter<EditRequest>,
) {
    let design = world.as_ref().map(|world| world.0.document.design());
    let edit = design.and_then(|design| edit(design, &selection));
    edits.write_batch(edit.map(EditRequest::Apply));
}

fn edit(design: &Design, selection: &Selection) -> Option<Edit> {
    let (body, indices) = selection.sensors()?;
    let own = design.body(body)?;
    let sensors = indices.iter().filter_map(|index| own.rigid.sensors.get(*index));
    let mut mounting = own.mounting.clone();
    mounting.regions.extend(sensors.map(MountingRegion::seat_of));
    Some(Edit::SetMounting { body, mounting: Box::new(mounting) })
}
