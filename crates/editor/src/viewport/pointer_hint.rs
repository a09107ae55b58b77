//! What the pointer can do now with a handle or a tool, in words for the status line.

use crate::document::requests::OpenWorld;
use crate::document::selection::Selected;
use crate::schedule::EditorSystems;
use crate::shell::window::PointerHint;
use crate::viewport::ball_handle::{BallWords, HoveredBall};
use crate::viewport::gizmo::drag::{HeldHandle, name_of};
use crate::viewport::gizmo::{CurrentGizmo, HoveredHandle};
use crate::viewport::sensor_drag::FollowsSurface;
use crate::viewport::tool::{SceneTool, ToolAim};
use crate::viewport::typed_move::TypedMove;
use bevy::ecs::system::SystemParam;
use bevy::prelude::*;
use trackwright_design::{BodyRole, HandleAxes};
use trackwright_geometry::gizmo::{Handle, HandleKind};
use trackwright_geometry::movement::{STEP_DEG, STEP_MM};

/// Keeps [`PointerHint`].
pub struct PointerHintPlugin;

impl Plugin for PointerHintPlugin {
    fn build(&self, app: &mut App) {
        app.add_systems(
            Update,
            show_hint
                .run_if(is_due)
                .in_set(EditorSystems::Draw)
                .after(crate::viewport::gizmo::GizmoSystems)
                .after(crate::viewport::tool::AimSystems),
        );
    }
}

fn is_due(
    hovered: Res<HoveredHandle>,
    held: Res<HeldHandle>,
    current: Res<CurrentGizmo>,
    tool: Res<SceneTool>,
    aim: Res<ToolAim>,
    ball: Res<HoveredBall>,
    (follows, typed): (Option<Res<FollowsSurface>>, Option<Res<TypedMove>>),
) -> bool {
    ball.is_changed()
        || typed.is_some_and(|typed| typed.is_changed())
        || follows.is_some_and(|follows| follows.is_changed())
        || hovered.is_changed()
        || held.is_changed()
        || current.is_changed()
        || tool.is_changed()
        || aim.is_changed()
}

/// Balls that are dragged have their own hint.
#[derive(SystemParam)]
struct Balls<'w, 's> {
    hovered: Res<'w, HoveredBall>,
    words: Query<'w, 's, &'static BallWords>,
}

impl Balls<'_, '_> {
    fn words(&self) -> Option<String> {
        let words = self.words.get(self.hovered.0?).ok()?;
        Some(words.0.clone())
    }
}

/// The handles of what is selected.
#[derive(SystemParam)]
struct Gizmo<'w> {
    world: Option<Res<'w, OpenWorld>>,
    hovered: Res<'w, HoveredHandle>,
    held: Res<'w, HeldHandle>,
    current: Res<'w, CurrentGizmo>,
}

impl Gizmo<'_> {
    fn words(&self) -> Option<String> {
        let design = self.world.as_ref()?.0.document.design();
        let shown = self.current.0?;
        match (self.held.handle(), self.hovered.0) {
            (Some(handle), _) => {
                let is_metal = matches!(self.held.target(), Some(Selected::Metal(_)));
                Some(match is_metal {
                    true => format!("{} · {METAL_FOLLOWS}", holding(handle)),
                    false => holding(handle),
                })
            }
            (None, Some(handle)) => {
                let whose = match shown.axes {
                    HandleAxes::Own => "its",
                    HandleAxes::Tracker => "the tracker's",
                };
                Some(over(handle, whose, &name_of(design, shown.target)))
            }
            (None, None) => None,
        }
    }
}

fn show_hint(
    tool: Res<SceneTool>,
    aim: Res<ToolAim>,
    gizmo: Gizmo,
    balls: Balls,
    follows: Option<Res<FollowsSurface>>,
    typed: Option<Res<TypedMove>>,
    mut hint: ResMut<PointerHint>,
) {
    let follows = follows.is_some_and(|follows| follows.0);
    let text = match *tool {
        SceneTool::Select => typed
            .and_then(|typed| typed.hint())
            .or_else(|| gizmo.words())
            .or_else(|| balls.words())
            .or_else(|| follows.then(|| FOLLOWING.to_owned())),
        tool => Some(match mounting_words(tool) {
            Some(words) => format!("{words} · Esc ends"),
            None => with_tool(tool, &aim),
        }),
    };
    hint.set_if_neq(PointerHint(text));
}

/// As long as drags are not what they usually are.
const FOLLOWING: &str =
    "Drags follow the surface: the axis of a dragged sensor turns with it · N ends";

/// A figure is that of metal some milliseconds ago.
const METAL_FOLLOWS: &str = "the figures follow as the metal is solved for";

/// Before a drag: what will move and how.
fn over(handle: Handle, whose: &str, name: &str) -> String {
    let axis = format!("{whose} {}", handle.axis.name());
    let step = step(handle);
    match handle.kind {
        HandleKind::Arrow => format!(
            "Drag to move the {name} along {axis} · Ctrl snaps to {step} · Shift moves finely"
        ),
        HandleKind::Ring => format!(
            "Drag to turn the {name} about {axis} · Ctrl snaps to {step} · Shift turns finely"
        ),
    }
}

fn holding(handle: Handle) -> String {
    let step = step(handle);
    format!("Esc takes the drag back · Shift goes finely · Ctrl snaps to {step}")
}

fn step(handle: Handle) -> String {
    match handle.kind {
        HandleKind::Arrow => format!("{STEP_MM:.0}\u{2009}mm"),
        HandleKind::Ring => format!("{STEP_DEG:.0}°"),
    }
}

fn mounting_words(tool: SceneTool) -> Option<&'static str> {
    match tool {
        SceneTool::PaintPatch => {
            Some("Drag over the selected body or anatomy to paint its patch · Alt erases")
        }
        SceneTool::ErasePatch => Some(
            "Drag over the selected body or anatomy to erase what the brush covers of its patch",
        ),
        SceneTool::DrawChannel => Some(
            "Click on the selected body for each point of the channel · Enter or a double click \
             finishes it",
        ),
        SceneTool::DrawBox => Some("Drag over the selected body to draw a forbidden box"),
        SceneTool::Select | SceneTool::AddSensor | SceneTool::SetTip => None,
    }
}

fn with_tool(tool: SceneTool, aim: &ToolAim) -> String {
    let what = |role: Option<BodyRole>| {
        let on = role.map_or_else(|| "a body".to_owned(), |role| format!("the {role}"));
        match tool {
            SceneTool::SetTip => format!("Click puts the tip of {on} there"),
            _ => format!("Click puts a sensor on {on} · Shift+click goes on"),
        }
    };
    match &aim.0 {
        None => format!("{} · Esc ends", what(None)),
        Some(Ok(point)) => match (tool, point.snap) {
            (SceneTool::SetTip, Some(snap)) => format!(
                "Click puts the tip of the {} on this {} · Alt frees it · Esc ends",
                point.body,
                snap.name()
            ),
            _ => format!("{} · Esc ends", what(Some(point.body))),
        },
        Some(Err(miss)) => format!("Nothing to click on here: {miss} · Esc ends"),
    }
}
