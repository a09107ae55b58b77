//! The menu of a sensor in the scene, where the pointer asked for it.

use crate::shell::PanelAction;
use crate::workspaces::design::sensor_ui::{IsAvailable, sensor_menu_ui};
use bevy::prelude::{Resource, Vec2};
use bevy_egui::egui::{Context, Id, LayerId, Popup, PopupKind, pos2};

/// Where the menu is open, in logical pixels of the window.
#[derive(Resource, Clone, Copy, Debug, Default, PartialEq)]
pub struct SceneMenu(pub Option<Vec2>);

/// Draws the menu while it is open, and closes it once something was chosen or clicked elsewhere.
pub fn scene_menu_ui(
    ctx: &Context,
    menu: &mut SceneMenu,
    is_available: IsAvailable<'_>,
) -> Vec<PanelAction> {
    let mut actions = Vec::new();
    let Some(at) = menu.0 else { return actions };
    // egui may be zoomed; the window's logical pixels are not.
    let at = at / ctx.zoom_factor();
    let mut is_open = true;
    Popup::new(Id::new("scene menu"), ctx.clone(), pos2(at.x, at.y), LayerId::background())
        .kind(PopupKind::Menu)
        .open_bool(&mut is_open)
        .show(|ui| sensor_menu_ui(ui, is_available, &mut actions));
    if !is_open {
        menu.0 = None;
    }
    actions
}
