//! A layer's one sphere or ellipsoid in the scene.

use crate::palette::Rgb;
use crate::scene::materials::glow::GlowMaterial;
use crate::scene::shapes::GlyphShapes;
use bevy::ecs::system::SystemParam;
use bevy::prelude::*;

/// How a layer's sphere looks.
pub struct SphereLook {
    pub name: &'static str,
    pub color: Rgb,
    pub alpha: f32,
    pub rim_alpha: f32,
    pub rim: f32,
    pub order_mm: f32,
}

/// The unit sphere that a layer marks with `M`.
#[derive(SystemParam)]
pub struct GlowSphere<'w, 's, M: Component> {
    commands: Commands<'w, 's>,
    drawn: Query<'w, 's, (Entity, &'static mut Transform), With<M>>,
    shapes: Res<'w, GlyphShapes>,
    materials: ResMut<'w, Assets<GlowMaterial>>,
}

impl<M: Component> GlowSphere<'_, '_, M> {
    /// Spawns the sphere, moves it, or takes it away where it has no place.
    pub fn show(&mut self, place: Option<Transform>, marker: M, look: &SphereLook) {
        let Some(place) = place else {
            for (entity, _) in &self.drawn {
                self.commands.entity(entity).despawn();
            }
            return;
        };
        if let Some((_, mut transform)) = self.drawn.iter_mut().next() {
            transform.set_if_neq(place);
            return;
        }
        let material = GlowMaterial::translucent(look.color, look.alpha, look.rim_alpha)
            .rim(look.rim)
            .order(look.order_mm);
        self.commands.spawn((
            Name::new(look.name),
            marker,
            Mesh3d(self.shapes.sphere.clone()),
            MeshMaterial3d(self.materials.add(material)),
            place,
        ));
    }
}
