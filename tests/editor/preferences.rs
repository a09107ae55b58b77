//! Window and layout as they were left.

use bevy::prelude::*;
use bevy::window::{PrimaryWindow, WindowResized};
use std::fs;
use std::path::Path;
use trackwright_editor::document::state::Notice;
use trackwright_editor::palette::Theme;
use trackwright_editor::shell::preferences::{
    InterfaceScale, PreferencesPlugin, Recalled, fitting,
};
use trackwright_editor::shell::registry::AddToShell;
use trackwright_editor::shell::window::{LegendFolded, PanelsShown, Workspace};
use trackwright_editor::{StatePlugin, workspaces};
use trackwright_formats::preferences_file::Preferences;

const FILE: &str = "preferences.ron";

/// A session with preferences in a folder.
fn session(folder: &Path) -> App {
    let mut app = App::new();
    app.add_plugins((MinimalPlugins, StatePlugin))
        .add_message::<WindowResized>()
        .add_workspace(workspaces::design::WORKSPACE)
        .add_workspace(workspaces::field::WORKSPACE)
        .add_workspace(workspaces::study::WORKSPACE)
        .insert_resource(Recalled::in_folder(folder.to_owned()))
        .add_plugins(PreferencesPlugin);
    app.update();
    app
}

fn end(mut app: App) {
    app.world_mut().write_message(AppExit::Success);
    app.update();
}

fn show_window(app: &mut App, width: u32, height: u32) {
    let window =
        Window { resolution: bevy::window::WindowResolution::new(width, height), ..default() };
    let window = app.world_mut().spawn((window, PrimaryWindow)).id();
    app.world_mut().write_message(WindowResized {
        window,
        width: width as f32,
        height: height as f32,
    });
    app.update();
}

#[test]
fn the_next_session_restores_the_last() {
    let folder = tempfile::tempdir().unwrap();
    let mut app = session(folder.path());
    app.world_mut().resource_mut::<PanelsShown>().left = false;
    app.insert_resource(workspaces::study::WORKSPACE);
    app.world_mut().resource_mut::<InterfaceScale>().step(1);
    app.insert_resource(LegendFolded(Some(true)));
    show_window(&mut app, 1300, 800);
    end(app);
    let app = session(folder.path());
    let panels = *app.world().resource::<PanelsShown>();
    assert_eq!((panels.left, panels.right), (false, true));
    assert_eq!(*app.world().resource::<Workspace>(), workspaces::study::WORKSPACE);
    assert_eq!(app.world().resource::<InterfaceScale>().0, 1.1);
    assert_eq!(*app.world().resource::<LegendFolded>(), LegendFolded(Some(true)));
    let recalled = &app.world().resource::<Recalled>().preferences;
    assert_eq!(recalled.window, Some([1300, 800]));
    assert_eq!(*app.world().resource::<Notice>(), Notice::Nothing);
}

#[test]
fn an_unchanged_session_writes_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let mut app = session(folder.path());
    for _ in 0..3 {
        app.update();
    }
    end(app);
    assert!(!folder.path().join(FILE).exists());
}

#[test]
fn a_damaged_preferences_file_is_replaced() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join(FILE);
    let later = "(version: 7, moon: true)";
    for (text, is_written) in [("(version: 1, pan", true), (later, false)] {
        fs::write(&file, text).unwrap();
        let mut app = session(folder.path());
        let notice = app.world().resource::<Notice>();
        assert!(matches!(notice, Notice::Refused(refusal) if refusal.contains(FILE)), "{notice:?}");
        assert_eq!(*app.world().resource::<Theme>(), Theme::Dark);
        app.insert_resource(workspaces::field::WORKSPACE);
        app.update();
        end(app);
        assert_eq!(fs::read_to_string(&file).unwrap() != text, is_written);
    }
}

/// Nobody can make a folder under a regular file.
#[test]
fn a_read_only_state_folder_stops_nothing() {
    let file = tempfile::NamedTempFile::new().unwrap();
    let mut app = session(&file.path().join("state"));
    app.insert_resource(workspaces::field::WORKSPACE);
    app.update();
    end(app);
}

#[test]
fn a_workspace_of_another_version_is_the_first_one() {
    let folder = tempfile::tempdir().unwrap();
    let left = Preferences { workspace: "Holodeck".into(), ..Preferences::default() };
    trackwright_project::write_preferences(folder.path(), &left).unwrap();
    let app = session(folder.path());
    assert_eq!(*app.world().resource::<Workspace>(), workspaces::design::WORKSPACE);
}

#[test]
fn a_too_large_window_is_reduced() {
    let screens = || [Vec2::new(1280.0, 720.0), Vec2::new(800.0, 600.0)].into_iter();
    let fits = |width, height| fitting(Vec2::new(width, height), screens());
    assert_eq!(fits(3840.0, 700.0), Vec2::new(1280.0, 700.0));
    assert_eq!(fits(1000.0, 2000.0), Vec2::new(1000.0, 720.0));
    assert_eq!(fitting(Vec2::ONE, [].into_iter()), Vec2::ONE);
}

#[test]
fn the_interface_scales_within_bounds() {
    let mut scale = InterfaceScale::default();
    scale.step(1);
    assert_eq!(scale.0, 1.1);
    scale.step(-1);
    scale.step(-1);
    assert_eq!(scale.0, 0.9);
    for _ in 0..20 {
        scale.step(1);
    }
    assert_eq!(scale.0, 3.0);
}

#[test]
fn a_small_window_limits_the_scale() {
    let scale = |scale, width, height| InterfaceScale(scale).in_window(Vec2::new(width, height));
    assert_eq!(scale(2.0, 3840.0, 2160.0), 2.0);
    assert_eq!(scale(1.5, 1440.0, 900.0), 1.5);
    assert_eq!(scale(2.0, 1440.0, 900.0), 1.5);
    // Both sides have to fit.
    assert_eq!(scale(3.0, 4000.0, 720.0), 1.2);
    assert_eq!(scale(3.0, 1200.0, 4000.0), 1.25);
    // It only reduces what was enlarged.
    assert_eq!(scale(2.0, 640.0, 480.0), 1.0);
    assert_eq!(scale(0.8, 640.0, 480.0), 0.8);
    // Each step shows: the size that was left on a larger screen is no detour.
    let mut left = InterfaceScale(3.0);
    left.step_in_window(-1, Some(Vec2::new(1440.0, 900.0)));
    assert_eq!(left.0, 1.25);
    for _ in 0..5 {
        left.step_in_window(1, Some(Vec2::new(1440.0, 900.0)));
    }
    assert_eq!(left.0, 1.5);
}
