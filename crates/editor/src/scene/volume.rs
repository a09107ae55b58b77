//! The outline of the tracker's measurement volume with brackets at its corners or rims, and the
//! model's box, dashed.

use crate::document::requests::OpenWorld;
use crate::layers::legend::{LegendKey, Swatch};
use crate::layers::registry::{AddLayer, LayerInfo};
use crate::palette::Theme;
use crate::palette::ThemedColor;
use crate::schedule::EditorSystems;
use crate::{convert, palette};
use bevy::prelude::*;
use nalgebra::Point3;
use trackwright_design::view::Layer;
use trackwright_geometry::bounds::Bounds;
use trackwright_geometry::outline::Outline;
use trackwright_geometry::volume::Volume;
use trackwright_scene::room::is_same_box;

const EDGE_ALPHA: f32 = 0.30;
const BRACKET_ALPHA: f32 = 0.95;
const BOX_ALPHA: f32 = 0.22;

/// The layer.
const LAYER: LayerInfo = LayerInfo {
    is_of_room: true,
    keys: |open| {
        let environment = &open.environment;
        let volume = environment.volume.map(|_| {
            LegendKey::new(Swatch::Line(palette::VOLUME), "measurement volume of the tracker")
        });
        let is_box_drawn = !is_box_of(environment.volume, environment.model.bounds());
        let model = is_box_drawn
            .then(|| LegendKey::new(Swatch::Line(palette::MODEL_BOX), "box of the room's model"));
        volume.into_iter().chain(model).collect()
    },
    ..LayerInfo::new(&Layer::VOLUME)
};

/// Draws both boxes while their layer is on.
pub struct VolumePlugin;

/// What the drawn lines were made for.
#[derive(Component, Clone, Copy, Debug, PartialEq)]
struct VolumeLines {
    volume: Option<Volume>,
    model: Bounds,
    theme: Theme,
}

#[derive(Component)]
struct VolumePart;

impl Plugin for VolumePlugin {
    fn build(&self, app: &mut App) {
        app.add_layer(LAYER).add_systems(
            Update,
            show.run_if(resource_exists::<OpenWorld>).run_if(is_due).in_set(EditorSystems::Draw),
        );
    }
}

fn is_due(world: Res<OpenWorld>, theme: Res<Theme>) -> bool {
    world.is_changed() || theme.is_changed()
}

fn show(
    mut commands: Commands,
    world: Res<OpenWorld>,
    theme: Res<Theme>,
    shown: Query<(Entity, &VolumeLines)>,
    mut gizmos: ResMut<Assets<GizmoAsset>>,
) {
    let environment = &world.0.environment;
    let wanted = world.0.document.view().layers.volume.then(|| VolumeLines {
        volume: environment.volume,
        model: *environment.model.bounds(),
        theme: *theme,
    });
    if shown.iter().next().map(|(_, lines)| *lines) == wanted {
        return;
    }
    for (entity, _) in &shown {
        commands.entity(entity).despawn();
    }
    let Some(wanted) = wanted else { return };
    let mut edges = GizmoAsset::default();
    let mut brackets = GizmoAsset::default();
    if let Some(volume) = wanted.volume {
        let outline = volume.outline();
        for (asset, lines, alpha) in [
            (&mut edges, &outline.lines, EDGE_ALPHA),
            (&mut brackets, &outline.brackets, BRACKET_ALPHA),
        ] {
            let color = palette::VOLUME.color_alpha(alpha);
            for line in lines {
                asset.linestrip(points(line), color);
            }
        }
    }
    let mut model = GizmoAsset::default();
    if !is_box_of(wanted.volume, &wanted.model) {
        let color = palette::MODEL_BOX.color_alpha(BOX_ALPHA);
        for line in Outline::of_box(&wanted.model).lines {
            model.linestrip(points(&line), color);
        }
    }
    let lines = |gizmo, width, style| Gizmo {
        handle: gizmo,
        line_config: GizmoLineConfig { width, style, ..default() },
        ..default()
    };
    let dashed = GizmoLineStyle::Dashed { gap_scale: 5.0, line_scale: 7.0 };
    commands
        .spawn((
            Name::new("measurement volume"),
            wanted,
            lines(gizmos.add(edges), 1.2, GizmoLineStyle::Solid),
            Visibility::default(),
        ))
        .with_children(|parent| {
            parent.spawn((VolumePart, lines(gizmos.add(brackets), 2.6, GizmoLineStyle::Solid)));
            parent.spawn((VolumePart, lines(gizmos.add(model), 1.2, dashed)));
        });
}

/// Whether the volume's outline is that of the model's box, too.
fn is_box_of(volume: Option<Volume>, model: &Bounds) -> bool {
    volume.is_some_and(|volume| is_same_box(&volume, model))
}

fn points(line: &[Point3<f64>]) -> impl Iterator<Item = Vec3> {
    line.iter().map(convert::point)
}
