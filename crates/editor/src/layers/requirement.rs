//! The sphere of the requirement's radius around the tip, magnified like its error vector, which
//! should end inside.

use crate::document::requests::OpenWorld;
use crate::layers::glow_sphere::{GlowSphere, SphereLook};
use crate::layers::legend::{Legend, LegendKey, Legends, Swatch};
use crate::layers::magnification::{ShownErrors, ShownMagnification, ToolErrors};
use crate::layers::registry::{AddLayer, LayerInfo};
use crate::schedule::EditorSystems;
use crate::widgets::basic::{length, times};
use crate::{convert, palette};
use bevy::prelude::*;

/// The sphere is little more than its outline, so that it hides nothing.
const LOOK: SphereLook = SphereLook {
    name: "requirement",
    color: palette::REQUIREMENT,
    alpha: 0.015,
    rim_alpha: 0.8,
    rim: 5.0,
    order_mm: 100.0,
};

/// A sphere with a larger radius than this share of the view's height would be a frame around
/// everything: the vector ends so deep inside it that it shows nothing.
const LARGEST_SHARE: f64 = 0.6;

/// The layer.
pub const LAYER: LayerInfo =
    LayerInfo::new("Requirement at the tip", 65, |layers| &mut layers.requirement);

/// What it shows.
const ABOUT: &str = "How far off the tip may be: a sphere around it, magnified like its error, which should end inside";

/// Draws the sphere while its layer is on and the design has a limit for single tip errors.
pub struct RequirementPlugin;

#[derive(Component)]
struct RequirementSphere;

impl Plugin for RequirementPlugin {
    fn build(&self, app: &mut App) {
        app.add_layer(LAYER, ABOUT).add_systems(
            Update,
            (
                explain.run_if(
                    resource_exists_and_changed::<OpenWorld>
                        .or_else(resource_changed::<ShownMagnification>),
                ),
                show.run_if(crate::layers::tip_error::anything_moved),
            )
                .in_set(EditorSystems::Draw),
        );
    }
}

/// The limit and its size in the scene.
fn explain(
    world: Option<Res<OpenWorld>>,
    magnification: Res<ShownMagnification>,
    mut legends: ResMut<Legends>,
) {
    let Some(world) = world else { return };
    let document = &world.0.document;
    let requirement = document.design().requirement.filter(|_| LAYER.is_on(document.view().layers));
    let limit = requirement.and_then(|requirement| requirement.single_position_mm());
    let key = limit.map(|(_, limit_mm)| {
        let larger = match magnification.times == 1.0 {
            true => "at true size".to_owned(),
            false => format!("drawn {}× larger", times(magnification.times)),
        };
        let text = format!("the tip may be {} off, {larger}", length(limit_mm));
        LegendKey::new(Swatch::Surface(palette::REQUIREMENT), text)
    });
    let legend = Legend { keys: key.into_iter().collect(), ..Legend::default() };
    legends.set(LAYER.order, legend);
}

fn show(errors: ShownErrors, mut sphere: GlowSphere<RequirementSphere>) {
    sphere.show(place(&errors), RequirementSphere, &LOOK);
}

/// Of the unit sphere: `None` while the layer is off, without a limit, and where it would be a frame.
fn place(errors: &ShownErrors) -> Option<Transform> {
    let tool: ToolErrors = errors.tool().filter(|_| LAYER.is_on(errors.layers()))?;
    let requirement = errors.world.0.document.design().requirement?;
    let radius_mm = requirement.single_position_mm()?.1 * errors.times();
    let tip = tool.tip_mm();
    let radius_px = radius_mm / errors.rig.mm_per_px(&tip);
    (radius_px < LARGEST_SHARE * errors.rig.view_px[1]).then(|| {
        Transform::from_translation(convert::point(&tip))
            .with_scale(Vec3::splat(convert::length(radius_mm)))
    })
}
