//! `stability`: every row holds, and the files state what the screen shows.

use crate::support::program::Scratch;
use serde_json::Value;

#[test]
fn the_quick_battery_holds_and_is_written() {
    let scratch = Scratch::new();
    let (rows, notes) = scratch.json_and_notes("stability --quick -o out/of/the/way");
    // No terminal, no progress.
    assert_eq!(notes, "");
    let rows = rows.as_array().unwrap();
    assert!(rows.len() > 500);
    for row in rows {
        assert_eq!(row["holds"], true, "{row}");
    }
    let read = |name: &str| scratch.read(&format!("out/of/the/way/{name}"));
    let written: Vec<Value> = serde_json::from_str(&read("stability.json")).unwrap();
    assert_eq!(&written, rows);
    let page = read("stability.md");
    assert!(page.contains(&format!("all {} rows hold", rows.len())), "{page}");
    assert_eq!(read("stability.csv").lines().count(), rows.len() + 1);
}
