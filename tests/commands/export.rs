//! Files for other programs, as those programs read them.

use crate::support::data::{own, third_party};
use crate::support::golden::{count, list, number, numbers, point, vector};
use crate::support::peers::python;
use crate::support::program::{Scratch, json_of, text};
use crate::support::table::{Table, points_table, poses_table};
use nalgebra::{Point3, Unit, Vector3};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};
use serde_json::Value;
use trackwright_field::Environment;
use trackwright_geometry::pose::{Pose, pose_from_array, pose_from_parts};
use trackwright_geometry::rotation::{axis_rotation, exp_vector};

const AXIS: &str = "0.3,-0.5,0.8";

fn axis() -> Unit<Vector3<f64>> {
    Unit::new_normalize(Vector3::new(0.3, -0.5, 0.8))
}

/// A room of order 2 with 6 orientations: coefficients of higher ones are so far apart where no
/// samples are that they bound nothing.
fn room() -> Scratch {
    let scratch = Scratch::new();
    scratch.fit("room.env.ron", "--order 2 --directions 6");
    scratch
}

/// Numbers from 0 to 1, the same each time.
fn parts() -> impl Iterator<Item = f64> {
    let mut rng = ChaCha8Rng::seed_from_u64(7);
    std::iter::repeat_with(move || f64::from(rng.next_u32()) / f64::from(u32::MAX))
}

/// What `distort` makes of a sensor along the axis at each point: how far it is off, mm, and turned,
/// degrees.
fn distorted(scratch: &Scratch, points: &[Point3<f64>]) -> Vec<(Vector3<f64>, f64)> {
    let ideal = points.iter().map(along_axis);
    scratch.write("poses.csv", poses_table(ideal.clone()));
    scratch.succeed("distort room.env.ron poses.csv -o distorted.csv");
    let pairs = ideal.zip(scratch.poses("distorted.csv"));
    pairs
        .map(|(ideal, measured)| {
            let off = measured.translation.vector - ideal.translation.vector;
            (off, ideal.rotation.angle_to(&measured.rotation).to_degrees())
        })
        .collect()
}

/// A sensor along the axis.
fn along_axis(at: &Point3<f64>) -> Pose {
    let turn = axis_rotation(&Vector3::z_axis(), &axis());
    pose_from_parts(at.coords, exp_vector(&turn.vector_rad))
}

/// What a program of others reads from a file at points of the tracker frame.
fn read(scratch: &Scratch, reader: &str, file: &str, points: &[Point3<f64>]) -> Vec<Vec<f64>> {
    scratch.write("points.csv", points_table(points.iter().copied()));
    run(python("field_at.py").args([reader, file, &scratch.arg("points.csv")]))
}

fn run(command: &mut std::process::Command) -> Vec<Vec<f64>> {
    serde_json::from_value(json_of(command)).unwrap()
}

/// A point of the tracker frame in a file for 3D Slicer, or back.
fn flipped(at: &Point3<f64>) -> Point3<f64> {
    Point3::new(-at.x, -at.y, at.z)
}

/// By how much lines between the points of a lattice may miss one component of the field: half the
/// step squared times half the second derivative, summed over the axes. The second derivative of a
/// Bernstein polynomial of order n is at most n (n - 1) times its coefficients' greatest second
/// difference, in the unit cube.
fn interpolation_bound_mm(room: &Environment, counts: [usize; 3]) -> f64 {
    let model = room.model.at_axis(&axis());
    let n = model.order();
    let coefficient = |[i, j, k]: [usize; 3]| model.coefficients()[(i * (n + 1) + j) * (n + 1) + k];
    let mut bound = 0.0;
    for (along, count) in counts.iter().enumerate() {
        let mut greatest: f64 = 0.0;
        for place in 0..(n + 1_usize).pow(3) {
            let at = [place / (n + 1).pow(2), place / (n + 1) % (n + 1), place % (n + 1)];
            if at[along] + 2 > n {
                continue;
            }
            let [a, b, c] = [0, 1, 2].map(|step| {
                let mut at = at;
                at[along] += step;
                coefficient(at)
            });
            for component in 0..3 {
                greatest = greatest.max((a[component] - 2.0 * b[component] + c[component]).abs());
            }
        }
        let step = 1.0 / (count - 1) as f64;
        bound += step * step / 8.0 * (n * (n - 1)) as f64 * greatest;
    }
    bound
}

#[test]
fn other_programs_read_the_error_of_distort() {
    let scratch = room();
    let export = |name: &str, more: &str| {
        let field = format!("--axis {AXIS} --spacing 12,10,8 {more}");
        let found = scratch.json(format!("export field room.env.ron -o {name} {field}"));
        (scratch.arg(name), found)
    };
    let (nrrd, found) = export("field.nrrd", "");
    let files = [
        ("pynrrd", nrrd.clone(), true),
        ("itk", nrrd, true),
        ("itk", export("field.mha", "").0, true),
        ("itk", export("as-it-is.mha", "--axes lps").0, false),
        ("pynrrd", export("as-it-is.nrrd", "--axes lps").0, false),
        ("vtk", export("field.vti", "").0, false),
    ];
    let counts: [usize; 3] = serde_json::from_value(found["counts"].clone()).unwrap();
    assert_eq!(count(&found["points"]), counts.iter().product::<usize>());
    let [min, max] = [0, 1].map(|i| vector(&found["box"][i]));
    let place =
        |parts: [f64; 3]| Point3::from(min + (max - min).component_mul(&Vector3::from(parts)));
    let mut parts = parts();
    let mut three = || [0; 3].map(|_| parts.next().unwrap());
    let on_lattice: Vec<_> = (0..100)
        .map(|_| {
            let parts = three();
            place([0, 1, 2].map(|k| {
                let last = (counts[k] - 1) as f64;
                (parts[k] * last).round() / last
            }))
        })
        .collect();
    let between: Vec<_> = (0..100).map(|_| place(three())).collect();
    let allowed_between_mm = interpolation_bound_mm(&scratch.environment("room.env.ron"), counts);
    // Errors are millimetres: a bound that lets everything through would show nothing.
    assert!((1e-4..0.2).contains(&allowed_between_mm), "{allowed_between_mm}");
    // A point is found by its coordinates to some 1e-12 of a step, over which the field changes less.
    for (points, allowed_mm) in [(&on_lattice, 1e-9), (&between, allowed_between_mm)] {
        let errors = distorted(&scratch, points);
        for (reader, file, is_flipped) in &files {
            let in_file: Vec<_> = match is_flipped {
                true => points.iter().map(flipped).collect(),
                false => points.clone(),
            };
            let read = read(&scratch, reader, file, &in_file);
            assert_eq!(read.len(), 100);
            for (vector, (expected, _)) in read.iter().zip(&errors) {
                let mut vector = Point3::new(vector[0], vector[1], vector[2]);
                if *is_flipped {
                    vector = flipped(&vector);
                }
                let off = (vector.coords - expected).amax();
                assert!(off <= allowed_mm, "{reader} {file}: {off} beyond {allowed_mm}");
            }
        }
    }
    let angles = read(&scratch, "vtk-angle", &files[5].1, &on_lattice);
    for (angle, (_, expected)) in angles.iter().zip(distorted(&scratch, &on_lattice)) {
        assert!((angle[0] - expected).abs() < 1e-9, "{angle:?} {expected}");
    }
}

#[test]
fn the_field_table_has_the_errors_of_distort() {
    let scratch = room();
    let part = "--spacing 100 --box -100,-100,-300,900,0,-200 --outside reject";
    let field = format!("export field room.env.ron -o field.csv --axis {AXIS} {part}");
    let found = scratch.json(field);
    let (outside, missing) = (count(&found["outside"]), count(&found["missing"]));
    assert!(outside > 0 && outside == missing);
    let Table { columns, rows } = scratch.table("field.csv");
    let expected = "x,y,z,error_x,error_y,error_z,error_mm,error_deg,outside";
    assert_eq!(columns.join(","), expected);
    assert_eq!(rows.len(), count(&found["points"]));
    let inside: Vec<_> = rows.iter().filter(|row| row[8] == "0").collect();
    assert_eq!(rows.len() - inside.len(), outside);
    let beyond = rows.iter().filter(|row| row[8] == "1");
    assert!(beyond.clone().all(|row| row[3..8] == [""; 5]));
    let at = |row: &[String], from: usize| {
        Point3::from([0, 1, 2].map(|k| row[from + k].parse::<f64>().unwrap()))
    };
    let points: Vec<_> = inside.iter().map(|row| at(row, 0)).collect();
    for (row, (expected, _)) in inside.iter().zip(distorted(&scratch, &points)) {
        let error = at(row, 3).coords;
        assert!((error - expected).norm() < 1e-12);
        assert!((row[6].parse::<f64>().unwrap() - error.norm()).abs() < 1e-12);
    }
}

#[test]
fn a_correction_agrees_with_compensate() {
    let scratch = room();
    let correction = format!("--displacement correction --axis {AXIS} --spacing 120");
    scratch.succeed(format!("export field room.env.ron -o field.csv {correction}"));
    let field = scratch.table("field.csv");
    let places = field.first().into_iter().map(Point3::from);
    scratch.write("measured.csv", poses_table(places.map(|at| along_axis(&at))));
    scratch.succeed("compensate room.env.ron measured.csv -o corrected.csv");
    let mut answers = 0;
    let rows = field.rows;
    for (row, corrected) in rows.iter().zip(scratch.table("corrected.csv").rows) {
        for k in 0..3 {
            let cells = [&row[k], &corrected[k], &row[3 + k]];
            match cells.map(|cell| cell.parse::<f64>()) {
                [Ok(from), Ok(to), Ok(by)] => {
                    answers += 1;
                    assert!((from + by - to).abs() < 1e-9, "{row:?} {corrected:?}");
                }
                [Ok(_), Err(_), Err(_)] => {}
                _ => panic!("{row:?} {corrected:?}"),
            }
        }
    }
    assert!(answers > rows.len(), "{answers} of {} rows", rows.len());
}

#[test]
fn a_transform_moves_points_as_the_pose_does() {
    let scratch = Scratch::new();
    let pose = pose_from_array([12.5, -80.25, -310.0, 0.5, -0.1, 0.7, 0.4]).unwrap();
    scratch.write("poses.csv", poses_table([Pose::identity(), pose]));
    let in_tool = [[0.0; 3], [100.0, 0.0, 0.0], [-3.0, 40.0, 7.0], [1.0, 2.0, -150.0]];
    let in_tool = in_tool.map(Point3::from);
    for (axes, is_flipped) in [("ras", true), ("lps", false)] {
        let turn = |p: &Point3<f64>| if is_flipped { flipped(p) } else { *p };
        scratch.succeed(format!("export poses poses.csv --row 1 -o out.tfm --axes {axes}"));
        scratch.write("points.csv", points_table(in_tool.map(|p| turn(&p))));
        let files = ["out.tfm", "points.csv"].map(|name| scratch.path(name));
        let moved = run(python("move_points.py").args(files));
        for (p, moved) in in_tool.iter().zip(moved) {
            let moved = turn(&Point3::new(moved[0], moved[1], moved[2]));
            let expected = pose * p;
            assert!((moved - expected).norm() < 1e-9, "{axes}: {moved} {expected}");
        }
    }
    let several = ["found 2 poses, expected one", "--row 0 to 1"];
    scratch.refused("export poses poses.csv -o all.tfm", &several);
    let none = ["found 2 poses, expected more than --row 2"];
    scratch.refused("export poses poses.csv --row 2 -o one.tfm", &none);
}

#[test]
fn tips_of_a_pivoted_tool_surround_the_pivot() {
    let Some(file) = third_party("pivot/poses-57.txt") else { return };
    let scratch = Scratch::new();
    let recording = text(&file);
    let found = scratch.json(format!("pivot {recording}"));
    let tip = numbers::<3>(&found["tip"]).map(|v| v.to_string()).join(",");
    scratch.succeed(format!("export poses {recording} -o tips.mrk.json --tip {tip}"));
    let written: Value = serde_json::from_str(&scratch.read("tips.mrk.json")).unwrap();
    let points = list(&written["markups"][0], "controlPoints");
    assert_eq!(points.len(), 57);
    // A person reads labels in Slicer, and counts from 1.
    assert!(points[0]["label"] == "1" && points[56]["label"] == "57", "{written}");
    scratch.succeed(format!("export poses {recording} -o third.mrk.json --row 2"));
    let third: Value = serde_json::from_str(&scratch.read("third.mrk.json")).unwrap();
    assert_eq!(list(&third["markups"][0], "controlPoints")[0]["label"], "3");
    let pivot = flipped(&point(&found["pivot"]));
    let squares = points.iter().map(|p| (point(&p["position"]) - pivot).norm_squared());
    let rms_mm = (squares.sum::<f64>() / 57.0).sqrt();
    assert!((rms_mm - number(&found["rms_mm"])).abs() < 1e-9, "{rms_mm}");
    // The same poses as a table are the same recording.
    scratch.succeed(format!("export poses {recording} -o poses.csv"));
    let again = scratch.json("pivot poses.csv");
    for key in ["tip", "pivot"] {
        assert!((point(&found[key]) - point(&again[key])).norm() < 1e-9, "{key}");
    }
}

#[test]
fn columns_select_the_poses_of_a_table() {
    let scratch = Scratch::new();
    let args = "export poses own:room-a/room-a-fit.csv -o measured.csv --columns";
    let printed = scratch.succeed(format!("{args} measured"));
    let rows = Table::read(&own("room-a/room-a-fit.csv")).rows.len();
    assert_eq!(scratch.poses("measured.csv").len(), rows, "{printed}");
    scratch.refused(format!("{args} sim"), &["room-a-fit.csv: line 1: found no column sim_x"]);
}

#[test]
fn impossible_exports_write_nothing() {
    let scratch = room();
    let refused = |args: &str, words: &[&str]| {
        scratch.refused(format!("export field room.env.ron -o {args}"), words);
        assert!(!scratch.has("field.vti"), "{args}");
    };
    for (args, words) in [
        ("--box 0,0,0,10,-10,10", &["--box", "y from 0 to -10", "empty"][..]),
        ("--box 0,0,0,10,10", &["--box", "six numbers"]),
        ("--box 0,0,0,10,10,NaN", &["six numbers"]),
        ("--spacing 0", &["--spacing", "above zero"]),
        ("--spacing NaN", &["--spacing", "above zero"]),
        ("--spacing 1,2", &["--spacing", "above zero"]),
        ("--spacing 0.001", &["expected at most 16777216", "a spacing of"]),
        ("--box 0,0,0,1e300,1,1", &["found 1e300, expected at most 1e6"]),
        ("--spacing 0.001 --box 0,0,0,1e6,1e6,1e6", &["e27 points", "expected at most 16777216"]),
        ("--axis 0,0,0", &["--axis", "not all zero, or mean"]),
    ] {
        refused(&format!("field.vti {args}"), words);
    }
    refused("field.stl", &["field.stl", ".nrrd, .mha, .vti or .csv"]);
    refused("nowhere/field.vti", &["nowhere/field.vti", "cannot be written"]);
    scratch.fit("correction.env.ron", "--order 1 --directions 6 --map correction");
    let export = "export field correction.env.ron -o field.vti --displacement error";
    scratch.refused(export, &["correction.env.ron: found a correction map"]);
}

#[test]
fn a_displacement_field_with_holes_is_warned_of() {
    let scratch = room();
    let part = "--box -100,-100,-300,900,0,-200 --outside reject --spacing 100";
    scratch
        .notes_with(format!("export field room.env.ron -o field.mha {part}"), &["points are NaN"]);
}
