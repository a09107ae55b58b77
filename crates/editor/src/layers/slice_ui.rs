//! The error slice: where it lies, which way its imagined sensor points, its colours.

use crate::document::requests::ViewRequest;
use crate::shell::PanelAction;
use crate::widgets::basic::{NumberChange, NumberField, number_ui, quiet_ui};
use bevy_egui::egui::{self, ComboBox, Slider, SliderClamping, Ui};
use trackwright_design::view::{ColorMap, Quantity, SliceAxis, SliceView, View};
use trackwright_geometry::bounds::Bounds;
use trackwright_geometry::orbit::OrbitCamera;

/// What the section shows.
pub struct SlicePanelView<'a> {
    pub view: &'a View,
    /// The model's box.
    pub bounds: Bounds,
    /// Whether the room keeps model validity.
    pub has_support: bool,
    /// The largest value of the slice, in its quantity's unit.
    pub max: Option<f64>,
    /// Where the scene is looked at from; `None` before there is a scene.
    pub camera: Option<OrbitCamera>,
}

/// Before a setting's name, and what the name takes.
const INDENT: f32 = 16.0;
const NAME_WIDTH: f32 = 66.0;

/// Width of a range's number.
const RANGE_WIDTH: f32 = 62.0;

const FACE: &str = "Turns the slice to face the view, through what the camera looks at, and keeps it \
    there while the view turns; press again to turn it again";

const AUTOMATIC: &str =
    "Automatic: up to the 95th percentile, so that one bad corner does not take all colours";

/// Why nothing is known of where the model is valid.
pub const NO_SUPPORT: &str =
    "This room has no model validity; fit its measurements again to add it";

const AXIS_NAMES: [&str; 3] = ["x", "y", "z"];

/// Draws the settings alone, for below the layer's switch.
pub fn slice_settings_ui(ui: &mut Ui, panel: &SlicePanelView) -> Vec<PanelAction> {
    let before = panel.view.slice;
    let mut slice = before;
    quantity_ui(ui, panel.has_support, &mut slice);
    plane_ui(ui, panel, &mut slice);
    position_ui(ui, &panel.bounds, &mut slice);
    if !slice.quantity.needs_tool() {
        sensor_axis_ui(ui, &mut slice.sensor_axis);
    }
    let field = NumberField {
        unit: slice.quantity.unit(),
        decimals: slice.quantity.decimals(),
        ..NumberField::length("colour range")
    };
    range_ui(ui, &field, panel.max, &mut slice.range_mm);
    color_map_ui(ui, &mut slice.color_map);
    if slice == before {
        return Vec::new();
    }
    let view = View { slice, ..panel.view.clone() };
    vec![PanelAction::View(ViewRequest::Set(view))]
}

fn plane_ui(ui: &mut Ui, panel: &SlicePanelView, slice: &mut SliceView) {
    row_ui(ui, "across", |ui| {
        for axis in SliceAxis::ALL {
            let name = AXIS_NAMES[axis.index()];
            let is_shown = slice.free.is_none() && slice.axis == axis;
            if ui.selectable_label(is_shown, name).clicked() && !is_shown {
                if slice.axis != axis {
                    // The old place means nothing along another axis.
                    slice.position_mm = panel.bounds.center_mm()[axis.index()];
                }
                slice.axis = axis;
                slice.free = None;
            }
        }
        let name = egui::Button::selectable(slice.free.is_some(), "the view");
        let face = ui.add_enabled(panel.camera.is_some(), name).on_hover_text(FACE);
        if let Some(camera) = panel.camera.filter(|_| face.clicked()) {
            slice.face(&camera, &panel.bounds);
        }
    });
}

/// Which way the imagined sensor points.
pub fn sensor_axis_ui(ui: &mut Ui, sensor_axis: &mut [f64; 3]) {
    row_ui(ui, "sensor along", |ui| {
        for (k, name) in AXIS_NAMES.into_iter().enumerate() {
            let mut along = [0.0; 3];
            along[k] = 1.0;
            if ui.selectable_label(*sensor_axis == along, name).clicked() {
                *sensor_axis = along;
            }
        }
    });
}

/// The map that every coloured layer has in common.
pub fn color_map_ui(ui: &mut Ui, color_map: &mut ColorMap) {
    row_ui(ui, "colours", |ui| {
        ComboBox::from_id_salt("color map")
            .selected_text(color_map.name())
            .width(90.0)
            .show_ui(ui, |ui| {
                for map in ColorMap::ALL {
                    ui.selectable_value(color_map, map, map.name());
                }
            })
            .response
            .on_hover_text("Of every coloured layer");
    });
}

fn quantity_ui(ui: &mut Ui, has_support: bool, slice: &mut SliceView) {
    row_ui(ui, "shows", |ui| {
        ComboBox::from_id_salt("slice quantity")
            .selected_text(short_name(slice.quantity))
            .width(110.0)
            .show_ui(ui, |ui| {
                for quantity in Quantity::ALL {
                    let is_known = has_support || !quantity.needs_support();
                    let is_shown = slice.quantity == quantity;
                    let name = egui::Button::selectable(is_shown, short_name(quantity));
                    let choice = ui
                        .add_enabled(is_known, name)
                        .on_hover_text(quantity.label())
                        .on_disabled_hover_text(NO_SUPPORT);
                    if choice.clicked() && !is_shown {
                        slice.quantity = quantity;
                        // The old range means nothing for another quantity.
                        slice.range_mm = None;
                    }
                }
            });
    });
    if !has_support && slice.quantity.needs_support() {
        crate::widgets::basic::warning_ui(ui, NO_SUPPORT);
    }
}

/// For a narrow panel; the colour bar has the whole name.
fn short_name(quantity: Quantity) -> &'static str {
    match quantity {
        Quantity::PositionErrorMm => "position error",
        Quantity::OrientationErrorDeg => "orientation error",
        Quantity::TipErrorMm => "tip error",
        Quantity::GradientMmPerMm => "gradient",
        Quantity::StdErrorMm => "standard error",
        Quantity::SupportDistanceMm => "nearest sample",
    }
}

fn position_ui(ui: &mut Ui, bounds: &Bounds, slice: &mut SliceView) {
    let [least, most] = bounds.span_mm(&slice.normal());
    row_ui(ui, "at", |ui| {
        let field =
            NumberField { decimals: 1, speed: 1.0, ..NumberField::length("slice position in mm") };
        set_from(number_ui(ui, &field, slice.offset_mm()), |v| {
            slice.set_offset_mm(v);
        });
    });
    ui.horizontal(|ui| {
        ui.add_space(INDENT);
        let mut offset_mm = slice.offset_mm();
        ui.spacing_mut().slider_width = (ui.available_width() - 8.0).max(40.0);
        let slider = Slider::new(&mut offset_mm, least..=most)
            .show_value(false)
            .clamping(SliderClamping::Never)
            .step_by(1.0);
        if ui.add(slider).changed() {
            slice.set_offset_mm(offset_mm);
        }
    });
}

/// Where colours end: by themselves, or at a number in the field's unit.
pub fn range_ui(ui: &mut Ui, field: &NumberField, largest: Option<f64>, range: &mut Option<f64>) {
    let step = 10f64.powi(-(field.decimals as i32));
    let field = NumberField { min: step, speed: step, width: RANGE_WIDTH, ..*field };
    row_ui(ui, "up to", |ui| {
        if let Some(value) = *range {
            set_from(number_ui(ui, &field, value), |v| {
                *range = Some(v);
            });
        }
        let mut is_automatic = range.is_none();
        // Beside a number there is no room for the word.
        let name = if is_automatic { "automatic" } else { "" };
        let automatic = ui.checkbox(&mut is_automatic, name).on_hover_text(AUTOMATIC);
        ui.ctx().accesskit_node_builder(automatic.id, |node| {
            node.set_label("automatic".to_owned());
        });
        if automatic.changed() {
            // What can be typed, so that the number stays as it is shown.
            let round = |value: f64| (value / step).ceil() * step;
            *range = (!is_automatic).then(|| largest.filter(|m| *m > 0.0).map_or(1.0, round));
        }
    });
}

fn set_from(changes: Vec<NumberChange>, mut set: impl FnMut(f64)) {
    for change in changes {
        if let NumberChange::Set(value) = change {
            set(value);
        }
    }
}

/// A setting: its name, set back from the layers' own, and what it can be set with.
pub fn row_ui<R>(ui: &mut Ui, name: &str, add: impl FnOnce(&mut Ui) -> R) {
    ui.horizontal(|ui| {
        ui.add_space(INDENT);
        ui.allocate_ui_with_layout(
            egui::vec2(NAME_WIDTH, ui.spacing().interact_size.y),
            egui::Layout::left_to_right(egui::Align::Center),
            |ui| {
                ui.set_min_width(NAME_WIDTH);
                quiet_ui(ui, name);
            },
        );
        add(ui);
    });
}
