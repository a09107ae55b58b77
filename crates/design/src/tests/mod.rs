//! Documents: edits, history, and what counts as saved.

mod edits;
mod handles;
mod history;
mod procedure;

use super::*;
use crate::view::CameraView;
use nalgebra::{Point3, Vector3};
use trackwright_geometry::pose::Pose;
use trackwright_simulation::body::{RigidBody, Sensor, SensorOrientation};
use trackwright_simulation::mounting::Mounting;

fn sensor(name: &str, z_mm: f64) -> Sensor {
    Sensor::five_dof(name, Point3::new(0.0, 0.0, z_mm), Vector3::z_axis())
}

fn body(reference: &str) -> DesignBody {
    DesignBody {
        reference: reference.to_owned(),
        mesh: None,
        rigid: RigidBody {
            name: reference.to_owned(),
            tip_in_body: None,
            sensors: vec![sensor("a", 0.1), sensor("b", 50.0)],
        },
        definition: None,
        mounting: Mounting::default(),
    }
}

fn design() -> Design {
    let mut design = Design::of_tool("design", "room.env.ron", body("tool.body.ron"));
    design.tool.crf_from_tool = Pose::translation(0.0, 20.0, 0.0);
    design.crf = Some(CrfPlacement {
        body: body("crf.body.ron"),
        tracker_from_crf: Pose::translation(0.0, 0.0, -300.0),
        targets: Vec::new(),
        motion: None,
        requirement: None,
    });
    design
}

pub(super) fn document() -> Document {
    Document::new(design(), View::default(), Origin::File("x.design.ron".into()))
}

fn move_to(z_mm: f64) -> Edit {
    Edit::SetSensor { body: BodyRole::Tool, index: 0, sensor: sensor("a", z_mm) }
}

fn z_mm(document: &Document) -> f64 {
    document.design().tool.body.rigid.sensors[0].position_in_body.z
}

fn arrange(indices: &[usize], arrangement: Arrangement) -> Edit {
    Edit::Arrange { body: BodyRole::Tool, indices: indices.to_vec(), arrangement }
}

fn tool_names(document: &Document) -> Vec<String> {
    let sensors = &document.design().tool.body.rigid.sensors;
    sensors.iter().map(|s| s.name.clone()).collect()
}

#[test]
fn a_tools_pose_goes_by_way_of_the_crf() {
    let mut design = design();
    let pose = design.tracker_from_body(BodyRole::Tool).unwrap();
    assert_eq!(pose.translation.vector, Vector3::new(0.0, 20.0, -300.0));
    design.crf = None;
    let pose = design.tracker_from_body(BodyRole::Tool).unwrap();
    assert_eq!(pose.translation.vector, Vector3::new(0.0, 20.0, 0.0));
    assert!(design.tracker_from_body(BodyRole::Crf).is_none());
    assert_eq!(design.bodies().count(), 1);
}

#[test]
fn the_view_dirties_the_file_but_is_no_step() {
    let mut document = document();
    let mut view = View::default();
    assert!(!document.set_view(view.clone()));
    view.layers.slice = false;
    assert!(document.set_view(view));
    assert!(document.is_dirty());
    assert_eq!((document.undo_label(), document.revision()), (None, 0));
    document.mark_saved();
    assert!(!document.is_dirty());
}

#[test]
fn orbiting_leaves_a_saved_design_saved() {
    let mut document = document();
    let camera = CameraView {
        focus_mm: [0.0; 3],
        distance_mm: 500.0,
        azimuth_rad: 0.1,
        elevation_rad: 0.2,
        is_orthographic: false,
    };
    let mut view = document.own_view().clone();
    for camera in [Some(camera), Some(CameraView { azimuth_rad: 0.3, ..camera }), None] {
        view.camera = camera;
        document.set_view(view.clone());
        assert!(!document.is_dirty());
    }
    view.camera = Some(camera);
    view.layers.slice = !view.layers.slice;
    document.set_view(view);
    assert!(document.is_dirty());
}

#[test]
fn moving_the_file_rewrites_the_past_too() {
    let mut document = document();
    document.apply(move_to(1.0)).unwrap();
    document.relocate(Origin::File("y".into()), |design| {
        design.tool.body.reference = "moved".to_owned();
    });
    document.undo();
    assert_eq!(document.design().tool.body.reference, "moved");
    assert!(!document.is_dirty());
}
