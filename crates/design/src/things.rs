//! The two bodies of a design, and the things that its view hides or locks: bodies, and sensors and
//! metal objects by their names.

use serde::{Deserialize, Serialize};
use std::collections::BTreeSet;

/// Which of a design's two bodies.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum BodyRole {
    Tool,
    Crf,
}

impl BodyRole {
    pub const ALL: [Self; 2] = [Self::Tool, Self::Crf];

    /// What a person calls it within a sentence.
    pub fn name(self) -> &'static str {
        match self {
            Self::Tool => "tool",
            Self::Crf => "CRF",
        }
    }
}

impl std::fmt::Display for BodyRole {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.name())
    }
}

/// A body, a sensor or a metal object. By name, as places in lists change: a sensor that gets
/// another name is shown again, which does no harm.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub enum Thing {
    Tool,
    Crf,
    ToolSensor(String),
    CrfSensor(String),
    Metal(String),
}

/// Some things of a design. A body stands for its sensors too.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(transparent)]
pub struct Things(BTreeSet<Thing>);

impl Thing {
    pub fn body(role: BodyRole) -> Self {
        match role {
            BodyRole::Tool => Self::Tool,
            BodyRole::Crf => Self::Crf,
        }
    }

    pub fn sensor(role: BodyRole, name: &str) -> Self {
        match role {
            BodyRole::Tool => Self::ToolSensor(name.to_owned()),
            BodyRole::Crf => Self::CrfSensor(name.to_owned()),
        }
    }
}

impl Things {
    pub fn has_body(&self, role: BodyRole) -> bool {
        self.has(&Thing::body(role))
    }

    /// Whether the sensor or its body is among them.
    pub fn has_sensor(&self, role: BodyRole, name: &str) -> bool {
        self.has_body(role) || self.has(&Thing::sensor(role, name))
    }

    /// Whether a metal object of this name is among them.
    pub fn has_metal(&self, name: &str) -> bool {
        self.has(&Thing::Metal(name.to_owned()))
    }

    /// Whether this very thing is among them.
    pub fn has(&self, thing: &Thing) -> bool {
        self.0.contains(thing)
    }

    /// Adds a thing, or takes it out where it is among them.
    pub fn toggle(&mut self, thing: Thing) {
        if !self.0.remove(&thing) {
            self.0.insert(thing);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_body_stands_for_its_sensors_and_no_others() {
        let mut things = Things::default();
        things.toggle(Thing::sensor(BodyRole::Tool, "shaft"));
        assert!(things.has_sensor(BodyRole::Tool, "shaft"));
        assert!(!things.has_sensor(BodyRole::Crf, "shaft"));
        assert!(!things.has_body(BodyRole::Tool));
        things.toggle(Thing::body(BodyRole::Crf));
        assert!(things.has_sensor(BodyRole::Crf, "shaft"));
        assert!(!things.has_sensor(BodyRole::Tool, "grip"));
        things.toggle(Thing::body(BodyRole::Crf));
        assert!(!things.has_sensor(BodyRole::Crf, "shaft"));
    }

    #[test]
    fn things_read_back_as_they_were_written() {
        let mut things = Things::default();
        things.toggle(Thing::Tool);
        things.toggle(Thing::sensor(BodyRole::Crf, "left \"ear\""));
        let text = ron::to_string(&things).unwrap();
        assert_eq!(ron::from_str::<Things>(&text).unwrap(), things);
    }
}
