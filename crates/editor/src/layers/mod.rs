//! Layers that show the room and what it does to this design: each computed in the background when
//! it is turned on, and not at all while it is off.

pub mod arrows;
pub mod latest;
pub mod placement;
pub mod region;
mod shell;
pub mod support;

use super::state::ColorBar;
use bevy::prelude::*;

/// | plugin | what it draws |
/// | --- | --- |
/// | [`arrows::ArrowsPlugin`] | the field's error as arrows on a lattice |
/// | [`placement::PlacementPlugin`] | what the selected sensor would be worth anywhere on its body |
/// | [`region::RegionPlugin`] | where in the volume the design meets its requirement |
/// | [`support::SupportPlugin`] | where in its box the room's model is valid |
pub struct LayersPlugin;

impl Plugin for LayersPlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<ColorBars>().add_plugins((
            arrows::ArrowsPlugin,
            placement::PlacementPlugin,
            region::RegionPlugin,
            support::SupportPlugin,
        ));
    }
}

/// Whether no layer has anything left to compute or to show.
pub fn are_idle(world: &World) -> bool {
    arrows::is_idle(world)
        && placement::is_idle(world)
        && region::is_idle(world)
        && support::is_idle(world)
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
