//! The report and exports from the window: of the design as it is, made by a process of its own, and
//! shown by other programs.

use super::app::{close_dialog, create_app, dialog, error, request, settle};
use super::harness::use_panel;
use bevy::prelude::*;
use egui_kittest::kittest::Queryable;
use std::path::Path;
use std::time::{Duration, Instant};
use trackwright_design::Edit;
use trackwright_editor::document::exports::ExportsPlugin;
use trackwright_editor::document::open_outside::{OpenJob, OpenOutsidePlugin, Opener};
use trackwright_editor::document::own_program::{OwnProgram, OwnProgramPlugin, WriteJob};
use trackwright_editor::document::report::{LastReport, ReportPlugin};
use trackwright_editor::document::requests::{EditRequest, Export, FileRequest, OpenWorld};
use trackwright_editor::document::state::Notice;
use trackwright_editor::runner::results::Results;
use trackwright_editor::shell::dialogs::ErrorDialog;
use trackwright_editor::shell::status_bar::{StatusView, status_bar_ui};
use trackwright_geometry::pose::Pose;

fn report_app() -> App {
    let mut app = create_app();
    app.insert_resource(OwnProgram(env!("CARGO_BIN_EXE_trackwright").into()))
        .add_plugins((OwnProgramPlugin, ReportPlugin, ExportsPlugin, OpenOutsidePlugin))
        .insert_resource(OpenWorld(
            trackwright_project::open_builtin(trackwright_project::DEFAULT_BUILTIN).unwrap(),
        ));
    settle(&mut app);
    app
}

fn write(app: &mut App, file: &Path) {
    app.world_mut().write_message(FileRequest::WriteReport(file.to_owned()));
    wait_while(app, is_writing);
}

fn is_writing(app: &App) -> bool {
    app.world().resource::<WriteJob>().is_writing()
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
    for figure in study.value.figures.bounded() {
        let interval = figure.interval_text(4).unwrap();
        assert!(page.contains(&figure.value_text(4)) && page.contains(&interval), "{figure:?}");
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
        wait_while(&mut app, is_writing);
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
    wait_while(&mut app, is_writing);
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

/// Requests a file of a program that never ends, until half of it is there; the process.
#[cfg(unix)]
fn write_without_end(app: &mut App, file: &Path, request: FileRequest) -> String {
    let program = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/editor/never_ends.sh");
    app.insert_resource(OwnProgram(program.into()));
    app.world_mut().write_message(request);
    let half = file.with_file_name(".trackwright-half.tmp");
    let process = || std::fs::read_to_string(&half).ok().filter(|text| text.ends_with('\n'));
    wait_while(app, |_| process().is_none());
    assert!(is_writing(app));
    process().unwrap()
}

#[cfg(unix)]
fn is_running(process: &str) -> bool {
    let signal = format!("kill -0 {process}");
    std::process::Command::new("sh").args(["-c", &signal]).output().unwrap().status.success()
}

#[cfg(unix)]
#[test]
fn cancel_ends_the_program_and_leaves_no_file() {
    let folder = tempfile::tempdir().unwrap();
    let mut app = report_app();
    let [page, tips] = ["report.html", "tips.csv"].map(|name| folder.path().join(name));
    std::fs::write(&tips, "older").unwrap();
    for (file, request) in [
        (&page, FileRequest::WriteReport(page.clone())),
        (&tips, FileRequest::Export(Export::Tips, tips.clone())),
    ] {
        let name = file.file_name().unwrap().to_str().unwrap();
        let process = write_without_end(&mut app, file, request.clone());
        assert!(is_running(&process));
        assert_eq!(app.world().resource::<WriteJob>().file_name().as_deref(), Some(name));
        app.world_mut().write_message(request);
        app.update();
        let notice = app.world().resource::<Notice>();
        let refused = Notice::Refused(format!("{name} is being written"));
        assert_eq!(*notice, refused, "one at a time");
        app.world_mut().write_message(FileRequest::CancelWriting);
        wait_while(&mut app, is_writing);
        let notice = app.world().resource::<Notice>();
        assert_eq!(*notice, Notice::Done(format!("Cancelled writing {name}")));
        assert!(dialog::<ErrorDialog>(&app).is_none());
        assert!(!is_running(&process));
        let left = std::fs::read_dir(folder.path()).unwrap();
        let left: Vec<_> = left.map(|entry| entry.unwrap().file_name()).collect();
        assert_eq!(left, ["tips.csv"]);
        assert_eq!(std::fs::read_to_string(&tips).unwrap(), "older");
    }
    assert_eq!(*app.world().resource::<LastReport>(), LastReport(None));
}

#[cfg(unix)]
#[test]
fn an_exit_ends_what_is_being_written() {
    let folder = tempfile::tempdir().unwrap();
    let mut app = report_app();
    let file = folder.path().join("report.html");
    let process = write_without_end(&mut app, &file, FileRequest::WriteReport(file.clone()));
    app.world_mut().write_message(AppExit::Success);
    app.update();
    assert!(!is_writing(&app));
    assert!(!is_running(&process));
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
}

#[test]
fn the_status_bar_names_and_cancels_what_is_written() {
    let status = StatusView {
        hint: String::new(),
        note: None,
        study: None,
        outside: 0,
        writing: Some("needle.html".to_owned()),
        notice: &Notice::Nothing,
    };
    let requests = use_panel(
        [700.0, 40.0],
        |ui| status_bar_ui(ui, &status),
        |harness| {
            harness.get_by_label("Writing needle.html…");
            harness.get_by_label("Cancel").click();
        },
    );
    assert_eq!(requests, [FileRequest::CancelWriting]);
}
