//! The panels of the Field workspace as functions: what they show, and what they request.

use super::app::create_app;
use super::field_workspace::{finish, request_and_wait, with_field};
use crate::support::data::own;
use crate::support::program::Scratch;
use bevy::prelude::*;
use bevy_egui::egui;
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;
use trackwright_editor::document::requests::OpenWorld;
use trackwright_editor::scene::materials::paint::PaintMaterial;
use trackwright_editor::workspaces::field::kind::FieldKind;
use trackwright_editor::workspaces::field::panels::fit_quality::{comparison_ui, fit_quality_ui};
use trackwright_editor::workspaces::field::panels::rooms::rooms_ui;
use trackwright_editor::workspaces::field::panels::selection::selection_ui;
use trackwright_editor::workspaces::field::panels::settings::settings_ui;
use trackwright_editor::workspaces::field::panels::table::tables_ui;
use trackwright_editor::workspaces::field::samples::SampleScale;
use trackwright_editor::workspaces::field::state::{FieldSettings, FieldState, TableRole};
use trackwright_editor::workspaces::field::{FieldRequest, RoomToSave};
use trackwright_geometry::directions::DirectionSet;
use trackwright_geometry::volume::Volume;

/// What a panel requested while it was used.
fn use_panel(
    panel: impl Fn(&mut egui::Ui) -> Vec<FieldRequest>,
    act: impl FnOnce(&mut Harness),
) -> Vec<FieldRequest> {
    super::harness::use_panel([360.0, 1100.0], panel, act)
}

fn app() -> App {
    let mut app = create_app();
    app.add_plugins((bevy::asset::AssetPlugin::default(), bevy::mesh::MeshPlugin))
        .init_asset::<Image>()
        .init_asset::<PaintMaterial>();
    let mut app = with_field(app);
    let world = trackwright_project::open_builtin("endoscope").unwrap();
    app.insert_resource(OpenWorld(world));
    finish(&mut app);
    app
}

fn read(app: &mut App) {
    for (role, name) in [
        (TableRole::Training, "room-a/room-a-fit.csv"),
        (TableRole::HeldOut, "room-a/room-a-holdout.csv"),
    ] {
        request_and_wait(app, FieldRequest::Open(role, own(name)));
    }
}

fn fit(app: &mut App, order: Option<usize>, directions: Option<DirectionSet>) {
    let mut settings = FieldSettings { kind: FieldKind::Polynomials, ..FieldSettings::default() };
    settings.model.order = order;
    settings.model.directions = directions;
    request_and_wait(app, FieldRequest::Set(settings));
    request_and_wait(app, FieldRequest::Fit);
}

#[test]
fn an_empty_state_shows_what_to_do_and_opens_a_table() {
    let state = FieldState::default();
    let requests = use_panel(
        |ui| tables_ui(ui, &state, SampleScale(None)),
        |harness| {
            harness.get_by_label_contains("Drop a measurement table");
            harness.get_by_label("Open measurements…").click();
        },
    );
    assert_eq!(requests, [FieldRequest::ShowOpen(TableRole::Training)]);
    let requests = use_panel(
        |ui| settings_ui(ui, &state),
        |harness| {
            harness.get_by_label_contains("no measurements to fit");
            harness.get_by_label("Select and fit").click();
        },
    );
    assert!(requests.is_empty(), "{requests:?}");
}

#[test]
fn the_volume_is_a_named_one_or_unknown() {
    let state = FieldState::default();
    let requests = use_panel(
        |ui| settings_ui(ui, &state),
        |harness| {
            let role = egui::accesskit::Role::ComboBox;
            harness.get_by_role_and_label(role, "volume").click();
            harness.run_steps(3);
            for volume in Volume::NAMED {
                harness.get_by_label(volume.name());
            }
            harness.get_by_label("Aurora dome").click();
        },
    );
    let settings = FieldSettings { volume: Some(Volume::AuroraDome), ..FieldSettings::default() };
    assert_eq!(requests.first(), Some(&FieldRequest::Set(settings)));
}

#[test]
fn a_table_shows_its_samples_and_bounds_with_units() {
    let mut app = app();
    read(&mut app);
    let state = app.world().resource::<FieldState>();
    let scale = *app.world().resource::<SampleScale>();
    let requests = use_panel(
        |ui| tables_ui(ui, state, scale),
        |harness| {
            harness.get_by_label("room-a-fit.csv");
            assert_eq!(harness.query_all_by_label("1,025 samples").count(), 2);
            let ranges = harness.query_all_by_label_contains("\u{2009}mm").count();
            assert!(ranges >= 5, "{ranges}");
            harness.get_by_label("held out").click();
        },
    );
    assert!(
        matches!(requests.as_slice(), [FieldRequest::Show(shown)] if !shown.held_out),
        "{requests:?}"
    );
    let requests = use_panel(
        |ui| settings_ui(ui, state),
        |harness| harness.get_by_label("Select and fit").click(),
    );
    assert_eq!(requests, [FieldRequest::Fit]);
}

#[test]
fn a_table_in_metres_needs_confirmation() {
    let scratch = Scratch::new();
    let file = scratch.path("metres.csv");
    let table = std::fs::read_to_string(own("room-a/room-a-fit.csv")).unwrap();
    let (head, rows) = table.split_once('\n').unwrap();
    let is_length = |name: &str| !name.contains("_q");
    let names: Vec<&str> = head.split(',').collect();
    let in_metres = |row: &str| {
        let cells = row.split(',').zip(&names).map(|(cell, name)| match is_length(name) {
            true => (cell.parse::<f64>().unwrap() / 1e3).to_string(),
            false => cell.to_owned(),
        });
        cells.collect::<Vec<_>>().join(",")
    };
    let rows: Vec<String> = rows.lines().map(in_metres).collect();
    std::fs::write(&file, format!("{head}\n{}\n", rows.join("\n"))).unwrap();

    let mut app = app();
    request_and_wait(&mut app, FieldRequest::Open(TableRole::Training, file.clone()));
    request_and_wait(&mut app, FieldRequest::Fit);
    let state = app.world().resource::<FieldState>();
    assert!(state.fitted.is_none());
    let requests = use_panel(
        |ui| tables_ui(ui, state, SampleScale::default()),
        |harness| {
            assert_eq!(harness.query_all_by_label_contains("are they metres?").count(), 1);
            harness.get_by_label("take it as it stands").click();
        },
    );
    let taken = FieldRequest::TakeAsIs(file, true);
    assert_eq!(requests, std::slice::from_ref(&taken));
    request_and_wait(&mut app, taken);
    fit(&mut app, Some(1), Some(DirectionSet::One));
    finish(&mut app);
    assert!(app.world().resource::<FieldState>().fitted.is_some());
}

#[test]
fn a_fit_shows_both_errors_and_warnings() {
    let mut app = app();
    read(&mut app);
    fit(&mut app, Some(4), Some(DirectionSet::FortyTwo));
    let state = app.world().resource::<FieldState>();
    let fitted = state.fitted.as_ref().unwrap();
    let held_out = fitted.held_out_quality.as_ref().unwrap();
    let requests = use_panel(
        |ui| fit_quality_ui(ui, state),
        |harness| {
            for value in [
                fitted.training_quality.after.rms.position_rms_mm,
                held_out.after.rms.position_rms_mm,
                held_out.after.position_max_mm,
            ] {
                let text = format!("{value:.2}\u{2009}mm");
                assert!(harness.query_all_by_label(&text).count() >= 1, "{text}");
            }
            harness.get_by_label_contains("have fewer samples than the 125 coefficients");
            assert!(harness.query_by_label_contains("have changed since").is_none());
            harness.get_by_label("Use in this design…").click();
        },
    );
    assert_eq!(requests, [FieldRequest::ShowSave(RoomToSave::Fitted)]);

    request_and_wait(&mut app, FieldRequest::Try);
    let state = app.world().resource::<FieldState>();
    let comparison = state.comparison.as_ref().unwrap();
    use_panel(
        |ui| {
            comparison_ui(ui, comparison, false);
            Vec::new()
        },
        |harness| {
            harness.get_by_label("present");
            harness.get_by_label("Another room: no verdict on the design");
            harness.get_by_label_contains("has changed since");
        },
    );
    request_and_wait(&mut app, FieldRequest::Set(FieldSettings::default()));
    let state = app.world().resource::<FieldState>();
    use_panel(
        |ui| fit_quality_ui(ui, state),
        |harness| {
            harness.get_by_label_contains("have changed since");
        },
    );
}

#[test]
fn a_selection_is_drawn_and_links_its_table() {
    let mut app = app();
    read(&mut app);
    fit(&mut app, Some(1), None);
    let state = app.world().resource::<FieldState>();
    let fitted = state.fitted.as_ref().unwrap();
    let requests = use_panel(
        |ui| selection_ui(ui, fitted),
        |harness| harness.get_by_label("Figure and table…").click(),
    );
    assert_eq!(requests, [FieldRequest::ShowSelection(true)]);
    let requests = use_panel(
        |ui| {
            trackwright_editor::workspaces::field::panels::selection::selection_window(
                ui.ctx(),
                fitted,
            )
            .0
        },
        |harness| {
            harness.get_by_label("chosen");
            harness.get_by_label_contains("chosen: order 1");
        },
    );
    assert!(requests.is_empty(), "{requests:?}");
}

#[test]
fn the_designs_own_room_is_not_assigned_again() {
    let app = app();
    let state = app.world().resource::<FieldState>();
    let requests = use_panel(
        |ui| rooms_ui(ui, state),
        |harness| harness.get_by_label("Operating table (built in)").click(),
    );
    assert!(requests.is_empty(), "{requests:?}");
    let state = FieldState { rooms: state.rooms.clone(), ..FieldState::default() };
    let requests = use_panel(
        |ui| rooms_ui(ui, &state),
        |harness| harness.get_by_label("Operating table (built in)").click(),
    );
    assert_eq!(requests, [FieldRequest::Assign(state.rooms[0].place.clone())]);
}
