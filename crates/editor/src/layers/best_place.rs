//! The best place that was found for the imagined sensor: a ball in the scene, whose value the legend
//! names. A click puts the sensor there.

use crate::document::requests::{EditRequest, OpenWorld};
use crate::document::shown::ShownDesign;
use crate::document::state::Notice;
use crate::layers::legend::{Legend, LegendKey, Legends, Swatch};
use crate::layers::placement::{FoundBest, PlacementLayer};
use crate::palette;
use crate::schedule::EditorSystems;
use crate::shell::commands::{Command, EDIT};
use crate::shell::window::Workspace;
use crate::viewport::ball_handle::{BallHandle, Balls, LARGE_PX};
use crate::widgets::basic::{length, short_name};
use bevy::picking::events::{Click, Pointer};
use bevy::picking::pointer::PointerButton;
use bevy::prelude::*;
use trackwright_design::view::Layer;
use trackwright_design::{Design, Edit};
use trackwright_simulation::{BestPlace, Sensor};

/// In the legend it comes after the colours of placement.
pub const LEGEND_ORDER: u32 = Layer::PLACEMENT.order + 1;

/// Letters of a sensor's name in the legend.
const NAME_CHARS: usize = 16;

/// What stands for the best place where there is none.
const FITS_NOWHERE: &str = "no best place: the coil fits at none";

pub const MOVE_TO_BEST: Command = Command::new(
    EDIT,
    56,
    "Move sensor to its best place",
    "Puts the selected sensor where the layer Sensor placement found the least tip error",
)
.available_if(|now| {
    let is_on = now.document().is_some_and(|own| own.view().layers.placement);
    is_on && now.workspace.edits_design && now.selection.sensors().is_some()
});

/// Marks the best place while the layer of placements is on.
pub struct BestPlacePlugin;

/// The ball at the best place, with what was found of it.
#[derive(Component, Clone, Debug, PartialEq)]
pub struct BestPlaceMark(pub BestPlace);

impl Plugin for BestPlacePlugin {
    fn build(&self, app: &mut App) {
        app.add_observer(on_click).add_systems(
            Update,
            mark.run_if(
                resource_exists::<ShownDesign>.and_then(
                    resource_changed::<PlacementLayer>
                        .or_else(resource_changed::<ShownDesign>)
                        .or_else(resource_changed::<OpenWorld>),
                ),
            )
            .after(crate::scene::bodies::BodiesSystems)
            .in_set(EditorSystems::Draw),
        );
    }
}

/// The sensor that is imagined elsewhere, as it is now.
fn own_sensor<'d>(design: &'d Design, found: &FoundBest) -> Option<&'d Sensor> {
    design.body(found.body)?.rigid.sensors.get(found.sensor)
}

fn mark(
    (layer, shown, world): (Res<PlacementLayer>, Res<ShownDesign>, Res<OpenWorld>),
    mut balls: Balls<BestPlaceMark>,
    mut legends: ResMut<Legends>,
) {
    let document = &world.0.document;
    let found = layer.best().filter(|found| found.revision == document.revision());
    let found =
        found.and_then(|found| Some((own_sensor(document.design(), &found)?.clone(), found)));
    let value = |found: &FoundBest| found.best.placement.shown_mm().map_or(String::new(), length);
    let ball = Swatch::Ball(palette::BEST_PLACE);
    let key = found.as_ref().map(|(own, found)| match *own == found.best.sensor {
        true => {
            LegendKey::new(Swatch::Nothing, format!("at the best place found: {}", value(found)))
        }
        false => LegendKey::new(ball, format!("best place found: {}", value(found))),
    });
    let fits_nowhere = layer.fits_nowhere(document.revision());
    let key = key
        .or_else(|| fits_nowhere.then(|| LegendKey::new(Swatch::Nothing, FITS_NOWHERE.to_owned())));
    let legend = Legend { keys: key.into_iter().collect(), ..Legend::default() };
    legends.set(LEGEND_ORDER, legend);
    // Over a sensor that is there already it would only hide it.
    let found = found.filter(|(own, found)| *own != found.best.sensor);
    let placed = found.and_then(|(own, found)| {
        let tracker_from_body = shown.design.tracker_from_body(found.body)?;
        let at_mm = tracker_from_body * found.best.sensor.position_in_body;
        let name = short_name(&own.name, NAME_CHARS);
        let words = format!("Click to move {name} to the best place found: {}", value(&found));
        let place = BallHandle { at_mm, radius_px: LARGE_PX };
        Some((BestPlaceMark(found.best), place, words))
    });
    balls.place("best place", |_| palette::BEST_PLACE, placed, |_, _| true);
}

/// The edit that puts the sensor there; `None` where nothing is known of the open design.
fn edit(layer: &PlacementLayer, world: &OpenWorld) -> Option<Edit> {
    let document = &world.0.document;
    let found = layer.best().filter(|found| found.revision == document.revision())?;
    let own = own_sensor(document.design(), &found)?;
    let sensor = Sensor { name: own.name.clone(), ..found.best.sensor };
    Some(Edit::SetSensor { body: found.body, index: found.sensor, sensor })
}

fn on_click(
    mut click: On<Pointer<Click>>,
    marks: Query<(), With<BestPlaceMark>>,
    layer: Res<PlacementLayer>,
    world: Option<Res<OpenWorld>>,
    workspace: Res<Workspace>,
    mut edits: MessageWriter<EditRequest>,
) {
    if !marks.contains(click.entity) {
        return;
    }
    click.propagate(false);
    if click.button == PointerButton::Primary && workspace.edits_design {
        let edit = world.and_then(|world| edit(&layer, &world));
        edits.write_batch(edit.map(EditRequest::Apply));
    }
}

/// Carries out [`MOVE_TO_BEST`].
pub(crate) fn move_on_request(
    layer: Res<PlacementLayer>,
    world: Option<Res<OpenWorld>>,
    mut edits: MessageWriter<EditRequest>,
    mut notice: ResMut<Notice>,
) {
    match world.as_ref().and_then(|world| edit(&layer, world)) {
        Some(edit) => {
            edits.write(EditRequest::Apply(edit));
        }
        None => {
            let revision = world.map(|world| world.0.document.revision());
            let why = match revision.is_some_and(|revision| layer.fits_nowhere(revision)) {
                true => "There is no best place: the coil fits at none",
                false => "The best place is not known yet",
            };
            *notice = Notice::Refused(why.to_owned());
        }
    }
}
