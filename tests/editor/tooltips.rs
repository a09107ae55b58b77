//! What can be used is explained in a sentence: commands, layers, figures, and the widgets of each
//! workspace's panels, whose sentences are read off the accessibility tree.

use super::app::{create_app, create_scene_app_with, layers, settle, world};
use super::commands::app_with_commands;
use super::harness::{is_usable, workspace_panels};
use bevy::prelude::*;
use bevy_egui::egui;
use egui_kittest::Harness;
use egui_kittest::kittest::{NodeT, Queryable};
use trackwright_editor::document::requests::BodyFileRequest;
use trackwright_editor::document::requests::MeshRequest;
use trackwright_editor::document::requests::OpenWorld;
use trackwright_editor::document::state::Notice;
use trackwright_editor::layers::LayersPlugin;
use trackwright_editor::shell::commands::{CommandRegistry, CommandsPlugin, RunCommand};
use trackwright_editor::shell::registry::Workspaces;
use trackwright_editor::widgets::basic::{NumberField, number_ui};
use trackwright_simulation::METRICS;

/// Whether a text states more than a name does.
fn is_sentence(text: &str) -> bool {
    let starts = text.chars().next().is_some_and(|c| c.is_uppercase() || !c.is_alphabetic());
    starts && text.split_whitespace().count() >= 3
}

#[test]
fn commands_layers_and_figures_are_explained() {
    let app = app_with_commands();
    for command in app.world().resource::<CommandRegistry>().all() {
        assert!(is_sentence(command.about), "{}: {}", command.name, command.about);
    }
    let layers = layers();
    assert!(layers.len() >= 15);
    for layer in layers {
        assert!(is_sentence(layer.row.about), "{}: {}", layer.row.label, layer.row.about);
    }
    for metric in METRICS {
        assert!(is_sentence(&metric.about()), "{}", metric.label());
    }
}

#[test]
fn tooltips_of_commands_have_their_keys() {
    let app = app_with_commands();
    let all = app.world().resource::<CommandRegistry>().all();
    let undo = all.iter().find(|command| command.name == "Undo").unwrap();
    assert_eq!(undo.tooltip(), format!("{} (Ctrl+Z)", undo.about));
}

/// Every widget that can be used and is not explained, and how many were seen.
fn unexplained(harness: &Harness) -> (Vec<String>, usize) {
    use egui::accesskit::Role;
    let mut seen = 0;
    let mut wrong = Vec::new();
    for node in harness.root().children_recursive() {
        let node = node.accesskit_node();
        // Rows of lists and choices are named by what they choose.
        let is_choice = node.role() == Role::Button && node.toggled().is_some();
        if !is_usable(node.role()) || is_choice {
            continue;
        }
        seen += 1;
        if node.description().is_none_or(|about| about.split_whitespace().count() < 3) {
            wrong.push(format!("{:?} {:?}", node.role(), node.label()));
        }
    }
    (wrong, seen)
}

#[test]
fn every_widget_of_a_workspace_is_explained() {
    let mut app = app_with_commands();
    app.add_message::<MeshRequest>().add_message::<BodyFileRequest>();
    settle(&mut app);
    let workspaces = app.world().resource::<Workspaces>().0.clone();
    let mut seen_in_all = 0;
    for workspace in workspaces {
        let harness = workspace_panels(&mut app, workspace, |_| ());
        let (wrong, seen) = unexplained(&harness);
        assert!(wrong.is_empty(), "{}: {}", workspace.name, wrong.join(", "));
        seen_in_all += seen;
    }
    assert!(seen_in_all > 20, "{seen_in_all}");
}

#[test]
fn a_number_field_explains_itself() {
    let mut harness = Harness::builder().build_ui(|ui| {
        let field = NumberField::length("length in mm").about("Length of the coil");
        let _ = number_ui(ui, &field, 9.0);
        let _ = number_ui(ui, &NumberField::length("plain length"), None::<f64>);
    });
    harness.run_steps(2);
    let about = |name: &str| harness.get_by_label(name).accesskit_node().description();
    assert!(about("length in mm").unwrap().starts_with("Length of the coil. "));
    assert!(about("plain length").unwrap().starts_with("Plain length. "));
}

#[test]
fn each_layer_is_switched_by_its_command() {
    let mut app = create_scene_app_with(|app| {
        app.add_plugins((LayersPlugin, CommandsPlugin));
    });
    settle(&mut app);
    let shows = |app: &App| app.world().resource::<OpenWorld>().0.document.view().layers;
    let before = shows(&app);
    for expected in [!before.slice, before.slice] {
        app.world_mut().write_message(RunCommand("Show layer: Error slice"));
        app.update();
        app.update();
        assert_eq!(shows(&app).slice, expected);
    }
    assert_eq!(shows(&app), before);
}

#[test]
fn a_layer_that_cannot_be_shown_is_refused() {
    // The room keeps no measurements, so that its model's validity is not known.
    let mut app = create_scene_app_with(|app| {
        app.insert_resource(OpenWorld(world())).add_plugins((LayersPlugin, CommandsPlugin));
    });
    settle(&mut app);
    app.world_mut().write_message(RunCommand("Show layer: Model support"));
    app.update();
    assert!(!app.world().resource::<OpenWorld>().0.document.view().layers.support);
    assert!(matches!(app.world().resource::<Notice>(), Notice::Refused(_)));
}

#[test]
fn an_app_without_layers_has_no_layer_commands() {
    let app = create_app();
    let commands = app.world().get_resource::<CommandRegistry>();
    let is_layer = |name: &str| name.starts_with("Show layer: ");
    assert!(commands.is_none_or(|all| all.all().iter().all(|own| !is_layer(own.name))));
}
