//! The menu of a sensor in the scene, where the pointer requested it.

use crate::schedule::UiSystems;
use crate::shell::commands::{Availability, Command, RunCommand};
use crate::shell::requests::Requests;
use crate::viewport::scene_menu::SceneMenu;
use crate::workspaces::design::actions::DesignAction;
use crate::workspaces::design::sensor_ui::sensor_menu_ui;
use bevy::prelude::*;
use bevy_egui::egui::{Id, LayerId, Popup, PopupKind, pos2};
use bevy_egui::{EguiContexts, EguiPrimaryContextPass};

pub(crate) fn plugin(app: &mut App) {
    app.add_systems(
        EguiPrimaryContextPass,
        menu.run_if(resource_exists::<SceneMenu>.and_then(is_open)).in_set(UiSystems::Dialogs),
    );
}

fn is_open(menu: Res<SceneMenu>) -> bool {
    menu.0.is_some()
}

/// Draws the menu, and closes it once something was chosen or clicked elsewhere.
fn menu(
    mut contexts: EguiContexts,
    mut menu: ResMut<SceneMenu>,
    available: Availability,
    mut requests: Requests<RunCommand>,
) -> Result {
    let ctx = contexts.ctx_mut()?;
    let menu = menu.bypass_change_detection();
    let Some(at) = menu.0 else { return Ok(()) };
    // egui may be zoomed; the window's logical pixels are not.
    let at = at / ctx.zoom_factor();
    let situation = available.situation();
    let (mut is_open, mut actions) = (true, Vec::new());
    Popup::new(Id::new("scene menu"), ctx.clone(), pos2(at.x, at.y), LayerId::background())
        .kind(PopupKind::Menu)
        .open_bool(&mut is_open)
        .show(|ui| {
            let is_available = |command: &Command| situation.allows(command);
            sensor_menu_ui(ui, &is_available, &mut actions);
        });
    for action in actions {
        if let DesignAction::Run(command) = action {
            requests.write(RunCommand(command));
        }
    }
    if !is_open {
        menu.0 = None;
        ctx.request_repaint();
    }
    Ok(())
}
