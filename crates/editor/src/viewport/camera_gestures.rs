//! What the mouse and a trackpad do to the camera.
//!
//! A drag with the middle or the right button orbits, and so does Alt with the left one; with Shift
//! it pans. The wheel zooms to the pointer. Two fingers on a trackpad orbit, with Shift they pan and
//! with Ctrl they zoom, as a pinch does.

use crate::convert;
use crate::document::requests::ActiveDrag;
use crate::document::selection::{Hovered, Selected};
use crate::document::shown::ShownDesign;
use crate::schedule::EditorSystems;
use crate::shell::mouse::{AddMouseActions, MouseAction};
use crate::shell::window::ViewportRect;
use crate::viewport::ball_handle::HoveredBall;
use crate::viewport::camera::{OrbitRig, ScenePointer, ViewKeeper};
use crate::viewport::fine_pointer::DEAD_ZONE_PX;
use crate::viewport::gizmo::HoveredHandle;
use crate::viewport::surfaces::Surfaces;
use crate::viewport::tool::SceneTool;
use bevy::ecs::system::SystemParam;
use bevy::input::gestures::PinchGesture;
use bevy::input::mouse::{MouseScrollUnit, MouseWheel};
use bevy::prelude::*;
use bevy::window::RequestRedraw;

/// What people can do to the camera.
const MOUSE: [MouseAction; 8] = [
    MouseAction::new("middle or right drag", "orbit"),
    MouseAction::new("Alt + left drag beside what can be dragged", "orbit"),
    MouseAction::new("Shift with these", "pan"),
    MouseAction::new("wheel", "zoom to the pointer"),
    MouseAction::new("two fingers on a trackpad; with Shift; with Ctrl", "orbit; pan; zoom"),
    MouseAction::new("pinch on a trackpad (macOS)", "zoom to the pointer"),
    MouseAction::new("click on an end of the axes in the corner", "look from that end"),
    MouseAction::new("drag on the axes in the corner", "orbit"),
];

/// Notches of a wheel in a pinch that doubles the size.
const NOTCHES_PER_PINCH: f32 = 5.4;

/// Pixels of a trackpad's scrolling that count as a notch of a wheel.
const PIXELS_PER_NOTCH: f32 = 40.0;

const SHIFT: [KeyCode; 2] = [KeyCode::ShiftLeft, KeyCode::ShiftRight];
const CONTROL: [KeyCode; 2] = [KeyCode::ControlLeft, KeyCode::ControlRight];
const ALT: [KeyCode; 2] = [KeyCode::AltLeft, KeyCode::AltRight];

/// Moves the camera by the mouse and a trackpad, in [`EditorSystems::Input`].
pub struct CameraGesturesPlugin;

/// Turns the camera by itself: how far the pointer of an orbiting hand would move between two
/// frames, pixels.
#[derive(Resource, Clone, Copy, Debug, Default, PartialEq)]
pub struct Turntable(pub Option<[f64; 2]>);

/// A drag that moves the camera.
#[derive(Resource, Default)]
pub struct Gesture(Option<Held>);

#[derive(Clone, Copy)]
struct Held {
    button: MouseButton,
    last: Vec2,
    has_moved: bool,
}

impl Held {
    /// Whether it moves the camera with the pointer there: the left button also clicks.
    fn is_drag(&self, at: Vec2) -> bool {
        let is_click = self.button == MouseButton::Left && at.distance(self.last) < DEAD_ZONE_PX;
        self.has_moved || !is_click
    }
}

impl Gesture {
    pub fn is_on(&self) -> bool {
        self.0.is_some()
    }

    /// Whether it moved the camera: its release is no click.
    pub fn has_moved(&self) -> bool {
        self.0.is_some_and(|held| held.has_moved)
    }
}

impl Plugin for CameraGesturesPlugin {
    fn build(&self, app: &mut App) {
        app.add_mouse_actions(&MOUSE)
            .init_resource::<Gesture>()
            .init_resource::<Turntable>()
            .add_message::<PinchGesture>()
            .add_systems(
                Update,
                (drag_camera, scroll, pinch)
                    .chain()
                    .run_if(resource_exists::<ButtonInput<MouseButton>>)
                    .in_set(EditorSystems::Input),
            )
            .add_systems(Update, turn.run_if(is_turning).in_set(EditorSystems::Input));
    }
}

/// What the left button would move if it were pressed.
#[derive(SystemParam)]
struct UnderPointer<'w> {
    active: Res<'w, ActiveDrag>,
    hovered: Option<Res<'w, Hovered>>,
    handle: Option<Res<'w, HoveredHandle>>,
    ball: Option<Res<'w, HoveredBall>>,
    tool: Option<Res<'w, SceneTool>>,
}

impl UnderPointer<'_> {
    fn is_dragged(&self) -> bool {
        let is_sensor = |hovered: &Res<Hovered>| matches!(hovered.0, Some(Selected::Sensor(..)));
        self.hovered.as_ref().is_some_and(is_sensor)
            || self.handle.as_ref().is_some_and(|handle| handle.0.is_some())
            || self.ball.as_ref().is_some_and(|ball| ball.0.is_some())
            // The brush erases.
            || self.tool.as_ref().is_some_and(|tool| **tool == SceneTool::PaintPatch)
    }
}

/// The button that begins to move the camera in this frame.
fn pressed(
    buttons: &ButtonInput<MouseButton>,
    keys: &ButtonInput<KeyCode>,
    under: &UnderPointer,
) -> Option<MouseButton> {
    let own = [MouseButton::Middle, MouseButton::Right];
    let own = own.into_iter().find(|button| buttons.just_pressed(*button));
    own.or_else(|| {
        // Over what it drags, Alt belongs to that drag.
        let is_left = buttons.just_pressed(MouseButton::Left);
        (is_left && keys.any_pressed(ALT) && !under.is_dragged()).then_some(MouseButton::Left)
    })
}

fn drag_camera(
    buttons: Res<ButtonInput<MouseButton>>,
    keys: Res<ButtonInput<KeyCode>>,
    pointer: ScenePointer,
    under: UnderPointer,
    mut gesture: ResMut<Gesture>,
    mut rig: ResMut<OrbitRig>,
    mut keeper: ViewKeeper,
) {
    if gesture.0.is_none()
        && !under.active.0
        && let Some(button) = pressed(&buttons, &keys, &under)
        && let Some(last) = pointer.over_scene()
    {
        gesture.0 = Some(Held { button, last, has_moved: false });
    }
    let Some(held) = gesture.0 else {
        return;
    };
    if let Some(at) = pointer.in_window()
        && at != held.last
        && held.is_drag(at)
    {
        move_camera(&mut rig, &keys, at - held.last);
        gesture.0 = Some(Held { last: at, has_moved: true, ..held });
    }
    if !buttons.pressed(held.button) {
        gesture.0 = None;
        keeper.keep(&mut rig);
    }
}

/// Orbits, or pans with Shift.
fn move_camera(rig: &mut OrbitRig, keys: &ButtonInput<KeyCode>, by: Vec2) {
    let drag_px = convert::pixel(by);
    let is_pan = keys.any_pressed(SHIFT);
    rig.by_hand(|camera, view_px| match is_pan {
        true => camera.pan(drag_px, view_px),
        false => camera.orbit(drag_px, view_px),
    });
}

fn is_turning(turntable: Res<Turntable>) -> bool {
    turntable.0.is_some()
}

fn turn(
    turntable: Res<Turntable>,
    mut rig: ResMut<OrbitRig>,
    mut redraws: MessageWriter<RequestRedraw>,
) {
    if let Some(way_px) = turntable.0 {
        rig.by_hand(|camera, view_px| camera.orbit(way_px, view_px));
        redraws.write(RequestRedraw);
    }
}

/// Where a camera zooms to: what lies under the pointer stays there, at its own depth.
#[derive(SystemParam)]
struct ZoomTarget<'w, 's> {
    pointer: ScenePointer<'w, 's>,
    view: Option<Res<'w, ViewportRect>>,
    surfaces: Res<'w, Surfaces>,
    shown: Option<Res<'w, ShownDesign>>,
}

impl ZoomTarget<'_, '_> {
    /// Zooms by notches of a wheel; whether the pointer was over the scene.
    fn zoom(&self, rig: &mut OrbitRig, notches: f32) -> bool {
        let (Some(at), Some(view)) = (self.pointer.over_scene(), &self.view) else {
            return false;
        };
        let pixel = view.pixel(at);
        let under = self.shown.as_ref().and_then(|shown| {
            self.surfaces.under(&shown.design, &rig.camera.ray(pixel, rig.view_px))
        });
        rig.by_hand(|camera, view_px| {
            if let Some(point) = under {
                camera.refocus(&point);
            }
            camera.zoom(f64::from(notches), pixel, view_px);
        });
        true
    }
}

fn scroll(
    mut wheel: MessageReader<MouseWheel>,
    keys: Res<ButtonInput<KeyCode>>,
    target: ZoomTarget,
    mut rig: ResMut<OrbitRig>,
    mut keeper: ViewKeeper,
) {
    let mut notches = 0.0;
    let mut fingers = Vec2::ZERO;
    for event in wheel.read() {
        match event.unit {
            MouseScrollUnit::Line => notches += event.y,
            MouseScrollUnit::Pixel if keys.any_pressed(CONTROL) => {
                notches += event.y / PIXELS_PER_NOTCH;
            }
            MouseScrollUnit::Pixel => fingers += Vec2::new(event.x, event.y),
        }
    }
    let mut has_moved = notches != 0.0 && target.zoom(&mut rig, notches);
    if fingers != Vec2::ZERO && target.pointer.over_scene().is_some() {
        move_camera(&mut rig, &keys, fingers);
        has_moved = true;
    }
    if has_moved {
        keeper.keep(&mut rig);
    }
}

fn pinch(
    mut pinches: MessageReader<PinchGesture>,
    target: ZoomTarget,
    mut rig: ResMut<OrbitRig>,
    mut keeper: ViewKeeper,
) {
    let by: f32 = pinches.read().map(|pinch| pinch.0).sum();
    if by != 0.0 && target.zoom(&mut rig, by * NOTCHES_PER_PINCH) {
        keeper.keep(&mut rig);
    }
}
