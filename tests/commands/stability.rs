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
        let row = row.as_object().unwrap();
        let mut names: Vec<_> = row.keys().map(String::as_str).collect();
        names.sort_unstable();
        assert_eq!(names, ["bound", "case", "condition", "error", "holds", "quantity"]);
        assert_eq!(row["holds"], true, "{row:?}");
        for name in ["condition", "error", "bound"] {
            assert!(row[name].is_number(), "{row:?}");
        }
    }
    let read = |name: &str| scratch.read(&format!("out/of/the/way/{name}"));
    let written: Vec<Value> = serde_json::from_str(&read("stability.json")).unwrap();
    assert_eq!(&written, rows);
    let page = read("stability.md");
    assert!(page.contains(&format!("all {} rows hold", rows.len())), "{page}");
    assert_eq!(read("stability.csv").lines().count(), rows.len() + 1);
}

#[test]
fn help_states_arguments_and_exit_status() {
    // Lines are broken where the terminal ends.
    let help = Scratch::new().succeed("stability --help");
    let help = help.split_whitespace().collect::<Vec<_>>().join(" ");
    for part in ["--quick", "--output", "exit status 1"] {
        assert!(help.contains(part), "{help}");
    }
}
