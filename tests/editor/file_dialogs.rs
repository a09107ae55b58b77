//! Dialogs about files: what they offer, and what the system's own dialog hands back.

use super::harness::{Requests, panel};
use bevy_egui::egui;
use egui_kittest::Harness;
use egui_kittest::kittest::{NodeT, Queryable};
use std::cell::RefCell;
use std::path::PathBuf;
use std::rc::Rc;
use trackwright_design::BodyRole;
use trackwright_editor::document::body_dialogs::MeshDialog;
use trackwright_editor::document::dialog::DesignDialog;
use trackwright_editor::document::requests::FileRequest;
use trackwright_editor::document::requests::MeshRequest;
use trackwright_editor::shell::dialogs::file_dialog::SystemChoice;
use trackwright_editor::shell::dialogs::{Dialog, DialogAnswer};
use trackwright_editor::workspaces::decide::DecideRequest;
use trackwright_editor::workspaces::decide::dialog::DecideDialog;
use trackwright_project::Starter;

/// A dialog that stays open, and all its answers.
fn shown<D: Dialog>(dialog: D) -> (Harness<'static>, Rc<RefCell<D>>, Requests<DialogAnswer<D>>) {
    let dialog = Rc::new(RefCell::new(dialog));
    let open = Rc::clone(&dialog);
    let (harness, answers) = panel([620.0, 460.0], move |ui| open.borrow_mut().ui(ui));
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
    let file = folder.path().join("b.design.ron");
    std::fs::write(&file, "").unwrap();
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
    // The field has the keys from the start.
    for (typed, is_listed) in [("mes", false), ("hes/", true), ("nothing/", true)] {
        harness.get_by_label("path").type_text(typed);
        harness.run_steps(2);
        let row = harness.query_by_label("grip.stl");
        assert_eq!(row.is_some(), is_listed, "{typed}");
    }
    assert!(answers.borrow().is_empty());
}

fn type_text(harness: &mut Harness, text: &str) {
    harness.get_by_label("path").type_text(text);
    harness.run_steps(2);
}

fn press(harness: &mut Harness, key: egui::Key) {
    harness.key_press(key);
    harness.run_steps(3);
}

fn text_of(dialog: &Rc<RefCell<impl Dialog>>) -> String {
    dialog.borrow_mut().files().expect("a file dialog").text.clone()
}

#[test]
fn the_name_without_its_ending_is_selected() {
    let folder = tempfile::tempdir().unwrap();
    let save = |name: &str| DesignDialog::save_as(folder.path().to_owned(), name);
    let (mut harness, dialog, _) = shown(save("mine.design.ron"));
    harness.run_steps(2);
    type_text(&mut harness, "other");
    assert_eq!(text_of(&dialog), "other.design.ron");
    // The same when it is opened once more, wherever the caret was left.
    *dialog.borrow_mut() = save("a-longer-name.design.ron");
    harness.run_steps(2);
    type_text(&mut harness, "x");
    assert_eq!(text_of(&dialog), "x.design.ron");
    assert!(harness.query_by_label_contains(&folder.path().display().to_string()).is_some());
}

/// A folder with designs of these names, and in it another folder.
fn designs(names: &[&str]) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    std::fs::create_dir(folder.path().join("scans")).unwrap();
    for name in names {
        std::fs::write(folder.path().join(format!("{name}.design.ron")), "").unwrap();
    }
    folder
}

#[test]
fn typing_narrows_the_list() {
    let folder = designs(&["pointer", "probe"]);
    let (mut harness, _, _) = shown(DesignDialog::open(folder.path().to_owned()));
    harness.run_steps(2);
    let is_listed = |harness: &Harness, name: &str| harness.query_by_label(name).is_some();
    for name in ["pointer.design.ron", "probe.design.ron", "scans", ".."] {
        assert!(is_listed(&harness, name), "{name}");
    }
    type_text(&mut harness, "INT");
    assert!(is_listed(&harness, "pointer.design.ron") && is_listed(&harness, ".."));
    assert!(!is_listed(&harness, "probe.design.ron") && !is_listed(&harness, "scans"));
    // A name that is only suggested narrows nothing.
    let save = DesignDialog::save_as(folder.path().to_owned(), "pointer.design.ron");
    let (mut harness, _, _) = shown(save);
    harness.run_steps(2);
    assert!(is_listed(&harness, "probe.design.ron"));
}

#[test]
fn tab_completes_a_name_and_then_goes_through_all() {
    let folder = designs(&["pointer", "pointing", "probe"]);
    let (mut harness, dialog, answers) = shown(DesignDialog::open(folder.path().to_owned()));
    harness.run_steps(2);
    type_text(&mut harness, "po");
    for expected in ["point", "pointer.design.ron", "pointing.design.ron", "pointer.design.ron"] {
        press(&mut harness, egui::Key::Tab);
        assert_eq!(text_of(&dialog), expected);
    }
    // The caret is behind the name, and Enter opens it.
    press(&mut harness, egui::Key::Enter);
    let open = FileRequest::Open(folder.path().join("pointer.design.ron"));
    assert_eq!(*answers.borrow(), [DialogAnswer::Request(open)]);
}

#[test]
fn tab_goes_into_a_folder() {
    let folder = designs(&["pointer"]);
    std::fs::write(folder.path().join("scans/head.design.ron"), "").unwrap();
    let (mut harness, dialog, _) = shown(DesignDialog::open(folder.path().to_owned()));
    harness.run_steps(2);
    type_text(&mut harness, "sc");
    press(&mut harness, egui::Key::Tab);
    assert_eq!(text_of(&dialog), format!("scans{}", std::path::MAIN_SEPARATOR));
    assert!(harness.query_by_label("head.design.ron").is_some());
    type_text(&mut harness, "h");
    press(&mut harness, egui::Key::Tab);
    assert!(text_of(&dialog).ends_with("head.design.ron"), "{}", text_of(&dialog));
}

#[test]
fn a_place_that_takes_no_file_is_named_in_the_dialog() {
    let folder = designs(&["pointer"]);
    let save = DesignDialog::save_as(folder.path().to_owned(), "mine.design.ron");
    let (mut harness, dialog, answers) = shown(save);
    harness.run_steps(2);
    for (typed, why) in [
        ("nowhere/mine", "no such file or folder"),
        ("pointer.design.ron/mine", "a file where a folder should be"),
    ] {
        harness.key_combination_modifiers(egui::Modifiers::COMMAND, &[egui::Key::A]);
        harness.run_steps(1);
        type_text(&mut harness, typed);
        press(&mut harness, egui::Key::Enter);
        assert!(harness.query_by_label_contains(why).is_some(), "{why} is not shown");
        assert!(answers.borrow().is_empty());
        assert_eq!(text_of(&dialog), typed);
    }
    let nowhere = folder.path().join("nowhere");
    std::fs::create_dir(&nowhere).unwrap();
    harness.key_combination_modifiers(egui::Modifiers::COMMAND, &[egui::Key::A]);
    harness.run_steps(1);
    type_text(&mut harness, "nowhere/mine");
    press(&mut harness, egui::Key::Enter);
    let saved = FileRequest::SaveAs(nowhere.join("mine.design.ron"));
    assert_eq!(*answers.borrow(), [DialogAnswer::Request(saved)]);
    assert_eq!(std::fs::read_dir(nowhere).unwrap().count(), 0, "trying leaves nothing");
}

#[test]
fn a_name_without_its_ending_replaces_nothing_unasked() {
    let folder = designs(&["pointer"]);
    let save = DesignDialog::save_as(folder.path().to_owned(), "mine.design.ron");
    let (mut harness, _, answers) = shown(save);
    harness.run_steps(2);
    harness.key_combination_modifiers(egui::Modifiers::COMMAND, &[egui::Key::A]);
    harness.run_steps(1);
    type_text(&mut harness, "pointer");
    press(&mut harness, egui::Key::Enter);
    let path = folder.path().join("pointer.design.ron");
    let then = FileRequest::SaveAs(path.clone());
    let replace = DesignDialog::Overwrite { path, then };
    assert_eq!(*answers.borrow(), [DialogAnswer::Become(replace)]);
}

#[test]
fn a_name_without_its_ending_is_found() {
    let folder = designs(&["pointer"]);
    for (typed, file) in [("pointer", "pointer.design.ron"), ("none", "none")] {
        let (mut harness, _, answers) = shown(DesignDialog::open(folder.path().to_owned()));
        harness.run_steps(2);
        type_text(&mut harness, typed);
        press(&mut harness, egui::Key::Enter);
        let open = FileRequest::Open(folder.path().join(file));
        assert_eq!(*answers.borrow(), [DialogAnswer::Request(open)]);
    }
}

#[test]
fn several_designs_are_added_at_once() {
    let folder = designs(&["pointer", "probe", "shaver"]);
    let (mut harness, _, answers) = shown(DecideDialog::add_design(folder.path().to_owned()));
    harness.run_steps(2);
    // A second click on one takes it back.
    for name in ["probe", "pointer", "shaver", "probe"] {
        harness.get_by_label(&format!("{name}.design.ron")).click();
        harness.run_steps(2);
    }
    assert!(answers.borrow().is_empty());
    harness.get_by_label("Add 2").click();
    harness.run_steps(2);
    let files = ["pointer", "shaver"].map(|name| folder.path().join(format!("{name}.design.ron")));
    let add = DecideRequest::AddDesigns(files.to_vec());
    assert_eq!(*answers.borrow(), [DialogAnswer::Request(add)]);
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
