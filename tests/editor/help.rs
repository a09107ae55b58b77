//! The dialog that states what this program is.

use super::commands::app_with_commands;
use super::harness::use_open_dialog;
use bevy_egui::egui;
use egui_kittest::kittest::Queryable;
use trackwright_editor::shell::commands::RunCommand;
use trackwright_editor::shell::dialogs::{Dialogs, Outcome};
use trackwright_editor::shell::help::ABOUT;

#[test]
fn about_states_the_version_and_the_licence() {
    let mut app = app_with_commands();
    app.update();
    app.world_mut().write_message(RunCommand(ABOUT.name));
    app.update();
    let shown = app.world_mut().resource_mut::<Dialogs>().current.take();
    let mut dialog = shown.expect("a dialog");
    assert_eq!(dialog.name(), "about");
    let outcome = use_open_dialog(dialog.as_mut(), |harness| {
        harness.get_by_label(&format!("Version {}", env!("CARGO_PKG_VERSION")));
        for licence in env!("CARGO_PKG_LICENSE").split(" OR ") {
            harness.get_by_label_contains(licence);
        }
        harness.key_press(egui::Key::Escape);
    });
    assert!(matches!(outcome, Some(Outcome::Close)), "Escape closes it");
}
