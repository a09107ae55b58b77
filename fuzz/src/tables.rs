//! Tables with a header, of comma-separated values.

use super::read;
use trackwright_formats::poses::WhosePoses;
use trackwright_formats::table::Table;
use trackwright_formats::{FormatError, groups, input, measurements, points, poses, recorded_tool};

/// The same bytes as each kind of table: there are as many rows for each, and tables that are written
/// too are written and read as the same again.
pub fn table(bytes: &[u8]) -> bool {
    let rows = read(Table::parse(bytes).and_then(|table| table.read(|_| Ok(()))));
    let rows = rows.map(|rows| rows.len());
    assert!(rows.is_none_or(|rows| rows <= bytes.len()));
    let mut counts = Vec::new();
    if let Some(set) = read(measurements::parse(bytes)) {
        assert_survives(&set, |out, set| measurements::write(out, set), measurements::parse);
        counts.push(set.measurements.len());
    }
    if let Some(found) = read(poses::parse(bytes)) {
        assert_survives(&found, |out, found| poses::write(out, found), poses::parse);
        counts.push(found.len());
    }
    counts.extend(read(recorded_tool::parse(bytes)).map(|table| table.rows.len()));
    for whose in [
        WhosePoses::True,
        WhosePoses::Simulated,
        WhosePoses::Ideal,
        WhosePoses::Measured,
        WhosePoses::Tool,
        WhosePoses::Crf,
    ] {
        counts.extend(read(poses::parse_of(bytes, whose)).map(|poses| poses.len()));
    }
    for design_has_crf in [false, true] {
        counts.extend(read(input::parse(bytes, design_has_crf)).map(|trials| trials.len()));
    }
    if let Some(Some(column)) = read(groups::parse(bytes, None)) {
        counts.extend(rows.map(|_| column.labels.len()).filter(|&count| count > 0));
    }
    assert!(counts.iter().all(|count| Some(*count) == rows), "{counts:?}");
    // Points may be a table or plain rows.
    if let Some(found) = read(points::parse(bytes)) {
        let mut table = Vec::new();
        points::write(&mut table, &found).expect("memory takes it");
        assert_eq!(points::parse(&table), Ok(found));
        return true;
    }
    !counts.is_empty()
}

/// What is written is read as the same again; compared as text.
fn assert_survives<T>(
    found: &T,
    write: impl Fn(&mut Vec<u8>, &T) -> std::io::Result<()>,
    parse: impl Fn(&[u8]) -> Result<T, FormatError>,
) {
    let written = |found: &T| {
        let mut bytes = Vec::new();
        write(&mut bytes, found).expect("memory takes it");
        bytes
    };
    let once = written(found);
    let again = parse(&once).expect("it was written here");
    assert_eq!(String::from_utf8_lossy(&written(&again)), String::from_utf8_lossy(&once));
}
