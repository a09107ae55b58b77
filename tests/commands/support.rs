//! Where the model is valid, through the command line.

use crate::support::data::own;
use crate::support::program::Scratch;
use crate::support::table::{POSE, Table};

/// What `distort --support` writes of poses given as rows.
fn support_of(scratch: &Scratch, poses: &str) -> Table {
    scratch.write("poses.csv", format!("{POSE}\n{poses}\n"));
    scratch.succeed("distort room.env.ron poses.csv -o out.csv --support");
    let table = scratch.table("out.csv");
    let added = "outside,without_field,std_error_mm,std_error_deg,leverage,supported,distance_mm,within95_mm,within95_deg";
    assert_eq!(table.columns.join(","), format!("{POSE},{added}"));
    table
}

#[test]
fn distort_adds_where_the_model_is_valid() {
    let scratch = Scratch::new();
    scratch.fit("room.env.ron", "--order 2 --directions 14");
    // A sample, the middle of the room, and a metre away.
    let found = support_of(
        &scratch,
        "-111.428939,-0.216641268,-199.625411,0.403448096,0.580714761,-0.704057214,-0.0656006052\n\
         0,0,-250,1,0,0,0\n0,0,750,1,0,0,0",
    );
    let flags = |row| [found.number(row, "outside"), found.number(row, "supported")];
    for row in 0..2 {
        assert_eq!(flags(row), [0.0, 1.0], "{found:?}");
        // Held out, the room leaves errors of 1.6 mm and 0.5°, less at a sample.
        for (unit, expected) in [("mm", 0.05..3.0), ("deg", 0.03..1.0)] {
            let rms = found.number(row, &format!("std_error_{unit}"));
            assert!(expected.contains(&rms), "{found:?}");
            // 95 % of a length in three dimensions are 1.6 of its RMS, of one with a bias less.
            let ratio = found.number(row, &format!("within95_{unit}")) / rms;
            assert!((1.0..2.2).contains(&ratio), "{found:?}");
        }
        assert!((0.0..1.0).contains(&found.number(row, "leverage")), "{found:?}");
    }
    let [sample, middle, away] = found.numbers("distance_mm")[..] else { panic!("{found:?}") };
    // Cells of a box of some 300 mm are less than 0.1 mm.
    assert!(sample < 0.1 && middle > 1.0 && away > 700.0, "{found:?}");
    assert_eq!(flags(2), [1.0, 0.0], "{found:?}");
}

#[test]
fn a_position_only_table_reports_no_angles() {
    let scratch = Scratch::new();
    let table = Table::read(&own("room-a/room-a-fit.csv"));
    let positions = |cells: &Vec<String>| [0, 1, 2, 7, 8, 9].map(|k| &*cells[k]).join(",") + "\n";
    let rows: String = table.rows.iter().map(positions).collect();
    scratch.write("p.csv", positions(&table.columns) + &rows);
    scratch.succeed("fit p.csv -o room.env.ron --order 2 --directions 1");
    let found = support_of(&scratch, "0,0,-250,1,0,0,0");
    assert_eq!((found.cell(0, "std_error_deg"), found.cell(0, "supported")), ("", "1"));
}

#[test]
fn undetermined_terms_come_from_the_measurements() {
    let scratch = Scratch::new();
    // 160 samples an orientation for 343 unknowns: some of the room is not determined.
    scratch.fit("room.env.ron", "--order 6 --directions 14");
    let pose = "0,0,-250,1,0,0,0";
    let found = support_of(&scratch, pose);
    assert!(found.number(0, "std_error_mm") > 0.3, "{found:?}");
    assert_eq!(found.cell(0, "supported"), "0");
    // Without the measurements it has no standard error.
    let text = scratch.read("room.env.ron");
    let (before, _) = text.split_once("    process: ").unwrap();
    scratch.write("room.env.ron", format!("{before})\n"));
    let found = support_of(&scratch, pose);
    assert_eq!(found.cell(0, "supported"), "0");
    for name in ["std_error_mm", "std_error_deg", "within95_mm", "within95_deg"] {
        assert_eq!(found.cell(0, name), "", "{name}");
    }
}

/// Every kind of model that a room may have.
const KINDS: [&str; 6] = [
    "--order 0",
    "--order 2 --directions 14",
    "--order 2 --directions 14 --symmetric yes",
    "--model kriging",
    "--model harmonic --generator planar-nine",
    "--model harmonic --generator learn",
];

#[test]
fn every_kind_of_model_has_reading_errors_and_support() {
    for kind in KINDS {
        let scratch = Scratch::new();
        scratch.fit("room.env.ron", kind);
        let found = support_of(&scratch, "0,0,-250,1,0,0,0\n0,0,750,1,0,0,0");
        assert!((0.01..4.0).contains(&found.number(0, "std_error_mm")), "{kind}: {found:?}");
        assert_eq!(found.numbers("supported"), [1.0, 0.0], "{kind}");
        let [middle, away] = found.numbers("distance_mm")[..] else { panic!("{found:?}") };
        assert!(middle > 1.0 && middle < 100.0 && away > 700.0, "{kind}: {found:?}");
        let has_leverage = kind.starts_with("--order 2");
        assert_eq!(!found.cell(0, "leverage").is_empty(), has_leverage, "{kind}");
    }
}

#[test]
fn a_room_without_validity_is_an_error() {
    let scratch = Scratch::new();
    let size = "--order 1 --directions 6 --no-support";
    scratch.copy_design_with_room("golden/pointer-on-head", size);
    let env = "d/room.env.ron";
    assert!(!scratch.read(env).contains("support"));
    scratch.write("poses.csv", "x,y,z,qw,qx,qy,qz\n0,0,-250,1,0,0,0\n");
    let message = scratch.fail(format!("distort {env} poses.csv -o out.csv --support"));
    assert!(message.contains("room.env.ron: found no `support` and no `process`"), "{message}");
    assert!(!scratch.has("out.csv"));
    let simulate = "simulate d/pointer-on-head.design.ron --mode single --log log.csv";
    scratch.refused(format!("{simulate} --support"), &["\"room\" has no model validity"]);
    assert!(!scratch.has("log.csv"));
    scratch.succeed(simulate);
}

#[test]
fn too_large_a_fit_is_left_out_with_a_note() {
    let scratch = Scratch::new();
    let fit = "fit own:room-a/room-a-fit.csv -o e.env.ron --order 8 --directions 14";
    // 36 edges and twice 14 orientations of 17³.
    scratch.notes_with(fit, &["314432 numbers, expected at most 250000"]);
    assert!(!scratch.read("e.env.ron").contains("support"));
}

#[test]
fn simulate_counts_poorly_supported_trials() {
    let simulate = "simulate d/pointer-on-head.design.ron --mode motion";
    for kind in KINDS {
        let scratch = Scratch::new();
        scratch.copy_design_with_room("golden/pointer-on-head", kind);
        let found = scratch.json(format!("{simulate} --support"));
        let support = &found["support"];
        assert_eq!(support["trials"], found["trials"], "{kind}");
        // A sensor outside the box is never supported.
        let [unsupported, outside] =
            [&support["unsupported"], &found["outside"]].map(|v| v.as_u64().unwrap());
        assert!(unsupported >= outside, "{kind}: {support}");
        for (key, range) in [("std_error_mm", 0.02..4.0), ("std_error_deg", 0.005..2.0)] {
            let [rms, max] = ["rms", "max"].map(|k| support[key][k].as_f64().unwrap());
            assert!(range.contains(&rms) && rms <= max, "{kind}: {support}");
        }
    }
    let scratch = Scratch::new();
    scratch.copy_design_with_room("golden/pointer-on-head", "--order 2 --directions 14");
    assert!(scratch.json(simulate).get("support").is_none());
    scratch.succeed_with(format!("{simulate} --support"), &["trials on poorly supported field"]);
    assert!(!scratch.succeed(simulate).contains("poorly supported"));
}
