//! Recordings of live poses: a table that grows by whole lines, one a sample.
//!
//! `received_s,time_s,tool,state,x,y,z,qw,qx,qy,qz`: seconds since 1970 by this machine's clock and
//! by the sender's, where it states any; the tool; `OK`, or why there is no pose to be used; mm and a
//! unit quaternion, as measured. No count and no end have to be written, so that what a crash leaves
//! is a recording up to its last line.

use super::rows::{Tools, pose};
use crate::error::{FormatError, quoted, text};
use crate::table_dialect::{cut_cells, quoted_cells};
use trackwright_geometry::number::shortest;
use trackwright_geometry::pose::{Pose, pose_to_array};
use trackwright_simulation::recording::{Recording, TrackSample, Unusable};

/// The first line.
pub const HEADER: &str = "received_s,time_s,tool,state,x,y,z,qw,qx,qy,qz";

const CELLS: usize = 11;

/// The state of a sample that the tracker stands by.
const GOOD: &str = "OK";

/// One line of a recording.
#[derive(Clone, Debug, PartialEq)]
pub struct LiveSample<'a> {
    pub received_s: f64,
    pub time_s: Option<f64>,
    pub tool: &'a str,
    pub pose: Result<Pose, Unusable>,
}

/// Whether a line is the first of such a table.
pub fn is_header(line: &str) -> bool {
    line.trim() == HEADER
}

/// Adds a line.
pub fn write_row(out: &mut Vec<u8>, sample: &LiveSample) {
    let mut cells = vec![
        format!("{:.6}", sample.received_s),
        sample.time_s.map(|s| format!("{s:.6}")).unwrap_or_default(),
        quoted_cell(sample.tool),
    ];
    match &sample.pose {
        Ok(pose) => {
            cells.push(GOOD.to_owned());
            cells.extend(pose_to_array(pose).map(shortest));
        }
        Err(reason) => {
            cells.push(quoted_cell(&reason.to_string()));
            cells.resize(CELLS, String::new());
        }
    }
    out.extend_from_slice(cells.join(",").as_bytes());
    out.push(b'\n');
}

/// A whole recording as such a table, tool after tool. It counts as received when it was sent.
pub fn write(recording: &Recording) -> Vec<u8> {
    let mut out = format!("{HEADER}\n").into_bytes();
    for tool in &recording.tools {
        for sample in &tool.samples {
            let row = LiveSample {
                received_s: sample.time_s.unwrap_or_default(),
                time_s: sample.time_s,
                tool: &tool.name,
                pose: sample.pose.clone(),
            };
            write_row(&mut out, &row);
        }
    }
    out
}

/// A cell in quotes where it needs them; a line stays a line.
fn quoted_cell(text: &str) -> String {
    let text: String = text.chars().map(|c| if c.is_control() { ' ' } else { c }).collect();
    match text.contains([',', '"']) || text.trim() != text {
        true => format!("\"{}\"", text.replace('"', "\"\"")),
        false => text,
    }
}

/// Reads a recording; what the file ends within is a sample that is cut, of the tool that it names
/// or else of the one before.
///
/// # Errors
/// Lines that are no samples, no lines.
pub fn parse(bytes: &[u8]) -> Result<Recording, FormatError> {
    let text = text(whole_characters(bytes))?;
    let (whole, cut) = match text.rfind('\n') {
        Some(end) => text.split_at(end + 1),
        None => ("", text),
    };
    let mut lines = (1..).zip(whole.lines());
    match lines.next() {
        Some((_, header)) if is_header(header) => {}
        other => {
            let found = quoted(other.map_or(cut, |(_, line)| line));
            return Err(FormatError::line(1, found, HEADER));
        }
    }
    let mut tools = Tools::default();
    let mut last = None;
    for (line, content) in lines.filter(|(_, content)| !content.trim().is_empty()) {
        let (tool, sample) = Row { line, cells: quoted_cells(line, content)? }.sample()?;
        tools.push(&tool, sample);
        last = Some(tool);
    }
    if !cut.is_empty() {
        let cells = cut_cells(0, cut)?;
        // The last cell may lack letters.
        let own = cells.get(2).filter(|_| cells.len() > 3).map(str::to_owned);
        if let Some(tool) = own.or(last) {
            let sample = TrackSample { frame: None, time_s: None, pose: Err(Unusable::Cut) };
            tools.push(&tool, sample);
        }
    }
    tools.finish()
}

/// Without the beginning of a character that the file ends in.
fn whole_characters(bytes: &[u8]) -> &[u8] {
    match std::str::from_utf8(bytes) {
        Err(error) if error.error_len().is_none() => {
            bytes.get(..error.valid_up_to()).unwrap_or(bytes)
        }
        _ => bytes,
    }
}

struct Row {
    line: u64,
    cells: csv::StringRecord,
}

impl Row {
    fn number(&self, column: usize) -> Result<Option<f64>, FormatError> {
        let cell = self.cells.get(column).unwrap_or("");
        if cell.is_empty() {
            return Ok(None);
        }
        let value = cell.parse().ok().filter(|value: &f64| value.is_finite());
        value.map(Some).ok_or_else(|| {
            let name = HEADER.split(',').nth(column).unwrap_or("");
            FormatError::cell(self.line, name, quoted(cell), "a number")
        })
    }

    fn sample(&self) -> Result<(String, TrackSample), FormatError> {
        let cell = |column: usize| self.cells.get(column).unwrap_or("");
        let [received, time, tool, state] = [0, 1, 2, 3].map(cell);
        if self.cells.len() != CELLS || received.is_empty() {
            let found = format!("{} cells", self.cells.len());
            return Err(FormatError::line(self.line, found, format!("{CELLS}: {HEADER}")));
        }
        let mut numbers = [None; 7];
        for (number, column) in numbers.iter_mut().zip(CELLS - 7..) {
            *number = self.number(column)?;
        }
        let measured = match (state, numbers) {
            (GOOD, [Some(x), Some(y), Some(z), Some(w), Some(qx), Some(qy), Some(qz)]) => {
                pose([x, y, z], [w, qx, qy, qz])
            }
            (GOOD | "missing", _) => Err(Unusable::Missing),
            (state, _) if state == Unusable::NoPose.to_string() => Err(Unusable::NoPose),
            (state, _) => Err(Unusable::State(state.to_owned())),
        };
        // The sender's own time, where it states any: the network's delays are not in it.
        let at = if time.is_empty() { 0 } else { 1 };
        let sample = TrackSample { frame: None, time_s: self.number(at)?, pose: measured };
        Ok((tool.to_owned(), sample))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_cases::{any_text, assert_refused};
    use proptest::prelude::*;
    use trackwright_geometry::pose::pose_from_array;

    fn table(samples: &[LiveSample]) -> Vec<u8> {
        let mut bytes = format!("{HEADER}\n").into_bytes();
        for sample in samples {
            write_row(&mut bytes, sample);
        }
        bytes
    }

    fn samples() -> Vec<LiveSample<'static>> {
        let pose = pose_from_array([1.25, -2.5, -300.0, 0.5, 0.5, -0.5, 0.5]).unwrap();
        let sample = |tool, time_s, pose| LiveSample { received_s: 100.5, time_s, tool, pose };
        vec![
            sample("StylusToTracker", Some(7.25), Ok(pose)),
            sample("a, \"b\" ü", None, Ok(pose)),
            sample("StylusToTracker", Some(7.5), Err(Unusable::State("INVALID, far".to_owned()))),
            sample("StylusToTracker", Some(7.75), Err(Unusable::Missing)),
            sample("StylusToTracker", Some(8.0), Err(Unusable::NoPose)),
        ]
    }

    #[test]
    fn a_written_recording_is_read_back() {
        let found = parse(&table(&samples())).unwrap();
        assert_eq!(parse(&write(&found)).unwrap(), found);
    }

    #[test]
    fn every_state_and_name_is_read_back() {
        let found = parse(&table(&samples())).unwrap();
        let [stylus, other] = found.tools.as_slice() else { panic!("{found:?}") };
        assert_eq!((stylus.name.as_str(), other.name.as_str()), ("StylusToTracker", "a, \"b\" ü"));
        for (track, expected) in [(stylus, vec![0, 2, 3, 4]), (other, vec![1])] {
            for (sample, index) in track.samples.iter().zip(expected) {
                let written = &samples()[index];
                assert_eq!(sample.pose, written.pose);
                // The sender's clock, or else ours.
                assert_eq!(sample.time_s, written.time_s.or(Some(100.5)));
            }
        }
    }

    #[test]
    fn a_cut_recording_keeps_its_whole_lines() {
        let bytes = table(&samples());
        let first_row = HEADER.len() + 1;
        for end in first_row..bytes.len() {
            let whole = bytes[first_row..end].iter().filter(|&&b| b == b'\n').count();
            let is_cut = bytes[end - 1] != b'\n';
            let found = match parse(&bytes[..end]) {
                Ok(found) => found,
                // Nothing but the beginning of the first line.
                Err(error) => {
                    assert!(whole == 0 && error == FormatError::NoRows, "{end}: {error}");
                    continue;
                }
            };
            let all: Vec<_> = found.tools.iter().flat_map(|tool| &tool.samples).collect();
            let cut = all.iter().filter(|s| s.pose == Err(Unusable::Cut)).count();
            assert_eq!((all.len() - cut, cut), (whole, usize::from(is_cut)), "{end}");
        }
    }

    #[test]
    fn what_is_no_such_table_is_named_with_its_line() {
        let whole = String::from_utf8(table(&samples())).unwrap();
        let refusal = |text: &str| parse(text.as_bytes()).unwrap_err().to_string();
        assert!(refusal("").starts_with("line 1: found \"\", expected received_s"));
        assert_eq!(refusal(&format!("{HEADER}\n")), FormatError::NoRows.to_string());
        let cases = r#"
            -300, => | line 2: found 10 cells, expected 11…
            -300, => far, | line 2: z is "far", expected a number
            -300, => NaN, | line 2: z is "NaN", expected a number
        "#;
        assert_refused(&whole, cases, refusal);
        // Numbers that are no pose are no error, but no pose either.
        let found = parse(whole.replacen("0.5,0.5,", "0.1,0.1,", 1).as_bytes()).unwrap();
        assert_eq!(found.tools[0].samples[0].pose, Err(Unusable::NoPose));
    }

    proptest! {
        #[test]
        fn any_name_and_state_stay_one_line(
            tool in any_text(0..30),
            state in any_text(0..30),
        ) {
            let pose = Err(Unusable::State(state));
            let sample = LiveSample { received_s: 1.0, time_s: None, tool: &tool, pose };
            let bytes = table(&[sample.clone(), sample]);
            prop_assert_eq!(bytes.iter().filter(|&&b| b == b'\n').count(), 3);
            let found = parse(&bytes).unwrap();
            prop_assert_eq!(found.tools.len(), 1);
            prop_assert_eq!(found.tools[0].samples.len(), 2);
        }
    }
}
