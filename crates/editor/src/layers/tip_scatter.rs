//! The ellipsoid that holds 95 % of where the tracker's jitter puts the tip, around the ghost's.

use crate::layers::glow_sphere::{GlowSphere, SphereLook};
use crate::layers::legend::{Legend, Legends, StrokeKey};
use crate::layers::magnification::ShownErrors;
use crate::layers::registry::{AddLayer, LayerInfo};
use crate::schedule::EditorSystems;
use crate::{convert, palette};
use bevy::prelude::*;
use nalgebra::{Matrix3, Vector3};
use trackwright_design::BodyRole;
use trackwright_geometry::pose::Pose;

const LOOK: SphereLook = SphereLook {
    name: "tip scatter",
    color: palette::SCATTER,
    alpha: 0.10,
    rim_alpha: 0.9,
    rim: 3.0,
    order_mm: 150.0,
};

/// The layer.
const LAYER: LayerInfo = LayerInfo::new("Tip scatter", 90, |layers| &mut layers.tip_scatter);

const STROKE: StrokeKey = StrokeKey {
    words: "95 % of the tip's jitter",
    plain_words: "95 % of the tip's jitter",
    color: palette::SCATTER,
};

/// Draws the ellipsoid while its layer is on and the room states its jitter.
pub struct TipScatterPlugin;

#[derive(Component)]
struct TipScatter;

/// What it shows.
const ABOUT: &str = "Where the tracker's jitter puts the tip, magnified as the errors are";

impl Plugin for TipScatterPlugin {
    fn build(&self, app: &mut App) {
        app.add_layer(LAYER, ABOUT).add_systems(
            Update,
            show.run_if(crate::layers::tip_error::anything_moved).in_set(EditorSystems::Draw),
        );
    }
}

fn show(errors: ShownErrors, mut ellipsoid: GlowSphere<TipScatter>, mut legends: ResMut<Legends>) {
    let is_known = matches!(errors.results.scatter, Some(Ok(_)));
    let stroke = (is_known && LAYER.is_on(errors.layers())).then_some(STROKE);
    legends.set(LAYER.order, Legend { stroke, ..Legend::default() });
    ellipsoid.show(place(&errors), TipScatter, &LOOK);
}

/// Of the unit sphere: `None` while the layer is off or nothing is known.
fn place(errors: &ShownErrors) -> Option<Transform> {
    if !errors.layers().tip_scatter {
        return None;
    }
    let scatter = errors.results.scatter.as_ref()?.as_ref().ok()?;
    let tool = errors.tool()?;
    let times = errors.times();
    let tracker_from_crf =
        errors.shown.design.tracker_from_body(BodyRole::Crf).unwrap_or_else(Pose::identity);
    let axes_mm = scatter.ellipsoid.semi_axes_in_crf_mm.map(|axis| tracker_from_crf * axis);
    let lengths = axes_mm.map(|axis| axis.norm());
    // A sphere of no size has no axes.
    let unit = |k: usize| axes_mm[k].try_normalize(0.0);
    let turn = match (unit(0), unit(1)) {
        (Some(a), Some(b)) => Matrix3::from_columns(&[a, b, a.cross(&b)]),
        _ => Matrix3::identity(),
    };
    let tip = tool.ghost(times).world_from_body * tool.tip_in_tool;
    Some(convert::ellipsoid(&tip, &turn, &Vector3::from(lengths.map(|length| length * times))))
}
