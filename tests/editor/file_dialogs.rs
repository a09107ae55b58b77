//! Dialogs about files: what they offer, and what the system's own dialog hands back.

use bevy_egui::egui;
use egui_kittest::Harness;
use egui_kittest::kittest::{NodeT, Queryable};
use std::cell::RefCell;
use std::path::PathBuf;
use std::rc::Rc;
use trackwright_design::BodyRole;
use trackwright_editor::document::body_dialogs::MeshDialog;
use trackwright_editor::document::dialog::DesignDialog;
use trackwright_editor::document::meshes::MeshRequest;
use trackwright_editor::document::requests::FileRequest;
use trackwright_editor::shell::dialogs::file_dialog::SystemChoice;
use trackwright_editor::shell::dialogs::{Dialog, DialogAnswer};
use trackwright_project::Starter;

type Answers<D> = Rc<RefCell<Vec<DialogAnswer<D>>>>;

/// A dialog that stays open, and all its answers.
fn shown<D: Dialog>(dialog: D) -> (Harness<'static>, Rc<RefCell<D>>, Answers<D>) {
    let (answers, dialog) = (Answers::default(), Rc::new(RefCell::new(dialog)));
    let (sink, open) = (Rc::clone(&answers), Rc::clone(&dialog));
    let harness = Harness::builder().with_size(egui::vec2(620.0, 460.0)).build_ui(move |ui| {
        trackwright_editor::widgets::theme::apply(ui.ctx());
        sink.borrow_mut().extend(open.borrow_mut().ui(ui));
    });
    (harness, dialog, answers)
}

fn choose(dialog: &Rc<RefCell<impl Dialog>>, choice: SystemChoice) {
    dialog.borrow_mut().files().expect("a file dialog").system = choice;
}

#[test]
fn the_system_dialogs_choice_is_used() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("grip.stl");
    std::fs::write(&file, "").unwrap();
    let load = MeshDialog::load(folder.path().to_owned(), BodyRole::Crf);
    let (mut harness, dialog, answers) = shown(load);
    harness.get_by_label("System dialog…").click();
    harness.run_steps(2);
    let mut open = dialog.borrow_mut();
    let files = open.files().unwrap();
    assert_eq!(files.system, SystemChoice::Requested);
    assert!(!files.is_saving && files.folder.is_dir());
    drop(open);
    choose(&dialog, SystemChoice::Open);
    harness.run_steps(2);
    assert!(harness.query_by_label("The system dialog is open").is_some());
    choose(&dialog, SystemChoice::Chosen(file.clone()));
    harness.run_steps(2);
    let load = MeshRequest::load(BodyRole::Crf, file.clone());
    assert_eq!(*answers.borrow(), [DialogAnswer::Request(load)]);
    // Replacing an existing file needs confirmation, wherever it was chosen.
    let save = DesignDialog::save_as(folder.path().to_owned(), "a.design.ron");
    let (mut harness, dialog, answers) = shown(save);
    choose(&dialog, SystemChoice::Chosen(file.clone()));
    harness.run_steps(2);
    let replace = DesignDialog::Overwrite { path: file.clone(), then: FileRequest::SaveAs(file) };
    assert_eq!(*answers.borrow(), [DialogAnswer::Become(replace)]);
}

#[test]
fn the_list_follows_the_typed_folder() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::create_dir(folder.path().join("meshes")).unwrap();
    std::fs::write(folder.path().join("meshes/grip.stl"), "").unwrap();
    let load = MeshDialog::load(folder.path().to_owned(), BodyRole::Tool);
    let (mut harness, _, answers) = shown(load);
    harness.run_steps(2);
    assert!(harness.query_by_label("grip.stl").is_none());
    // The field has the keys from the start, with the folder in it.
    for (typed, is_listed) in [("mes", false), ("hes/", true), ("nothing/", true)] {
        harness.get_by_label("path").type_text(typed);
        harness.run_steps(2);
        let row = harness.query_by_label("grip.stl");
        assert_eq!(row.is_some(), is_listed, "{typed}");
    }
    assert!(answers.borrow().is_empty());
}

#[test]
fn without_a_system_dialog_ours_is_used() {
    let folder = tempfile::tempdir().unwrap();
    let (mut harness, dialog, answers) = shown(DesignDialog::open(folder.path().to_owned()));
    choose(&dialog, SystemChoice::Nothing("this system has none".into()));
    harness.run_steps(2);
    assert!(harness.query_by_label_contains("this system has none").is_some());
    let button = harness.get_by_label("System dialog…");
    assert!(!button.accesskit_node().is_disabled());
    assert!(answers.borrow().is_empty());
}

#[test]
fn a_new_design_begins_with_or_without_a_crf() {
    for (label, starter) in [("Tool alone", Starter::Tool), ("Tool and CRF", Starter::ToolOnCrf)] {
        let (mut harness, _, answers) = shown(DesignDialog::New);
        harness.get_by_label(label).click();
        harness.run_steps(2);
        let new = DialogAnswer::Request(FileRequest::New(starter));
        assert_eq!(*answers.borrow(), [new]);
    }
}

#[test]
fn a_failed_save_can_be_saved_elsewhere() {
    let error = trackwright_project::StoreError::Write {
        file: PathBuf::from("/full/a.design.ron"),
        cause: std::io::ErrorKind::StorageFull.into(),
    };
    let (mut harness, _, answers) = shown(DesignDialog::not_saved(&error));
    for text in ["/full/a.design.ron", "no space left", "Nothing is lost"] {
        let found = harness.query_by_label_contains(text);
        assert!(found.is_some(), "{text:?} is not shown");
    }
    harness.get_by_label("Save as…").click();
    harness.run_steps(2);
    let elsewhere = DialogAnswer::Request(FileRequest::ShowSaveAs);
    assert_eq!(*answers.borrow(), [elsewhere]);
}
