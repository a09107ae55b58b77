//! The tool as the tracker reports it: translucent, with a bright rim.

use crate::layers::legend::StrokeKey;
use crate::layers::magnification::ShownErrors;
use crate::layers::registry::{AddLayer, LayerInfo};
use crate::layers::tool_ghost::{GhostLook, ToolGhost};
use crate::palette;
use crate::scene::bodies::shown_mesh;
use crate::schedule::EditorSystems;
use bevy::prelude::*;
use trackwright_design::BodyRole;

const LOOK: GhostLook = GhostLook {
    name: "ghost",
    color: palette::GHOST,
    middle_alpha: 0.16,
    rim_alpha: 0.95,
    hidden_alpha: Some(0.10),
    order_mm: 200.0,
    is_of_design: true,
};

/// The layer.
const LAYER: LayerInfo = LayerInfo {
    stroke: Some(StrokeKey {
        words: "tool as tracked",
        plain_words: "where the tracker sees the tool",
        color: palette::GHOST,
    }),
    ..LayerInfo::new("Ghost", 70, |layers| &mut layers.ghost)
};

/// Draws the ghost while its layer is on.
pub struct GhostPlugin;

/// The design's ghost.
#[derive(Component)]
struct DesignGhost;

/// What it shows.
const ABOUT: &str = "The tool where the tracker measures it, magnified as the errors are";

impl Plugin for GhostPlugin {
    fn build(&self, app: &mut App) {
        app.add_layer(LAYER, ABOUT).add_systems(
            Update,
            show.run_if(crate::layers::tip_error::anything_moved).in_set(EditorSystems::Draw),
        );
    }
}

fn show(errors: ShownErrors, mut ghost: ToolGhost<DesignGhost>) {
    let tool = errors.tool().filter(|_| errors.layers().ghost);
    let mesh = tool.and_then(|_| shown_mesh(&errors.world.0, BodyRole::Tool));
    ghost.show(mesh.as_ref().zip(tool), errors.times(), DesignGhost, &LOOK);
}
