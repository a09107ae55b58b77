//! The manufacturing sheet as a workshop gets it: text, JSON, table, and the check by drawn tools.

use crate::support::golden::{list, number, numbers};
use crate::support::program::Scratch;
use serde_json::Value;

const POINTER: &str = "pointer.design.ron";

/// A copy of the built-in pointer with a requirement that it meets as drawn.
fn with_pointer() -> Scratch {
    let scratch = Scratch::new();
    scratch.copy_built_in("pointer-on-head", POINTER, "angle_rms: 0.5", "angle_rms: 1.2");
    scratch
}

#[test]
fn the_sheet_is_the_same_in_every_format() {
    let scratch = with_pointer();
    let found = scratch.json(format!("tolerances {POINTER} --csv sheet.csv --check 20"));
    assert_eq!(found["no_tolerances"], Value::Null);
    assert_eq!((&found["poses"], &found["study_poses"]), (&3375.into(), &3375.into()));
    assert_eq!(found["check"]["met"], 20);
    let bodies = list(&found, "bodies");
    assert_eq!(bodies.len(), 2);
    assert_eq!((&bodies[0]["role"], &bodies[1]["role"]), (&"tool".into(), &"crf".into()));
    let shaft = &bodies[0]["sensors"][0];
    assert_eq!((&shaft["name"], &shaft["kind"]), (&"shaft".into(), &"5 DOF".into()));
    assert_eq!(numbers::<3>(&shaft["position_in_body_mm"]), [0.0, 0.0, 72.0]);
    assert_eq!(number(&shaft["distance_from_tip_mm"]), 72.0);
    assert_eq!(number(&shaft["axis"]["polar_deg"]), 0.0);
    let position = &shaft["alone"]["position_mm"];
    assert!(number(&position["value"]) <= number(&position["simulated"]));
    assert_eq!(position["limited_by"]["met"], true);

    let table = scratch.table("sheet.csv");
    assert_eq!(table.rows.len(), 6);
    assert_eq!((table.cell(0, "role"), table.cell(0, "sensor")), ("tool", "shaft"));
    assert_eq!(table.number(0, "alone_position_mm"), number(&position["value"]));
    let together = number(&bodies[1]["together"]["angle_deg"]["value"]);
    assert_eq!(table.number(5, "together_angle_deg"), together);

    let words = [
        "Origin: the tip.",
        "in the direction +z",
        "shaft – grip",
        "tool, every sensor",
        "Worst allowed combination: position RMS",
        "all 20 drawn tools meet the requirement",
    ];
    scratch.succeed_with(format!("tolerances {POINTER} --check 20"), &words);
}

#[test]
fn the_sheet_states_missed_requirements() {
    let scratch = Scratch::new();
    let requirement = "requirement: (position_rms: 1.0, angle_rms: 0.5),";
    let changed = |name: &str, to: &str| {
        let file = format!("{name}.design.ron");
        scratch.copy_built_in("pointer-on-head", &file, requirement, to);
        file
    };
    let missed = changed("missed", "requirement: (position_max: 0.1),");
    let text = scratch.succeed(format!("tolerances {missed} --check 5"));
    assert!(text.contains("No tolerances: the requirement is missed"), "{text}");
    assert!(text.contains("shaft"), "{text}");
    let found = scratch.json(format!("tolerances {missed}"));
    assert_eq!(found["bodies"][0]["together"], Value::Null);
    let none = changed("none", "");
    scratch.succeed_with(format!("tolerances {none}"), &["the design states no requirement"]);
}

#[test]
fn bad_arguments_of_tolerances_are_refused() {
    let scratch = with_pointer();
    for draws in ["0", "1000001", "many"] {
        let line = format!("tolerances {POINTER} --check {draws}");
        scratch.refused(line, &["expected 1 to 1000000"]);
    }
    scratch.refused("tolerances nowhere.design.ron", &["nowhere.design.ron"]);
    scratch.fail(format!("tolerances {POINTER} --csv /nowhere/sheet.csv"));
}
