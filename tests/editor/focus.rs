//! The keyboard reaches every widget of every workspace, and a ring shows where it is.

use super::app::settle;
use super::commands::app_with_commands;
use super::harness::{is_usable, workspace_panels};
use bevy_egui::egui;
use egui_kittest::Harness;
use egui_kittest::kittest::NodeT;
use std::cell::Cell;
use std::collections::BTreeSet;
use trackwright_editor::document::requests::{BodyFileRequest, MeshRequest};
use trackwright_editor::palette::{self, ThemedColor};
use trackwright_editor::shell::focus::focus_ui;
use trackwright_editor::shell::registry::Workspaces;
use trackwright_editor::shell::shortcuts::KeyboardFocus;

/// More than any workspace has widgets.
const MOST_TABS: usize = 400;

/// Whether a ring was painted in the last frame.
fn has_ring(harness: &Harness) -> bool {
    let is_ring = |shape: &egui::epaint::ClippedShape| match &shape.shape {
        egui::Shape::Rect(rect) => {
            rect.stroke.width == 2.0 && rect.stroke.color == palette::ACCENT.color32()
        }
        _ => false,
    };
    harness.output().shapes.iter().any(is_ring)
}

/// The widgets that can be used, by what identifies them, with their names.
fn usable(harness: &Harness) -> BTreeSet<String> {
    let nodes = harness.root().children_recursive();
    let name = |node: egui_kittest::Node| {
        let node = node.accesskit_node();
        (is_usable(node.role()) && !node.is_disabled())
            .then(|| format!("{:?} {:?} {:?}", node.role(), node.label(), node.id()))
    };
    nodes.filter_map(name).collect()
}

fn focused(harness: &Harness) -> Option<String> {
    let mut nodes = harness.root().children_recursive();
    let node = nodes.find(|node| node.accesskit_node().is_focused())?;
    let node = node.accesskit_node();
    Some(format!("{:?} {:?} {:?}", node.role(), node.label(), node.id()))
}

#[test]
fn tab_leads_to_every_widget_and_shows_it() {
    let mut app = app_with_commands();
    app.add_message::<MeshRequest>().add_message::<BodyFileRequest>();
    settle(&mut app);
    let workspaces = app.world().resource::<Workspaces>().0.clone();
    let mut seen = 0;
    for workspace in workspaces {
        let found = Cell::new(KeyboardFocus::Commands);
        let mut is_by_keys = false;
        let mut harness = workspace_panels(&mut app, workspace, |ctx| {
            found.set(focus_ui(ctx, &mut is_by_keys));
        });
        assert!(!has_ring(&harness));
        let mut wanted = usable(&harness);
        seen += wanted.len();
        for _ in 0..MOST_TABS {
            if wanted.is_empty() {
                break;
            }
            harness.key_press(egui::Key::Tab);
            harness.run_steps(2);
            let Some(now) = focused(&harness) else { continue };
            wanted.remove(&now);
            let is_text = found.get() == KeyboardFocus::Text;
            assert!(is_text || has_ring(&harness), "{}: {now}", workspace.name);
        }
        assert!(wanted.is_empty(), "{}: {wanted:?}", workspace.name);
    }
    assert!(seen > 20, "{seen}");
}
