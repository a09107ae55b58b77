//! A session as a person has it: a sensor added by a click, dragged and mirrored, the CRF moved by
//! its handle, all of it undone and redone, saved, closed and opened again.

use super::harness::{Turn, Window, simulated};
use super::places::{arrow_x, in_outliner, middle_of_view, project, tool_sensor};
use crate::copied::Copied;
use nalgebra::{Point3, Vector3};
use trackwright_design::BodyRole;
use trackwright_design::view::Magnification;
use trackwright_editor::document::selection::Selected;
use trackwright_geometry::orbit::{OrbitCamera, Projection};
use trackwright_project::World;

/// From the shaft's sensor to where another one is added, along the shaft.
const BESIDE_MM: f64 = 28.0;

/// How far sensor and CRF are dragged, pixels.
const SLIDE_PX: u32 = 24;
const PULL_PX: u32 = 40;

/// The pointer on the head, and a camera that sees its shaft and the CRF's handles with little
/// around them.
fn pointer_on_head() -> (Copied, OrbitCamera) {
    let copy = Copied::new("pointer-on-head");
    let world = trackwright_project::open_design(&copy.design).unwrap();
    let (_, shaft) = tool_sensor(&world, "shaft");
    let crf = world.document.design().tracker_from_body(BodyRole::Crf);
    let crf_mm = Point3::from(crf.unwrap().translation.vector);
    let camera = OrbitCamera {
        focus_mm: nalgebra::center(&shaft, &crf_mm),
        distance_mm: 600.0,
        azimuth_rad: -0.5,
        elevation_rad: 0.25,
        projection: Projection::Perspective,
    };
    copy.change_view(|view| {
        view.camera = Some(camera.into());
        // Nothing but bodies and sensors under the pointer.
        view.layers.slice = false;
        view.layers.labels = false;
        view.magnification = Magnification::Times(50.0);
    });
    (copy, camera)
}

/// A place on the shaft between its sensors, and the direction of the shaft there, in the window.
fn on_the_shaft(world: &World, camera: &OrbitCamera) -> ([f64; 2], [f64; 2]) {
    let pose = world.document.design().tracker_from_body(BodyRole::Tool);
    let along = pose.unwrap().rotation * Vector3::z();
    let (_, sensor) = tool_sensor(world, "shaft");
    let [from, to] =
        [BESIDE_MM, BESIDE_MM + 10.0].map(|mm| project(camera, &(sensor + along * mm)));
    let way = [to[0] - from[0], to[1] - from[1]];
    let length = way[0].hypot(way[1]);
    (from, way.map(|d| d / length))
}

/// Presses at a place, moves along a direction, and lets go.
fn drag(window: &mut Window, at: [f64; 2], along: [f64; 2], way_px: u32) {
    window.point_at(at);
    window.press_button();
    window.move_along(along, way_px);
    window.release_button();
}

#[test]
fn undo_save_and_reopen_keep_every_digit() {
    let (copy, camera) = pointer_on_head();
    let world = trackwright_project::open_design(&copy.design).unwrap();
    let design = world.document.design();
    let turn = Turn::wait();
    let state = tempfile::tempdir().unwrap();
    let mut window = Window::open_beside(&turn, &copy.design, state.path());
    let opened = window.figures();
    let mut steps = Vec::new();

    let (at, along) = on_the_shaft(&world, &camera);
    window.point_at(middle_of_view());
    window.key("a");
    window.click(at);
    steps.push(window.figures());
    let added = window.document("undo").to_owned();
    assert!(added.starts_with("Add sensor "), "{added}");

    drag(&mut window, at, along, SLIDE_PX);
    steps.push(window.figures());
    assert_eq!(window.document("undo"), added.replace("Add", "Move"));

    window.run_command("Mirror sensors at x");
    steps.push(window.figures());
    assert_eq!(window.document("undo"), added.replace("Add", "Mirror"));

    let crf = &design.crf.as_ref().unwrap().body.rigid.name;
    let with_sensor = {
        // The list is a row longer than in the file.
        window.key("ctrl+s");
        trackwright_project::open_design(&copy.design).unwrap()
    };
    window.click(in_outliner(&with_sensor, crf));
    let (grip, away) = arrow_x(&with_sensor, Selected::Body(BodyRole::Crf), &camera);
    drag(&mut window, grip, away, PULL_PX);
    steps.push(window.figures());
    assert_eq!(window.document("undo"), "Move CRF");

    let mut before = opened.clone();
    for after in &steps {
        assert_ne!(*after, before);
        before.clone_from(after);
    }
    let last = steps.pop().unwrap();
    for step in steps.iter().rev().chain([&opened]) {
        window.key("ctrl+z");
        assert_eq!(window.figures(), *step);
    }
    assert_eq!(window.document("undo"), "none");
    for step in steps.iter().chain([&last]) {
        window.key("ctrl+shift+z");
        assert_eq!(window.figures(), *step);
    }
    assert_eq!(window.document("redo"), "none");

    window.key("ctrl+s");
    assert_eq!(window.document("dirty"), "false");
    assert_eq!(simulated(&copy.design), last);
    window.close();

    let window = Window::open_beside(&turn, &copy.design, state.path());
    assert_eq!(window.last("dialog"), Some("none"));
    assert_eq!(window.figures(), last);
    let saved = trackwright_project::open_design(&copy.design).unwrap();
    let (before, after) = (design, saved.document.design());
    let sensors = |design: &trackwright_design::Design| design.tool.body.rigid.sensors.len();
    assert_eq!(sensors(after), sensors(before) + 1);
    // The tool goes with the CRF that it is tracked in.
    assert_eq!(after.tool.crf_from_tool, before.tool.crf_from_tool);
}
