//! The panels as functions: what they show, and what they request when they are used.

use super::app::{design, environment, layers, studied, world};
use super::harness::{Requests, use_dialog};
use crate::support::studies::default_design;
use bevy_egui::egui;
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;
use nalgebra::{Point3, Unit, Vector3};
use std::time::Duration;
use trackwright_design::view::View;
use trackwright_design::{BodyRole, Design, Edit};
use trackwright_editor::document::commands::{REDO, UNDO};
use trackwright_editor::document::dialog::DesignDialog;
use trackwright_editor::document::requests::{EditRequest, FileRequest, OpenWorld, ViewRequest};
use trackwright_editor::document::selection::{Selected, Selection};
use trackwright_editor::layers::layers_ui::{LayerFigures, LayersView, Listed, layers_ui};
use trackwright_editor::layers::slice;
use trackwright_editor::runner::results::{Results, Stamped};
use trackwright_editor::runner::solved::Extent;
use trackwright_editor::shell::commands::Situation;
use trackwright_editor::shell::dialogs::DialogAnswer;
use trackwright_editor::shell::top_bar::{TopBarAction, TopBarView, top_bar_ui};
use trackwright_editor::shell::window::{PanelsShown, Workspace};
use trackwright_editor::viewport::coil_fit::ShownFindings;
use trackwright_editor::viewport::troubles::sensor_trouble_text;
use trackwright_editor::widgets::basic::signed;
use trackwright_editor::workspaces;
use trackwright_editor::workspaces::design::actions::DesignAction;
use trackwright_editor::workspaces::design::baseline::Change;
use trackwright_editor::workspaces::design::inspector::{InspectorView, inspector_ui};
use trackwright_editor::workspaces::design::outliner::outliner_ui;
use trackwright_editor::workspaces::design::outliner_row::OutlinerView;
use trackwright_editor::workspaces::design::result::{ResultView, result_ui};
use trackwright_field::environment::{Jitter, OrientationWeight, OrientationWeightSource};
use trackwright_geometry::pose::Pose;
use trackwright_simulation::{
    CoilFinding, CoilMisfit, Metric, Mode, Motion, Pivot, Requirement, SensorOrientation,
    figure_rows, simulate_pose,
};

/// A panel at the side of the window, and what it requests.
fn harness<'a, T: 'a>(
    panel: impl FnMut(&mut egui::Ui) -> Vec<T> + 'a,
) -> (Harness<'a>, Requests<T>) {
    super::harness::panel([300.0, 1100.0], panel)
}

fn inspector<'a>(
    design: &'a Design,
    selected: Option<Selected>,
) -> (Harness<'a>, Requests<DesignAction>) {
    let selection = Selection::of(selected);
    harness(move |ui| {
        inspector_ui(
            ui,
            &InspectorView {
                design,
                selection: &selection,
                is_available: &|_| true,
                pose: None,
                coils: ShownFindings::default(),
                derived_weight: environment().orientation_weight(None),
            },
        )
    })
}

#[test]
fn hidden_characters_are_escaped() {
    let hidden = |text: &str| format!("{text}\u{202e}\n{text}");
    let (mut design, mut environment, view) = (design(), environment(), View::default());
    design.name = hidden("design");
    design.tool.body.rigid.name = hidden("tool");
    design.tool.body.rigid.sensors[0].name = hidden("sensor");
    environment.name = hidden("room");
    let (harness, _) = harness(|ui| {
        outliner_ui(ui, &OutlinerView::new(&design, &environment, &view, &Selection::default()))
    });
    for name in ["design", "tool", "sensor", "room"] {
        let shown = format!(r"{name}\u{{202e}}\u{{a}}{name}");
        assert_eq!(harness.query_all_by_label(&shown).count(), 1, "{name}");
    }
    for raw in ["\u{202e}", "\n"] {
        assert_eq!(harness.query_all_by_label_contains(raw).count(), 0);
    }
}

#[test]
fn an_outliner_row_selects_its_sensor() {
    let layers = layers();
    let (design, environment, view) = (design(), environment(), View::default());
    let (mut harness, requests) = harness(|ui| {
        let selection = Selection::default();
        let outliner = OutlinerView::new(&design, &environment, &view, &selection);
        let mut actions = outliner_ui(ui, &outliner);
        let figures = LayerFigures { layers: &layers, ..LayerFigures::default() };
        let panel =
            LayersView { view: &view, environment: &environment, figures, listed: Listed::All };
        let set = layers_ui(ui, &panel).map(|view| DesignAction::View(ViewRequest::Set(view)));
        actions.extend(set);
        actions
    });
    harness.get_by_label("Aurora cube");
    harness.get_by_label("grip").click();
    harness.run_steps(2);
    let select = DesignAction::Select(Some(Selected::Sensor(BodyRole::Tool, 1)));
    assert!(requests.borrow().contains(&select), "{:?}", requests.borrow());
    harness.get_by_label("Ghost").click();
    harness.run_steps(2);
    let mut wanted = View::default();
    wanted.layers.ghost = false;
    let set = DesignAction::View(ViewRequest::Set(wanted));
    assert!(requests.borrow().contains(&set));
}

#[test]
fn a_typed_position_is_one_edit_in_millimetres() {
    let design = design();
    let selected = Some(Selected::Sensor(BodyRole::Tool, 0));
    let (mut harness, requests) = inspector(&design, selected);
    let field = harness.get_by_label("position z in mm");
    assert_eq!(field.value().as_deref(), Some("120.00\u{2009}mm"));
    field.click();
    harness.run_steps(2);
    let field = harness.get_by_label("position z in mm");
    field.type_text("\u{2212}7,25 mm");
    harness.run_steps(1);
    harness.key_press(egui::Key::Enter);
    harness.run_steps(3);
    let mut sensor = design.tool.body.rigid.sensors[0].clone();
    sensor.position_in_body.z = -7.25;
    let edit = DesignAction::apply(Edit::SetSensor { body: BodyRole::Tool, index: 0, sensor });
    assert_eq!(*requests.borrow(), [edit]);
}

#[test]
fn a_field_that_is_only_visited_changes_nothing() {
    let mut design = design();
    design.tool.body.rigid.sensors[0].position_in_body.z = 120.123_456_789;
    let selected = Some(Selected::Sensor(BodyRole::Tool, 0));
    let (mut harness, requests) = inspector(&design, selected);
    harness.get_by_label("position z in mm").click();
    harness.run_steps(2);
    harness.key_press(egui::Key::Enter);
    harness.run_steps(3);
    assert!(requests.borrow().is_empty(), "{:?}", requests.borrow());
}

#[test]
fn angles_are_typed_in_degrees() {
    let design = design();
    let (mut harness, requests) = inspector(&design, Some(Selected::Body(BodyRole::Tool)));
    harness.get_by_label("rotation rz in degrees").click();
    harness.run_steps(2);
    harness.get_by_label("rotation rz in degrees").type_text("90");
    harness.run_steps(1);
    harness.key_press(egui::Key::Enter);
    harness.run_steps(3);
    let requests = requests.borrow();
    let [DesignAction::Edit(EditRequest::Apply(Edit::SetToolPose(pose)))] = requests.as_slice()
    else {
        panic!("{requests:?}");
    };
    assert!((pose.rotation.angle() - std::f64::consts::FRAC_PI_2).abs() < 1e-12);
    assert_eq!(pose.translation.z, 30.0);
}

#[test]
fn the_range_of_motion_shows_its_number_of_poses() {
    let design = design();
    let (harness, _) = inspector(&design, None);
    harness.get_by_label("15 poses");
}

#[test]
fn the_pivot_is_chosen_and_typed() {
    let design = design();
    for (choice, pivot) in [
        ("the tool's tip", Pivot::Tip),
        ("a point of the tool", Pivot::on_shaft(&design.tool.body.rigid)),
        ("a point of the CRF", Pivot::Reference([0.0; 3])),
    ] {
        let (mut harness, requests) = inspector(&design, None);
        let role = egui::accesskit::Role::ComboBox;
        harness.get_by_role_and_label(role, "turns about").click();
        harness.run_steps(3);
        harness.get_by_label(choice).click();
        harness.run_steps(3);
        let motion = Motion { pivot, ..design.motion.unwrap() };
        let set = DesignAction::apply(Edit::SetMotion(Some(motion)));
        assert_eq!(requests.borrow().as_slice(), [set]);
    }
    // One that is new turns about the tip, and a point has three fields.
    let still = Design { motion: None, ..design.clone() };
    let (mut harness, requests) = inspector(&still, None);
    harness.get_by_label("rx").click();
    harness.run_steps(3);
    let [DesignAction::Edit(EditRequest::Apply(Edit::SetMotion(Some(new))))] =
        requests.borrow()[..]
    else {
        panic!("{:?}", requests.borrow())
    };
    assert_eq!(new.pivot, Pivot::Tip);
    let motion = Motion { pivot: Pivot::Body([1.0, 2.0, 3.0]), ..new };
    let about = Design { motion: Some(motion), ..design.clone() };
    let (harness, _) = inspector(&about, None);
    for axis in ["x", "y", "z"] {
        harness.get_by_label(&format!("pivot {axis} in mm"));
    }
}

pub fn of_results(results: &Results) -> ResultView<'_> {
    ResultView { results, change: None, reasons: Vec::new(), is_computing: false, is_short: false }
}

/// Of the first revision, at once.
fn stamped<T>(value: T) -> Option<Stamped<T>> {
    Some(Stamped { revision: 0, value, took: Duration::from_millis(4) })
}

#[test]
fn the_result_shows_the_commands_digits() {
    let world = world();
    let mut scenario = trackwright_project::resolve(world.document.design(), &world.environment);
    scenario.requirement = Some(Requirement::at_most([(Metric::TIP_RMS, 1e-3)]));
    let study = studied(&scenario, &Mode::Motion);
    let rows = figure_rows(&study.room_field);
    let figures = study.figures.clone();
    let by_mm = figures.get(Metric::TIP_RMS).unwrap().value - 9.0;
    let change = signed(by_mm, 2);
    let results = Results { study: stamped(study), ..Results::default() };
    let (mut harness, _) = harness(|ui| {
        let reasons = vec!["Sensor shaft of the tool carries all".to_owned()];
        let change = Some(Change::By(by_mm));
        result_ui(ui, &ResultView { change, reasons, ..of_results(&results) });
        Vec::<()>::new()
    });
    let unit = |unit| if unit == "mm" { "\u{2009}mm" } else { "°" };
    for figure in figures.bounded() {
        let text = format!("{}{}", figure.value_text(2), unit(figure.metric.unit()));
        assert!(harness.query_all_by_label(&text).count() >= 1, "{text}");
    }
    harness.get_by_label_contains("No interval: ");
    assert_eq!(harness.query_all_by_label_contains("✖ missed: ").count(), 1);
    // The paper's simulation, which is folded.
    assert_eq!(harness.query_all_by_label("angle error mean").count(), 0);
    harness.get_by_label("Room's model alone").click();
    harness.run_steps(20);
    for label in ["tip error RMS", "tip error max", "angle error mean"] {
        let row = rows.iter().find(|row| row.label == label).unwrap();
        let text = format!("{}{}", row.value_text(), unit(row.unit));
        assert!(harness.query_all_by_label(&text).count() >= 1, "{text}");
    }
    harness.get_by_label("Sensor shaft of the tool carries all");
    harness.get_by_label(&format!("{change}\u{2009}mm"));
    harness.get_by_label("15 trials");
}

#[test]
fn what_is_met_needs_no_reasons() {
    let world = world();
    let mut scenario = trackwright_project::resolve(world.document.design(), &world.environment);
    scenario.requirement = Some(Requirement::at_most([(Metric::TIP_RMS, 1e3)]));
    let study = stamped(studied(&scenario, &Mode::Motion));
    let results = Results { study, ..Results::default() };
    let (harness, _) = harness(|ui| {
        let reasons = vec!["Sensor shaft of the tool carries all".to_owned()];
        result_ui(ui, &ResultView { reasons, ..of_results(&results) });
        Vec::<()>::new()
    });
    for (text, times) in [("✔ met", 1), ("Sensor shaft", 0)] {
        assert_eq!(harness.query_all_by_label_contains(text).count(), times, "{text}");
    }
}

/// How often texts are in the result of a design whose requirement is a bound on an RMS that no study
/// keeps.
fn result_texts(change: Option<Change>, mode: &Mode, texts: &[&str]) -> Vec<usize> {
    let world = world();
    let mut scenario = trackwright_project::resolve(world.document.design(), &world.environment);
    scenario.requirement = Some(Requirement::at_most([(Metric::TIP_RMS, 1e-3)]));
    let results = Results { study: stamped(studied(&scenario, mode)), ..Results::default() };
    let (harness, _) = harness(|ui| {
        result_ui(ui, &ResultView { change, ..of_results(&results) });
        Vec::<()>::new()
    });
    texts.iter().map(|text| harness.query_all_by_label_contains(text).count()).collect()
}

#[test]
fn a_change_of_nothing_shows_nothing() {
    assert_eq!(result_texts(Some(Change::By(0.001)), &Mode::Motion, &["±", "+", "−"]), [0, 0, 0]);
    assert_eq!(result_texts(Some(Change::By(-0.21)), &Mode::Motion, &["−0.21\u{2009}mm"]), [1]);
}

#[test]
fn a_change_of_the_room_has_no_sign() {
    let texts = ["another room", "+", "−"];
    assert_eq!(result_texts(Some(Change::OtherRoom), &Mode::Motion, &texts), [1, 0, 0]);
    let texts = ["another range of motion", "+", "−"];
    assert_eq!(result_texts(Some(Change::OtherMotion), &Mode::Motion, &texts), [1, 0, 0]);
}

#[test]
fn one_pose_of_many_has_no_verdict_on_an_rms() {
    let texts = ["✖ missed: ", "one pose is not judged"];
    assert_eq!(result_texts(None, &Mode::Motion, &texts), [1, 0]);
    assert_eq!(result_texts(None, &Mode::Single, &texts), [0, 1]);
}

#[test]
fn an_interval_around_the_bound_is_undecided() {
    let mut scenario = default_design();
    let figure = *studied(&scenario, &Mode::Motion).figures.get(Metric::TIP_RMS).unwrap();
    scenario.requirement = Some(Requirement::at_most([(Metric::TIP_RMS, figure.value)]));
    let study = studied(&scenario, &Mode::Motion);
    let interval = format!("95\u{2009}%: {}\u{2009}mm", figure.interval_text(2).unwrap());
    // A drag shows the same figure, interval and verdict.
    for extent in [Extent::Whole, Extent::PreviewOf(50_625)] {
        let results =
            Results { study: stamped(study.clone()), extent: Some(extent), ..Results::default() };
        let (harness, _) = harness(|ui| {
            result_ui(ui, &of_results(&results));
            Vec::<()>::new()
        });
        // The figure is shown once: large.
        for text in ["tip error RMS", &interval] {
            assert_eq!(harness.query_all_by_label(text).count(), 1, "{text}");
        }
        let verdict = "? cannot tell: the interval holds the limit: at most";
        assert_eq!(harness.query_all_by_label_contains(verdict).count(), 1);
        for text in ["✔", "✖", "expected"] {
            assert_eq!(harness.query_all_by_label_contains(text).count(), 0, "{text}");
        }
    }
}

#[test]
fn a_design_out_of_the_room_has_no_figures() {
    let mut design = design();
    design.tool.crf_from_tool.translation.x = 4000.0;
    let scenario = trackwright_project::resolve(&design, &std::sync::Arc::new(environment()));
    let study = studied(&scenario, &Mode::Motion);
    assert!(study.figures.all.is_empty());
    let results = Results { study: stamped(study), ..Results::default() };
    let (harness, _) = harness(|ui| {
        result_ui(ui, &of_results(&results));
        Vec::<()>::new()
    });
    for text in ["no figures", "? cannot tell"] {
        assert_eq!(harness.query_all_by_label(text).count(), 1, "{text}");
    }
    harness.get_by_label_contains("No figures: in 15 of 15 trials a sensor is outside");
}

#[test]
fn a_preview_shows_its_share_of_all_trials() {
    let world = world();
    let scenario = trackwright_project::resolve(world.document.design(), &world.environment);
    let results = |extent| Results {
        study: stamped(studied(&scenario, &Mode::Motion)),
        extent: Some(extent),
        ..Results::default()
    };
    let (preview, whole) = (results(Extent::PreviewOf(50_625)), results(Extent::Whole));
    let panel = |results: &Results| {
        let (harness, _) = harness(|ui| {
            result_ui(ui, &of_results(results));
            Vec::<()>::new()
        });
        let warning = harness.query_all_by_label_contains("15 trials of 50,625");
        warning.count()
    };
    assert_eq!((panel(&preview), panel(&whole)), (1, 0));
}

#[test]
fn a_derived_weight_is_shown_as_derived() {
    let jitter = Jitter::uniform(0.5, 0.005);
    let mut design = design();
    let weight = OrientationWeight { value_mm: 100.0, source: OrientationWeightSource::Jitter };
    assert_eq!(jitter.orientation_weight_mm(), Some(weight.value_mm));
    for (own_mm, is_derived) in [(None, 1), (Some(80.0), 0)] {
        design.orientation_weight_mm = own_mm;
        let (harness, _) = harness(|ui| {
            inspector_ui(
                ui,
                &InspectorView {
                    design: &design,
                    selection: &Selection::default(),
                    is_available: &|_| true,
                    pose: None,
                    coils: ShownFindings::default(),
                    derived_weight: weight,
                },
            )
        });
        let source = harness.query_all_by_label_contains("derived from the room's jitter");
        assert_eq!(source.count(), is_derived, "{own_mm:?}");
    }
}

#[test]
fn sensors_out_of_the_volume_are_named_in_words() {
    let mut design = design();
    design.tool.crf_from_tool.translation.x = 600.0;
    let environment = std::sync::Arc::new(environment());
    let scenario = trackwright_project::resolve(&design, &environment);
    let pose = simulate_pose(&scenario);
    let view = View::default();
    let (harness, _) = harness(|ui| {
        outliner_ui(
            ui,
            &OutlinerView {
                pose: Some(&pose),
                ..OutlinerView::new(&design, &environment, &view, &Selection::default())
            },
        );
        inspector_ui(
            ui,
            &InspectorView {
                design: &design,
                selection: &Selection::of(Some(Selected::Sensor(BodyRole::Tool, 0))),
                is_available: &|_| true,
                pose: Some(&pose),
                coils: ShownFindings::default(),
                derived_weight: environment.orientation_weight(None),
            },
        )
    });
    assert_eq!(harness.query_all_by_label_contains("outside the volume").count(), 1);
}

#[test]
fn the_menu_names_what_undo_takes_back() {
    let mut world = world();
    let edit = Edit::SetToolPose(Pose::translation(9.0, 0.0, 30.0));
    world.document.begin("Move sensor shaft");
    world.document.apply(edit).unwrap();
    world.document.commit();
    let world = OpenWorld(world);
    let (mut harness, requests) = harness(|ui| {
        let bar = TopBarView {
            file: "pointer.design.ron",
            is_dirty: true,
            builtins: &["endoscope"],
            recent: &[],
            workspaces: &[workspaces::design::WORKSPACE],
            commands: &[UNDO, REDO],
            situation: Situation {
                world: Some(&world),
                selection: &Selection::default(),
                is_dragging: false,
                workspace: workspaces::design::WORKSPACE,
                panels: PanelsShown::default(),
            },
        };
        top_bar_ui(ui, &bar)
    });
    harness.get_by_label("Edit").click();
    harness.run_steps(3);
    harness.get_by_label_contains("Undo move sensor shaft").click();
    harness.run_steps(3);
    assert_eq!(*requests.borrow(), [TopBarAction::Run(UNDO.name)]);
}

/// Where tabs, a menu and the file's name begin in a bar.
fn places_in_the_bar(file: &str, is_dirty: bool, shown: Workspace) -> Vec<egui::Rect> {
    let world = OpenWorld(world());
    let harness = Harness::builder().with_size(egui::vec2(900.0, 40.0)).build_ui(|ui| {
        trackwright_editor::widgets::theme::apply(ui.ctx());
        let bar = TopBarView {
            file,
            is_dirty,
            builtins: &[],
            recent: &[],
            workspaces: &[workspaces::design::WORKSPACE, workspaces::study::WORKSPACE],
            commands: &[UNDO, REDO],
            situation: Situation {
                world: Some(&world),
                selection: &Selection::default(),
                is_dragging: false,
                workspace: shown,
                panels: PanelsShown::default(),
            },
        };
        top_bar_ui(ui, &bar);
    });
    let mut places: Vec<egui::Rect> =
        ["Design", "Study", "Edit"].map(|label| harness.get_by_label(label).rect()).into();
    let name = harness.get_by_label_contains(&file[..3]).rect();
    places.push(egui::Rect::from_min_size(name.min, egui::Vec2::ZERO));
    places
}

#[test]
fn no_text_of_the_top_bar_moves_another() {
    let [design, study] = [workspaces::design::WORKSPACE, workspaces::study::WORKSPACE];
    let short = places_in_the_bar("needle.design.ron", false, design);
    assert_eq!(short, places_in_the_bar("needle.design.ron", true, design));
    assert_eq!(short, places_in_the_bar("needle.design.ron", false, study));
    let name = format!("needle{}.design.ron", "-with-a-very-long-name".repeat(12));
    assert_eq!(short, places_in_the_bar(&name, true, design));
    let [design, study, ..] = short[..] else { panic!("{short:?}") };
    assert!(design.right() <= study.left() && study.right() <= 900.0, "{short:?}");
}

#[test]
fn a_new_axis_centres_the_slice() {
    let view = View::default();
    let (room, layers) = (environment(), [slice::LAYER]);
    let (mut harness, requests) = harness(|ui| {
        let figures = LayerFigures { layers: &layers, ..LayerFigures::default() };
        let panel =
            LayersView { view: &view, environment: &room, figures, listed: Listed::OfTheRoom };
        let view = layers_ui(ui, &panel);
        view.map(|view| DesignAction::View(ViewRequest::Set(view))).into_iter().collect()
    });
    harness.run_steps(2);
    assert!(requests.borrow().is_empty(), "nothing was touched");
    harness.get_all_by_label("x").next().unwrap().click();
    harness.run_steps(2);
    let requests = requests.borrow();
    let [DesignAction::View(ViewRequest::Set(view))] = requests.as_slice() else {
        panic!("{requests:?}");
    };
    assert_eq!(view.slice.position_mm, 0.0);
}

#[test]
fn enter_opens_a_typed_path() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("mine.design.ron");
    std::fs::write(&file, "").unwrap();
    let answered = use_dialog(DesignDialog::open(folder.path().into()), |harness| {
        harness.key_combination_modifiers(egui::Modifiers::COMMAND, &[egui::Key::A]);
        harness.run_steps(1);
        let text = file.display().to_string();
        harness.get_by_label("path").type_text(&text);
        harness.run_steps(2);
        harness.key_press(egui::Key::Enter);
    });
    let open = DialogAnswer::Request(FileRequest::Open(file));
    assert_eq!(answered, Some(open));
}

#[test]
fn a_design_in_the_list_is_opened_by_a_click() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("mine.design.ron");
    std::fs::write(&file, "").unwrap();
    let answered = use_dialog(DesignDialog::open(folder.path().into()), |harness| {
        harness.get_by_label("mine.design.ron").click();
    });
    let open = DialogAnswer::Request(FileRequest::Open(file));
    assert_eq!(answered, Some(open));
}

#[test]
fn saving_over_a_file_needs_confirmation() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("mine.design.ron");
    std::fs::write(&file, "").unwrap();
    let dialog = DesignDialog::save_as(folder.path().into(), "mine.design.ron");
    let answered = use_dialog(dialog, |harness| harness.get_by_label("Save").click());
    let overwrite = DialogAnswer::Become(DesignDialog::Overwrite {
        then: FileRequest::SaveAs(file.clone()),
        path: file,
    });
    assert_eq!(answered, Some(overwrite));
}

#[test]
fn unsaved_changes_can_be_saved_given_up_or_kept() {
    let dialog = || DesignDialog::unsaved("mine.design.ron".into(), FileRequest::Quit);
    let then = || Box::new(FileRequest::Quit);
    for (button, answered) in [
        ("Save", DialogAnswer::Request(FileRequest::SaveThen(then()))),
        ("Don't save", DialogAnswer::Request(FileRequest::Discard(then()))),
        ("Cancel", DialogAnswer::Close),
    ] {
        let found = use_dialog(dialog(), |harness| harness.get_by_label(button).click());
        assert_eq!(found, Some(answered));
    }
}

#[test]
fn a_barely_determined_rotation_is_stated() {
    let mut design = design();
    let nearly = Unit::new_normalize(Vector3::new(0.05, 0.0, 1.0));
    let grip = &mut design.tool.body.rigid.sensors[1];
    (grip.position_in_body, grip.orientation) =
        (Point3::new(0.0, 0.0, 150.0), SensorOrientation::FiveDof(nearly));
    let environment = std::sync::Arc::new(environment());
    let pose = simulate_pose(&trackwright_project::resolve(&design, &environment));
    let (harness, _) = harness(|ui| {
        inspector_ui(
            ui,
            &InspectorView {
                design: &design,
                selection: &Selection::of(Some(Selected::Body(BodyRole::Tool))),
                is_available: &|_| true,
                pose: Some(&pose),
                coils: ShownFindings::default(),
                derived_weight: environment.orientation_weight(None),
            },
        )
    });
    let statement = harness.query_all_by_label_contains("is barely determined: 1° of tilt");
    assert_eq!(statement.count(), 1);
}

#[test]
fn a_coil_that_does_not_fit_is_named_in_words() {
    let (design, environment, view) = (design(), environment(), View::default());
    let finding = |index, misfit| CoilFinding {
        body: "tool",
        index,
        sensor: design.tool.body.rigid.sensors[index].name.clone(),
        misfit,
    };
    let found = [
        finding(0, CoilMisfit::SticksOut { by_mm: 3.52 }),
        finding(1, CoilMisfit::Overlaps { index: 0, other: "shaft".to_owned(), by_mm: 0.8 }),
    ];
    let coils = ShownFindings::of_body(BodyRole::Tool, &found);
    let (harness, _) = harness(|ui| {
        outliner_ui(
            ui,
            &OutlinerView {
                coils,
                ..OutlinerView::new(&design, &environment, &view, &Selection::default())
            },
        );
        inspector_ui(
            ui,
            &InspectorView {
                design: &design,
                selection: &Selection::of(Some(Selected::Sensor(BodyRole::Tool, 0))),
                is_available: &|_| true,
                pose: None,
                coils,
                derived_weight: environment.orientation_weight(None),
            },
        )
    });
    let statement =
        "The coil of the tool's sensor shaft does not fit: it sticks out of the body by 3.5 mm";
    assert_eq!(harness.query_all_by_label_contains(statement).count(), 1);
    // In the outliner and the scene.
    for (index, words) in ["sticks out by 3.5 mm", "overlaps by 0.8 mm"].into_iter().enumerate() {
        let trouble = sensor_trouble_text(None, coils, BodyRole::Tool, index);
        assert_eq!(trouble.as_deref(), Some(words));
    }
}
