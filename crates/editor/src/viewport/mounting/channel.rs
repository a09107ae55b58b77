//! A channel drawn by clicks: each puts a point in the middle of the body below the pointer. Enter or
//! a double click ends it.

use crate::document::requests::{EditRequest, OpenWorld};
use crate::document::state::Notice;
use crate::schedule::EditorSystems;
use crate::viewport::camera::Sight;
use crate::viewport::fine_pointer::DEAD_ZONE_PX;
use crate::viewport::mounting::state::{EditedBody, TargetClicks};
use crate::viewport::surfaces::Surfaces;
use crate::viewport::tool::SceneTool;
use bevy::ecs::system::SystemParam;
use bevy::picking::events::{Click, Pointer};
use bevy::prelude::*;
use bevy::window::RequestRedraw;
use bevy_egui::input::EguiWantsInput;
use nalgebra::{Point3, Vector3};
use trackwright_design::{BodyRole, Edit};
use trackwright_simulation::{MountingRegion, channel_point};

const FEW_POINTS: &str = "A channel needs two points: click on the body twice";
const OPEN_MESH: &str =
    "No middle of the body below this point: its mesh is open there. Type the channel's points";

/// A channel that is being drawn.
#[derive(Resource, Clone, Debug, Default, PartialEq)]
pub struct ChannelDraft {
    /// Body frame.
    pub points_mm: Vec<Point3<f64>>,
    /// Where the last click was in the window.
    clicked: Option<Vec2>,
}

impl ChannelDraft {
    /// Whether a click is the second of two at one place.
    fn is_double(&self, click: &Click, at: Vec2) -> bool {
        let is_same = |last: Vec2| last.distance(at) < DEAD_ZONE_PX;
        click.count > 1 && self.clicked.is_some_and(is_same)
    }
}

pub(super) fn plugin(app: &mut App) {
    app.init_resource::<ChannelDraft>().add_observer(on_click).add_systems(
        Update,
        (
            forget.run_if(resource_changed::<SceneTool>),
            end_on_enter
                .run_if(resource_equals(SceneTool::DrawChannel))
                .run_if(resource_exists::<ButtonInput<KeyCode>>),
        )
            .chain()
            .in_set(EditorSystems::Input),
    );
}

/// Ends a drawn channel.
#[derive(SystemParam)]
struct Drawing<'w> {
    world: Option<Res<'w, OpenWorld>>,
    draft: ResMut<'w, ChannelDraft>,
    tool: ResMut<'w, SceneTool>,
    notice: ResMut<'w, Notice>,
    edits: MessageWriter<'w, EditRequest>,
    redraws: MessageWriter<'w, RequestRedraw>,
}

impl Drawing<'_> {
    fn add(&mut self, point_mm: Option<Point3<f64>>, at: Vec2) {
        match point_mm {
            Some(point_mm) => {
                self.draft.points_mm.push(point_mm);
                self.draft.clicked = Some(at);
            }
            None => {
                self.notice.set_if_neq(Notice::Refused(OPEN_MESH.to_owned()));
            }
        }
        self.redraws.write(RequestRedraw);
    }

    /// One undo step.
    fn end(&mut self, body: BodyRole) {
        let design = self.world.as_ref().map(|world| world.0.document.design());
        let own = design.and_then(|design| design.body(body));
        let channel = MountingRegion::channel(&self.draft.points_mm);
        let (Some(own), Some(channel)) = (own, channel) else {
            self.notice.set_if_neq(Notice::Refused(FEW_POINTS.to_owned()));
            return;
        };
        let mut mounting = own.mounting.clone();
        mounting.regions.push(channel);
        let edit = Edit::SetMounting { body, mounting: Box::new(mounting) };
        let label = format!("Draw mounting channel of the {body}");
        self.edits.write_batch(EditRequest::step(label, [edit]));
        *self.tool = SceneTool::Select;
        self.redraws.write(RequestRedraw);
    }
}

/// Escape, or another tool, ends it without a channel.
fn forget(tool: Res<SceneTool>, mut draft: ResMut<ChannelDraft>) {
    if *tool != SceneTool::DrawChannel {
        draft.set_if_neq(ChannelDraft::default());
    }
}

fn end_on_enter(
    keys: Res<ButtonInput<KeyCode>>,
    egui: Option<Res<EguiWantsInput>>,
    edited: EditedBody,
    mut drawing: Drawing,
) {
    let is_typed = egui.is_some_and(|egui| egui.wants_any_keyboard_input());
    let is_enter = keys.any_just_pressed([KeyCode::Enter, KeyCode::NumpadEnter]);
    if let Some(body) = edited.get().filter(|_| is_enter && !is_typed) {
        drawing.end(body);
    }
}

/// Where a click puts a point.
#[derive(SystemParam)]
struct Below<'w> {
    sight: Sight<'w>,
    surfaces: Res<'w, Surfaces>,
}

impl Below<'_> {
    /// `None` beside the body; within, `None` where its mesh is open.
    fn point(&self, body: BodyRole, at: Vec2) -> Option<Option<Point3<f64>>> {
        let tracker_from_body = self.sight.design()?.tracker_from_body(body)?;
        let surface = self.surfaces.of(body)?;
        let hit = self.sight.hit(surface, &tracker_from_body, at)?;
        let mesh = self.sight.world.as_ref()?.0.mesh(body);
        let long_axis = mesh.map_or_else(Vector3::z, |mesh| mesh.long_axis());
        Some(channel_point(surface, &hit, &long_axis))
    }
}

fn on_click(
    mut click: On<Pointer<Click>>,
    clicks: TargetClicks,
    below: Below,
    mut drawing: Drawing,
) {
    let is_own = *drawing.tool == SceneTool::DrawChannel;
    let Some(body) = clicks.owner(&click).filter(|_| is_own).and_then(|owner| owner.body()) else {
        return;
    };
    click.propagate(false);
    let at = click.pointer_location.position;
    if drawing.draft.is_double(&click, at) {
        drawing.end(body);
    } else if let Some(point_mm) = below.point(body, at) {
        drawing.add(point_mm, at);
    }
}
