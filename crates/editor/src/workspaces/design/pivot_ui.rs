//! What the turns of a range of motion are about.

use crate::widgets::basic::{NumberField, number_ui, quiet_ui};
use crate::widgets::tooltip::Explain;
use crate::workspaces::design::actions::{DesignAction, number_edits};
use crate::workspaces::design::motion_ui::{AXIS_WIDTH, MotionOf, NARROW};
use crate::workspaces::design::rows::{AXES, row_ui};
use bevy_egui::egui::{self, ComboBox, Ui, vec2};
use trackwright_simulation::{Motion, Pivot};

/// A choice, and the numbers of a point.
pub(crate) fn pivot_ui(
    ui: &mut Ui,
    of: &MotionOf,
    motion: &Motion,
    actions: &mut Vec<DesignAction>,
) {
    let with = |pivot: Pivot| of.edit(Motion { pivot, ..*motion });
    let own = motion.pivot;
    let name = |pivot: &Pivot| pivot.words(of.body_word(), of.reference_word);
    row_ui(ui, "turns about", |ui| {
        let choice = ComboBox::from_id_salt(("pivot", of.role.name()))
            .selected_text(name(&own))
            .show_ui(ui, |ui| {
                let all = [
                    Pivot::Tip,
                    Pivot::Origin,
                    Pivot::on_shaft(of.body),
                    Pivot::Reference([0.0; 3]),
                ];
                for pivot in all {
                    let is = std::mem::discriminant(&own) == std::mem::discriminant(&pivot);
                    let choice = ui.selectable_label(is, name(&pivot)).explained(about(&pivot));
                    if choice.clicked() && !is {
                        actions.push(DesignAction::apply(with(pivot)));
                    }
                }
            });
        let response = choice.response;
        let info = || egui::WidgetInfo::labeled(egui::WidgetType::ComboBox, true, "turns about");
        response.widget_info(info);
        response.explained("What stays where it is when the range of motion turns the body");
    });
    let (point, of_what): (_, fn([f64; 3]) -> Pivot) = match own {
        Pivot::Body(point) => (point, Pivot::Body),
        Pivot::Reference(point) => (point, Pivot::Reference),
        Pivot::Tip | Pivot::Origin => return,
    };
    // In a row below those of the axes, of which each is as wide.
    ui.horizontal(|ui| {
        ui.spacing_mut().item_spacing.x = 4.0;
        let size = vec2(AXIS_WIDTH, ui.spacing().interact_size.y);
        let layout = egui::Layout::left_to_right(egui::Align::Center);
        ui.allocate_ui_with_layout(size, layout, |ui| {
            ui.set_min_width(AXIS_WIDTH);
            quiet_ui(ui, "x, y, z");
        });
        for (k, axis) in AXES.into_iter().enumerate() {
            let field_name = format!("pivot {axis} in mm");
            let field = NumberField { decimals: 1, ..NumberField::length(&field_name) };
            let changes = number_ui(ui, &field.width(NARROW), point[k]);
            number_edits(&changes, actions, "Move pivot", |v| {
                let mut point = point;
                point[k] = v;
                Some(with(of_what(point)))
            });
        }
    });
}

fn about(pivot: &Pivot) -> &'static str {
    match pivot {
        Pivot::Tip => "The tip stays in its place: the tool is tilted over its target",
        Pivot::Origin => "The origin of its mesh stays in its place, as in the paper",
        Pivot::Body(_) => "A point of the body, such as where a needle enters the skin",
        Pivot::Reference(_) => "A point that is fixed to it, such as a joint of the patient",
    }
}
