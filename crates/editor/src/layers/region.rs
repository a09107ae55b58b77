//! Where in the tracker's volume the design meets its requirement: the surface around it.

use crate::document::apply::WorldGeneration;
use crate::document::requests::{ActiveDrag, OpenWorld};
use crate::layers::ColorBars;
use crate::layers::region_surface::{Shell, ShellLook};
use crate::palette;
use crate::runner::diagnostics::Diagnostics;
use crate::runner::latest::Latest;
use crate::runner::wake::Waker;
use crate::schedule::EditorSystems;
use bevy::prelude::*;
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

/// Finds and draws the usable region while its layer is on.
pub struct RegionPlugin;

#[derive(Component)]
struct Region;

type Found = Result<UsableRegion, RegionError>;

#[derive(Resource)]
struct RegionLayer {
    latest: Latest<Found>,
    key: Option<(u64, u64)>,
    found: Option<Found>,
}

impl FromWorld for RegionLayer {
    fn from_world(world: &mut World) -> Self {
        Self {
            latest: Latest::new("region", world.get_resource_or_init::<Waker>().clone()),
            key: None,
            found: None,
        }
    }
}

impl Plugin for RegionPlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<RegionLayer>()
            .init_resource::<ColorBars>()
            .init_resource::<Diagnostics>()
            .init_resource::<WorldGeneration>()
            .init_resource::<ActiveDrag>()
            .add_systems(
                Update,
                (ask.run_if(resource_exists::<OpenWorld>).run_if(may_differ), hear.run_if(is_on))
                    .chain()
                    .in_set(EditorSystems::Solve),
            )
            .add_systems(
                Update,
                draw.run_if(resource_changed::<RegionLayer>).in_set(EditorSystems::Draw),
            );
    }
}

pub(crate) fn is_idle(world: &World) -> bool {
    world.get_resource::<RegionLayer>().is_none_or(|layer| layer.latest.is_idle())
}

fn is_on(layer: Res<RegionLayer>) -> bool {
    layer.key.is_some()
}

fn may_differ(world: Res<OpenWorld>, drag: Res<ActiveDrag>) -> bool {
    world.is_changed() || drag.is_changed()
}

fn ask(
    mut layer: ResMut<RegionLayer>,
    world: Res<OpenWorld>,
    generation: Res<WorldGeneration>,
    drag: Res<ActiveDrag>,
    mut bars: ResMut<ColorBars>,
) {
    let document = &world.0.document;
    let is_wanted = document.view().layers.region;
    // While something moves, every step would begin anew.
    if drag.0 && is_wanted {
        return;
    }
    let key = is_wanted.then(|| (generation.0, document.revision()));
    if layer.bypass_change_detection().key == key {
        return;
    }
    layer.key = key;
    if !is_wanted {
        layer.latest.give_up();
        layer.found = None;
        bars.region = None;
        return;
    }
    let scenario = trackwright_project::resolve(document.design(), &world.0.environment);
    let work = move |task: &trackwright_task::Task, found: &mut dyn FnMut(Found)| {
        for (count, basis) in STEPS {
            let region = usable_region(&scenario, [count; 3], basis, task);
            let is_over = region.is_err();
            found(region);
            if is_over {
                return;
            }
        }
    };
    if let Err(error) = layer.latest.wish(Box::new(work)) {
        warn!("no thread for the usable region: {error}");
    }
}

fn hear(
    mut layer: ResMut<RegionLayer>,
    mut bars: ResMut<ColorBars>,
    mut diagnostics: ResMut<Diagnostics>,
) {
    let Some(found) = layer.bypass_change_detection().latest.answers().pop() else {
        return;
    };
    bars.region = Some(match &found {
        Ok(region) => {
            diagnostics.work += region.work;
            in_words(region)
        }
        Err(error) => format!("no usable region: {error}"),
    });
    layer.found = Some(found);
}

/// `requirement met with 95 % in 34 % of the volume, 42,669 cm³; in the room's own field 61 %`.
fn in_words(region: &UsableRegion) -> String {
    let percent = |part: f64| format!("{:.0} %", part * 100.0);
    let volume = crate::widgets::basic::count(region.volume_cm3.round() as usize);
    let (with, own) = match region.upper_share {
        Some(_) => {
            (" with 95 %", format!("; in the room's own field {}", percent(region.own_fraction)))
        }
        None => ("", String::new()),
    };
    format!(
        "requirement met{with} in {} of the volume, {volume} cm³{own}",
        percent(region.fraction)
    )
}

fn draw(layer: Res<RegionLayer>, mut shell: Shell<Region>) {
    let surface = match &layer.found {
        Some(Ok(region)) => Some(&region.surface),
        _ => None,
    };
    shell.draw(Region, surface, &LOOK);
}
