//! What is set of a layer below its switch.

use super::app::{design, environment, layers};
use super::harness::use_panel;
use bevy_egui::egui;
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;
use trackwright_design::view::{AxisRule, Quantity, View};
use trackwright_editor::document::selection::Selection;
use trackwright_editor::layers::layers_ui::{LayerFigures, LayersView, Listed, layers_ui};
use trackwright_editor::layers::legend::{ColorBar, Legends};
use trackwright_editor::layers::slice;
use trackwright_editor::widgets::theme;
use trackwright_editor::workspaces::design::outliner::outliner_ui;
use trackwright_editor::workspaces::design::outliner_row::OutlinerView;
use trackwright_field::Environment;
use trackwright_geometry::colormap::ColorMap;
use trackwright_geometry::orbit::{OrbitCamera, Projection};

fn camera() -> OrbitCamera {
    OrbitCamera {
        focus_mm: nalgebra::Point3::new(0.0, 0.0, -300.0),
        distance_mm: 900.0,
        azimuth_rad: 0.6,
        elevation_rad: 0.3,
        projection: Projection::Perspective,
    }
}

/// A slice whose largest value is known.
fn legends() -> Legends {
    let mut legends = Legends::default();
    let bar = ColorBar {
        label: String::new(),
        note: None,
        unit: "mm",
        map: ColorMap::default(),
        min: 0.0,
        max: 1.0,
        largest: 2.347,
        decimals: 2,
        limit: None,
    };
    legends.set_bar(slice::LAYER.row.order, Some(bar));
    legends
}

/// The views that the outliner requested while it was used, as narrow as in the window.
fn requested(view: &View, room: &Environment, act: impl Fn(&mut Harness)) -> Vec<View> {
    let (design, selection) = (design(), Selection::default());
    let (layers, legends) = (layers(), legends());
    let panel = |ui: &mut egui::Ui| {
        let outliner = OutlinerView::new(&design, room, view, &selection);
        assert_eq!(outliner_ui(ui, &outliner), []);
        let figures = LayerFigures {
            layers: &layers,
            legends: Some(&legends),
            camera: Some(camera()),
            ..LayerFigures::default()
        };
        let panel = LayersView { view, environment: room, figures, listed: Listed::All };
        let actions = layers_ui(ui, &panel);
        let width = ui.min_rect().width();
        assert!(width <= theme::LEFT_WIDTH - 16.0, "wider than the panel: {width}");
        actions
    };
    use_panel([theme::LEFT_WIDTH - 16.0, 1400.0], panel, act)
}

fn with(change: impl FnOnce(&mut View)) -> View {
    let mut view = View::default();
    view.layers.slice = false;
    change(&mut view);
    view
}

#[test]
fn a_layer_that_is_off_shows_no_settings() {
    let views = requested(&with(|_| ()), &environment(), |harness| {
        for label in ["per side", "turned", "colours", "shows"] {
            assert!(harness.query_by_label(label).is_none(), "{label}");
        }
    });
    assert_eq!(views, []);
}

#[test]
fn arrows_are_of_a_sensor_or_of_the_tool() {
    let view = with(|view| view.layers.arrows = true);
    let room = environment();
    let views = requested(&view, &room, |harness| {
        harness.get_by_label("the tool's").click();
    });
    assert!(views.len() == 1 && views[0].arrows.of_tool, "{views:?}");
    let views = requested(&view, &room, |harness| harness.get_by_label("x").click());
    assert_eq!(views[0].slice.sensor_axis, [1.0, 0.0, 0.0]);
    // Of the tool no axis is chosen.
    requested(&views_of_tool(&view), &room, |harness| {
        assert!(harness.query_by_label("sensor along").is_none());
    });
}

fn views_of_tool(view: &View) -> View {
    let mut view = view.clone();
    view.arrows.of_tool = true;
    view
}

#[test]
fn placement_requests_a_sensor() {
    let view = with(|view| view.layers.placement = true);
    let views = requested(&view, &environment(), |harness| {
        harness.get_by_label("select a sensor");
        let chosen = view.placement_rule.name();
        harness.get_by_value(chosen).click();
        harness.run_steps(3);
        harness.get_by_label(AxisRule::Tangent.name()).click();
    });
    assert_eq!(views[0].placement_rule, AxisRule::Tangent);
}

#[test]
fn the_slice_faces_the_view_on_request() {
    let view = with(|view| view.layers.slice = true);
    let room = environment();
    let views = requested(&view, &room, |harness| {
        harness.get_by_label("the view").click();
    });
    let mut wanted = view.slice;
    wanted.face(&camera(), room.model.bounds());
    assert_eq!(views[0].slice, wanted);
    assert_eq!(views[0].check(), Ok(()));
    let views = requested(&views[0], &room, |harness| {
        let axes: Vec<_> = harness.get_all_by_label("z").collect();
        axes[0].click();
    });
    assert_eq!(views[0].slice, view.slice);
}

#[test]
fn a_fixed_range_starts_at_the_largest_value() {
    let view = with(|view| {
        view.layers.slice = true;
        view.slice.quantity = Quantity::GradientMmPerMm;
    });
    let views = requested(&view, &environment(), |harness| {
        harness.get_by_label("automatic").click();
    });
    // Four decimals, so that the number is what is shown.
    let range = views[0].slice.range_mm.unwrap();
    assert!((range - 2.347).abs() < 1e-12, "{range}");
    requested(&views[0], &environment(), |harness| {
        harness.get_by_value("2.3470\u{2009}mm/mm");
    });
}

#[test]
fn model_validity_needs_a_room_with_it() {
    let view = with(|_| ());
    let click = |harness: &mut Harness| harness.get_by_label("Model support").click();
    assert_eq!(requested(&view, &environment(), click), []);
    let world = trackwright_project::open_builtin(trackwright_project::DEFAULT_BUILTIN).unwrap();
    let views = requested(&view, &world.environment, click);
    assert!(views.len() == 1 && views[0].layers.support);
}

#[test]
fn the_field_workspace_lists_room_layers() {
    let view = View::default();
    let room = environment();
    let layers = layers();
    let panel = LayersView {
        view: &view,
        environment: &room,
        figures: LayerFigures { layers: &layers, ..LayerFigures::default() },
        listed: Listed::OfTheRoom,
    };
    let size = [theme::LEFT_WIDTH - 16.0, 600.0];
    let requests = use_panel(
        size,
        |ui| layers_ui(ui, &panel),
        |harness| {
            assert!(harness.query_by_label("Ghost").is_none());
            for name in ["Volume", "Error slice", "Usable region", "Model support"] {
                assert!(harness.query_by_label(name).is_some(), "{name}");
            }
            harness.get_by_label("Field arrows").click();
        },
    );
    let mut wanted = view.clone();
    wanted.layers.arrows = true;
    assert_eq!(requests, [wanted]);
}
