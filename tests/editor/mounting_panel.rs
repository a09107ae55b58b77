//! The section of mounting regions as a function: what each of its widgets requests.

use super::app::design;
use super::harness::{assert_nothing_overlaps, panel, use_panel};
use bevy_egui::egui;
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;
use nalgebra::Point3;
use trackwright_design::{Anatomy, AnatomyEdit, BodyRole, Edit};
use trackwright_editor::document::requests::EditRequest;
use trackwright_editor::viewport::mounting::state::MountingState;
use trackwright_editor::viewport::tool::SceneTool;
use trackwright_editor::workspaces::design::actions::{DesignAction, MountingAction};
use trackwright_editor::workspaces::design::crf_patch_ui::{CrfPatchView, crf_patch_ui};
use trackwright_editor::workspaces::design::mounting_ui::{MountingView, mounting_ui};
use trackwright_geometry::bounds::Bounds;
use trackwright_geometry::mesh::SurfaceMesh;
use trackwright_geometry::placeholder::placeholder;
use trackwright_simulation::body::Sensor;
use trackwright_simulation::{Mounting, MountingAxis, MountingRegion};

/// As wide as the side of the window, as high as it is in a small one.
const SIZE: [f32; 2] = [300.0, 600.0];

const OPEN: MountingState = MountingState { is_open: true, patch: None, brush_mm: 5.0 };

fn rod() -> SurfaceMesh {
    placeholder(&Point3::origin(), &[Point3::new(0.0, 0.0, 100.0)])
}

fn channel() -> MountingRegion {
    MountingRegion::channel(&[Point3::origin(), Point3::new(0.0, 0.0, 100.0)]).unwrap()
}

/// One of each kind.
fn full() -> Mounting {
    Mounting {
        regions: vec![
            MountingRegion::whole_surface(),
            channel(),
            MountingRegion::Seat { position_mm: Point3::new(1.0, 2.0, 3.0), axis: None },
        ],
        keep_out: vec![Bounds::from(([0.0; 3], [5.0; 3]))],
        ..Mounting::default()
    }
}

fn view<'a>(
    mounting: &'a Mounting,
    sensors: &'a [Sensor],
    mesh: Option<&'a SurfaceMesh>,
    found: &'a dyn Fn() -> Option<MountingRegion>,
) -> MountingView<'a> {
    MountingView {
        body: BodyRole::Tool,
        mounting,
        sensors,
        mesh,
        state: OPEN,
        tool: SceneTool::Select,
        channel_from_mesh: found,
    }
}

/// What is requested by what is done to the open section.
fn requested(mounting: &Mounting, act: impl FnOnce(&mut Harness)) -> Vec<DesignAction> {
    let (design, rod, found) = (design(), rod(), || Some(channel()));
    let sensors = &design.tool.body.rigid.sensors;
    let view = view(mounting, sensors, Some(&rod), &found);
    use_panel([300.0, 1400.0], |ui| mounting_ui(ui, &view), act)
}

/// The mounting that a click on a widget makes.
fn clicked(mounting: &Mounting, name: &str) -> Mounting {
    changed(requested(mounting, |harness| harness.get_by_label(name).click()))
}

fn changed(actions: Vec<DesignAction>) -> Mounting {
    let mut edits = actions.into_iter().filter_map(|action| match action {
        DesignAction::Edit(EditRequest::Apply(Edit::SetMounting { mounting, .. })) => {
            Some(mounting)
        }
        _ => None,
    });
    let first = edits.next().expect("a changed mounting");
    assert_eq!((edits.next(), first.check()), (None, Ok(())));
    *first
}

#[test]
fn buttons_add_and_remove_regions() {
    let none = Mounting::default();
    assert_eq!(clicked(&none, "Add patch").regions, [MountingRegion::whole_surface()]);
    assert_eq!(clicked(&none, "Channel from mesh").regions, [channel()]);
    let [own] = clicked(&none, "Forbidden box").keep_out[..] else { panic!("one box") };
    assert_eq!(own.center_mm(), rod().body_bounds().unwrap().center_mm());
    let full = full();
    for (name, left) in [("Remove Patch 1", 0), ("Remove Channel 2", 1), ("Remove Seat 3", 2)] {
        let mut expected = full.clone();
        expected.regions.remove(left);
        assert_eq!(clicked(&full, name), expected, "{name}");
    }
    assert_eq!(clicked(&full, "Remove Forbidden box 1").keep_out, []);
}

#[test]
fn a_seat_is_added_at_a_sensor() {
    let sensor = design().tool.body.rigid.sensors[1].clone();
    let actions = requested(&Mounting::default(), |harness| {
        harness.get_by_label("Add seat at…").click();
        harness.run_steps(3);
        harness.get_by_label(&sensor.name).click();
    });
    assert_eq!(changed(actions).regions, [MountingRegion::seat_of(&sensor)]);
}

#[test]
fn a_menu_sets_the_axis_rule() {
    let actions = requested(&full(), |harness| {
        harness.get_by_label("Axis rule of Patch 1").click();
        harness.run_steps(3);
        harness.get_by_label("axis along normal").click();
    });
    assert_eq!(changed(actions).regions[0].axis(), Some(MountingAxis::Normal));
}

#[test]
fn distances_are_typed() {
    let type_in = |name: &'static str, text: &'static str| {
        let actions = requested(&full(), |harness| {
            harness.get_by_label(name).click();
            harness.run_steps(2);
            harness.get_by_label(name).type_text(text);
            harness.run_steps(1);
            harness.key_press(egui::Key::Enter);
        });
        changed(actions)
    };
    assert_eq!(type_in("tip clearance in mm", "4.5").tip_clearance_mm, 4.5);
    assert_eq!(type_in("Forbidden box 1 y to in mm", "7 mm").keep_out[0].max_mm.y, 7.0);
    assert_eq!(clicked(&full(), "least gap").least_gap_mm, Some(9.0));
    assert!(matches!(
        clicked(&full(), "inner radius").regions[1],
        MountingRegion::Channel { radius_mm: Some(0.5), .. }
    ));
}

#[test]
fn a_body_without_a_channel_is_refused() {
    let (mounting, rod) = (Mounting::default(), rod());
    let view = view(&mounting, &[], Some(&rod), &|| None);
    let actions = use_panel(
        SIZE,
        |ui| mounting_ui(ui, &view),
        |harness| {
            harness.get_by_label("Channel from mesh").click();
        },
    );
    let [DesignAction::Mounting(MountingAction::Refuse(why))] = actions[..] else {
        panic!("{actions:?}")
    };
    assert!(why.starts_with("No channel found"), "{why}");
}

#[test]
fn tools_are_taken_and_put_back() {
    for (name, tool) in [
        ("Paint a patch", SceneTool::PaintPatch),
        ("Erase a patch", SceneTool::ErasePatch),
        ("Draw a channel", SceneTool::DrawChannel),
        ("Draw a forbidden box", SceneTool::DrawBox),
    ] {
        let actions = requested(&full(), |harness| harness.get_by_label(name).click());
        assert_eq!(actions, [DesignAction::Mounting(MountingAction::Take(tool))]);
        let (mounting, rod) = (full(), rod());
        let view = MountingView { tool, ..view(&mounting, &[], Some(&rod), &|| None) };
        let actions = use_panel(
            [300.0, 1400.0],
            |ui| mounting_ui(ui, &view),
            |harness| {
                harness.get_by_label(name).click();
            },
        );
        assert_eq!(actions, [DesignAction::Mounting(MountingAction::Take(SceneTool::Select))]);
    }
}

#[test]
fn a_patch_for_the_crf_is_painted_and_removed() {
    let boxes = vec![Bounds::from(([0.0; 3], [5.0; 3]))];
    let anatomy = Anatomy { crf_patch: boxes, ..super::anatomy::anatomy("head", "head.stl") };
    let view = CrfPatchView {
        index: 2,
        anatomy: &anatomy,
        has_mesh: true,
        state: OPEN,
        tool: SceneTool::Select,
    };
    let after = |name: &'static str| {
        use_panel(SIZE, |ui| crf_patch_ui(ui, &view), |harness| harness.get_by_label(name).click())
    };
    let paint = DesignAction::Mounting(MountingAction::Take(SceneTool::PaintPatch));
    assert_eq!(after("Paint a patch"), [paint]);
    let removed = AnatomyEdit::SetCrfPatch { index: 2, boxes: Vec::new() };
    assert_eq!(after("Remove patch"), [DesignAction::apply(Edit::Anatomy(removed))]);
    let closed = MountingState { is_open: false, ..OPEN };
    assert_eq!(after("edit patch"), [DesignAction::Mounting(MountingAction::Set(closed))]);
}

#[test]
fn a_closed_section_is_one_switch() {
    let (mounting, rod) = (full(), rod());
    let closed = MountingState { is_open: false, ..OPEN };
    let view = MountingView { state: closed, ..view(&mounting, &[], Some(&rod), &|| None) };
    let (mut harness, requests) = panel(SIZE, |ui| mounting_ui(ui, &view));
    harness.run_steps(2);
    assert_eq!(harness.query_all_by_label("Patch 1").count(), 0);
    harness.get_by_label("3 regions, 1 forbidden box");
    harness.get_by_label("edit regions").click();
    harness.run_steps(2);
    let open = DesignAction::Mounting(MountingAction::Set(OPEN));
    assert_eq!(*requests.borrow(), [open]);
}

#[test]
fn nothing_of_the_section_is_cut_or_overlaps() {
    let (mut mounting, rod, design) = (full(), rod(), design());
    mounting.least_gap_mm = Some(12.5);
    mounting.regions[1] = channel().with_axis(MountingAxis::Along);
    let sensors = &design.tool.body.rigid.sensors;
    let view = view(&mounting, sensors, Some(&rod), &|| None);
    let (mut harness, _) = panel([300.0, 1400.0], |ui| mounting_ui(ui, &view));
    harness.run_steps(3);
    assert_nothing_overlaps(&harness, 300.0, 25);
}
