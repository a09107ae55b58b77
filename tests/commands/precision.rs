//! `precision`: its table and its page.

use crate::support::golden::number;
use crate::support::program::Scratch;

const FAMILIES: [&str; 7] =
    ["field", "fit", "inverse", "uncertainty", "motion", "heatmap", "metal"];

#[test]
fn json_page_pictures_and_table_have_every_row() {
    let scratch = Scratch::new();
    let printed = scratch.json("precision --quick -o new/folder");
    let rows = printed.as_array().unwrap();
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
    let read = |name: &str| scratch.read(&format!("new/folder/{name}"));
    let page = read("precision.md");
    for family in FAMILIES {
        assert!(rows.iter().any(|r| r["what"] == family), "{family}");
        let picture = format!("precision-{family}.svg");
        assert!(page.contains(&format!("({picture})")), "{picture}");
        assert!(read(&picture).contains("Pareto front"), "{picture}");
    }
    let written: serde_json::Value = serde_json::from_str(&read("precision.json")).unwrap();
    assert_eq!(written, printed);
    assert_eq!(read("precision.csv").lines().count(), rows.len() + 1);
    let words = ["scattered poses in the design's room"];
    scratch.succeed_with("precision --quick", &words);
}
