//! The error slice: where it lies, which way its imagined sensor points, its colours.

use super::PanelAction;
use super::widgets::{NumberChange, NumberField, number_ui, section_ui};
use crate::design::view::{ColorMap, Quantity, SliceAxis, SliceView, View};
use crate::editor::state::ViewRequest;
use crate::geometry::bounds::Bounds;
use bevy_egui::egui::{self, ComboBox, Slider, SliderClamping, Ui};

/// What the section shows.
pub struct SlicePanelView<'a> {
    pub view: &'a View,
    /// The model's box.
    pub bounds: Bounds,
    /// Whether the room says where its model may be believed.
    pub has_support: bool,
    /// The largest value of the slice, the automatic end of the colour bar.
    pub max_mm: Option<f64>,
}

const NO_SUPPORT: &str =
    "This room does not say where its model may be believed; fit its measurements again to know";

const AXIS_NAMES: [&str; 3] = ["x", "y", "z"];

/// Draws the section.
pub fn slice_ui(ui: &mut Ui, panel: &SlicePanelView) -> Vec<PanelAction> {
    let before = panel.view.slice;
    let mut slice = before;
    section_ui(ui, "Error slice");
    quantity_ui(ui, panel.has_support, &mut slice);
    row_ui(ui, "across", |ui| {
        for axis in SliceAxis::ALL {
            let name = AXIS_NAMES[axis.index()];
            if ui.selectable_label(slice.axis == axis, name).clicked() && slice.axis != axis {
                slice.axis = axis;
                // The old place means nothing along another axis.
                slice.position_mm = panel.bounds.center_mm()[axis.index()];
            }
        }
    });
    position_ui(ui, &panel.bounds, &mut slice);
    row_ui(ui, "sensor along", |ui| {
        for (k, name) in AXIS_NAMES.into_iter().enumerate() {
            let mut along = [0.0; 3];
            along[k] = 1.0;
            if ui
                .selectable_label(slice.sensor_axis == along, name)
                .clicked()
            {
                slice.sensor_axis = along;
            }
        }
    });
    range_ui(ui, panel.max_mm, &mut slice);
    row_ui(ui, "colours", |ui| {
        ComboBox::from_id_salt("color map")
            .selected_text(slice.color_map.name())
            .width(90.0)
            .show_ui(ui, |ui| {
                for map in ColorMap::ALL {
                    ui.selectable_value(&mut slice.color_map, map, map.name());
                }
            });
    });
    if slice == before {
        return Vec::new();
    }
    let view = View {
        slice,
        ..panel.view.clone()
    };
    vec![PanelAction::View(ViewRequest::Set(view))]
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
        super::widgets::warning_ui(ui, NO_SUPPORT);
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
    let axis = slice.axis.index();
    let range = bounds.min_mm[axis]..=bounds.max_mm[axis];
    row_ui(ui, "at", |ui| {
        let field = NumberField {
            decimals: 1,
            speed: 1.0,
            ..NumberField::length("slice position in mm")
        };
        set_from(number_ui(ui, &field, slice.position_mm), |v| {
            slice.position_mm = v;
        });
    });
    ui.horizontal(|ui| {
        ui.add_space(6.0);
        let mut position_mm = slice.position_mm;
        ui.spacing_mut().slider_width = (ui.available_width() - 8.0).max(40.0);
        let slider = Slider::new(&mut position_mm, range)
            .show_value(false)
            .clamping(SliderClamping::Never)
            .step_by(1.0);
        if ui.add(slider).changed() {
            slice.position_mm = position_mm;
        }
    });
}

fn range_ui(ui: &mut Ui, max_mm: Option<f64>, slice: &mut SliceView) {
    row_ui(ui, "up to", |ui| {
        if let Some(range_mm) = slice.range_mm {
            let field = NumberField {
                min: 0.01,
                speed: 0.02,
                ..NumberField::length("colour range in mm")
            };
            set_from(number_ui(ui, &field, range_mm), |v| {
                slice.range_mm = Some(v);
            });
        }
        let mut is_automatic = slice.range_mm.is_none();
        if ui.checkbox(&mut is_automatic, "automatic").changed() {
            slice.range_mm = (!is_automatic).then(|| max_mm.filter(|m| *m > 0.0).unwrap_or(1.0));
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

fn row_ui<R>(ui: &mut Ui, name: &str, add: impl FnOnce(&mut Ui) -> R) {
    ui.horizontal(|ui| {
        ui.add_space(6.0);
        ui.allocate_ui_with_layout(
            egui::vec2(78.0, ui.spacing().interact_size.y),
            egui::Layout::left_to_right(egui::Align::Center),
            |ui| {
                ui.set_min_width(78.0);
                ui.label(name);
            },
        );
        add(ui);
    });
}
