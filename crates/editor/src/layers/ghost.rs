//! The tool as the tracker reports it: translucent, with a bright rim.

use crate::layers::legend::{Legend, Legends, StrokeKey};
use crate::layers::magnification::{ShownErrors, anything_moved};
use crate::layers::registry::{AddLayer, LayerInfo};
use crate::layers::tool_ghost::{GhostLook, ToolGhost};
use crate::palette;
use crate::scene::bodies::shown_mesh;
use crate::schedule::EditorSystems;
use bevy::prelude::*;
use trackwright_design::BodyRole;
use trackwright_design::view::Layer;

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
const LAYER: LayerInfo = LayerInfo::new(&Layer::GHOST);

const WORDS: &str = "tool as tracked";
const PLAIN_WORDS: &str = "where the tracker sees the tool";

/// Draws the ghost while its layer is on.
pub struct GhostPlugin;

/// The design's ghost.
#[derive(Component)]
struct DesignGhost;

impl Plugin for GhostPlugin {
    fn build(&self, app: &mut App) {
        app.add_layer(LAYER)
            .add_systems(Update, show.run_if(anything_moved).in_set(EditorSystems::Draw));
    }
}

fn show(errors: ShownErrors, mut ghost: ToolGhost<DesignGhost>, mut legends: ResMut<Legends>) {
    let is_on = LAYER.is_on(errors.layers());
    let stroke = is_on.then(|| StrokeKey::new(palette::GHOST, WORDS, PLAIN_WORDS));
    legends.set(LAYER.row.order, Legend { stroke, ..Legend::default() });
    let tool = errors.tool().filter(|_| is_on);
    let mesh = tool.and_then(|_| shown_mesh(&errors.world.0, BodyRole::Tool));
    ghost.show(mesh.as_ref().zip(tool), errors.times(), DesignGhost, &LOOK);
}
