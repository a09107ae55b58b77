//! Which way a tool's shaft points, beside its tip or by itself.

use crate::support::golden::{number, numbers};
use crate::support::program::{Scratch, trackwright};
use nalgebra::{Point3, Unit, Vector3};
use std::fs;
use trackwright_formats::tool_definition::OnMismatch;
use trackwright_geometry::pose::{Pose, pose_from_parts, pose_to_array};
use trackwright_geometry::rotation::exp_vector;

const TIP: [f64; 3] = [40.0, -12.0, 150.0];

/// Of a tool whose sensor sits askew on it.
fn shaft() -> Unit<Vector3<f64>> {
    Unit::new_normalize(Vector3::new(0.25, -0.1, 0.95))
}

/// The tip rests in a point of the tracker; the tool turned from where it stands by a vector of its own
/// frame.
fn pose(turn: Vector3<f64>) -> Pose {
    let rotation = exp_vector(&Vector3::new(0.2, 0.9, -0.4)) * exp_vector(&turn);
    let tip = rotation * Vector3::from(TIP);
    pose_from_parts(Vector3::new(10.0, 20.0, -300.0) - tip, rotation)
}

fn write(scratch: &Scratch, name: &str, poses: impl Iterator<Item = Pose>) -> String {
    let rows = poses.map(|p| pose_to_array(&p).map(|v| v.to_string()).join(",") + "\n");
    let table = "x,y,z,qw,qx,qy,qz\n".to_owned() + &rows.collect::<String>();
    scratch.write(name, table);
    scratch.arg(name)
}

fn pivoted(scratch: &Scratch) -> String {
    let swings = (0..20).map(|i| {
        let (s, c) = (f64::from(i) * 2.4).sin_cos();
        pose(Vector3::new(s, c, 0.1) * 0.5)
    });
    write(scratch, "pivot.csv", swings)
}

fn spun(scratch: &Scratch) -> String {
    let turns = (0..40).map(|i| pose(shaft().into_inner() * (f64::from(i) * 0.1)));
    write(scratch, "spin.csv", turns)
}

#[test]
fn tip_and_shaft_come_from_one_command() {
    let scratch = Scratch::new();
    let (around, about) = (pivoted(&scratch), spun(&scratch));
    let found = scratch.json(format!("pivot {around} --spin {about}"));
    assert!((Point3::from(numbers::<3>(&found["tip"])) - Point3::from(TIP)).norm() < 1e-9);
    let alone = scratch.json(format!("pivot {around}"));
    for (key, value) in alone.as_object().unwrap() {
        assert_eq!(&found[key], value, "{key}");
    }
    let spin = &found["spin"];
    assert_eq!((&spin["poses"], &spin["towards_tip"]), (&40.into(), &true.into()));
    let there = Vector3::from(numbers::<3>(&spin["shaft"]));
    assert!((there - shaft().into_inner()).norm() < 1e-12);
    for key in ["rms_deg", "max_deg", "std_error_deg"] {
        assert!(number(&spin[key]) < 1e-9, "{key}");
    }
    let words = scratch.succeed(format!("pivot {around} --spin {about}"));
    assert!(words.contains("shaft towards the tip, tool's frame"), "{words}");
}

#[test]
fn a_stated_tip_settles_the_direction() {
    let scratch = Scratch::new();
    let about = spun(&scratch);
    let output = trackwright(&["pivot", "--spin", &about, "--format", "json"]).output().unwrap();
    let stderr = String::from_utf8(output.stderr).unwrap();
    assert!(stderr.contains("which of the two directions"), "{stderr}");
    let found: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(found["spin"]["towards_tip"], false);
    assert_eq!(found.as_object().unwrap().len(), 1);
    for (tip, sign) in [("0,0,100", 1.0), ("0,0,-100", -1.0)] {
        let found = scratch.json(format!("pivot --spin {about} --tip {tip}"));
        assert_eq!(found["spin"]["towards_tip"], true);
        let there = Vector3::from(numbers::<3>(&found["spin"]["shaft"]));
        assert!((there - shaft().into_inner() * sign).norm() < 1e-12, "{tip}");
    }
    let beside = scratch.fail(format!("pivot --spin {about} --tip 0,0,0 --tip-frame a.tfm"));
    assert!(beside.contains("a.tfm: which of the two directions"), "{beside}");
    let none = scratch.fail(format!("pivot --spin {about} --tip-frame a.tfm"));
    assert!(none.contains("--tip-frame: found no tip"), "{none}");
    let none = scratch.fail(format!("pivot --spin {about} --tips {about} -o tips.csv"));
    assert!(none.contains("--tips: found no tip"), "{none}");
    assert!(!scratch.has("a.tfm") && !scratch.has("tips.csv"));
}

#[test]
fn a_spin_has_refusals_and_limits_of_its_own() {
    let scratch = Scratch::new();
    let (around, about) = (pivoted(&scratch), spun(&scratch));
    let little = write(
        &scratch,
        "little.csv",
        (0..40).map(|i| pose(shaft().into_inner() * (f64::from(i) * 0.005))),
    );
    // Half of the turn is about another axis.
    let two_axes = write(
        &scratch,
        "two.csv",
        (0..40).map(|i| match f64::from(i) * 0.1 {
            turn if turn < 2.0 => pose(shaft().into_inner() * turn),
            turn => pose(Vector3::y() * (turn - 2.0)),
        }),
    );
    for (args, expected) in [
        (format!("{about} --min-poses 41"), "no shaft: too few poses: 40, expected at least 41"),
        (
            little,
            "too little variation: no two poses differ by more than 11.2°, expected at least 15.0°",
        ),
        (two_axes.clone(), "too large an error: the shaft's direction is"),
        (around.clone(), "too large an error: the shaft's direction is"),
    ] {
        let error = scratch.fail(format!("pivot --spin {args}"));
        assert!(error.contains(expected), "{error}");
    }
    let lenient = scratch.json(format!("pivot --spin {two_axes} --max-shaft-deg 60"));
    assert!(number(&lenient["spin"]["rms_deg"]) > 3.0);
    let wrong = scratch.fail(format!("pivot {around} --spin {about} --tip-frame frame.csv"));
    assert!(wrong.contains("frame.csv: found no kind of file"), "{wrong}");
    let missing = scratch.fail("pivot");
    assert!(missing.contains("required") && missing.contains("RECORDINGS"), "{missing}");
}

#[test]
fn the_tip_frame_is_exported_for_slicer() {
    let scratch = Scratch::new();
    let (around, about) = (pivoted(&scratch), spun(&scratch));
    let [transform, body] = ["tip.tfm", "probe.body.ron"].map(|name| scratch.arg(name));
    for file in [&transform, &body] {
        scratch.succeed(format!("pivot {around} --spin {about} --tip-frame {file}"));
    }
    let read = trackwright_project::Files::default()
        .read_tool(body.as_ref(), OnMismatch::Refuse)
        .unwrap()
        .body
        .rigid;
    assert_eq!((read.name.as_str(), read.sensors.len()), ("probe", 1));
    let body_from_tool = read.sensors[0].body_from_sensor();
    let tip = body_from_tool * Point3::from(TIP);
    assert!((tip - read.judged_tip_in_body()).norm() < 1e-9);
    // Built-in tools have their shafts above their tips.
    let up = body_from_tool * -shaft().into_inner();
    assert!((up - Vector3::z()).norm() < 1e-12);
    // What Slicer reads is inverted, in LPS: the tool's frame from the tip's has the tip as its shift.
    let text = fs::read_to_string(&transform).unwrap();
    let line = text.lines().find_map(|l| l.strip_prefix("Parameters: ")).unwrap();
    let values: Vec<f64> = line.split(' ').map(|v| v.parse().unwrap()).collect();
    let flip = Vector3::new(-1.0, -1.0, 1.0);
    let turn = nalgebra::Matrix3::from_row_slice(&values[..9]);
    let shift = Vector3::from_column_slice(&values[9..12]);
    let tool_from_tip_lps = |at: Vector3<f64>| turn.transpose() * (at - shift);
    let at_tip = tool_from_tip_lps(Vector3::zeros()).component_mul(&flip);
    assert!((at_tip - Vector3::from(TIP)).norm() < 1e-9, "{at_tip}");
    let ahead = tool_from_tip_lps(Vector3::z()).component_mul(&flip) - at_tip;
    assert!((ahead - shaft().into_inner()).norm() < 1e-9, "{ahead}");
}
