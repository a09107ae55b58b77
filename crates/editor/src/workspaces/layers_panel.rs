//! The layers' switches and settings as a panel that several workspaces have.

use crate::document::requests::{OpenWorld, ViewRequest};
use crate::layers::layers_ui::{LayersPanel, Listed};
use crate::shell::requests::Requests;
use bevy::prelude::*;
use bevy_egui::egui::Ui;

/// All layers.
pub(crate) fn layers_panel(
    mut ui: InMut<Ui>,
    world: Res<OpenWorld>,
    layers: LayersPanel,
    mut requests: Requests<ViewRequest>,
) {
    requests.write_all(layers.ui(&mut ui, &world, Listed::All).map(ViewRequest::Set));
}

/// Those of the room.
pub(crate) fn room_layers_panel(
    mut ui: InMut<Ui>,
    world: Res<OpenWorld>,
    layers: LayersPanel,
    mut requests: Requests<ViewRequest>,
) {
    requests.write_all(layers.ui(&mut ui, &world, Listed::OfTheRoom).map(ViewRequest::Set));
}
