//! Dragging a sensor in the window: what it changes, and that Escape and undo take it back.

use super::harness::{Window, simulated};
use super::places::{project, tool_sensor, view};
use crate::copied::Copied;
use crate::pixels::{Blob, Picture, Pixel, is_ghost, is_near};
use bevy_egui::egui::pos2;
use nalgebra::Point3;
use std::collections::BTreeSet;
use trackwright_design::view::Magnification;
use trackwright_editor::palette;
use trackwright_editor::palette::ThemedColor;
use trackwright_geometry::orbit::{OrbitCamera, Projection};

/// How far the sensor is dragged, pixels.
const WAY_PX: u32 = 60;

/// Shading makes coils a little darker towards their rims.
const SHADE: u8 = 40;

/// What the ghost has to move at least: its outline is hundreds of pixels long, and a pixel of
/// it that moves by one counts twice.
const LEAST_MOVED: usize = 200;

/// The pointer on the head with the camera before its shaft, and nothing amber or cyan around it.
fn pointer_on_head() -> (Copied, OrbitCamera) {
    let copy = Copied::new("pointer-on-head");
    let world = trackwright_project::open_design(&copy.design).unwrap();
    let (_, shaft) = tool_sensor(&world, "shaft");
    let camera = OrbitCamera {
        focus_mm: shaft,
        distance_mm: 450.0,
        azimuth_rad: -0.5,
        elevation_rad: 0.25,
        projection: Projection::Perspective,
    };
    copy.change_view(|view| {
        view.camera = Some(camera.into());
        // The map's colours run through the ghost's; vectors and labels that move with the sensor
        // would cover other parts of it; an automatic magnification would move it by itself.
        view.layers.slice = false;
        view.layers.sensor_errors = false;
        view.layers.tip_error = false;
        view.layers.labels = false;
        view.magnification = Magnification::Times(50.0);
    });
    (copy, camera)
}

/// The coil that is drawn nearest to a place, and not a label in the same colour: letters are
/// thinner than any coil.
fn coil(picture: &Picture, near: [f64; 2]) -> Blob {
    let [r, g, b] = palette::SENSOR.srgb();
    let is_amber = |color: [u8; 3]| {
        // Amber in any shade: its hue stays.
        let shade = f64::from(color[0]) / f64::from(r);
        let hue = [r, g, b].map(|c| (f64::from(c) * shade).round() as u8);
        color[0] >= r - SHADE && is_near(color, hue, 12)
    };
    let distance = |blob: &Blob| {
        let [x, y] = blob.center();
        (x - near[0]).hypot(y - near[1])
    };
    picture
        .blobs(is_amber)
        .into_iter()
        .filter(|blob| blob.pixels.len() >= 60)
        .min_by(|a, b| distance(a).total_cmp(&distance(b)))
        .filter(|blob| distance(blob) < 20.0)
        .expect("a coil where the camera sees the sensor")
}

/// Where the ghost is in the 3D view, away from the sensor that is dragged over it.
fn ghost(picture: &Picture, avoid: &[[f64; 2]]) -> BTreeSet<Pixel> {
    let mut ghost = picture.all(is_ghost);
    ghost.retain(|[x, y]| {
        let at = [*x as f64, *y as f64];
        view().contains(pos2(at[0] as f32, at[1] as f32))
            && avoid.iter().all(|a| (a[0] - at[0]).hypot(a[1] - at[1]) > 60.0)
    });
    ghost
}

/// Takes hold of the shaft's sensor and drags it towards the grip, without letting go.
fn drag_shaft_sensor(
    window: &mut Window,
    camera: &OrbitCamera,
    sensor: Point3<f64>,
) -> [[f64; 2]; 2] {
    window.point_at([20.0, 20.0]);
    let blob = coil(&window.picture(), project(camera, &sensor));
    let (at, mut along) = (blob.center(), blob.direction());
    // Up: away from the tip.
    if along[1] > 0.0 {
        along = along.map(|d| -d);
    }
    window.point_at(at);
    window.press_button();
    window.move_along(along, WAY_PX);
    let way = f64::from(WAY_PX);
    [at, [at[0] + along[0] * way, at[1] + along[1] * way]]
}

#[test]
fn a_dragged_sensor_can_be_undone_exactly() {
    let (copy, camera) = pointer_on_head();
    let files = copy.bytes();
    let world = trackwright_project::open_design(&copy.design).unwrap();
    let (_, sensor) = tool_sensor(&world, "shaft");
    let mut window = Window::open(&copy.design);
    let figures = window.figures();
    assert_eq!(figures, simulated(&copy.design));
    let before = window.picture();

    let ends = drag_shaft_sensor(&mut window, &camera, sensor);
    window.release_button();
    assert_eq!(window.document("undo"), "Move sensor shaft");
    assert_ne!(window.figures(), figures);
    window.point_at([20.0, 20.0]);
    let after = window.picture();
    let moved = ghost(&before, &ends).symmetric_difference(&ghost(&after, &ends)).count();
    assert!(moved > LEAST_MOVED, "{moved} of the ghost's pixels");

    window.key("ctrl+s");
    assert_eq!(window.document("dirty"), "false");
    assert_ne!(copy.bytes(), files);
    assert_eq!(window.figures(), simulated(&copy.design));

    window.key("ctrl+z");
    assert_eq!(window.document("undo"), "none");
    assert_eq!(window.figures(), figures);
    window.key("ctrl+s");
    for ((file, was), (_, is)) in files.iter().zip(copy.bytes()) {
        assert!(*was == is, "{} is not as it was", file.display());
    }
}

#[test]
fn escape_takes_a_drag_back_as_if_it_had_not_been() {
    let (copy, camera) = pointer_on_head();
    let files = copy.bytes();
    let world = trackwright_project::open_design(&copy.design).unwrap();
    let (_, sensor) = tool_sensor(&world, "shaft");
    let mut window = Window::open(&copy.design);
    let (figures, title) = (window.figures(), window.title());

    drag_shaft_sensor(&mut window, &camera, sensor);
    assert_eq!(window.document("dirty"), "true");
    assert_ne!(window.figures(), figures);
    window.key("Escape");
    let is_clean = |window: &Window| {
        assert_eq!(window.figures(), figures);
        assert_eq!(window.document("dirty"), "false");
        assert_eq!(window.document("undo"), "none");
        assert_eq!(window.document("redo"), "none");
        assert_eq!(window.title(), title);
    };
    is_clean(&window);
    // The button is still down, but that drag is over.
    window.move_along([0.0, -1.0], 30);
    window.release_button();
    is_clean(&window);
    window.key("ctrl+z");
    is_clean(&window);
    assert!(copy.bytes() == files);
}
