//! Where in its box the room's model is valid: the surface within which the field is supported
//! for the imagined sensor. The slice's hatching comes with the slice.

use crate::document::requests::OpenWorld;
use crate::layers::ColorBars;
use crate::layers::region_surface::{Shell, ShellLook};
use crate::palette;
use crate::runner::diagnostics::Diagnostics;
use crate::runner::latest::Latest;
use crate::runner::wake::Waker;
use crate::schedule::EditorSystems;
use bevy::prelude::*;
use nalgebra::{Unit, Vector3};
use std::sync::Arc;
use trackwright_field::Environment;
use trackwright_simulation::{SupportedRegion, SupportedRegionError, supported_region};

/// Points along each side of the lattice: coarse for the first picture, then fine.
const COUNTS: [usize; 2] = [13, 33];

const LOOK: ShellLook = ShellLook {
    name: "supported region",
    color: palette::SUPPORT,
    alpha: [0.06, 0.30],
    rim: 2.5,
    // Behind the usable region, which lies within it more often than around it.
    order_mm: -600.0,
};

/// Finds and draws the region of supported field while its layer is on.
pub struct SupportPlugin;

#[derive(Component)]
struct Supported;

type Found = Result<SupportedRegion, SupportedRegionError>;

#[derive(Resource)]
struct SupportLayer {
    latest: Latest<Found>,
    key: Option<Key>,
    found: Option<Found>,
}

/// What the region depends on: the room and which way the sensor points, and nothing of the design.
#[derive(Clone)]
struct Key {
    environment: Arc<Environment>,
    axis: Unit<Vector3<f64>>,
}

impl PartialEq for Key {
    fn eq(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.environment, &other.environment) && self.axis == other.axis
    }
}

impl FromWorld for SupportLayer {
    fn from_world(world: &mut World) -> Self {
        Self {
            latest: Latest::new("support", world.get_resource_or_init::<Waker>().clone()),
            key: None,
            found: None,
        }
    }
}

impl Plugin for SupportPlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<SupportLayer>()
            .init_resource::<ColorBars>()
            .init_resource::<Diagnostics>()
            .add_systems(
                Update,
                (ask.run_if(resource_exists_and_changed::<OpenWorld>), hear.run_if(is_on))
                    .chain()
                    .in_set(EditorSystems::Solve),
            )
            .add_systems(
                Update,
                draw.run_if(resource_changed::<SupportLayer>).in_set(EditorSystems::Draw),
            );
    }
}

pub(crate) fn is_idle(world: &World) -> bool {
    world.get_resource::<SupportLayer>().is_none_or(|layer| layer.latest.is_idle())
}

fn is_on(layer: Res<SupportLayer>) -> bool {
    layer.key.is_some()
}

fn ask(mut layer: ResMut<SupportLayer>, world: Res<OpenWorld>, mut bars: ResMut<ColorBars>) {
    let (view, environment) = (world.0.document.view(), &world.0.environment);
    let is_wanted = view.layers.support && environment.fit_validity.is_some();
    let axis = Vector3::from(view.slice.sensor_axis);
    let key = is_wanted.then(|| Key {
        environment: Arc::clone(environment),
        axis: Unit::try_new(axis, 1e-12).unwrap_or_else(Vector3::z_axis),
    });
    if layer.bypass_change_detection().key == key {
        return;
    }
    layer.key.clone_from(&key);
    let Some(Key { environment, axis }) = key else {
        layer.latest.give_up();
        layer.found = None;
        bars.support = None;
        return;
    };
    let work = move |task: &trackwright_task::Task, found: &mut dyn FnMut(Found)| {
        for count in COUNTS {
            found(supported_region(&environment, &axis, count, task));
        }
    };
    if let Err(error) = layer.latest.wish(Box::new(work)) {
        warn!("no thread for the supported region: {error}");
    }
}

fn hear(
    mut layer: ResMut<SupportLayer>,
    mut bars: ResMut<ColorBars>,
    mut diagnostics: ResMut<Diagnostics>,
) {
    let answers = layer.bypass_change_detection().latest.answers();
    diagnostics.support_evaluations +=
        answers.iter().flatten().map(|region| region.evaluations).sum::<u64>();
    let Some(found) = answers.into_iter().next_back() else {
        return;
    };
    bars.support = Some(match &found {
        Ok(region) => in_words(region),
        Err(error) => format!("no supported region: {error}"),
    });
    layer.found = Some(found);
}

/// `field supported in 61 % of the box, sensor along z`.
fn in_words(region: &SupportedRegion) -> String {
    let percent = region.fraction * 100.0;
    let along = ["x", "y", "z"]
        .into_iter()
        .zip(region.axis.iter())
        .find(|(_, part)| part.abs() > 1.0 - 1e-9)
        .map(|(name, _)| format!(", sensor along {name}"))
        .unwrap_or_default();
    format!("field supported in {percent:.0} % of the box{along}")
}

fn draw(layer: Res<SupportLayer>, mut shell: Shell<Supported>) {
    let surface = match &layer.found {
        Some(Ok(region)) => Some(&region.surface),
        _ => None,
    };
    shell.draw(Supported, surface, &LOOK);
}
