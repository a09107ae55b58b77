//! `precision`: its table, its page, and what it refuses.

use crate::support::program::{Scratch, json};
use std::fs;

#[test]
fn json_has_every_field_of_the_contract() {
    let rows = json(&["precision", "--quick"]);
    let rows = rows.as_array().unwrap();
    for what in ["field", "fit", "inverse", "uncertainty", "motion", "heatmap"] {
        assert!(rows.iter().any(|r| r["what"] == what), "{what}");
    }
    for row in rows {
        for number in ["order", "directions", "size"] {
            assert!(row[number].is_u64(), "{number}: {row}");
        }
        assert!(row["seconds"].as_f64().unwrap() > 0.0, "{row}");
        assert!(row["error"].as_f64().unwrap() >= 0.0, "{row}");
        assert_eq!(row["error_unit"], "mm", "{row}");
        assert!(row["on_front"].is_boolean(), "{row}");
        assert!(row["method"].is_string(), "{row}");
    }
    // The path that simulations take is right to round-off of fields of some ten millimetres.
    let scattered: Vec<_> =
        rows.iter().filter(|r| r["what"] == "field" && r["method"] == "scattered").collect();
    assert!(!scattered.is_empty());
    for row in scattered {
        assert!(row["error"].as_f64().unwrap() < 1e-12, "{row}");
    }
}

#[test]
fn a_folder_receives_page_pictures_and_tables() {
    let scratch = Scratch::new();
    let text = scratch.succeed("precision --quick -o new/folder");
    assert!(text.contains("scattered poses in the design's room"), "{text}");
    let read = |name: &str| fs::read_to_string(scratch.path("new/folder").join(name)).unwrap();
    let page = read("precision.md");
    for family in ["field", "fit", "inverse", "uncertainty", "motion", "heatmap"] {
        let picture = format!("precision-{family}.svg");
        assert!(page.contains(&format!("({picture})")), "{picture}");
        assert!(read(&picture).contains("Pareto front"), "{picture}");
    }
    let rows: serde_json::Value = serde_json::from_str(&read("precision.json")).unwrap();
    let lines = read("precision.csv").lines().count();
    assert_eq!(lines, rows.as_array().unwrap().len() + 1);
}

#[test]
fn an_impossible_folder_fails_first() {
    let scratch = Scratch::new();
    scratch.write("file", "");
    let message = scratch.fail("precision -o file");
    assert!(message.contains("cannot make the folder"), "{message}");
    assert_eq!(message.lines().count(), 1, "{message}");
}
