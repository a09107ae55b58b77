//! What a tracker recorded: tools over time, and which of their samples it stands by.

use crate::geometry::pose::Pose;
use std::collections::BTreeMap;

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
        self.samples
            .iter()
            .filter_map(|sample| sample.pose.as_ref().ok())
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
    #[error("found no tool with {wanted:?} in its name, expected one of {}", .names.join("; "))]
    NotThere { wanted: String, names: Vec<String> },
}

impl Recording {
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
            ([], Some(wanted)) => Err(ToolChoiceError::NotThere {
                wanted: wanted.to_owned(),
                names: names(&all),
            }),
            (several, Some(wanted)) => several
                .iter()
                .find(|tool| tool.name == wanted)
                .copied()
                .ok_or_else(|| ToolChoiceError::Several(names(several))),
            (several, None) => Err(ToolChoiceError::Several(names(several))),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn recording(names: &[&str]) -> Recording {
        let tool = |name: &&str| ToolTrack {
            name: (*name).to_owned(),
            samples: Vec::new(),
        };
        Recording {
            tools: names.iter().map(tool).collect(),
        }
    }

    #[test]
    fn the_only_tool_needs_no_name_and_one_of_several_does() {
        assert_eq!(recording(&["a"]).tool(None).unwrap().name, "a");
        assert_eq!(recording(&[]).tool(None), Err(ToolChoiceError::None));
        let two = recording(&["Port 1: a", "Port 10: b"]);
        assert!(matches!(two.tool(None), Err(ToolChoiceError::Several(names)) if names.len() == 2));
        assert_eq!(two.tool(Some("10")).unwrap().name, "Port 10: b");
        assert!(matches!(
            two.tool(Some("Port 1")),
            Err(ToolChoiceError::Several(_))
        ));
        assert!(matches!(
            two.tool(Some("c")),
            Err(ToolChoiceError::NotThere { .. })
        ));
        let exact = recording(&["Stylus", "StylusTip"]);
        assert_eq!(exact.tool(Some("Stylus")).unwrap().name, "Stylus");
    }

    #[test]
    fn what_is_not_used_is_counted_by_reason() {
        let sample = |pose| TrackSample {
            frame: None,
            time_s: None,
            pose,
        };
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
