//! The metal that was found in the measurements, in the 3D view while the workspace is shown: of each body that is
//! determined a sphere of the equivalent radius, with a cross of the 95 % intervals of its middle.

use crate::convert;
use crate::layers::legend::{Legend, LegendKey, Legends, Swatch};
use crate::palette::{self, Theme, ThemedColor};
use crate::scene::materials::glow::GlowMaterial;
use crate::scene::shapes::GlyphShapes;
use crate::schedule::EditorSystems;
use crate::shell::window::{SceneLabel, SceneLabels, Workspace};
use crate::workspaces::field::metal::FoundMetal;
use crate::workspaces::field::requests::WORKSPACE;
use crate::workspaces::field::state::FieldState;
use bevy::picking::Pickable;
use bevy::prelude::*;
use std::sync::Arc;
use trackwright_design::view::Layer;
use trackwright_metal::identify::{FoundBody, KnownBody};
use trackwright_report::found_metal::kind_name;

/// In the legend it comes after places found for sensors.
const LEGEND_ORDER: u32 = Layer::PLACEMENT.order + 3;

/// Behind other translucent things.
const ORDER_MM: f32 = -200.0;
/// Opacity of middle and rim.
const ALPHAS: [f32; 2] = [0.25, 0.9];
const RIM: f32 = 2.5;
const CROSS_PX: f32 = 2.0;
/// In front of the sphere.
const CROSS_BIAS: f32 = -1.0;
/// A longer interval, or one of no known length, has no line: it leaves the view.
const MOST_HALF_MM: f64 = 1_000.0;

/// Draws the bodies in [`EditorSystems::Draw`]; needs [`FieldState`].
pub struct FoundBodiesPlugin;

/// The bodies of one search, and what they were drawn for.
#[derive(Component)]
#[require(Transform, Visibility)]
struct FoundBodies {
    metal: Arc<FoundMetal>,
    theme: Theme,
}

impl Plugin for FoundBodiesPlugin {
    fn build(&self, app: &mut App) {
        app.add_systems(
            Update,
            draw.run_if(
                resource_changed::<FieldState>
                    .or_else(resource_changed::<Workspace>)
                    .or_else(resource_changed::<Theme>),
            )
            .run_if(is_any)
            .in_set(EditorSystems::Draw),
        );
    }
}

/// Whether there is anything to draw, or to take away.
fn is_any(state: Res<FieldState>, drawn: Query<(), With<FoundBodies>>) -> bool {
    state.metal.found.is_some() || !drawn.is_empty()
}

fn draw(
    mut commands: Commands,
    (state, workspace, theme): (Res<FieldState>, Res<Workspace>, Res<Theme>),
    drawn: Query<(Entity, &FoundBodies)>,
    shapes: Res<GlyphShapes>,
    (mut materials, mut gizmos): (ResMut<Assets<GlowMaterial>>, ResMut<Assets<GizmoAsset>>),
    (mut legends, mut labels): (ResMut<Legends>, ResMut<SceneLabels>),
) {
    let found = state.metal.found.as_ref();
    let wanted =
        found.filter(|metal| *workspace == WORKSPACE && metal.found.determined().next().is_some());
    for (entity, bodies) in &drawn {
        let is_same = wanted.is_some_and(|metal| Arc::ptr_eq(metal, &bodies.metal));
        if is_same && bodies.theme == *theme {
            return;
        }
        commands.entity(entity).despawn();
    }
    // Numbered as in the panel.
    let bodies = wanted.map_or(&[][..], |metal| &metal.found.bodies);
    let key = wanted.map(|_| {
        let words = "metal found, a sphere like it; its cross: 95 % intervals";
        LegendKey::new(Swatch::Ball(palette::FOUND_METAL), words)
    });
    legends.set(LEGEND_ORDER, Legend { keys: key.into_iter().collect(), ..Legend::default() });
    labels.set_if_neq(SceneLabels((1..).zip(bodies).filter_map(label).collect()));
    let Some(metal) = wanted else { return };
    let [middle, rim] = ALPHAS;
    let look = GlowMaterial::translucent(palette::FOUND_METAL, middle, rim);
    let look = materials.add(look.rim(RIM).order(ORDER_MM));
    let drawn = FoundBodies { metal: Arc::clone(metal), theme: *theme };
    let mut root = commands.spawn((Name::new("found metal"), drawn));
    for body in bodies {
        let Ok(known) = &body.known else { continue };
        let at = Transform::from_translation(convert::point(&body.source.center_mm));
        root.with_child((
            Name::new("found body"),
            Pickable::IGNORE,
            Mesh3d(shapes.sphere.clone()),
            MeshMaterial3d(look.clone()),
            at.with_scale(Vec3::splat(convert::length(body.source.radius_mm()))),
        ));
        root.with_child((
            Name::new("found interval"),
            Gizmo {
                handle: gizmos.add(cross(body, known)),
                line_config: GizmoLineConfig { width: CROSS_PX, ..default() },
                depth_bias: CROSS_BIAS,
            },
            Visibility::default(),
        ));
    }
}

/// A line along each axis from one end of the interval to the other.
fn cross(body: &FoundBody, known: &KnownBody) -> GizmoAsset {
    let mut lines = GizmoAsset::default();
    for (axis, interval) in known.center_mm.iter().enumerate() {
        let half_mm = interval.half_length();
        if !half_mm.is_finite() || half_mm > MOST_HALF_MM {
            continue;
        }
        let end = |value_mm: f64| {
            let mut end_mm = body.source.center_mm;
            end_mm[axis] = value_mm;
            convert::point(&end_mm)
        };
        lines.line(end(interval.low), end(interval.high), palette::FOUND_METAL.color());
    }
    lines
}

fn label((number, body): (usize, &FoundBody)) -> Option<SceneLabel> {
    body.known.is_ok().then(|| SceneLabel {
        at_mm: body.source.center_mm,
        text: format!("{number} {}", kind_name(body.kind)),
        color: palette::FOUND_METAL,
    })
}
