//! Commands, workspaces and panels as they register.

use super::app::create_app;
use bevy::prelude::*;
use trackwright_editor::document::commands::{CANCEL_DRAG, DocumentCommandsPlugin, REDO, UNDO};
use trackwright_editor::layers::commands::LayersCommandsPlugin;
use trackwright_editor::shell::command_palette::found;
use trackwright_editor::shell::commands::{
    AddCommand, Command, CommandRegistry, CommandsPlugin, RunCommand, VIEW,
};
use trackwright_editor::shell::registry::{AddToShell, PanelInfo, Panels, Side, Workspaces};
use trackwright_editor::shell::shell_commands::ShellCommandsPlugin;
use trackwright_editor::shell::window::Workspace;
use trackwright_editor::viewport::commands::ViewportCommandsPlugin;
use trackwright_editor::workspaces;
use trackwright_editor::workspaces::decide::DecidePlugin;
use trackwright_editor::workspaces::design::DesignPlugin;
use trackwright_editor::workspaces::field::FieldPlugin;
use trackwright_editor::workspaces::live::LivePlugin;
use trackwright_editor::workspaces::present::PresentPlugin;
use trackwright_editor::workspaces::study::StudyPlugin;
use trackwright_editor::workspaces::study::precision::PrecisionPlugin;

/// An App with every plugin that registers commands.
pub fn app_with_commands() -> App {
    let mut app = create_app();
    app.add_plugins((
        (CommandsPlugin, ShellCommandsPlugin, DocumentCommandsPlugin, ViewportCommandsPlugin),
        (DesignPlugin, FieldPlugin, StudyPlugin, PrecisionPlugin),
        (LivePlugin, DecidePlugin, PresentPlugin, LayersCommandsPlugin),
    ));
    app
}

fn of_key(
    app: &App,
    key: &str,
    modifiers: [bool; 2],
    workspace: Workspace,
) -> Option<&'static str> {
    let [control, shift] = modifiers;
    let registry = app.world().resource::<CommandRegistry>();
    registry.of_key(key, control, shift, workspace).map(|command| command.name)
}

#[test]
fn shift_distinguishes_redo_from_undo() {
    let app = app_with_commands();
    let design = workspaces::design::WORKSPACE;
    for (key, modifiers, command) in [
        ("z", [true, false], Some(UNDO.name)),
        ("z", [true, true], Some(REDO.name)),
        ("y", [true, false], Some(REDO.name)),
        ("z", [false, false], None),
    ] {
        assert_eq!(of_key(&app, key, modifiers, design), command, "{key} {modifiers:?}");
    }
}

#[test]
fn a_workspaces_own_keys_go_first() {
    let app = app_with_commands();
    for (key, workspace, command) in [
        ("right", workspaces::study::WORKSPACE, Some("Next trial")),
        ("right", workspaces::present::WORKSPACE, Some("Next slide")),
        ("right", workspaces::design::WORKSPACE, Some("Nudge sensors right")),
        ("escape", workspaces::present::WORKSPACE, Some("End the presentation")),
        ("escape", workspaces::field::WORKSPACE, Some(CANCEL_DRAG.name)),
    ] {
        let found = of_key(&app, key, [false; 2], workspace);
        assert_eq!(found, command, "{key} in {}", workspace.name);
    }
}

#[test]
fn no_two_commands_share_a_name_or_a_key() {
    let app = app_with_commands();
    let all = app.world().resource::<CommandRegistry>().all();
    assert!(all.len() > 70, "{}", all.len());
    for (i, a) in all.iter().enumerate() {
        for b in &all[i + 1..] {
            assert_ne!(a.name, b.name);
            assert_ne!((a.group, a.order), (b.group, b.order), "{} and {}", a.name, b.name);
            // Different workspaces may use one key.
            if a.group.workspace == b.group.workspace {
                let shared = a.keys.iter().find(|keys| b.keys.contains(keys));
                assert_eq!(shared, None, "{} and {}", a.name, b.name);
            }
        }
    }
}

#[test]
fn commands_are_found_by_their_words() {
    let app = app_with_commands();
    let all = app.world().resource::<CommandRegistry>().all();
    for (text, first) in [
        ("sa", Some("Save")),
        ("true errors", Some("Errors at true size")),
        ("ctrl+shift+z", Some("Redo")),
        ("xyzzy", None),
    ] {
        assert_eq!(found(all, text).first().map(|command| command.name), first, "{text}");
    }
    assert_eq!(found(all, "").len(), all.len());
}

#[test]
fn a_stranger_registers_a_workspace() {
    const MINE: Workspace =
        Workspace { name: "Mine", order: 9, command: "My workspace", ..Workspace::NONE };
    #[derive(Resource, Default)]
    struct Runs(usize);
    let mut app = app_with_commands();
    let count = |mut runs: ResMut<Runs>| runs.0 += 1;
    app.init_resource::<Runs>()
        .add_workspace(MINE)
        .add_panel(PanelInfo::new(MINE, Side::Left), |_: InMut<bevy_egui::egui::Ui>| {})
        .add_command(Command::new(VIEW, 200, "Count", "Counts"), count);
    let names: Vec<&str> =
        app.world().resource::<Workspaces>().0.iter().map(|own| own.name).collect();
    assert_eq!(names, ["Design", "Field", "Study", "Live", "Decide", "Present", "Mine"]);
    assert_eq!(app.world().resource::<Panels>().0.last().unwrap().info.workspace, "Mine");
    for name in ["My workspace", "Count"] {
        app.world_mut().write_message(RunCommand(name));
        app.update();
    }
    assert_eq!(*app.world().resource::<Workspace>(), MINE);
    assert_eq!(app.world().resource::<Runs>().0, 1);
}
