//! The baseline in the scene: its tool as the tracker reports it, in a colour of its own beside the
//! design's ghost, and where its sensors are.

use crate::document::requests::OpenWorld;
use crate::document::shown::ShownDesign;
use crate::layers::legend::{Legend, Legends, StrokeKey};
use crate::layers::magnification::{ShownErrors, ToolErrors};
use crate::scene::body_meshes::{Shapes, paints_in_software};
use crate::scene::materials::glow::{GlowMaterial, Shown};
use crate::scene::screen_size::{ScreenSized, SizeBounds};
use crate::scene::shapes::GlyphShapes;
use crate::schedule::EditorSystems;
use crate::shell::window::Workspace;
use crate::workspaces::decide::against::Against;
use crate::workspaces::decide::state::DecideState;
use crate::{convert, palette};
use bevy::prelude::*;
use bevy::render::renderer::RenderAdapterInfo;

const MIDDLE_ALPHA: f32 = 0.10;
const RIM_ALPHA: f32 = 0.85;
const SENSOR_ALPHA: f32 = 0.9;
/// Behind the design's own ghost.
const ORDER_MM: f32 = 150.0;
/// Over what hides it.
const SENSOR_ORDER_MM: f32 = 18_000.0;
/// A sensor of the baseline, in millimetres and within pixels.
const SENSOR: SizeBounds = SizeBounds { true_mm: 2.5, least_px: 7.0, most_px: 14.0, extra_px: 0.0 };

/// In the legend it comes after the design's own ghost.
const LEGEND_ORDER: u32 = 75;

const STROKE: StrokeKey = StrokeKey {
    words: "baseline as tracked, and its sensors",
    plain_words: "baseline as tracked, and its sensors",
    color: palette::BASELINE,
};

/// Draws the baseline while the workspace is shown.
pub struct BaselineGhostPlugin;

/// The ghost, by the pin that it was made for.
#[derive(Component)]
#[require(Transform, Visibility)]
struct GhostRoot(u64);

/// Where the baseline's sensors are, by the pin that they were made for.
#[derive(Component)]
#[require(Transform, Visibility)]
struct SensorsRoot(u64);

impl Plugin for BaselineGhostPlugin {
    fn build(&self, app: &mut App) {
        app.add_systems(
            Update,
            show.run_if(resource_exists::<OpenWorld>.and_then(resource_exists::<ShownDesign>))
                .run_if(
                    crate::layers::tip_error::anything_moved
                        .or_else(resource_changed::<Against>)
                        .or_else(resource_changed::<DecideState>)
                        .or_else(resource_changed::<Workspace>),
                )
                .in_set(EditorSystems::Draw),
        );
    }
}

fn show(
    mut commands: Commands,
    (errors, state, against, workspace): (
        ShownErrors,
        Res<DecideState>,
        Res<Against>,
        Res<Workspace>,
    ),
    mut ghosts: Query<(Entity, &mut Transform, &GhostRoot), Without<SensorsRoot>>,
    mut sensors: Query<(Entity, &mut Transform, &SensorsRoot), Without<GhostRoot>>,
    mut assets: (ResMut<Assets<Mesh>>, ResMut<Assets<GlowMaterial>>),
    (shapes, adapter): (Res<GlyphShapes>, Option<Res<RenderAdapterInfo>>),
    mut legends: ResMut<Legends>,
) {
    let pinned = workspace.shows_baseline.then_some(state.pinned.as_ref()).flatten();
    legends.set(LEGEND_ORDER, Legend { stroke: pinned.map(|_| STROKE), ..Legend::default() });
    let found = pinned.and_then(|pinned| Some((pinned, against.found(pinned.serial)?.1)));
    let tool = found
        .and_then(|(pinned, found)| Some((pinned, ToolErrors::of(&pinned.design, &found.pose)?)));
    let Some((pinned, tool)) = tool else {
        for entity in ghosts.iter().map(|g| g.0).chain(sensors.iter().map(|s| s.0)) {
            commands.entity(entity).despawn();
        }
        return;
    };
    let ghost_at = convert::transform(&tool.ghost(errors.times()).world_from_body);
    let tool_at = convert::transform(&tool.tracker_from_tool);
    let mut is_drawn = [false; 2];
    for (entity, mut place, root) in &mut ghosts {
        if root.0 == pinned.serial {
            place.set_if_neq(ghost_at);
            is_drawn[0] = true;
        } else {
            commands.entity(entity).despawn();
        }
    }
    for (entity, mut place, root) in &mut sensors {
        if root.0 == pinned.serial {
            place.set_if_neq(tool_at);
            is_drawn[1] = true;
        } else {
            commands.entity(entity).despawn();
        }
    }
    let (meshes, materials) = (&mut assets.0, &mut assets.1);
    if let (false, Some(mesh)) = (is_drawn[0], &pinned.tool_mesh) {
        let look = GlowMaterial::translucent(palette::BASELINE, MIDDLE_ALPHA, RIM_ALPHA);
        let look = materials.add(look.order(ORDER_MM));
        let mut root =
            commands.spawn((Name::new("baseline ghost"), GhostRoot(pinned.serial), ghost_at));
        let is_software = paints_in_software(adapter);
        for part in mesh.parts.iter().filter(|part| !part.is_anatomy()) {
            let shapes = Shapes::of_part(part, meshes, is_software);
            let fine = Mesh3d(shapes.fine.clone());
            root.with_child((fine, shapes, MeshMaterial3d(look.clone())));
        }
    }
    if !is_drawn[1] {
        let look = GlowMaterial::translucent(palette::BASELINE, SENSOR_ALPHA, SENSOR_ALPHA)
            .shown(Shown::Always)
            .order(SENSOR_ORDER_MM);
        let look = materials.add(look);
        let mut root =
            commands.spawn((Name::new("baseline sensors"), SensorsRoot(pinned.serial), tool_at));
        for sensor in &pinned.design.tool.body.rigid.sensors {
            let at_mm = sensor.position_in_body;
            root.with_child((
                Mesh3d(shapes.ball.clone()),
                MeshMaterial3d(look.clone()),
                Transform::from_translation(convert::point(&at_mm)),
                ScreenSized {
                    at_mm: tool.tracker_from_tool * at_mm,
                    across: SENSOR,
                    along: SENSOR,
                },
            ));
        }
    }
}
