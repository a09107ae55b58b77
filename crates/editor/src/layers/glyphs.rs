//! Magnified errors: a vector at each sensor and at the tip, and the tool as the tracker
//! believes it to be. One magnification for all of them.

use bevy::prelude::*;

/// Draws errors.
///
/// | plugin | what it draws |
/// | --- | --- |
/// | [`crate::layers::magnification::MagnifyPlugin`] | nothing: decides the magnification |
/// | [`crate::layers::sensor_errors::SensorErrorsPlugin`] | the position error of each sensor |
/// | [`crate::layers::tip_error::TipErrorPlugin`] | the tip's error, and the sphere it should end in |
/// | [`crate::layers::tip_scatter::TipScatterPlugin`] | where the tracker's jitter puts the tip |
/// | [`crate::layers::ghost::GhostPlugin`] | the tool as the tracker believes it to be |
pub struct GlyphsPlugin;

impl Plugin for GlyphsPlugin {
    fn build(&self, app: &mut App) {
        app.add_plugins((
            crate::layers::magnification::MagnifyPlugin,
            crate::layers::sensor_errors::SensorErrorsPlugin,
            crate::layers::tip_error::TipErrorPlugin,
            crate::layers::tip_scatter::TipScatterPlugin,
            crate::layers::ghost::GhostPlugin,
        ));
    }
}
