//! Tables of NDI Track and NDI ToolBox: tab- or comma-separated, some with decimal commas.
//!
//! The header has `Tools`, then for each tool its port with `Frame`, `Face`, `State`, `Q0`…`Tz`,
//! `Error`, `Markers`, and four cells a marker; rows repeat the port.

use super::{pose, quoted};
use crate::error::{FormatError, text};
use trackwright_simulation::recording::{Recording, ToolTrack, TrackSample, Unusable};

/// NDI writes −3.697314e28 where there is no number.
const MISSING_BELOW: f64 = -1e27;

/// The state of a sample that the tracker stands by.
const GOOD: &str = "OK";

/// The columns of a pose: scalar first, then mm.
const POSE: [&str; 7] = ["Q0", "Qx", "Qy", "Qz", "Tx", "Ty", "Tz"];

/// Whether a line is the header of such a table.
pub fn is_header(line: &str) -> bool {
    line.trim_start().starts_with("Tools") && separator_of(line).is_some()
}

/// What is between the cells: the one of these that the header has after `Tools`.
fn separator_of(header: &str) -> Option<char> {
    let after = header.trim_start().strip_prefix("Tools")?;
    after.chars().find(|c| ['\t', ';', ','].contains(c))
}

/// Where a tool's cells are.
struct Columns {
    name: String,
    frame: Option<usize>,
    time: Option<usize>,
    state: usize,
    pose: [usize; 7],
}

/// Reads a table.
///
/// # Errors
/// A header without tools or without their columns, rows that are too short, cells that are no
/// numbers, no rows.
pub fn parse(bytes: &[u8]) -> Result<Recording, FormatError> {
    let text = text(bytes)?;
    let mut lines = (1..).zip(text.lines()).peekable();
    // A row whose line ends is whole, also one that ends in empty cells.
    let is_ended = text.ends_with('\n');
    let (_, header) = lines.next().unwrap_or((1, ""));
    let no_header = || FormatError::Line {
        line: 1,
        found: quoted(header),
        expected: "the header of an NDI table: Tools, Port …, Frame, State, Q0, …".to_owned(),
    };
    let separator = separator_of(header).ok_or_else(no_header)?;
    let cells: Vec<&str> = header.split(separator).map(str::trim).collect();
    let tools = columns(&cells).ok_or_else(no_header)?;
    let mut tracks: Vec<ToolTrack> = tools
        .iter()
        .map(|tool| ToolTrack { name: tool.name.clone(), samples: Vec::new() })
        .collect();
    while let Some((line, content)) = lines.next() {
        if content.trim().is_empty() {
            continue;
        }
        let row = Row {
            line,
            cells: content.split(separator).map(str::trim).collect(),
            has_decimal_commas: separator != ',',
            is_cut: !is_ended && lines.peek().is_none(),
        };
        for (tool, track) in tools.iter().zip(&mut tracks) {
            track.samples.push(row.sample(tool)?);
        }
    }
    if tracks.first().is_none_or(|track| track.samples.is_empty()) {
        return Err(FormatError::NoRows);
    }
    Ok(Recording { tools: tracks })
}

/// Each tool's columns, from its port to the next one's; `None` where there is no tool or one has no
/// pose.
fn columns(header: &[&str]) -> Option<Vec<Columns>> {
    let ports: Vec<usize> = (1..header.len()).filter(|&k| header[k].starts_with("Port")).collect();
    let tools: Option<Vec<Columns>> = ports
        .iter()
        .zip(ports.iter().skip(1).chain([&header.len()]))
        .map(|(&from, &to)| {
            let named = |name: &str| (from..to).find(|&k| header[k].starts_with(name));
            let mut pose = [0; 7];
            for (column, name) in pose.iter_mut().zip(POSE) {
                *column = named(name)?;
            }
            Some(Columns {
                name: header[from].split_whitespace().collect::<Vec<_>>().join(" "),
                frame: named("Frame"),
                time: named("Time"),
                state: named("State")?,
                pose,
            })
        })
        .collect();
    tools.filter(|tools| !tools.is_empty())
}

struct Row<'a> {
    line: u64,
    cells: Vec<&'a str>,
    has_decimal_commas: bool,
    /// The file may end within it.
    is_cut: bool,
}

impl Row<'_> {
    fn cell(&self, column: usize) -> Result<&str, FormatError> {
        self.cells.get(column).copied().ok_or_else(|| FormatError::Line {
            line: self.line,
            found: format!("{} cells", self.cells.len()),
            expected: format!("{} at least, as the header has", column + 1),
        })
    }

    /// `None` where nothing was measured.
    fn number(&self, column: usize, name: &'static str) -> Result<Option<f64>, FormatError> {
        let cell = self.cell(column)?;
        if cell.is_empty() {
            return Ok(None);
        }
        let value = match self.has_decimal_commas {
            true => cell.replace(',', ".").parse(),
            false => cell.parse(),
        };
        let value: f64 = value.map_err(|_| FormatError::Cell {
            line: self.line,
            field: name.to_owned(),
            found: quoted(cell),
            expected: "a number",
        })?;
        Ok((value > MISSING_BELOW || value.is_nan()).then_some(value))
    }

    fn sample(&self, tool: &Columns) -> Result<TrackSample, FormatError> {
        // The last cell of a row that is cut may lack digits.
        let last = tool.pose.iter().copied().fold(tool.state, usize::max);
        if self.is_cut && self.cells.len() <= last + 1 {
            return Ok(TrackSample { frame: None, time_s: None, pose: Err(Unusable::Cut) });
        }
        let state = self.cell(tool.state)?;
        let mut numbers = [Some(0.0); 7];
        for ((number, column), name) in numbers.iter_mut().zip(tool.pose).zip(POSE) {
            *number = self.number(column, name)?;
        }
        let pose = match numbers {
            // What is missing has a state too, and that says more.
            _ if !state.is_empty() && state != GOOD => Err(Unusable::State(state.to_owned())),
            [Some(w), Some(qx), Some(qy), Some(qz), Some(x), Some(y), Some(z)] => {
                pose([x, y, z], [w, qx, qy, qz])
            }
            _ => Err(Unusable::Missing),
        };
        let counted = |column: Option<usize>, name| match column {
            Some(column) => self.number(column, name),
            None => Ok(None),
        };
        let frame = counted(tool.frame, "Frame")?;
        Ok(TrackSample {
            // A counter of 32 bits, exact in a double.
            frame: frame.filter(|frame| *frame >= 0.0).map(|frame| frame as u64),
            time_s: counted(tool.time, "Time")?,
            pose,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Vector3;
    use proptest::prelude::*;
    use trackwright_geometry::pose::Pose;

    const TSV: &str = "Tools\tPort 1: A  s/n:1\tFrame\tFace\tState\tQ0\tQx\tQy\tQz\tTx\tTy\tTz\tError\tMarkers\tState\tTx\tTy\tTz\tPort 2: B\tFrame\tFace\tState\tQ0\tQx\tQy\tQz\tTx\tTy\tTz\tError\tMarkers\n\
        2\tPort 1: A  s/n:1\t8\t1\tOK\t1\t0\t0\t0\t1.5\t2\t3\t0.1\t1\tOK\t9\t9\t9\tPort 2: B\t9\t1\tBad Fit\t-3.697314E28\t0\t0\t0\t0\t0\t0\t0\t0\n\
        2\tPort 1: A  s/n:1\t24\t1\tOK\t0\t0\t1\t0\t4\t5\t6\t0.1\t0\t\t\t\t\tPort 2: B\t25\t1\t\t-3.697314E28\t-3.697314E28\t-3.697314E28\t-3.697314E28\t-3.697314E28\t-3.697314E28\t-3.697314E28\t0\t0\n";

    #[test]
    fn tools_are_told_apart_and_what_is_bad_says_why() {
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
    fn commas_between_cells_and_commas_in_numbers_are_read_alike() {
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
        for (text, expected) in [
            ("Tools\tFrame\n", "line 1: found \"Tools\\tFrame\""),
            ("Tools\n", "line 1: found \"Tools\""),
            (TSV.lines().next().unwrap(), "found no rows"),
            (&TSV.replace("1.5", "one"), "line 2: Tx is \"one\""),
            (
                &TSV.replace("Bad Fit\t-3.697314E28\t0\t0\t0\t0\t0\t0\t0\t0", "Bad Fit"),
                "line 2: found 22 cells",
            ),
        ] {
            let error = parse(text.as_bytes()).unwrap_err().to_string();
            assert!(error.starts_with(expected), "{error}");
        }
    }

    #[test]
    fn a_table_cut_anywhere_panics_nowhere_and_keeps_what_was_whole() {
        let header = TSV.find('\n').unwrap();
        for end in 0..TSV.len() {
            let found = parse(&TSV.as_bytes()[..end]);
            if end > header + 1 {
                let tools = found.unwrap().tools;
                let good: Vec<_> = tools.iter().flat_map(ToolTrack::good).collect();
                // No number that lacks digits is taken for one.
                let is_known = |p: &&Pose| [1.5, 4.0].contains(&p.translation.x);
                assert!(good.iter().all(is_known), "{end}");
            }
        }
        let cut = parse(&TSV.as_bytes()[..TSV.len() - 100]).unwrap();
        assert_eq!(cut.tools[0].good().count(), 2);
        assert_eq!(cut.tools[1].samples[1].pose, Err(Unusable::Cut));
    }

    proptest! {
        #[test]
        fn no_bytes_panic(bytes in prop::collection::vec(any::<u8>(), 0..200)) {
            let _ = parse(&[b"Tools\tPort 1\tState\tQ0\tQx\tQy\tQz\tTx\tTy\tTz\n", &bytes[..]].concat());
        }
    }
}
