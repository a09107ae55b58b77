//! The field generator, where the tracker's frame has its origin.

use crate::convert;
use crate::document::requests::OpenWorld;
use crate::layers::legend::{LegendKey, Swatch};
use crate::layers::registry::{AddLayer, LayerInfo};
use crate::palette;
use crate::scene::axes::axes_key;
use crate::scene::materials::lit::LitMaterial;
use crate::schedule::EditorSystems;
use bevy::prelude::*;

/// The layer.
const LAYER: LayerInfo = LayerInfo {
    keys: |_| vec![LegendKey::new(Swatch::Line(palette::GENERATOR), "field generator"), axes_key()],
    ..LayerInfo::new("Field generator", 20, |layers| &mut layers.generator)
};

/// Draws the generator while its layer is on.
pub struct GeneratorPlugin;

#[derive(Component)]
struct Generator;

/// What it shows.
const ABOUT: &str =
    "The field generator at the origin of the tracker frame, with the tracker's axes";

impl Plugin for GeneratorPlugin {
    fn build(&self, app: &mut App) {
        app.add_layer(LAYER, ABOUT).add_systems(
            Update,
            show.run_if(resource_exists_and_changed::<OpenWorld>).in_set(EditorSystems::Draw),
        );
    }
}

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
