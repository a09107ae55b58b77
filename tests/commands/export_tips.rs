//! Tips of a design's study for 3D Slicer and for spreadsheets.

use crate::support::golden::numbers;
use crate::support::program::Scratch;
use nalgebra::Point3;
use serde_json::Value;
use trackwright_formats::poses::WhosePoses;

const TIP: [f64; 3] = [3.0, -4.0, 12.0];

const DESIGN: &str = "d/pointer-on-head.design.ron";

/// A design on a CRF whose tool's tip is not its origin.
fn design() -> Scratch {
    let scratch = Scratch::new();
    scratch.copy_design_with_room("golden/pointer-on-head", "--order 1 --directions 6");
    scratch.replace("d/tool.body.ron", "tip: (0, 0, 0)", "tip: (3, -4, 12)");
    scratch
}

/// Trial, true tip, simulated tip, error.
fn rows(scratch: &Scratch) -> Vec<[f64; 8]> {
    let table = scratch.table("tips.csv");
    let header = "trial,true_x,true_y,true_z,sim_x,sim_y,sim_z,err_mm";
    assert_eq!(table.columns.join(","), header);
    table.first()
}

#[test]
fn tips_are_those_of_the_simulation_log() {
    let scratch = design();
    scratch.succeed(format!("simulate {DESIGN} --mode motion --log log.csv"));
    let export = format!("export tips {DESIGN} -o tips.csv");
    scratch.succeed_with(export, &["in the frame of the CRF"]);
    scratch.succeed(format!("export tips {DESIGN} -o tips.mrk.json"));
    let rows = rows(&scratch);
    let errors = scratch.table("log.csv").numbers("err_mm");
    for (whose, first) in [(WhosePoses::True, 1), (WhosePoses::Simulated, 4)] {
        let poses = trackwright_project::Files::default()
            .read_poses_of(&scratch.path("log.csv"), whose)
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

    let file: Value = serde_json::from_str(&scratch.read("tips.mrk.json")).unwrap();
    let lists = file["markups"].as_array().unwrap();
    let names: Vec<&str> = lists.iter().map(|l| l["name"].as_str().unwrap()).collect();
    assert_eq!(names, ["pointer-on-head, true tips", "pointer-on-head, simulated tips"]);
    assert_ne!(lists[0]["display"]["selectedColor"], lists[1]["display"]["selectedColor"]);
    for (list, first) in lists.iter().zip([1, 4]) {
        let points = list["controlPoints"].as_array().unwrap();
        assert_eq!(points.len(), rows.len());
        for (point, row) in points.iter().zip(&rows) {
            // The table has rows counted from 0; a person reads labels.
            assert_eq!(point["label"], (row[0] + 1.0).to_string());
            // LPS, of the tracker's numbers as RAS.
            let [x, y, z] = numbers::<3>(&point["position"]);
            assert_eq!([-x, -y, z], [row[first], row[first + 1], row[first + 2]]);
        }
    }
    // As points they come back, one list after the other.
    let points = scratch.points("tips.mrk.json");
    let [last_true, first_simulated] = [&points[rows.len() - 1], &points[rows.len()]];
    assert_eq!(last_true.x, rows[rows.len() - 1][1]);
    assert_eq!(first_simulated.x, rows[0][4]);
}

#[test]
fn other_modes_are_those_of_simulate() {
    let scratch = design();
    let export = format!("export tips {DESIGN} -o tips.csv");
    scratch.succeed(format!("{export} --mode single"));
    assert_eq!(rows(&scratch).len(), 1);
    let count = scratch.table("d/input.csv").rows.len();
    let by_input = format!("{export} --mode input");
    scratch.succeed(format!("{by_input} --input d/input.csv"));
    assert_eq!(rows(&scratch).len(), count);
    scratch.refused(&by_input, &["--input"]);
    let kind = format!("export tips {DESIGN} -o tips.tfm");
    scratch.refused(kind, &["tips.tfm: found no kind of file"]);
    assert!(!scratch.has("tips.tfm"));
    let printed = scratch.succeed(format!("{export} --outside reject"));
    let all = 3 * 3 * 3 * 3 * 5;
    let kept = rows(&scratch);
    assert!(printed.contains(&format!("{} trials left out", all - kept.len())), "{printed}");
    // Trials keep their numbers.
    let last = kept.last().unwrap()[0];
    assert!(kept.windows(2).all(|pair| pair[0][0] < pair[1][0]) && last < f64::from(all as u32));
}
