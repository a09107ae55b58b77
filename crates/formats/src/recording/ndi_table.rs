//! Tables of NDI Track and NDI ToolBox: tab- or comma-separated, some with decimal commas.
//!
//! The header has `Tools`, then for each tool its port with `Frame`, `Face`, `State`, `Q0`…`Tz`,
//! `Error`, `Markers`, and four cells a marker; rows repeat the port.

use super::rows::{POSE, SEPARATORS, ToolColumns, rows};
use crate::error::{FormatError, quoted, text};
use trackwright_simulation::recording::{Recording, ToolTrack};

/// Whether a line is the header of such a table.
pub fn is_header(line: &str) -> bool {
    line.trim_start().starts_with("Tools") && separator_of(line).is_some()
}

/// What is between the cells: the one that the header has after `Tools`.
fn separator_of(header: &str) -> Option<char> {
    let after = header.trim_start().strip_prefix("Tools")?;
    after.chars().find(|c| SEPARATORS.contains(c))
}

/// Reads a table.
///
/// # Errors
/// A header without tools or without their columns, rows that are too short, cells that are no
/// numbers, no rows.
pub fn parse(bytes: &[u8]) -> Result<Recording, FormatError> {
    let text = text(bytes)?;
    let mut lines = (1..).zip(text.lines());
    let (_, header) = lines.next().unwrap_or((1, ""));
    let no_header = || {
        let expected = "the header of an NDI table: Tools, Port …, Frame, State, Q0, …";
        FormatError::line(1, quoted(header), expected)
    };
    let separator = separator_of(header).ok_or_else(no_header)?;
    let cells: Vec<&str> = header.split(separator).map(str::trim).collect();
    let (mut tracks, columns): (Vec<ToolTrack>, Vec<_>) =
        tools(&cells).ok_or_else(no_header)?.into_iter().unzip();
    // A row whose line ends is whole, also one that ends in empty cells.
    for row in rows(lines, separator, text.ends_with('\n')) {
        for (columns, track) in columns.iter().zip(&mut tracks) {
            track.samples.push(row.sample(0, columns)?);
        }
    }
    if tracks.first().is_none_or(|track| track.samples.is_empty()) {
        return Err(FormatError::NoRows);
    }
    Ok(Recording { tools: tracks })
}

/// Each tool and its columns, from its port to the next one's; `None` where there is no tool or one
/// has no pose.
fn tools(header: &[&str]) -> Option<Vec<(ToolTrack, ToolColumns)>> {
    let ports: Vec<usize> = (1..header.len()).filter(|&k| header[k].starts_with("Port")).collect();
    let ends = ports.iter().copied().skip(1).chain([header.len()]);
    let tools: Option<Vec<_>> = ports
        .iter()
        .zip(ends)
        .map(|(&from, to)| {
            let named = |name: &str| (from..to).find(|&k| header[k].starts_with(name));
            let mut pose = [0; 7];
            for (column, name) in pose.iter_mut().zip(POSE) {
                *column = named(name)?;
            }
            let name = header[from].split_whitespace().collect::<Vec<_>>().join(" ");
            let columns = ToolColumns {
                frame: named("Frame"),
                time: named("Time"),
                state: named("State")?,
                pose,
            };
            Some((ToolTrack { name, samples: Vec::new() }, columns))
        })
        .collect();
    tools.filter(|tools| !tools.is_empty())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::recording::test_cuts::assert_cut_keeps_places;
    use crate::test_cases::assert_refused;
    use nalgebra::Vector3;
    use trackwright_simulation::recording::Unusable;

    const TSV: &str = "Tools\tPort 1: A  s/n:1\tFrame\tFace\tState\tQ0\tQx\tQy\tQz\tTx\tTy\tTz\tError\tMarkers\tState\tTx\tTy\tTz\tPort 2: B\tFrame\tFace\tState\tQ0\tQx\tQy\tQz\tTx\tTy\tTz\tError\tMarkers\n\
        2\tPort 1: A  s/n:1\t8\t1\tOK\t1\t0\t0\t0\t1.5\t2\t3\t0.1\t1\tOK\t9\t9\t9\tPort 2: B\t9\t1\tBad Fit\t-3.697314E28\t0\t0\t0\t0\t0\t0\t0\t0\n\
        2\tPort 1: A  s/n:1\t24\t1\tOK\t0\t0\t1\t0\t4\t5\t6\t0.1\t0\t\t\t\t\tPort 2: B\t25\t1\t\t-3.697314E28\t-3.697314E28\t-3.697314E28\t-3.697314E28\t-3.697314E28\t-3.697314E28\t-3.697314E28\t0\t0\n";

    #[test]
    fn tools_are_distinguished_and_bad_rows_state_why() {
        let found = parse(TSV.as_bytes()).unwrap();
        let [a, b] = found.tools.as_slice() else { panic!("two tools") };
        assert_eq!(a.name, "Port 1: A s/n:1");
        let poses: Vec<_> = a.good().map(|pose| pose.translation.vector).collect();
        assert_eq!(poses, [Vector3::new(1.5, 2.0, 3.0), Vector3::new(4.0, 5.0, 6.0)]);
        assert_eq!(a.samples[1].frame, Some(24));
        let reasons: Vec<_> = b.samples.iter().map(|s| s.pose.clone().unwrap_err()).collect();
        assert_eq!(reasons, [Unusable::State("Bad Fit".into()), Unusable::Missing]);
    }

    #[test]
    fn separators_and_decimal_commas_are_distinguished() {
        let csv = parse(TSV.replace('\t', ",").as_bytes()).unwrap();
        let decimal = parse(TSV.replace('.', ",").as_bytes()).unwrap();
        let expected = parse(TSV.as_bytes()).unwrap();
        for found in [csv, decimal] {
            let samples =
                |r: &Recording| r.tools.iter().map(|t| t.samples.clone()).collect::<Vec<_>>();
            assert_eq!(samples(&found), samples(&expected));
        }
    }

    #[test]
    fn what_is_no_such_table_is_named_with_its_line() {
        let header = TSV.lines().next().unwrap();
        assert_eq!(parse(header.as_bytes()), Err(FormatError::NoRows));
        let cases = r#"
            Tools\tFrame\n | line 1: found "Tools\tFrame"…
            Tools\n | line 1: found "Tools"…
            1.5 => one | line 2: Tx is "one"…
            Bad Fit\t-3.697314E28\t0\t0\t0\t0\t0\t0\t0\t0 => Bad Fit | line 2: found 22 cells…
        "#;
        assert_refused(TSV, cases, |text| parse(text.as_bytes()).unwrap_err().to_string());
    }

    #[test]
    fn a_cut_table_keeps_its_whole_rows() {
        let header = TSV.find('\n').unwrap();
        assert_cut_keeps_places(TSV, (header + 1, 0), [1.5, 4.0], parse);
        let cut = parse(&TSV.as_bytes()[..TSV.len() - 100]).unwrap();
        assert_eq!(cut.tools[0].good().count(), 2);
        assert_eq!(cut.tools[1].samples[1].pose, Err(Unusable::Cut));
    }
}
