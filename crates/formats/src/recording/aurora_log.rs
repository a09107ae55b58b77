//! Logs of an Aurora as comma-separated text: some lines of heading, then `Sample, Hour, Minutes,
//! Seconds, ms` and seven cells a sensor, `X, Y, Z, qo, qx, qy, qz`; a sensor that is missing has
//! seven zeros.

use super::rows::pose;
use crate::error::{FormatError, quoted, text};
use trackwright_simulation::recording::{Recording, ToolTrack, TrackSample, Unusable};

/// Cells before those of the first sensor.
const BEFORE: usize = 5;

/// Cells of a sensor.
const EACH: usize = 7;

const SECONDS_A_DAY: f64 = 86_400.0;

/// Whether a line names the columns.
pub fn is_header(line: &str) -> bool {
    let mut cells = line.split(',').map(str::trim);
    let names = ["Sample", "Hour", "Minutes", "Seconds", "ms"];
    names.iter().all(|name| cells.next().is_some_and(|cell| cell.trim_end_matches(':') == *name))
}

/// Reads a log; times run on over midnight.
///
/// # Errors
/// No line that names the columns, rows of another length, cells that are no numbers, no rows.
pub fn parse(bytes: &[u8]) -> Result<Recording, FormatError> {
    let text = text(bytes)?;
    let mut lines = (1..).zip(text.trim_end().lines()).peekable();
    let expected =
        "Sample, Hour, Minutes, Seconds, ms, and X, Y, Z, qo, qx, qy, qz for each sensor";
    let found = lines.by_ref().find(|(_, line)| is_header(line));
    let (header_line, header) = found.ok_or_else(|| {
        let found = quoted(text.lines().next().unwrap_or(""));
        FormatError::line(1, found, format!("a line that names the columns: {expected}"))
    })?;
    let names = cells(header);
    if names.len() <= BEFORE || !(names.len() - BEFORE).is_multiple_of(EACH) {
        return Err(FormatError::line(header_line, format!("{} columns", names.len()), expected));
    }
    let mut tracks: Vec<ToolTrack> = names[BEFORE..]
        .chunks(EACH)
        .enumerate()
        .map(|(index, names)| ToolTrack {
            // `Xa` is the place of sensor a.
            name: match names[0].strip_prefix('X') {
                Some(letter) if !letter.is_empty() => letter.to_owned(),
                _ => (index + 1).to_string(),
            },
            samples: Vec::new(),
        })
        .collect();
    let mut clock = Clock::default();
    while let Some((line, content)) = lines.next() {
        if content.trim().is_empty() {
            continue;
        }
        let mut cells = cells(content);
        let is_cut = lines.peek().is_none() && cells.len() < names.len();
        if is_cut {
            // The number that the file ends in may lack digits.
            cells.pop();
        } else if cells.len() != names.len() {
            let expected = format!("{}, as the line that names them has", names.len());
            return Err(FormatError::line(line, format!("{} cells", cells.len()), expected));
        }
        let mut numbers = Vec::with_capacity(cells.len());
        for (cell, name) in cells.iter().zip(&names) {
            let number = cell.parse::<f64>();
            numbers.push(
                number.map_err(|_| FormatError::cell(line, *name, quoted(cell), "a number"))?,
            );
        }
        let time_s = clock.seconds(&numbers);
        let frame = numbers.first().filter(|n| **n >= 0.0).map(|n| *n as u64);
        for (track, first) in tracks.iter_mut().zip((BEFORE..).step_by(EACH)) {
            track.samples.push(TrackSample {
                frame,
                time_s,
                pose: match numbers.get(first..first + EACH) {
                    Some(values @ [x, y, z, w, qx, qy, qz]) if values.iter().any(|v| *v != 0.0) => {
                        pose([*x, *y, *z], [*w, *qx, *qy, *qz])
                    }
                    Some(_) => Err(Unusable::Missing),
                    None => Err(Unusable::Cut),
                },
            });
        }
    }
    if tracks.first().is_none_or(|track| track.samples.is_empty()) {
        return Err(FormatError::NoRows);
    }
    Ok(Recording { tools: tracks })
}

/// Without the empty one behind a comma at the end.
fn cells(line: &str) -> Vec<&str> {
    let line = line.trim_end();
    let line = line.strip_suffix(',').unwrap_or(line);
    line.split(',').map(str::trim).collect()
}

/// The time of day, made to go on over midnight.
#[derive(Default)]
struct Clock {
    days: f64,
    last_s: Option<f64>,
}

impl Clock {
    /// From `Sample, Hour, Minutes, Seconds, ms`.
    fn seconds(&mut self, row: &[f64]) -> Option<f64> {
        let [_, hours, minutes, seconds, milliseconds, ..] = row else {
            return None;
        };
        let of_day_s = hours * 3600.0 + minutes * 60.0 + seconds + milliseconds / 1000.0;
        // A clock that is set back by less than half a day is that, and no midnight.
        let is_midnight = self.last_s.is_some_and(|last_s| of_day_s < last_s - SECONDS_A_DAY / 2.0);
        if is_midnight {
            self.days += 1.0;
        }
        self.last_s = Some(of_day_s);
        let time_s = self.days * SECONDS_A_DAY + of_day_s;
        time_s.is_finite().then_some(time_s)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::recording::test_cuts::assert_cut_keeps_places;
    use crate::test_cases::assert_refused;

    const LOG: &str = "Test Date: \nday, month\n2, 2 \n\nSample:,Hour,Minutes,Seconds,ms,Xa,Ya,Za,qoa,qxa,qya,qza,Xb,Yb,Zb,qob,qxb,qyb,qzb\n\
        1, 23 , 59 , 59, 900,0, 0, 0, 0, 0, 0, 0, 10.5 , -1 , -200, 0.8 , 0.6 , 0, 0, \n\
        2, 0 , 0 , 0, 100,1, 2, 3, 1, 0, 0, 0, 1, 2, 3, 0.5, 0, 0, 0, \n";

    #[test]
    fn sensors_have_letters_and_zeros_are_missing() {
        let found = parse(LOG.as_bytes()).unwrap();
        let [a, b] = found.tools.as_slice() else { panic!("two sensors") };
        assert_eq!((a.name.as_str(), b.name.as_str()), ("a", "b"));
        assert_eq!(a.samples[0].pose, Err(Unusable::Missing));
        let at = a.samples[1].pose.as_ref().unwrap().translation.vector;
        assert_eq!([at.x, at.y, at.z], [1.0, 2.0, 3.0]);
        // Half a quaternion.
        assert_eq!(b.samples[1].pose, Err(Unusable::NoPose));
        let [first, second] = [0, 1].map(|k| a.samples[k].time_s.unwrap());
        assert!((second - first - 0.2).abs() < 1e-9, "{first} {second}");
    }

    #[test]
    fn what_is_no_such_log_is_named_with_its_line() {
        let refusal = |text: &str| parse(text.as_bytes()).unwrap_err().to_string();
        assert!(refusal("").starts_with("line 1: found \"\", expected a line that names"));
        let heading: Vec<_> = LOG.lines().take(5).collect();
        assert_eq!(refusal(&heading.join("\n")), FormatError::NoRows.to_string());
        let cases = r#"
            ,qzb => | line 5: found 18 columns…
            0.8 , 0.6 , 0, 0, => | line 6: found 15 cells…
            10.5 => ten | line 6: Xb is "ten"…
        "#;
        assert_refused(LOG, cases, refusal);
    }

    #[test]
    fn a_cut_log_keeps_its_whole_rows() {
        let rows = LOG.find("1, 23").unwrap();
        assert_cut_keeps_places(LOG, (rows, 0), [1.0, 10.5], parse);
        let cut = LOG.find("2, 3, 0.5").unwrap();
        let found = parse(&LOG.as_bytes()[..cut]).unwrap();
        assert_eq!(found.tools[0].good().count(), 1);
        assert_eq!(found.tools[1].samples[1].pose, Err(Unusable::Cut));
    }
}
