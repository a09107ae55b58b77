//! The value under the pointer: of whichever layer, table or body is in front, interpolated from
//! what was sampled.
//!
//! It requests no frame: a pointer that moves draws one, and in that the probe works. It rests while
//! nothing is coloured, something is dragged or a button is held.

use crate::document::requests::{ActiveDrag, OpenWorld};
use crate::document::selection::{Hovered, Selected};
use crate::document::shown::ShownSystems;
use crate::layers::registry::{LayerRegistry, ProbeRay, Probed};
use crate::schedule::EditorSystems;
use crate::shell::window::DragText;
use crate::viewport::camera::{ScenePointer, Sight};
use crate::viewport::surfaces::Surfaces;
use bevy::ecs::system::{SystemParam, SystemState};
use bevy::prelude::*;
use trackwright_design::BodyRole;

/// How near to an arrow or a sample the pointer has to be, in pixels.
const REACH_PX: f64 = 4.0;

/// Keeps [`Probe`].
pub struct ProbePlugin;

/// What the pointer is over, in words, and where; `None` where nothing coloured is.
#[derive(Resource, Clone, Debug, Default, PartialEq)]
pub struct Probe(pub Option<DragText>);

/// How often the probe looked for what is under the pointer.
#[derive(Resource, Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ProbeLooks(pub u64);

impl Plugin for ProbePlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<Probe>().init_resource::<ProbeLooks>().add_systems(
            Update,
            probe
                .run_if(resource_exists::<OpenWorld>)
                .after(ShownSystems::Follow)
                .in_set(EditorSystems::Draw),
        );
    }
}

/// What keeps the probe from looking.
#[derive(SystemParam)]
struct Busy<'w> {
    drag: Res<'w, ActiveDrag>,
    buttons: Option<Res<'w, ButtonInput<MouseButton>>>,
    hovered: Res<'w, Hovered>,
}

impl Busy<'_> {
    fn is_any(&self) -> bool {
        let is_pressed =
            |buttons: &Res<ButtonInput<MouseButton>>| buttons.get_pressed().next().is_some();
        self.drag.0
            || self.buttons.as_ref().is_some_and(is_pressed)
            // What would be dragged has its own hint.
            || matches!(self.hovered.0, Some(Selected::Sensor(..)))
    }
}

/// Exclusive, so that each layer reads what it wants of the world, and only while it is on.
fn probe(
    world: &mut World,
    state: &mut SystemState<(ScenePointer<'static, 'static>, Busy<'static>, Sight<'static>)>,
) -> Result {
    let (pointer, busy, sight) = state.get(world)?;
    let registry = world.get_resource::<LayerRegistry>();
    let is_on = |registry: &&LayerRegistry| {
        !busy.is_any() && registry.probes.iter().any(|probe| (probe.is_on)(world))
    };
    let at = pointer.over_scene();
    let aimed = registry.filter(is_on).zip(at).map(|(registry, at)| {
        let text = text_under(world, registry, &sight, at);
        text.map(|text| DragText { at, text })
    });
    if aimed.is_some() {
        world.resource_mut::<ProbeLooks>().0 += 1;
    }
    world.resource_mut::<Probe>().set_if_neq(Probe(aimed.flatten()));
    Ok(())
}

/// What is in front, in words; `None` where that has no colour of its own.
fn text_under(world: &World, registry: &LayerRegistry, sight: &Sight, at: Vec2) -> Option<String> {
    let camera = &sight.rig.camera;
    let view_px = sight.rig.view_px[1].max(1.0);
    let probe = ProbeRay {
        ray: sight.ray(at)?,
        reach_rad: REACH_PX * camera.view_height_mm() / (view_px * camera.eye_distance_mm()),
        design: sight.design()?,
    };
    let is_on = registry.probes.iter().filter(|of| (of.is_on)(world));
    let values = is_on.filter_map(|of| (of.value)(world, &probe));
    let hidden = &sight.world.as_ref()?.0.document.view().hidden;
    let surfaces = world.get_resource::<Surfaces>();
    let bodies = BodyRole::ALL.into_iter().filter(|role| !hidden.has_body(*role));
    let bodies = bodies.filter_map(|role| {
        let pose = probe.design.tracker_from_body(role)?;
        let hit = surfaces?.of(role)?.hit(&probe.ray.transformed_by(&pose.inverse()))?;
        Some(Probed { distance_mm: hit.distance_mm, words: None })
    });
    // What is painted on a body is as near as the body, and comes first.
    values.chain(bodies).min_by(|a, b| a.distance_mm.total_cmp(&b.distance_mm))?.words
}
