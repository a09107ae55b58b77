//! Meshes of tool and CRF, and the anatomy that the CRF sits on.

use crate::document::requests::OpenWorld;
use crate::document::shown::ShownDesign;
use crate::scene::BodyRoot;
use crate::scene::body_meshes::{BodyMeshes, is_same_mesh, paints_in_software};
use crate::scene::materials::glow::GlowMaterial;
use crate::scene::materials::lit::LitMaterial;
use crate::schedule::EditorSystems;
use crate::{convert, palette};
use bevy::prelude::*;
use bevy::render::renderer::RenderAdapterInfo;
use std::sync::Arc;
use trackwright_design::BodyRole;
use trackwright_geometry::mesh::{MeshPart, SurfaceMesh};
pub use trackwright_scene::shown_mesh;

/// How opaque anatomy is, where it faces the viewer and at its rim: what it hides has to be seen
/// through it, and its shape has to be read all the same.
const ANATOMY_ALPHA: [f32; 2] = [0.13, 0.62];

/// How anatomy of this colour looks.
pub(crate) fn anatomy_look(color: palette::Rgb) -> GlowMaterial {
    let [middle, rim] = ANATOMY_ALPHA;
    GlowMaterial::translucent(color, middle, rim)
}

/// Draws both bodies at their poses.
pub struct BodiesPlugin;

/// When the bodies' entities are there and placed.
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct BodiesSystems;

/// A part of a body's mesh.
#[derive(Component, Clone, Copy, Debug)]
pub struct BodyPart {
    pub body: BodyRole,
    pub is_anatomy: bool,
}

/// The mesh that a body's parts were made from.
#[derive(Component)]
struct MadeFrom(Option<Arc<SurfaceMesh>>);

impl Plugin for BodiesPlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<BodyMeshes>().add_systems(
            Update,
            (spawn_bodies, ApplyDeferred, place_bodies, show_anatomy)
                .chain()
                .run_if(resource_exists_and_changed::<ShownDesign>)
                .in_set(BodiesSystems)
                .in_set(EditorSystems::Draw),
        );
    }
}

/// One root a body; its parts anew when it got another mesh.
fn spawn_bodies(
    mut commands: Commands,
    world: Res<OpenWorld>,
    roots: Query<(Entity, &BodyRoot, &MadeFrom)>,
    mut made: ResMut<BodyMeshes>,
    mut meshes: ResMut<Assets<Mesh>>,
    (mut materials, mut glows): (ResMut<Assets<LitMaterial>>, ResMut<Assets<GlowMaterial>>),
    adapter: Option<Res<RenderAdapterInfo>>,
) {
    let is_software = paints_in_software(adapter);
    for role in BodyRole::ALL {
        let mesh = shown_mesh(&world.0, role);
        let existing = roots.iter().find(|(_, root, _)| root.0 == role);
        let is_wanted = world.0.document.design().body(role).is_some();
        if let Some((entity, _, made_from)) = existing {
            let is_current = match (&made_from.0, &mesh) {
                (Some(a), Some(b)) => is_same_mesh(a, b),
                (None, None) => true,
                _ => false,
            };
            if is_wanted && is_current {
                continue;
            }
            commands.entity(entity).despawn();
        }
        if !is_wanted {
            continue;
        }
        let mut root =
            commands.spawn((Name::new(role.name()), BodyRoot(role), MadeFrom(mesh.clone())));
        let Some(mesh) = &mesh else { continue };
        for (part, shapes) in made.of(role, mesh, &mut meshes, is_software) {
            root.with_children(|parts| {
                let mut shape = parts.spawn((
                    Name::new(part.name.clone()),
                    BodyPart { body: role, is_anatomy: part.is_anatomy() },
                    Mesh3d(shapes.fine.clone()),
                    shapes,
                ));
                if part.is_anatomy() {
                    let look = glows.add(anatomy_look(palette::BONE));
                    shape.insert(MeshMaterial3d(look));
                } else {
                    shape.insert(MeshMaterial3d(materials.add(material(role, part))));
                }
            });
        }
    }
}

fn place_bodies(
    world: Res<OpenWorld>,
    shown: Res<ShownDesign>,
    mut roots: Query<(&BodyRoot, &mut Transform, &mut Visibility)>,
) {
    let hidden = &world.0.document.view().hidden;
    for (root, mut transform, mut visibility) in &mut roots {
        visibility.set_if_neq(match hidden.has_body(root.0) {
            true => Visibility::Hidden,
            false => Visibility::Inherited,
        });
        if let Some(pose) = shown.design.tracker_from_body(root.0) {
            transform.set_if_neq(convert::transform(&pose));
        }
    }
}

fn show_anatomy(world: Res<OpenWorld>, mut parts: Query<(&BodyPart, &mut Visibility)>) {
    let is_shown = world.0.document.view().layers.anatomy;
    for (part, mut visibility) in &mut parts {
        let wanted =
            if part.is_anatomy && !is_shown { Visibility::Hidden } else { Visibility::Inherited };
        visibility.set_if_neq(wanted);
    }
}

/// Parts keep their file's metal, roughness and lightness; the hue is the role's.
fn material(role: BodyRole, part: &MeshPart) -> LitMaterial {
    let [r, g, b, _] = part.base_color;
    LitMaterial::new(
        palette::of_part(role, LinearRgba::rgb(r, g, b)),
        part.metallic,
        part.roughness.clamp(0.15, 1.0),
    )
}
