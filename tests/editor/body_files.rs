//! Tool definitions in the window: dropped, opened, confirmed, refused, shown and written.

use super::app::{close_dialog, dialog, error, request, write};
use super::drops::{app, drop_file};
use super::harness::{Requests, panel, use_dialog, use_panel};
use super::meshes::finish;
use crate::support::studies;
use bevy::prelude::*;
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;
use nalgebra::{Point3, Vector3};
use std::fs;
use std::path::Path;
use trackwright_design::{BodyRole, Edit, View};
use trackwright_editor::document::body_dialogs::BodyDialog;
use trackwright_editor::document::body_files::BodyLoading;
use trackwright_editor::document::commands::{OPEN_CRF, OPEN_TOOL};
use trackwright_editor::document::requests::BodyFileRequest;
use trackwright_editor::document::requests::{EditRequest, FileRequest, OpenWorld};
use trackwright_editor::document::selection::{Selected, Selection};
use trackwright_editor::document::state::Notice;
use trackwright_editor::shell::commands::{Command, Situation};
use trackwright_editor::shell::dialogs::{DialogAnswer, Dialogs, ErrorDialog};
use trackwright_editor::shell::window::PanelsShown;
use trackwright_editor::workspaces;
use trackwright_editor::workspaces::design::actions::DesignAction;
use trackwright_editor::workspaces::design::body_file_ui::{BodyFileView, body_file_ui};
use trackwright_editor::workspaces::design::outliner::outliner_ui;
use trackwright_editor::workspaces::design::outliner_row::OutlinerView;
use trackwright_formats::BodyFile;
use trackwright_formats::tool_definition::{DefinitionFormat, OnMismatch, from_body};
use trackwright_simulation::{Mounting, RigidBody, Sensor, SensorOrientation};

/// The image of a tool of these sensors, and a byte behind it that is none of its own.
fn image(sensors: Vec<SensorOrientation>) -> Vec<u8> {
    let sensors = sensors.into_iter().enumerate().map(|(k, orientation)| Sensor {
        name: format!("s{k}"),
        ..studies::sensor([30.0 * k as f64, (k * k) as f64, 40.0], orientation)
    });
    let body = studies::body(sensors.collect(), None);
    let rigid = RigidBody { name: "8700339".into(), ..body };
    let body = BodyFile { rigid, mesh: None, definition: None, mounting: Mounting::default() };
    let conversion = from_body(&body, DefinitionFormat::Rom).unwrap();
    [&conversion.definition.write()[..], &[0xee]].concat()
}

fn coils() -> Vec<u8> {
    let axes = [Vector3::z_axis(), Vector3::x_axis()];
    image(axes.map(SensorOrientation::FiveDof).to_vec())
}

fn markers() -> Vec<u8> {
    image(vec![SensorOrientation::Marker; 4])
}

fn request_and_wait(app: &mut App, request: BodyFileRequest) {
    app.world_mut().write_message(request);
    finish(app);
}

fn world(app: &App) -> &trackwright_project::World {
    &app.world().resource::<OpenWorld>().0
}

fn select(app: &mut App, what: Selected) {
    app.insert_resource(Selection::of(Some(what)));
}

/// Checks the open dialog's texts, and sends the request of one of its buttons.
fn press(app: &mut App, texts: &[&str], button: &str) {
    let question: BodyDialog = dialog(app).cloned().expect("a dialog");
    let answer = use_dialog(question, |harness| {
        for text in texts {
            let found = harness.query_by_label_contains(text);
            assert!(found.is_some(), "{text:?} is not shown");
        }
        harness.get_by_label(button).click();
    });
    close_dialog(app);
    match answer {
        Some(DialogAnswer::Request(request)) => request_and_wait(app, request),
        Some(DialogAnswer::Close) => {}
        other => panic!("{button}: {other:?}"),
    }
}

/// The section of the tool's definition, and what it requests.
fn section(app: &App) -> (Harness<'_>, Requests<DesignAction>) {
    let (world, loading) = (world(app), app.world().resource::<BodyLoading>());
    panel([276.0, 600.0], move |ui| {
        let view = BodyFileView::of(world, BodyRole::Tool, loading).unwrap();
        body_file_ui(ui, &view)
    })
}

#[test]
fn a_dropped_definition_is_one_undo_step() {
    let (folder, mut app) = app();
    let rom = write(&folder, "roms/8700339.rom", coils());
    let before = world(&app).document.shared_design();
    select(&mut app, Selected::Sensor(BodyRole::Tool, 1));
    drop_file(&mut app, &rom);
    assert!(app.world().resource::<Dialogs>().current.is_none());
    let document = &world(&app).document;
    let tool = &document.design().tool;
    assert_eq!(document.undo_label(), Some("Use 8700339 as the tool"));
    assert_eq!(tool.crf_from_tool, before.tool.crf_from_tool);
    let sensors = &tool.body.rigid.sensors;
    let names: Vec<_> = sensors.iter().map(|s| s.name.as_str()).collect();
    assert_eq!(names, ["coil 1", "coil 2"]);
    assert_eq!(sensors[1].position_in_body, Point3::new(30.0, 1.0, 40.0));
    assert_eq!(sensors[1].orientation.degrees_of_freedom(), 5);
    let selected = app.world().resource::<Selection>().primary();
    assert_eq!(selected, Some(Selected::Body(BodyRole::Tool)));
    request(&mut app, EditRequest::Undo);
    app.update();
    assert_eq!(world(&app).document.design(), &*before);
    assert!(!world(&app).document.is_dirty());
    assert!(world(&app).mesh(BodyRole::Tool).is_some());
}

#[test]
fn without_a_selection_a_dialog_selects_the_body() {
    let (folder, mut app) = app();
    let rom = write(&folder, "8700339.rom", markers());
    drop_file(&mut app, &rom);
    assert_eq!(world(&app).document.undo_label(), None);
    press(&mut app, &["What is this tool", "8700339.rom"], "The CRF");
    let design = world(&app).document.design();
    let crf = design.body(BodyRole::Crf).unwrap();
    assert_eq!(crf.rigid.sensors.len(), 4);
    assert!(crf.rigid.sensors.iter().all(|s| s.orientation == SensorOrientation::Marker));
    assert!(design.tool.body.definition.is_none());
    // Once more it changes nothing, and that is reported.
    request_and_wait(&mut app, BodyFileRequest::open(BodyRole::Crf, rom));
    let text = "The CRF already matches 8700339.rom".to_owned();
    assert_eq!(*app.world().resource::<Notice>(), Notice::Done(text));
}

#[test]
fn a_wrong_checksum_needs_consent() {
    let (folder, mut app) = app();
    let mut bytes = coils();
    bytes[60] ^= 1;
    let rom = write(&folder, "8700339.rom", &bytes);
    select(&mut app, Selected::Body(BodyRole::Tool));
    drop_file(&mut app, &rom);
    press(&mut app, &["8700339.rom: checksum is ", "expected "], "Don't use it");
    assert_eq!(world(&app).document.undo_label(), None);
    drop_file(&mut app, &rom);
    press(&mut app, &[], "Use it anyway");
    assert!(app.world().resource::<Dialogs>().current.is_none());
    let definition = world(&app).document.design().tool.body.definition.clone();
    assert_eq!(definition.unwrap().bytes, bytes);
    let (mut harness, _) = section(&app);
    harness.run_steps(2);
    assert!(harness.query_by_label_contains("whose checksum is").is_some());
}

#[test]
fn an_invalid_definition_changes_nothing() {
    let (folder, mut app) = app();
    let before = world(&app).document.shared_design();
    let whole = markers();
    let cuts = [0, 1, 3, 4, 100, 751];
    let cut = cuts.map(|length| ("8700339.rom", whole[..length].to_vec()));
    let others = [
        ("a.json", b"{\"count\": 2, \"fiducials\": []}".to_vec()),
        ("a.ini", b"[geometry]\ncount=x\n".to_vec()),
        ("a.tool", b"<plist>".to_vec()),
        ("a.body.ron", b"(version: 1, name: \"a\", sensors: [])".to_vec()),
    ];
    for (name, bytes) in cut.into_iter().chain(others) {
        let file = write(&folder, name, &bytes);
        request_and_wait(&mut app, BodyFileRequest::open(BodyRole::Tool, file));
        let ErrorDialog { title, text } = error(&app);
        assert_eq!(title, "The tool definition cannot be used");
        assert!(text.contains(name) && text.contains("expected"), "{text}");
        assert_eq!(world(&app).document.design(), &*before);
        close_dialog(&mut app);
    }
    assert_eq!(world(&app).document.undo_label(), None);
    assert!(!world(&app).document.is_dirty());
}

#[test]
fn save_never_overwrites_the_makers_file() {
    let (folder, mut app) = app();
    let rom = write(&folder, "pointer.rom", coils());
    request_and_wait(&mut app, BodyFileRequest::open(BodyRole::Tool, rom.clone()));
    let old_body = fs::read(folder.path().join("pointer.body.ron")).unwrap();
    app.world_mut().write_message(FileRequest::Save);
    app.update();
    assert!(app.world().resource::<Dialogs>().current.is_none());
    assert!(!world(&app).document.is_dirty());
    assert_eq!(fs::read(&rom).unwrap(), coils());
    assert_eq!(fs::read(folder.path().join("pointer.body.ron")).unwrap(), old_body);
    let saved = trackwright_project::open_design(&folder.path().join("a.design.ron")).unwrap();
    let tool = &saved.document.design().tool.body;
    assert_eq!(tool.reference, "pointer-2.body.ron");
    assert_eq!(tool.definition.as_ref().unwrap().bytes, coils());
}

#[test]
fn losses_are_listed_before_writing() {
    let (folder, mut app) = app();
    let tip =
        Edit::SetTip { body: BodyRole::Tool, tip_in_body: Some(Point3::new(0.0, 0.0, -12.5)) };
    request(&mut app, EditRequest::Apply(tip));
    request_and_wait(&mut app, BodyFileRequest::ShowSave(BodyRole::Tool));
    let Some(BodyDialog::Save { files, .. }) = dialog(&app) else {
        panic!("{:?}", app.world().resource::<Dialogs>().current);
    };
    assert!(files.text.ends_with("pointer.rom"), "{}", files.text);
    close_dialog(&mut app);
    let file = folder.path().join("out.rom");
    let body = BodyRole::Tool;
    let save = |file: &Path| BodyFileRequest::Save { body, file: file.to_owned() };
    let texts = [
        "Save out.rom?",
        "The tool is written as an NDI Aurora ROM:",
        "without the tip (0 0 -12.5 mm)",
        "writing Aurora ROMs is experimental",
        "a new image",
    ];
    request_and_wait(&mut app, save(&file));
    press(&mut app, &texts, "Cancel");
    assert!(!file.exists());
    request_and_wait(&mut app, save(&file));
    press(&mut app, &texts, "Save");
    let read =
        trackwright_project::Files::default().read_tool(&file, OnMismatch::Refuse).unwrap().body;
    let own = &world(&app).document.design().tool.body.rigid.sensors;
    assert_eq!(read.rigid.sensors.len(), own.len());
    for (read, own) in read.rigid.sensors.iter().zip(own) {
        // Places are kept in 32 bits: half a step at 256 mm.
        assert!((read.position_in_body - own.position_in_body).norm() < 2e-5);
    }
    let notice = app.world().resource::<Notice>();
    assert!(
        matches!(notice, Notice::Done(text) if text.starts_with("Wrote the tool as an NDI Aurora ROM")),
        "{notice:?}"
    );
    // Replacing an existing file needs confirmation, whatever it is.
    fs::write(&file, "theirs").unwrap();
    request_and_wait(&mut app, save(&file));
    press(&mut app, &["Replace out.rom?", "exists already"], "Cancel");
    assert_eq!(fs::read(&file).unwrap(), b"theirs");
    request_and_wait(&mut app, save(&file));
    press(&mut app, &[], "Replace");
    assert!(trackwright_project::Files::default().read_tool(&file, OnMismatch::Refuse).is_ok());
    // Files of the design are Save's alone, and a name has to state a format.
    for (name, reason) in [
        ("pointer.body.ron", "the design itself uses this file"),
        ("out", "expected one in .body.ron, .rom"),
    ] {
        request_and_wait(&mut app, save(&folder.path().join(name)));
        let text = &error(&app).text;
        assert!(text.contains(reason), "{name}: {text}");
    }
}

#[test]
fn the_next_definition_is_looked_for_beside_the_last() {
    let (folder, mut app) = app();
    let begins_in = |app: &mut App| {
        request_and_wait(app, BodyFileRequest::ShowOpen(BodyRole::Crf));
        let Some(BodyDialog::Open { files, .. }) = dialog(app) else {
            panic!("no dialog");
        };
        let folder = files.folder.canonicalize().unwrap();
        app.world_mut().resource_mut::<Dialogs>().current = None;
        folder
    };
    assert_eq!(begins_in(&mut app), folder.path().canonicalize().unwrap());
    let rom = write(&folder, "roms/8700339.rom", coils());
    request_and_wait(&mut app, BodyFileRequest::open(BodyRole::Tool, rom));
    assert_eq!(begins_in(&mut app), folder.path().join("roms").canonicalize().unwrap());
}

#[test]
fn an_unchanged_file_is_written_to_the_byte() {
    let (folder, mut app) = app();
    for (name, bytes) in [("coils.rom", coils()), ("markers.rom", markers())] {
        let rom = write(&folder, name, &bytes);
        request_and_wait(&mut app, BodyFileRequest::open(BodyRole::Tool, rom));
        let file = folder.path().join(format!("back-{name}"));
        let body = BodyRole::Tool;
        request_and_wait(&mut app, BodyFileRequest::Save { body, file: file.clone() });
        if let Some(BodyDialog::Write { notes, .. }) = dialog(&app) {
            // Nothing is lost; what is experimental is reported all the same.
            assert_eq!(notes.len(), 1, "{notes:?}");
            press(&mut app, &["experimental"], "Save");
        }
        assert_eq!(fs::read(&file).unwrap(), bytes);
    }
}

#[test]
fn the_inspector_shows_a_definitions_facts() {
    let (folder, mut app) = app();
    {
        let (mut harness, requests) = section(&app);
        harness.run_steps(2);
        assert!(harness.query_by_label_contains("none: the body").is_some());
        harness.get_by_label("Open definition…").click();
        harness.run_steps(2);
        harness.get_by_label("Save definition as…").click();
        harness.run_steps(2);
        let request_of = |request| DesignAction::BodyFile(request);
        assert_eq!(
            *requests.borrow(),
            [
                request_of(BodyFileRequest::ShowOpen(BodyRole::Tool)),
                request_of(BodyFileRequest::ShowSave(BodyRole::Tool)),
            ]
        );
    }
    let rom = write(&folder, "8700339.rom", markers());
    request_and_wait(&mut app, BodyFileRequest::open(BodyRole::Tool, rom));
    let (mut harness, _) = section(&app);
    harness.run_steps(2);
    assert!(harness.query_by_label("part number").is_none());
    harness.get_by_label("From an NDI optical ROM").click();
    harness.run_steps(2);
    for label in [
        "part number",
        "8700339",
        "manufacturer",
        "serial number",
        "date",
        "markers",
        "90°",
        "2\u{2009}mm",
        "trailing bytes",
        "1: EE",
    ] {
        assert!(harness.query_all_by_label(label).next().is_some(), "{label:?}");
    }
    assert!(harness.query_by_label_contains(", matches").is_some());
}

#[test]
fn a_body_read_for_another_design_is_dropped() {
    let (folder, mut app) = app();
    let rom = write(&folder, "8700339.rom", coils());
    let open = |role| match role {
        BodyRole::Tool => OPEN_TOOL,
        BodyRole::Crf => OPEN_CRF,
    };
    let is_available = |app: &App, command: Command| {
        let now = Situation {
            world: app.world().get_resource::<OpenWorld>(),
            selection: &Selection::default(),
            is_dragging: false,
            workspace: workspaces::design::WORKSPACE,
            panels: PanelsShown::default(),
        };
        now.allows(&command)
    };
    assert!(is_available(&app, open(BodyRole::Crf)));
    let load = BodyFileRequest::open(BodyRole::Tool, rom.clone());
    app.world_mut().write_message(load);
    let other = FileRequest::OpenBuiltIn("endoscope".into());
    app.world_mut().write_message(other);
    finish(&mut app);
    assert_eq!(world(&app).document.undo_label(), None);
    // A design without a CRF can gain one.
    assert!(is_available(&app, open(BodyRole::Tool)) && is_available(&app, open(BodyRole::Crf)));
    // With one body there is nothing to choose.
    drop_file(&mut app, &rom);
    let label = world(&app).document.undo_label();
    assert_eq!(label, Some("Use 8700339 as the tool"));
}

#[test]
fn a_design_gains_a_crf_from_a_file() {
    let (folder, mut app) = app();
    let rom = write(&folder, "8700339.rom", coils());
    app.world_mut().write_message(FileRequest::OpenBuiltIn("endoscope".into()));
    app.update();
    let tool = |app: &App| world(app).document.design().tracker_from_body(BodyRole::Tool).unwrap();
    let before = tool(&app);
    let (design, environment, view) = {
        let world = world(&app);
        (world.document.design().clone(), &world.environment, View::default())
    };
    let selection = Selection::default();
    let actions = use_panel(
        [260.0, 700.0],
        |ui| outliner_ui(ui, &OutlinerView::new(&design, environment, &view, &selection)),
        |harness| harness.get_by_label("Add from a file…").click(),
    );
    assert!(actions.contains(&DesignAction::Run(OPEN_CRF.name)), "{actions:?}");
    request_and_wait(&mut app, BodyFileRequest::open(BodyRole::Crf, rom));
    let document = &world(&app).document;
    assert_eq!(document.undo_label(), Some("Add 8700339 as the CRF"));
    assert_eq!(document.design().body(BodyRole::Crf).unwrap().rigid.sensors.len(), 2);
    let selected = app.world().resource::<Selection>().primary();
    assert_eq!(selected, Some(Selected::Body(BodyRole::Crf)));
    assert!((tool(&app).translation.vector - before.translation.vector).norm() < 1e-12);
    assert!(tool(&app).rotation.angle_to(&before.rotation) < 1e-12);
    request(&mut app, EditRequest::Undo);
    app.update();
    assert!(world(&app).document.design().crf.is_none());
    assert!(!world(&app).document.is_dirty());
}
