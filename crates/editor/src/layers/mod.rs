//! What is drawn over the scene: magnified errors, and what the room does to this design. Each layer
//! is one file with its state, systems, settings, legend and value under the pointer, and
//! [registers](registry) itself. One that is off computes nothing.

pub mod best_place;
pub mod commands;
pub mod field_arrows;
pub mod ghost;
pub mod layers_ui;
pub mod legend;
pub mod legend_entries;
pub mod magnification;
pub mod motion;
pub mod mounting;
pub mod pivot_ball;
pub mod placement;
pub mod probe;
pub mod region;
pub mod region_surface;
pub mod registry;
pub mod settings;
pub mod shapes;
pub mod slice;
pub mod slice_picture;
pub mod tool_ghost;
pub mod validity;

use bevy::prelude::*;

/// The list of layers and the legend, which layers write to.
pub struct RegistryPlugin;

impl Plugin for RegistryPlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<registry::LayerRegistry>().init_resource::<legend::Legends>();
    }
}

/// | plugin | what it draws |
/// | --- | --- |
/// | [`field_arrows::ArrowsPlugin`] | the field's error as arrows on a lattice |
/// | [`placement::PlacementPlugin`] | the error with the selected sensor anywhere on its body |
/// | [`best_place::BestPlacePlugin`] | the best of these places; a click puts the sensor there |
/// | [`mounting::MountingLayerPlugin`] | where sensors may be mounted, and where no coil may be |
/// | [`region::RegionPlugin`] | where in the volume the design meets its requirement |
/// | [`validity::SupportPlugin`] | where in its box the room's model is valid |
pub struct LayersPlugin;

impl Plugin for LayersPlugin {
    fn build(&self, app: &mut App) {
        app.add_plugins((
            field_arrows::ArrowsPlugin,
            placement::PlacementPlugin,
            best_place::BestPlacePlugin,
            mounting::MountingLayerPlugin,
            region::RegionPlugin,
            validity::SupportPlugin,
        ));
    }
}

/// Draws magnified errors, all by one magnification.
///
/// | plugin | what it draws |
/// | --- | --- |
/// | [`magnification::MagnifyPlugin`] | nothing: decides the magnification |
/// | [`shapes::ShapesPlugin`] | errors of sensors and tip, the sphere that the tip's should end in, its jitter, the range of motion |
/// | [`ghost::GhostPlugin`] | the tool as the tracker reports it |
pub struct GlyphsPlugin;

impl Plugin for GlyphsPlugin {
    fn build(&self, app: &mut App) {
        app.add_plugins((magnification::MagnifyPlugin, shapes::ShapesPlugin, ghost::GhostPlugin));
    }
}
