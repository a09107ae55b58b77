//! The page that makes a row of sensors: how many, how far apart, in which direction.

use crate::document::requests::{EditRequest, OpenWorld};
use crate::document::selection::{Selected, Selection};
use crate::schedule::EditorSystems;
use crate::schedule::UiSystems;
use crate::shell::commands::AddCommand;
use crate::shell::requests::Requests;
use crate::shell::shortcuts::{KeysHeld, ShortcutsSystems};
use crate::viewport::sensor_commands::SensorCommand;
use crate::widgets::basic::{
    FIELD_WIDTH, NumberChange, NumberField, main_button, number_ui, quiet_ui, warning_ui,
};
use crate::widgets::tooltip::{Explain, button_ui};
use bevy::prelude::*;
use bevy_egui::egui::{self, Align, ComboBox, Context, Id, Key, Layout, RichText, Ui};
use bevy_egui::{EguiContexts, EguiPrimaryContextPass};
use nalgebra::Vector3;
use trackwright_design::{ArrangeError, Arrangement, Design, Edit, MAX_ARRAY};

const WIDTH: f32 = 320.0;
const TITLE_SIZE: f32 = 15.0;

/// The page, and what was last entered there.
#[derive(Resource, Clone, Copy, Debug, PartialEq)]
pub struct RowPage {
    pub is_open: bool,
    /// Sensors of the row, the one it begins with included.
    pub count: usize,
    /// From one to the next.
    pub spacing_mm: f64,
    pub direction: RowDirection,
}

impl Default for RowPage {
    fn default() -> Self {
        Self { is_open: false, count: 3, spacing_mm: 15.0, direction: RowDirection::Z }
    }
}

/// Registers the command that opens the page, and draws it.
pub fn plugin(app: &mut App) {
    app.init_resource::<RowPage>()
        .add_command(*SensorCommand::Row.command(), |mut page: ResMut<RowPage>| {
            page.is_open = true;
        })
        .add_systems(
            Update,
            hold_keys.run_if(is_open).in_set(EditorSystems::Input).before(ShortcutsSystems),
        )
        .add_systems(EguiPrimaryContextPass, window.run_if(is_open).in_set(UiSystems::Dialogs));
}

fn is_open(page: Res<RowPage>) -> bool {
    page.is_open
}

fn hold_keys(held: Option<ResMut<KeysHeld>>) {
    if let Some(mut held) = held {
        held.0 = true;
    }
}

fn window(
    mut contexts: EguiContexts,
    mut page: ResMut<RowPage>,
    world: Option<Res<OpenWorld>>,
    selection: Res<Selection>,
    mut requests: Requests<EditRequest>,
) -> Result {
    let Some(world) = world else { return Ok(()) };
    // Writing to the resource would mark it as changed in every frame.
    let page = page.bypass_change_detection();
    let ctx = contexts.ctx_mut()?;
    requests.write_all(row_window(ctx, page, world.0.document.design(), &selection));
    if !page.is_open {
        ctx.request_repaint();
    }
    Ok(())
}

/// Where a row runs, in the frame of the body.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RowDirection {
    X,
    Y,
    Z,
    /// Along the axis of the sensor that was selected last.
    OwnAxis,
}

impl RowDirection {
    pub const ALL: [Self; 4] = [Self::X, Self::Y, Self::Z, Self::OwnAxis];

    pub fn name(self) -> &'static str {
        match self {
            Self::X => "x of the body",
            Self::Y => "y of the body",
            Self::Z => "z of the body",
            Self::OwnAxis => "the sensor's own axis",
        }
    }
}

impl RowPage {
    /// The edit that makes the row; `None` where no sensor is selected.
    pub fn edit(&self, design: &Design, selection: &Selection) -> Option<Edit> {
        let (body, indices) = selection.sensors()?;
        let direction_in_body = match self.direction {
            RowDirection::X => Vector3::x(),
            RowDirection::Y => Vector3::y(),
            RowDirection::Z => Vector3::z(),
            RowDirection::OwnAxis => {
                let Some(Selected::Sensor(_, index)) = selection.primary() else {
                    return None;
                };
                let sensor = design.body(body)?.rigid.sensors.get(index)?;
                // A marker's are the body's.
                sensor.body_from_sensor().rotation * Vector3::z()
            }
        };
        Some(Edit::Arrange {
            body,
            indices,
            arrangement: Arrangement::Array {
                count: self.count,
                spacing_mm: self.spacing_mm,
                direction_in_body,
            },
        })
    }
}

/// Draws the page over everything; the edit once it was requested.
pub fn row_window(
    ctx: &Context,
    page: &mut RowPage,
    design: &Design,
    selection: &Selection,
) -> Option<EditRequest> {
    let modal = egui::Modal::new(Id::new("row of sensors")).show(ctx, |ui| {
        ui.set_width(WIDTH);
        row_page_ui(ui, page, design, selection)
    });
    if modal.inner.is_some() || modal.should_close() {
        page.is_open = false;
    }
    modal.inner
}

/// The page's inside.
pub fn row_page_ui(
    ui: &mut Ui,
    page: &mut RowPage,
    design: &Design,
    selection: &Selection,
) -> Option<EditRequest> {
    ui.label(RichText::new("Row of sensors").size(TITLE_SIZE));
    ui.add_space(6.0);
    let was_typing = ui.memory(|memory| memory.focused().is_some());
    line_ui(ui, "sensors", |ui| {
        let field = NumberField {
            unit: "",
            decimals: 0,
            speed: 0.1,
            min: 2.0,
            max: MAX_ARRAY as f64,
            ..NumberField::length("sensors of the row")
        };
        if let Some(count) = typed(ui, &field, page.count as f64) {
            page.count = count.round() as usize;
        }
    });
    line_ui(ui, "spacing", |ui| {
        let field = NumberField::length("spacing in mm");
        if let Some(spacing_mm) = typed(ui, &field, page.spacing_mm) {
            page.spacing_mm = spacing_mm;
        }
    });
    line_ui(ui, "along", |ui| {
        let choice = ComboBox::from_id_salt("row direction")
            .selected_text(page.direction.name())
            .width(2.0 * FIELD_WIDTH)
            .show_ui(ui, |ui| {
                for direction in RowDirection::ALL {
                    ui.selectable_value(&mut page.direction, direction, direction.name());
                }
            });
        choice.response.explained("In which direction the row goes on from each sensor");
    });
    ui.add_space(4.0);
    let rows = selection.sensors().map_or(0, |(_, indices)| indices.len());
    let edit = page.edit(design, selection);
    let problem = edit.as_ref().and_then(|edit| problem(edit, design));
    let can_be_made = edit.is_some() && problem.is_none();
    match problem {
        Some(problem) => {
            warning_ui(ui, &problem.to_string());
        }
        None => {
            let new = rows * page.count.saturating_sub(1);
            quiet_ui(ui, crate::widgets::basic::counted(new, "new sensor", "new sensors"));
        }
    }
    ui.add_space(10.0);
    let mut request = None;
    ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
        if button_ui(ui, "Cancel", "Closes the page; nothing is changed").clicked() {
            page.is_open = false;
        }
        let is_entered = !was_typing && ui.input(|input| input.key_pressed(Key::Enter));
        let make = ui.add_enabled(can_be_made, main_button("Make row"));
        let make = make.explained("Adds the sensors of the row in one step");
        if make.clicked() || (is_entered && can_be_made) {
            request = edit.map(EditRequest::Apply);
        }
    });
    request
}

/// Why an arrangement cannot be made.
fn problem(edit: &Edit, design: &Design) -> Option<ArrangeError> {
    let Edit::Arrange { body, indices, arrangement } = edit else {
        return None;
    };
    let sensors = &design.body(*body)?.rigid.sensors;
    arrangement.arranged(sensors, indices).err()
}

fn line_ui(ui: &mut Ui, name: &str, add: impl FnOnce(&mut Ui)) {
    ui.horizontal(|ui| {
        ui.label(name);
        ui.with_layout(Layout::right_to_left(Align::Center), add);
    });
}

fn typed(ui: &mut Ui, field: &NumberField, value: f64) -> Option<f64> {
    let changes = number_ui(ui, field, value);
    changes.into_iter().rev().find_map(|change| match change {
        NumberChange::Set(value) => Some(value),
        NumberChange::Begin | NumberChange::Commit => None,
    })
}
