//! A recording pose by pose: the built tool where it was measured, beside the ghost that is predicted.

use crate::document::requests::OpenWorld;
use crate::document::shown::ShownDesign;
use crate::document::trials::{ModeKind, TrialChoice};
use crate::layers::legend::{Legend, Legends, StrokeKey};
use crate::layers::magnification::{ShownErrors, ToolErrors};
use crate::scene::bodies::shown_mesh;
use crate::scene::body_meshes::{BodyMeshes, is_same_mesh, paints_in_software};
use crate::scene::materials::glow::GlowMaterial;
use crate::schedule::EditorSystems;
use crate::{convert, palette};
use bevy::prelude::*;
use bevy::render::renderer::RenderAdapterInfo;
use std::sync::Arc;
use trackwright_design::BodyRole;
use trackwright_geometry::mesh::SurfaceMesh;
use trackwright_geometry::pose::Pose;

const MIDDLE_ALPHA: f32 = 0.12;
const RIM_ALPHA: f32 = 0.9;
/// Behind the design's own ghost.
const ORDER_MM: f32 = 175.0;

/// In the legend it comes after the design's own ghost.
const LEGEND_ORDER: u32 = 72;

const STROKE: StrokeKey = StrokeKey {
    words: "tool as measured",
    plain_words: "where the built tool was measured",
    color: palette::MEASURED,
};

/// Draws the measured tool while a recorded pose is shown.
pub struct MeasuredGhostPlugin;

/// The ghost, and the mesh that it was made from.
#[derive(Component)]
#[require(Transform, Visibility)]
struct GhostRoot(Arc<SurfaceMesh>);

impl Plugin for MeasuredGhostPlugin {
    fn build(&self, app: &mut App) {
        app.add_systems(
            Update,
            show.run_if(resource_exists::<OpenWorld>.and_then(resource_exists::<ShownDesign>))
                .run_if(
                    crate::layers::tip_error::anything_moved
                        .or_else(resource_exists_and_changed::<TrialChoice>),
                )
                .in_set(EditorSystems::Draw),
        );
    }
}

fn show(
    mut commands: Commands,
    (errors, choice): (ShownErrors, Res<TrialChoice>),
    mut ghosts: Query<(Entity, &mut Transform, &GhostRoot)>,
    (mut made, mut meshes): (ResMut<BodyMeshes>, ResMut<Assets<Mesh>>),
    mut materials: ResMut<Assets<GlowMaterial>>,
    adapter: Option<Res<RenderAdapterInfo>>,
    mut legends: ResMut<Legends>,
) {
    let tool = measured_tool(&errors, &choice);
    let mesh = tool.and_then(|_| shown_mesh(&errors.world.0, BodyRole::Tool));
    let stroke = mesh.as_ref().map(|_| STROKE);
    legends.set(LEGEND_ORDER, Legend { stroke, ..Legend::default() });
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
    let look = GlowMaterial::translucent(palette::MEASURED, MIDDLE_ALPHA, RIM_ALPHA);
    let look = materials.add(look.order(ORDER_MM));
    let mut root =
        commands.spawn((Name::new("measured ghost"), GhostRoot(Arc::clone(mesh)), place));
    let is_software = paints_in_software(adapter);
    for (part, shapes) in made.of(BodyRole::Tool, mesh, &mut meshes, is_software) {
        if part.is_anatomy() {
            continue;
        }
        root.with_child((
            Mesh3d(shapes.fine.clone()),
            shapes.clone(),
            MeshMaterial3d(look.clone()),
        ));
    }
}

/// The built tool at the recorded pose that is shown; `None` where none is, or where its measured pose
/// is not known.
fn measured_tool(errors: &ShownErrors, choice: &TrialChoice) -> Option<ToolErrors> {
    let trial = errors.shown.trial.as_ref().filter(|trial| trial.kind == ModeKind::Input)?;
    let has_motion = errors.world.0.document.design().motion.is_some();
    let measured = choice.measured(has_motion)?.get(trial.number)?.crf_from_tool?;
    let design = &errors.shown.design;
    let tracker_from_crf = design.tracker_from_body(BodyRole::Crf).unwrap_or_else(Pose::identity);
    Some(ToolErrors {
        tracker_from_tool: tracker_from_crf * design.tool.crf_from_tool,
        tracker_from_tool_reported: tracker_from_crf * measured,
        tip_in_tool: design.body(BodyRole::Tool)?.rigid.judged_tip_in_body(),
    })
}
