//! `precision`: its table, its page, and what it refuses.

use crate::support::golden::number;
use crate::support::program::{Scratch, json};

#[test]
fn json_has_every_field_of_the_contract() {
    let rows = json(&["precision", "--quick"]);
    let rows = rows.as_array().unwrap();
    for what in ["field", "fit", "inverse", "uncertainty", "motion", "heatmap", "metal"] {
        assert!(rows.iter().any(|r| r["what"] == what), "{what}");
    }
    for row in rows {
        for count in ["order", "directions", "size"] {
            assert!(row[count].is_u64(), "{count}: {row}");
        }
        assert!(number(&row["seconds"]) > 0.0, "{row}");
        assert!(number(&row["error"]) >= 0.0, "{row}");
        assert_eq!(row["error_unit"], "mm", "{row}");
        assert!(row["on_front"].is_boolean(), "{row}");
        assert!(row["method"].is_string(), "{row}");
    }
    // The path that simulations take is right to round-off of fields of some ten millimetres.
    let scattered: Vec<_> =
        rows.iter().filter(|r| r["what"] == "field" && r["method"] == "scattered").collect();
    assert!(!scattered.is_empty());
    for row in scattered {
        assert!(number(&row["error"]) < 1e-12, "{row}");
    }
}

#[test]
fn a_folder_receives_page_pictures_and_tables() {
    let scratch = Scratch::new();
    let words = ["scattered poses in the design's room"];
    scratch.succeed_with("precision --quick -o new/folder", &words);
    let read = |name: &str| scratch.read(&format!("new/folder/{name}"));
    let page = read("precision.md");
    for family in ["field", "fit", "inverse", "uncertainty", "motion", "heatmap", "metal"] {
        let picture = format!("precision-{family}.svg");
        assert!(page.contains(&format!("({picture})")), "{picture}");
        assert!(read(&picture).contains("Pareto front"), "{picture}");
    }
    let rows: serde_json::Value = serde_json::from_str(&read("precision.json")).unwrap();
    let lines = read("precision.csv").lines().count();
    assert_eq!(lines, rows.as_array().unwrap().len() + 1);
}
