//! Where in the tracker's volume the design meets its requirement: the surface around it.

use crate::document::requests::{ActiveDrag, OpenWorld};
use crate::document::state::WorldGeneration;
use crate::layers::legend::Legends;
use crate::layers::region_surface::{Shell, ShellLook};
use crate::layers::registry::{AddLayer, LayerInfo};
use crate::palette;
use crate::runner::diagnostics::Diagnostics;
use crate::runner::jobs::Newest;
use crate::runner::wake::Waker;
use crate::schedule::{EditorSystems, request_then_receive};
use bevy::prelude::*;
use trackwright_design::view::Layer;
use trackwright_simulation::usable_region::{
    RegionBasis, RegionError, UsableRegion, usable_region,
};

/// Points along each side of the lattice, and what bounds are held against: coarse and in the room's
/// own field for the first picture, then fine and with intervals.
const STEPS: [(usize, RegionBasis); 2] = [(13, RegionBasis::OwnField), (33, RegionBasis::Interval)];

const LOOK: ShellLook = ShellLook {
    name: "usable region",
    color: palette::MET,
    alpha: [0.10, 0.45],
    rim: 2.0,
    order_mm: -400.0,
};

/// The layer.
pub const LAYER: LayerInfo =
    LayerInfo { is_of_room: true, is_idle, ..LayerInfo::new(&Layer::REGION) };

/// In the legend it comes below model validity.
pub const LEGEND_ORDER: u32 = Layer::SUPPORT.order + 5;

/// Finds and draws the usable region while its layer is on.
pub struct RegionPlugin;

#[derive(Component)]
struct Region;

type Found = Result<UsableRegion, RegionError>;

#[derive(Resource)]
struct RegionLayer {
    /// By generation and revision.
    newest: Newest<(u64, u64), Found>,
}

impl FromWorld for RegionLayer {
    fn from_world(world: &mut World) -> Self {
        Self { newest: Newest::new("region", world.get_resource_or_init::<Waker>().clone()) }
    }
}

impl Plugin for RegionPlugin {
    fn build(&self, app: &mut App) {
        app.add_layer(LAYER)
            .init_resource::<RegionLayer>()
            .add_systems(
                Update,
                request_then_receive(
                    request.run_if(resource_exists::<OpenWorld>).run_if(may_differ),
                    receive.run_if(is_on),
                ),
            )
            .add_systems(
                Update,
                draw.run_if(resource_changed::<RegionLayer>).in_set(EditorSystems::Draw),
            );
    }
}

fn is_idle(world: &World) -> bool {
    world.get_resource::<RegionLayer>().is_none_or(|layer| layer.newest.is_idle())
}

fn is_on(layer: Res<RegionLayer>) -> bool {
    layer.newest.requested().is_some()
}

fn may_differ(world: Res<OpenWorld>, drag: Res<ActiveDrag>) -> bool {
    world.is_changed() || drag.is_changed()
}

fn request(
    mut layer: ResMut<RegionLayer>,
    world: Res<OpenWorld>,
    generation: Res<WorldGeneration>,
    drag: Res<ActiveDrag>,
    mut legends: ResMut<Legends>,
) {
    let document = &world.0.document;
    let is_wanted = document.view().layers.region;
    // While something moves, every step would begin anew.
    if drag.0 && is_wanted {
        return;
    }
    let key = is_wanted.then(|| (generation.0, document.revision()));
    if layer.newest.requested() == key.as_ref() {
        return;
    }
    let Some(key) = key else {
        layer.newest.give_up();
        legends.set_surface(LEGEND_ORDER, LOOK.color, None);
        return;
    };
    let scenario = trackwright_project::resolve(document.design(), &world.0.environment);
    layer.newest.request(key, move |task, report| {
        let [coarse, fine] = STEPS.map(|(count, basis)| ([count; 3], basis));
        let first = usable_region(&scenario, coarse.0, coarse.1, task);
        if first.is_err() {
            return Some(first);
        }
        report(first);
        Some(usable_region(&scenario, fine.0, fine.1, task))
    });
}

fn receive(
    mut layer: ResMut<RegionLayer>,
    mut legends: ResMut<Legends>,
    mut diagnostics: ResMut<Diagnostics>,
) {
    let count = |found: &Found| {
        if let Ok(region) = found {
            diagnostics.work += region.work;
        }
    };
    if !layer.bypass_change_detection().newest.receive(count) {
        return;
    }
    layer.set_changed();
    let words = layer.newest.found().map(|(_, found)| match found {
        Ok(region) => Ok(in_words(region)),
        Err(error) => Err(format!("no usable region: {error}")),
    });
    legends.set_surface(LEGEND_ORDER, LOOK.color, words);
}

/// `requirement met with 95 % in 34 % of the volume, 42,669 cm³`.
fn in_words(region: &UsableRegion) -> String {
    let volume = crate::widgets::basic::count(region.volume_cm3.round() as usize);
    let with = if region.upper_share.is_some() { " with 95 %" } else { "" };
    let percent = 100.0 * region.fraction;
    format!("requirement met{with} in {percent:.0} % of the volume, {volume} cm³")
}

fn draw(layer: Res<RegionLayer>, mut shell: Shell<Region>) {
    let found = layer.newest.found().and_then(|(_, found)| found.as_ref().ok());
    shell.draw(Region, found.map(|region| &region.surface), &LOOK);
}
