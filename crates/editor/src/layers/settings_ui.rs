//! What can be set of a layer, right below its switch while it is on.

use crate::document::requests::ViewRequest;
use crate::layers::slice_ui::{
    SlicePanelView, color_map_ui, range_ui, row_ui, sensor_axis_ui, slice_settings_ui,
};
use crate::shell::PanelAction;
use crate::widgets::basic::{NumberField, quiet_ui};
use bevy_egui::egui::{self, ComboBox, Slider, Ui};
use trackwright_design::view::{ArrowsView, AxisRule, View};
use trackwright_field::Environment;
use trackwright_geometry::orbit::OrbitCamera;

/// What settings need to know beside the view and the room.
#[derive(Clone, Copy, Debug, Default)]
pub struct LayerFigures {
    pub camera: Option<OrbitCamera>,
    /// The largest value that each layer shows now, in its unit.
    pub slice_max: Option<f64>,
    pub arrows_max_mm: Option<f64>,
    pub placement_max_mm: Option<f64>,
    /// Whether a sensor is selected, of which placement could tell.
    pub is_sensor_selected: bool,
}

/// A layer with settings of its own.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Settings {
    Slice,
    Arrows,
    Placement,
}

impl Settings {
    fn is_on(self, view: &View) -> bool {
        match self {
            Self::Slice => view.layers.slice,
            Self::Arrows => view.layers.arrows,
            Self::Placement => view.layers.placement,
        }
    }
}

/// Draws a layer's settings; nothing while it is off.
pub fn layer_settings_ui(
    ui: &mut Ui,
    settings: Settings,
    view: &View,
    environment: &Environment,
    figures: &LayerFigures,
) -> Vec<PanelAction> {
    if !settings.is_on(view) {
        return Vec::new();
    }
    let draw = |ui: &mut Ui| match settings {
        Settings::Slice => slice_settings_ui(
            ui,
            &SlicePanelView {
                view,
                bounds: *environment.model.bounds(),
                has_support: environment.fit_validity.is_some(),
                max: figures.slice_max,
                camera: figures.camera,
            },
        ),
        Settings::Arrows => changed(view, |after| arrows_ui(ui, after, figures)),
        Settings::Placement => changed(view, |after| placement_ui(ui, after, figures)),
    };
    // Each has its own colours, of one map.
    ui.push_id(format!("{settings:?}"), |ui| {
        let actions = draw(ui);
        ui.add_space(4.0);
        actions
    })
    .inner
}

fn changed(view: &View, set: impl FnOnce(&mut View)) -> Vec<PanelAction> {
    let mut after = view.clone();
    set(&mut after);
    match after == *view {
        true => Vec::new(),
        false => vec![PanelAction::View(ViewRequest::Set(after))],
    }
}

fn arrows_ui(ui: &mut Ui, view: &mut View, figures: &LayerFigures) {
    row_ui(ui, "of", |ui| {
        for (of_tool, name, about) in [
            (false, "a sensor", "A sensor that is imagined at each arrow"),
            (true, "the tool's", "The mean of the tool's own sensors, turned as the tool is seen"),
        ] {
            let label = ui.selectable_label(view.arrows.of_tool == of_tool, name);
            if label.on_hover_text(about).clicked() {
                view.arrows.of_tool = of_tool;
            }
        }
    });
    if !view.arrows.of_tool {
        sensor_axis_ui(ui, &mut view.slice.sensor_axis);
    }
    row_ui(ui, "per side", |ui| {
        ui.spacing_mut().slider_width = 70.0;
        let mut per_side = view.arrows.per_side();
        let slider = Slider::new(&mut per_side, ArrowsView::PER_SIDE);
        let response = ui.add(slider);
        ui.ctx().accesskit_node_builder(response.id, |node| {
            node.set_label("arrows per side".to_owned());
        });
        if response.changed() {
            view.arrows.per_side = per_side;
        }
    });
    let field = NumberField::length("arrows' colour range in mm");
    range_ui(ui, &field, figures.arrows_max_mm, &mut view.arrows.range_mm);
    color_map_ui(ui, &mut view.slice.color_map);
}

fn placement_ui(ui: &mut Ui, view: &mut View, figures: &LayerFigures) {
    if !figures.is_sensor_selected {
        row_ui(ui, "of", |ui| {
            quiet_ui(ui, "select a sensor");
        });
    }
    row_ui(ui, "turned", |ui| {
        ComboBox::from_id_salt("placement rule")
            .selected_text(view.placement_rule.name())
            .width(110.0)
            .show_ui(ui, |ui| {
                for rule in AxisRule::ALL {
                    ui.selectable_value(&mut view.placement_rule, rule, rule.name());
                }
            })
            .response
            .on_hover_text("Which way the sensor points where it is imagined");
    });
    let field = NumberField::length("placement's colour range in mm");
    let range = &mut view.placement_range_mm;
    range_ui(ui, &field, figures.placement_max_mm, range);
    color_map_ui(ui, &mut view.slice.color_map);
}

/// A layer's switch; one that cannot be turned on says why.
pub fn switch_ui(ui: &mut Ui, is_on: &mut bool, name: &str, why_not: Option<&str>) -> bool {
    ui.add_enabled(why_not.is_none(), egui::Checkbox::new(is_on, name))
        .on_disabled_hover_text(why_not.unwrap_or_default())
        .changed()
}
