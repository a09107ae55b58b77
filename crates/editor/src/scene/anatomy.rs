//! The design's anatomy: meshes that are looked through and nothing else. They are no part of what
//! can be picked, which the core's surfaces of the bodies alone are.

use crate::convert;
use crate::document::requests::OpenWorld;
use crate::document::shown::ShownDesign;
use crate::layers::legend::{LegendKey, Swatch};
use crate::layers::registry::{AddLayer, LayerInfo};
use crate::palette::{self, Rgb};
use crate::scene::bodies::anatomy_look;
use crate::scene::body_meshes::{Shapes, paints_in_software};
use crate::scene::materials::glow::GlowMaterial;
use crate::schedule::EditorSystems;
use bevy::prelude::*;
use bevy::render::renderer::RenderAdapterInfo;
use std::sync::Arc;
use trackwright_design::BodyRole;
use trackwright_design::view::Layer;
use trackwright_formats::printable::printable;
use trackwright_geometry::mesh::SurfaceMesh;
use trackwright_scene::color_of_anatomy;

/// The layer.
const LAYER: LayerInfo = LayerInfo { keys, ..LayerInfo::new(&Layer::ANATOMY) };

/// What comes with the bodies' meshes, and the design's own meshes by their names.
fn keys(open: &trackwright_project::World) -> Vec<LegendKey> {
    let has_anatomy = |role: BodyRole| {
        let parts = open.mesh(role).into_iter().flat_map(|mesh| &mesh.parts);
        parts.into_iter().any(|part| part.is_anatomy())
    };
    let of_bodies = BodyRole::ALL
        .into_iter()
        .any(has_anatomy)
        .then(|| LegendKey::new(Swatch::Surface(palette::BONE), "anatomy"));
    let own = open.document.design().anatomy.iter();
    let own = own.filter(|anatomy| open.anatomy_mesh(&anatomy.mesh).is_some());
    let own = own.map(|anatomy| {
        let name = printable(&anatomy.name).into_owned();
        LegendKey::new(Swatch::Surface(color_of_anatomy(anatomy)), name)
    });
    of_bodies.into_iter().chain(own).collect()
}

/// Draws the anatomy where its frames have it, while its layer is on.
pub struct AnatomyPlugin;

/// One mesh of the anatomy, by its place in the design's list.
#[derive(Component, Clone, Copy, Debug, PartialEq, Eq)]
#[require(Transform, Visibility)]
pub struct AnatomyRoot(pub usize);

/// What its entities were made from.
#[derive(Component)]
struct MadeFrom {
    name: String,
    mesh: Arc<SurfaceMesh>,
    color: Rgb,
}

/// The meshes as the renderer has them, kept while the design refers to them.
#[derive(Resource, Default)]
struct AnatomyShapes(Vec<(Arc<SurfaceMesh>, Vec<Shapes>)>);

impl Plugin for AnatomyPlugin {
    fn build(&self, app: &mut App) {
        app.add_layer(LAYER).init_resource::<AnatomyShapes>().add_systems(
            Update,
            draw_anatomy
                .run_if(resource_exists_and_changed::<ShownDesign>)
                .in_set(EditorSystems::Draw),
        );
    }
}

impl AnatomyShapes {
    fn of(
        &mut self,
        mesh: &Arc<SurfaceMesh>,
        meshes: &mut Assets<Mesh>,
        is_software: bool,
    ) -> Vec<Shapes> {
        if let Some((_, shapes)) = self.0.iter().find(|(kept, _)| Arc::ptr_eq(kept, mesh)) {
            return shapes.clone();
        }
        let shapes = Shapes::of_parts(mesh, meshes, is_software);
        self.0.push((Arc::clone(mesh), shapes.clone()));
        shapes
    }
}

fn draw_anatomy(
    mut commands: Commands,
    world: Res<OpenWorld>,
    shown: Res<ShownDesign>,
    mut roots: Query<(Entity, &AnatomyRoot, &MadeFrom, &mut Transform)>,
    mut kept: ResMut<AnatomyShapes>,
    (mut meshes, mut glows): (ResMut<Assets<Mesh>>, ResMut<Assets<GlowMaterial>>),
    adapter: Option<Res<RenderAdapterInfo>>,
) {
    let design = &shown.design;
    let is_shown = world.0.document.view().layers.anatomy;
    let mesh_of = |index: usize| {
        let anatomy = design.anatomy.get(index)?;
        Some((anatomy, world.0.anatomy_mesh(&anatomy.mesh)?))
    };
    let present: Vec<_> = (0..design.anatomy.len()).filter_map(mesh_of).collect();
    (kept.0).retain(|(mesh, _)| present.iter().any(|(_, other)| Arc::ptr_eq(mesh, other)));
    let mut is_there = vec![false; design.anatomy.len()];
    for (entity, root, made_from, mut transform) in &mut roots {
        let wanted = mesh_of(root.0).filter(|(anatomy, mesh)| {
            let is_same_color = made_from.color == color_of_anatomy(anatomy);
            let is_same = made_from.name == anatomy.name && is_same_color;
            is_shown && is_same && Arc::ptr_eq(&made_from.mesh, mesh)
        });
        match wanted {
            Some((anatomy, _)) => {
                transform.set_if_neq(convert::transform(&anatomy.tracker_from_mesh(design)));
                is_there[root.0] = true;
            }
            None => commands.entity(entity).despawn(),
        }
    }
    if !is_shown {
        return;
    }
    let is_software = paints_in_software(adapter);
    let missing = (0..is_there.len()).filter(|index| !is_there[*index]);
    for (index, (anatomy, mesh)) in missing.filter_map(|index| Some((index, mesh_of(index)?))) {
        let shapes = kept.of(mesh, &mut meshes, is_software);
        let color = color_of_anatomy(anatomy);
        let look = glows.add(anatomy_look(color));
        let mut root = commands.spawn((
            Name::new(format!("anatomy {}", anatomy.name)),
            AnatomyRoot(index),
            MadeFrom { name: anatomy.name.clone(), mesh: Arc::clone(mesh), color },
            convert::transform(&anatomy.tracker_from_mesh(design)),
        ));
        for (part, shapes) in mesh.parts.iter().zip(shapes) {
            root.with_child((
                Name::new(part.name.clone()),
                Mesh3d(shapes.fine.clone()),
                shapes,
                MeshMaterial3d(look.clone()),
            ));
        }
    }
}
