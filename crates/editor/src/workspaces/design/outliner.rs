//! What is in the design: bodies with their sensors and tips, the anatomy, the room and its metal.

use crate::document::commands::OPEN_CRF;
use crate::document::selection::Selected;
use crate::palette;
use crate::palette::ThemedColor;
use crate::viewport::commands::ADD_SENSOR;
use crate::viewport::troubles::{detail, sensor_trouble_text};
use crate::widgets::basic::{Mark, Row, counted, quiet_ui, row_ui, section_ui};
use crate::widgets::tooltip::Explain;
use crate::workspaces::design::actions::DesignAction;
use crate::workspaces::design::anatomy_ui::anatomy_rows_ui;
use crate::workspaces::design::metal_ui::metal_rows_ui;
use crate::workspaces::design::outliner_row::{OutlinerView, selectable_ui};
use bevy_egui::egui::Ui;
use trackwright_design::BodyRole;
use trackwright_field::environment::Environment;
use trackwright_report::room::{model_error, unmeasured};
use trackwright_simulation::SensorOrientation;

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
