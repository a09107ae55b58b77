//! Tables with a header, of comma-separated values.

use super::read;
use trackwright_formats::poses::WhosePoses;
use trackwright_formats::table::Table;
use trackwright_formats::{groups, input, measurements, points, poses, recorded_tool};

/// The same bytes as each kind of table: there are as many rows for each, and tables that are written
/// too are written and read as the same again.
pub fn table(bytes: &[u8]) -> bool {
    let rows = read(Table::parse(bytes).and_then(|table| table.read(|_| Ok(()))));
    let rows = rows.map(|rows| rows.len());
    assert!(rows.is_none_or(|rows| rows <= bytes.len()));
    let mut counts = Vec::new();
    if let Some(set) = read(measurements::parse(bytes)) {
        let mut once = Vec::new();
        measurements::write(&mut once, &set).expect("memory takes it");
        let again = measurements::parse(&once).expect("it was written here");
        let mut twice = Vec::new();
        measurements::write(&mut twice, &again).expect("memory takes it");
        assert_eq!(text(&twice), text(&once));
        counts.push(set.measurements.len());
    }
    if let Some(found) = read(poses::parse(bytes)) {
        let mut once = Vec::new();
        poses::write(&mut once, &found).expect("memory takes it");
        let again = poses::parse(&once).expect("it was written here");
        let mut twice = Vec::new();
        poses::write(&mut twice, &again).expect("memory takes it");
        assert_eq!(text(&twice), text(&once));
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

fn text(bytes: &[u8]) -> std::borrow::Cow<'_, str> {
    String::from_utf8_lossy(bytes)
}
