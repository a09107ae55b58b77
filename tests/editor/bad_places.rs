//! Places that nothing can be written to: what is reported, and that no edit is lost.
//!
//! Permission bits mean nothing to the superuser, who runs many of these tests: a folder under a
//! regular file is one that nobody can write to, and `/dev/full` a disk without space.

use super::app::{dialog, request};
use bevy::prelude::*;
use std::path::{Path, PathBuf};
use std::sync::mpsc::channel;
use std::time::Duration;
use tempfile::TempDir;
use trackwright_design::Edit;
use trackwright_editor::StatePlugin;
use trackwright_editor::document::apply::DocumentPlugin;
use trackwright_editor::document::autosave::{AutosavePlugin, RecoveryFolder};
use trackwright_editor::document::dialog::DesignDialog;
use trackwright_editor::document::requests::{EditRequest, FileRequest, OpenWorld};
use trackwright_editor::document::state::Notice;
use trackwright_editor::runner::wake::Waker;
use trackwright_editor::shell::dialogs::Dialogs;
use trackwright_geometry::pose::Pose;

fn app_of(world: trackwright_project::World) -> App {
    let mut app = App::new();
    app.add_plugins((MinimalPlugins, StatePlugin, DocumentPlugin))
        .insert_resource(OpenWorld(world));
    app
}

/// A design in a folder of its own.
fn saved() -> (TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("a.design.ron");
    let mut world = trackwright_project::open_builtin("pointer-on-head").unwrap();
    trackwright_project::save_as(&mut world, &file).unwrap();
    (folder, file)
}

fn open(file: &Path) -> App {
    app_of(trackwright_project::open_design(file).unwrap())
}

fn request_and_wait(app: &mut App, request: FileRequest) {
    app.world_mut().write_message(request);
    app.update();
}

fn move_tool(app: &mut App, x_mm: f64) {
    let pose = Edit::SetToolPose(Pose::translation(x_mm, 0.0, 30.0));
    request(app, EditRequest::Apply(pose));
    app.update();
}

fn tool_x(app: &App) -> f64 {
    let design = app.world().resource::<OpenWorld>().0.document.design();
    design.tool.crf_from_tool.translation.x
}

fn is_dirty(app: &App) -> bool {
    app.world().resource::<OpenWorld>().0.document.is_dirty()
}

fn refusal(app: &App) -> &str {
    match dialog(app) {
        Some(DesignDialog::NotSaved { text }) => text,
        _ => panic!("{:?}", app.world().resource::<Dialogs>().current),
    }
}

#[test]
fn a_read_only_place_is_named() {
    let (folder, file) = saved();
    let mut app = open(&file);
    move_tool(&mut app, 9.0);
    let under_a_file = file.join("b.design.ron");
    request_and_wait(&mut app, FileRequest::SaveAs(under_a_file));
    assert!(refusal(&app).contains("a file where a folder should be"));
    request_and_wait(&mut app, FileRequest::SaveAs("/proc/b.design.ron".into()));
    assert!(refusal(&app).contains("cannot be written"));
    assert_eq!((tool_x(&app), is_dirty(&app)), (9.0, true));
    let elsewhere = folder.path().join("c.design.ron");
    request_and_wait(&mut app, FileRequest::SaveAs(elsewhere.clone()));
    assert!(!is_dirty(&app));
    let read = trackwright_project::open_design(&elsewhere).unwrap();
    let pose = read.document.design().tool.crf_from_tool;
    assert_eq!(pose.translation.x, 9.0);
}

#[test]
#[cfg(target_os = "linux")]
fn a_full_disk_leaves_the_old_file_whole() {
    let (folder, file) = saved();
    let mut app = open(&file);
    move_tool(&mut app, 9.0);
    let full = folder.path().join("full.design.ron");
    std::os::unix::fs::symlink("/dev/full", &full).unwrap();
    request_and_wait(&mut app, FileRequest::SaveAs(full));
    assert!(refusal(&app).contains("no space left"), "{}", refusal(&app));
    assert_eq!((tool_x(&app), is_dirty(&app)), (9.0, true));
    assert!(trackwright_project::open_design(&file).is_ok());
    // Nor does a window close over it.
    request_and_wait(&mut app, FileRequest::Quit);
    assert!(matches!(dialog(&app), Some(DesignDialog::Unsaved { .. })));
    assert!(app.should_exit().is_none());
}

#[test]
fn the_second_editor_to_save_gets_a_dialog() {
    let (folder, file) = saved();
    let (mut one, mut other) = (open(&file), open(&file));
    move_tool(&mut one, 9.0);
    move_tool(&mut other, 7.0);
    request_and_wait(&mut one, FileRequest::Save);
    assert!(!is_dirty(&one));
    request_and_wait(&mut other, FileRequest::Save);
    assert!(matches!(dialog(&other), Some(DesignDialog::ChangedOnDisk { is_saving: true, .. })));
    assert_eq!((tool_x(&other), is_dirty(&other)), (7.0, true));
    let x_of = |file: &Path| {
        let world = trackwright_project::open_design(file).unwrap();
        world.document.design().tool.crf_from_tool.translation.x
    };
    assert_eq!(x_of(&file), 9.0);
    // Coming back to the window, reading the file again would lose the edit: a dialog opens.
    request_and_wait(&mut other, FileRequest::Reload);
    assert!(matches!(dialog(&other), Some(DesignDialog::Unsaved { .. })));
    let elsewhere = folder.path().join("b.design.ron");
    request_and_wait(&mut other, FileRequest::SaveAs(elsewhere.clone()));
    assert_eq!((x_of(&file), x_of(&elsewhere)), (9.0, 7.0));
    move_tool(&mut one, 5.0);
    request_and_wait(&mut one, FileRequest::Discard(Box::new(FileRequest::Reload)));
    assert_eq!((tool_x(&one), is_dirty(&one)), (9.0, false));
}

#[test]
fn missing_recovery_folder_does_not_stop_work() {
    let (_folder, file) = saved();
    let mut app = open(&file);
    app.insert_resource(RecoveryFolder(file.join("recovery"))).add_plugins(AutosavePlugin);
    let notice = app.world().resource::<Notice>();
    assert!(matches!(notice, Notice::Refused(text) if text.contains("save often")), "{notice:?}");
    move_tool(&mut app, 9.0);
    request_and_wait(&mut app, FileRequest::Save);
    let dialogs = app.world().resource::<Dialogs>();
    assert!(dialogs.current.is_none() && !is_dirty(&app), "{:?}", dialogs.current);
}

#[test]
fn a_lost_recovery_folder_is_reported() {
    let (folder, file) = saved();
    let recovery = folder.path().join("recovery");
    let mut app = open(&file);
    let (sender, receiver) = channel();
    app.insert_resource(Waker::new(move || {
        // A test that has ended no longer listens.
        let _ = sender.send(());
    }))
    .insert_resource(RecoveryFolder(recovery.clone()))
    .add_plugins(AutosavePlugin);
    std::fs::remove_dir_all(&recovery).unwrap();
    std::fs::write(&recovery, "").unwrap();
    move_tool(&mut app, 9.0);
    receiver.recv_timeout(Duration::from_secs(30)).expect("a word of the thread");
    app.update();
    let notice = app.world().resource::<Notice>();
    assert!(matches!(notice, Notice::Refused(text) if text.contains("save often")), "{notice:?}");
    assert_eq!((tool_x(&app), is_dirty(&app)), (9.0, true));
}
