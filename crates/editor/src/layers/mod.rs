//! Layers that show the room and what it does to this design: each computed in the background when
//! it is turned on, and not at all while it is off.

pub mod arrow_glyphs;
pub mod color_bar;
pub mod field_arrows;
pub mod ghost;
pub mod glyphs;
pub mod layers_ui;
pub mod magnification;
pub mod motion;
pub mod placement;
pub mod probe;
pub mod region;
pub mod region_surface;
pub mod sensor_errors;
pub mod settings_ui;
pub mod slice;
pub mod slice_picture;
pub mod slice_ui;
pub mod tip_error;
pub mod tip_scatter;
pub mod validity;

use crate::layers::color_bar::ColorBar;
use bevy::prelude::*;

/// | plugin | what it draws |
/// | --- | --- |
/// | [`field_arrows::ArrowsPlugin`] | the field's error as arrows on a lattice |
/// | [`placement::PlacementPlugin`] | what the selected sensor would be worth anywhere on its body |
/// | [`region::RegionPlugin`] | where in the volume the design meets its requirement |
/// | [`validity::SupportPlugin`] | where in its box the room's model is valid |
pub struct LayersPlugin;

impl Plugin for LayersPlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<ColorBars>().add_plugins((
            field_arrows::ArrowsPlugin,
            placement::PlacementPlugin,
            region::RegionPlugin,
            validity::SupportPlugin,
        ));
    }
}

/// Whether no layer has anything left to compute or to show.
pub fn are_idle(world: &World) -> bool {
    field_arrows::is_idle(world)
        && placement::is_idle(world)
        && region::is_idle(world)
        && validity::is_idle(world)
}

/// The colour bars of the layers that are shown, beside the slice's own.
#[derive(Resource, Clone, Debug, Default, PartialEq)]
pub struct ColorBars {
    pub arrows: Option<ColorBar>,
    pub placement: Option<ColorBar>,
    /// What the usable region comes to, in words.
    pub region: Option<String>,
    /// What the region of supported field comes to, in words.
    pub support: Option<String>,
}

impl ColorBars {
    pub fn all(&self) -> impl Iterator<Item = &ColorBar> {
        [&self.arrows, &self.placement].into_iter().flatten()
    }
}
