//! Metal moved by hand in the window: the figure follows, and undo takes it back.

use super::harness::{Window, simulated};
use super::places::{arrow_x, in_outliner};
use crate::copied::Copied;
use nalgebra::{Point3, Vector3};
use std::sync::Arc;
use trackwright_design::view::Magnification;
use trackwright_design::{Edit, MetalEdit};
use trackwright_editor::document::selection::Selected;
use trackwright_field::generator::Generator;
use trackwright_geometry::orbit::{OrbitCamera, Projection};
use trackwright_geometry::pose::Pose;
use trackwright_metal::setup::{
    DEFAULT_TRIANGLES, MaterialTolerance, MetalObject, ObjectMaterial, ObjectShape, RoomMetal,
};

/// Beside the patient, who is at x = −50.
const PLATE_MM: [f64; 3] = [260.0, 0.0, -280.0];

/// How far the plate is dragged, pixels.
const WAY_PX: u32 = 60;

/// The pointer on the head in its measured room, with an aluminium plate beside the patient, and a camera
/// that sees the plate's handles.
fn with_plate() -> (Copied, OrbitCamera) {
    let copy = Copied::new("pointer-on-head");
    let mut world = trackwright_project::open_design(&copy.design).unwrap();
    let plate = MetalObject {
        name: "plate".to_owned(),
        shape: ObjectShape::Cuboid { size_mm: Vector3::new(10.0, 200.0, 200.0) },
        material: ObjectMaterial::Named("aluminium"),
        tracker_from_object: Pose::from(Vector3::from(PLATE_MM)),
        most_triangles: DEFAULT_TRIANGLES,
        tolerance: MaterialTolerance::default(),
    };
    let empty = RoomMetal::empty(Generator::planar_nine());
    let metal = Arc::new(RoomMetal { objects: vec![plate], ..empty });
    world.document.apply(Edit::Metal(MetalEdit::Replace(Some(metal)))).unwrap();
    trackwright_project::save(&mut world).unwrap();
    let camera = OrbitCamera {
        focus_mm: Point3::from(PLATE_MM),
        distance_mm: 900.0,
        azimuth_rad: -0.5,
        elevation_rad: 0.3,
        projection: Projection::Perspective,
    };
    copy.change_view(|view| {
        view.camera = Some(camera.into());
        // Nothing but bodies under the pointer.
        view.layers.slice = false;
        view.layers.labels = false;
        view.magnification = Magnification::Times(10.0);
    });
    (copy, camera)
}

fn rms_mm(figures: &[(String, String)]) -> f64 {
    let (_, value) = figures.iter().find(|(label, _)| label == "tip error RMS").unwrap();
    let number: String = value.chars().take_while(|c| c.is_ascii_digit() || *c == '.').collect();
    number.parse().unwrap()
}

#[test]
fn a_plate_dragged_to_the_patient_raises_the_error() {
    let (copy, camera) = with_plate();
    let world = trackwright_project::open_design(&copy.design).unwrap();
    let mut window = Window::open(&copy.design);
    let before = window.figures();
    assert_eq!(before, simulated(&copy.design));
    let rooms = window.counter("rooms");

    window.click(in_outliner(&world, "plate"));
    let (grip, away) = arrow_x(&world, Selected::Metal(0), &camera);
    window.point_at(grip);
    window.press_button();
    window.move_along(away.map(|d| -d), WAY_PX);
    // While it is held already.
    let held = window.figures();
    assert!(rms_mm(&held) > 1.2 * rms_mm(&before), "{held:?} {before:?}");
    assert!(window.counter("rooms") > rooms);
    window.release_button();
    assert_eq!(window.document("undo"), "Move plate");
    let after = window.figures();
    assert!(rms_mm(&after) > 1.2 * rms_mm(&before), "{after:?} {before:?}");

    window.key("ctrl+s");
    assert_eq!(window.document("dirty"), "false");
    assert_eq!(simulated(&copy.design), after);
    window.key("ctrl+z");
    assert_eq!(window.document("undo"), "none");
    assert_eq!(window.figures(), before);
}
