//! The legend: everything that is drawn is named, no two things share a colour, one scale a quantity,
//! and it can be folded.

use super::app::{create_scene_app, named, settle};
use super::field_layers::{app_with, rest};
use bevy::prelude::*;
use bevy_egui::egui;
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;
use std::cell::Cell;
use std::sync::Arc;
use trackwright_design::view::{Layers, Magnification, Quantity, View};
use trackwright_design::{BodyRole, Edit};
use trackwright_editor::document::requests::{EditRequest, OpenWorld, ViewRequest};
use trackwright_editor::document::selection::{Selected, Selection};
use trackwright_editor::layers::legend::{ColorBar, Legends};
use trackwright_editor::layers::legend_entries::LegendEntries;
use trackwright_editor::layers::registry::{LayerInfo, LayerRegistry};
use trackwright_editor::layers::{field_arrows, placement, slice};
use trackwright_editor::palette::{self, Ground, Rgb};
use trackwright_editor::viewport::overlay::OverlayPlugin;
use trackwright_editor::viewport::overlay::legend::{Title, entries_ui, title_ui};
use trackwright_field::Environment;
use trackwright_field::environment::Jitter;
use trackwright_simulation::{Metric, Requirement};

/// Every layer registers, and each has something to draw: the room states a jitter, a sensor is
/// selected.
fn app() -> App {
    let mut app = app_with(|app| {
        app.add_plugins(OverlayPlugin);
    });
    let sensor = Selected::Sensor(BodyRole::Tool, 0);
    *app.world_mut().resource_mut::<Selection>() = Selection::of(Some(sensor));
    let mut open = app.world_mut().resource_mut::<OpenWorld>();
    let jitter = Some(Jitter::uniform(0.2, 0.004));
    open.0.environment =
        Arc::new(Environment { jitter, ..Environment::clone(&open.0.environment) });
    let loose = Requirement::at_most([(Metric::TIP_RMS, 1.2)]);
    let loosen = Edit::SetRequirement(Some(loose));
    app.world_mut().write_message(EditRequest::Apply(loosen));
    show(&mut app, |view| {
        view.layers = Layers::none();
        view.magnification = Magnification::Times(20.0);
    });
    app
}

fn show(app: &mut App, change: impl FnOnce(&mut View)) {
    let mut view = app.world().resource::<OpenWorld>().0.document.view().clone();
    change(&mut view);
    app.world_mut().write_message(ViewRequest::Set(view));
    rest(app);
    app.update();
}

fn layers(app: &App) -> Vec<LayerInfo> {
    app.world().resource::<LayerRegistry>().layers.clone()
}

fn entries(app: &App) -> LegendEntries {
    let (open, legends) = (app.world().resource::<OpenWorld>(), app.world().resource::<Legends>());
    LegendEntries::new(&open.0, &layers(app), legends, false)
}

fn bar(app: &App, layer: &LayerInfo) -> ColorBar {
    app.world().resource::<Legends>().bar(layer.row.order).cloned().unwrap()
}

/// Entities that have a shape.
fn drawn(app: &mut App) -> usize {
    let world = app.world_mut();
    let mut shapes = world.query_filtered::<(), Or<(With<Mesh3d>, With<Gizmo>)>>();
    shapes.iter(world).count()
}

#[test]
fn every_layer_that_draws_is_in_the_legend() {
    let mut app = app();
    let (nothing, shapes) = (entries(&app), drawn(&mut app));
    // Bodies and sensors are there without any layer.
    assert!(nothing.keys.len() >= 3 && nothing.strokes.is_empty() && nothing.bars.is_empty());
    for layer in layers(&app) {
        if layer.row.label == "Labels" {
            continue;
        }
        show(&mut app, |view| {
            view.layers = Layers::none();
            *(layer.row.switch)(&mut view.layers) = true;
        });
        let found = entries(&app);
        let added = found.keys.len() - nothing.keys.len() + found.strokes.len() + found.bars.len();
        // Anatomy is a part of its body's entity, shown and hidden with it.
        let draws = drawn(&mut app) > shapes || layer.row.label == "Anatomy";
        assert!(draws, "{} draws nothing", layer.row.label);
        assert!(added > 0, "{} has no entry in the legend", layer.row.label);
    }
}

#[test]
fn no_two_things_in_the_legend_share_a_colour() {
    let mut app = app();
    let all = layers(&app);
    show(&mut app, |view| {
        for layer in &all {
            *(layer.row.switch)(&mut view.layers) = true;
        }
    });
    let found = entries(&app);
    let strokes = found.strokes.iter().map(|stroke| (stroke.words.clone(), stroke.color));
    let keys = found.keys.iter().flat_map(|key| {
        let colors = key.swatch.colors().into_iter();
        colors.map(|color| (key.text.clone(), color))
    });
    // Drawn in one workspace only, over any layer.
    let ghosts = [
        ("baseline", palette::BASELINE),
        ("tool as measured", palette::MEASURED),
        ("places found", palette::FOUND_PLACE),
        ("metal found", palette::FOUND_METAL),
    ];
    let ghosts = ghosts.map(|(name, color)| (name.to_owned(), color));
    let things: Vec<(String, Rgb)> = strokes.chain(keys).chain(ghosts).collect();
    assert!(things.len() > 15, "{things:?}");
    // Eight bits a channel: nearer colours are hard to tell apart.
    const LEAST: f64 = 40.0;
    for ground in [Ground::Dark, Ground::Light] {
        for (i, (one, a)) in things.iter().enumerate() {
            for (other, b) in &things[i + 1..] {
                let parts = a.on(ground).into_iter().zip(b.on(ground));
                let squares = parts.map(|(a, b)| (f64::from(a) - f64::from(b)).powi(2));
                let apart = squares.sum::<f64>().sqrt();
                assert!(apart > LEAST, "{ground:?}: {one:?} and {other:?}: {apart}");
            }
        }
    }
}

#[test]
fn a_slide_explains_no_bodies() {
    let mut app = app();
    let all = layers(&app);
    show(&mut app, |view| {
        for layer in &all {
            *(layer.row.switch)(&mut view.layers) = true;
        }
    });
    let (open, legends) = (app.world().resource::<OpenWorld>(), app.world().resource::<Legends>());
    let words = |is_slide| {
        let found = LegendEntries::new(&open.0, &all, legends, is_slide);
        found.keys.into_iter().map(|key| key.text).collect::<Vec<_>>()
    };
    let (all, slide) = (words(false), words(true));
    for of_designers in ["tool", "CRF", "sensors"].map(str::to_owned) {
        assert!(all.contains(&of_designers) && !slide.contains(&of_designers), "{slide:?}");
    }
    assert!(slide.iter().any(|text| text == "range of motion"), "{slide:?}");
}

#[test]
fn the_opening_view_shows_few_things() {
    let mut app = create_scene_app();
    settle(&mut app);
    app.update();
    for name in ["tip error", "ghost", "slice", "sensor"] {
        assert!(named(&mut app, name) > 0, "{name}");
    }
    let others = [
        "requirement at the tip",
        "measurement volume",
        "field generator",
        "ground",
        "tracker axes",
        "sensor errors",
        "range of motion",
        "tip scatter",
    ];
    for name in others {
        assert_eq!(named(&mut app, name), 0, "{name}");
    }
}

#[test]
fn the_limit_is_drawn_on_request_and_named() {
    let mut app = app();
    show(&mut app, |view| view.layers.tip_error = true);
    assert_eq!(named(&mut app, "requirement at the tip"), 0);
    show(&mut app, |view| view.layers.requirement = true);
    assert_eq!(named(&mut app, "requirement at the tip"), 1);
    let strokes = entries(&app).strokes;
    let words = "the tip may be 1.20\u{2009}mm off";
    assert!(strokes.iter().any(|stroke| stroke.words == words), "{strokes:?}");
}

#[test]
fn slice_and_arrows_of_one_quantity_share_a_scale() {
    let mut app = app();
    show(&mut app, |view| {
        view.layers.slice = true;
        view.layers.arrows = true;
    });
    let (of_slice, of_arrows) = (bar(&app, &slice::LAYER), bar(&app, &field_arrows::LAYER));
    assert_eq!((of_slice.map, of_slice.max), (of_arrows.map, of_arrows.max));
    let bars = entries(&app).bars;
    assert_eq!(bars.len(), 1, "{bars:?}");
    assert!(bars[0].label.starts_with("position error; arrows "), "{bars:?}");
    // The scale follows the slice as it moves.
    show(&mut app, |view| view.slice.position_mm += 60.0);
    let (of_slice, of_arrows) = (bar(&app, &slice::LAYER), bar(&app, &field_arrows::LAYER));
    assert_eq!(of_slice.max, of_arrows.max);
}

#[test]
fn another_quantity_has_another_map() {
    let mut app = app();
    show(&mut app, |view| {
        view.layers.slice = true;
        view.layers.arrows = true;
        view.layers.placement = true;
        view.slice.quantity = Quantity::OrientationErrorDeg;
    });
    let bars = [&slice::LAYER, &field_arrows::LAYER, &placement::LAYER].map(|of| bar(&app, of));
    let maps = [bars[0].map, bars[1].map, bars[2].map];
    assert!(maps[0] != maps[1] && maps[1] != maps[2] && maps[0] != maps[2], "{maps:?}");
    assert_eq!(entries(&app).bars.len(), 3);
}

#[test]
fn the_placement_bar_names_where_the_coil_is() {
    let mut app = app();
    show(&mut app, |view| view.layers.placement = true);
    let note = bar(&app, &placement::LAYER).note.unwrap();
    assert_eq!(note, "coil on the surface, axis as it is");
}

#[test]
fn every_entry_of_the_legend_is_explained() {
    let mut app = app();
    show(&mut app, |view| view.layers.placement = true);
    for layer in layers(&app) {
        show(&mut app, |view| *(layer.row.switch)(&mut view.layers) = true);
        let found = entries(&app);
        let all = found.strokes.len() + found.keys.len() + found.bars.len();
        assert_eq!(found.abouts.len(), all, "{}", layer.row.label);
        let short: Vec<_> =
            found.abouts.iter().filter(|about| about.split(' ').count() < 4).collect();
        assert!(short.is_empty(), "{}: {short:?}", layer.row.label);
    }
}

#[test]
fn an_entry_under_the_pointer_is_explained() {
    let rect = |y: f32| egui::Rect::from_min_size(egui::pos2(20.0, y), egui::vec2(120.0, 15.0));
    let entries = vec![(rect(60.0), "About the first"), (rect(80.0), "About the second")];
    let title = Title { rect: rect(30.0), entries, after_click: None, is_folded: false };
    let mut harness = Harness::builder()
        .with_size(egui::vec2(300.0, 200.0))
        .build_ui(|ui| entries_ui(ui.ctx(), &title));
    harness.run_steps(2);
    assert!(harness.query_by_label_contains("About").is_none());
    harness.hover_at(egui::pos2(40.0, 88.0));
    harness.run_steps(2);
    assert!(harness.query_by_label("About the second").is_some());
    assert!(harness.query_by_label("About the first").is_none());
}

#[test]
fn a_click_on_the_title_folds_the_legend() {
    let rect = egui::Rect::from_min_size(egui::pos2(20.0, 30.0), egui::vec2(120.0, 22.0));
    let title = Title { rect, entries: Vec::new(), after_click: Some(true), is_folded: false };
    let clicks = Cell::new(0);
    let mut harness = Harness::builder().with_size(egui::vec2(300.0, 200.0)).build_ui(|ui| {
        clicks.set(clicks.get() + usize::from(title_ui(ui.ctx(), &title)));
    });
    harness.run_steps(2);
    assert_eq!(clicks.get(), 0);
    harness.get_by_label("Legend").click();
    harness.run_steps(2);
    assert_eq!(clicks.get(), 1);
}
