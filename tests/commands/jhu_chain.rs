//! The whole chain of the Johns Hopkins sets: a room from the calibration object, the tip of the probe
//! in it, fiducials that it touched, their registration to CT, and points that it touched there;
//! against the true values of the data's generator.

use crate::support::close::assert_close;
use crate::support::data::third_party;
use crate::support::golden::{number, numbers};
use crate::support::jhu_cis::import;
use crate::support::program::{Scratch, text};
use nalgebra::Point3;
use std::fs;
use std::path::Path;
use trackwright_project::Files;

/// Errors of a chain, mm.
struct Chain {
    /// Of the post that the probe was pivoted on.
    post: f64,
    /// Mean over the navigation points, in CT.
    navigation: f64,
    navigation_rms: f64,
    /// The value of this according to the registration.
    predicted_rms: f64,
}

/// Numbers with commas after a label, one an occurrence.
fn after(text: &str, label: &str) -> Vec<Point3<f64>> {
    text.lines()
        .filter_map(|line| line.split_once(label))
        .map(|(_, values)| {
            let values: Vec<f64> = values
                .trim_matches([' ', '=', ':'])
                .split(',')
                .map(|value| value.trim().parse().unwrap())
                .collect();
            Point3::from_slice(&values)
        })
        .collect()
}

/// The probe's chain in a set of the second assignment, in a room where one is given.
fn chain(scratch: &Scratch, case: &str, room: Option<&str>) -> Chain {
    let folder = third_party("jhu-cis").unwrap();
    let path = |kind: &str| folder.join(format!("pa2-debug-{case}-{kind}.txt"));
    let file = |kind: &str| text(&path(kind));
    let in_room = room.map(|room| format!("--environment {room} --outside extrapolate"));
    let in_room = in_room.unwrap_or_default();
    let touched = |kind: &str, output: &str| {
        let (empivot, other) = (file("empivot"), file(kind));
        let more = format!("--max-rms-mm 50 {in_room}");
        scratch.json(format!("pivot {empivot} --tips {other} -o {output} {more}"))
    };
    let pivot = touched("em-fiducialss", "fiducials.csv");
    touched("EM-nav", "nav.csv");
    let ct = file("ct-fiducials");
    let registered =
        scratch.json(format!("register fiducials.csv {ct} --at nav.csv -o nav-ct.csv"));
    // The clean set comes without the generator's words; its answers are the truth.
    let (post, navigation) = match case {
        "a" => {
            let points = Files::default().read_points(&path("output2")).unwrap();
            (points_of_answers(&path("output1"))[0], points.as_it_stands())
        }
        _ => {
            let [first, second] =
                ["auxilliary1", "auxilliary2"].map(|kind| fs::read_to_string(path(kind)).unwrap());
            let truth = after(&second, "WRT CT:");
            let navigation = truth.into_iter().step_by(2).collect();
            (after(&first, "EM pivot post actual position")[0], navigation)
        }
    };
    let found = scratch.points("nav-ct.csv");
    assert_eq!(found.len(), navigation.len());
    let errors: Vec<f64> = found.iter().zip(&navigation).map(|(a, b)| (a - b).norm()).collect();
    let rms = |squares: f64| (squares / found.len() as f64).sqrt();
    let fle_mm = number(&registered["fle_rms_mm"]);
    let table = scratch.table("nav-ct.csv");
    let tre2 = table.numbers(table.columns.last().unwrap()).iter().map(|tre| tre * tre).sum();
    Chain {
        post: (Point3::from(numbers::<3>(&pivot["pivot"])) - post).norm(),
        navigation: errors.iter().sum::<f64>() / found.len() as f64,
        navigation_rms: rms(errors.iter().map(|e| e * e).sum()),
        predicted_rms: rms(tre2).hypot(fle_mm),
    }
}

/// The points of a file of answers, whose header has as many counts as it likes.
fn points_of_answers(file: &Path) -> Vec<Point3<f64>> {
    let text = fs::read_to_string(file).unwrap();
    let rows: String = text.lines().skip(1).map(|line| format!("{line}\n")).collect();
    trackwright_formats::points::parse(rows.as_bytes()).unwrap()
}

/// What a correction of so many orders (none of 0) leaves, as published: post and navigation, mm.
type Published = (&'static str, f64, f64);

/// Case by case; the figures' last digits are hundredths, with a third one where it was given. Then the RMS
/// of the positions before and after a correction of order 5, mm.
const PUBLISHED: [(&str, [Published; 3], [f64; 2]); 3] = [
    ("c", [("0", 3.61, 1.26), ("3", 3.39, 0.78), ("5", 0.09, 0.042)], [3.643, 0.0313]),
    ("e", [("0", 5.94, 3.23), ("3", 3.09, 2.08), ("5", 0.26, 0.166)], [7.230, 0.1055]),
    ("f", [("0", 6.97, 2.85), ("3", 5.76, 2.08), ("5", 0.32, 0.203)], [7.177, 0.2229]),
];

/// Of the RMS: published from files rounded to 0.01 mm, by another program.
const AGREEMENT: f64 = 0.02;

/// Another program's last digit may differ by one: the files are rounded to 0.01 mm.
const LAST_DIGIT_MM: f64 = 0.01;

/// Of positions in files, each number rounded to 0.01 mm: in what was read and in what is true.
const ROUNDING_MM: f64 = 2.0 * 0.005 * 1.733;

#[test]
fn corrected_rooms_have_the_published_errors() {
    let scratch = Scratch::new();
    for (case, figures, rms_mm) in PUBLISHED {
        let Some(table) = import(&scratch, case) else { return };
        for (order, post, navigation) in figures {
            let room = (order != "0").then(|| {
                let room = format!("{case}-{order}.env.ron");
                let model = format!("--directions 1 --order {order} --map correction");
                let fit = scratch.json(format!("fit {table} -o {room} {model}"));
                if order == "5" {
                    assert_eq!(fit["samples"], 3375);
                    for (which, rms_mm) in ["before", "after"].into_iter().zip(rms_mm) {
                        let found = number(&fit["train"][which]["position_rms_mm"]);
                        assert_close(&format!("{case} {which}"), found, rms_mm, AGREEMENT, 0.0);
                    }
                    assert!(fit["train"]["after"]["angle_rms_deg"].is_null());
                }
                room
            });
            let found = chain(&scratch, case, room.as_deref());
            let digit = if order == "5" { LAST_DIGIT_MM / 10.0 } else { LAST_DIGIT_MM };
            let off = [found.post - post, found.navigation - navigation].map(f64::abs);
            assert!(off[0] < LAST_DIGIT_MM, "{case} {order}: post {}", found.post);
            assert!(off[1] < digit, "{case} {order}: navigation {}", found.navigation);
        }
    }
}

#[test]
fn without_distortion_the_chain_is_exact() {
    if third_party("jhu-cis").is_none() {
        return;
    }
    let scratch = Scratch::new();
    // Optical jiggle (d) has no part in what the EM tracker reads.
    for case in ["a", "d"] {
        let found = chain(&scratch, case, None);
        assert!(found.post < ROUNDING_MM, "{case}: {}", found.post);
        assert!(found.navigation < ROUNDING_MM, "{case}: {}", found.navigation);
    }
    // The tip that touches a point is off like one that touched a fiducial, and the registration is
    // on top. Twelve components scatter by a fifth, and share the registration's part.
    let noisy = chain(&scratch, "b", None);
    let (found, predicted) = (noisy.navigation_rms, noisy.predicted_rms);
    assert!((0.5..2.0).contains(&(found / predicted)), "{found} {predicted}");
}

#[test]
fn an_optical_probe_finds_its_post() {
    let Some(folder) = third_party("jhu-cis") else { return };
    let scratch = Scratch::new();
    for (set, cases) in [("pa1", "abcdefg"), ("pa2", "bcdef")] {
        for case in cases.chars() {
            let path = |kind: &str| folder.join(format!("{set}-debug-{case}-{kind}.txt"));
            let file = |kind: &str| text(&path(kind));
            let (optpivot, calbody) = (file("optpivot"), file("calbody"));
            let found = scratch.json(format!("pivot {optpivot} --calbody {calbody}"));
            let truth = fs::read_to_string(path("auxilliary1")).unwrap();
            let truth = after(&truth, "Optical pivot post actual position")[0];
            let off_mm = (Point3::from(numbers::<3>(&found["pivot"])) - truth).norm();
            assert!(off_mm < ROUNDING_MM, "{set} {case}: {off_mm}");
        }
    }
    let optpivot = text(&folder.join("pa1-debug-a-optpivot.txt"));
    scratch.refused(format!("pivot {optpivot}"), &["pa1-debug-a-optpivot.txt", "--calbody"]);
}

#[test]
fn marker_correction_needs_no_axes() {
    let Some(folder) = third_party("jhu-cis") else { return };
    let scratch = Scratch::new();
    scratch.fit("room.env.ron", "--order 1 --directions 6");
    let pivot = format!("pivot {}", text(&folder.join("pa1-debug-a-empivot.txt")));
    let words = ["pa1-debug-a-empivot.txt", "not 6"];
    scratch.refused(format!("{pivot} --environment room.env.ron"), &words);
}

#[test]
fn a_design_in_room_e_runs_in_all_modes() {
    let scratch = Scratch::new();
    let Some(table) = import(&scratch, "e") else { return };
    scratch.copy_own("room-e", "room-e");
    scratch.succeed(format!("fit {table} -o room-e/room-e.env.ron --directions 1 --order 5"));
    for mode in ["single", "motion", "input --input room-e/input.csv"] {
        let found = scratch.json(format!("simulate room-e/pointer.design.ron --mode {mode}"));
        let rms = number(&found["room_field"]["position_mm"]["rms"]);
        // The room is off by 7 mm, but alike for sensors that are close together.
        assert!((0.01..20.0).contains(&rms), "{mode}: {rms}");
    }
}
