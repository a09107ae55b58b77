//! The metal of the room: each object where it is, in the colour of its material, or in that of a problem
//! where it cannot be simulated.

use crate::convert;
use crate::document::requests::OpenWorld;
use crate::document::shown::ShownDesign;
use crate::palette::{self, Rgb, Theme, ThemedColor};
use crate::scene::body_meshes::{Shapes, paints_in_software};
use crate::scene::materials::lit::LitMaterial;
use crate::schedule::EditorSystems;
use bevy::prelude::*;
use bevy::render::renderer::RenderAdapterInfo;
use trackwright_metal::furnished::FurnishError;
use trackwright_metal::setup::{MetalObject, ObjectShape};
use trackwright_scene::{MetalLook, look_of_metal};

/// Draws the room's metal.
pub struct MetalScenePlugin;

/// The entity of a metal object, by its place in the room's list: its transform is the object's pose in
/// the tracker frame.
#[derive(Component, Clone, Copy, Debug, PartialEq, Eq)]
#[require(Transform, Visibility)]
pub struct MetalRoot(pub usize);

/// What its entities were made from.
#[derive(Component, Clone, Debug, PartialEq)]
struct MadeFrom {
    name: String,
    shape: ObjectShape,
    look: MetalLook,
    theme: Theme,
}

impl Plugin for MetalScenePlugin {
    fn build(&self, app: &mut App) {
        app.add_systems(
            Update,
            draw_metal
                .run_if(resource_exists::<OpenWorld>)
                .run_if(resource_exists::<ShownDesign>)
                .run_if(is_due)
                .in_set(EditorSystems::Draw),
        );
    }
}

/// What an object is marked with that cannot be simulated.
pub(crate) const PROBLEM: Rgb = palette::OUTSIDE;

/// Whether a problem of the room's metal is that of an object, or of the room as a whole.
pub(crate) fn has_problem(problem: Option<&FurnishError>, name: &str) -> bool {
    problem.is_some_and(|problem| {
        let objects = problem.objects();
        objects.is_empty() || objects.contains(&name)
    })
}

/// The colour of an object in the scene.
fn look_of(object: &MetalObject, problem: Option<&FurnishError>) -> MetalLook {
    let look = look_of_metal(&object.material);
    match has_problem(problem, &object.name) {
        true => MetalLook { color: PROBLEM, ..look },
        false => look,
    }
}

/// A solved room changes the marks of its objects.
fn is_due(world: Res<OpenWorld>, shown: Res<ShownDesign>, theme: Res<Theme>) -> bool {
    world.is_changed() || shown.is_changed() || theme.is_changed()
}

fn draw_metal(
    mut commands: Commands,
    (world, shown, theme): (Res<OpenWorld>, Res<ShownDesign>, Res<Theme>),
    mut roots: Query<(Entity, &MetalRoot, &MadeFrom, &mut Transform)>,
    (mut meshes, mut materials): (ResMut<Assets<Mesh>>, ResMut<Assets<LitMaterial>>),
    adapter: Option<Res<RenderAdapterInfo>>,
) {
    let objects = shown.design.room_metal.as_ref().map_or(&[][..], |metal| &metal.objects);
    let problem = world.0.metal_problem().map(|problem| &**problem);
    let hidden = &world.0.document.view().hidden;
    let wanted = |index: usize| {
        let object = objects.get(index).filter(|object| !hidden.has_metal(&object.name))?;
        let made_from = MadeFrom {
            name: object.name.clone(),
            shape: object.shape.clone(),
            look: look_of(object, problem),
            theme: *theme,
        };
        Some((made_from, convert::transform(&object.tracker_from_object)))
    };
    let mut is_there = vec![false; objects.len()];
    for (entity, root, made_from, mut transform) in &mut roots {
        match wanted(root.0).filter(|(wanted, _)| wanted == made_from) {
            Some((_, at)) => {
                transform.set_if_neq(at);
                is_there[root.0] = true;
            }
            None => commands.entity(entity).despawn(),
        }
    }
    let is_software = paints_in_software(adapter);
    for index in (0..objects.len()).filter(|index| !is_there[*index]) {
        let Some((made_from, at)) = wanted(index) else { continue };
        // What has no shape, which the design refuses, is not drawn.
        let Ok(mesh) = made_from.shape.drawn() else { continue };
        let MetalLook { color, metallic, roughness } = made_from.look;
        let (metallic, roughness) = (metallic as f32, roughness as f32);
        let material = materials.add(LitMaterial::new(color.color(), metallic, roughness));
        let shapes = Shapes::of_parts(&mesh, &mut meshes, is_software);
        let name = Name::new(format!("metal {}", made_from.name));
        let mut root = commands.spawn((name, MetalRoot(index), made_from, at));
        for (part, shapes) in mesh.parts.iter().zip(shapes) {
            root.with_child((
                Name::new(part.name.clone()),
                Mesh3d(shapes.fine.clone()),
                shapes,
                MeshMaterial3d(material.clone()),
            ));
        }
    }
}
