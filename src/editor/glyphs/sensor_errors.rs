//! The position error of each sensor, from where it is to where the tracker says it is.

use super::arrows::{Arrow, ArrowStyle, arrows_mesh};
use super::magnify::ShownErrors;
use crate::editor::materials::GlowMaterial;
use crate::editor::palette;
use crate::editor::state::EditorSystems;
use crate::study::PoseDetail;
use bevy::camera::visibility::NoFrustumCulling;
use bevy::prelude::*;

const STYLE: ArrowStyle = ArrowStyle {
    shaft_px: 2.6,
    head_width_px: 9.0,
    head_length_px: 11.0,
};

/// What shines through is this opaque.
const HIDDEN_ALPHA: f32 = 0.5;
const ORDER_MM: f32 = 15_000.0;

/// Draws sensors' error vectors while their layer is on.
pub struct SensorErrorsPlugin;

#[derive(Component)]
struct SensorErrors;

impl Plugin for SensorErrorsPlugin {
    fn build(&self, app: &mut App) {
        app.add_systems(
            Update,
            show.run_if(super::tip_error::anything_moved)
                .in_set(EditorSystems::Draw),
        );
    }
}

fn show(
    mut commands: Commands,
    errors: ShownErrors,
    drawn: Query<(Entity, &Mesh3d), With<SensorErrors>>,
    mut meshes: ResMut<Assets<Mesh>>,
    mut materials: ResMut<Assets<GlowMaterial>>,
) {
    let mesh = errors
        .pose()
        .filter(|_| errors.layers().sensor_errors)
        .and_then(|pose| arrows_mesh(&arrows(pose, errors.times()), STYLE, &errors.rig));
    let Some(mesh) = mesh else {
        for (entity, _) in &drawn {
            commands.entity(entity).despawn();
        }
        return;
    };
    if let Some((_, handle)) = drawn.iter().next() {
        if let Some(mut old) = meshes.get_mut(&handle.0) {
            *old = mesh;
        }
        return;
    }
    let handle = meshes.add(mesh);
    let color = palette::ERROR_VECTOR.color();
    for material in [
        GlowMaterial::solid(color),
        GlowMaterial::shining_through(color, HIDDEN_ALPHA).order(ORDER_MM),
    ] {
        commands.spawn((
            Name::new("sensor errors"),
            SensorErrors,
            NoFrustumCulling,
            Mesh3d(handle.clone()),
            MeshMaterial3d(materials.add(material)),
        ));
    }
}

/// Of tool and CRF, magnified.
fn arrows(detail: &PoseDetail, times: f64) -> Vec<Arrow> {
    let bodies = std::iter::once(&detail.tool).chain(&detail.crf);
    bodies
        .flat_map(|body| &body.sensors)
        .map(|sensor| {
            let from = sensor.tracker_from_sensor.translation.vector;
            let to = sensor.tracker_from_measured.translation.vector;
            Arrow {
                start_mm: from.into(),
                vector_mm: (to - from) * times,
            }
        })
        .collect()
}
