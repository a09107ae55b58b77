//! Positions outside a room's box are counted and reported by every command that evaluates it there.

use crate::support::data::own;
use crate::support::golden::number;
use crate::support::program::{Scratch, run_within, text, trackwright};
use nalgebra::{Point3, UnitQuaternion, Vector3};
use serde_json::Value;
use std::fmt::Write;
use std::fs;
use std::time::Duration;
use trackwright_geometry::bounds::Bounds;
use trackwright_simulation::figures::with_separators;

/// A room without errors, whose box is that of its measurements.
fn room(scratch: &Scratch) -> (String, Bounds) {
    let (table, file) = (text(&own("room-a/room-a-fit.csv")), scratch.arg("room.env.ron"));
    scratch.succeed(format!("fit {table} -o {file} --order 0"));
    let bounds = *trackwright_project::Files::default()
        .read_environment(file.as_ref())
        .unwrap()
        .model
        .bounds();
    (file, bounds)
}

/// Standard output as JSON, and standard error.
#[track_caller]
fn json_and_notes(args: &[&str]) -> (Value, String) {
    let args = [args, &["--format", "json"]].concat();
    let output = run_within(trackwright(&args), Duration::from_secs(60));
    let stderr = String::from_utf8(output.stderr).unwrap();
    assert!(output.status.success(), "{stderr}");
    (serde_json::from_slice(&output.stdout).unwrap(), stderr)
}

/// Poses of a tool that turns about a point on the box's side, 80 mm from its sensor.
fn rotations(bounds: &Bounds) -> Vec<(Point3<f64>, UnitQuaternion<f64>)> {
    let mut pivot = bounds.center_mm();
    pivot.x = bounds.max_mm.x;
    let poses = (0..24).map(|k| {
        let turn = Vector3::new(f64::from(k % 5) - 2.0, f64::from(k % 7) - 3.0, 0.0) * 0.2;
        let rotation = UnitQuaternion::from_scaled_axis(turn);
        (pivot + rotation * Vector3::new(0.0, 0.0, 80.0), rotation)
    });
    poses.collect()
}

fn poses_table(poses: &[(Point3<f64>, UnitQuaternion<f64>)]) -> String {
    let mut table = "x,y,z,qw,qx,qy,qz\n".to_owned();
    for (at, turn) in poses {
        let [x, y, z] = [at.x, at.y, at.z];
        let q = turn.quaternion();
        writeln!(table, "{x},{y},{z},{},{},{},{}", q.w, q.i, q.j, q.k).unwrap();
    }
    table
}

#[test]
fn pivot_can_leave_outside_readings_out() {
    let scratch = Scratch::new();
    let (room, bounds) = room(&scratch);
    let poses = rotations(&bounds);
    let outside = poses.iter().filter(|(at, _)| !bounds.contains(at)).count();
    assert!((5..20).contains(&outside), "{outside}");
    let file = scratch.arg("poses.csv");
    fs::write(&file, poses_table(&poses)).unwrap();
    let pivot = ["pivot", &file, "--environment", &room, "--min-poses", "3"];
    let (found, notes) = json_and_notes(&pivot);
    assert_eq!(found["compensated"]["outside"], outside);
    assert_eq!((&found["poses"], &found["compensated"]["rejected"]), (&24.into(), &0.into()));
    let expected = format!(
        "warning: {outside} of 24 poses of {file} are outside the room's box: the nearest point"
    );
    assert!(notes.contains(&expected), "{notes}");
    let (found, notes) = json_and_notes(&[&pivot[..], &["--outside", "reject"]].concat());
    assert_eq!(found["poses"], 24 - outside);
    assert_eq!(found["compensated"]["rejected"], outside);
    assert!(notes.contains("outside the room's box: they are left out"), "{notes}");
    assert!(number(&found["rms_mm"]) < 1e-6);
    let (found, notes) = json_and_notes(&["pivot", &file]);
    assert!(found.get("compensated").is_none() && !notes.contains("outside"), "{notes}");
}

#[test]
fn frames_with_outside_markers_are_left_out() {
    let scratch = Scratch::new();
    let (room, bounds) = room(&scratch);
    let markers = [[0.0, 0.0, 0.0], [12.0, 0.0, 0.0], [0.0, 9.0, 4.0]].map(Point3::from);
    let poses = rotations(&bounds);
    let mut text = format!("3, {}, a-empivot.txt\n", poses.len());
    let mut kept = 0;
    for (at, turn) in &poses {
        let seen = markers.map(|marker| at + turn * marker.coords);
        kept += usize::from(seen.iter().all(|marker| bounds.contains(marker)));
        for marker in seen {
            writeln!(text, "{}, {}, {}", marker.x, marker.y, marker.z).unwrap();
        }
    }
    assert!((3..20).contains(&kept), "{kept}");
    let file = scratch.arg("a-empivot.txt");
    fs::write(&file, text).unwrap();
    let pivot = ["pivot", &file, "--environment", &room, "--min-poses", "3"];
    let (found, notes) = json_and_notes(&[&pivot[..], &["--outside", "reject"]].concat());
    assert_eq!(found["poses"], kept);
    assert_eq!(found["compensated"]["rows"], 72);
    let expected = format!("{file}: {} of 24 frames not used", 24 - kept);
    assert!(notes.contains(&expected), "{notes}");
    scratch.write("b-empivot.txt", "3, 1, b-empivot.txt\n0, 0, 5000\n9, 0, 5000\n0, 9, 5000\n");
    let error = scratch.fail(format!("pivot b-empivot.txt --environment {room} --outside reject"));
    assert!(error.contains("found no frame of 1 whose markers the room corrects"), "{error}");
}

#[test]
fn distort_and_fit_report_how_many_are_outside() {
    let scratch = Scratch::new();
    let (room, bounds) = room(&scratch);
    let poses = rotations(&bounds);
    let outside = poses.iter().filter(|(at, _)| !bounds.contains(at)).count();
    let (file, out) = (scratch.arg("poses.csv"), scratch.arg("out.csv"));
    fs::write(&file, poses_table(&poses)).unwrap();
    let notes_of = |args: &[&str]| {
        let output = trackwright(args).output().unwrap();
        assert!(output.status.success());
        String::from_utf8(output.stderr).unwrap()
    };
    let notes = notes_of(&["distort", &room, &file, "-o", &out]);
    assert!(
        notes.starts_with(&format!("warning: {outside} of 24 poses are outside the room's box")),
        "{notes}"
    );
    let [fit, holdout] =
        ["fit", "holdout"].map(|kind| text(&own(&format!("room-a/room-a-{kind}.csv"))));
    let fitted = scratch.arg("fitted.env.ron");
    let notes = notes_of(&["fit", &fit, "-o", &fitted, "--order", "0", "--holdout", &holdout]);
    let samples = trackwright_project::Files::default()
        .read_measurements(holdout.as_ref())
        .unwrap()
        .measurements;
    let places = samples.iter().map(|row| Point3::from(row.tracker_from_ideal.translation.vector));
    let outside = places.filter(|at| !bounds.contains(at)).count();
    let all = with_separators(samples.len());
    let expected = format!("warning: {outside} of {all} held-out samples are outside");
    assert!(outside > 0 && notes.contains(&expected), "{outside}: {notes}");
}
