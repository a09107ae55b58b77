//! Commands of layers.

use crate::layers::best_place::{MOVE_TO_BEST, move_on_request};
use crate::layers::magnification::{FIT, fit_on_request};
use crate::shell::commands::AddCommand;
use bevy::prelude::*;

/// Registers the commands.
pub struct LayersCommandsPlugin;

impl Plugin for LayersCommandsPlugin {
    fn build(&self, app: &mut App) {
        app.add_command(FIT, fit_on_request).add_command(MOVE_TO_BEST, move_on_request);
    }
}
