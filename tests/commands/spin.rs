//! Which way a tool's shaft points, beside its tip or by itself.

use crate::support::golden::{number, numbers};
use crate::support::program::Scratch;
use crate::support::table::poses_table;
use nalgebra::{Point3, Unit, Vector3};
use trackwright_formats::tool_definition::OnMismatch;
use trackwright_geometry::pose::{Pose, pose_from_parts};
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

/// A tool that was pivoted, in `pivot.csv`, and turned about its shaft, in `spin.csv`.
fn recordings() -> Scratch {
    let scratch = Scratch::new();
    let swings = (0..20).map(|i| {
        let (s, c) = (f64::from(i) * 2.4).sin_cos();
        pose(Vector3::new(s, c, 0.1) * 0.5)
    });
    scratch.write("pivot.csv", poses_table(swings));
    scratch.write("spin.csv", poses_table(turned(0.1)));
    scratch
}

/// Forty poses, from one to the next turned about the shaft.
fn turned(step_rad: f64) -> impl Iterator<Item = Pose> {
    (0..40).map(move |i| pose(shaft().into_inner() * (f64::from(i) * step_rad)))
}

#[test]
fn tip_and_shaft_come_from_one_command() {
    let scratch = recordings();
    let found = scratch.json("pivot pivot.csv --spin spin.csv");
    assert!((Point3::from(numbers::<3>(&found["tip"])) - Point3::from(TIP)).norm() < 1e-9);
    let alone = scratch.json("pivot pivot.csv");
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
    let words = ["shaft towards the tip, tool's frame"];
    scratch.succeed_with("pivot pivot.csv --spin spin.csv", &words);
}

#[test]
fn a_stated_tip_settles_the_direction() {
    let scratch = recordings();
    let (found, notes) = scratch.json_and_notes("pivot --spin spin.csv");
    assert!(notes.contains("which of the two directions"), "{notes}");
    assert_eq!(found["spin"]["towards_tip"], false);
    assert_eq!(found.as_object().unwrap().len(), 1);
    for (tip, sign) in [("0,0,100", 1.0), ("0,0,-100", -1.0)] {
        let found = scratch.json(format!("pivot --spin spin.csv --tip {tip}"));
        assert_eq!(found["spin"]["towards_tip"], true);
        let there = Vector3::from(numbers::<3>(&found["spin"]["shaft"]));
        assert!((there - shaft().into_inner() * sign).norm() < 1e-12, "{tip}");
    }
    for (args, words) in [
        ("--tip 0,0,0 --tip-frame a.tfm", "a.tfm: which of the two directions"),
        ("--tip-frame a.tfm", "--tip-frame: found no tip"),
        ("--tips spin.csv -o tips.csv", "--tips: found no tip"),
    ] {
        scratch.refused(format!("pivot --spin spin.csv {args}"), &[words]);
    }
    assert!(!scratch.has("a.tfm") && !scratch.has("tips.csv"));
}

#[test]
fn a_spin_has_refusals_and_limits_of_its_own() {
    let scratch = recordings();
    scratch.write("little.csv", poses_table(turned(0.005)));
    // Half of the turn is about another axis.
    let two_axes = (0..40).map(|i| match f64::from(i) * 0.1 {
        turn if turn < 2.0 => pose(shaft().into_inner() * turn),
        turn => pose(Vector3::y() * (turn - 2.0)),
    });
    scratch.write("two.csv", poses_table(two_axes));
    let little =
        "too little variation: no two poses differ by more than 11.2°, expected at least 15.0°";
    for (args, expected) in [
        ("--spin spin.csv --min-poses 41", "no shaft: too few poses: 40, expected at least 41"),
        ("--spin little.csv", little),
        ("--spin two.csv", "too large an error: the shaft's direction is"),
        ("--spin pivot.csv", "too large an error: the shaft's direction is"),
        ("pivot.csv --spin spin.csv --tip-frame a.csv", "a.csv: found no kind of file"),
    ] {
        scratch.refused(format!("pivot {args}"), &[expected]);
    }
    let lenient = scratch.json("pivot --spin two.csv --max-shaft-deg 60");
    assert!(number(&lenient["spin"]["rms_deg"]) > 3.0);
    scratch.refused("pivot", &["required", "RECORDINGS"]);
}

#[test]
fn the_tip_frame_is_exported_for_slicer() {
    let scratch = recordings();
    for file in ["tip.tfm", "probe.body.ron"] {
        scratch.succeed(format!("pivot pivot.csv --spin spin.csv --tip-frame {file}"));
    }
    let read = trackwright_project::Files::default()
        .read_tool(&scratch.path("probe.body.ron"), OnMismatch::Refuse)
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
    let text = scratch.read("tip.tfm");
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
