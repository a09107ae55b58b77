//! Commands of layers.

use crate::document::requests::{OpenWorld, ViewRequest};
use crate::layers::best_place::{MOVE_TO_BEST, move_on_request};
use crate::layers::magnification::{FIT, fit_on_request};
use crate::shell::commands::{AddCommand, Command, VIEW};
use bevy::prelude::*;
use trackwright_design::view::{CoilDepth, View};

pub const PLACE_IN_BORE: Command = Command::new(
    VIEW,
    13,
    "Placement in the bore",
    "Imagines the coil of Sensor placement as deep in its body as it is, or on the surface again",
)
.available_if(|now| now.document().is_some_and(|own| own.view().layers.placement));

/// Registers the commands.
pub struct LayersCommandsPlugin;

impl Plugin for LayersCommandsPlugin {
    fn build(&self, app: &mut App) {
        app.add_command(FIT, fit_on_request)
            .add_command(PLACE_IN_BORE, place_in_bore)
            .add_command(MOVE_TO_BEST, move_on_request);
    }
}

/// As deep as it is, or on the surface where it was so.
fn place_in_bore(world: Option<Res<OpenWorld>>, mut requests: MessageWriter<ViewRequest>) {
    let Some(world) = world else { return };
    let view = world.0.document.view();
    let placement_depth = match view.placement_depth {
        CoilDepth::Surface => CoilDepth::Own,
        CoilDepth::Own => CoilDepth::Surface,
    };
    requests.write(ViewRequest::Set(View { placement_depth, ..view.clone() }));
}
