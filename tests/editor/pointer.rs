//! A pointer in a window that nothing paints: presses, drags and clicks, and what they did.

use super::app::{create_scene_app, settle};
use bevy::camera::NormalizedRenderTarget;
use bevy::picking::pointer::{Location, PointerAction, PointerButton, PointerId, PointerInput};
use bevy::prelude::*;
use bevy::window::{PrimaryWindow, WindowRef};
use trackwright_design::{BodyRole, Design};
use trackwright_editor::document::requests::{EditRequest, OpenWorld};
use trackwright_editor::document::selection::{Selected, Selection};
use trackwright_editor::shell::window::ViewportRect;
use trackwright_editor::viewport::camera::OrbitRig;

/// The sensor in the straight part of the pointer's shaft.
pub const SHAFT: usize = 0;

pub struct SimulatedPointer {
    pub app: App,
}

impl SimulatedPointer {
    pub fn new() -> Self {
        let mut app = create_scene_app();
        settle(&mut app);
        Self { app }
    }

    pub fn design(&self) -> Design {
        self.app.world().resource::<OpenWorld>().0.document.design().clone()
    }

    pub fn position_mm(&self, index: usize) -> nalgebra::Point3<f64> {
        self.design().tool.body.rigid.sensors[index].position_in_body
    }

    /// Where a point of the tool is in the window.
    pub fn pixel(&self, point_in_tool: &nalgebra::Point3<f64>) -> Vec2 {
        let rig = self.app.world().resource::<OrbitRig>();
        let view = self.app.world().resource::<ViewportRect>();
        let pose = self.design().tracker_from_body(BodyRole::Tool).unwrap();
        let [x, y] = rig.camera.project(&(pose * point_in_tool), rig.view_px).unwrap();
        view.min + Vec2::new(x as f32, y as f32)
    }

    /// The sensor's pixel, and the direction on the screen in which the shaft runs back.
    pub fn shaft(&self) -> (Vec2, Vec2) {
        let at = self.position_mm(SHAFT);
        let back = self.pixel(&(at + nalgebra::Vector3::z() * 10.0));
        (self.pixel(&at), (back - self.pixel(&at)).normalize())
    }

    pub fn send(&mut self, at: Vec2, action: PointerAction) {
        let world = self.app.world_mut();
        let window = world.query_filtered::<Entity, With<PrimaryWindow>>().single(world).unwrap();
        let target = WindowRef::Primary.normalize(Some(window)).unwrap();
        world.write_message(PointerInput::new(
            PointerId::Mouse,
            Location { target: NormalizedRenderTarget::Window(target), position: at },
            action,
        ));
    }

    pub fn move_to(&mut self, at: Vec2) {
        self.send(at, PointerAction::Move { delta: Vec2::ONE });
    }

    pub fn press(&mut self, at: Vec2, button: PointerButton) {
        self.move_to(at);
        self.app.update();
        self.send(at, PointerAction::Press(button));
        self.app.update();
    }

    pub fn drag(&mut self, from: Vec2, by: Vec2, button: PointerButton) {
        self.press(from, button);
        for step in 1..=6 {
            self.move_to(from + by * step as f32 / 6.0);
            self.app.update();
        }
    }

    pub fn release(&mut self, at: Vec2, button: PointerButton) {
        self.send(at, PointerAction::Release(button));
        self.app.update();
        self.app.update();
    }

    pub fn request(&mut self, request: EditRequest) {
        self.app.world_mut().write_message(request);
        self.app.update();
    }

    pub fn undo_label(&self) -> Option<String> {
        let world = self.app.world().resource::<OpenWorld>();
        world.0.document.undo_label().map(str::to_owned)
    }

    pub fn click(&mut self, at: Vec2) {
        self.press(at, PointerButton::Primary);
        self.release(at, PointerButton::Primary);
    }

    pub fn select(&mut self, what: Option<Selected>) {
        *self.app.world_mut().resource_mut::<Selection>() = Selection::of(what);
        settle(&mut self.app);
    }

    pub fn hold(&mut self, key: KeyCode) {
        let mut keys = self.app.world_mut().resource_mut::<ButtonInput<KeyCode>>();
        keys.press(key);
    }

    /// Presses Escape. Input is cleared at the start of an update, so the key goes in just before
    /// `Update`.
    pub fn escape(&mut self) {
        self.hold(KeyCode::Escape);
        self.app.world_mut().run_schedule(Update);
    }

    /// Escape lets go: the design is as before, and the pointer moves and releases nothing more.
    pub fn assert_escape_restores(&mut self, before: &Design, at: Vec2) {
        self.escape();
        assert_eq!(self.design(), *before);
        self.move_to(at);
        self.app.update();
        self.release(at, PointerButton::Primary);
        assert_eq!(self.design(), *before);
        assert_eq!(self.undo_label(), None);
    }

    pub fn resource<R: Resource>(&self) -> &R {
        self.app.world().resource::<R>()
    }
}
