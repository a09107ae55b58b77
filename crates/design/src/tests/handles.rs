//! What is moved by hand.

use super::*;
use nalgebra::{Unit, UnitQuaternion};
use std::sync::Arc;
use trackwright_field::generator::Generator;
use trackwright_geometry::movement::Movement;
use trackwright_geometry::pose::pose_from_parts;
use trackwright_metal::new_object::NewShape;
use trackwright_metal::setup::{
    DEFAULT_TRIANGLES, MaterialTolerance, MetalObject, ObjectMaterial, RoomMetal,
};

/// A design whose frames are turned against each other.
fn turned_design() -> Design {
    let mut design = design();
    let rotation = UnitQuaternion::from_euler_angles;
    if let Some(crf) = &mut design.crf {
        crf.tracker_from_crf =
            pose_from_parts(Vector3::new(-40.0, 3.0, -300.0), rotation(0.3, -0.7, 1.9));
    }
    design.tool.crf_from_tool =
        pose_from_parts(Vector3::new(5.0, 20.0, -1.0), rotation(1.1, 0.2, -0.4));
    design.tool.body.rigid.tip_in_body = Some(Point3::new(0.5, -2.0, 9.0));
    design
}

fn document(design: Design) -> Document {
    Document::new(design, View::default(), Origin::File("d.design.ron".into()))
}

fn moved(design: &Design, role: BodyRole, movement: &Movement) -> Design {
    let mut document = document(design.clone());
    document.apply(design.moved_body(role, movement).unwrap()).unwrap();
    document.design().clone()
}

fn slide(by_mm: f64) -> Movement {
    Movement::Slide { direction: Unit::new_normalize(Vector3::new(0.2, 0.9, -0.4)), by_mm }
}

fn turn(pivot_mm: Point3<f64>, by_rad: f64) -> Movement {
    Movement::Turn { axis: Unit::new_normalize(Vector3::new(-0.5, 0.1, 0.8)), pivot_mm, by_rad }
}

fn pivot(design: &Design, role: BodyRole) -> Point3<f64> {
    let handle = design.tracker_from_body_handle(role, HandleAxes::Own);
    handle.unwrap().translation.vector.into()
}

#[test]
fn moving_the_crf_keeps_the_tool_in_it_exactly() {
    let before = turned_design();
    let at = pivot(&before, BodyRole::Crf);
    for movement in [slide(12.0), turn(at, 0.8)] {
        let after = moved(&before, BodyRole::Crf, &movement);
        assert_eq!(after.tool, before.tool);
        let tool = |design: &Design| design.tracker_from_body(BodyRole::Tool).unwrap();
        let wanted = movement.moved(&tool(&before));
        assert!((tool(&after).translation.vector - wanted.translation.vector).norm() < 1e-10);
    }
}

#[test]
fn a_moved_tool_leaves_the_crf() {
    let before = turned_design();
    let tool = |design: &Design| design.tracker_from_body(BodyRole::Tool).unwrap();
    let after = moved(&before, BodyRole::Tool, &slide(-7.5));
    assert_eq!(after.crf, before.crf);
    assert_eq!(
        after.tool.crf_from_tool.rotation, before.tool.crf_from_tool.rotation,
        "what slides does not turn"
    );
    let wanted = slide(-7.5).moved(&tool(&before));
    assert!((tool(&after).translation.vector - wanted.translation.vector).norm() < 1e-12 * 400.0);
}

#[test]
fn a_body_turns_about_its_tip() {
    let before = turned_design();
    for role in BodyRole::ALL {
        let at = pivot(&before, role);
        let after = moved(&before, role, &turn(at, 1.3));
        assert!((pivot(&after, role) - at).norm() < 1e-12 * 400.0, "{role}");
        let angle = before.tracker_from_body(role).unwrap().rotation;
        let angle = angle.angle_to(&after.tracker_from_body(role).unwrap().rotation);
        assert!((angle - 1.3).abs() < 1e-9, "{role} {angle}");
    }
}

#[test]
fn a_movement_by_nothing_changes_nothing() {
    let before = turned_design();
    for role in BodyRole::ALL {
        let at = pivot(&before, role);
        assert_eq!(moved(&before, role, &slide(0.0)), before);
        assert_eq!(moved(&before, role, &turn(at, 0.0)), before);
    }
}

#[test]
fn a_sensor_turns_about_a_tracker_axis_in_place() {
    let before = turned_design();
    let movement = turn(Point3::origin(), 0.6);
    let mut document = document(before.clone());
    let edit = before.turned_sensor(BodyRole::Tool, 1, &movement).unwrap();
    document.apply(edit).unwrap();
    let axis = |design: &Design| {
        let pose = design.tracker_from_body(BodyRole::Tool).unwrap();
        pose.rotation * design.tool.body.rigid.sensors[1].axis_in_body().unwrap().into_inner()
    };
    let wanted = movement.rotation() * axis(&before);
    assert!((axis(document.design()) - wanted).norm() < 1e-12);
    let place = |design: &Design| design.tool.body.rigid.sensors[1].position_in_body;
    assert_eq!(place(document.design()), place(&before));
    let nothing = before.turned_sensor(BodyRole::Tool, 1, &turn(Point3::origin(), 0.0));
    assert_eq!(document.undo(), Some("Move sensor b".into()));
    assert_eq!(document.apply(nothing.unwrap()), Ok(false));
}

#[test]
fn handles_follow_the_body_or_the_tracker() {
    let design = turned_design();
    let role = BodyRole::Tool;
    let rotation = |pose: Option<Pose>| pose.unwrap().rotation;
    let own = rotation(design.tracker_from_body_handle(role, HandleAxes::Own));
    assert_eq!(own, design.tracker_from_body(role).unwrap().rotation);
    let tracker = rotation(design.tracker_from_body_handle(role, HandleAxes::Tracker));
    assert_eq!(tracker, UnitQuaternion::identity());
    let sensor = rotation(design.tracker_from_sensor_handle(role, 0, HandleAxes::Own));
    let z = design.tool.body.rigid.sensors[0].axis_in_body().unwrap();
    assert!((sensor * Vector3::z() - own * z.into_inner()).norm() < 1e-12);
}

#[test]
fn a_new_sensor_has_a_name_of_its_own() {
    let mut body = design().tool.body.rigid;
    for wanted in ["sensor 1", "sensor 2", "sensor 3"] {
        let new = sensor_beside_last(&body);
        assert_eq!(new.name, wanted);
        body.sensors.push(new);
    }
}

#[test]
fn beside_a_marker_another_is_put() {
    let mut body = design().tool.body.rigid;
    body.sensors[0].orientation = SensorOrientation::Marker;
    body.sensors.truncate(1);
    for wanted in ["marker 1", "marker 2"] {
        let new = sensor_beside_last(&body);
        assert_eq!((new.name.as_str(), new.orientation), (wanted, SensorOrientation::Marker));
        body.sensors.push(new);
    }
}

#[test]
fn metal_moves_about_its_own_handle() {
    let mut before = turned_design();
    let object = MetalObject {
        name: "plate".to_owned(),
        shape: NewShape::Plate.shape(),
        material: ObjectMaterial::Named("aluminium"),
        tracker_from_object: pose_from_parts(
            Vector3::new(400.0, -20.0, -300.0),
            UnitQuaternion::from_euler_angles(0.4, 0.1, -0.9),
        ),
        most_triangles: DEFAULT_TRIANGLES,
        tolerance: MaterialTolerance::default(),
    };
    let room = RoomMetal::empty(Generator::planar_nine());
    before.room_metal = Some(Arc::new(RoomMetal { objects: vec![object.clone()], ..room }));
    let own = before.tracker_from_metal_handle(0, HandleAxes::Own).unwrap();
    assert_eq!(own, object.tracker_from_object);
    let in_tracker = before.tracker_from_metal_handle(0, HandleAxes::Tracker).unwrap();
    assert_eq!(in_tracker.rotation, UnitQuaternion::identity());
    assert_eq!(in_tracker.translation, own.translation);
    for movement in [slide(12.0), turn(own.translation.vector.into(), 0.8)] {
        let mut document = document(before.clone());
        document.apply(before.moved_metal(0, &movement).unwrap()).unwrap();
        let after = document.design().metal_object(0).unwrap();
        assert_eq!(after.tracker_from_object, movement.moved(&own));
        assert_eq!(document.undo().as_deref(), Some("Move plate"));
        assert_eq!(*document.design(), before);
    }
    assert_eq!(before.moved_metal(1, &slide(1.0)), None);
}
