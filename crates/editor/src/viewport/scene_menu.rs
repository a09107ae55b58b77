//! Where the menu of a sensor in the scene is open.

use bevy::prelude::{Resource, Vec2};

/// Where the menu is open, in logical pixels of the window.
#[derive(Resource, Clone, Copy, Debug, Default, PartialEq)]
pub struct SceneMenu(pub Option<Vec2>);
