//! `compensate`: measured poses corrected, what the table and the summary state about them.

use crate::support::golden::number;
use crate::support::program::Scratch;
use crate::support::table::POSE;

const POSES: &str = "x,y,z,qw,qx,qy,qz
10,20,-250,1,0,0,0
-60,35,-180,0.5,0.5,-0.5,0.5
-110,-110,-300,0.1,0.7,-0.1,0.7
40,-70,-220,0.9,0.1,0.3,-0.3
";

/// A room fitted to a table of the repository, and some poses.
fn room(arguments: &str) -> Scratch {
    let scratch = Scratch::new();
    scratch.fit("room.env.ron", &format!("--order 2 {arguments}"));
    scratch.write("poses.csv", POSES);
    scratch
}

/// The cells of a table without its header, empty ones as `None`.
fn cells(scratch: &Scratch, file: &str) -> Vec<Vec<Option<f64>>> {
    let number = |cell: &String| (!cell.is_empty()).then(|| cell.parse().unwrap());
    scratch.table(file).rows.iter().map(|row| row.iter().map(number).collect()).collect()
}

#[test]
fn distorted_poses_come_back() {
    for arguments in [
        "--directions 1 --weights area",
        "--directions 14 --weights area",
        "--directions 42 --weights gnomonic",
    ] {
        let scratch = room(arguments);
        scratch.succeed("distort room.env.ron poses.csv -o measured.csv");
        let figures = scratch.json("compensate room.env.ron measured.csv -o out.csv");
        let columns = scratch.table("out.csv").columns.join(",");
        assert_eq!(columns, format!("{POSE},outside,without_field,converged,ambiguous"));
        let mut unflagged = 0;
        for (was, is) in cells(&scratch, "poses.csv").iter().zip(cells(&scratch, "out.csv")) {
            assert_eq!(is[9], Some(1.0));
            if is[10] == Some(0.0) {
                unflagged += 1;
                let length: f64 = was[3..7].iter().flatten().map(|q| q * q).sum::<f64>().sqrt();
                for k in 0..7 {
                    let scale = if k < 3 { 1.0 } else { 1.0 / length };
                    let error = was[k].unwrap() * scale - is[k].unwrap();
                    let bound = if k < 3 { 1e-9 } else { 1e-12 };
                    assert!(error.abs() < bound, "column {k}: {error:e}");
                }
            }
        }
        assert!(unflagged >= 3, "{unflagged} of 4 are certain");
        assert_eq!(figures["method"], "inverse");
        assert_eq!(figures["rows"], 4);
        assert_eq!(figures["converged"], 4);
        assert_eq!(figures["not_converged"], 0);
        assert!(number(&figures["largest_correction_mm"]) > 0.01);
        let shortcut = &figures["shortcut_against_inverse"];
        let rms = number(&shortcut["position_rms_mm"]);
        assert!(rms > 0.0 && rms <= number(&shortcut["position_max_mm"]));
    }
}

#[test]
fn a_correction_map_is_applied_as_it_is() {
    let scratch = room("--directions 14 --map correction");
    let figures = scratch.json("compensate room.env.ron poses.csv -o out.csv");
    assert_eq!(figures["method"], "correction");
    assert!(figures["shortcut_against_inverse"].is_null());
    // The same map called a distortion adds what the correction takes off, and its shortcut
    // takes it off too.
    let as_distortion = scratch.read("room.env.ron").replace("Correction", "Distortion");
    scratch.write("d.env.ron", as_distortion);
    scratch.succeed("compensate d.env.ron poses.csv -o s.csv --method shortcut");
    assert_eq!(scratch.read("out.csv"), scratch.read("s.csv"));
    scratch.succeed("distort d.env.ron poses.csv -o m.csv");
    let (was, on, off) =
        (cells(&scratch, "poses.csv"), cells(&scratch, "m.csv"), cells(&scratch, "out.csv"));
    for ((was, on), off) in was.iter().zip(&on).zip(&off) {
        for k in 0..3 {
            let middle = 0.5 * (on[k].unwrap() + off[k].unwrap());
            assert!((middle - was[k].unwrap()).abs() < 1e-9);
        }
    }
}

#[test]
fn rejected_outside_poses_have_empty_cells() {
    let scratch = room("--directions 14");
    let far = format!("{POSES}5000,0,-200,1,0,0,0\n");
    scratch.write("poses.csv", far);
    let clamped = scratch.json("compensate room.env.ron poses.csv -o out.csv");
    assert_eq!((&clamped["converged"], &clamped["outside"]), (&5.into(), &1.into()));
    let last = cells(&scratch, "out.csv").pop().unwrap();
    assert_eq!(last[7..10], [Some(1.0), Some(1.0), Some(1.0)]);
    let rejected = scratch.json("compensate room.env.ron poses.csv -o out.csv --outside reject");
    assert_eq!((&rejected["converged"], &rejected["rejected"]), (&4.into(), &1.into()));
    let last = cells(&scratch, "out.csv").pop().unwrap();
    assert_eq!(last[..7], [None; 7]);
    assert_eq!(last[7..], [Some(1.0), Some(1.0), Some(0.0), Some(0.0)]);
    let line = "compensate room.env.ron poses.csv -o bounds.csv --outside reject --support";
    scratch.succeed(line);
    let rows = cells(&scratch, "bounds.csv");
    let [first, last] = [rows.first(), rows.last()].map(|row| &row.unwrap()[11..]);
    assert!(first.len() == 7 && first.iter().all(Option::is_some), "{first:?}");
    assert_eq!(last, [None; 7]);
}

#[test]
fn a_row_without_an_answer_has_empty_cells() {
    let scratch = room("--directions 1");
    // In a room in which x is read as 50 + 2 (x - 50)² / 100: it folds, and nothing reads below 50.
    // The written environment shows the form; its box and its coefficients are replaced.
    let written = scratch.read("room.env.ron");
    let fold: String = [100.0, -50.0, 0.0]
        .iter()
        .map(|x| format!("({x:?}, 0.0, 0.0, 0.0, 0.0, 0.0),\n").repeat(9))
        .collect();
    let start = written.find("coefficients: [").expect("coefficients") + "coefficients: [".len();
    let end = start + written[start..].find(']').expect("an end");
    let mut text = format!("{}\n{fold}{}", &written[..start], &written[end..]);
    let start = text.find("box: (").expect("a box");
    let end = start + text[start..].find("))").expect("its end") + 2;
    text.replace_range(start..end, "box: ((0.0, 0.0, 0.0), (100.0, 100.0, 100.0))");
    scratch.write("fold.env.ron", text);
    scratch.write("poses.csv", format!("{POSE}\n20,40,60,1,0,0,0\n60,40,60,1,0,0,0\n"));
    let figures =
        scratch.json("compensate fold.env.ron poses.csv -o out.csv --outside extrapolate");
    let rows = cells(&scratch, "out.csv");
    assert_eq!(rows[0][..7], [None; 7]);
    assert_eq!(rows[0][9..], [Some(0.0), Some(0.0)]);
    // 60 is read at 50 ± 10 √5.
    let x = rows[1][0].unwrap();
    assert!((x - 50.0 - 10.0 * 5.0_f64.sqrt()).abs() < 1e-9, "{x}");
    assert_eq!(rows[1][9..], [Some(1.0), Some(1.0)]);
    assert_eq!(figures["converged"], 1);
    assert_eq!(figures["ambiguous"], 1);
    assert_eq!(number(&figures["folded"]) + number(&figures["not_converged"]), 1.0);
}

#[test]
fn a_correction_map_has_no_inverse() {
    let scratch = room("--directions 14 --map correction");
    for method in ["inverse", "shortcut"] {
        let words = ["room.env.ron", "correction map", "expected a distortion map", method];
        let compensate = "compensate room.env.ron poses.csv -o out.csv --method";
        scratch.fail_with(format!("{compensate} {method}"), &words);
    }
    scratch.refused("compensate none.env.ron poses.csv -o out.csv", &["none.env.ron"]);
    assert!(!scratch.has("out.csv"));
}
