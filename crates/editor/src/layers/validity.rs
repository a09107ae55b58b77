//! Where in its box the room's model is valid: the surface within which the field is supported
//! for the imagined sensor. The slice's hatching comes with the slice.

use crate::document::requests::OpenWorld;
use crate::layers::legend::Legends;
use crate::layers::region_surface::{Shell, ShellLook};
use crate::layers::registry::{AddLayer, LayerInfo};
use crate::layers::slice::NO_SUPPORT;
use crate::palette;
use crate::runner::diagnostics::Diagnostics;
use crate::runner::jobs::Newest;
use crate::runner::wake::Waker;
use crate::schedule::{EditorSystems, request_then_receive};
use bevy::prelude::*;
use nalgebra::{Unit, Vector3};
use std::sync::Arc;
use trackwright_design::view::Layer;
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

/// The layer.
pub const LAYER: LayerInfo = LayerInfo {
    is_of_room: true,
    why_not: |environment| (!environment.has_validity()).then_some(NO_SUPPORT),
    is_idle,
    ..LayerInfo::new(&Layer::SUPPORT)
};

/// Finds and draws the region of supported field while its layer is on.
pub struct SupportPlugin;

#[derive(Component)]
struct Supported;

type Found = Result<SupportedRegion, SupportedRegionError>;

#[derive(Resource)]
struct SupportLayer {
    newest: Newest<Key, Found>,
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
        Self { newest: Newest::new("support", world.get_resource_or_init::<Waker>().clone()) }
    }
}

impl Plugin for SupportPlugin {
    fn build(&self, app: &mut App) {
        app.add_layer(LAYER)
            .init_resource::<SupportLayer>()
            .add_systems(
                Update,
                request_then_receive(
                    request.run_if(resource_exists_and_changed::<OpenWorld>),
                    receive.run_if(is_on),
                ),
            )
            .add_systems(
                Update,
                draw.run_if(resource_changed::<SupportLayer>).in_set(EditorSystems::Draw),
            );
    }
}

fn is_idle(world: &World) -> bool {
    world.get_resource::<SupportLayer>().is_none_or(|layer| layer.newest.is_idle())
}

fn is_on(layer: Res<SupportLayer>) -> bool {
    layer.newest.requested().is_some()
}

fn request(mut layer: ResMut<SupportLayer>, world: Res<OpenWorld>, mut legends: ResMut<Legends>) {
    let (view, environment) = (world.0.document.view(), &world.0.environment);
    let is_wanted = view.layers.support && environment.has_validity();
    let axis = Vector3::from(view.slice.sensor_axis);
    let key = is_wanted.then(|| Key {
        environment: Arc::clone(environment),
        axis: Unit::try_new(axis, 1e-12).unwrap_or_else(Vector3::z_axis),
    });
    if layer.newest.requested() == key.as_ref() {
        return;
    }
    let Some(key) = key else {
        layer.newest.give_up();
        legends.set_surface(LAYER.row.order, LOOK.color, None);
        return;
    };
    let Key { environment, axis } = key.clone();
    layer.newest.request(key, move |task, report| {
        report(supported_region(&environment, &axis, COUNTS[0], task));
        Some(supported_region(&environment, &axis, COUNTS[1], task))
    });
}

fn receive(
    mut layer: ResMut<SupportLayer>,
    mut legends: ResMut<Legends>,
    mut diagnostics: ResMut<Diagnostics>,
) {
    let count = |found: &Found| {
        diagnostics.support_evaluations += found.as_ref().map_or(0, |region| region.evaluations);
    };
    if !layer.bypass_change_detection().newest.receive(count) {
        return;
    }
    layer.set_changed();
    let words = layer.newest.found().map(|(_, found)| match found {
        Ok(region) => Ok(in_words(region)),
        Err(error) => Err(format!("no supported region: {error}")),
    });
    legends.set_surface(LAYER.row.order, LOOK.color, words);
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
    let found = layer.newest.found().and_then(|(_, found)| found.as_ref().ok());
    shell.draw(Supported, found.map(|region| &region.surface), &LOOK);
}
