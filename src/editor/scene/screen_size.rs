//! Glyphs that keep their size on the screen within bounds.

use crate::editor::camera::OrbitRig;
use crate::editor::convert;
use bevy::prelude::*;
use nalgebra::Point3;

/// Scales entities with [`ScreenSized`] whenever the camera moves.
pub struct ScreenSizePlugin;

/// A true length and how small and large it may get on the screen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SizeBounds {
    pub true_mm: f64,
    pub least_px: f64,
    pub most_px: f64,
    /// Added on the screen, whatever the size: the width of an outline.
    pub extra_px: f64,
}

impl SizeBounds {
    /// The length to draw, in millimetres.
    pub fn mm(&self, mm_per_px: f64) -> f64 {
        let (least, most) = (self.least_px * mm_per_px, self.most_px * mm_per_px);
        self.true_mm.max(least).min(most.max(self.true_mm)) + self.extra_px * mm_per_px
    }
}

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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_small_coil_is_drawn_larger_and_a_large_one_as_it_is() {
        let coil = SizeBounds {
            true_mm: 0.8,
            least_px: 8.0,
            most_px: 40.0,
            extra_px: 0.0,
        };
        assert_eq!(coil.mm(0.5), 4.0);
        assert_eq!(coil.mm(0.05), 0.8);
        // Nearer than true size it never shrinks.
        assert_eq!(coil.mm(0.001), 0.8);
        let outline = SizeBounds {
            extra_px: 4.0,
            ..coil
        };
        assert_eq!(outline.mm(0.5), 6.0);
    }
}
