//! Panels for sensors as functions: selecting several, menus and buttons, rows, history, and
//! numbers typed as expressions.

use super::app::{design, environment};
use super::harness::{Requests, panel};
use bevy_egui::egui;
use egui_kittest::Harness;
use egui_kittest::kittest::{NodeT, Queryable};
use trackwright_design::view::View;
use trackwright_design::{
    Arrangement, BodyRole, Design, Document, Edit, MirrorPlane, Origin, Thing,
};
use trackwright_editor::document::requests::{EditRequest, ViewRequest};
use trackwright_editor::document::selection::{Selected, Selection};
use trackwright_editor::viewport::coil_fit::ShownFindings;
use trackwright_editor::viewport::commands::ADD_SENSOR;
use trackwright_editor::viewport::sensor_commands::SensorCommand;
use trackwright_editor::widgets::basic::{NumberChange, NumberField, number_ui};
use trackwright_editor::workspaces::design::actions::DesignAction;
use trackwright_editor::workspaces::design::history_ui::history_ui;
use trackwright_editor::workspaces::design::inspector::{InspectorView, inspector_ui};
use trackwright_editor::workspaces::design::outliner::outliner_ui;
use trackwright_editor::workspaces::design::outliner_row::OutlinerView;
use trackwright_editor::workspaces::design::row_page::{RowPage, row_page_ui};
use trackwright_simulation::Coil;

/// As wide as at the side of the window.
const SIZE: [f32; 2] = [300.0, 1100.0];

/// Types into the field of a value, in millimetres or degrees, and returns what is requested.
fn type_number(
    field: NumberField<'static>,
    value: f64,
    text: &str,
) -> (Harness<'static>, Vec<NumberChange>) {
    let name = field.name;
    let (mut harness, requests) = panel(SIZE, move |ui| number_ui(ui, &field, value));
    harness.get_by_label(name).click();
    harness.run_steps(2);
    harness.get_by_label(name).type_text(text);
    harness.run_steps(1);
    harness.key_press(egui::Key::Enter);
    harness.run_steps(3);
    let requests = requests.borrow().clone();
    (harness, requests)
}

#[test]
fn a_field_takes_expressions_and_other_units() {
    for (text, expected) in [("12.5+3", 15.5), ("1 in", 25.4), ("2.001", 2.001)] {
        let (_, requests) = type_number(NumberField::length("length"), 2.0, text);
        assert_eq!(requests, [NumberChange::Set(expected)], "{text}");
    }
    let (_, requests) = type_number(NumberField::angle("angle"), 0.0, "0.2 rad");
    let [NumberChange::Set(angle_deg)] = requests[..] else {
        panic!("{requests:?}");
    };
    assert!((angle_deg - 0.2_f64.to_degrees()).abs() < 1e-12);
}

#[test]
fn a_text_that_is_no_number_shows_why() {
    let (mut harness, requests) = type_number(NumberField::length("length"), 2.0, "2 furlong");
    assert!(requests.is_empty(), "{requests:?}");
    let why = |harness: &Harness| harness.query_all_by_label_contains("furlong").count();
    assert_eq!(why(&harness), 1);
    harness.key_press(egui::Key::Escape);
    harness.run_steps(2);
    assert_eq!(why(&harness), 0);
    let field = harness.get_by_label("length");
    assert_eq!(field.value().as_deref(), Some("2.00\u{2009}mm"));
}

#[test]
fn escape_leaves_the_value_of_a_number_field() {
    let field = NumberField::length("length");
    let (mut harness, requests) = panel(SIZE, move |ui| number_ui(ui, &field, 2.0));
    harness.get_by_label("length").click();
    harness.run_steps(2);
    harness.get_by_label("length").type_text("7");
    harness.run_steps(1);
    harness.key_press(egui::Key::Escape);
    harness.run_steps(4);
    assert!(requests.borrow().is_empty(), "{:?}", requests.borrow());
    // It opens again, and a press elsewhere is the end of what is typed then.
    harness.get_by_label("length").click();
    harness.run_steps(2);
    harness.get_by_label("length").type_text("9");
    harness.run_steps(1);
    press_at(&harness, egui::pos2(150.0, 900.0));
    harness.run_steps(3);
    assert_eq!(*requests.borrow(), [NumberChange::Set(9.0)]);
}

/// The button goes down and stays down.
fn press_at(harness: &Harness, pos: egui::Pos2) {
    harness.event(egui::Event::PointerMoved(pos));
    harness.event(egui::Event::PointerButton {
        pos,
        button: egui::PointerButton::Primary,
        pressed: true,
        modifiers: egui::Modifiers::default(),
    });
}

#[test]
fn control_adds_a_row_and_opens_its_menu() {
    let (design, environment, view) = (design(), environment(), View::default());
    let selection = Selection::of(Some(Selected::Sensor(BodyRole::Tool, 0)));
    let (mut harness, requests) = panel(SIZE, |ui| {
        outliner_ui(ui, &OutlinerView::new(&design, &environment, &view, &selection))
    });
    let grip = Selected::Sensor(BodyRole::Tool, 1);
    let row = harness.get_by_label("grip");
    row.click_modifiers(egui::Modifiers::COMMAND);
    harness.run_steps(2);
    let also = DesignAction::SelectAlso(grip);
    assert!(requests.borrow().contains(&also), "{:?}", requests.borrow());
    harness.get_by_label("grip").click_secondary();
    harness.run_steps(3);
    let select = DesignAction::Select(Some(grip));
    assert!(requests.borrow().contains(&select), "{:?}", requests.borrow());
    harness.get_by_label_contains("Duplicate sensors").click();
    harness.run_steps(2);
    let duplicate = DesignAction::Run(SensorCommand::Duplicate.command().name);
    assert!(requests.borrow().contains(&duplicate), "{:?}", requests.borrow());
}

#[test]
fn the_add_row_requests_the_tool() {
    let (design, environment, view) = (design(), environment(), View::default());
    let (mut harness, requests) = panel(SIZE, |ui| {
        outliner_ui(ui, &OutlinerView::new(&design, &environment, &view, &Selection::default()))
    });
    let rows: Vec<_> = harness.get_all_by_label("Add sensor").collect();
    assert_eq!(rows.len(), 2, "one a body");
    rows[0].click();
    harness.run_steps(2);
    let tool = DesignAction::Run(ADD_SENSOR.name);
    assert!(requests.borrow().contains(&tool), "{:?}", requests.borrow());
}

#[test]
fn eye_and_lock_change_only_the_view() {
    let (design, environment, view) = (design(), environment(), View::default());
    let (mut harness, requests) = panel(SIZE, |ui| {
        outliner_ui(ui, &OutlinerView::new(&design, &environment, &view, &Selection::default()))
    });
    harness.get_by_label("Hide grip").click();
    harness.run_steps(2);
    harness.get_by_label("Lock Pointer").click();
    harness.run_steps(2);
    let (mut hidden, mut locked) = (view.clone(), view.clone());
    hidden.hidden.toggle(Thing::sensor(BodyRole::Tool, "grip"));
    locked.locked.toggle(Thing::Tool);
    let requests = requests.borrow();
    for wanted in [hidden, locked] {
        let set = DesignAction::View(ViewRequest::Set(wanted));
        assert!(requests.contains(&set), "{requests:?}");
    }
    let is_select = |action: &DesignAction| matches!(action, DesignAction::Select(_));
    assert!(!requests.iter().any(is_select), "{requests:?}");
}

#[test]
fn inspector_buttons_run_commands() {
    let design = design();
    let selection = Selection::of_sensors(BodyRole::Tool, [0, 1]);
    let remove = SensorCommand::Remove.command().name;
    let (mut harness, requests) = panel(SIZE, |ui| {
        inspector_ui(
            ui,
            &InspectorView {
                design: &design,
                selection: &selection,
                is_available: &|command| command.name != remove,
                pose: None,
                coils: ShownFindings::default(),
                derived_weight: environment().orientation_weight(None),
            },
        )
    });
    harness.get_by_label_contains("2 sensors on the tool");
    harness.get_by_label("Delete sensors").click();
    harness.run_steps(2);
    assert!(requests.borrow().is_empty(), "{:?}", requests.borrow());
    harness.get_by_label("Mirror copy at y = 0").click();
    harness.run_steps(2);
    let mirror = SensorCommand::MirrorCopy(MirrorPlane::Y).command().name;
    assert_eq!(*requests.borrow(), [DesignAction::Run(mirror)]);
}

#[test]
fn the_row_page_makes_the_requested_row() {
    let design = design();
    let selection = Selection::of_sensors(BodyRole::Tool, [0]);
    let mut page = RowPage::default();
    let (mut harness, requests) =
        panel(SIZE, |ui| Vec::from_iter(row_page_ui(ui, &mut page, &design, &selection)));
    harness.get_by_label("2 new sensors");
    harness.get_by_label("spacing in mm").click();
    harness.run_steps(2);
    harness.get_by_label("spacing in mm").type_text("1 in");
    harness.run_steps(1);
    harness.key_press(egui::Key::Enter);
    harness.run_steps(3);
    assert!(requests.borrow().is_empty(), "Enter belonged to the field");
    harness.get_by_label("Make row").click();
    harness.run_steps(2);
    let edit = Edit::Arrange {
        body: BodyRole::Tool,
        indices: vec![0],
        arrangement: Arrangement::Array {
            count: 3,
            spacing_mm: 25.4,
            direction_in_body: nalgebra::Vector3::z(),
        },
    };
    assert_eq!(*requests.borrow(), [EditRequest::Apply(edit)]);
}

#[test]
fn a_click_in_the_history_jumps_to_that_state() {
    let mut document = Document::new(design(), View::default(), Origin::BuiltIn("test"));
    for name in ["one", "two"] {
        document.apply(Edit::SetName(name.to_owned())).unwrap();
    }
    let (mut harness, requests) = panel(SIZE, |ui| history_ui(ui, &document.history()));
    assert_eq!(harness.query_all_by_label("Rename design").count(), 2);
    harness.get_by_label("Beginning").click();
    harness.run_steps(2);
    let jump = EditRequest::JumpTo(0);
    assert_eq!(*requests.borrow(), [jump]);
}

#[test]
fn the_history_shows_the_current_step() {
    let mut document = Document::new(design(), View::default(), Origin::BuiltIn("test"));
    for name in 0..20 {
        document.apply(Edit::SetName(name.to_string())).unwrap();
    }
    for undone in [0, 10] {
        for _ in 0..undone {
            document.undo().unwrap();
        }
        let (mut harness, _) = panel(SIZE, |ui| history_ui(ui, &document.history()));
        harness.run_steps(3);
        // What is scrolled away is not there at all.
        let rows = harness.get_all_by_label("Rename design");
        let seen: Vec<_> = rows.filter(|row| row.rect().max.y <= 1100.0).collect();
        assert!((7..=10).contains(&seen.len()), "{} rows", seen.len());
        assert!(
            seen.iter()
                .any(|row| row.accesskit_node().toggled() == Some(egui::accesskit::Toggled::True))
        );
    }
}

/// Both sensors of the tool in the inspector: one at 120 mm, one at 150 mm along z.
fn both_sensors(design: &Design) -> (Harness<'_>, Requests<DesignAction>) {
    panel(SIZE, move |ui| {
        let selection = Selection::of_sensors(BodyRole::Tool, [0, 1]);
        let room = environment();
        let view = InspectorView {
            design,
            selection: &selection,
            is_available: &|_| true,
            pose: None,
            derived_weight: room.orientation_weight(None),
            coils: ShownFindings::default(),
        };
        inspector_ui(ui, &view)
    })
}

fn type_into(harness: &mut Harness, name: &str, text: &str) {
    harness.get_by_label(name).click();
    harness.run_steps(2);
    harness.get_by_label(name).type_text(text);
    harness.run_steps(1);
    harness.key_press(egui::Key::Enter);
    harness.run_steps(3);
}

#[test]
fn fields_of_several_sensors_show_what_they_share() {
    let design = design();
    let (mut harness, requests) = both_sensors(&design);
    harness.run_steps(2);
    // A label may stand beside the field of the same name.
    let shown = |name: &str| harness.get_all_by_label(name).last().unwrap().value();
    assert_eq!(shown("position y in mm").as_deref(), Some("0.00\u{2009}mm"));
    assert_eq!(shown("position z in mm").as_deref(), Some("mixed"));
    assert_eq!(shown("axis y").as_deref(), Some("0.000"));
    assert_eq!(shown("axis z").as_deref(), Some("mixed"));
    assert!(requests.borrow().is_empty(), "{:?}", requests.borrow());
}

#[test]
fn a_number_is_set_for_all_selected_sensors() {
    let design = design();
    let sensors = &design.tool.body.rigid.sensors;
    for (name, text, k, value_mm) in
        [("position z in mm", "140", 2, 140.0), ("position y in mm", "3 cm", 1, 30.0)]
    {
        let (mut harness, requests) = both_sensors(&design);
        type_into(&mut harness, name, text);
        let wanted = sensors.iter().cloned().enumerate().map(|(index, mut sensor)| {
            sensor.position_in_body[k] = value_mm;
            (index, sensor)
        });
        let edit = Edit::SetSensors { body: BodyRole::Tool, sensors: wanted.collect() };
        assert_eq!(*requests.borrow(), [DesignAction::apply(edit)], "{name}");
    }
    // Escape leaves a mixed value mixed.
    let (mut harness, requests) = both_sensors(&design);
    harness.get_by_label("position z in mm").click();
    harness.run_steps(2);
    harness.key_press(egui::Key::Escape);
    harness.run_steps(3);
    assert!(requests.borrow().is_empty(), "{:?}", requests.borrow());
}

#[test]
fn coils_of_several_sensors_are_set_in_one_step() {
    let mut design = design();
    for (sensor, length_mm) in design.tool.body.rigid.sensors.iter_mut().zip([9.0, 11.0]) {
        sensor.coil = Some(Coil { diameter_mm: 0.8, length_mm });
    }
    let (mut harness, requests) = both_sensors(&design);
    harness.run_steps(2);
    assert_eq!(harness.get_by_label("coil length in mm").value().as_deref(), Some("mixed"));
    type_into(&mut harness, "coil length in mm", "10");
    let [DesignAction::Edit(EditRequest::Apply(edit))] = &requests.borrow()[..] else {
        panic!("{:?}", requests.borrow());
    };
    let mut document = Document::new(design.clone(), View::default(), Origin::BuiltIn("test"));
    document.apply(edit.clone()).unwrap();
    let coils = document.design().tool.body.rigid.sensors.iter().map(|sensor| sensor.coil);
    let coil = Coil { diameter_mm: 0.8, length_mm: 10.0 };
    assert!(coils.into_iter().all(|own| own == Some(coil)));
    assert_eq!(document.undo_label(), Some("Change 2 sensors"));
    document.undo();
    assert_eq!(*document.design(), design);
}
