//! The tip's error vector, and the sphere of the requirement's radius that it should end in.

use crate::document::requests::OpenWorld;
use crate::document::shown::ShownDesign;
use crate::layers::arrow_glyphs::{
    Arrow, ArrowStyle, DrawnArrows, ERROR_STROKE, ShineThrough, arrows_mesh,
};
use crate::layers::legend::{Audience, Legend, LegendKey, Legends, Swatch};
use crate::layers::magnification::{ShownErrors, ShownMagnification, ToolErrors};
use crate::layers::registry::{AddLayer, LayerInfo};
use crate::runner::results::Results;
use crate::scene::materials::glow::GlowMaterial;
use crate::scene::shapes::GlyphShapes;
use crate::schedule::EditorSystems;
use crate::viewport::camera::OrbitRig;
use crate::widgets::basic::length;
use crate::{convert, palette};
use bevy::prelude::*;

const HIDDEN: ShineThrough = ShineThrough { alpha: 0.6, order_mm: 16_000.0 };

/// The sphere is little more than its outline, so that it hides nothing.
const SPHERE_ALPHA: f32 = 0.015;
const SPHERE_RIM_ALPHA: f32 = 0.8;
const SPHERE_RIM: f32 = 5.0;

/// A sphere with a larger radius than this share of the view's height would be a frame around
/// everything: the vector ends so deep inside it that it shows nothing.
const LARGEST_SHARE: f64 = 0.6;

/// The layer.
const LAYER: LayerInfo = LayerInfo {
    stroke: Some(ERROR_STROKE),
    ..LayerInfo::new("Tip error", 60, |layers| &mut layers.tip_error)
};

/// In the legend the sphere comes below the slice's hatchings.
const SPHERE_LEGEND_ORDER: u32 = 105;

/// Draws the tip's error while its layer is on.
pub struct TipErrorPlugin;

#[derive(Component, Default)]
struct TipArrow;

/// The sphere, and whether it was drawn for a tip inside it.
#[derive(Component)]
struct RequirementSphere {
    is_met: Option<bool>,
}

/// What it shows.
const ABOUT: &str =
    "The error of the tip as an arrow, magnified, from where it is to where it is measured";

impl Plugin for TipErrorPlugin {
    fn build(&self, app: &mut App) {
        app.add_layer(LAYER, ABOUT).add_systems(
            Update,
            (
                (show_arrow, show_sphere).run_if(anything_moved),
                explain_sphere.run_if(resource_exists_and_changed::<OpenWorld>),
            )
                .in_set(EditorSystems::Draw),
        );
    }
}

/// What the sphere around the tip means, in plain words; to people who design it is plain.
fn explain_sphere(world: Res<OpenWorld>, mut legends: ResMut<Legends>) {
    let document = &world.0.document;
    let requirement = document.design().requirement.filter(|_| LAYER.is_on(document.view().layers));
    let limit = requirement.and_then(|requirement| requirement.single_position_mm());
    let key = limit.map(|(_, limit_mm)| LegendKey {
        swatch: Swatch::Surface(palette::MET),
        text: format!("at most {} off, drawn as large", length(limit_mm)),
        audience: Audience::Slides,
    });
    let legend = Legend { keys: key.into_iter().collect(), ..Legend::default() };
    legends.set(SPHERE_LEGEND_ORDER, legend);
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
    let mesh = of_tip(&errors).and_then(|tip| {
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

fn show_sphere(
    mut commands: Commands,
    errors: ShownErrors,
    mut drawn: Query<(Entity, &mut Transform, &RequirementSphere)>,
    shapes: Res<GlyphShapes>,
    mut materials: ResMut<Assets<GlowMaterial>>,
) {
    let requirement = errors.world.0.document.design().requirement;
    let times = errors.times();
    let wanted = of_tip(&errors)
        .zip(requirement.and_then(|r| Some(r.single_position_mm()?.1)))
        .filter(|(tip, radius_mm)| {
            let radius_px = radius_mm * times / errors.rig.mm_per_px(&tip.tip_mm());
            radius_px < LARGEST_SHARE * errors.rig.view_px[1]
        });
    let Some((tip, radius_mm)) = wanted else {
        for (entity, ..) in &drawn {
            commands.entity(entity).despawn();
        }
        return;
    };
    let reported = tip.tracker_from_tool_reported * tip.tip_in_tool;
    let is_met = requirement.and_then(|r| r.met_by_single((reported - tip.tip_mm()).norm()));
    let place = Transform::from_translation(convert::point(&tip.tip_mm()))
        .with_scale(Vec3::splat(convert::length(radius_mm * times)));
    if let Some((entity, mut transform, sphere)) = drawn.iter_mut().next() {
        if sphere.is_met == is_met {
            transform.set_if_neq(place);
            return;
        }
        commands.entity(entity).despawn();
    }
    // One pose has no verdict against a bound on an RMS.
    let color = match is_met {
        Some(true) => palette::MET,
        Some(false) => palette::MISSED,
        None => palette::TEXT_QUIET,
    };
    let material = GlowMaterial::translucent(color, SPHERE_ALPHA, SPHERE_RIM_ALPHA)
        .rim(SPHERE_RIM)
        .order(100.0);
    commands.spawn((
        Name::new("requirement"),
        RequirementSphere { is_met },
        Mesh3d(shapes.sphere.clone()),
        MeshMaterial3d(materials.add(material)),
        place,
    ));
}

/// `None` while the layer is off or nothing is known.
fn of_tip(errors: &ShownErrors) -> Option<ToolErrors> {
    errors.tool().filter(|_| errors.layers().tip_error)
}
