//! Rooms made in the Field workspace: what the command line makes, in the background, and given to
//! the design as one undo step.

use super::app::{
    close_dialog, create_app, create_scene_app_with, document, drop_on_window, error, named,
    request, settle, wait_for_work,
};
use crate::support::data::own;
use crate::support::program::{Scratch, text};
use bevy::prelude::*;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use trackwright_editor::document::requests::{EditRequest, OpenWorld};
use trackwright_editor::document::state::Notice;
use trackwright_editor::runner::results::Results;
use trackwright_editor::scene::materials::paint::PaintMaterial;
use trackwright_editor::shell::dialogs::Dialogs;
use trackwright_editor::workspaces;
use trackwright_editor::workspaces::field::dialog::FieldDialog;
use trackwright_editor::workspaces::field::kind::{FieldKind, GeneratorName};
use trackwright_editor::workspaces::field::samples::SamplesPlugin;
use trackwright_editor::workspaces::field::state::{
    FieldCounts, FieldSettings, FieldState, SampleValue, SamplesShown, TableRole,
};
use trackwright_editor::workspaces::field::{FieldPlugin, FieldRequest, RoomToSave};
use trackwright_geometry::directions::DirectionSet;
use trackwright_project::{RoomSource, builtin_rooms};
use trackwright_simulation::Figures;

pub fn with_field(mut app: App) -> App {
    add_field(&mut app);
    app
}

pub fn add_field(app: &mut App) {
    app.insert_resource(workspaces::field::WORKSPACE).add_plugins((FieldPlugin, SamplesPlugin));
}

/// The workspace without renderer, in a design that was saved to a folder.
fn saved_app(folder: &Path) -> App {
    let mut app = with_field(without_samples());
    let mut world = trackwright_project::open_builtin("endoscope").unwrap();
    trackwright_project::save_as(&mut world, &folder.join("endoscope.design.ron")).unwrap();
    app.insert_resource(OpenWorld(world));
    finish(&mut app);
    app
}

/// Meshes are drawn nowhere, but there is a place for them.
fn without_samples() -> App {
    let mut app = create_app();
    app.add_plugins((bevy::asset::AssetPlugin::default(), bevy::mesh::MeshPlugin))
        .init_asset::<Image>()
        .init_asset::<PaintMaterial>();
    app
}

fn field_state(app: &App) -> &FieldState {
    app.world().resource::<FieldState>()
}

/// Updates until no thread works for the workspace and the solver rests.
pub fn finish(app: &mut App) {
    app.update();
    app.update();
    while field_state(app).is_busy() {
        wait_for_work(app);
    }
    settle(app);
}

pub fn request_and_wait(app: &mut App, request: FieldRequest) {
    app.world_mut().write_message(request);
    finish(app);
}

fn drop_file(app: &mut App, file: &Path) {
    drop_on_window(app, file);
    finish(app);
}

fn room_a() -> [PathBuf; 2] {
    ["room-a/room-a-fit.csv", "room-a/room-a-holdout.csv"].map(own)
}

fn settings(order: Option<usize>, directions: Option<DirectionSet>) -> FieldSettings {
    let mut settings = FieldSettings { kind: FieldKind::Polynomials, ..FieldSettings::default() };
    settings.model.order = order;
    settings.model.directions = directions;
    settings
}

fn set(app: &mut App, order: usize, directions: DirectionSet) {
    let settings = settings(Some(order), Some(directions));
    request_and_wait(app, FieldRequest::Set(settings));
}

fn figures(app: &App) -> Figures {
    app.world().resource::<Results>().study.as_ref().unwrap().value.figures.clone()
}

/// Every figure of the study to the last bit.
fn figure_bits(app: &App) -> Vec<u64> {
    let study = app.world().resource::<Results>().study.as_ref().unwrap();
    study.value.figures.all.iter().map(|figure| figure.value.to_bits()).collect()
}

/// To the last bit but one: reading JSON rounds once more.
#[track_caller]
pub fn assert_printed(value: f64, printed: &serde_json::Value) {
    let printed = printed.as_f64().unwrap();
    assert!((value - printed).abs() <= 4.0 * f64::EPSILON * value.abs(), "{value} {printed}");
}

#[test]
fn a_fitted_room_equals_the_commands_output() {
    let scratch = Scratch::new();
    let mut app = saved_app(&scratch.path(""));
    let [fit, holdout] = ["cube-fit.csv", "cube-holdout.csv"]
        .map(|name| own("../../assets/environments/data").join(name));
    drop_file(&mut app, &fit);
    let table = field_state(&app).training.table.as_ref().unwrap();
    assert_eq!(table.samples.samples.len(), 4000);
    // The second one opens a dialog about its purpose.
    drop_file(&mut app, &holdout);
    let which = FieldDialog::WhichTable { file: holdout.clone() };
    assert_eq!(app.world().resource::<Dialogs>().get(), Some(&which));
    close_dialog(&mut app);
    request_and_wait(&mut app, FieldRequest::Open(TableRole::HeldOut, holdout.clone()));
    set(&mut app, 2, DirectionSet::Six);
    request_and_wait(&mut app, FieldRequest::Fit);
    let fitted = field_state(&app).fitted.clone().unwrap();
    assert!(!field_state(&app).is_outdated(&fitted));
    let mine = scratch.path("mine.env.ron");
    request_and_wait(&mut app, FieldRequest::Save(RoomToSave::Fitted, mine));
    std::fs::create_dir(scratch.path("theirs")).unwrap();
    let tables = format!("{} --holdout {}", text(&fit), text(&holdout));
    let size = "--order 2 --directions 6";
    let printed = scratch.json(format!("fit {tables} -o theirs/mine.env.ron {size}"));
    assert!(scratch.read("mine.env.ron") == scratch.read("theirs/mine.env.ron"), "not the same");
    let held_out = fitted.held_out_quality.as_ref().unwrap();
    let printed = &printed["holdout"]["after"]["position_rms_mm"];
    assert_printed(held_out.after.rms.position_rms_mm, printed);
    assert!(held_out.after.position_max_mm < held_out.before.position_max_mm);
}

#[test]
fn every_kind_of_model_equals_the_command() {
    let scratch = Scratch::new();
    let mut app = saved_app(&scratch.path(""));
    let [fit, _] = room_a();
    drop_file(&mut app, &fit);
    std::fs::create_dir(scratch.path("theirs")).unwrap();
    let planar = FieldKind::Harmonic(GeneratorName::BuiltIn("planar-nine"));
    for (name, kind, options) in [
        (
            "symmetric.env.ron",
            FieldKind::SymmetricPolynomials,
            "--symmetric yes --order 1 --directions 6",
        ),
        ("kriging.env.ron", FieldKind::Kriging, "--model kriging"),
        ("harmonic.env.ron", planar, "--model harmonic --generator planar-nine --degree 3"),
    ] {
        let settings = FieldSettings {
            kind,
            degree: (kind == planar).then_some(3),
            ..settings(Some(1), Some(DirectionSet::Six))
        };
        request_and_wait(&mut app, FieldRequest::Set(settings));
        request_and_wait(&mut app, FieldRequest::Fit);
        let fitted = field_state(&app).fitted.clone().unwrap();
        assert!(!field_state(&app).is_outdated(&fitted) && fitted.field_settings.kind == kind);
        let save = FieldRequest::Save(RoomToSave::Fitted, scratch.path(name));
        request_and_wait(&mut app, save);
        let theirs = format!("theirs/{name}");
        scratch.succeed(format!("fit {} -o {theirs} {options}", text(&fit)));
        assert!(scratch.read(name) == scratch.read(&theirs), "{kind:?}: the two rooms differ");
    }
}

#[test]
fn open_choices_equal_the_command_selection() {
    let scratch = Scratch::new();
    let mut app = with_field(without_samples());
    let [fit, _] = room_a();
    drop_file(&mut app, &fit);
    request_and_wait(&mut app, FieldRequest::Set(settings(Some(1), None)));
    request_and_wait(&mut app, FieldRequest::Fit);
    let printed = scratch.json(format!("fit {} -o room.env.ron --order 1", text(&fit)));
    let fitted = field_state(&app).fitted.as_ref().unwrap();
    let chosen = fitted.decided.chosen.as_ref().unwrap();
    let best = chosen.selection.best();
    let selection = &printed["selection"];
    assert_eq!(selection["directions"].as_u64(), Some(best.candidate.directions.len() as u64));
    assert_printed(best.candidate.ridge, &selection["ridge"]);
    assert_printed(best.deciding().position_rms_mm, &selection["cv"]["position_rms_mm"]);
    assert_eq!(fitted.decided.settings, chosen.settings());
    assert_eq!(scratch.environment("room.env.ron").model, fitted.environment.model);
}

#[test]
fn an_abandoned_fit_changes_nothing() {
    let mut app = with_field(without_samples());
    drop_file(&mut app, &room_a()[0]);
    set(&mut app, 1, DirectionSet::Six);
    request_and_wait(&mut app, FieldRequest::Fit);
    let before = field_state(&app).fitted.clone().unwrap();
    let bits = figure_bits(&app);
    set(&mut app, 6, DirectionSet::FortyTwo);
    app.world_mut().write_message(FieldRequest::Fit);
    request_and_wait(&mut app, FieldRequest::CancelFit);
    let now = field_state(&app);
    assert!(Arc::ptr_eq(now.fitted.as_ref().unwrap(), &before));
    assert!(now.is_outdated(&before), "the settings have changed since");
    assert!(app.world().resource::<Dialogs>().current.is_none());
    assert_eq!(figure_bits(&app), bits);
    let notice = app.world().resource::<Notice>();
    assert!(matches!(notice, Notice::Done(text) if text.contains("cancelled")));
}

#[test]
fn assigning_a_room_is_one_undo_step() {
    let scratch = Scratch::new();
    for is_saved in [true, false] {
        let mut app = match is_saved {
            true => saved_app(&scratch.path("")),
            false => {
                let mut app = with_field(without_samples());
                let world = trackwright_project::open_builtin("endoscope").unwrap();
                app.insert_resource(OpenWorld(world));
                app
            }
        };
        drop_file(&mut app, &room_a()[0]);
        set(&mut app, 2, DirectionSet::Six);
        request_and_wait(&mut app, FieldRequest::Fit);
        let before = (figure_bits(&app), figures(&app));
        let revision = document(&app).revision();

        request_and_wait(&mut app, FieldRequest::Try);
        let comparison = field_state(&app).comparison.clone().unwrap();
        assert_eq!(comparison.present.figures, before.1);
        assert_eq!(figure_bits(&app), before.0, "trying changes nothing");
        let document = document(&app);
        assert_eq!(document.revision(), revision);

        let file = scratch.path(if is_saved { "a.env.ron" } else { "b.env.ron" });
        request_and_wait(&mut app, FieldRequest::Save(RoomToSave::Fitted, file.clone()));
        assert_eq!(figures(&app), comparison.tried.figures, "what was tried is what came");
        let world = &app.world().resource::<OpenWorld>().0;
        let name = if is_saved { "a" } else { "b" };
        assert_eq!(world.environment.name, name);
        let label = format!("Use room {name}");
        assert_eq!(world.document.undo_label(), Some(&*label));
        let is_listed = |room: &trackwright_project::RoomListing| {
            Some(&room.place) == field_state(&app).own.as_ref()
        };
        assert!(field_state(&app).rooms.iter().any(is_listed));

        request(&mut app, EditRequest::Undo);
        finish(&mut app);
        assert_eq!(figure_bits(&app), before.0);
        let world = &app.world().resource::<OpenWorld>().0;
        assert_eq!(world.environment.name, "Operating table");
        assert_eq!(world.document.undo_label(), None, "it was one step");
    }
}

#[test]
fn the_own_rooms_file_is_never_replaced() {
    let scratch = Scratch::new();
    let [fit, _] = room_a();
    scratch.fit("other.env.ron", "--order 1 --directions 6");
    scratch.write("spoilt.env.ron", "(version: 1");
    let mut app = saved_app(&scratch.path(""));
    let names: Vec<&str> =
        field_state(&app).rooms.iter().map(|room| room.summary.name.as_str()).collect();
    // The built-in rooms, and the two readable ones of the folder.
    assert_eq!(names, ["Operating table", "Operating theatre", "Operating table", "other"]);
    let before = figure_bits(&app);
    let place = field_state(&app).rooms[3].place.clone();
    request_and_wait(&mut app, FieldRequest::Assign(place.clone()));
    assert_ne!(figure_bits(&app), before);
    assert_eq!(field_state(&app).own.as_ref(), Some(&place));
    assert_eq!(field_state(&app).recent.first(), Some(&place));
    assert_eq!(field_state(&app).rooms.len(), 4, "the room that was left can be had again");

    drop_file(&mut app, &fit);
    set(&mut app, 1, DirectionSet::Six);
    request_and_wait(&mut app, FieldRequest::Fit);
    let was = scratch.read("other.env.ron");
    let RoomSource::File(file) = place else { panic!("{place:?}") };
    request_and_wait(&mut app, FieldRequest::Save(RoomToSave::Fitted, file));
    assert!(error(&app).text.contains("a file that is read here"));
    assert_eq!(scratch.read("other.env.ron"), was);
}

#[test]
fn a_click_tries_any_room_and_undo_leaves_it() {
    let scratch = Scratch::new();
    let mut app = saved_app(&scratch.path(""));
    let before = figure_bits(&app);
    let builtin_rooms: Vec<_> = builtin_rooms().collect();
    for room in &builtin_rooms {
        request_and_wait(&mut app, FieldRequest::Assign(room.clone()));
        assert!(app.world().resource::<Dialogs>().current.is_none());
        assert_eq!(field_state(&app).own.as_ref(), Some(room));
        let name = app.world().resource::<OpenWorld>().0.bare_environment().name.clone();
        let notice = app.world().resource::<Notice>();
        let Notice::Done(text) = notice else { panic!("{notice:?}") };
        assert!(text.starts_with(&format!("The design is in room {name}; Undo")), "{text}");
    }
    for _ in &builtin_rooms {
        request(&mut app, EditRequest::Undo);
        finish(&mut app);
    }
    assert_eq!(figure_bits(&app), before);
    assert!(!app.world().resource::<OpenWorld>().0.document.is_dirty());
}

#[test]
fn unusable_tables_use_the_commands_words() {
    let scratch = Scratch::new();
    let head = "ideal_x,ideal_y,ideal_z,measured_x,measured_y,measured_z\n";
    for (name, content) in [
        ("empty.csv", String::new()),
        ("nan.csv", format!("{head}0,0,0,NaN,0,0\n")),
        ("columns.csv", "x,y,z\n1,2,3\n".to_owned()),
        ("rows.csv", head.to_owned()),
        ("one.csv", format!("{head}0,0,0,1,0,0\n")),
    ] {
        let file = scratch.path(name);
        scratch.write(name, content);
        let mut app = with_field(without_samples());
        drop_file(&mut app, &file);
        if field_state(&app).training.table.is_some() {
            request_and_wait(&mut app, FieldRequest::Set(settings(None, None)));
            request_and_wait(&mut app, FieldRequest::Fit);
        }
        let printed = scratch.fail(format!("fit {} -o no.env.ron", text(&file)));
        assert_eq!(format!("error: {}", error(&app).text), printed.trim_end());
        assert!(field_state(&app).fitted.is_none());
    }
}

#[test]
fn sensors_without_rotations_are_deselected() {
    let scratch = Scratch::new();
    let file = scratch.path("positions.csv");
    let head = "ideal_x,ideal_y,ideal_z,measured_x,measured_y,measured_z\n";
    scratch.write("positions.csv", format!("{head}0,0,0,1,0,0\n9,8,7,9,8,7\n"));
    let mut app = with_field(without_samples());
    drop_file(&mut app, &file);
    let table = field_state(&app).training.table.clone().unwrap();
    let six = FieldSettings { has_rolls: true, ..FieldSettings::default() };
    request_and_wait(&mut app, FieldRequest::Set(six));
    assert!(error(&app).text.ends_with("found no quaternions, expected them for 6-DOF sensors"));
    assert!(Arc::ptr_eq(field_state(&app).training.table.as_ref().unwrap(), &table));
    assert!(!field_state(&app).settings.has_rolls);
}

#[test]
fn a_workspace_that_is_not_shown_does_nothing() {
    let scratch = Scratch::new();
    let app = saved_app(&scratch.path(""));
    let listed = field_state(&app).counts;
    assert_eq!(listed.listings, 1);
    let mut app = with_field(without_samples());
    app.insert_resource(workspaces::design::WORKSPACE);
    drop_file(&mut app, &room_a()[0]);
    request(&mut app, EditRequest::Undo);
    finish(&mut app);
    assert_eq!(field_state(&app).counts, FieldCounts::default());
    assert!(app.world().resource::<Dialogs>().current.is_none());
}

#[test]
fn samples_are_drawn_once_in_this_workspace() {
    let mut app = create_scene_app_with(add_field);
    let [fit, holdout] = room_a();
    drop_file(&mut app, &fit);
    request_and_wait(&mut app, FieldRequest::Open(TableRole::HeldOut, holdout));
    assert_eq!(named(&mut app, "samples"), 2);
    let drawn = field_state(&app).counts.sample_meshes;
    for _ in 0..3 {
        app.update();
    }
    assert_eq!(field_state(&app).counts.sample_meshes, drawn);

    app.insert_resource(workspaces::design::WORKSPACE);
    finish(&mut app);
    assert_eq!(named(&mut app, "samples"), 0);
    app.insert_resource(workspaces::field::WORKSPACE);
    finish(&mut app);
    assert_eq!(named(&mut app, "samples"), 2);

    set(&mut app, 1, DirectionSet::Six);
    request_and_wait(&mut app, FieldRequest::Fit);
    let shown =
        SamplesShown { held_out: false, value: SampleValue::Left, ..SamplesShown::default() };
    request_and_wait(&mut app, FieldRequest::Show(shown));
    assert_eq!(named(&mut app, "samples"), 1);
    let (value, left) = field_state(&app).sample_values(TableRole::Training).unwrap();
    assert_eq!(value, SampleValue::Left);
    let mean_square = left.position_mm.iter().map(|v| v * v).sum::<f64>() / 1025.0;
    let rms_mm = field_state(&app).fitted.as_ref().unwrap().fit.after.position_rms_mm;
    assert!((mean_square.sqrt() - rms_mm).abs() < 1e-12, "the colours are of what is left");
}
