//! The baseline in the scene: its tool as the tracker reports it, in a colour of its own beside the
//! design's ghost, and where its sensors are.

use crate::document::requests::OpenWorld;
use crate::document::shown::ShownDesign;
use crate::layers::legend::{Legend, Legends, StrokeKey};
use crate::layers::magnification::{ShownErrors, anything_moved};
use crate::layers::tool_ghost::{GhostLook, ToolGhost};
use crate::scene::materials::glow::{GlowMaterial, Shown};
use crate::scene::screen_size::{ScreenSized, SizeBounds};
use crate::scene::shapes::GlyphShapes;
use crate::schedule::EditorSystems;
use crate::shell::window::Workspace;
use crate::workspaces::decide::against::Against;
use crate::workspaces::decide::state::{DecideState, Pinned};
use crate::{convert, palette};
use bevy::ecs::system::SystemParam;
use bevy::prelude::*;
use trackwright_design::view::Layer;
use trackwright_scene::tool_errors::ToolErrors;

const LOOK: GhostLook = GhostLook {
    name: "baseline ghost",
    color: palette::BASELINE,
    middle_alpha: 0.10,
    rim_alpha: 0.85,
    hidden_alpha: None,
    // Behind the design's own ghost.
    order_mm: 150.0,
    is_of_design: false,
};

const SENSOR_ALPHA: f32 = 0.9;
/// Over what hides it.
const SENSOR_ORDER_MM: f32 = 18_000.0;
/// A sensor of the baseline, in millimetres and within pixels.
const SENSOR: SizeBounds = SizeBounds { true_mm: 2.5, least_px: 7.0, most_px: 14.0, extra_px: 0.0 };

/// In the legend it comes after the design's own ghost.
const LEGEND_ORDER: u32 = Layer::GHOST.order + 5;

const WORDS: &str = "baseline as tracked, and its sensors";

/// Draws the baseline while the workspace is shown.
pub struct BaselineGhostPlugin;

/// The baseline's ghost.
#[derive(Component)]
struct BaselineGhost;

/// Where the baseline's sensors are, by the pin that they were made for.
#[derive(Component)]
#[require(Transform, Visibility)]
struct SensorsRoot(u64);

/// What is drawn of the baseline.
#[derive(SystemParam)]
struct ShownBaseline<'w> {
    errors: ShownErrors<'w>,
    state: Res<'w, DecideState>,
    against: Res<'w, Against>,
    workspace: Res<'w, Workspace>,
}

impl ShownBaseline<'_> {
    /// Whether or not anything is known of it.
    fn pinned(&self) -> Option<&Pinned> {
        self.state.pinned.as_ref().filter(|_| self.workspace.shows_baseline)
    }

    /// Its tool once it was simulated in the design's room.
    fn tool(&self) -> Option<(&Pinned, ToolErrors)> {
        let pinned = self.pinned()?;
        let (_, found) = self.against.found(pinned.serial)?;
        Some((pinned, ToolErrors::of(&pinned.design, &found.pose)))
    }
}

impl Plugin for BaselineGhostPlugin {
    fn build(&self, app: &mut App) {
        app.add_systems(
            Update,
            (show_ghost, show_sensors)
                .run_if(resource_exists::<OpenWorld>.and_then(resource_exists::<ShownDesign>))
                .run_if(
                    anything_moved
                        .or_else(resource_changed::<Against>)
                        .or_else(resource_changed::<DecideState>)
                        .or_else(resource_changed::<Workspace>),
                )
                .in_set(EditorSystems::Draw),
        );
    }
}

fn show_ghost(
    baseline: ShownBaseline,
    mut ghost: ToolGhost<BaselineGhost>,
    mut legends: ResMut<Legends>,
) {
    let stroke = baseline.pinned().map(|_| StrokeKey::new(palette::BASELINE, WORDS, WORDS));
    legends.set(LEGEND_ORDER, Legend { stroke, ..Legend::default() });
    let tool = baseline.tool();
    let tool = tool.and_then(|(pinned, tool)| Some((pinned.tool_mesh.as_ref()?, tool)));
    ghost.show(tool, baseline.errors.times(), BaselineGhost, &LOOK);
}

fn show_sensors(
    mut commands: Commands,
    baseline: ShownBaseline,
    mut roots: Query<(Entity, &mut Transform, &SensorsRoot)>,
    shapes: Res<GlyphShapes>,
    mut materials: ResMut<Assets<GlowMaterial>>,
) {
    let Some((pinned, tool)) = baseline.tool() else {
        for (entity, ..) in &roots {
            commands.entity(entity).despawn();
        }
        return;
    };
    let place = convert::transform(&tool.tracker_from_tool);
    if let Some((entity, mut transform, root)) = roots.iter_mut().next() {
        if root.0 == pinned.serial {
            transform.set_if_neq(place);
            return;
        }
        commands.entity(entity).despawn();
    }
    let look = GlowMaterial::translucent(palette::BASELINE, SENSOR_ALPHA, SENSOR_ALPHA)
        .shown(Shown::Always)
        .order(SENSOR_ORDER_MM);
    let look = materials.add(look);
    let mut root =
        commands.spawn((Name::new("baseline sensors"), SensorsRoot(pinned.serial), place));
    for sensor in &pinned.design.tool.body.rigid.sensors {
        let at_mm = sensor.position_in_body;
        root.with_child((
            Mesh3d(shapes.ball.clone()),
            MeshMaterial3d(look.clone()),
            Transform::from_translation(convert::point(&at_mm)),
            ScreenSized { at_mm: tool.tracker_from_tool * at_mm, across: SENSOR, along: SENSOR },
        ));
    }
}
