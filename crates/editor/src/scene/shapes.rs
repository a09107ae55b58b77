//! Meshes of unit size that glyphs share.

use crate::convert;
use bevy::prelude::*;
use trackwright_geometry::solid::Solid;

/// Makes [`GlyphShapes`] at startup.
pub struct ShapesPlugin;

/// Shapes along z, one unit long and one across, centred.
#[derive(Resource, Clone, Debug)]
pub struct GlyphShapes {
    pub coil: Handle<Mesh>,
    pub cylinder: Handle<Mesh>,
    /// Base at z = 0, point at z = 1.
    pub cone: Handle<Mesh>,
    /// Of diameter 1.
    pub ball: Handle<Mesh>,
    /// Of radius 1.
    pub sphere: Handle<Mesh>,
}

impl Plugin for ShapesPlugin {
    fn build(&self, app: &mut App) {
        app.add_systems(PreStartup, make);
    }
}

fn make(mut commands: Commands, mut meshes: ResMut<Assets<Mesh>>) {
    let mesh = |solid: Solid| {
        convert::triangle_mesh(&solid.positions_mm, &solid.normals, &solid.triangles)
    };
    commands.insert_resource(GlyphShapes {
        coil: meshes.add(mesh(Solid::coil())),
        cylinder: meshes.add(mesh(Solid::cylinder())),
        cone: meshes.add(mesh(Solid::cone())),
        ball: meshes.add(Sphere::new(0.5).mesh().uv(32, 16)),
        sphere: meshes.add(Sphere::new(1.0).mesh().uv(48, 24)),
    });
}
