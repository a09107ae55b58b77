//! What edits do, what they are called, and what is refused.

use super::*;
use crate::definition::{DefinitionFile, DefinitionKind};
use nalgebra::Point3;
use nalgebra::Unit;
use std::sync::Arc;
use trackwright_geometry::mesh_reference::{MeshReference, MeshUnit};
use trackwright_simulation::Metric;
use trackwright_simulation::SensorOrientation;
use trackwright_simulation::body::Coil;
use trackwright_simulation::motion::{AxisRange, Motion};
use trackwright_simulation::{MountingAxis, MountingRegion};

#[test]
fn edits_state_what_they_do() {
    let design = design();
    let label = |edit: Edit| edit.label_for(&design);
    let set = |sensor| Edit::SetSensor { body: BodyRole::Tool, index: 0, sensor };
    assert_eq!(label(move_to(1.0)), "Move sensor a");
    assert_eq!(label(set(sensor("c", 0.1))), "Rename sensor a");
    let mut with_coil = sensor("a", 0.1);
    with_coil.coil = Some(Coil { diameter_mm: 0.8, length_mm: 9.0 });
    assert_eq!(label(set(with_coil)), "Change sensor a");
    let remove = Edit::RemoveSensor { body: BodyRole::Crf, index: 1 };
    assert_eq!(label(remove), "Remove sensor b");
    let mesh = set_mesh(MeshReference::new("a.stl"));
    assert_eq!(label(mesh), "Change tool's mesh");
    assert_eq!(label(set_body(probe())), "Use probe as the tool");
}

/// A body that came from a maker's file.
fn probe() -> DesignBody {
    let image = r#"{"count": 1, "id": 7, "fiducials": [{"x": 1.5, "y": 0, "z": -0.0}]}"#;
    let definition = DefinitionFile { kind: DefinitionKind::SawJson, bytes: image.into() };
    let mut probe = body("probe");
    probe.rigid.sensors =
        vec![Sensor::new("marker 1", Point3::new(1.5, 0.0, -0.0), SensorOrientation::Marker)];
    probe.definition = Some(Arc::new(definition));
    probe
}

fn set_body(content: DesignBody) -> Edit {
    Edit::SetBody { body: BodyRole::Tool, content: Box::new(content) }
}

#[test]
fn a_new_crf_moves_nothing() {
    let mut design = design();
    let crf = design.crf.take().unwrap();
    // What was on the CRF is in the tracker's frame without one.
    design.tool.crf_from_tool = Pose::translation(1.0, 2.0, -250.0);
    let mesh = MeshReference::new("head.stl");
    for (name, on) in [("head", AnatomyFrame::Crf), ("table", AnatomyFrame::Tracker)] {
        design.anatomy.push(Anatomy {
            name: name.to_owned(),
            mesh: mesh.clone(),
            on,
            frame_from_mesh: Pose::translation(5.0, 0.0, -200.0),
            color: None,
            crf_patch: Vec::new(),
        });
    }
    let places = |design: &Design| {
        let tool = design.tracker_from_body(BodyRole::Tool).unwrap();
        let anatomy = design.anatomy.iter().map(|own| own.tracker_from_mesh(design));
        std::iter::once(tool).chain(anatomy).collect::<Vec<_>>()
    };
    let before = places(&design);
    let at = design.pose_of_new_crf();
    assert_eq!(at.rotation.angle(), 0.0, "the axes of motion are as they were");
    let add = Edit::AddCrf(Box::new(CrfPlacement { tracker_from_crf: at, ..crf }));
    let mut document = Document::new(design.clone(), View::default(), Origin::BuiltIn("x"));
    assert!(document.apply(add.clone()).unwrap());
    assert!(document.undo_label().is_some_and(|label| label.ends_with(" as the CRF")));
    for (before, after) in before.iter().zip(places(document.design())) {
        assert!((before.translation.vector - after.translation.vector).norm() < 1e-12);
        assert!(before.rotation.angle_to(&after.rotation) < 1e-12);
    }
    assert_eq!(document.apply(add), Err(EditError::HasCrf));
    document.undo();
    assert_eq!(*document.design(), design);
}

#[test]
fn a_replaced_body_is_restored_exactly() {
    let mut document = document();
    let mesh = set_mesh(MeshReference::new("a.stl"));
    document.apply(mesh).unwrap();
    let before = document.shared_design();
    assert!(document.apply(set_body(probe())).unwrap());
    let design = document.design();
    assert_eq!(design.tool.body, probe());
    // Where it is stays, and so does the other body.
    assert_eq!(design.tool.crf_from_tool, before.tool.crf_from_tool);
    assert_eq!(design.crf, before.crf);
    assert!(!document.apply(set_body(probe())).unwrap());
    assert_eq!(document.undo().as_deref(), Some("Use probe as the tool"));
    assert!(std::sync::Arc::ptr_eq(&document.shared_design(), &before));
    document.redo();
    assert_eq!(document.design().tool.body, probe());
}

#[test]
fn bodies_that_cannot_be_studied_are_refused() {
    let with = |change: fn(&mut DesignBody)| {
        let mut body = probe();
        change(&mut body);
        set_body(body)
    };
    let crf = Edit::SetBody { body: BodyRole::Crf, content: Box::new(probe()) };
    let mut alone = design();
    alone.crf = None;
    let mut lone = Document::new(alone, View::default(), Origin::File("x".into()));
    assert_eq!(lone.apply(crf), Err(EditError::NoCrf));
    for (edit, expected) in [
        (with(|b| b.rigid.sensors.clear()), "at least one sensor"),
        (with(|b| b.reference.clear()), "the body's file is empty"),
        (with(|b| b.rigid.tip_in_body = Some(Point3::new(0.0, f64::NAN, 0.0))), "the tip is NaN"),
        (
            with(|b| b.rigid.sensors.push(b.rigid.sensors[0].clone())),
            "already has a sensor named \"marker 1\"",
        ),
        (with(|b| b.mesh = Some(MeshReference::new(""))), "mesh's file is empty"),
        (with(|b| b.mounting.tip_clearance_mm = -1.0), "tip_clearance is -1, expected zero"),
    ] {
        let mut document = document();
        let error = document.apply(edit).unwrap_err().to_string();
        assert!(error.contains(expected), "{error}");
        assert_eq!((document.design(), document.undo_label()), (&self::design(), None));
    }
}

fn set_mesh(mesh: MeshReference) -> Edit {
    Edit::SetMesh { body: BodyRole::Tool, mesh: Some(mesh) }
}

fn set_mounting(mounting: Mounting) -> Edit {
    Edit::SetMounting { body: BodyRole::Tool, mounting: Box::new(mounting) }
}

/// A needle's lumen.
fn channel() -> Mounting {
    let region = MountingRegion::Channel {
        points_mm: vec![Point3::new(0.0, 0.0, 10.0), Point3::new(0.0, 0.0, 130.0)],
        radius_mm: Some(0.5),
        axis: MountingAxis::Along,
    };
    Mounting { regions: vec![region], tip_clearance_mm: 5.0, ..Mounting::default() }
}

#[test]
fn mounting_regions_change_no_study() {
    let mut document = document();
    let before = document.shared_design();
    assert!(document.apply(set_mounting(channel())).unwrap());
    assert_eq!(document.undo_label(), Some("Change tool's mounting regions"));
    assert_eq!(document.design().tool.body.mounting, channel());
    assert!(document.design().has_studies_of(&before));
    assert!(!document.apply(set_mounting(channel())).unwrap(), "nothing changes");
    document.undo();
    assert!(std::sync::Arc::ptr_eq(&document.shared_design(), &before));
    document.redo();
    assert_eq!(document.design().tool.body.mounting, channel());
    // A body that comes in the place of this one brings its own.
    document.apply(set_body(probe())).unwrap();
    assert!(document.design().tool.body.mounting.is_empty());
    let mut alone = design();
    alone.crf = None;
    let mut lone = Document::new(alone, View::default(), Origin::File("x".into()));
    let mounting = Box::new(channel());
    let of_crf = Edit::SetMounting { body: BodyRole::Crf, mounting };
    assert_eq!(lone.apply(of_crf), Err(EditError::NoCrf));
}

#[test]
fn refused_edits_change_nothing() {
    let tool = BodyRole::Tool;
    let set = |index, sensor| Edit::SetSensor { body: tool, index, sensor };
    let mut bent = sensor("a", 0.0);
    bent.orientation = SensorOrientation::FiveDof(Unit::new_unchecked(Vector3::new(0.0, 0.0, 1.1)));
    let axis = |min, max, step| {
        Some(Motion { x: Some(AxisRange { min, max, step }), ..Motion::default() })
    };
    let requirement = trackwright_simulation::Requirement::at_most([(Metric::ANGLE_MAX, -1.0)]);
    for (edit, message) in [
        (set(2, sensor("a", 0.0)), "the tool has no sensor 2, it has 2"),
        (
            set(0, sensor("b", 0.0)),
            "the tool already has a sensor named \"b\", expected another name",
        ),
        (set(0, sensor(" ", 0.0)), "the sensor's name is empty, expected a name"),
        (set(0, sensor("a", f64::NAN)), "the sensor's position is NaN, expected a finite number"),
        (set(0, bent), "the sensor's axis has length 1.1, expected 1"),
        (Edit::SetName(String::new()), "the design's name is empty, expected a name"),
        (
            Edit::SetToolPose(Pose::translation(0.0, f64::INFINITY, 0.0)),
            "the position is inf, expected a finite number",
        ),
        (
            Edit::SetTip { body: tool, tip_in_body: Some(Point3::new(f64::NAN, 0.0, 0.0)) },
            "the tip is NaN, expected a finite number",
        ),
        (Edit::SetMotion(axis(0.0, 1.0, -1.0)), "motion.x: step is -1, expected zero or more"),
        (
            Edit::SetOrientationWeight(Some(-1.0)),
            "the orientation weight is -1, expected zero or more",
        ),
        (Edit::SetRequirement(Some(requirement)), "angle_max is -1, expected zero or more"),
        (set_mesh(MeshReference::new(" ")), "the mesh's file is empty, expected a name"),
        (
            set_mesh(MeshReference {
                unit: Some(MeshUnit::Factor(0.0)),
                ..MeshReference::new("a.stl")
            }),
            "the mesh's unit is 0, expected a number above zero",
        ),
        (
            set_mounting(Mounting { least_gap_mm: Some(f64::NAN), ..channel() }),
            "least_gap is NaN, expected zero or more",
        ),
        (
            set_mounting(Mounting {
                regions: vec![MountingRegion::Surface {
                    axis: MountingAxis::Along,
                    boxes: Vec::new(),
                }],
                ..Mounting::default()
            }),
            "mounting[0].axis is Along, expected Free or Normal or Tangent or AsItIs for a surface",
        ),
        (
            Edit::SetEnvironment { file: String::new(), metal: None },
            "the environment's file is empty, expected a name",
        ),
    ] {
        let mut document = document();
        assert_eq!(document.apply(edit).unwrap_err().to_string(), message);
        assert_eq!((document.design(), document.revision()), (&design(), 0));
        assert_eq!(document.undo_label(), None);
    }
}

#[test]
fn the_last_sensor_and_a_missing_crf_are_refused() {
    let mut document = document();
    let remove = Edit::RemoveSensor { body: BodyRole::Tool, index: 0 };
    document.apply(remove.clone()).unwrap();
    assert_eq!(document.apply(remove), Err(EditError::LastSensor));
    let mut without = design();
    without.crf = None;
    let mut document = Document::new(without, View::default(), Origin::BuiltIn("x"));
    let edit = Edit::SetCrfPose(Pose::identity());
    assert_eq!(document.apply(edit), Err(EditError::NoCrf));
}

#[test]
fn arranging_is_one_named_step() {
    let row = Arrangement::Array { count: 3, spacing_mm: 5.0, direction_in_body: Vector3::y() };
    for (edit, label, names) in [
        (arrange(&[1], Arrangement::Duplicate), "Duplicate sensor b", vec!["a", "b", "b 2"]),
        (
            arrange(&[1, 0, 1], Arrangement::MirrorCopy(MirrorPlane::Z)),
            "Mirror copy of 2 sensors",
            vec!["a", "b", "a 2", "b 2"],
        ),
        (arrange(&[0], row), "Array of 3 sensors", vec!["a", "b", "a 2", "a 3"]),
        (arrange(&[0], Arrangement::MakeSixDof), "Make sensor a 6-DOF", vec!["a", "b"]),
        (arrange(&[0, 1], Arrangement::MakeMarker), "Make 2 sensors markers", vec!["a", "b"]),
        (
            Edit::AddSensors {
                body: BodyRole::Tool,
                sensors: vec![sensor("c", 1.0), sensor("d", 2.0)],
            },
            "Add 2 sensors",
            vec!["a", "b", "c", "d"],
        ),
        (
            Edit::RemoveSensors { body: BodyRole::Tool, indices: vec![1, 1] },
            "Remove sensor b",
            vec!["a"],
        ),
    ] {
        let mut document = document();
        assert!(document.apply(edit).unwrap());
        assert_eq!(tool_names(&document), names);
        assert_eq!(document.undo().as_deref(), Some(label));
        assert_eq!(document.design(), &design());
    }
}

#[test]
fn several_sensors_move_at_once() {
    let mut document = document();
    let edit = |sensors| Edit::SetSensors { body: BodyRole::Tool, sensors };
    let swap = edit(vec![(0, sensor("b", 50.0)), (1, sensor("a", 0.1))]);
    assert!(document.apply(swap).unwrap());
    assert_eq!(tool_names(&document), ["b", "a"]);
    assert_eq!(document.undo_label(), Some("Move 2 sensors"));
    let error = document.apply(edit(vec![(0, sensor("c", 0.0)), (1, sensor("c", 0.0))]));
    assert!(matches!(error, Err(EditError::DuplicateSensorName { .. })), "{error:?}");
    assert_eq!(tool_names(&document), ["b", "a"]);
}

#[test]
fn a_crf_has_its_own_targets_and_study() {
    let target = |name: &str, x_mm| Target {
        name: name.to_owned(),
        position_in_crf: Point3::new(x_mm, 0.0, 0.0),
    };
    let set = |target| Edit::SetTarget { index: 0, target };
    let motion = |step| {
        Edit::SetCrfMotion(Some(Motion {
            x: Some(AxisRange { min: 0.0, max: 1.0, step }),
            ..Motion::default()
        }))
    };
    let rename = Edit::SetBodyName { body: BodyRole::Crf, name: "headband".to_owned() };
    let requirement = Edit::SetCrfRequirement(Some(Default::default()));
    let steps = [
        (Edit::AddTarget(target("sinus", 1.0)), "Add target sinus"),
        (set(target("sinus", 2.0)), "Move target sinus"),
        (set(target("left sinus", 2.0)), "Rename target sinus"),
        (motion(0.5), "Change range of motion of CRF"),
        (requirement.clone(), "Change requirement of CRF"),
        (rename.clone(), "Rename CRF"),
        (Edit::RemoveTarget { index: 0 }, "Remove target left sinus"),
    ];
    let mut document = document();
    for (edit, label) in &steps {
        assert!(document.apply(edit.clone()).unwrap(), "{label}");
        assert_eq!(document.undo_label(), Some(*label));
    }
    let crf = document.design().crf.as_ref().unwrap();
    assert_eq!(crf.body.rigid.name, "headband");
    assert!(crf.motion.is_some() && crf.requirement.is_some() && crf.targets.is_empty());

    document.apply(Edit::AddTarget(target("sinus", 1.0))).unwrap();
    for (edit, message) in [
        (set(target("sinus", f64::NAN)), "the target is NaN, expected a finite number"),
        (
            Edit::AddTarget(target("sinus", 2.0)),
            "the CRF already has a target named \"sinus\", expected another name",
        ),
        (Edit::AddTarget(target("", 2.0)), "the target's name is empty, expected a name"),
        (Edit::RemoveTarget { index: 1 }, "the CRF has no target 1, it has 1"),
        (motion(-1.0), "crf.motion.x: step is -1, expected zero or more"),
    ] {
        assert_eq!(document.apply(edit).unwrap_err().to_string(), message);
    }
    let mut without = design();
    without.crf = None;
    for (edit, _) in steps {
        let mut document = Document::new(without.clone(), View::default(), Origin::BuiltIn("x"));
        assert_eq!(document.apply(edit), Err(EditError::NoCrf));
    }
}
