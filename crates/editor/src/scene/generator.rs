//! The field generator, where the tracker's frame has its origin, and its coils where they are known.

use crate::convert;
use crate::document::requests::OpenWorld;
use crate::layers::legend::{LegendKey, Swatch};
use crate::layers::registry::{AddLayer, LayerInfo};
use crate::palette::{self, Theme, ThemedColor};
use crate::scene::axes::axes_key;
use crate::scene::materials::lit::LitMaterial;
use crate::schedule::EditorSystems;
use bevy::prelude::*;
use trackwright_design::view::Layer;
use trackwright_field::generator::Generator as FieldGenerator;
use trackwright_formats::printable::printable;
use trackwright_scene::coils::coil_lines;

/// The layer.
const LAYER: LayerInfo = LayerInfo {
    keys: |open| {
        let coils = open.generator().map(|generator| {
            let text = format!("coils of {}", printable(&generator.name));
            LegendKey::new(Swatch::Line(palette::COIL), text)
        });
        let own = LegendKey::new(Swatch::Line(palette::GENERATOR), "field generator");
        [own, axes_key()].into_iter().chain(coils).collect()
    },
    ..LayerInfo::new(&Layer::GENERATOR)
};

/// Draws the generator while its layer is on.
pub struct GeneratorPlugin;

#[derive(Component)]
struct Generator;

impl Plugin for GeneratorPlugin {
    fn build(&self, app: &mut App) {
        app.add_layer(LAYER).add_systems(
            Update,
            (
                show.run_if(resource_exists_and_changed::<OpenWorld>),
                show_coils.run_if(resource_exists::<OpenWorld>).run_if(are_coils_due),
            )
                .in_set(EditorSystems::Draw),
        );
    }
}

/// What the lines of the coils were made for.
#[derive(Component, Clone, Debug, PartialEq)]
pub struct CoilLines {
    generator: FieldGenerator,
    theme: Theme,
}

fn are_coils_due(world: Res<OpenWorld>, theme: Res<Theme>) -> bool {
    world.is_changed() || theme.is_changed()
}

fn show_coils(
    mut commands: Commands,
    world: Res<OpenWorld>,
    theme: Res<Theme>,
    shown: Query<(Entity, &CoilLines)>,
    mut gizmos: ResMut<Assets<GizmoAsset>>,
) {
    let is_shown = world.0.document.view().layers.generator;
    let generator = world.0.generator().filter(|_| is_shown);
    for (entity, lines) in &shown {
        if generator == Some(&lines.generator) && lines.theme == *theme {
            return;
        }
        commands.entity(entity).despawn();
    }
    let Some(generator) = generator else { return };
    let mut lines = GizmoAsset::default();
    for line in coil_lines(generator) {
        lines.linestrip(line.iter().map(convert::point), palette::COIL.color());
    }
    commands.spawn((
        Name::new("coils"),
        CoilLines { generator: generator.clone(), theme: *theme },
        Gizmo {
            handle: gizmos.add(lines),
            line_config: GizmoLineConfig { width: COIL_WIDTH_PX, ..default() },
            ..default()
        },
        Visibility::default(),
    ));
}

const COIL_WIDTH_PX: f32 = 1.6;

fn show(
    mut commands: Commands,
    world: Res<OpenWorld>,
    shown: Query<Entity, With<Generator>>,
    mut meshes: ResMut<Assets<Mesh>>,
    mut materials: ResMut<Assets<LitMaterial>>,
) -> Result {
    let is_wanted = world.0.document.view().layers.generator;
    if !is_wanted {
        for entity in &shown {
            commands.entity(entity).despawn();
        }
        return Ok(());
    }
    if !shown.is_empty() {
        return Ok(());
    }
    let mesh = trackwright_project::generator_mesh()?;
    let mut root = commands.spawn((
        Name::new("field generator"),
        Generator,
        Transform::IDENTITY,
        Visibility::default(),
    ));
    for part in &mesh.parts {
        let [r, g, b, _] = part.base_color;
        root.with_child((
            Name::new(part.name.clone()),
            Mesh3d(meshes.add(convert::mesh(part))),
            MeshMaterial3d(materials.add(LitMaterial::new(
                LinearRgba::rgb(r, g, b).into(),
                part.metallic,
                part.roughness,
            ))),
        ));
    }
    Ok(())
}
