//! Edges of the tracker's measurement volume with brackets at its corners, and the model's box.

use crate::editor::palette::Theme;
use crate::editor::state::{EditorSystems, OpenWorld};
use crate::editor::{convert, palette};
use crate::geometry::bounds::Bounds;
use bevy::prelude::*;
use nalgebra::Point3;

/// How much of each edge a bracket covers.
const BRACKET_SHARE: f64 = 0.09;

const EDGE_ALPHA: f32 = 0.30;
const BRACKET_ALPHA: f32 = 0.95;
const BOX_ALPHA: f32 = 0.22;

/// Draws both boxes while their layer is on.
pub struct VolumePlugin;

/// What the drawn lines were made for.
#[derive(Component, Clone, Copy, Debug, PartialEq)]
struct VolumeLines {
    volume: Option<Bounds>,
    model: Bounds,
    theme: Theme,
}

#[derive(Component)]
struct VolumePart;

impl Plugin for VolumePlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<Theme>().add_systems(
            Update,
            show.run_if(resource_exists::<OpenWorld>)
                .run_if(is_due)
                .in_set(EditorSystems::Draw),
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
        volume: environment.volume.map(|volume| volume.bounds()),
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
        let color = palette::VOLUME.color_alpha(EDGE_ALPHA);
        for [a, b] in edges_mm(&volume) {
            edges.line(convert::point(&a), convert::point(&b), color);
            for (corner, other) in [(a, b), (b, a)] {
                let end = corner + (other - corner) * BRACKET_SHARE;
                let color = palette::VOLUME.color_alpha(BRACKET_ALPHA);
                brackets.line(convert::point(&corner), convert::point(&end), color);
            }
        }
    }
    let mut model = GizmoAsset::default();
    if wanted.volume != Some(wanted.model) {
        for [a, b] in edges_mm(&wanted.model) {
            let color = palette::MODEL_BOX.color_alpha(BOX_ALPHA);
            model.line(convert::point(&a), convert::point(&b), color);
        }
    }
    let lines = |gizmo, width| Gizmo {
        handle: gizmo,
        line_config: GizmoLineConfig { width, ..default() },
        ..default()
    };
    commands
        .spawn((
            Name::new("measurement volume"),
            wanted,
            lines(gizmos.add(edges), 1.2),
            Visibility::default(),
        ))
        .with_children(|parent| {
            parent.spawn((VolumePart, lines(gizmos.add(brackets), 2.6)));
            parent.spawn((VolumePart, lines(gizmos.add(model), 1.0)));
        });
}

/// The twelve edges of a box.
fn edges_mm(bounds: &Bounds) -> Vec<[Point3<f64>; 2]> {
    let corners = bounds.corners_mm();
    (0..8usize)
        .flat_map(|i| {
            [1, 2, 4]
                .into_iter()
                .filter(move |bit| i & bit == 0)
                .map(move |bit| [i, i | bit])
        })
        .map(|[i, j]| [corners[i], corners[j]])
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_box_has_twelve_edges_along_its_axes() {
        let edges = edges_mm(&Bounds::from(([0.0; 3], [1.0, 2.0, 3.0])));
        assert_eq!(edges.len(), 12);
        let total: f64 = edges.iter().map(|[a, b]| (b - a).norm()).sum();
        assert_eq!(total, 4.0 * (1.0 + 2.0 + 3.0));
    }
}
