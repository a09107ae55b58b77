//! What NDI's sample program for the combined API writes: `Frame#, ToolHandle, Face, TransformStatus,
//! q0 … qz, tx, ty, tz, error, #markers` and four cells a marker.
//!
//! Either a row is one tool at one time, named by its handle (a line of its output), or it is all
//! tools at once, each behind what is known of it: `#Tools, ToolInfo, Frame#, PortHandle, …` (its CSV
//! file). A tool that was not seen has the status `Missing` and empty cells.

use super::rows::{POSE, Row, SEPARATORS, ToolColumns, Tools, rows};
use crate::error::{FormatError, quoted, text};
use trackwright_simulation::recording::Recording;

/// Cells of a marker: its status and its place.
const MARKER: usize = 4;

/// Whether a line names the columns.
pub fn is_header(line: &str) -> bool {
    header(line).is_some()
}

struct Header {
    separator: char,
    columns: Columns,
    /// Of the number of markers, from a tool's first cell, where all tools stand in a row.
    markers: Option<usize>,
}

struct Columns {
    handle: usize,
    tool: ToolColumns,
}

/// What stands at the front of lines that were printed: `[2 alerts] [buttons: 0 ] `.
fn without_brackets(line: &str) -> &str {
    let mut line = line.trim_start();
    while let Some((_, rest)) = line.strip_prefix('[').and_then(|rest| rest.split_once(']')) {
        line = rest.trim_start();
    }
    line
}

fn header(line: &str) -> Option<Header> {
    let line = without_brackets(line);
    let is_wide = line.starts_with("#Tools");
    if !is_wide && !line.to_ascii_lowercase().starts_with("frame#") {
        return None;
    }
    let separator = line.chars().find(|c| SEPARATORS.contains(c))?;
    let names: Vec<&str> = line.split(separator).map(str::trim).collect();
    // Of all tools only the first is named, behind their number and its information.
    let first = if is_wide { 2 } else { 0 };
    let named = |name: &str| {
        let mut own = names.iter().skip(first);
        own.position(|cell| cell.eq_ignore_ascii_case(name))
    };
    let mut pose = [0; 7];
    for (column, name) in pose.iter_mut().zip(POSE) {
        *column = named(name)?;
    }
    let markers = named("#markers").or_else(|| named("markers"));
    if is_wide && markers.is_none() {
        return None;
    }
    Some(Header {
        separator,
        markers: markers.filter(|_| is_wide),
        columns: Columns {
            handle: named("toolhandle").or_else(|| named("porthandle"))?,
            tool: ToolColumns {
                frame: Some(named("frame#")?),
                time: None,
                state: named("transformstatus")?,
                pose,
            },
        },
    })
}

/// Reads what the program wrote, tools in order of their appearance.
///
/// # Errors
/// No line that names the columns, rows that are too short, cells that are no numbers, tools that
/// change from row to row where all stand in one, no rows.
pub fn parse(bytes: &[u8]) -> Result<Recording, FormatError> {
    let text = text(bytes)?;
    let mut lines = (1..).zip(text.lines());
    let header = lines.by_ref().find_map(|(_, line)| header(line)).ok_or_else(|| {
        let found = quoted(text.lines().next().unwrap_or(""));
        let names = "Frame#, ToolHandle, Face, TransformStatus, q0, …";
        FormatError::line(1, found, format!("a line that names the columns: {names}"))
    })?;
    let mut tools = Tools::default();
    // What was printed may be begun anew.
    let lines = lines.filter(|(_, line)| !is_header(line));
    let lines = lines.map(|(line, content)| (line, without_brackets(content)));
    // A row whose line ends is whole.
    for row in rows(lines, header.separator, text.ends_with('\n')) {
        match header.markers {
            Some(markers) => read_tools(&row, &header.columns, markers, &mut tools)?,
            None => read_tool(&row, &header.columns, &mut tools)?,
        }
    }
    tools.finish()
}

/// The tool of a row.
fn read_tool(row: &Row, columns: &Columns, tools: &mut Tools) -> Result<(), FormatError> {
    // Whose row it is stands in a cell that another follows.
    if !(row.is_cut && row.cells.len() <= columns.handle + 1) {
        tools.push(row.cell(columns.handle)?, row.sample(0, &columns.tool)?);
    }
    Ok(())
}

/// All tools of a row, each as long as its markers make it.
fn read_tools(
    row: &Row,
    columns: &Columns,
    markers: usize,
    tools: &mut Tools,
) -> Result<(), FormatError> {
    // The number of tools stands in front; what is there is what counts.
    let mut info = 1;
    while info < row.cells.len() {
        let first = info + 1;
        if row.is_cut && row.cells.len() <= first + columns.handle + 1 {
            return Ok(());
        }
        let name = format!("{} {}", row.cell(first + columns.handle)?, row.cell(info)?);
        let name: Vec<&str> = name.split_whitespace().collect();
        tools.push(&name.join(" "), row.sample(first, &columns.tool)?);
        let count = first + markers;
        if row.is_cut && row.cells.len() <= count + 1 {
            return Ok(());
        }
        let found = row.cell(count)?;
        let seen: usize = found.parse().map_err(|_| {
            FormatError::cell(row.line, "#Markers", quoted(found), "a number of markers")
        })?;
        info = seen
            .checked_mul(MARKER)
            .and_then(|cells| cells.checked_add(count + 1))
            .filter(|next| row.is_cut || *next <= row.cells.len())
            .ok_or_else(|| {
                let found = format!("{} cells", row.cells.len());
                let cells = format!("{seen} markers of {MARKER} cells behind cell {}", count + 1);
                FormatError::line(row.line, found, cells)
            })?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::recording::test_cuts::assert_cut_keeps_places;
    use crate::test_cases::assert_refused;
    use nalgebra::Vector3;
    use proptest::prelude::*;
    use trackwright_simulation::recording::{TrackSample, Unusable};

    /// As the program prints it, a line a tool.
    const PRINTED: &str = "[alerts] [buttons] Frame#,ToolHandle,Face#,TransformStatus,Q0,Qx,Qy,Qz,Tx,Ty,Tz,Error,#Markers,State,Tx,Ty,Tz\n\
        100,Port:1,0,Enabled,1,0,0,0,1.5,2,3,0.1,1,OK,9,9,9\n\
        100,Port:2,0,Missing,,,,,,,,,2,Missing,,,,OK,7,7,7\n\
        [1 alerts] 101,Port:1,1,PartiallyOutOfVolume,0,0,1,0,4,5,6,0.1,0\n\
        [buttons: 0 1 ] 101,Port:2,0,Enabled,0,0,1,0,4,5,6,0.25,0\n";

    /// The same as it writes it, a line a time; the tools' frames need not be the same.
    const WRITTEN: &str = "#Tools,ToolInfo,Frame#,PortHandle,Face#,TransformStatus,Q0,Qx,Qy,Qz,Tx,Ty,Tz,Error,Markers,State,Tx,Ty,Tz\n\
        2,8700340 s/n:1,100,Port:1,0,Enabled,1,0,0,0,1.5,2,3,0.1,1,OK,9,9,9,8700339 s/n:2,100,Port:2,0,Missing,,,,,,,,,2,Missing,,,,OK,7,7,7\n\
        2,8700340 s/n:1,101,Port:1,1,PartiallyOutOfVolume,0,0,1,0,4,5,6,0.1,0,8700339 s/n:2,101,Port:2,0,Enabled,0,0,1,0,4,5,6,0.25,0\n";

    fn samples(recording: &Recording) -> Vec<Vec<TrackSample>> {
        let tools = recording.tools.iter();
        tools.map(|tool| tool.samples.clone()).collect()
    }

    #[test]
    fn tools_are_distinguished_by_their_handles() {
        let printed = parse(PRINTED.as_bytes()).unwrap();
        let written = parse(WRITTEN.as_bytes()).unwrap();
        let names = |r: &Recording| r.tools.iter().map(|t| t.name.clone()).collect::<Vec<_>>();
        assert_eq!(names(&printed), ["Port:1", "Port:2"]);
        assert_eq!(names(&written), ["Port:1 8700340 s/n:1", "Port:2 8700339 s/n:2"]);
        assert_eq!(samples(&printed), samples(&written));
        let [a, b] = printed.tools.as_slice() else { panic!("two tools") };
        let at: Vec<_> = a.good().map(|pose| pose.translation.vector).collect();
        assert_eq!(at, [Vector3::new(1.5, 2.0, 3.0)]);
        let state = Unusable::State("PartiallyOutOfVolume".to_owned());
        assert_eq!(a.samples[1].pose, Err(state));
        assert_eq!(b.samples[0].pose, Err(Unusable::Missing));
        assert_eq!(b.samples[1].frame, Some(101));
        // A half turn about y.
        let there = b.good().next().unwrap() * Vector3::x();
        assert!((there + Vector3::x()).norm() < 1e-15, "{there}");
    }

    #[test]
    fn a_tool_may_be_in_some_frames_only() {
        let some: String = PRINTED
            .lines()
            .filter(|line| !line.starts_with("100,Port:2"))
            .map(|line| format!("{line}\n"))
            .collect();
        let found = parse(some.as_bytes()).unwrap();
        let frames = |k: usize| found.tools[k].samples.iter().map(|s| s.frame).collect::<Vec<_>>();
        assert_eq!(frames(0), [Some(100), Some(101)]);
        assert_eq!(frames(1), [Some(101)]);
    }

    #[test]
    fn separators_and_decimal_commas_are_distinguished() {
        for text in [PRINTED, WRITTEN] {
            let expected = samples(&parse(text.as_bytes()).unwrap());
            for (between, point) in [(";", ","), ("\t", ","), (";", ".")] {
                let other = text.replace(',', between).replace('.', point);
                assert_eq!(samples(&parse(other.as_bytes()).unwrap()), expected, "{between}");
            }
        }
    }

    #[test]
    fn what_is_no_such_file_is_named_with_its_line() {
        let refusal = |text: &str| parse(text.as_bytes()).unwrap_err().to_string();
        assert!(refusal("").starts_with("line 1: found \"\", expected a line that names"));
        assert_eq!(refusal(PRINTED.lines().next().unwrap()), FormatError::NoRows.to_string());
        let cases = r#"
            Frame#,ToolHandle\n | line 1: found "Frame#,ToolHandle"…
            1.5 => one | line 2: Tx is "one", expected a number
            100,Port:2,0,Missing,,,,,,,,, => 100,Port:2,0,Missing,
                | line 3: Qx is "Missing", expected a number
            101,Port:1,1, => 101,Port:1,\n1, | line 4: found 3 cells…
        "#;
        assert_refused(PRINTED, cases, refusal);
        // The last two have a marker more than there are cells.
        let cases = r#"
            0.1,1,OK => 0.1,one,OK | line 2: #Markers is "one"…
            0.25,0 => 0.25,1 | line 3: found 29 cells, expected 1 markers of 4…
            0.25,0 => 0.25,18446744073709551615 | line 3: found 29 cells…
        "#;
        assert_refused(WRITTEN, cases, refusal);
    }

    #[test]
    fn numbers_that_are_none_are_no_poses() {
        for (number, expected) in [
            ("NaN", Unusable::NoPose),
            ("inf", Unusable::NoPose),
            ("0.5", Unusable::NoPose),
            ("-3.697314e28", Unusable::Missing),
            ("", Unusable::Missing),
        ] {
            let text = PRINTED.replace("Enabled,1,0", &format!("Enabled,{number},0"));
            let found = parse(text.as_bytes()).unwrap();
            assert_eq!(found.tools[0].samples[0].pose, Err(expected), "{number}");
        }
    }

    #[test]
    fn a_cut_file_keeps_its_whole_rows() {
        for text in [PRINTED, WRITTEN] {
            let first = text.find('\n').unwrap();
            let whole = first + 1 + text[first + 1..].find('\n').unwrap();
            assert_cut_keeps_places(text, (whole, 1), [1.5, 4.0], parse);
        }
    }

    proptest! {
        #[test]
        fn cells_in_any_order_do_not_panic(
            is_wide in any::<bool>(),
            cells in prop::collection::vec(
                prop::sample::select(&["1", "0", "Port:1", "Missing", "Enabled", "", "9", "\n", "4e9"][..]),
                0..80,
            ),
        ) {
            let header = [PRINTED, WRITTEN][usize::from(is_wide)].split_inclusive('\n').next();
            let _ = parse((header.unwrap_or("").to_owned() + &cells.join(",")).as_bytes());
        }
    }
}
