//! Sequences of PLUS, `.igs.mha` or `.seq.mha`: a heading `Key = Value`, with the transforms of each
//! frame among its keys (DOMAIN 1.5). Images behind the heading are left alone.

use super::quoted;
use crate::formats::error::FormatError;
use crate::formats::matrices;
use crate::geometry::pose::Pose;
use crate::tracking::recording::{Recording, ToolTrack, TrackSample, Unusable};
use std::collections::BTreeMap;

/// The last line of the heading.
const LAST_KEY: &str = "ElementDataFile";

/// Before the number of a frame.
const FRAME: &str = "Seq_Frame";

/// The state of a transform that the tracker stands by.
const GOOD: &str = "OK";

/// Longest heading line that is looked at: sixteen numbers and a name are far shorter.
const MAX_LINE: usize = 4096;

#[derive(Default)]
struct Frame<'a> {
    time_s: Option<f64>,
    /// By name, with the line.
    transforms: BTreeMap<&'a str, (u64, &'a str)>,
    states: BTreeMap<&'a str, &'a str>,
}

/// Reads the transforms of a sequence; each is a tool of its own name, such as `StylusToTracker`.
///
/// # Errors
/// A heading that does not end, transforms of other than 16 numbers or that are none, no frame with
/// one.
pub fn parse(bytes: &[u8]) -> Result<Recording, FormatError> {
    let frames = frames(bytes)?;
    let mut tracks: BTreeMap<&str, Vec<TrackSample>> = BTreeMap::new();
    for name in frames.values().flat_map(|frame| frame.transforms.keys()) {
        tracks.entry(name).or_default();
    }
    for (number, frame) in &frames {
        for (name, samples) in &mut tracks {
            samples.push(TrackSample {
                frame: Some(*number),
                time_s: frame.time_s,
                pose: frame.pose(name)?,
            });
        }
    }
    if tracks.is_empty() {
        return Err(FormatError::NoRows);
    }
    let tools = tracks.into_iter().map(|(name, samples)| ToolTrack {
        name: name.to_owned(),
        samples,
    });
    Ok(Recording {
        tools: tools.collect(),
    })
}

impl Frame<'_> {
    fn pose(&self, name: &str) -> Result<Result<Pose, Unusable>, FormatError> {
        if let Some(state) = self.states.get(name).filter(|state| **state != GOOD) {
            return Ok(Err(Unusable::State((*state).to_owned())));
        }
        let Some((line, numbers)) = self.transforms.get(name) else {
            return Ok(Err(Unusable::Missing));
        };
        let none = |found: String| FormatError::Line {
            line: *line,
            found,
            expected: format!("16 numbers of a 4x4 matrix for {name}"),
        };
        match matrices::parse(numbers.as_bytes()) {
            Ok(poses) => match poses.as_slice() {
                [pose] => Ok(Ok(*pose)),
                several => Err(none(format!("{} matrices", several.len()))),
            },
            // Sixteen numbers that are no rotation are the tracker's doing, and a reason to leave
            // the sample out.
            Err(_)
                if numbers
                    .split_whitespace()
                    .filter(|n| n.parse::<f64>().is_ok())
                    .count()
                    == 16 =>
            {
                Ok(Err(Unusable::NoPose))
            }
            Err(_) => Err(none(quoted(numbers))),
        }
    }
}

/// The heading's frames by their numbers.
fn frames(bytes: &[u8]) -> Result<BTreeMap<u64, Frame<'_>>, FormatError> {
    let mut frames: BTreeMap<u64, Frame> = BTreeMap::new();
    let mut last_line = 0;
    for (line, raw) in (1..).zip(bytes.split(|byte| *byte == b'\n')) {
        last_line = line;
        let content = raw
            .get(..raw.len().min(MAX_LINE))
            .and_then(|raw| std::str::from_utf8(raw).ok())
            .ok_or_else(|| FormatError::Line {
                line,
                found: "bytes that are not text".to_owned(),
                expected: "a line of the heading".to_owned(),
            })?;
        let content = content.trim_start_matches('\u{feff}').trim();
        let Some((key, value)) = content.split_once('=') else {
            if content.is_empty() {
                continue;
            }
            return Err(FormatError::Line {
                line,
                found: quoted(content),
                expected: "Key = Value".to_owned(),
            });
        };
        let (key, value) = (key.trim(), value.trim());
        if key == LAST_KEY {
            return Ok(frames);
        }
        let Some((number, name)) = key
            .strip_prefix(FRAME)
            .and_then(|rest| rest.split_once('_'))
            .and_then(|(number, name)| Some((number.parse().ok()?, name)))
        else {
            continue;
        };
        let frame = frames.entry(number).or_default();
        match name {
            "Timestamp" => frame.time_s = value.parse().ok().filter(|t: &f64| t.is_finite()),
            "UnfilteredTimestamp" | "FrameNumber" | "ImageStatus" => {}
            _ => {
                if let Some(transform) = name.strip_suffix("Status") {
                    frame.states.insert(tool_name(transform), value);
                } else if name.ends_with("Transform") || value.split_whitespace().count() == 16 {
                    frame.transforms.insert(tool_name(name), (line, value));
                }
            }
        }
    }
    Err(FormatError::Line {
        line: last_line,
        found: "the end of the file".to_owned(),
        expected: format!("{LAST_KEY}, the last key of the heading"),
    })
}

/// `StylusToTracker` of `StylusToTrackerTransform`; older files have no such ending.
fn tool_name(name: &str) -> &str {
    name.strip_suffix("Transform").unwrap_or(name)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const HEADING: &str = "ObjectType = Image\nDimSize = 0 0 2\n\
        Seq_Frame0000_StylusToTrackerTransform = 1 0 0 4 0 1 0 5 0 0 1 6 0 0 -0 1 \n\
        Seq_Frame0000_StylusToTrackerTransformStatus = OK\n\
        Seq_Frame0000_Old = 1 0 0 7 0 1 0 8 0 0 1 9 0 0 0 1\n\
        Seq_Frame0000_Timestamp = 1.5\nSeq_Frame0000_ImageStatus = INVALID\n\
        Seq_Frame0001_StylusToTrackerTransform = 1 0 0 4 0 1 0 5 0 0 1 6 0 0 0 1 \n\
        Seq_Frame0001_StylusToTrackerTransformStatus = INVALID\n\
        ElementDataFile = LOCAL\n";

    #[test]
    fn each_transform_is_a_tool_and_an_invalid_one_is_not_used() {
        let bytes = [HEADING.as_bytes(), &[0xff, 0, 0x80]].concat();
        let found = parse(&bytes).unwrap();
        let stylus = found.tool(Some("StylusToTracker")).unwrap();
        assert_eq!(stylus.good().count(), 1);
        assert_eq!(stylus.samples[0].time_s, Some(1.5));
        let invalid = Unusable::State("INVALID".to_owned());
        assert_eq!(stylus.samples[1].pose, Err(invalid));
        let old = found.tool(Some("Old")).unwrap();
        assert_eq!(old.samples[0].pose, Ok(Pose::translation(7.0, 8.0, 9.0)));
        assert_eq!(old.samples[1].pose, Err(Unusable::Missing));
    }

    #[test]
    fn what_is_no_such_heading_is_named_with_its_line() {
        for (text, expected) in [
            (
                HEADING.replace("ElementDataFile", "Other"),
                "line 11: found the end of the file",
            ),
            (
                HEADING.replace("DimSize = ", "DimSize "),
                "line 2: found \"DimSize 0 0 2\"",
            ),
            (
                HEADING.replace("5 0 0 1 6", "x 0 0 1 6"),
                "line 3: found \"1 0 0 4 0 1 0 x",
            ),
            (
                "ObjectType = Image\nElementDataFile = LOCAL\n".to_owned(),
                "found no rows",
            ),
        ] {
            let error = parse(text.as_bytes()).unwrap_err().to_string();
            assert!(error.starts_with(expected), "{error}");
        }
    }

    #[test]
    fn a_heading_cut_anywhere_panics_nowhere() {
        for end in 0..HEADING.len() {
            let _ = parse(&HEADING.as_bytes()[..end]);
        }
    }

    proptest! {
        #[test]
        fn no_bytes_panic(bytes in prop::collection::vec(any::<u8>(), 0..200)) {
            let _ = parse(&[b"ObjectType = Image\nSeq_Frame", &bytes[..]].concat());
        }
    }
}
