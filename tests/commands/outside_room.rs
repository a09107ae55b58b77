//! Positions outside a room's box are counted and reported by every command that evaluates it there.

use crate::support::data::own;
use crate::support::golden::number;
use crate::support::program::Scratch;
use crate::support::table::{points_table, poses_table};
use nalgebra::{Point3, UnitQuaternion, Vector3};
use trackwright_geometry::bounds::Bounds;
use trackwright_geometry::pose::{Pose, pose_from_parts};
use trackwright_result::with_separators;

/// A room without errors, whose box is that of its measurements.
fn room() -> (Scratch, Bounds) {
    let scratch = Scratch::new();
    scratch.fit("room.env.ron", "--order 0");
    let bounds = *scratch.environment("room.env.ron").model.bounds();
    (scratch, bounds)
}

/// Poses of a tool that turns about a point on the box's side, 80 mm from its sensor.
fn rotations(bounds: &Bounds) -> Vec<Pose> {
    let mut pivot = bounds.center_mm();
    pivot.x = bounds.max_mm.x;
    let poses = (0..24).map(|k| {
        let turn = Vector3::new(f64::from(k % 5) - 2.0, f64::from(k % 7) - 3.0, 0.0) * 0.2;
        let rotation = UnitQuaternion::from_scaled_axis(turn);
        pose_from_parts(pivot.coords + rotation * Vector3::new(0.0, 0.0, 80.0), rotation)
    });
    poses.collect()
}

/// How many poses are outside the box.
fn outside(poses: &[Pose], bounds: &Bounds) -> usize {
    poses.iter().filter(|pose| !bounds.contains(&pose.translation.vector.into())).count()
}

#[test]
fn pivot_can_leave_outside_readings_out() {
    let (scratch, bounds) = room();
    let poses = rotations(&bounds);
    let outside = outside(&poses, &bounds);
    assert!((5..20).contains(&outside), "{outside}");
    scratch.write("poses.csv", poses_table(poses));
    let pivot = "pivot poses.csv --environment room.env.ron --min-poses 3";
    let (found, notes) = scratch.json_and_notes(pivot);
    assert_eq!(found["compensated"]["outside"], outside);
    assert_eq!((&found["poses"], &found["compensated"]["rejected"]), (&24.into(), &0.into()));
    let expected = "of 24 poses of poses.csv are outside the room's box: the nearest point";
    assert!(notes.contains(&format!("warning: {outside} {expected}")), "{notes}");
    let (found, notes) = scratch.json_and_notes(format!("{pivot} --outside reject"));
    assert_eq!(found["poses"], 24 - outside);
    assert_eq!(found["compensated"]["rejected"], outside);
    assert!(notes.contains("outside the room's box: they are left out"), "{notes}");
    assert!(number(&found["rms_mm"]) < 1e-6);
    let (found, notes) = scratch.json_and_notes("pivot poses.csv");
    assert!(found.get("compensated").is_none() && !notes.contains("outside"), "{notes}");
}

#[test]
fn frames_with_outside_markers_are_left_out() {
    let (scratch, bounds) = room();
    let markers = [[0.0, 0.0, 0.0], [12.0, 0.0, 0.0], [0.0, 9.0, 4.0]].map(Point3::from);
    let poses = rotations(&bounds);
    let mut text = format!("3, {}, a-empivot.txt\n", poses.len());
    let mut kept = 0;
    for pose in &poses {
        let seen = markers.map(|marker| pose * marker);
        kept += usize::from(seen.iter().all(|marker| bounds.contains(marker)));
        text += &points_table(seen).replace(',', ", ");
    }
    assert!((3..20).contains(&kept), "{kept}");
    scratch.write("a-empivot.txt", text);
    let reject = "--environment room.env.ron --outside reject";
    let (found, notes) =
        scratch.json_and_notes(format!("pivot a-empivot.txt --min-poses 3 {reject}"));
    assert_eq!(found["poses"], kept);
    assert_eq!(found["compensated"]["rows"], 72);
    let expected = format!("a-empivot.txt: {} of 24 frames not used", 24 - kept);
    assert!(notes.contains(&expected), "{notes}");
    scratch.write("b-empivot.txt", "3, 1, b-empivot.txt\n0, 0, 5000\n9, 0, 5000\n0, 9, 5000\n");
    let words = ["found no frame of 1 whose markers the room corrects"];
    scratch.refused(format!("pivot b-empivot.txt {reject}"), &words);
}

#[test]
fn distort_and_fit_report_how_many_are_outside() {
    let (scratch, bounds) = room();
    let poses = rotations(&bounds);
    let expected = outside(&poses, &bounds);
    scratch.write("poses.csv", poses_table(poses));
    let notes = scratch.notes("distort room.env.ron poses.csv -o out.csv");
    let expected = format!("warning: {expected} of 24 poses are outside the room's box");
    assert!(notes.starts_with(&expected), "{notes}");
    let holdout = own("room-a/room-a-holdout.csv");
    let samples =
        trackwright_project::Files::default().read_measurements(&holdout).unwrap().measurements;
    let places: Vec<_> = samples.iter().map(|row| row.tracker_from_ideal).collect();
    let outside = outside(&places, &bounds);
    let all = with_separators(samples.len());
    let expected = format!("warning: {outside} of {all} held-out samples are outside");
    assert!(outside > 0);
    let fit = "fit own:room-a/room-a-fit.csv -o fitted.env.ron --order 0 --holdout";
    scratch.notes_with(format!("{fit} {}", holdout.display()), &[&expected]);
}
