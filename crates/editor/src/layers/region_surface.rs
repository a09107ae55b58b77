//! The closed surface around a region of the room, translucent.

use crate::convert;
use crate::palette::Rgb;
use crate::scene::materials::glow::GlowMaterial;
use bevy::ecs::system::SystemParam;
use bevy::prelude::*;
use trackwright_geometry::isosurface::Isosurface;

/// What distinguishes one region's surface from another's.
#[derive(Clone, Copy, Debug)]
pub struct ShellLook {
    pub name: &'static str,
    pub color: Rgb,
    /// Opacity where the surface faces the eye, and at its rim.
    pub alpha: [f32; 2],
    /// How narrow the rim is.
    pub rim: f32,
    pub order_mm: f32,
}

/// The one surface that is marked with an `M`.
#[derive(SystemParam)]
pub struct Shell<'w, 's, M: Component> {
    commands: Commands<'w, 's>,
    drawn: Query<'w, 's, Entity, With<M>>,
    meshes: ResMut<'w, Assets<Mesh>>,
    materials: ResMut<'w, Assets<GlowMaterial>>,
}

impl<M: Component> Shell<'_, '_, M> {
    /// In place of the one before; an empty surface, or none, is not drawn.
    pub fn draw(&mut self, mark: M, surface: Option<&Isosurface>, look: &ShellLook) {
        for entity in &self.drawn {
            self.commands.entity(entity).despawn();
        }
        let Some(surface) = surface.filter(|surface| !surface.triangles.is_empty()) else {
            return;
        };
        let mesh =
            convert::triangle_mesh(&surface.positions_mm, &surface.normals, &surface.triangles);
        let [middle, rim] = look.alpha;
        let material = GlowMaterial::translucent(look.color, middle, rim)
            .rim(look.rim)
            .order(look.order_mm)
            .both_faces();
        self.commands.spawn((
            Name::new(look.name),
            mark,
            Mesh3d(self.meshes.add(mesh)),
            MeshMaterial3d(self.materials.add(material)),
        ));
    }
}
