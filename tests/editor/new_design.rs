//! New designs, which were never saved.

use super::app::{create_app, dialog, document, request};
use bevy::prelude::*;
use std::fs;
use trackwright_design::{BodyRole, Edit};
use trackwright_editor::document::apply::title;
use trackwright_editor::document::dialog::DesignDialog;
use trackwright_editor::document::requests::{EditRequest, FileRequest};
use trackwright_editor::document::state::WorldGeneration;
use trackwright_editor::runner::results::Results;
use trackwright_editor::shell::dialogs::Dialogs;
use trackwright_geometry::pose::Pose;
use trackwright_project::Starter;

fn request_and_wait(app: &mut App, request: FileRequest) {
    app.world_mut().write_message(request);
    app.update();
}

fn change(app: &mut App) {
    let pose = Edit::SetToolPose(Pose::translation(9.0, 0.0, -200.0));
    request(app, EditRequest::Apply(pose));
    app.update();
}

#[test]
fn one_dialog_is_about_the_open_design() {
    let mut app = create_app();
    change(&mut app);
    // The choice of a design loses nothing; what was chosen would, and that is the one question.
    request_and_wait(&mut app, FileRequest::ShowNew);
    assert_eq!(dialog(&app), Some(&DesignDialog::New));
    let new = FileRequest::New(Starter::Tool);
    request_and_wait(&mut app, new.clone());
    let Some(DesignDialog::Unsaved { then, .. }) = dialog(&app) else {
        panic!("no question");
    };
    assert_eq!(*then, new);
    request_and_wait(&mut app, FileRequest::Discard(Box::new(new)));
    assert_eq!(app.world().resource::<WorldGeneration>().0, 1);
    assert_eq!(document(&app).design().crf, None);
    assert!(!document(&app).is_dirty());
    let title = title(document(&app), &Results::default());
    assert!(title.starts_with("untitled — "), "{title}");
}

#[test]
fn a_new_design_is_saved_with_its_files() {
    let folder = tempfile::tempdir().unwrap();
    let mut app = create_app();
    request_and_wait(&mut app, FileRequest::New(Starter::ToolOnCrf));
    change(&mut app);
    request_and_wait(&mut app, FileRequest::Save);
    let Some(DesignDialog::SaveAs(files)) = dialog(&app) else {
        panic!("no file dialog: {:?}", app.world().resource::<Dialogs>().current);
    };
    assert!(files.text.ends_with("untitled.design.ron"), "{}", files.text);
    let file = folder.path().join("mine.design.ron");
    request_and_wait(&mut app, FileRequest::SaveAs(file.clone()));
    assert!(!document(&app).is_dirty());
    let mut names: Vec<String> = fs::read_dir(folder.path())
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect();
    names.sort();
    let expected = ["crf.body.ron", "mine.design.ron", "operating-table.env.ron", "tool.body.ron"];
    assert_eq!(names, expected);
    let read = trackwright_project::open_design(&file).unwrap();
    assert_eq!(read.document.design(), document(&app).design());
    assert!(read.document.design().body(BodyRole::Crf).is_some());
}

#[test]
fn a_save_that_was_given_up_ends_nothing_later() {
    let mut app = create_app();
    request_and_wait(&mut app, FileRequest::New(Starter::Tool));
    change(&mut app);
    let quit = Box::new(FileRequest::Quit);
    request_and_wait(&mut app, FileRequest::SaveThen(quit));
    assert!(matches!(dialog(&app), Some(DesignDialog::SaveAs(_))));
    // The person closes the dialog, and saves much later.
    app.world_mut().resource_mut::<Dialogs>().current = None;
    let folder = tempfile::tempdir().unwrap();
    request_and_wait(&mut app, FileRequest::ShowSaveAs);
    let file = folder.path().join("mine.design.ron");
    request_and_wait(&mut app, FileRequest::SaveAs(file));
    assert!(!document(&app).is_dirty());
    assert!(app.should_exit().is_none());
}
