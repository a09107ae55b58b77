//! A row of the outliner: of what can be selected, hidden and locked, with what can be done to it.

use crate::document::requests::ViewRequest;
use crate::document::selection::{Selected, Selection};
use crate::shell::top_bar::item_ui;
use crate::viewport::coil_fit::ShownFindings;
use crate::viewport::sensor_commands::SensorCommand;
use crate::widgets::basic::{Row, row_ui};
use crate::widgets::switch::{SWITCH_WIDTH, Switch, switch_ui};
use crate::widgets::theme;
use crate::workspaces::design::actions::DesignAction;
use crate::workspaces::design::sensor_ui::{IsAvailable, sensor_menu_ui};
use bevy_egui::egui::{Rect, Response, Ui, vec2};
use trackwright_design::view::View;
use trackwright_design::{Design, Thing, Things};
use trackwright_field::environment::Environment;
use trackwright_formats::printable::printable;
use trackwright_metal::furnished::FurnishError;
use trackwright_simulation::PoseDetail;

/// What the outliner shows.
pub struct OutlinerView<'a> {
    pub design: &'a Design,
    pub environment: &'a Environment,
    pub view: &'a View,
    pub selection: &'a Selection,
    pub hovered: Option<Selected>,
    pub is_available: IsAvailable<'a>,
    /// Shows which sensors are outside the box or the volume.
    pub pose: Option<&'a PoseDetail>,
    /// Coils that do not fit.
    pub coils: ShownFindings<'a>,
    /// Why the room's metal cannot be simulated.
    pub metal_problem: Option<&'a FurnishError>,
}

impl<'a> OutlinerView<'a> {
    /// Of a design at rest: nothing under the pointer, no results yet, every command at hand.
    pub fn new(
        design: &'a Design,
        environment: &'a Environment,
        view: &'a View,
        selection: &'a Selection,
    ) -> Self {
        Self {
            design,
            environment,
            view,
            selection,
            hovered: None,
            is_available: &|_| true,
            pose: None,
            coils: ShownFindings::default(),
            metal_problem: None,
        }
    }
}

/// A row of what can be selected, with the switches of what can be hidden and locked.
pub(crate) fn selectable_ui(
    ui: &mut Ui,
    outliner: &OutlinerView,
    what: Selected,
    row: Row,
    actions: &mut Vec<DesignAction>,
) {
    let row = Row {
        is_selected: outliner.selection.contains(what),
        is_hovered: outliner.hovered == Some(what),
        ..row
    };
    let thing = match what {
        Selected::Body(role) => Some(Thing::body(role)),
        Selected::Sensor(role, _) => Some(Thing::sensor(role, row.label)),
        Selected::Metal(_) => Some(Thing::Metal(row.label.to_owned())),
        Selected::Tip(_) | Selected::Anatomy(_) => None,
    };
    let response = with_switches_ui(ui, outliner.view, thing, &row, actions);
    answer(ui, &response, what, outliner, actions);
}

/// A row, and at its right end the switches of a thing that can be hidden and locked.
fn with_switches_ui(
    ui: &mut Ui,
    view: &View,
    thing: Option<Thing>,
    row: &Row,
    actions: &mut Vec<DesignAction>,
) -> Response {
    let Some(thing) = thing else {
        return row_ui(ui, row);
    };
    ui.horizontal(|ui| {
        ui.spacing_mut().item_spacing.x = 0.0;
        let whole = vec2(ui.available_width(), theme::ROW_HEIGHT);
        let size = whole - vec2(2.0 * SWITCH_WIDTH, 0.0);
        let response = ui.allocate_ui(size, |ui| row_ui(ui, row)).inner;
        let whole = Rect::from_min_size(response.rect.min, whole);
        let is_near = ui.rect_contains_pointer(whole) || row.is_hovered;
        type ThingsOf = fn(&mut View) -> &mut Things;
        let switches: [(Switch, ThingsOf); 2] =
            [(Switch::Eye, |view| &mut view.hidden), (Switch::Lock, |view| &mut view.locked)];
        for (switch, things_of) in switches {
            let mut after = view.clone();
            let things = things_of(&mut after);
            let is_on = things.has(&thing);
            if switch_ui(ui, switch, is_on, is_near, &printable(row.label)).clicked() {
                things.toggle(thing.clone());
                actions.push(DesignAction::View(ViewRequest::Set(after)));
            }
        }
        response
    })
    .inner
}

/// A click selects, with Ctrl or Shift beside what is selected; the other button shows what can be
/// done to the sensors, of which the one under the pointer is one, or to a metal object.
fn answer(
    ui: &Ui,
    response: &Response,
    what: Selected,
    outliner: &OutlinerView,
    actions: &mut Vec<DesignAction>,
) {
    if response.hovered() {
        actions.push(DesignAction::Hover(what));
    }
    let is_added = ui.input(|input| input.modifiers.command || input.modifiers.shift);
    if response.clicked() {
        actions.push(match is_added {
            true => DesignAction::SelectAlso(what),
            false => DesignAction::Select(Some(what)),
        });
    }
    if !matches!(what, Selected::Sensor(..) | Selected::Metal(_)) {
        return;
    }
    if response.secondary_clicked() && !outliner.selection.contains(what) {
        actions.push(DesignAction::Select(Some(what)));
    }
    response.context_menu(|ui| match what {
        Selected::Metal(_) => metal_menu_ui(ui, outliner.is_available, actions),
        _ => sensor_menu_ui(ui, outliner.is_available, actions),
    });
}

/// What can be done to the selected metal object.
fn metal_menu_ui(ui: &mut Ui, is_available: IsAvailable<'_>, actions: &mut Vec<DesignAction>) {
    let remove = SensorCommand::Remove.command();
    if item_ui(ui, "Remove metal object", remove, is_available(remove)).clicked() {
        actions.push(DesignAction::Run(remove.name));
    }
}
