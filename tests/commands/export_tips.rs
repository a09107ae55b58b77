//! Tips of a design's study for 3D Slicer and for spreadsheets.

use crate::support::golden::numbers;
use crate::support::program::Scratch;
use nalgebra::Point3;
use serde_json::Value;
use std::fs;
use trackwright_formats::poses::WhosePoses;

const TIP: [f64; 3] = [3.0, -4.0, 12.0];

/// A design on a CRF whose tool's tip is not its origin.
fn design(scratch: &Scratch) -> String {
    scratch.copy_own("golden/pointer-on-head", "design");
    scratch
        .succeed("fit own:room-a/room-a-fit.csv -o design/room.env.ron --order 1 --directions 6");
    let written = scratch.read("design/tool.body.ron");
    assert!(written.contains("tip: (0"), "{written}");
    let start = written.find("tip: (").unwrap();
    let end = start + written[start..].find(')').unwrap();
    let moved = format!("{}tip: (3, -4, 12{}", &written[..start], &written[end..]);
    scratch.write("design/tool.body.ron", moved);
    scratch.arg("design/pointer-on-head.design.ron")
}

/// Trial, true tip, simulated tip, error.
fn rows(file: &str) -> Vec<[f64; 8]> {
    let table = fs::read_to_string(file).unwrap();
    let mut lines = table.lines();
    let header = "trial,true_x,true_y,true_z,sim_x,sim_y,sim_z,err_mm";
    assert_eq!(lines.next(), Some(header));
    let cells = |line: &str| -> Vec<f64> { line.split(',').map(|c| c.parse().unwrap()).collect() };
    lines.map(|line| cells(line).try_into().unwrap()).collect()
}

#[test]
fn tips_are_those_of_the_simulation_log() {
    let scratch = Scratch::new();
    let design = design(&scratch);
    let [log, table, markups] = ["log.csv", "tips.csv", "tips.mrk.json"].map(|n| scratch.arg(n));
    scratch.succeed(format!("simulate {design} --mode motion --log {log}"));
    let printed = scratch.succeed(format!("export tips {design} -o {table}"));
    assert!(printed.contains("in the frame of the CRF"), "{printed}");
    scratch.succeed(format!("export tips {design} -o {markups}"));
    let rows = rows(&table);
    let errors = fs::read_to_string(&log).unwrap();
    let column = errors.lines().next().unwrap().split(',').position(|name| name == "err_mm");
    let errors: Vec<f64> = errors
        .lines()
        .skip(1)
        .map(|line| line.split(',').nth(column.unwrap()).unwrap().parse().unwrap())
        .collect();
    for (whose, first) in [(WhosePoses::True, 1), (WhosePoses::Simulated, 4)] {
        let poses = trackwright_project::Files::default()
            .read_poses_of(log.as_ref(), whose)
            .unwrap()
            .as_it_stands();
        assert_eq!(poses.len(), rows.len());
        for (pose, row) in poses.iter().zip(&rows) {
            let at = Point3::from([0, 1, 2].map(|k| row[first + k]));
            assert!((at - pose * Point3::from(TIP)).norm() < 1e-9, "{row:?}");
        }
    }
    for (k, (row, error)) in rows.iter().zip(errors).enumerate() {
        assert_eq!(row[0], k as f64);
        assert!((row[7] - error).abs() < 1e-9, "{row:?} {error}");
    }
    // The error is no round-off.
    assert!(rows.iter().any(|row| row[7] > 0.1));

    let file: Value = serde_json::from_slice(&fs::read(&markups).unwrap()).unwrap();
    let lists = file["markups"].as_array().unwrap();
    let names: Vec<&str> = lists.iter().map(|l| l["name"].as_str().unwrap()).collect();
    assert_eq!(names, ["pointer-on-head, true tips", "pointer-on-head, simulated tips"]);
    assert_ne!(lists[0]["display"]["selectedColor"], lists[1]["display"]["selectedColor"]);
    for (list, first) in lists.iter().zip([1, 4]) {
        let points = list["controlPoints"].as_array().unwrap();
        assert_eq!(points.len(), rows.len());
        for (point, row) in points.iter().zip(&rows) {
            assert_eq!(point["label"], row[0].to_string());
            // LPS, of the tracker's numbers as RAS.
            let [x, y, z] = numbers::<3>(&point["position"]);
            assert_eq!([-x, -y, z], [row[first], row[first + 1], row[first + 2]]);
        }
    }
    // As points they come back, one list after the other.
    let points =
        trackwright_project::Files::default().read_points(markups.as_ref()).unwrap().as_it_stands();
    let [last_true, first_simulated] = [&points[rows.len() - 1], &points[rows.len()]];
    assert_eq!(last_true.x, rows[rows.len() - 1][1]);
    assert_eq!(first_simulated.x, rows[0][4]);
}

#[test]
fn other_modes_are_those_of_simulate() {
    let scratch = Scratch::new();
    let design = design(&scratch);
    let table = scratch.arg("tips.csv");
    scratch.succeed(format!("export tips {design} -o {table} --mode single"));
    assert_eq!(rows(&table).len(), 1);
    let count = scratch.read("design/input.csv").lines().count() - 1;
    let by_input = format!("export tips {design} -o {table} --mode input");
    scratch.succeed(format!("{by_input} --input design/input.csv"));
    assert_eq!(rows(&table).len(), count);
    let without = scratch.fail(&by_input);
    assert!(without.contains("--input"), "{without}");
    let kind = scratch.fail(format!("export tips {design} -o tips.tfm"));
    assert!(kind.contains("tips.tfm: found no kind of file"), "{kind}");
    assert!(!scratch.has("tips.tfm"));
    let printed = scratch.succeed(format!("export tips {design} -o {table} --outside reject"));
    let all = 3 * 3 * 3 * 3 * 5;
    let kept = rows(&table);
    assert!(printed.contains(&format!("{} trials left out", all - kept.len())), "{printed}");
    // Trials keep their numbers.
    let last = kept.last().unwrap()[0];
    assert!(kept.windows(2).all(|pair| pair[0][0] < pair[1][0]) && last < f64::from(all as u32));
}
