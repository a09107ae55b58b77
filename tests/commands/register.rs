//! Points in two frames: what the registration reports, and what it refuses.

use crate::support::golden::{number, numbers};
use crate::support::program::{Scratch, json};
use nalgebra::{Point3, Vector3};
use std::fs;
use trackwright_geometry::pose::{Pose, pose_from_array};

const POINTS: [[f64; 3]; 5] =
    [[0.0, 0.0, 0.0], [80.0, 0.0, 10.0], [0.0, 60.0, -5.0], [20.0, 30.0, 90.0], [70.0, 50.0, 40.0]];

fn pose() -> Pose {
    pose_from_array([12.0, -40.0, 300.0, 0.7, 0.1, -0.6, 0.3]).unwrap()
}

fn write(scratch: &Scratch, name: &str, points: impl IntoIterator<Item = Point3<f64>>) -> String {
    let rows = points.into_iter().map(|p| format!("{} {} {}\n", p.x, p.y, p.z));
    scratch.write(name, rows.collect::<String>());
    scratch.arg(name)
}

#[test]
fn exact_points_give_the_exact_pose() {
    let scratch = Scratch::new();
    let source = write(&scratch, "source.txt", POINTS.map(Point3::from));
    let target = write(&scratch, "target.txt", POINTS.map(|p| pose() * Point3::from(p)));
    let at = write(&scratch, "at.txt", [Point3::new(5.0, 6.0, 200.0)]);
    let (moved, transform) = (scratch.arg("moved.csv"), scratch.arg("pose.csv"));
    let found = scratch
        .json(format!("register {source} {target} --at {at} -o {moved} --transform {transform}"));
    assert_eq!(found["points"], 5);
    assert!(number(&found["fre_rms_mm"]) < 1e-12);
    let there = pose_from_array(numbers(&found["target_from_source"])).unwrap();
    assert!((there.translation.vector - pose().translation.vector).norm() < 1e-10);
    assert!(there.rotation.angle_to(&pose().rotation) < 1e-12);
    assert_eq!(
        trackwright_project::Files::default()
            .read_poses(transform.as_ref())
            .unwrap()
            .as_it_stands()
            .len(),
        1
    );
    let expected = pose() * Point3::new(5.0, 6.0, 200.0);
    let found =
        trackwright_project::Files::default().read_points(moved.as_ref()).unwrap().as_it_stands();
    assert!((found[0] - expected).norm() < 1e-9);
    scratch.succeed(format!("export poses {transform} -o pose.tfm"));
}

#[test]
fn the_expected_error_grows_with_distance() {
    let scratch = Scratch::new();
    let source = write(&scratch, "source.txt", POINTS.map(Point3::from));
    let target = write(&scratch, "target.txt", POINTS.map(Point3::from));
    let mean = Point3::new(34.0, 28.0, 27.0);
    let away = [0.0, 100.0, 400.0].map(|x| mean + Vector3::new(x, 0.0, 0.0));
    let (at, moved) = (write(&scratch, "at.txt", away), scratch.arg("moved.csv"));
    scratch.json(format!("register {source} {target} --at {at} -o {moved} --fle-mm 0.5"));
    let table = fs::read_to_string(&moved).unwrap();
    let tre: Vec<f64> = table
        .lines()
        .skip(1)
        .map(|line| line.rsplit(',').next().unwrap().parse().unwrap())
        .collect();
    // In the middle only the shift is off: by FLE over the root of the number of points.
    assert!((tre[0] - 0.5 / 5.0_f64.sqrt()).abs() < 1e-9, "{tre:?}");
    assert!(tre[0] < tre[1] && tre[1] < tre[2] && tre[2] > 1.0, "{tre:?}");
}

#[test]
fn undetermined_points_are_refused() {
    let scratch = Scratch::new();
    let all = write(&scratch, "all.txt", POINTS.map(Point3::from));
    let two = write(&scratch, "two.txt", POINTS[..2].iter().map(|p| Point3::from(*p)));
    let line = |bend: f64| {
        let at = |i: u8| Point3::new(10.0 * f64::from(i), bend * f64::from(i % 2), 0.0);
        (0..6).map(at).collect::<Vec<_>>()
    };
    let straight = write(&scratch, "straight.txt", line(0.0));
    // Bent by less than the points are off.
    let bent = write(&scratch, "bent.txt", line(0.4));
    let noisy = (0..).zip(line(0.4)).map(|(i, p)| {
        p + Vector3::new(f64::from(i * i % 5), f64::from(i * 3 % 4), f64::from(i % 3)) * 0.4
    });
    let noisy = write(&scratch, "noisy.txt", noisy);
    for (source, target, words) in [
        (&two, &two, "2 points, expected at least 3"),
        (&two, &all, "2 source points but 5 target points"),
        (&straight, &straight, "the points lie on one line"),
        (&bent, &noisy, "the rotation about it is known to"),
    ] {
        let error = scratch.fail(format!("register {source} {target}"));
        assert!(error.contains(words), "{error}");
    }
    let accepted = ["register", &bent, &noisy, "--max-turn-error-deg", "180"];
    assert!(number(&json(&accepted)["turn_std_error_deg"]) > 10.0);
}
