//! Glyphs that keep their size on the screen within bounds.

use crate::convert;
use crate::viewport::camera::OrbitRig;
use bevy::prelude::*;
use nalgebra::Point3;
pub use trackwright_scene::sensor_look::SizeBounds;

/// Scales entities with [`ScreenSized`] whenever the camera moves.
pub struct ScreenSizePlugin;

/// Scale of an entity: across (x, y) and along (z), over meshes of unit size.
#[derive(Component, Clone, Copy, Debug, PartialEq)]
pub struct ScreenSized {
    /// Where it is, tracker frame.
    pub at_mm: Point3<f64>,
    pub across: SizeBounds,
    pub along: SizeBounds,
}

impl Plugin for ScreenSizePlugin {
    fn build(&self, app: &mut App) {
        app.add_systems(PostUpdate, scale.before(TransformSystems::Propagate));
    }
}

fn scale(rig: Option<Res<OrbitRig>>, mut glyphs: Query<(Ref<ScreenSized>, &mut Transform)>) {
    let Some(rig) = rig else { return };
    for (size, mut transform) in &mut glyphs {
        if !rig.is_changed() && !size.is_changed() {
            continue;
        }
        let mm_per_px = rig.mm_per_px(&size.at_mm);
        let across = convert::length(size.across.mm(mm_per_px));
        let along = convert::length(size.along.mm(mm_per_px));
        let scale = Vec3::new(across, across, along);
        if transform.scale != scale {
            transform.scale = scale;
        }
    }
}
