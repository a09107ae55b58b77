//! Sequences of PLUS, `.igs.mha` or `.seq.mha`: a heading `Key = Value`, with the transforms of each
//! frame among its keys. Images behind the heading are left alone.

use crate::error::{FormatError, quoted};
use crate::matrices;
use std::collections::BTreeMap;
use trackwright_geometry::pose::Pose;
use trackwright_simulation::recording::{Recording, ToolTrack, TrackSample, Unusable};

/// The last line of the heading.
const LAST_KEY: &str = "ElementDataFile";

/// Before the number of a frame.
const FRAME: &str = "Seq_Frame";

/// The state of a transform that the tracker stands by.
const GOOD: &str = "OK";

/// Longest heading line that is looked at: sixteen numbers and a name are far shorter.
const MAX_LINE: usize = 4096;

/// Most samples, missing ones among them, for each frame and each transform in the file. Frames of a
/// tracker name the same transforms; where each named others, samples would grow with the square of
/// the file. Up to so many names do what they like.
const MAX_SAMPLES_EACH: usize = 16;

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
/// one, frames that name other transforms each.
pub fn parse(bytes: &[u8]) -> Result<Recording, FormatError> {
    let frames = frames(bytes)?;
    let mut tracks: BTreeMap<&str, Vec<TrackSample>> = BTreeMap::new();
    for name in frames.values().flat_map(|frame| frame.transforms.keys()) {
        tracks.entry(name).or_default();
    }
    let transforms: usize = frames.values().map(|frame| frame.transforms.len()).sum();
    let samples = tracks.len().saturating_mul(frames.len());
    if samples > (transforms + frames.len()).saturating_mul(MAX_SAMPLES_EACH) {
        return Err(FormatError::field(
            "number of transforms",
            format!("{transforms}, of {} names in {} frames", tracks.len(), frames.len()),
            "frames that name the same transforms",
        ));
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
    let tools =
        tracks.into_iter().map(|(name, samples)| ToolTrack { name: name.to_owned(), samples });
    Ok(Recording { tools: tools.collect() })
}

impl Frame<'_> {
    fn pose(&self, name: &str) -> Result<Result<Pose, Unusable>, FormatError> {
        if let Some(state) = self.states.get(name).filter(|state| **state != GOOD) {
            return Ok(Err(Unusable::State((*state).to_owned())));
        }
        let Some((line, numbers)) = self.transforms.get(name) else {
            return Ok(Err(Unusable::Missing));
        };
        let none = |found: String| {
            FormatError::line(*line, found, format!("16 numbers of a 4x4 matrix for {name}"))
        };
        match matrices::parse_4x4(numbers.as_bytes()) {
            Ok(poses) => match poses.as_slice() {
                [pose] => Ok(Ok(*pose)),
                several => Err(none(format!("{} matrices", several.len()))),
            },
            // Sixteen numbers that are no rotation are the tracker's doing, and a reason to leave
            // the sample out.
            Err(_)
                if numbers.split_whitespace().filter(|n| n.parse::<f64>().is_ok()).count()
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
            .ok_or_else(|| {
                FormatError::line(line, "bytes that are not text", "a line of the heading")
            })?;
        let content = content.trim_start_matches('\u{feff}').trim();
        let Some((key, value)) = content.split_once('=') else {
            if content.is_empty() {
                continue;
            }
            return Err(FormatError::line(line, quoted(content), "Key = Value"));
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
    let expected = format!("{LAST_KEY}, the last key of the heading");
    Err(FormatError::line(last_line, "the end of the file", expected))
}

/// `StylusToTracker` of `StylusToTrackerTransform`; older files have no such ending.
fn tool_name(name: &str) -> &str {
    name.strip_suffix("Transform").unwrap_or(name)
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use crate::test_cases::assert_refused;

    pub(crate) const HEADING: &str = "ObjectType = Image\nDimSize = 0 0 2\n\
        Seq_Frame0000_StylusToTrackerTransform = 1 0 0 4 0 1 0 5 0 0 1 6 0 0 -0 1 \n\
        Seq_Frame0000_StylusToTrackerTransformStatus = OK\n\
        Seq_Frame0000_Old = 1 0 0 7 0 1 0 8 0 0 1 9 0 0 0 1\n\
        Seq_Frame0000_Timestamp = 1.5\nSeq_Frame0000_ImageStatus = INVALID\n\
        Seq_Frame0001_StylusToTrackerTransform = 1 0 0 4 0 1 0 5 0 0 1 6 0 0 0 1 \n\
        Seq_Frame0001_StylusToTrackerTransformStatus = INVALID\n\
        ElementDataFile = LOCAL\n";

    #[test]
    fn each_transform_is_a_tool() {
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
    fn wrong_headings_are_named_with_their_line() {
        let cases = r#"
            ElementDataFile => Other | line 11: found the end of the file…
            DimSize = => DimSize | line 2: found "DimSize 0 0 2"…
            5 0 0 1 6 => x 0 0 1 6 | line 3: found "1 0 0 4 0 1 0 x…
            ObjectType = Image\nElementDataFile = LOCAL\n | found no rows…
        "#;
        assert_refused(HEADING, cases, |text| parse(text.as_bytes()).unwrap_err().to_string());
    }

    #[test]
    fn ever_new_transforms_are_refused() {
        let frames = |count: usize, name: fn(usize) -> usize| {
            let frame = |i| {
                format!("Seq_Frame{i}_t{}Transform = 1 0 0 4 0 1 0 5 0 0 1 6 0 0 0 1\n", name(i))
            };
            let frames: String = (0..count).map(frame).collect();
            parse(format!("ObjectType = Image\n{frames}ElementDataFile = LOCAL\n").as_bytes())
        };
        // 40,000 frames times as many names: 1.6 billion missing samples of a file of 2.6 MB.
        let message = frames(40_000, |i| i).unwrap_err().to_string();
        assert_eq!(
            message,
            "number of transforms is 40000, of 40000 names in 40000 frames, expected frames that name \
             the same transforms"
        );
        // Tools that are seen in turn are no such thing.
        let found = frames(400, |i| i % 16).unwrap();
        assert!(found.tools.iter().all(|tool| tool.good().count() == 25));
        assert!(found.tools.iter().all(|tool| tool.samples.len() == 400));
    }
}
