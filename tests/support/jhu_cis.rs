//! The Johns Hopkins calibration sets as measurement tables.

use super::data::third_party;
use super::program::{Scratch, succeed, text};

/// The table of a case of the second assignment, imported into the scratch folder; `None` where the data set
/// is not at hand.
pub fn import(scratch: &Scratch, case: &str) -> Option<String> {
    let folder = third_party("jhu-cis")?;
    let file = |kind: &str| text(&folder.join(format!("pa2-debug-{case}-{kind}.txt")));
    let table = scratch.arg(&format!("{case}.csv"));
    succeed(&["import", "jhu-cis", &file("calbody"), &file("calreadings"), "-o", &table]);
    Some(table)
}
