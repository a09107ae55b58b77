//! Points in two frames: what the registration reports, and what it refuses.

use crate::support::golden::{number, numbers};
use crate::support::program::Scratch;
use crate::support::table::points_table;
use nalgebra::{Point3, Vector3};
use trackwright_geometry::pose::{Pose, pose_from_array};

pub const POINTS: [[f64; 3]; 5] =
    [[0.0, 0.0, 0.0], [80.0, 0.0, 10.0], [0.0, 60.0, -5.0], [20.0, 30.0, 90.0], [70.0, 50.0, 40.0]];

fn pose() -> Pose {
    pose_from_array([12.0, -40.0, 300.0, 0.7, 0.1, -0.6, 0.3]).unwrap()
}

fn write(scratch: &Scratch, name: &str, points: impl IntoIterator<Item = Point3<f64>>) {
    scratch.write(name, points_table(points).replace(',', " "));
}

#[test]
fn exact_points_give_the_exact_pose() {
    let scratch = Scratch::new();
    write(&scratch, "source.txt", POINTS.map(Point3::from));
    write(&scratch, "target.txt", POINTS.map(|p| pose() * Point3::from(p)));
    write(&scratch, "at.txt", [Point3::new(5.0, 6.0, 200.0)]);
    let register = "register source.txt target.txt --at at.txt -o moved.csv";
    let found = scratch.json(format!("{register} --transform pose.csv"));
    assert_eq!(found["points"], 5);
    assert!(number(&found["fre_rms_mm"]) < 1e-12);
    let there = pose_from_array(numbers(&found["target_from_source"])).unwrap();
    assert!((there.translation.vector - pose().translation.vector).norm() < 1e-10);
    assert!(there.rotation.angle_to(&pose().rotation) < 1e-12);
    assert_eq!(scratch.poses("pose.csv").len(), 1);
    let expected = pose() * Point3::new(5.0, 6.0, 200.0);
    assert!((scratch.points("moved.csv")[0] - expected).norm() < 1e-9);
    scratch.succeed("export poses pose.csv -o pose.tfm");
}

#[test]
fn the_expected_error_grows_with_distance() {
    let scratch = Scratch::new();
    write(&scratch, "points.txt", POINTS.map(Point3::from));
    let mean = Point3::new(34.0, 28.0, 27.0);
    let away = [0.0, 100.0, 400.0].map(|x| mean + Vector3::new(x, 0.0, 0.0));
    write(&scratch, "at.txt", away);
    let files = "points.txt points.txt --at at.txt -o moved.csv";
    scratch.json(format!("register {files} --fle-mm 0.5"));
    let moved = scratch.table("moved.csv");
    let tre = moved.numbers(moved.columns.last().unwrap());
    // In the middle only the shift is off: by FLE over the root of the number of points.
    assert!((tre[0] - 0.5 / 5.0_f64.sqrt()).abs() < 1e-9, "{tre:?}");
    assert!(tre[0] < tre[1] && tre[1] < tre[2] && tre[2] > 1.0, "{tre:?}");
}

#[test]
fn undetermined_points_are_refused() {
    let scratch = Scratch::new();
    write(&scratch, "all.txt", POINTS.map(Point3::from));
    write(&scratch, "two.txt", POINTS[..2].iter().map(|p| Point3::from(*p)));
    let line = |bend: f64| {
        let at = |i: u8| Point3::new(10.0 * f64::from(i), bend * f64::from(i % 2), 0.0);
        (0..6).map(at).collect::<Vec<_>>()
    };
    write(&scratch, "straight.txt", line(0.0));
    // Bent by less than the points are off.
    write(&scratch, "bent.txt", line(0.4));
    let noisy = (0..).zip(line(0.4)).map(|(i, p)| {
        p + Vector3::new(f64::from(i * i % 5), f64::from(i * 3 % 4), f64::from(i % 3)) * 0.4
    });
    write(&scratch, "noisy.txt", noisy);
    for (files, words) in [
        ("two.txt two.txt", "2 points, expected at least 3"),
        ("two.txt all.txt", "2 source points but 5 target points"),
        ("straight.txt straight.txt", "the points lie on one line"),
        ("bent.txt noisy.txt", "the rotation about it is known to"),
    ] {
        scratch.refused(format!("register {files}"), &[words]);
    }
    let accepted = scratch.json("register bent.txt noisy.txt --max-turn-error-deg 180");
    assert!(number(&accepted["turn_std_error_deg"]) > 10.0);
}
