//! The value under the pointer: of the slice, an arrow, a painted body or a measurement, whichever is
//! in front, interpolated from what was sampled.
//!
//! It asks for no frame: a pointer that moves draws one, and in that the probe looks. It does not look
//! while nothing is coloured, something is dragged or a button is held.

use crate::document::requests::{ActiveDrag, OpenWorld};
use crate::document::selection::{Hovered, Selected};
use crate::document::shown::ShownSystems;
use crate::layers::field_arrows::ArrowLayer;
use crate::layers::placement::{PaintedValue, PlacementLayer};
use crate::runner::results::Results;
use crate::schedule::EditorSystems;
use crate::shell::window::{DragText, Workspace};
use crate::viewport::camera::{ScenePointer, Sight};
use crate::viewport::picking::Surfaces;
use crate::widgets::basic::{decimal, with_unit};
use crate::workspaces::field::desk::{FieldDesk, SampleValue};
use crate::workspaces::field::samples;
use bevy::ecs::system::SystemParam;
use bevy::prelude::*;
use trackwright_design::BodyRole;
use trackwright_geometry::surface::Ray;
use trackwright_simulation::{Quantity, Reading, SliceHit};

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
        app.init_resource::<Probe>()
            .init_resource::<ProbeLooks>()
            .init_resource::<ActiveDrag>()
            .init_resource::<Hovered>()
            .init_resource::<Workspace>()
            .init_resource::<Surfaces>()
            .add_systems(
                Update,
                probe
                    .run_if(resource_exists::<OpenWorld>)
                    .after(ShownSystems::Follow)
                    .in_set(EditorSystems::Draw),
            );
    }
}

/// What is coloured.
#[derive(SystemParam)]
struct Colored<'w> {
    results: Res<'w, Results>,
    arrows: Option<Res<'w, ArrowLayer>>,
    placement: Option<Res<'w, PlacementLayer>>,
    field: Option<Res<'w, FieldDesk>>,
    workspace: Res<'w, Workspace>,
    surfaces: Res<'w, Surfaces>,
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
            // What would be taken hold of says so itself.
            || matches!(self.hovered.0, Some(Selected::Sensor(..)))
    }
}

fn probe(
    pointer: ScenePointer,
    busy: Busy,
    sight: Sight,
    colored: Colored,
    mut looks: ResMut<ProbeLooks>,
    mut probe: ResMut<Probe>,
) {
    let is_wanted = !busy.is_any() && sight.world.as_ref().is_some_and(|w| colored.is_any(w));
    let at = pointer.over_scene().filter(|_| is_wanted);
    let text = at.and_then(|at| {
        looks.0 += 1;
        let text = colored.under(&sight, &sight.ray(at)?)?;
        Some(DragText { at, text })
    });
    probe.set_if_neq(Probe(text));
}

impl Colored<'_> {
    fn has_samples(&self) -> bool {
        *self.workspace == Workspace::Field && self.field.is_some()
    }

    fn is_any(&self, world: &OpenWorld) -> bool {
        let layers = world.0.document.view().layers;
        layers.slice || layers.arrows || layers.placement || self.has_samples()
    }

    /// What is in front along a ray, in words; `None` where that has no colour of its own.
    fn under(&self, sight: &Sight, ray: &Ray) -> Option<String> {
        let world = sight.world.as_ref()?;
        let view = world.0.document.view();
        let reach_rad = REACH_PX * sight.rig.camera.view_height_mm()
            / (sight.rig.view_px[1].max(1.0) * sight.rig.camera.distance_mm);
        let slice = self.results.slice.as_ref().filter(|_| view.layers.slice);
        let of_slice = slice.and_then(|slice| {
            let hit = slice.value.hit(ray)?;
            let words = slice_words(slice.value.quantity, &hit);
            Some((hit.distance_mm, Some(words)))
        });
        let of_arrows = self.arrows.as_ref().and_then(|layer| {
            let (along_mm, value_mm) = layer.pointed_at(ray, reach_rad)?;
            Some((along_mm, Some(named(layer.quantity(), value_mm))))
        });
        let samples = self.field.as_ref().filter(|_| self.has_samples());
        let of_samples = samples.and_then(|desk| {
            let (along_mm, (kind, value_mm)) = samples::pointed_at(desk, ray, reach_rad)?;
            let name = match kind {
                SampleValue::Measured => "error as measured",
                SampleValue::Left => "error left by the fit",
            };
            Some((along_mm, Some(named(name, value_mm))))
        });
        let bodies = BodyRole::ALL.into_iter().filter(|role| !view.hidden.has_body(*role));
        let of_bodies = bodies.filter_map(|role| self.body(sight, role, ray));
        [of_slice, of_arrows, of_samples]
            .into_iter()
            .flatten()
            .chain(of_bodies)
            .min_by(|a, b| a.0.total_cmp(&b.0))?
            .1
    }

    /// How far a body is along a ray, and what it says: nothing unless it is painted.
    fn body(&self, sight: &Sight, role: BodyRole, ray: &Ray) -> Option<(f64, Option<String>)> {
        let pose = sight.design()?.tracker_from_body(role)?;
        let in_body = ray.transformed_by(&pose.inverse());
        let own = self.surfaces.of(role);
        let painted = self.placement.as_ref().and_then(|layer| layer.under(role, own, &in_body));
        match painted {
            Some((distance_mm, value)) => {
                let words = match value {
                    Some(value) => painted_words(&value),
                    None => "no tip error, sensor here".to_owned(),
                };
                Some((distance_mm, Some(words)))
            }
            None => Some((own?.hit(&in_body)?.distance_mm, None)),
        }
    }
}

/// `expected tip error RMS 0.63 mm (95 %: 0.46 to 0.83), sensor here`.
fn painted_words(painted: &PaintedValue) -> String {
    let value = named("tip error RMS", painted.tip_rms_mm);
    match painted.interval_mm {
        Some(ends) => {
            let [low, high] = ends.map(|end| decimal(end, 2));
            format!("expected {value} (95\u{2009}%: {low} to {high}), sensor here")
        }
        None => format!("{value}, sensor here"),
    }
}

fn named(name: &str, value_mm: f64) -> String {
    format!("{name} {}", with_unit(&decimal(value_mm, 2), "mm"))
}

/// `position error 1.24 mm`.
fn slice_words(quantity: Quantity, hit: &SliceHit) -> String {
    let words = match hit.reading {
        Reading::Value(value) => {
            let value = with_unit(&decimal(value, quantity.decimals()), quantity.unit());
            format!("{} {value}", quantity.label())
        }
        Reading::Outside => return outside_words(quantity).to_owned(),
        Reading::Undetermined => return format!("{} not determined", quantity.label()),
    };
    match hit.is_supported {
        true => words,
        false => format!("{words}, {POORLY_SUPPORTED}"),
    }
}

/// What is said of field where the samples do not carry the model.
pub const POORLY_SUPPORTED: &str = "poorly supported field";

/// What is said where a slice has no value.
pub fn outside_words(quantity: Quantity) -> &'static str {
    match quantity.needs_tool() {
        true => "a sensor outside the room's box",
        false => "outside the room's box",
    }
}
