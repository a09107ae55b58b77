//! Edits and history: what is refused, what comes back, what counts as saved.

use super::*;
use crate::geometry::mesh_reference::{MeshReference, MeshUnit};
use crate::geometry::pose::Pose;
use crate::study::motion::{AxisRange, Motion};
use crate::tracking::body::{Coil, RigidBody, Sensor, SensorOrientation};
use nalgebra::{Point3, Unit, Vector3};
use proptest::prelude::*;

fn sensor(name: &str, z_mm: f64) -> Sensor {
    Sensor {
        name: name.to_owned(),
        position_in_body: Point3::new(0.0, 0.0, z_mm),
        orientation: SensorOrientation::FiveDof(Vector3::z_axis()),
        coil: None,
    }
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
    }
}

fn design() -> Design {
    Design {
        name: "design".to_owned(),
        environment: "room.env.ron".to_owned(),
        crf: Some(CrfPlacement {
            body: body("crf.body.ron"),
            tracker_from_crf: Pose::translation(0.0, 0.0, -300.0),
            targets: Vec::new(),
            motion: None,
            requirement: None,
        }),
        tool: ToolPlacement {
            body: body("tool.body.ron"),
            crf_from_tool: Pose::translation(0.0, 20.0, 0.0),
        },
        motion: None,
        orientation_weight_mm: None,
        requirement: None,
    }
}

fn document() -> Document {
    Document::new(
        design(),
        View::default(),
        Origin::File("x.design.ron".into()),
    )
}

fn move_to(z_mm: f64) -> Edit {
    Edit::SetSensor {
        body: BodyRole::Tool,
        index: 0,
        sensor: sensor("a", z_mm),
    }
}

fn set_mesh(mesh: MeshReference) -> Edit {
    Edit::SetMesh {
        body: BodyRole::Tool,
        mesh: Some(mesh),
    }
}

fn z_mm(document: &Document) -> f64 {
    document.design().tool.body.rigid.sensors[0]
        .position_in_body
        .z
}

#[test]
fn the_tool_goes_by_way_of_the_crf_where_there_is_one() {
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
fn a_drag_is_one_step_and_undo_restores_it_to_the_bit() {
    let mut document = document();
    document.begin("Drag sensor a");
    for step in 1..=10 {
        assert!(
            document
                .apply(move_to(0.1 + 0.1 * f64::from(step)))
                .unwrap()
        );
    }
    assert!(document.commit());
    assert!(document.is_dirty());
    let dragged = z_mm(&document);
    assert_eq!(document.undo().as_deref(), Some("Drag sensor a"));
    assert_eq!(z_mm(&document).to_bits(), 0.1_f64.to_bits());
    assert!(!document.is_dirty());
    assert_eq!(document.undo(), None);
    assert_eq!(document.redo_label(), Some("Drag sensor a"));
    assert_eq!(document.redo().as_deref(), Some("Drag sensor a"));
    assert_eq!(z_mm(&document).to_bits(), dragged.to_bits());
}

#[test]
fn cancel_takes_a_step_back_and_leaves_no_trace() {
    let mut document = document();
    document.begin("Drag");
    document.apply(move_to(9.0)).unwrap();
    assert!(document.is_in_step());
    assert!(document.undo().is_none() && document.redo().is_none());
    let revision = document.revision();
    assert!(document.cancel());
    assert!(document.revision() > revision);
    assert_eq!(document.design(), &design());
    assert_eq!(document.undo_label(), None);
    assert!(!document.is_in_step() && !document.is_dirty() && !document.cancel());
}

#[test]
fn a_step_that_ends_where_it_began_is_none() {
    let mut document = document();
    document.begin("Drag");
    document.apply(move_to(9.0)).unwrap();
    document.apply(move_to(0.1)).unwrap();
    assert!(!document.commit());
    assert_eq!(document.undo_label(), None);
    assert!(!document.apply(move_to(0.1)).unwrap());
}

#[test]
fn a_cancelled_or_empty_step_keeps_what_can_be_redone_and_a_new_edit_does_not() {
    let mut document = document();
    document.apply(move_to(1.0)).unwrap();
    document.undo();
    document.begin("Drag");
    document.apply(move_to(2.0)).unwrap();
    document.cancel();
    assert_eq!(document.redo_label(), Some("Move sensor a"));
    document.apply(move_to(3.0)).unwrap();
    assert_eq!(document.redo_label(), None);
}

#[test]
fn a_step_that_begins_within_another_ends_it() {
    let mut document = document();
    document.begin("First");
    document.apply(move_to(1.0)).unwrap();
    document.begin("Second");
    document.apply(move_to(2.0)).unwrap();
    document.cancel();
    assert_eq!(z_mm(&document), 1.0);
    assert_eq!(document.undo_label(), Some("First"));
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
fn undo_past_a_save_is_dirty_and_redo_to_it_clean() {
    let mut document = document();
    document.apply(move_to(1.0)).unwrap();
    document.mark_saved();
    assert!(!document.is_dirty());
    document.undo();
    assert!(document.is_dirty());
    document.redo();
    assert!(!document.is_dirty());
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

#[test]
fn edits_say_what_they_do() {
    let design = design();
    let label = |edit: Edit| edit.label_for(&design);
    let set = |sensor| Edit::SetSensor {
        body: BodyRole::Tool,
        index: 0,
        sensor,
    };
    assert_eq!(label(move_to(1.0)), "Move sensor a");
    assert_eq!(label(set(sensor("c", 0.1))), "Rename sensor a");
    let mut with_coil = sensor("a", 0.1);
    with_coil.coil = Some(Coil {
        diameter_mm: 0.8,
        length_mm: 9.0,
    });
    assert_eq!(label(set(with_coil)), "Change sensor a");
    let remove = Edit::RemoveSensor {
        body: BodyRole::Crf,
        index: 1,
    };
    assert_eq!(label(remove), "Remove sensor b");
    let mesh = set_mesh(MeshReference::new("a.stl"));
    assert_eq!(label(mesh), "Change tool's mesh");
}

#[test]
fn edits_that_cannot_be_are_refused_and_change_nothing() {
    let tool = BodyRole::Tool;
    let set = |index, sensor| Edit::SetSensor {
        body: tool,
        index,
        sensor,
    };
    let mut bent = sensor("a", 0.0);
    bent.orientation = SensorOrientation::FiveDof(Unit::new_unchecked(Vector3::new(0.0, 0.0, 1.1)));
    let axis = |min, max, step| {
        Some(Motion {
            x: Some(AxisRange { min, max, step }),
            ..Motion::default()
        })
    };
    let requirement = crate::study::requirement::Requirement {
        angle_max_deg: Some(-1.0),
        ..Default::default()
    };
    for (edit, message) in [
        (
            set(2, sensor("a", 0.0)),
            "the tool has no sensor 2, it has 2",
        ),
        (
            set(0, sensor("b", 0.0)),
            "the tool already has a sensor named \"b\", expected another name",
        ),
        (
            set(0, sensor(" ", 0.0)),
            "the sensor's name is empty, expected a name",
        ),
        (
            set(0, sensor("a", f64::NAN)),
            "the sensor's position is NaN, expected a finite number",
        ),
        (set(0, bent), "the sensor's axis has length 1.1, expected 1"),
        (
            Edit::SetName(String::new()),
            "the design's name is empty, expected a name",
        ),
        (
            Edit::SetToolPose(Pose::translation(0.0, f64::INFINITY, 0.0)),
            "the position is inf, expected a finite number",
        ),
        (
            Edit::SetTip {
                body: tool,
                tip_in_body: Some(Point3::new(f64::NAN, 0.0, 0.0)),
            },
            "the tip is NaN, expected a finite number",
        ),
        (
            Edit::SetMotion(axis(0.0, 1.0, -1.0)),
            "motion.x: step is -1, expected zero or more",
        ),
        (
            Edit::SetOrientationWeight(Some(-1.0)),
            "the orientation weight is -1, expected zero or more",
        ),
        (
            Edit::SetRequirement(Some(requirement)),
            "angle_max is -1, expected zero or more",
        ),
        (
            set_mesh(MeshReference::new(" ")),
            "the mesh's file is empty, expected a name",
        ),
        (
            set_mesh(MeshReference {
                unit: Some(MeshUnit::Factor(0.0)),
                ..MeshReference::new("a.stl")
            }),
            "the mesh's unit is 0, expected a number above zero",
        ),
        (
            Edit::SetEnvironment(String::new()),
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
fn a_body_keeps_its_last_sensor_and_a_design_without_crf_has_none_to_edit() {
    let mut document = document();
    let remove = Edit::RemoveSensor {
        body: BodyRole::Tool,
        index: 0,
    };
    document.apply(remove.clone()).unwrap();
    assert_eq!(document.apply(remove), Err(EditError::LastSensor));
    let mut without = design();
    without.crf = None;
    let mut document = Document::new(without, View::default(), Origin::BuiltIn("x"));
    let edit = Edit::SetCrfPose(Pose::identity());
    assert_eq!(document.apply(edit), Err(EditError::NoCrf));
}

/// Anything a person can do to a document.
#[derive(Clone, Debug)]
enum Act {
    Apply(f64),
    Begin,
    Commit,
    Cancel,
    Undo,
    Redo,
}

fn act() -> impl Strategy<Value = Act> {
    prop_oneof![
        3 => (0..5).prop_map(|z| Act::Apply(f64::from(z) / 3.0)),
        1 => Just(Act::Begin),
        1 => Just(Act::Commit),
        1 => Just(Act::Cancel),
        2 => Just(Act::Undo),
        1 => Just(Act::Redo),
    ]
}

proptest! {
    /// Undoing everything gives the first state, redoing everything the last, and the revision
    /// grows exactly when the design changes.
    #[test]
    fn any_history_can_be_walked_back_and_forth(acts in prop::collection::vec(act(), 0..60)) {
        let mut document = document();
        for act in acts {
            let before = (document.design().clone(), document.revision());
            match act {
                Act::Apply(z) => { document.apply(move_to(z)).unwrap(); }
                Act::Begin => document.begin("step"),
                Act::Commit => { document.commit(); }
                Act::Cancel => { document.cancel(); }
                Act::Undo => { document.undo(); }
                Act::Redo => { document.redo(); }
            }
            prop_assert!(document.revision() >= before.1);
            if *document.design() != before.0 {
                prop_assert!(document.revision() > before.1);
            }
        }
        document.commit();
        while document.redo().is_some() {}
        let last = document.design().clone();
        let mut steps = 0;
        while document.undo().is_some() { steps += 1; }
        prop_assert_eq!(document.design(), &design());
        prop_assert!(!document.is_dirty());
        for _ in 0..steps { document.redo(); }
        prop_assert_eq!(document.design(), &last);
    }
}
