//! Arrows that keep their thickness on the screen, all of one kind in one mesh.

use crate::layers::legend::StrokeKey;
use crate::scene::materials::glow::GlowMaterial;
use crate::viewport::camera::OrbitRig;
use crate::{convert, palette};
use bevy::camera::visibility::NoFrustumCulling;
use bevy::ecs::system::SystemParam;
use bevy::prelude::*;
use nalgebra::{Point3, Vector3};
use trackwright_geometry::solid::Solid;
pub use trackwright_scene::arrow_style::ArrowStyle;

/// What arrows from what is to what the tracker reports mean.
pub const ERROR_STROKE: StrokeKey = StrokeKey {
    words: "error vectors, two heads where cut",
    plain_words: "how far off the tip is",
    color: palette::ERROR_VECTOR,
};

/// From a point by a vector, tracker frame, millimetres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Arrow {
    pub start_mm: Point3<f64>,
    pub vector_mm: Vector3<f64>,
}

/// The entities of one kind of error arrows, marked with `M`: one mesh, solid where it is seen and
/// shining through where it is hidden. None while there is nothing to show.
#[derive(SystemParam)]
pub struct DrawnArrows<'w, 's, M: Component> {
    commands: Commands<'w, 's>,
    drawn: Query<'w, 's, (Entity, &'static Mesh3d), With<M>>,
    meshes: ResMut<'w, Assets<Mesh>>,
    materials: ResMut<'w, Assets<GlowMaterial>>,
}

/// How arrows that are hidden by something look.
#[derive(Clone, Copy, Debug)]
pub struct ShineThrough {
    pub alpha: f32,
    /// Before what other things that shine through they are drawn, in millimetres of depth.
    pub order_mm: f32,
}

impl<M: Component + Default> DrawnArrows<'_, '_, M> {
    /// Shows the mesh, or nothing.
    pub fn show(&mut self, name: &'static str, mesh: Option<Mesh>, hidden: ShineThrough) {
        let Some(mesh) = mesh else {
            for (entity, _) in &self.drawn {
                self.commands.entity(entity).despawn();
            }
            return;
        };
        if let Some((_, handle)) = self.drawn.iter().next() {
            if let Some(mut old) = self.meshes.get_mut(&handle.0) {
                *old = mesh;
            }
            return;
        }
        let handle = self.meshes.add(mesh);
        let color = palette::ERROR_VECTOR;
        for material in [
            GlowMaterial::solid(color),
            GlowMaterial::shining_through(color, hidden.alpha).order(hidden.order_mm),
        ] {
            self.commands.spawn((
                Name::new(name),
                M::default(),
                NoFrustumCulling,
                Mesh3d(handle.clone()),
                MeshMaterial3d(self.materials.add(material)),
            ));
        }
    }
}

/// One mesh with all the arrows as they look from where the camera is; `None` where none of them
/// is long enough to be seen.
pub fn arrows_mesh(arrows: &[Arrow], style: ArrowStyle, rig: &OrbitRig) -> Option<Mesh> {
    let mut solid = Solid::default();
    for arrow in arrows {
        let mm_per_px = rig.mm_per_px(&arrow.start_mm);
        if let Some(size) = style.size(&arrow.vector_mm, mm_per_px, rig.view_px[1]) {
            solid.push_arrow(&arrow.start_mm, &arrow.vector_mm, &size);
        }
    }
    (!solid.triangles.is_empty())
        .then(|| convert::triangle_mesh(&solid.positions_mm, &solid.normals, &solid.triangles))
}
