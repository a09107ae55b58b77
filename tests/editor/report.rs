//! The report from the window: of the design as it is, made by a process of its own.

use super::app::{create_app, request, settle};
use bevy::prelude::*;
use std::path::Path;
use std::time::{Duration, Instant};
use trackwright_design::Edit;
use trackwright_editor::document::report::{ReportJob, ReportPlugin, ReportProgram};
use trackwright_editor::document::requests::{EditRequest, FileRequest, OpenWorld};
use trackwright_editor::document::state::Notice;
use trackwright_editor::runner::results::Results;
use trackwright_editor::shell::dialogs::{Dialogs, ErrorDialog};
use trackwright_geometry::pose::Pose;
use trackwright_simulation::figure_rows;

fn report_app() -> App {
    let mut app = create_app();
    app.insert_resource(ReportProgram(env!("CARGO_BIN_EXE_trackwright").into()))
        .add_plugins(ReportPlugin)
        .insert_resource(OpenWorld(
            trackwright_project::open_builtin(trackwright_project::DEFAULT_BUILTIN).unwrap(),
        ));
    settle(&mut app);
    app
}

fn write(app: &mut App, file: &Path) {
    app.world_mut().write_message(FileRequest::WriteReport(file.to_owned()));
    settle(app);
    let start = Instant::now();
    while app.world().resource::<ReportJob>().is_writing() {
        assert!(start.elapsed() < Duration::from_secs(120), "never written");
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
    let dialogs = app.world().resource::<Dialogs>();
    match dialogs.get() {
        Some(ErrorDialog { title, text }) => {
            assert_eq!(title, "The report cannot be written");
            assert!(text.contains("no-such"), "{text}");
        }
        None => panic!("{:?}", dialogs.current),
    }
}
