//! Which of the tools that a tracker reports are the bodies of a design.

use std::collections::BTreeMap;
use trackwright_design::BodyRole;

/// Names that labs give to what they point with, and to what is fixed to the patient, as PLUS's and
/// 3D Slicer's own configurations have them; letters and digits in lower case.
const USUAL_TOOLS: [&str; 6] = ["stylus", "pointer", "probe", "tool", "needle", "instrument"];
const USUAL_CRFS: [&str; 5] = ["reference", "ref", "crf", "drf", "patientreference"];

/// What a design's bodies are called.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct BodyNames {
    pub tool: String,
    /// `None` where the design has no CRF.
    pub crf: Option<String>,
}

/// The tools that the user has assigned: a body, or none of them.
pub type Assigned = BTreeMap<String, Option<BodyRole>>;

/// The tool that each body is received as, if any.
///
/// The user's assignment goes first; then a tool called like the body; then, where the other body's
/// name does not fit it as well, one of a usual name. `StylusToTracker` is called `Stylus`. Of two
/// that fit alike it is the first in the order of names.
pub fn roles<'n>(
    received: impl Iterator<Item = &'n str> + Clone,
    names: &BodyNames,
    assigned: &Assigned,
) -> BTreeMap<BodyRole, String> {
    let mut roles = BTreeMap::new();
    let roles_there =
        (BodyRole::ALL.into_iter()).filter(|role| *role == BodyRole::Tool || names.crf.is_some());
    for role in roles_there.clone() {
        if let Some(name) = received.clone().find(|name| assigned.get(*name) == Some(&Some(role))) {
            roles.insert(role, name.to_owned());
        }
    }
    let free = received.filter(|name| !assigned.contains_key(*name));
    for fits in [is_called_so as Fits, is_called_as_usual] {
        for role in roles_there.clone() {
            if roles.contains_key(&role) {
                continue;
            }
            let fitting = (free.clone())
                .filter(|name| !roles.values().any(|taken| taken == name))
                .find(|name| fits(&plain(base_name(name)), role, names));
            if let Some(name) = fitting {
                roles.insert(role, name.to_owned());
            }
        }
    }
    roles
}

type Fits = fn(&str, BodyRole, &BodyNames) -> bool;

fn is_called_so(called: &str, role: BodyRole, names: &BodyNames) -> bool {
    let name = match role {
        BodyRole::Tool => Some(&names.tool),
        BodyRole::Crf => names.crf.as_ref(),
    };
    !called.is_empty() && name.is_some_and(|name| plain(name) == called)
}

fn is_called_as_usual(called: &str, role: BodyRole, _: &BodyNames) -> bool {
    match role {
        BodyRole::Tool => USUAL_TOOLS.contains(&called),
        BodyRole::Crf => USUAL_CRFS.contains(&called),
    }
}

fn plain(name: &str) -> String {
    (name.chars().filter(|c| c.is_alphanumeric())).flat_map(char::to_lowercase).collect()
}

/// `Tracker` of `StylusToTracker`.
pub fn target_frame(name: &str) -> Option<&str> {
    split(name).map(|(_, frame)| frame)
}

/// `Stylus` of `StylusToTracker`, and of `Stylus`.
///
/// ```
/// use trackwright_openigtlink::roles::{base_name, target_frame};
/// assert_eq!(base_name("StylusToTracker"), "Stylus");
/// assert_eq!(target_frame("StylusToTracker"), Some("Tracker"));
/// assert_eq!((base_name("Stylus"), target_frame("Stylus")), ("Stylus", None));
/// ```
pub fn base_name(name: &str) -> &str {
    split(name).map_or(name, |(tool, _)| tool)
}

fn split(name: &str) -> Option<(&str, &str)> {
    name.rmatch_indices("To")
        .filter(|(at, _)| *at > 0)
        .filter_map(|(at, to)| Some((name.get(..at)?, name.get(at + to.len()..)?)))
        .find(|(_, frame)| frame.starts_with(|c: char| c.is_ascii_uppercase()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use BodyRole::{Crf, Tool};

    fn of(received: &[&str], assigned: &[(&str, Option<BodyRole>)]) -> Vec<(BodyRole, String)> {
        let names =
            BodyNames { tool: "Long pointer".to_owned(), crf: Some("Head frame".to_owned()) };
        let assigned = (assigned.iter()).map(|(name, role)| ((*name).to_owned(), *role)).collect();
        (roles(received.iter().copied(), &names, &assigned).into_iter()).collect()
    }

    fn pairs(expected: &[(BodyRole, &str)]) -> Vec<(BodyRole, String)> {
        (expected.iter()).map(|(role, name)| (*role, (*name).to_owned())).collect()
    }

    #[test]
    fn a_tool_named_as_a_body_comes_first() {
        let received = ["LongPointerToTracker", "HeadFrame", "StylusToTracker", "Reference"];
        let expected = pairs(&[(Tool, "LongPointerToTracker"), (Crf, "HeadFrame")]);
        assert_eq!(of(&received, &[]), expected);
        let expected = pairs(&[(Tool, "StylusToTracker"), (Crf, "ReferenceToTracker")]);
        assert_eq!(of(&["ReferenceToTracker", "StylusToTracker"], &[]), expected);
        assert_eq!(of(&["Something", "To", "", "ToTracker"], &[]), []);
    }

    #[test]
    fn assignments_come_first() {
        let received = ["Coil 3", "Reference", "Stylus"];
        let assigned = [("Coil 3", Some(Tool)), ("Reference", None)];
        assert_eq!(of(&received, &assigned), pairs(&[(Tool, "Coil 3")]));
        // A tool that is not received is not looked for further.
        let expected = pairs(&[(Tool, "Stylus"), (Crf, "Reference")]);
        assert_eq!(of(&received, &[("Gone", Some(Tool))]), expected);
        let both = [("Stylus", Some(Crf))];
        assert_eq!(of(&received, &both), pairs(&[(Crf, "Stylus")]));
    }

    #[test]
    fn a_design_without_a_crf_finds_none() {
        let names = BodyNames { tool: "x".to_owned(), crf: None };
        let found = roles(["Reference", "Ref"].into_iter(), &names, &Assigned::new());
        assert_eq!(found, BTreeMap::new());
    }

    #[test]
    fn a_name_has_the_tool_and_its_frame() {
        for (name, tool, frame) in [
            ("StylusToTracker", "Stylus", Some("Tracker")),
            ("ToolTip", "ToolTip", None),
            ("AToBToCup", "AToB", Some("Cup")),
            ("ToTracker", "ToTracker", None),
            ("ÄToÖ", "ÄToÖ", None),
        ] {
            assert_eq!((base_name(name), target_frame(name)), (tool, frame), "{name}");
        }
    }
}
