//! Mounting regions by hand: a brush that paints a patch and erases it, clicks that draw a channel, a
//! drag that draws a forbidden box, balls that resize boxes.

pub mod box_handles;
pub mod channel;
pub mod drag;
pub mod seats;
pub mod state;

use bevy::prelude::*;

/// The tools for mounting regions, and which body they change.
pub struct MountingPlugin;

impl Plugin for MountingPlugin {
    fn build(&self, app: &mut App) {
        app.add_plugins((state::plugin, drag::plugin, channel::plugin, seats::plugin))
            .add_plugins(box_handles::plugin);
    }
}
