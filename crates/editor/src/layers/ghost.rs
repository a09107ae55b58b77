//! The tool as the tracker reports it: translucent, with a bright rim.

use crate::layers::legend::StrokeKey;
use crate::layers::magnification::ShownErrors;
use crate::layers::registry::{AddLayer, LayerInfo};
use crate::scene::bodies::shown_mesh;
use crate::scene::body_meshes::paints_in_software;
use crate::scene::body_meshes::{BodyMeshes, is_same_mesh};
use crate::scene::materials::glow::GlowMaterial;
use crate::schedule::EditorSystems;
use crate::{convert, palette};
use bevy::prelude::*;
use bevy::render::renderer::RenderAdapterInfo;
use std::sync::Arc;
use trackwright_design::BodyRole;
use trackwright_geometry::mesh::SurfaceMesh;

const MIDDLE_ALPHA: f32 = 0.16;
const RIM_ALPHA: f32 = 0.95;
const HIDDEN_ALPHA: f32 = 0.10;
const ORDER_MM: f32 = 200.0;

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

/// The ghost, and the mesh that it was made from.
#[derive(Component)]
#[require(Transform, Visibility)]
struct GhostRoot(Arc<SurfaceMesh>);

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

fn show(
    mut commands: Commands,
    errors: ShownErrors,
    mut ghosts: Query<(Entity, &mut Transform, &GhostRoot)>,
    mut made: ResMut<BodyMeshes>,
    mut meshes: ResMut<Assets<Mesh>>,
    mut materials: ResMut<Assets<GlowMaterial>>,
    adapter: Option<Res<RenderAdapterInfo>>,
) {
    let tool = errors.tool().filter(|_| errors.layers().ghost);
    let mesh = tool.and_then(|_| shown_mesh(&errors.world.0, BodyRole::Tool));
    let (Some(tool), Some(mesh)) = (tool, &mesh) else {
        for (entity, ..) in &ghosts {
            commands.entity(entity).despawn();
        }
        return;
    };
    let place = convert::transform(&tool.ghost(errors.times()).world_from_body);
    if let Some((entity, mut transform, made_from)) = ghosts.iter_mut().next() {
        if is_same_mesh(&made_from.0, mesh) {
            transform.set_if_neq(place);
            return;
        }
        commands.entity(entity).despawn();
    }
    let color = palette::GHOST;
    let looks = [
        GlowMaterial::translucent(color, MIDDLE_ALPHA, RIM_ALPHA).order(ORDER_MM),
        GlowMaterial::shining_through(color, HIDDEN_ALPHA).order(ORDER_MM),
    ]
    .map(|material| materials.add(material));
    let mut root = commands.spawn((Name::new("ghost"), GhostRoot(Arc::clone(mesh)), place));
    let is_software = paints_in_software(adapter);
    for (part, shapes) in made.of(BodyRole::Tool, mesh, &mut meshes, is_software) {
        if part.is_anatomy() {
            continue;
        }
        for look in &looks {
            root.with_child((
                Mesh3d(shapes.fine.clone()),
                shapes.clone(),
                MeshMaterial3d(look.clone()),
            ));
        }
    }
}
