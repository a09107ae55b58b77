//! A tool as it is reported: its mesh, translucent with a bright rim, where the magnified error puts it.

use crate::convert;
use crate::palette::Rgb;
use crate::scene::body_meshes::{BodyMeshes, Shapes, is_same_mesh, paints_in_software};
use crate::scene::materials::glow::GlowMaterial;
use bevy::ecs::system::SystemParam;
use bevy::prelude::*;
use bevy::render::renderer::RenderAdapterInfo;
use std::sync::Arc;
use trackwright_design::BodyRole;
use trackwright_geometry::mesh::SurfaceMesh;
use trackwright_scene::tool_errors::ToolErrors;

/// How a ghost looks.
pub struct GhostLook {
    pub name: &'static str,
    pub color: Rgb,
    pub middle_alpha: f32,
    pub rim_alpha: f32,
    /// Of what shines through bodies that hide it; `None` leaves that out.
    pub hidden_alpha: Option<f32>,
    pub order_mm: f32,
    /// Whether it is the open design's tool, whose shapes are there already.
    pub is_of_design: bool,
}

/// The mesh that a ghost was made from.
#[derive(Component)]
#[require(Transform, Visibility)]
struct MadeFrom(Arc<SurfaceMesh>);

/// The ghost of a tool that a plugin marks with `M`.
#[derive(SystemParam)]
pub struct ToolGhost<'w, 's, M: Component> {
    commands: Commands<'w, 's>,
    drawn: Query<'w, 's, (Entity, &'static mut Transform, &'static MadeFrom), With<M>>,
    made: ResMut<'w, BodyMeshes>,
    meshes: ResMut<'w, Assets<Mesh>>,
    materials: ResMut<'w, Assets<GlowMaterial>>,
    adapter: Option<Res<'w, RenderAdapterInfo>>,
}

impl<M: Component> ToolGhost<'_, '_, M> {
    /// Spawns the ghost, moves it, or takes it away where there is no tool. `times` is the
    /// magnification of its error.
    pub fn show(
        &mut self,
        tool: Option<(&Arc<SurfaceMesh>, ToolErrors)>,
        times: f64,
        marker: M,
        look: &GhostLook,
    ) {
        let Some((mesh, tool)) = tool else {
            for (entity, ..) in &self.drawn {
                self.commands.entity(entity).despawn();
            }
            return;
        };
        let place = convert::transform(&tool.ghost(times).world_from_body);
        if let Some((entity, mut transform, made_from)) = self.drawn.iter_mut().next() {
            if is_same_mesh(&made_from.0, mesh) {
                transform.set_if_neq(place);
                return;
            }
            self.commands.entity(entity).despawn();
        }
        let shapes = self.shapes(mesh, look.is_of_design);
        let materials = look.materials().map(|material| self.materials.add(material));
        let materials: Vec<_> = materials.collect();
        let mut root =
            self.commands.spawn((Name::new(look.name), marker, MadeFrom(Arc::clone(mesh)), place));
        for shapes in shapes {
            for material in &materials {
                root.with_child((
                    Mesh3d(shapes.fine.clone()),
                    shapes.clone(),
                    MeshMaterial3d(material.clone()),
                ));
            }
        }
    }

    /// Of each part that is no anatomy.
    fn shapes(&mut self, mesh: &Arc<SurfaceMesh>, is_of_design: bool) -> Vec<Shapes> {
        let is_software = paints_in_software(self.adapter.as_ref().map(Res::clone));
        if is_of_design {
            let made = self.made.of(BodyRole::Tool, mesh, &mut self.meshes, is_software);
            let shown = made.into_iter().filter(|(part, _)| !part.is_anatomy());
            return shown.map(|(_, shapes)| shapes).collect();
        }
        let shown = mesh.parts.iter().filter(|part| !part.is_anatomy());
        shown.map(|part| Shapes::of_part(part, &mut self.meshes, is_software)).collect()
    }
}

impl GhostLook {
    fn materials(&self) -> impl Iterator<Item = GlowMaterial> {
        let body = GlowMaterial::translucent(self.color, self.middle_alpha, self.rim_alpha);
        let hidden =
            self.hidden_alpha.map(|alpha| GlowMaterial::shining_through(self.color, alpha));
        std::iter::once(body).chain(hidden).map(|material| material.order(self.order_mm))
    }
}
