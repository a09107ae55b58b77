//! The tracker's axes at its origin, and a ground grid that fades with distance.

use crate::convert;
use crate::document::requests::OpenWorld;
use crate::layers::legend::{LegendKey, Swatch};
use crate::layers::registry::{AddLayer, LayerInfo};
use crate::palette::ThemedColor;
use crate::palette::{self, Theme};
use crate::schedule::EditorSystems;
use bevy::prelude::*;
use trackwright_design::view::Layer;
use trackwright_scene::ground;

/// The layer.
const LAYER: LayerInfo = LayerInfo {
    keys: |_| {
        vec![axes_key(), LegendKey::new(Swatch::Line(palette::GRID), "ground, 50 mm a square")]
    },
    ..LayerInfo::new(&Layer::GRID)
};

/// In the legend of both layers that the axes are drawn with.
pub(crate) fn axes_key() -> LegendKey {
    LegendKey::new(Swatch::Axes(palette::AXES), "tracker's axes x, y, z")
}

/// Draws the grid while its layer is on, and the axes with it or with the generator.
pub struct AxesPlugin;

/// In the colours of a theme.
#[derive(Component)]
struct Ground(Theme);

#[derive(Component)]
struct TrackerAxes(Theme);

impl Plugin for AxesPlugin {
    fn build(&self, app: &mut App) {
        app.add_layer(LAYER).add_systems(
            Update,
            (show_axes, show_grid)
                .run_if(resource_exists::<OpenWorld>)
                .run_if(is_due)
                .in_set(EditorSystems::Draw),
        );
    }
}

fn is_due(world: Res<OpenWorld>, theme: Res<Theme>) -> bool {
    world.is_changed() || theme.is_changed()
}

/// The axes are the tracker's: without its generator and the ground there is nothing that they are of.
fn show_axes(
    mut commands: Commands,
    world: Res<OpenWorld>,
    theme: Res<Theme>,
    drawn: Query<(Entity, &TrackerAxes)>,
    mut gizmos: ResMut<Assets<GizmoAsset>>,
) {
    let layers = world.0.document.view().layers;
    let is_wanted = layers.generator || layers.grid;
    let mut is_shown = false;
    for (entity, axes) in &drawn {
        if is_wanted && axes.0 == *theme {
            is_shown = true;
        } else {
            commands.entity(entity).despawn();
        }
    }
    if !is_wanted || is_shown {
        return;
    }
    let mut axes = GizmoAsset::default();
    for (direction, color) in
        [(Vec3::X, palette::AXIS_X), (Vec3::Y, palette::AXIS_Y), (Vec3::Z, palette::AXIS_Z)]
    {
        axes.arrow(Vec3::ZERO, direction * convert::length(ground::AXIS_LENGTH_MM), color.color())
            .with_tip_length(10.0);
    }
    commands.spawn((
        Name::new("tracker axes"),
        TrackerAxes(*theme),
        Gizmo {
            handle: gizmos.add(axes),
            line_config: GizmoLineConfig { width: 2.5, ..default() },
            depth_bias: -0.002,
        },
    ));
}

fn show_grid(
    mut commands: Commands,
    world: Res<OpenWorld>,
    theme: Res<Theme>,
    shown: Query<(Entity, &Ground)>,
    mut gizmos: ResMut<Assets<GizmoAsset>>,
) {
    let is_wanted = world.0.document.view().layers.grid;
    let mut is_shown = false;
    for (entity, ground) in &shown {
        if is_wanted && ground.0 == *theme {
            is_shown = true;
        } else {
            commands.entity(entity).despawn();
        }
    }
    if is_wanted && !is_shown {
        commands.spawn((
            Name::new("ground"),
            Ground(*theme),
            Gizmo {
                handle: gizmos.add(grid()),
                line_config: GizmoLineConfig { width: 1.0, ..default() },
                ..default()
            },
        ));
    }
}

/// Lines in pieces, each end as faint as it is far from the middle.
fn grid() -> GizmoAsset {
    let mut grid = GizmoAsset::default();
    for line in ground::grid() {
        let [(a, from), (b, to)] =
            line.map(|(at, alpha)| (convert::point(&at), palette::GRID.color_alpha(alpha as f32)));
        grid.line_gradient(a, b, from, to);
    }
    grid
}
