//! The tip's error vector.

use crate::document::requests::OpenWorld;
use crate::document::shown::ShownDesign;
use crate::layers::arrow_glyphs::{
    Arrow, ArrowStyle, DrawnArrows, ERROR_STROKE, ShineThrough, arrows_mesh,
};
use crate::layers::magnification::{ShownErrors, ShownMagnification, ToolErrors};
use crate::layers::registry::{AddLayer, LayerInfo};
use crate::runner::results::Results;
use crate::schedule::EditorSystems;
use crate::viewport::camera::OrbitRig;
use bevy::prelude::*;

const HIDDEN: ShineThrough = ShineThrough { alpha: 0.6, order_mm: 16_000.0 };

/// The layer.
const LAYER: LayerInfo = LayerInfo {
    stroke: Some(ERROR_STROKE),
    ..LayerInfo::new("Tip error", 60, |layers| &mut layers.tip_error)
};

/// Draws the tip's error while its layer is on.
pub struct TipErrorPlugin;

#[derive(Component, Default)]
struct TipArrow;

/// What it shows.
const ABOUT: &str =
    "The error of the tip as an arrow, magnified, from where it is to where it is measured";

impl Plugin for TipErrorPlugin {
    fn build(&self, app: &mut App) {
        app.add_layer(LAYER, ABOUT)
            .add_systems(Update, show_arrow.run_if(anything_moved).in_set(EditorSystems::Draw));
    }
}

/// Whether glyphs may look different from before.
pub fn anything_moved(
    world: Option<Res<OpenWorld>>,
    design: Option<Res<ShownDesign>>,
    results: Res<Results>,
    magnification: Res<ShownMagnification>,
    rig: Res<OrbitRig>,
) -> bool {
    world.is_some_and(|world| world.is_changed())
        || design.is_some_and(|design| design.is_changed())
        || results.is_changed()
        || magnification.is_changed()
        || rig.is_changed()
}

fn show_arrow(errors: ShownErrors, mut drawn: DrawnArrows<TipArrow>) {
    let tool = errors.tool().filter(|_| errors.layers().tip_error);
    let mesh = tool.and_then(|tip| {
        arrows_mesh(&[tip_arrow(&tip, errors.times())], ArrowStyle::OF_TIP, &errors.rig)
    });
    drawn.show("tip error", mesh, HIDDEN);
}

/// From the tip to the ghost's.
fn tip_arrow(errors: &ToolErrors, times: f64) -> Arrow {
    let start_mm = errors.tip_mm();
    let end_mm = errors.ghost(times).world_from_body * errors.tip_in_tool;
    Arrow { start_mm, vector_mm: end_mm - start_mm }
}
