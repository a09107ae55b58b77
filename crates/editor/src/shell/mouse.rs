//! What the mouse and a trackpad do in the scene, for the page of shortcuts. Whoever answers a
//! gesture registers it.

use bevy::prelude::{App, Resource};

/// A gesture and what it does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MouseAction {
    /// As people write it: `Shift + wheel`.
    pub gesture: &'static str,
    pub effect: &'static str,
}

impl MouseAction {
    /// A gesture and what it does.
    pub const fn new(gesture: &'static str, effect: &'static str) -> Self {
        Self { gesture, effect }
    }
}

/// Every gesture that was registered, in the order of the page.
#[derive(Resource, Clone, Debug, Default)]
pub struct MouseActions(pub Vec<MouseAction>);

/// Registers gestures.
pub trait AddMouseActions {
    /// Adds gestures, below those that are there.
    fn add_mouse_actions(&mut self, actions: &[MouseAction]) -> &mut Self;
}

impl AddMouseActions for App {
    fn add_mouse_actions(&mut self, actions: &[MouseAction]) -> &mut Self {
        self.world_mut().get_resource_or_init::<MouseActions>().0.extend_from_slice(actions);
        self
    }
}
