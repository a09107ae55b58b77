//! `stability`: every row holds, and the files state what the screen shows.

use crate::support::program::{Scratch, succeed, trackwright};
use serde_json::Value;

#[test]
fn the_quick_battery_holds_and_is_written() {
    let scratch = Scratch::new();
    let folder = scratch.arg("out/of/the/way");
    let output =
        trackwright(&["stability", "--quick", "--format", "json", "-o", &folder]).output().unwrap();
    let text = String::from_utf8(output.stdout).unwrap();
    assert_eq!(output.status.code(), Some(0), "{text}");
    // No terminal, no progress.
    assert!(output.stderr.is_empty());
    let rows: Vec<Value> = serde_json::from_str(&text).unwrap();
    assert!(rows.len() > 500);
    for row in &rows {
        let row = row.as_object().unwrap();
        let names: Vec<_> = row.keys().map(String::as_str).collect();
        let mut expected = ["case", "quantity", "condition", "error", "bound", "holds"];
        expected.sort_unstable();
        let mut found = names.clone();
        found.sort_unstable();
        assert_eq!(found, expected);
        assert_eq!(row["holds"], true, "{row:?}");
        for name in ["condition", "error", "bound"] {
            assert!(row[name].is_number(), "{row:?}");
        }
    }
    let read = |name: &str| std::fs::read_to_string(scratch.path("out/of/the/way").join(name));
    let written: Vec<Value> = serde_json::from_str(&read("stability.json").unwrap()).unwrap();
    assert_eq!(written, rows);
    let page = read("stability.md").unwrap();
    assert!(page.contains(&format!("all {} rows hold", rows.len())), "{page}");
    assert_eq!(read("stability.csv").unwrap().lines().count(), rows.len() + 1);
}

#[test]
fn an_impossible_folder_fails_before_the_work() {
    let scratch = Scratch::new();
    scratch.write("file", "");
    let error = scratch.fail("stability -o file/folder");
    assert!(error.contains("file/folder"), "{error}");
    assert_eq!(error.lines().count(), 1, "{error}");
}

#[test]
fn help_states_arguments_and_exit_status() {
    // Lines are broken where the terminal ends.
    let help = succeed(&["stability", "--help"]);
    let help = help.split_whitespace().collect::<Vec<_>>().join(" ");
    for part in ["--quick", "--output", "exit status 1"] {
        assert!(help.contains(part), "{help}");
    }
}
