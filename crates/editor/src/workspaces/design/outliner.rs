//! What is in the design: bodies with their sensors and tips, the anatomy, the room and its metal.

use crate::document::commands::OPEN_CRF;
use crate::document::requests::ViewRequest;
use crate::document::selection::{Selected, Selection};
use crate::palette;
use crate::palette::ThemedColor;
use crate::viewport::coil_fit::ShownFindings;
use crate::viewport::commands::ADD_SENSOR;
use crate::viewport::troubles::{detail, sensor_trouble_text};
use crate::widgets::basic::{Mark, Row, counted, quiet_ui, row_ui, section_ui};
use crate::widgets::switch::{SWITCH_WIDTH, Switch, switch_ui};
use crate::widgets::theme;
use crate::widgets::tooltip::Explain;
use crate::workspaces::design::actions::DesignAction;
use crate::workspaces::design::anatomy_ui::anatomy_rows_ui;
use crate::workspaces::design::metal_ui::{metal_menu_ui, metal_rows_ui};
use crate::workspaces::design::sensor_ui::{IsAvailable, sensor_menu_ui};
use bevy_egui::egui::{Rect, Response, Ui, vec2};
use trackwright_design::view::View;
use trackwright_design::{BodyRole, Design, Thing, Things};
use trackwright_field::environment::Environment;
use trackwright_formats::printable::printable;
use trackwright_metal::furnished::FurnishError;
use trackwright_report::room::{model_error, unmeasured};
use trackwright_simulation::PoseDetail;
use trackwright_simulation::SensorOrientation;

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

/// Draws bodies and room.
pub fn outliner_ui(ui: &mut Ui, outliner: &OutlinerView) -> Vec<DesignAction> {
    let mut actions = Vec::new();
    ui.spacing_mut().item_spacing.y = 0.0;
    section_ui(ui, "Design");
    let design = Row {
        label: &outliner.design.name,
        is_selected: outliner.selection.primary().is_none(),
        ..Row::default()
    };
    if row_ui(ui, &design).clicked() {
        actions.push(DesignAction::Select(None));
    }
    section_ui(ui, "Tool");
    body_ui(ui, outliner, BodyRole::Tool, &mut actions);
    section_ui(ui, "Coordinate reference frame");
    match outliner.design.crf.is_some() {
        true => body_ui(ui, outliner, BodyRole::Crf, &mut actions),
        false => {
            let add = Row {
                label: "Add from a file…",
                indent: 1,
                mark: Some((Mark::Plus, palette::TEXT_QUIET.color32())),
                ..Row::default()
            };
            if row_ui(ui, &add).on_hover_text(OPEN_CRF.about).clicked() {
                actions.push(DesignAction::Run(OPEN_CRF.name));
            }
        }
    }
    anatomy_rows_ui(ui, outliner, &mut actions);
    section_ui(ui, "Room");
    room_ui(ui, outliner.environment);
    metal_rows_ui(ui, outliner, &mut actions);
    actions
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

fn body_ui(ui: &mut Ui, outliner: &OutlinerView, role: BodyRole, actions: &mut Vec<DesignAction>) {
    let Some(body) = outliner.design.body(role) else {
        return;
    };
    let color = match role {
        BodyRole::Tool => palette::TOOL,
        BodyRole::Crf => palette::CRF,
    };
    let head = Row {
        label: &body.rigid.name,
        mark: Some((Mark::Square, color.color32())),
        ..Row::default()
    };
    selectable_ui(ui, outliner, Selected::Body(role), head, actions);
    for (index, sensor) in body.rigid.sensors.iter().enumerate() {
        let sensor_mark = match &sensor.orientation {
            SensorOrientation::Marker => Mark::Ball,
            SensorOrientation::FiveDof(_) => Mark::Dot,
            SensorOrientation::SixDof(_) => Mark::Ring,
        };
        let trouble = sensor_trouble_text(detail(outliner.pose, role), outliner.coils, role, index);
        let row = Row {
            label: &sensor.name,
            note: trouble.as_deref().unwrap_or(sensor.orientation.kind_name()),
            note_color: trouble.as_ref().map(|_| palette::MISSED.color32()),
            indent: 1,
            mark: Some((sensor_mark, palette::SENSOR.color32())),
            ..Row::default()
        };
        selectable_ui(ui, outliner, Selected::Sensor(role, index), row, actions);
    }
    if body.rigid.tip_in_body.is_some() {
        let row = Row {
            label: "tip",
            indent: 1,
            mark: Some((Mark::Diamond, palette::ERROR_VECTOR.color32())),
            ..Row::default()
        };
        selectable_ui(ui, outliner, Selected::Tip(role), row, actions);
    }
    if let (BodyRole::Crf, Some(crf)) = (role, &outliner.design.crf) {
        for target in &crf.targets {
            let row = Row {
                label: &target.name,
                note: "target",
                indent: 1,
                mark: Some((Mark::OpenDiamond, palette::TEXT_QUIET.color32())),
                ..Row::default()
            };
            row_ui(ui, &row);
        }
    }
    let add = Row {
        label: "Add sensor",
        indent: 1,
        mark: Some((Mark::Plus, palette::TEXT_QUIET.color32())),
        ..Row::default()
    };
    if row_ui(ui, &add).explained(ADD_SENSOR.about).clicked() {
        actions.push(DesignAction::Run(ADD_SENSOR.name));
    }
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

fn room_ui(ui: &mut Ui, environment: &Environment) {
    let row = Row { label: &environment.name, ..Row::default() };
    row_ui(ui, &row);
    ui.indent("room", |ui| {
        if let Some(volume) = &environment.volume {
            quiet_ui(ui, volume.name());
        }
        match &environment.provenance {
            None => {
                quiet_ui(ui, format!("{}, never measured", unmeasured(environment)));
            }
            Some(from) => {
                quiet_ui(ui, counted(from.samples, "sample", "samples"));
                if let Some(holdout) = &from.holdout {
                    quiet_ui(ui, model_error(Some(holdout.after.position_rms_mm)));
                }
            }
        }
    });
}
