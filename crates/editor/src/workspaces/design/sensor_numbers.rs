//! Numbers of the selected sensors. Of several, a field shows what all of them have, or that it is
//! mixed; what is typed is set for all in one step.

use crate::viewport::sensor_commands::SensorCommand;
use crate::widgets::basic::{FIELD_WIDTH, MIXED, NumberField, number_ui, quiet_ui, section_ui};
use crate::widgets::tooltip::Explain;

use crate::workspaces::design::actions::{DesignAction, number_edits};
use crate::workspaces::design::chosen_sensors::ChosenSensors;
use crate::workspaces::design::rows::{AXES, row_ui, text_row_ui};
use bevy_egui::egui::{Checkbox, ComboBox, Ui};
use nalgebra::{Unit, UnitQuaternion, Vector3};
use trackwright_design::{BodyRole, Edit};
use trackwright_simulation::{Coil, Sensor, SensorOrientation};

/// The coil that a sensor gets when a person gives it one, mm: a common 5-DOF coil.
pub(crate) const NEW_COIL: Coil = Coil { diameter_mm: 0.8, length_mm: 9.0 };

/// Draws name, kind, place, axis and coil.
pub fn sensor_numbers_ui(
    ui: &mut Ui,
    role: BodyRole,
    chosen: &ChosenSensors,
    actions: &mut Vec<DesignAction>,
) {
    match chosen.single() {
        Some((index, sensor)) => {
            section_ui(ui, &format!("Sensor on the {}", role.name()));
            if let Some(name) = text_row_ui(ui, "name", &sensor.name) {
                let sensor = Sensor { name, ..sensor.clone() };
                actions.push(DesignAction::apply(Edit::SetSensor { body: role, index, sensor }));
            }
        }
        None => {
            section_ui(ui, &format!("{} sensors on the {}", chosen.count(), role.name()));
            quiet_ui(ui, "what is set here is set for all of them");
        }
    }
    kind_ui(ui, chosen, actions);
    section_ui(ui, "Place in the body");
    position_ui(ui, chosen, actions);
    orientation_ui(ui, chosen, actions);
    coil_ui(ui, chosen, actions);
}

/// A choice is made for all selected sensors.
fn kind_ui(ui: &mut Ui, chosen: &ChosenSensors, actions: &mut Vec<DesignAction>) {
    let own = chosen.common(|sensor| sensor.orientation.degrees_of_freedom());
    row_ui(ui, "measures", |ui| {
        let choice = ComboBox::from_id_salt("kind")
            .selected_text(own.map_or(MIXED, kind_name))
            .width(2.0 * FIELD_WIDTH)
            .show_ui(ui, |ui| {
                for (kind, command) in [
                    (5, SensorCommand::MakeFiveDof),
                    (6, SensorCommand::MakeSixDof),
                    (3, SensorCommand::MakeMarker),
                ] {
                    let command = command.command();
                    let choice = ui.selectable_label(own == Some(kind), kind_name(kind));
                    let choice = choice.explained(command.about);
                    if choice.clicked() && own != Some(kind) {
                        actions.push(DesignAction::Run(command.name));
                    }
                }
            });
        let _ = choice.response.explained("What the tracker measures of the sensor");
    });
}

fn kind_name(degrees_of_freedom: u8) -> &'static str {
    match degrees_of_freedom {
        3 => "position, a marker",
        5 => "5 DOF, one axis",
        _ => "6 DOF, full rotation",
    }
}

/// A row with a number that all of them have, or with a field that shows that it is mixed.
fn number_row_ui(
    ui: &mut Ui,
    name: &str,
    field: &NumberField,
    value: Option<f64>,
    label: &str,
    actions: &mut Vec<DesignAction>,
    edit: impl Fn(f64) -> Option<Edit>,
) {
    row_ui(ui, name, |ui| {
        let changes = number_ui(ui, field, value);
        number_edits(&changes, actions, label, edit);
    });
}

fn position_ui(ui: &mut Ui, chosen: &ChosenSensors, actions: &mut Vec<DesignAction>) {
    let label = format!("Move {}", chosen.name());
    for (k, axis) in AXES.into_iter().enumerate() {
        let name = format!("position {axis} in mm");
        let value = chosen.common_number(|sensor| Some(sensor.position_in_body[k]));
        number_row_ui(ui, axis, &NumberField::length(&name), value, &label, actions, |v| {
            chosen.edit(|sensor| {
                let mut position_in_body = sensor.position_in_body;
                position_in_body[k] = v;
                Some(Sensor { position_in_body, ..sensor.clone() })
            })
        });
    }
}

/// Axes where all of them have one, rotations where all have one, else nothing.
fn orientation_ui(ui: &mut Ui, chosen: &ChosenSensors, actions: &mut Vec<DesignAction>) {
    let label = format!("Move {}", chosen.name());
    match chosen.common(|sensor| sensor.orientation.degrees_of_freedom()) {
        Some(5) => axis_ui(ui, chosen, &label, actions),
        Some(6) => rotation_ui(ui, chosen, &label, actions),
        Some(_) => {}
        None => {
            quiet_ui(ui, "axes can be typed where all of them measure the same");
        }
    }
}

/// A direction by its three components; what is typed is normalised.
fn axis_ui(ui: &mut Ui, chosen: &ChosenSensors, label: &str, actions: &mut Vec<DesignAction>) {
    for (k, axis) in AXES.into_iter().enumerate() {
        let name = format!("axis {axis}");
        let value = chosen.common_number(|sensor| match &sensor.orientation {
            SensorOrientation::FiveDof(axis) => Some(axis[k]),
            _ => None,
        });
        number_row_ui(ui, &name, &NumberField::plain(&name), value, label, actions, |v| {
            chosen.edit_orientation(|orientation| match orientation {
                SensorOrientation::FiveDof(axis) => with_component(axis, k, v),
                _ => None,
            })
        });
    }
}

/// The axis with another component; `None` for three zeros, which are no direction: the field then
/// shows the axis as it was.
fn with_component(axis: &Unit<Vector3<f64>>, k: usize, value: f64) -> Option<SensorOrientation> {
    let mut direction = axis.into_inner();
    direction[k] = value;
    Unit::try_new(direction, 1e-9).map(SensorOrientation::FiveDof)
}

/// Turns about x, then y, then z, shown in degrees.
fn rotation_ui(ui: &mut Ui, chosen: &ChosenSensors, label: &str, actions: &mut Vec<DesignAction>) {
    let angles = |rotation: &UnitQuaternion<f64>| {
        let (rx, ry, rz) = rotation.euler_angles();
        [rx, ry, rz]
    };
    for (k, axis) in ["rx", "ry", "rz"].into_iter().enumerate() {
        let name = format!("rotation {axis} in degrees");
        let value = chosen.common_number(|sensor| match &sensor.orientation {
            SensorOrientation::SixDof(rotation) => Some(angles(rotation)[k].to_degrees()),
            _ => None,
        });
        number_row_ui(ui, axis, &NumberField::angle(&name), value, label, actions, |v| {
            chosen.edit_orientation(|orientation| match orientation {
                SensorOrientation::SixDof(rotation) => {
                    let mut turned = angles(rotation);
                    turned[k] = v.to_radians();
                    let [rx, ry, rz] = turned;
                    let rotation = UnitQuaternion::from_euler_angles(rx, ry, rz);
                    Some(SensorOrientation::SixDof(rotation))
                }
                _ => None,
            })
        });
    }
}

fn coil_ui(ui: &mut Ui, chosen: &ChosenSensors, actions: &mut Vec<DesignAction>) {
    // A marker has none.
    let is_coil = chosen.common(|sensor| sensor.orientation != SensorOrientation::Marker);
    if is_coil != Some(true) {
        return;
    }
    section_ui(ui, "Coil");
    let known = chosen.common(|sensor| sensor.coil.is_some());
    let mut is_known = known == Some(true);
    let switch = Checkbox::new(&mut is_known, "size is known").indeterminate(known.is_none());
    let about = "A coil of known size is drawn at its true size, and checked against the body";
    if ui.add(switch).explained(about).changed() {
        let edit = chosen.edit(|sensor| {
            let coil = is_known.then(|| sensor.coil.unwrap_or(NEW_COIL));
            Some(Sensor { coil, ..sensor.clone() })
        });
        actions.extend(edit.map(DesignAction::apply));
    }
    if known == Some(false) {
        return;
    }
    let label = format!("Change {}", chosen.name());
    type Size = ([&'static str; 2], fn(&Coil) -> f64, fn(&mut Coil) -> &mut f64);
    let sizes: [Size; 2] = [
        (
            ["diameter", "Outer diameter of the coil, across its axis"],
            |coil| coil.diameter_mm,
            |coil| &mut coil.diameter_mm,
        ),
        (
            ["length", "Length of the coil, along its axis"],
            |coil| coil.length_mm,
            |coil| &mut coil.length_mm,
        ),
    ];
    for ([name, about], read, write) in sizes {
        let long_name = format!("coil {name} in mm");
        let field =
            NumberField { min: 0.01, speed: 0.01, ..NumberField::length(&long_name).about(about) };
        let value = chosen.common_number(|sensor| sensor.coil.as_ref().map(read));
        number_row_ui(ui, name, &field, value, &label, actions, |v| {
            chosen.edit(|sensor| {
                let mut coil = sensor.coil.unwrap_or(NEW_COIL);
                *write(&mut coil) = v;
                Some(Sensor { coil: Some(coil), ..sensor.clone() })
            })
        });
    }
}
