//! What a tracker recorded: tools over time, and which of their samples it stands by.

use std::borrow::Cow;
use std::collections::{BTreeMap, HashMap};
use trackwright_geometry::pose::Pose;

/// A recording of one or several tools; `tracker_from_tool`, mm.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Recording {
    pub tools: Vec<ToolTrack>,
}

/// One tool, in the order of its samples.
#[derive(Clone, Debug, PartialEq)]
pub struct ToolTrack {
    /// As the file has it: a port with a part and a serial number, or a transform's name.
    pub name: String,
    pub samples: Vec<TrackSample>,
}

/// What was known of a tool at one moment.
#[derive(Clone, Debug, PartialEq)]
pub struct TrackSample {
    /// The tracker's own counter, which runs unevenly and belongs to this tracker alone.
    pub frame: Option<u64>,
    /// Seconds, from wherever the file counts.
    pub time_s: Option<f64>,
    pub pose: Result<Pose, Unusable>,
}

/// Why a sample is not used.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, thiserror::Error)]
pub enum Unusable {
    #[error("missing")]
    Missing,
    /// In the tracker's words.
    #[error("{0}")]
    State(String),
    #[error("its numbers are no pose")]
    NoPose,
    /// As a program that crashed leaves it.
    #[error("the file ends within it")]
    Cut,
}

impl ToolTrack {
    /// The poses that the tracker called good.
    pub fn good(&self) -> impl Iterator<Item = &Pose> {
        self.samples.iter().filter_map(|sample| sample.pose.as_ref().ok())
    }

    /// How many samples are not used, by reason.
    pub fn unusable(&self) -> BTreeMap<&Unusable, usize> {
        let mut counts = BTreeMap::new();
        for reason in self.samples.iter().filter_map(|s| s.pose.as_ref().err()) {
            *counts.entry(reason).or_default() += 1;
        }
        counts
    }
}

/// No tool, or not the one that was meant.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum ToolChoiceError {
    #[error("found no tool, expected one at least")]
    None,
    #[error("found {} tools ({}), expected the name of one, or a part of it", .0.len(), .0.join("; "))]
    Several(Vec<String>),
    #[error(
        "found {tool:?} and {reference:?} recorded at no moment in common, expected one counter or one clock"
    )]
    NotTogether { tool: String, reference: String },
    #[error("found no tool with {wanted:?} in its name, expected one of {}", .names.join("; "))]
    NotThere { wanted: String, names: Vec<String> },
}

impl Recording {
    /// The tool that is meant, relative to another one of the recording where that is named. A name such as
    /// `StylusToReference` that no tool has is made of `StylusToTracker` and `ReferenceToTracker`, whatever
    /// the frame is called that both are in.
    ///
    /// # Errors
    /// As [`Self::tool`]; tools that were not recorded at the same moments.
    pub fn track(
        &self,
        wanted: Option<&str>,
        reference: Option<&str>,
    ) -> Result<Cow<'_, ToolTrack>, ToolChoiceError> {
        if let Some(reference) = reference {
            let (tool, reference) = (self.tool(wanted)?, self.tool(Some(reference))?);
            return relative(tool, reference).map(Cow::Owned);
        }
        match (self.tool(wanted), wanted.and_then(|name| self.both_of(name))) {
            (Err(ToolChoiceError::NotThere { .. }), Some((tool, reference))) => {
                relative(tool, reference).map(Cow::Owned)
            }
            (found, _) => found.map(Cow::Borrowed),
        }
    }

    /// The tools A and B in one frame, of a name `AToB`.
    fn both_of(&self, name: &str) -> Option<(&ToolTrack, &ToolTrack)> {
        let name = name.strip_suffix("Transform").unwrap_or(name);
        let (tool, reference) = name.split_once("To")?;
        let others = |of: &str| {
            let of = format!("{of}To");
            let own = move |tool: &'_ ToolTrack| tool.name.strip_prefix(&of).map(str::to_owned);
            self.tools.iter().filter_map(move |tool| Some((own(tool)?, tool)))
        };
        let mut pairs = others(tool).flat_map(|(frame, tool)| {
            let same = others(reference).filter(move |(other, _)| *other == frame);
            same.map(move |(_, reference)| (tool, reference))
        });
        pairs.next()
    }

    /// The tool with a text in its name, or the only one.
    ///
    /// # Errors
    /// None such, or several.
    pub fn tool(&self, wanted: Option<&str>) -> Result<&ToolTrack, ToolChoiceError> {
        let names = |tools: &[&ToolTrack]| tools.iter().map(|tool| tool.name.clone()).collect();
        let all: Vec<&ToolTrack> = self.tools.iter().collect();
        let found: Vec<&ToolTrack> = match wanted {
            Some(wanted) => {
                let is_it = |tool: &&ToolTrack| tool.name.contains(wanted);
                all.iter().copied().filter(is_it).collect()
            }
            None => all.clone(),
        };
        match (found.as_slice(), wanted) {
            ([tool], _) => Ok(tool),
            ([], None) => Err(ToolChoiceError::None),
            ([], Some(wanted)) => {
                Err(ToolChoiceError::NotThere { wanted: wanted.to_owned(), names: names(&all) })
            }
            (several, Some(wanted)) => several
                .iter()
                .find(|tool| tool.name == wanted)
                .copied()
                .ok_or_else(|| ToolChoiceError::Several(names(several))),
            (several, None) => Err(ToolChoiceError::Several(names(several))),
        }
    }
}

/// A tool in the frame of another, at the moments of both.
fn relative(tool: &ToolTrack, reference: &ToolTrack) -> Result<ToolTrack, ToolChoiceError> {
    type Moment = (Option<u64>, Option<u64>);
    let moment =
        |sample: &TrackSample| -> Moment { (sample.frame, sample.time_s.map(f64::to_bits)) };
    let is_row_by_row = tool.samples.len() == reference.samples.len()
        && tool.samples.iter().zip(&reference.samples).all(|(a, b)| moment(a) == moment(b));
    let by_moment: HashMap<Moment, &TrackSample> = match is_row_by_row {
        true => HashMap::new(),
        false => reference
            .samples
            .iter()
            .map(|sample| (moment(sample), sample))
            .filter(|(moment, _)| *moment != (None, None))
            .collect(),
    };
    let each = tool.samples.iter().enumerate().filter_map(|(row, sample)| {
        let other = match is_row_by_row {
            true => reference.samples.get(row)?,
            false => by_moment.get(&moment(sample))?,
        };
        let pose = match (&sample.pose, &other.pose) {
            (Ok(tool), Ok(reference)) => Ok(reference.inv_mul(tool)),
            (Err(reason), _) | (_, Err(reason)) => Err(reason.clone()),
        };
        Some(TrackSample { pose, ..sample.clone() })
    });
    let samples: Vec<TrackSample> = each.collect();
    match samples.is_empty() {
        true => Err(ToolChoiceError::NotTogether {
            tool: tool.name.clone(),
            reference: reference.name.clone(),
        }),
        false => Ok(ToolTrack { name: format!("{} in {}", tool.name, reference.name), samples }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn recording(names: &[&str]) -> Recording {
        let tool = |name: &&str| ToolTrack { name: (*name).to_owned(), samples: Vec::new() };
        Recording { tools: names.iter().map(tool).collect() }
    }

    #[test]
    fn a_tool_is_given_in_the_frame_of_another() {
        let sample = |x: f64, frame: u64| TrackSample {
            frame: Some(frame),
            time_s: None,
            pose: Ok(Pose::translation(x, 0.0, 0.0)),
        };
        let mut both = recording(&["StylusToTracker", "ReferenceToTracker"]);
        both.tools[0].samples = vec![sample(50.0, 1), sample(52.0, 2)];
        both.tools[1].samples = vec![sample(40.0, 2), sample(39.0, 3)];
        let by_name = both.track(Some("StylusToReference"), None).unwrap();
        let by_option = both.track(Some("Stylus"), Some("Reference")).unwrap();
        assert_eq!(by_name.samples, by_option.samples);
        let [only] = by_name.samples.as_slice() else {
            panic!("{by_name:?}");
        };
        assert_eq!(only.pose, Ok(Pose::translation(12.0, 0.0, 0.0)));
        assert_eq!(both.track(Some("Stylus"), None).unwrap().samples.len(), 2);
        both.tools[1].samples.truncate(0);
        let apart = both.track(Some("StylusToReference"), None);
        assert!(matches!(apart, Err(ToolChoiceError::NotTogether { .. })));
        let unknown = both.track(Some("ProbeToReference"), None);
        assert!(matches!(unknown, Err(ToolChoiceError::NotThere { .. })));
    }

    #[test]
    fn a_tool_needs_a_name_only_among_several() {
        assert_eq!(recording(&["a"]).tool(None).unwrap().name, "a");
        assert_eq!(recording(&[]).tool(None), Err(ToolChoiceError::None));
        let two = recording(&["Port 1: a", "Port 10: b"]);
        assert!(matches!(two.tool(None), Err(ToolChoiceError::Several(names)) if names.len() == 2));
        assert_eq!(two.tool(Some("10")).unwrap().name, "Port 10: b");
        assert!(matches!(two.tool(Some("Port 1")), Err(ToolChoiceError::Several(_))));
        assert!(matches!(two.tool(Some("c")), Err(ToolChoiceError::NotThere { .. })));
        let exact = recording(&["Stylus", "StylusTip"]);
        assert_eq!(exact.tool(Some("Stylus")).unwrap().name, "Stylus");
    }

    #[test]
    fn what_is_not_used_is_counted_by_reason() {
        let sample = |pose| TrackSample { frame: None, time_s: None, pose };
        let bad = || Unusable::State("Bad Fit".to_owned());
        let track = ToolTrack {
            name: "t".to_owned(),
            samples: vec![
                sample(Err(bad())),
                sample(Ok(Pose::identity())),
                sample(Err(Unusable::Missing)),
                sample(Err(bad())),
            ],
        };
        assert_eq!(track.good().count(), 1);
        assert_eq!(track.unusable().len(), 2);
        assert_eq!(track.unusable()[&Unusable::Missing], 1);
        assert_eq!(track.unusable()[&bad()], 2);
    }
}
