//! The report and exports from the window: of the design as it is, made by a process of its own, and
//! shown by other programs.

use super::app::{close_dialog, create_app, dialog, error, request, settle};
use bevy::prelude::*;
use std::path::Path;
use std::time::{Duration, Instant};
use trackwright_design::Edit;
use trackwright_editor::document::exports::{ExportJob, ExportsPlugin};
use trackwright_editor::document::open_outside::{OpenJob, OpenOutsidePlugin, Opener};
use trackwright_editor::document::own_program::OwnProgram;
use trackwright_editor::document::report::{ReportJob, ReportPlugin};
use trackwright_editor::document::requests::{EditRequest, Export, FileRequest, OpenWorld};
use trackwright_editor::document::state::Notice;
use trackwright_editor::runner::results::Results;
use trackwright_editor::shell::dialogs::ErrorDialog;
use trackwright_geometry::pose::Pose;
use trackwright_simulation::figure_rows;

fn report_app() -> App {
    let mut app = create_app();
    app.insert_resource(OwnProgram(env!("CARGO_BIN_EXE_trackwright").into()))
        .add_plugins((ReportPlugin, ExportsPlugin, OpenOutsidePlugin))
        .insert_resource(OpenWorld(
            trackwright_project::open_builtin(trackwright_project::DEFAULT_BUILTIN).unwrap(),
        ));
    settle(&mut app);
    app
}

fn write(app: &mut App, file: &Path) {
    app.world_mut().write_message(FileRequest::WriteReport(file.to_owned()));
    wait_while(app, |app| app.world().resource::<ReportJob>().is_writing());
}

fn wait_while(app: &mut App, is_busy: impl Fn(&App) -> bool) {
    settle(app);
    let start = Instant::now();
    while is_busy(app) {
        assert!(start.elapsed() < Duration::from_secs(120), "never done");
        settle(app);
    }
}

#[test]
fn the_report_is_of_the_unsaved_design() {
    let folder = tempfile::tempdir().unwrap();
    let mut app = report_app();
    let edit = |edit| EditRequest::Apply(edit);
    request(&mut app, edit(Edit::SetName("Pointer <b>as edited</b>".to_owned())));
    let pose = app.world().resource::<OpenWorld>().0.document.design().tool.crf_from_tool;
    let moved = Pose::translation(7.0, 0.0, 0.0) * pose;
    request(&mut app, edit(Edit::SetToolPose(moved)));
    settle(&mut app);
    let file = folder.path().join("report.html");
    write(&mut app, &file);
    let notice = app.world().resource::<Notice>();
    assert!(matches!(notice, Notice::Done(text) if text.contains("report.html")), "{notice:?}");
    let page = std::fs::read_to_string(&file).unwrap();
    assert!(page.contains("Pointer &lt;b&gt;as edited&lt;/b&gt;"));
    let study = app.world().resource::<Results>().study.as_ref().unwrap();
    for row in figure_rows(&study.value.figures).iter().take(14) {
        assert!(page.contains(&row.value), "{row:?}");
    }
    let document = &app.world().resource::<OpenWorld>().0.document;
    assert!(document.is_dirty(), "the open design is as it was");
}

#[test]
fn an_unwritable_place_uses_the_commands_words() {
    let folder = tempfile::tempdir().unwrap();
    let mut app = report_app();
    write(&mut app, &folder.path().join("no-such").join("report.html"));
    let ErrorDialog { title, text } = error(&app);
    assert_eq!(title, "The report cannot be written");
    assert!(text.contains("no-such"), "{text}");
}

#[test]
fn exports_are_what_the_command_writes() {
    let folder = tempfile::tempdir().unwrap();
    let mut app = report_app();
    let pose = app.world().resource::<OpenWorld>().0.document.design().tool.crf_from_tool;
    let moved = Edit::SetToolPose(Pose::translation(7.0, 0.0, 0.0) * pose);
    request(&mut app, EditRequest::Apply(moved));
    settle(&mut app);
    let saved = folder.path().join("saved");
    std::fs::create_dir(&saved).unwrap();
    let design = saved.join("a.design.ron");
    let mut copy = app.world().resource::<OpenWorld>().0.clone();
    trackwright_project::save_as(&mut copy, &design).unwrap();
    let room = saved.join("operating-table.env.ron");
    for (export, name, of) in [
        (Export::Field, "error.vti", &room),
        (Export::Tips, "tips.csv", &design),
        (Export::Scene, "scene.glb", &design),
    ] {
        let file = folder.path().join(name);
        // Replaced, since the dialog has shown that something is there.
        std::fs::write(&file, "theirs").unwrap();
        app.world_mut().write_message(FileRequest::Export(export, file.clone()));
        wait_while(&mut app, |app| app.world().resource::<ExportJob>().is_writing());
        let failed: Option<&ErrorDialog> = dialog(&app);
        assert!(failed.is_none(), "{failed:?}");
        let expected = saved.join(name);
        let [of, to] = [of, &expected].map(|path| path.display().to_string());
        crate::support::program::succeed(&["export", export.name(), &of, "--output", &to]);
        let same = std::fs::read(&file).unwrap() == std::fs::read(&expected).unwrap();
        assert!(same, "{name} differs from the command's");
    }
    let nowhere = folder.path().join("no-such").join("error.vti");
    app.world_mut().write_message(FileRequest::Export(Export::Field, nowhere));
    wait_while(&mut app, |app| app.world().resource::<ExportJob>().is_writing());
    assert!(error(&app).text.contains("no-such"));
    assert!(app.world().resource::<OpenWorld>().0.document.is_dirty());
}

/// Requests the report, with a program in the place of the browser.
#[cfg(unix)]
fn open_report(app: &mut App, opener: &str) -> Option<String> {
    close_dialog(app);
    app.insert_resource(Opener(opener.into()));
    app.world_mut().write_message(FileRequest::OpenReport);
    settle(app);
    wait_while(app, |app| app.world().resource::<OpenJob>().is_opening());
    dialog(app).map(|error: &ErrorDialog| error.text.clone())
}

#[cfg(unix)]
#[test]
fn the_last_report_is_shown_by_another_program() {
    let folder = tempfile::tempdir().unwrap();
    let mut app = report_app();
    assert_eq!(open_report(&mut app, "true"), None);
    let notice = app.world().resource::<Notice>();
    assert!(matches!(notice, Notice::Refused(text) if text.contains("Report…")), "{notice:?}");
    let file = folder.path().join("report.html");
    write(&mut app, &file);
    assert_eq!(open_report(&mut app, "true"), None);
    for (opener, why) in [("false", "ended with"), ("/no/such/opener", "cannot be started")] {
        let error = open_report(&mut app, opener).expect("an error");
        assert!(error.contains(why) && error.contains("report.html"), "{error}");
    }
    std::fs::remove_file(&file).unwrap();
    let error = open_report(&mut app, "true").expect("an error");
    assert!(error.contains("no such file"), "{error}");
}
