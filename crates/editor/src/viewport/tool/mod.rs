//! What a click in the scene does beside selecting: adding sensors, setting the tip.

pub mod aim;
pub mod preview;

use crate::document::commands::CANCEL_DRAG;
use crate::document::requests::{ActiveDrag, EditRequest};
use crate::document::selection::{Hovered, Selected, Selection};
use crate::document::state::Notice;
use crate::schedule::EditorSystems;
use crate::shell::commands::RunCommand;
use crate::shell::window::{DragReadout, DragText, Workspace};
use crate::viewport::camera::Sight;
use crate::viewport::fine_pointer::{DEAD_ZONE_PX, DragKeys};
use crate::viewport::surfaces::Surfaces;
use crate::viewport::tool::aim::{AimedPoint, Miss, aim_at, aim_tip};
use bevy::ecs::system::SystemParam;
use bevy::picking::pointer::{
    PointerAction, PointerButton, PointerId, PointerInput, PointerLocation,
};
use bevy::prelude::*;
use bevy::window::RequestRedraw;
use bevy_egui::input::EguiWantsInput;
use bevy_egui::{EguiContexts, EguiPrimaryContextPass, egui};
use trackwright_design::{BodyRole, Design, Edit, sensor_beside_last, sensor_on_surface};
use trackwright_geometry::snap::SnapKind;
use trackwright_simulation::Sensor;

/// What the pointer has in hand in the 3D view.
#[derive(Resource, Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum SceneTool {
    /// A click selects, a drag moves.
    #[default]
    Select,
    /// A click puts a sensor on a body.
    AddSensor,
    /// A click puts the tip of a body there.
    SetTip,
    /// A drag paints a mounting patch of the selected body.
    PaintPatch,
    /// A drag takes what it covers out of its mounting patch.
    ErasePatch,
    /// Clicks draw a mounting channel through it.
    DrawChannel,
    /// A drag draws a forbidden box on it.
    DrawBox,
}

impl SceneTool {
    /// The tool taken in hand, or put back where it is in hand already.
    pub fn toggled(self, tool: Self) -> Self {
        if self == tool { Self::Select } else { tool }
    }

    /// Whether it changes mounting regions, which the drags and clicks on a body themselves do.
    pub fn is_for_mounting(self) -> bool {
        matches!(self, Self::PaintPatch | Self::ErasePatch | Self::DrawChannel | Self::DrawBox)
    }
}

/// Answers clicks while a tool is in hand, and shows what they would do.
pub struct ToolPlugin;

/// When [`ToolAim`] follows the pointer.
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct AimSystems;

/// What is under the pointer; `None` without a tool, or where the pointer is elsewhere.
#[derive(Resource, Clone, Debug, Default, PartialEq)]
pub struct ToolAim(pub Option<Result<AimedPoint, Miss>>);

impl ToolAim {
    /// What the pointer snapped to.
    pub fn snap(&self) -> Option<SnapKind> {
        self.0.as_ref()?.as_ref().ok()?.snap
    }
}

impl Plugin for ToolPlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<SceneTool>()
            .init_resource::<ToolAim>()
            .add_message::<PointerInput>()
            .add_message::<RunCommand>()
            .add_plugins(preview::plugin)
            .add_systems(
                Update,
                (
                    begin.run_if(resource_changed::<SceneTool>.and_then(is_in_hand)),
                    put_back.run_if(is_in_hand),
                    answer_clicks.run_if(on_message::<PointerInput>.and_then(is_by_click)),
                )
                    .chain()
                    .in_set(EditorSystems::Input),
            )
            .add_systems(
                Update,
                aim.run_if(is_in_hand.or_else(has_aim))
                    .in_set(AimSystems)
                    .in_set(EditorSystems::Draw)
                    .before(preview::PreviewSystems),
            )
            .add_systems(EguiPrimaryContextPass, show_cursor.run_if(has_aim));
    }
}

fn is_in_hand(tool: Res<SceneTool>) -> bool {
    *tool != SceneTool::Select
}

/// Whether a click is all that the tool takes.
fn is_by_click(tool: Res<SceneTool>) -> bool {
    !tool.is_for_mounting()
}

fn has_aim(aim: Res<ToolAim>) -> bool {
    aim.0.is_some()
}

/// The edit that adds a sensor beside the last one of the body that is selected, or whose sensor
/// is; of the tool where nothing is.
pub fn add_sensor_beside(design: &Design, selection: &Selection) -> Option<Edit> {
    let body = match selection.primary() {
        Some(Selected::Body(role) | Selected::Sensor(role, _) | Selected::Tip(role)) => role,
        Some(Selected::Anatomy(_) | Selected::Metal(_)) | None => BodyRole::Tool,
    };
    let sensor = sensor_beside_last(&design.body(body)?.rigid);
    Some(Edit::AddSensor { body, sensor })
}

/// The sensor that a click at this point adds.
fn new_sensor(design: &Design, point: &AimedPoint) -> Option<Sensor> {
    let body = &design.body(point.body)?.rigid;
    Some(sensor_on_surface(body, &point.at, &point.directions))
}

/// Whoever takes a tool has read the previous line: it now states what the tool does, and
/// what would be selected or dragged no longer stands out.
fn begin(mut notice: ResMut<Notice>, mut hovered: ResMut<Hovered>) {
    notice.set_if_neq(Notice::Nothing);
    hovered.set_if_neq(Hovered(None));
}

/// Escape ends it, and so does the room's workspace, where there is nothing to put anything on.
fn put_back(
    mut commands: MessageReader<RunCommand>,
    drag: Res<ActiveDrag>,
    workspace: Res<Workspace>,
    mut tool: ResMut<SceneTool>,
    mut redraws: MessageWriter<RequestRedraw>,
) {
    let is_escape = |command: &RunCommand| command.0 == CANCEL_DRAG.name;
    let is_ended = commands.read().any(is_escape) && !drag.0;
    if is_ended || !workspace.edits_design {
        *tool = SceneTool::Select;
        redraws.write(RequestRedraw);
    }
}

/// What the tool looks at.
#[derive(SystemParam)]
struct Scene<'w> {
    sight: Sight<'w>,
    surfaces: Res<'w, Surfaces>,
    egui: Option<Res<'w, EguiWantsInput>>,
}

impl Scene<'_> {
    /// What a tool finds at a place in the window; `None` where that is not its own. The tip snaps to
    /// points of a body unless it is free.
    fn aim(&self, tool: SceneTool, at: Vec2, is_free: bool) -> Option<Result<AimedPoint, Miss>> {
        let is_egui = (self.egui.as_ref()).is_some_and(|egui| egui.wants_any_pointer_input());
        if tool == SceneTool::Select || is_egui || !self.sight.contains(at) {
            return None;
        }
        let world = &self.sight.world.as_ref()?.0;
        let design = self.sight.design()?;
        let ray = self.sight.ray(at)?;
        Some(match tool == SceneTool::SetTip && !is_free {
            true => aim_tip(world, design, &self.surfaces, &ray, &self.sight.eye()),
            false => aim_at(world, design, &self.surfaces, &ray),
        })
    }

    /// What a click on a point does.
    fn edit(&self, tool: SceneTool, point: &AimedPoint) -> Option<Edit> {
        let body = point.body;
        match tool {
            SceneTool::AddSensor => {
                let sensor = new_sensor(self.sight.design()?, point)?;
                Some(Edit::AddSensor { body, sensor })
            }
            SceneTool::SetTip => {
                Some(Edit::SetTip { body, tip_in_body: Some(point.at.position_mm) })
            }
            _ => None,
        }
    }
}

/// Takes clicks from the pointer itself: picking loses one that comes with the move to where it is
/// made, as happens while frames are slow.
fn answer_clicks(
    mut inputs: MessageReader<PointerInput>,
    mut pressed: Local<Option<Vec2>>,
    scene: Scene,
    keys: DragKeys,
    mut tool: ResMut<SceneTool>,
    mut selection: ResMut<Selection>,
    mut edits: MessageWriter<EditRequest>,
) {
    let of_mouse = |input: &&PointerInput| input.pointer_id == PointerId::Mouse;
    for input in inputs.read().filter(of_mouse) {
        let at = input.location.position;
        match input.action {
            PointerAction::Press(PointerButton::Primary) => *pressed = Some(at),
            PointerAction::Release(PointerButton::Primary) => {
                let is_click = |from: &Vec2| from.distance(at) < DEAD_ZONE_PX;
                let Some(click) = pressed.take().filter(is_click) else {
                    continue;
                };
                let Some(Ok(point)) = scene.aim(*tool, click, keys.is_off()) else {
                    continue;
                };
                if *tool == SceneTool::SetTip {
                    let tip = Some(Selected::Tip(point.body));
                    selection.set_if_neq(Selection::of(tip));
                }
                edits.write_batch(scene.edit(*tool, &point).map(EditRequest::Apply));
                // Shift is held for several.
                if !keys.is_fine() {
                    *tool = SceneTool::Select;
                }
            }
            _ => {}
        }
    }
}

fn aim(
    tool: Res<SceneTool>,
    pointers: Query<(&PointerId, &PointerLocation)>,
    scene: Scene,
    keys: DragKeys,
    mut aim: ResMut<ToolAim>,
    mut readout: ResMut<DragReadout>,
) {
    let mouse = pointers.iter().find(|(id, _)| **id == PointerId::Mouse);
    let at = mouse.and_then(|(_, at)| Some(at.location()?.position));
    let found = ToolAim(at.and_then(|at| scene.aim(*tool, at, keys.is_off())));
    let name = found.snap().zip(at).map(|(snap, at)| DragText { at, text: snap.name().to_owned() });
    // Nothing is dragged while a tool is in hand.
    if name.is_some() || aim.snap().is_some() {
        readout.set_if_neq(DragReadout(name));
    }
    aim.set_if_neq(found);
}

fn show_cursor(mut contexts: EguiContexts) -> Result {
    let icon = egui::CursorIcon::Crosshair;
    contexts.ctx_mut()?.set_cursor_icon(icon);
    Ok(())
}
