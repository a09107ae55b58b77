//! Magnified errors: a vector at each sensor and at the tip, and the tool as the tracker
//! believes it to be. One magnification for all of them.

pub mod arrows;
pub mod ghost;
pub mod magnify;
pub mod sensor_errors;
pub mod tip_error;
pub mod tip_scatter;

use bevy::prelude::*;

/// Draws errors.
///
/// | plugin | what it draws |
/// | --- | --- |
/// | [`magnify::MagnifyPlugin`] | nothing: decides the magnification |
/// | [`sensor_errors::SensorErrorsPlugin`] | the position error of each sensor |
/// | [`tip_error::TipErrorPlugin`] | the tip's error, and the sphere it should end in |
/// | [`tip_scatter::TipScatterPlugin`] | where the tracker's jitter puts the tip |
/// | [`ghost::GhostPlugin`] | the tool as the tracker believes it to be |
pub struct GlyphsPlugin;

impl Plugin for GlyphsPlugin {
    fn build(&self, app: &mut App) {
        app.add_plugins((
            magnify::MagnifyPlugin,
            sensor_errors::SensorErrorsPlugin,
            tip_error::TipErrorPlugin,
            tip_scatter::TipScatterPlugin,
            ghost::GhostPlugin,
        ));
    }
}
