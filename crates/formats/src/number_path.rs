//! The numbers of a RON document by their paths, `sensors[1].position.z`, and the document with others in
//! their places.
//!
//! A document with another number is read as any file is: what it may not hold is found there.

use super::nearest::nearest;
use super::ron_tree::{Field, Node};
use serde::{Deserialize, Serialize};
use std::fmt;
use std::fmt::Write;
use std::ops::Range;
use std::str::FromStr;

/// Names of the parts of a point and of a quaternion, beside their numbers in brackets.
const POINT: [&str; 3] = ["x", "y", "z"];
const QUATERNION: [&str; 4] = ["w", "x", "y", "z"];

/// The way to a number in a document.
#[derive(Clone, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub struct NumberPath(Vec<Step>);

#[derive(Clone, Debug, PartialEq, Eq, Hash)]
enum Step {
    Field(String),
    Item(usize),
    /// The item of a list whose field `name` this is.
    Named(String),
}

/// Why a text is no path.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{found:?} is no path, expected one such as tool.body.sensors[0].position.x")]
pub struct PathSyntaxError {
    found: String,
}

/// Why a path leads to no number.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum PathError {
    #[error("{} has no {name}{}", place(before), expected(known))]
    NoField { before: String, name: String, known: Vec<String> },
    #[error("{} has no item {item}, expected one of {count}, from 0", place(before))]
    NoItem { before: String, item: usize, count: usize },
    #[error("{} has no item named {name:?}{}", place(before), expected(known))]
    NoName { before: String, name: String, known: Vec<String> },
    #[error("{path} is {found}, expected a number")]
    NoNumber { path: String, found: &'static str },
}

fn place(before: &str) -> &str {
    if before.is_empty() { "the design" } else { before }
}

fn expected(known: &[String]) -> String {
    if known.is_empty() { String::new() } else { format!(", expected one of {}", known.join(", ")) }
}

impl FromStr for NumberPath {
    type Err = PathSyntaxError;

    fn from_str(text: &str) -> Result<Self, PathSyntaxError> {
        parse(text).ok_or_else(|| PathSyntaxError { found: text.to_owned() })
    }
}

fn parse(text: &str) -> Option<NumberPath> {
    let (mut steps, mut rest) = (Vec::new(), text);
    let field = |rest: &mut &str, steps: &mut Vec<Step>| {
        let is_of_name = |c: char| c == '_' || c.is_ascii_alphanumeric();
        let end = rest.find(|c| !is_of_name(c)).unwrap_or(rest.len());
        let (name, after) = rest.split_at(end);
        steps.push(Step::Field((!name.is_empty()).then(|| name.to_owned())?));
        *rest = after;
        Some(())
    };
    field(&mut rest, &mut steps)?;
    while !rest.is_empty() {
        if let Some(after) = rest.strip_prefix('.') {
            rest = after;
            field(&mut rest, &mut steps)?;
        } else if let Some(after) = rest.strip_prefix("[\"") {
            let (name, after) = after.split_once("\"]")?;
            steps.push(Step::Named(name.to_owned()));
            rest = after;
        } else {
            let (item, after) = rest.strip_prefix('[')?.split_once(']')?;
            steps.push(Step::Item(item.parse().ok()?));
            rest = after;
        }
    }
    Some(NumberPath(steps))
}

impl TryFrom<String> for NumberPath {
    type Error = PathSyntaxError;

    fn try_from(text: String) -> Result<Self, PathSyntaxError> {
        text.parse()
    }
}

impl From<NumberPath> for String {
    fn from(path: NumberPath) -> Self {
        path.to_string()
    }
}

impl fmt::Display for NumberPath {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.iter().enumerate().try_for_each(|(k, step)| step.write(f, k == 0))
    }
}

impl Step {
    /// Writes it behind others, or as the first.
    fn write(&self, out: &mut impl Write, is_first: bool) -> fmt::Result {
        match self {
            Self::Field(name) => write!(out, "{}{name}", if is_first { "" } else { "." }),
            Self::Item(item) => write!(out, "[{item}]"),
            Self::Named(name) => write!(out, "[\"{name}\"]"),
        }
    }
}

impl NumberPath {
    /// The path behind some fields, where it begins with them.
    pub fn behind(&self, fields: &[&str]) -> Option<Self> {
        let begins =
            fields.len() < self.0.len()
                && self.0.iter().zip(fields).all(
                    |(step, field)| matches!(step, Step::Field(name) if name.as_str() == *field),
                );
        begins.then(|| Self(self.0[fields.len()..].to_vec()))
    }

    /// The unit of what files hold there, by the names of its fields; nothing for what has none, such as
    /// the part of an axis.
    pub fn unit(&self) -> &'static str {
        let fields = || {
            self.0.iter().rev().filter_map(|step| match step {
                Step::Field(name) => Some(name.as_str()),
                Step::Item(_) | Step::Named(_) => None,
            })
        };
        if fields().any(|name| matches!(name, "rx" | "ry" | "rz")) {
            return "deg";
        }
        let units = fields().find_map(|name| match name {
            "axis" | "rotation" => Some(""),
            "position" | "tip" | "orientation_weight" | "length" | "diameter" | "motion" => {
                Some("mm")
            }
            _ if name.starts_with("position_") => Some("mm"),
            _ if name.starts_with("angle_") => Some("deg"),
            _ => None,
        });
        units.unwrap_or_default()
    }
}

/// A document's text, and where its numbers are.
#[derive(Clone, Debug)]
pub struct NumberedText {
    text: String,
    root: Node,
}

/// A number that was found in a [`NumberedText`].
#[derive(Clone, Debug, PartialEq)]
pub struct FoundNumber {
    at: Range<usize>,
    pub value: f64,
}

impl NumberedText {
    /// Finds the numbers of a document that can be read; of another text it finds some or none.
    pub fn new(text: String) -> Self {
        let root = Node::of(&text);
        Self { text, root }
    }

    /// The number that a path leads to.
    ///
    /// # Errors
    /// See [`PathError`]; `within` is what stands before the path in messages.
    pub fn find(&self, path: &NumberPath, within: &str) -> Result<FoundNumber, PathError> {
        let mut node = &self.root;
        let mut before = within.to_owned();
        for step in &path.0 {
            node = take_step(node, step, &before)?;
            let is_first = before.is_empty();
            let _ = step.write(&mut before, is_first);
        }
        let found = match node {
            Node::Number(at) => {
                let digits = self.text[at.clone()].replace('_', "");
                match digits.parse() {
                    Ok(value) => return Ok(FoundNumber { at: at.clone(), value }),
                    Err(_) => "a number of another kind",
                }
            }
            Node::Fields(_) => "a group of fields",
            Node::Items(_) => "a list",
            Node::Text(_) => "a text",
            Node::Word(_) | Node::Nothing => "a word",
        };
        Err(PathError::NoNumber { path: before, found })
    }

    /// The paths of all numbers, in the order of the text.
    pub fn paths(&self) -> Vec<NumberPath> {
        let mut paths = Vec::new();
        add_paths(&self.root, &mut Vec::new(), &mut paths);
        paths
    }

    /// The text with other numbers.
    pub fn with(&self, numbers: &[(&FoundNumber, f64)]) -> String {
        let mut sorted: Vec<_> = numbers.iter().collect();
        sorted.sort_by_key(|(found, _)| found.at.start);
        let mut out = String::with_capacity(self.text.len() + 16 * sorted.len());
        let mut from = 0;
        for (found, value) in sorted {
            // A number that is given twice is the first.
            if found.at.start < from {
                continue;
            }
            out.push_str(&self.text[from..found.at.start]);
            let _ = write!(out, "{value}");
            from = found.at.end;
        }
        out.push_str(&self.text[from..]);
        out
    }
}

/// Where a step leads from a value; `before` is the way to it.
fn take_step<'a>(node: &'a Node, step: &Step, before: &str) -> Result<&'a Node, PathError> {
    let before = || before.to_owned();
    let (fields, items): (&[Field], &[Node]) = match node {
        Node::Fields(fields) => (fields, &[]),
        Node::Items(items) => (&[], items),
        _ => (&[], &[]),
    };
    match step {
        Step::Field(name) => {
            let field = fields.iter().find(|field| field.name == *name);
            let part = part_names(items.len()).iter().position(|part| part == name);
            field.map(|field| &field.value).or(part.map(|part| &items[part])).ok_or_else(|| {
                let known = fields.iter().map(|field| field.name.as_str());
                let parts = part_names(items.len()).iter().map(|&part| part.to_owned());
                let known = near(name, known).into_iter().chain(parts).collect();
                PathError::NoField { before: before(), name: name.clone(), known }
            })
        }
        Step::Item(item) => items.get(*item).ok_or_else(|| PathError::NoItem {
            before: before(),
            item: *item,
            count: items.len(),
        }),
        Step::Named(name) => {
            let found = items.iter().find(|item| name_of(item) == Some(name));
            found.ok_or_else(|| PathError::NoName {
                before: before(),
                name: name.clone(),
                known: items.iter().filter_map(name_of).map(str::to_owned).collect(),
            })
        }
    }
}

/// What the parts of so many numbers are called, if they are.
fn part_names(count: usize) -> &'static [&'static str] {
    match count {
        3 => &POINT,
        4 => &QUATERNION,
        _ => &[],
    }
}

/// What the field `name` of an item is.
fn name_of(item: &Node) -> Option<&str> {
    let Node::Fields(fields) = item else {
        return None;
    };
    fields.iter().find_map(|field| match &field.value {
        Node::Text(text) if field.name == "name" => Some(text.as_str()),
        _ => None,
    })
}

fn add_paths(node: &Node, steps: &mut Vec<Step>, paths: &mut Vec<NumberPath>) {
    let mut add = |step: Step, node: &Node| {
        steps.push(step);
        add_paths(node, steps, paths);
        steps.pop();
    };
    match node {
        Node::Fields(fields) => {
            fields.iter().for_each(|field| add(Step::Field(field.name.clone()), &field.value));
        }
        Node::Items(items) => {
            let are_numbers = items.iter().all(|item| matches!(item, Node::Number(_)));
            let names = if are_numbers { part_names(items.len()) } else { &[] };
            for (k, item) in items.iter().enumerate() {
                let named = names.get(k).map(|name| Step::Field((*name).to_owned()));
                add(named.unwrap_or(Step::Item(k)), item);
            }
        }
        Node::Number(_) => paths.push(NumberPath(steps.clone())),
        Node::Text(_) | Node::Word(_) | Node::Nothing => {}
    }
}

/// The fields that were probably meant, else all of them.
fn near<'a>(name: &str, known: impl Iterator<Item = &'a str>) -> Vec<String> {
    let all: Vec<&str> = known.collect();
    let near = nearest(name, &all);
    let stated = if near.is_empty() { all } else { near };
    stated.into_iter().map(str::to_owned).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_cases::assert_refused;

    const BODY: &str = r#"(
        version: 1, // a comment with 5.0 in it
        name: "probe 7",
        tip: (0.0, -1_0.5, 2e1),
        sensors: [
            (name: "left", kind: FiveDof, position: (1, 2, 3), axis: (0, 0, 1)),
            (name: "right [2]", kind: SixDof, position: (4, 5, 6), rotation: (1, 0, 0, 0)),
        ],
        coil: Some((length: 7.0)),
    )"#;

    fn value(path: &str) -> Result<f64, PathError> {
        NumberedText::new(BODY.to_owned()).find(&path.parse().unwrap(), "").map(|n| n.value)
    }

    #[test]
    fn paths_lead_to_the_numbers_of_a_file() {
        for (path, expected) in [
            ("version", 1.0),
            ("tip.y", -10.5),
            ("tip[2]", 20.0),
            ("sensors[1].position.x", 4.0),
            ("sensors[\"left\"].position.z", 3.0),
            ("sensors[\"right [2]\"].rotation.w", 1.0),
            ("coil[0].length", 7.0),
        ] {
            assert_eq!(value(path), Ok(expected), "{path}");
        }
    }

    #[test]
    fn a_wrong_path_states_what_there_is() {
        let cases = r#"
            tips.x | the design has no tips, expected one of tip
            sensors[2].position.x | sensors has no item 2, expected one of 2, from 0
            sensors["top"].position.x
                | sensors has no item named "top", expected one of left, right [2]
            tip.w | tip has no w, expected one of x, y, z
            tip | tip is a list, expected a number
            name | name is a text, expected a number
            sensors[0].kind | sensors[0].kind is a word, expected a number
            version.x | version has no x
            version[0] | version has no item 0, expected one of 0, from 0
        "#;
        assert_refused("", cases, |path| value(path).unwrap_err().to_string());
        for text in ["", ".x", "a..b", "a[", "a[b]", "a[-1]", "a b", "a[\"b]", "a]"] {
            assert!(text.parse::<NumberPath>().is_err(), "{text}");
        }
    }

    #[test]
    fn other_numbers_leave_the_rest_as_it_is() {
        let text = NumberedText::new(BODY.to_owned());
        let find = |path: &str| text.find(&path.parse().unwrap(), "").unwrap();
        let (tip, x) = (find("tip.y"), find("sensors[1].position.x"));
        let out = text.with(&[(&x, 0.1), (&tip, -3.0)]);
        let expected = BODY.replace("-1_0.5", "-3").replace("(4, 5", "(0.1, 5");
        assert_eq!(out, expected);
        assert_eq!(text.with(&[]), BODY);
    }

    #[test]
    fn every_listed_path_leads_to_its_number() {
        let text = NumberedText::new(BODY.to_owned());
        let paths = text.paths();
        assert_eq!(paths.len(), 1 + 3 + 6 + 7 + 1);
        for path in paths {
            let again: NumberPath = path.to_string().parse().unwrap();
            assert_eq!(again, path);
            assert!(text.find(&path, "").is_ok(), "{path}");
        }
    }

    #[test]
    fn any_text_is_searched_without_a_panic() {
        for end in 0..BODY.len() {
            let text = NumberedText::new(BODY[..end].to_owned());
            for path in text.paths() {
                let found = text.find(&path, "");
                assert!(found.is_ok() || matches!(found, Err(PathError::NoNumber { .. })));
            }
        }
    }

    #[test]
    fn units_are_those_of_the_files() {
        for (path, unit) in [
            ("tool.body.sensors[0].position.x", "mm"),
            ("tool.body.sensors[0].axis.x", ""),
            ("tool.pose.rotation.w", ""),
            ("tool.pose.position[1]", "mm"),
            ("motion.x.max", "mm"),
            ("motion.rx.step", "deg"),
            ("requirement.angle_rms", "deg"),
            ("requirement.position_rms", "mm"),
            ("orientation_weight", "mm"),
            ("version", ""),
        ] {
            assert_eq!(path.parse::<NumberPath>().unwrap().unit(), unit, "{path}");
        }
    }
}
