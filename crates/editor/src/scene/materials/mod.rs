//! What surfaces look like: four small shaders in the place of a physically based one, which a
//! processor that paints by itself pays for with most of its time.

pub mod glow;
pub mod lit;
pub mod map;
pub mod paint;

use bevy::prelude::*;

/// Adds the materials.
///
/// | plugin | what it paints |
/// | --- | --- |
/// | `GlowPlugin` | glyphs, ghosts, anatomy: one colour in any light |
/// | `LitPlugin` | bodies: a key light, a fill light, a room |
/// | `MapPlugin` | coloured maps, to the bit |
/// | `PaintPlugin` | surfaces whose corners have colours |
pub struct MaterialsPlugin;

impl Plugin for MaterialsPlugin {
    fn build(&self, app: &mut App) {
        app.add_plugins((glow::GlowPlugin, lit::LitPlugin, map::MapPlugin, paint::PaintPlugin));
    }
}
