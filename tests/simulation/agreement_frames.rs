//! Recordings of a built tool in different frames are recognised.

use crate::support::studies::default_design;
use nalgebra::{UnitQuaternion, Vector3};
use trackwright_calibration::agreement::*;
use trackwright_field::random_models::Seeded;
use trackwright_geometry::pose::{Pose, pose_from_parts};
use trackwright_simulation::Scenario;
use trackwright_task::Task;

fn scenario() -> Scenario {
    Scenario { crf: None, ..default_design() }
}

/// Poses about the middle of the room, measured as the room has it and then in another frame.
fn rows(scenario: &Scenario, other_from_tracker: &Pose) -> Vec<AgreementRow> {
    let middle = scenario.environment.model.bounds().center_mm().coords;
    let at_middle = pose_from_parts(middle, UnitQuaternion::identity());
    let mut noise = Seeded::new(3);
    let recorded = |pose: Pose, measured: Pose| RecordedPose {
        tracker_from_crf: None,
        crf_from_tool: pose,
        crf_from_tool_measured: measured,
        group: 0,
    };
    let truth: Vec<Pose> = (0..40).map(|_| at_middle * noise.pose_within(80.0)).collect();
    let first: Vec<_> = truth.iter().map(|pose| recorded(*pose, *pose)).collect();
    let predicted = paired_rows(scenario, &first, &Task::default()).unwrap();
    let each = truth.iter().zip(&predicted).map(|(pose, row)| {
        let shifted = pose_from_parts(pose.translation.vector + row.predicted_mm, pose.rotation);
        recorded(*pose, other_from_tracker * shifted)
    });
    paired_rows(scenario, &each.collect::<Vec<_>>(), &Task::default()).unwrap()
}

#[test]
fn errors_of_the_field_are_no_matter_of_frames() {
    let scenario = scenario();
    assert_eq!(frame_mismatch(&scenario, &rows(&scenario, &Pose::identity())), None);
    // As far as the median of a part of any room.
    let shift = pose_from_parts(Vector3::new(0.0, 15.7, 0.0), UnitQuaternion::identity());
    assert_eq!(frame_mismatch(&scenario, &rows(&scenario, &shift)), None);
}

#[test]
fn a_frame_mismatch_reports_rotation_and_translation() {
    let scenario = scenario();
    let turn = UnitQuaternion::from_axis_angle(&Vector3::x_axis(), 0.5);
    let other = pose_from_parts(Vector3::new(300.0, -20.0, 100.0), turn);
    let found = frame_mismatch(&scenario, &rows(&scenario, &other)).unwrap();
    let FrameMismatch::Apart { common: Some(common), predicted_max_mm, .. } = &found else {
        panic!("{found:?}");
    };
    assert!(common.explains());
    // What is left is no more than what the field does.
    assert!(common.left_rms_mm <= *predicted_max_mm, "{found:?}");
    assert!((common.turn_deg - 0.5_f64.to_degrees()).abs() < 3.0, "{found:?}");
    let text = found.to_string();
    assert!(text.contains("different frames"), "{text}");
}

#[test]
fn rows_of_other_moments_are_apart_in_every_frame() {
    let scenario = scenario();
    let mut mixed = rows(&scenario, &Pose::identity());
    let tips: Vec<_> = mixed.iter().map(|row| tip_in_crf(row, &scenario)).collect();
    let count = tips.len();
    for (k, row) in mixed.iter_mut().enumerate() {
        row.measured_mm += tips[(7 * k + 3) % count] - tips[k];
    }
    let found = frame_mismatch(&scenario, &mixed).unwrap();
    let text = found.to_string();
    assert!(text.contains("no common frame explains it"), "{text}");
}

#[test]
fn poses_far_outside_the_room_are_a_frame_mismatch() {
    let scenario = scenario();
    let mut away = rows(&scenario, &Pose::identity());
    for row in &mut away {
        row.crf_from_tool.translation.vector.x += 2000.0;
        row.outside = 1;
    }
    let found = frame_mismatch(&scenario, &away).unwrap();
    assert!(matches!(found, FrameMismatch::NotInRoom { .. }), "{found}");
}
