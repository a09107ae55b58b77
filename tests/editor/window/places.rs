//! Where things are in the window: the panels are laid out once more without it, and the camera
//! projects as the core does.

use super::screen::SIZE;
use crate::app::layers;
use bevy_egui::egui::{self, Rect, UiBuilder, pos2};
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;
use nalgebra::Point3;
use trackwright_design::{BodyRole, HandleAxes};
use trackwright_editor::document::selection::{Selected, Selection};
use trackwright_editor::layers::layers_ui::{LayerFigures, LayersView, Listed, layers_ui};
use trackwright_editor::viewport::coil_fit::ShownFindings;
use trackwright_editor::viewport::gizmo::gizmo_of;
use trackwright_editor::widgets::theme;
use trackwright_editor::workspaces::design::inspector::{InspectorView, inspector_ui};
use trackwright_editor::workspaces::design::outliner::outliner_ui;
use trackwright_editor::workspaces::design::outliner_row::OutlinerView;
use trackwright_geometry::gizmo::{Eye, Handle};
use trackwright_geometry::orbit::{Axis, OrbitCamera};
use trackwright_project::World;

/// Space that the panels' frames leave at the sides.
const LEFT_MARGIN: f32 = 8.0;
const RIGHT_MARGIN: f32 = 12.0;

/// The 3D view: the hole between the panels.
pub fn view() -> Rect {
    let [width, height] = SIZE.map(f32::from);
    Rect::from_min_max(
        pos2(theme::LEFT_WIDTH, theme::TOP_BAR_HEIGHT),
        pos2(width - theme::RIGHT_WIDTH, height - theme::STATUS_BAR_HEIGHT),
    )
}

/// Where a point of the tracker frame is drawn in the window.
pub fn project(camera: &OrbitCamera, point_mm: &Point3<f64>) -> [f64; 2] {
    let size = view().size();
    let view_px = [f64::from(size.x), f64::from(size.y)];
    let [x, y] = camera.project(point_mm, view_px).expect("in front of the camera");
    [x + f64::from(view().min.x), y + f64::from(view().min.y)]
}

/// The handle that moves what is selected along its own x, and the direction in which it points, in the
/// window.
pub fn arrow_x(world: &World, selected: Selected, camera: &OrbitCamera) -> ([f64; 2], [f64; 2]) {
    let document = &world.document;
    let selection = Selection::of(Some(selected));
    let axes = HandleAxes::default();
    let shown = gizmo_of(document.design(), document.view(), &selection, axes).unwrap();
    let size = view().size();
    let eye = Eye { camera: *camera, view_px: [size.x.into(), size.y.into()] };
    let [x, y] = shown.gizmo.grip_px(Handle::arrow(Axis::X), &eye).unwrap();
    let grip = [x + f64::from(view().min.x), y + f64::from(view().min.y)];
    let pivot = project(camera, &shown.gizmo.pivot_mm());
    let way = [grip[0] - pivot[0], grip[1] - pivot[1]];
    let length = way[0].hypot(way[1]);
    (grip, way.map(|d| d / length))
}

/// The middle of the 3D view.
pub fn middle_of_view() -> [f64; 2] {
    let middle = view().center();
    [f64::from(middle.x), f64::from(middle.y)]
}

/// A row of the outliner, or a switch of the layers below it.
pub fn in_outliner(world: &World, label: &str) -> [f64; 2] {
    let rect = Rect::from_min_max(
        pos2(LEFT_MARGIN, theme::TOP_BAR_HEIGHT),
        pos2(theme::LEFT_WIDTH - LEFT_MARGIN, SIZE[1].into()),
    );
    let layers = layers();
    let harness = laid_out(rect, |ui| {
        let selection = Selection::default();
        let outliner = OutlinerView::new(
            world.document.design(),
            &world.environment,
            world.document.view(),
            &selection,
        );
        outliner_ui(ui, &outliner);
        let figures = LayerFigures { layers: &layers, ..LayerFigures::default() };
        let (view, environment) = (world.document.view(), &world.environment);
        layers_ui(ui, &LayersView { view, environment, figures, listed: Listed::All });
    });
    place(harness.get_by_label(label).rect())
}

/// A number or text field of the inspector.
pub fn in_inspector(world: &World, selected: Option<Selected>, label: &str) -> [f64; 2] {
    let right = f32::from(SIZE[0]);
    let rect = Rect::from_min_max(
        pos2(right - theme::RIGHT_WIDTH + RIGHT_MARGIN, theme::TOP_BAR_HEIGHT),
        pos2(right - RIGHT_MARGIN, SIZE[1].into()),
    );
    let harness = laid_out(rect, |ui| {
        let inspector = InspectorView {
            design: world.document.design(),
            selection: &Selection::of(selected),
            is_available: &|_| true,
            pose: None,
            coils: ShownFindings::default(),
            derived_weight: world.environment.orientation_weight(None),
        };
        inspector_ui(ui, &inspector);
    });
    // A field may share its label with the text beside it: the field is the last of the row.
    let field = harness.get_all_by_label(label).last().expect("a field");
    place(field.rect())
}

/// The sensor of the tool with this name.
pub fn tool_sensor(world: &World, name: &str) -> (Selected, Point3<f64>) {
    let design = world.document.design();
    let sensors = &design.tool.body.rigid.sensors;
    let index = sensors.iter().position(|sensor| sensor.name == name).expect("a sensor");
    let pose = design.tracker_from_body(BodyRole::Tool).expect("a pose");
    (Selected::Sensor(BodyRole::Tool, index), pose * sensors[index].position_in_body)
}

fn laid_out<'a>(rect: Rect, panel: impl Fn(&mut egui::Ui) + 'a) -> Harness<'a> {
    Harness::builder().with_size(egui::vec2(SIZE[0].into(), SIZE[1].into())).build_ui(move |ui| {
        theme::apply(ui.ctx());
        ui.scope_builder(UiBuilder::new().max_rect(rect), |ui| panel(ui));
    })
}

fn place(rect: Rect) -> [f64; 2] {
    let middle = rect.center();
    [f64::from(middle.x), f64::from(middle.y)]
}
