//! Metal found in the Field workspace: what the command finds, in the panel and in the scene.

use super::app::{close_dialog, create_scene_app_with, document, error, named, world};
use super::field_workspace::{add_field, assert_printed, finish, request_and_wait};
use super::harness::use_panel;
use crate::support::metal_table::{AT_MM, metal_table};
use crate::support::program::{Scratch, text};
use bevy::prelude::*;
use egui_kittest::kittest::Queryable;
use std::path::{Path, PathBuf};
use trackwright_editor::document::requests::OpenWorld;
use trackwright_editor::document::state::Notice;
use trackwright_editor::shell::window::SceneLabels;
use trackwright_editor::workspaces;
use trackwright_editor::workspaces::field::found_bodies::FoundBodiesPlugin;
use trackwright_editor::workspaces::field::metal::GeneratorSource;
use trackwright_editor::workspaces::field::panels::metal::metal_ui;
use trackwright_editor::workspaces::field::state::{FieldState, TableRole};
use trackwright_editor::workspaces::field::{FieldRequest, RoomToSave};
use trackwright_metal::identify::{MetalKind, Verdict};

const PANEL: [f32; 2] = [360.0, 1100.0];
const PLANAR: GeneratorSource = GeneratorSource::BuiltIn("planar-nine");

/// The scene, in the Field workspace.
fn app() -> App {
    create_scene_app_with(|app| {
        add_field(app);
        app.add_plugins(FoundBodiesPlugin);
    })
}

fn state(app: &App) -> &FieldState {
    app.world().resource::<FieldState>()
}

fn open(app: &mut App, file: &Path) {
    request_and_wait(app, FieldRequest::Open(TableRole::Training, file.to_owned()));
}

/// A table of so many rows beside a sphere of aluminium.
fn table(scratch: &Scratch, rows: usize) -> PathBuf {
    scratch.write("room.csv", metal_table(rows, true));
    scratch.path("room.csv")
}

/// The metal of such a table is found.
fn found_app(scratch: &Scratch) -> App {
    let mut app = app();
    open(&mut app, &table(scratch, 300));
    request_and_wait(&mut app, FieldRequest::UseGenerator(PLANAR));
    request_and_wait(&mut app, FieldRequest::FindMetal);
    app
}

/// The message of a request that was refused.
#[track_caller]
fn refusal(app: &App) -> &str {
    match app.world().resource::<Notice>() {
        Notice::Refused(why) => why,
        other => panic!("{other:?}"),
    }
}

#[test]
fn a_sphere_is_found_as_by_the_command() {
    let scratch = Scratch::new();
    let mut app = found_app(&scratch);
    let metal = state(&app).metal.found.clone().unwrap();
    assert_eq!(metal.found.verdict, Verdict::Found);
    let [body] = &metal.found.bodies[..] else { panic!("{:?}", metal.found.bodies) };
    assert_eq!(body.kind, MetalKind::Conductor);
    let known = body.known.as_ref().unwrap();
    for (interval, at_mm) in known.center_mm.iter().zip(AT_MM) {
        assert!(interval.contains(at_mm) && interval.half_length() < 5.0, "{interval:?} {at_mm}");
    }

    std::fs::create_dir(scratch.path("theirs")).unwrap();
    let printed = scratch.json(
        "metal find room.csv --generator planar-nine --no-comparison -o theirs/metal.env.ron",
    );
    let printed = &printed["bodies"][0];
    assert_printed(body.source.center_mm.x, &printed["center_mm"][0]);
    assert_printed(body.source.strength_mm3, &printed["strength_mm3"]);
    let mine = scratch.path("metal.env.ron");
    request_and_wait(&mut app, FieldRequest::Save(RoomToSave::Metal, mine));
    assert!(scratch.read("metal.env.ron") == scratch.read("theirs/metal.env.ron"), "not the same");
    let document = document(&app);
    assert_eq!(document.undo_label(), Some("Use room Metal found in room.csv"));
    let own = document.design().room_metal.as_ref().unwrap();
    assert_eq!(own.objects.len(), 1);
}

#[test]
fn found_metal_is_drawn_in_this_workspace() {
    let scratch = Scratch::new();
    let mut app = found_app(&scratch);
    let metal = state(&app).metal.found.clone().unwrap();
    let [body] = &metal.found.bodies[..] else { panic!("{:?}", metal.found.bodies) };
    let world = app.world_mut();
    let mut all = world.query::<(&Name, &Transform)>();
    let (_, at) = all.iter(world).find(|(name, _)| name.as_str() == "found body").unwrap();
    let center_mm = body.source.center_mm.map(|value| value as f32);
    assert_eq!(at.translation.to_array(), <[f32; 3]>::from(center_mm));
    assert_eq!(at.scale, Vec3::splat(body.source.radius_mm() as f32));

    let drawn = |app: &mut App| {
        let labels = app.world().resource::<SceneLabels>();
        let labels: Vec<String> = labels.0.iter().map(|label| label.text.clone()).collect();
        (named(app, "found body"), named(app, "found interval"), labels)
    };
    let one = (1, 1, vec!["1 conductor".to_owned()]);
    assert_eq!(drawn(&mut app), one);
    app.insert_resource(workspaces::design::WORKSPACE);
    finish(&mut app);
    assert_eq!(drawn(&mut app), (0, 0, Vec::new()));
    app.insert_resource(workspaces::field::WORKSPACE);
    finish(&mut app);
    assert_eq!(drawn(&mut app), one);

    scratch.write("other.csv", metal_table(20, false));
    open(&mut app, &scratch.path("other.csv"));
    assert!(state(&app).metal.found.is_none(), "it belongs to another table");
    app.update();
    assert_eq!(drawn(&mut app), (0, 0, Vec::new()));
}

#[test]
fn a_search_needs_a_table_and_a_generator() {
    let scratch = Scratch::new();
    let mut app = app();
    // Its room states no coils.
    app.insert_resource(OpenWorld(world()));
    app.update();
    assert!(app.world().resource::<OpenWorld>().0.generator().is_none());
    request_and_wait(&mut app, FieldRequest::FindMetal);
    assert!(refusal(&app).contains("open a table first"), "{}", refusal(&app));
    let file = table(&scratch, 19);
    open(&mut app, &file);
    request_and_wait(&mut app, FieldRequest::FindMetal);
    assert!(refusal(&app).contains("choose the tracker's field generator"), "{}", refusal(&app));
    request_and_wait(&mut app, FieldRequest::ShowSave(RoomToSave::Metal));
    assert!(refusal(&app).contains("no metal"), "{}", refusal(&app));
    assert_eq!(state(&app).counts.searches, 0);

    request_and_wait(&mut app, FieldRequest::UseGenerator(PLANAR));
    request_and_wait(&mut app, FieldRequest::FindMetal);
    let printed = scratch.fail(format!("metal find {} --generator planar-nine", text(&file)));
    assert_eq!(format!("error: {}", error(&app).text), printed.trim_end());
    close_dialog(&mut app);

    let missing = GeneratorSource::File(scratch.path("none.generator.ron"));
    request_and_wait(&mut app, FieldRequest::UseGenerator(missing));
    request_and_wait(&mut app, FieldRequest::FindMetal);
    assert!(error(&app).text.contains("none.generator.ron"), "{}", error(&app).text);
    assert!(state(&app).metal.found.is_none());
}

#[test]
fn a_changed_file_is_not_searched() {
    let scratch = Scratch::new();
    let mut app = app();
    open(&mut app, &table(&scratch, 30));
    table(&scratch, 31);
    request_and_wait(&mut app, FieldRequest::UseGenerator(PLANAR));
    request_and_wait(&mut app, FieldRequest::FindMetal);
    assert!(error(&app).text.contains("changed since it was opened"), "{}", error(&app).text);
}

#[test]
fn a_cancelled_search_leaves_no_metal() {
    let scratch = Scratch::new();
    let mut app = app();
    open(&mut app, &table(&scratch, 300));
    request_and_wait(&mut app, FieldRequest::UseGenerator(PLANAR));
    app.world_mut().write_message(FieldRequest::FindMetal);
    request_and_wait(&mut app, FieldRequest::CancelMetal);
    assert!(state(&app).metal.found.is_none() && state(&app).metal.searching.is_none());
    let notice = app.world().resource::<Notice>();
    assert!(matches!(notice, Notice::Done(text) if text.contains("cancelled")), "{notice:?}");
}

#[test]
fn the_metal_section_shows_what_was_found() {
    let scratch = Scratch::new();
    let empty = FieldState::default();
    let shown = use_panel(
        PANEL,
        |ui| metal_ui(ui, &empty, None),
        |harness| assert!(harness.query_by_label("Find metal").is_none(), "no table is open"),
    );
    assert!(shown.is_empty(), "{shown:?}");

    let mut app = app();
    open(&mut app, &table(&scratch, 60));
    let requests = use_panel(
        PANEL,
        |ui| metal_ui(ui, state(&app), None),
        |harness| {
            harness.get_by_label_contains("choose the tracker's field generator");
            harness.get_by_label("Find metal").click();
        },
    );
    assert!(requests.is_empty(), "{requests:?}");

    request_and_wait(&mut app, FieldRequest::UseGenerator(PLANAR));
    request_and_wait(&mut app, FieldRequest::FindMetal);
    request_and_wait(&mut app, FieldRequest::CompareMetal);
    let metal = state(&app).metal.found.clone().unwrap();
    let [body] = &metal.found.bodies[..] else { panic!("{:?}", metal.found.bodies) };
    let requests = use_panel(
        PANEL,
        |ui| metal_ui(ui, state(&app), None),
        |harness| {
            harness.get_by_label("found 1 body");
            harness.get_by_label("1  conductor");
            let half_mm = body.known.as_ref().unwrap().center_mm[0].half_length();
            let x = format!("{:.1} ± {half_mm:.1}\u{2009}mm", body.source.center_mm.x);
            harness.get_by_label(&x);
            for name in ["not corrected", "the bodies found"] {
                harness.get_by_label(name);
            }
            harness.get_by_label_contains("Bernstein, order");
            assert!(harness.query_by_label("Compare with other models").is_none());
            harness.get_by_label("Use as room with metal…").click();
        },
    );
    assert_eq!(requests, [FieldRequest::ShowSave(RoomToSave::Metal)]);
}
