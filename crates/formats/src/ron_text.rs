//! RON as this program reads and writes it: no field that is not known, errors with a place, numbers
//! that read back exactly.

use super::error::{FormatError, text};
use super::nearest::nearest;
use super::ron_tokens::{place, stated_version, too_large_number};
use nalgebra::{Point3, Unit, UnitQuaternion, Vector3};
use ron::error::SpannedError;
use ron::extensions::Extensions;
use ron::ser::PrettyConfig;
use serde::de::{DeserializeOwned, Deserializer, Error};
use serde::{Deserialize, Serialize};
use std::collections::HashMap;
use std::fmt::{Display, Write};
use trackwright_geometry::limits::{position_problem, short};
use trackwright_geometry::mesh_reference::MeshUnit;
use trackwright_geometry::number;
use trackwright_geometry::pose::{Pose, pose_from_parts, quaternion_to_array};

/// The only version of the program's own files so far.
pub(super) const VERSION: u64 = 1;

/// Longest piece of a file that an error quotes.
const MAX_QUOTE: usize = 24;

/// The version of a file of the program's own, which has to be the one that it reads.
pub(super) struct Version;

impl<'de> Deserialize<'de> for Version {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        check_version(u64::deserialize(deserializer)?).map_err(D::Error::custom)?;
        Ok(Self)
    }
}

/// Reads a file with a [`Version`]; `Some(…)` may be left out.
///
/// A field that is not known is an error, as one that is mistyped would else have its default and
/// nobody would notice. `T` and all that it is made of have `deny_unknown_fields`.
pub(super) fn parse<T: DeserializeOwned>(bytes: &[u8]) -> Result<T, FormatError> {
    let text = text(bytes)?;
    // Another version may have other fields; it is the version that is wrong then.
    stated_version(text).map_or(Ok(()), check_version)?;
    let options = ron::Options::default().with_default_extension(Extensions::IMPLICIT_SOME);
    let entry: T = options.from_str(text).map_err(|error| located(text, &error))?;
    if let Some(range) = too_large_number(text) {
        let (line, column) = place(text, range.start);
        return Err(FormatError::Syntax {
            line,
            column,
            problem: format!("found {}, expected a number of at most 1e30", shown(&text[range])),
        });
    }
    Ok(entry)
}

fn check_version(found: u64) -> Result<(), FormatError> {
    match found {
        VERSION => Ok(()),
        found => Err(FormatError::Version { found, expected: VERSION }),
    }
}

/// What is wrong with a field that is none of those that are known.
pub(super) fn unknown_field(found: &str, known: &[&str]) -> String {
    format!("found the unknown field {}, expected {}", shown(found), nearest_of(found, known))
}

/// A RON error in this program's words.
fn located(text: &str, error: &SpannedError) -> FormatError {
    use ron::Error as E;
    let cut = E::Eof;
    let code = match &error.code {
        // Half a name is no unknown one.
        E::NoSuchStructField { .. } | E::NoSuchEnumVariant { .. }
            if place(text, text.len()) == (error.span.end.line, error.span.end.col) =>
        {
            &cut
        }
        code => code,
    };
    // Names and values of the wrong kind are found where they begin, broken syntax where it ends.
    let at = match code {
        E::InvalidValueForType { .. }
        | E::Message(_)
        | E::NoSuchEnumVariant { .. }
        | E::NoSuchStructField { .. }
        | E::DuplicateStructField { .. } => error.span.start,
        _ => error.span.end,
    };
    let found = || quote(text, at.line, at.col);
    let problem = match code {
        E::Message(message) => message.clone(),
        E::Eof => "found the end of the file, expected more: it is cut short".to_owned(),
        E::InvalidValueForType { expected, found } => format!("found {found}, expected {expected}"),
        E::ExpectedDifferentLength { expected, found: count } => {
            format!("found {count} elements, expected {expected}")
        }
        E::NoSuchEnumVariant { expected, found, .. } => {
            format!("found {}, expected {}", shown(found), nearest_of(found, expected))
        }
        E::NoSuchStructField { expected, found, .. } => unknown_field(found, expected),
        E::ExpectedDifferentStructName { expected, found } => {
            format!("found {}, expected `{expected}` or no name", shown(found))
        }
        E::MissingStructField { field, .. } => format!("found no field `{field}`, expected it"),
        E::DuplicateStructField { field, .. } => {
            format!("found field `{field}` twice, expected it once")
        }
        other => {
            let message = other.to_string();
            match message.strip_prefix("Expected ") {
                Some(expected) => format!("found {}, expected {expected}", found()),
                None => {
                    let lower = message[..1].to_lowercase() + &message[1..];
                    format!("found {}, expected valid RON ({lower})", found())
                }
            }
        }
    };
    FormatError::Syntax { line: at.line, column: at.col, problem }
}

/// The known names that are like one that is none of them, or all.
fn nearest_of(found: &str, known: &[&str]) -> String {
    let near = nearest(found, known);
    let names = if near.is_empty() { known } else { &near };
    names.iter().map(|name| format!("`{name}`")).collect::<Vec<_>>().join(" or ")
}

/// A word of a file between quotes, no more of it than a line holds.
fn shown(word: &str) -> String {
    match word.char_indices().nth(MAX_QUOTE) {
        None => format!("`{}`", word.escape_debug()),
        Some((end, _)) => format!("`{}…`", word[..end].escape_debug()),
    }
}

/// What stands at a place, up to the next separator.
fn quote(text: &str, line: usize, column: usize) -> String {
    let rest: String = text
        .lines()
        .nth(line.saturating_sub(1))
        .unwrap_or_default()
        .chars()
        .skip(column.saturating_sub(1))
        .take(MAX_QUOTE)
        .collect();
    let is_separator = |c: char| c.is_whitespace() || ",:()[]{}".contains(c);
    let rest = rest.trim_start();
    let end = match rest.char_indices().find(|(_, c)| is_separator(*c)) {
        Some((0, c)) => c.len_utf8(),
        Some((end, _)) => end,
        None => rest.len(),
    };
    match &rest[..end] {
        "" if line >= text.lines().count() => "the end of the file".to_owned(),
        "" => "the end of the line".to_owned(),
        word => format!("`{}`", word.escape_debug()),
    }
}

/// A pose as files hold it.
#[derive(Deserialize)]
#[serde(rename = "Pose", deny_unknown_fields)]
pub(super) struct PoseEntry {
    position: [f64; 3],
    rotation: [f64; 4],
}

impl PoseEntry {
    pub(super) fn check(&self, field: &str) -> Result<Pose, FormatError> {
        let position = point(&format!("{field}.position"), self.position)?;
        let rotation = rotation(&format!("{field}.rotation"), self.rotation)?;
        Ok(pose_from_parts(position.coords, rotation))
    }
}

/// A position, finite and within [`MAX_LENGTH_MM`](trackwright_geometry::limits::MAX_LENGTH_MM).
pub(super) fn point(field: &str, components: [f64; 3]) -> Result<Point3<f64>, FormatError> {
    match position_problem(&components) {
        None => Ok(components.into()),
        Some(expected) => Err(FormatError::field(field, list(&components), expected)),
    }
}

/// A direction, normalised.
pub(super) fn axis(field: &str, components: [f64; 3]) -> Result<Unit<Vector3<f64>>, FormatError> {
    number::direction(components)
        .ok_or_else(|| FormatError::field(field, list(&components), "a direction"))
}

/// The name of a file, which is not empty.
pub(super) fn file_name(field: impl Into<String>, name: String) -> Result<String, FormatError> {
    match name.trim().is_empty() {
        true => Err(FormatError::field(field, "empty", "a file")),
        false => Ok(name),
    }
}

/// The unit of a mesh, where its file states one.
pub(super) fn mesh_unit(
    field: impl Into<String>,
    unit: Option<MeshUnit>,
) -> Result<Option<MeshUnit>, FormatError> {
    match unit.and_then(|unit| Some((unit, unit.problem()?))) {
        None => Ok(unit),
        Some((unit, expected)) => Err(FormatError::field(field, unit, expected)),
    }
}

/// Refuses items of a list without a name, or with that of one before.
pub(super) fn check_names<'a>(
    list: &str,
    names: impl Iterator<Item = &'a str>,
) -> Result<(), FormatError> {
    let mut known = HashMap::new();
    for (index, name) in names.enumerate() {
        let wrong = |found: String, expected| {
            Err(FormatError::field(format!("{list}[{index}]: name"), found, expected))
        };
        if name.trim().is_empty() {
            return wrong("empty".to_owned(), "a name");
        }
        if let Some(first) = known.insert(name, index) {
            return wrong(format!("{name:?}, the name of {list}[{first}]"), "each name once");
        }
    }
    Ok(())
}

/// A rotation, normalised.
pub(super) fn rotation(
    field: &str,
    components: [f64; 4],
) -> Result<UnitQuaternion<f64>, FormatError> {
    number::rotation(components)
        .ok_or_else(|| FormatError::field(field, list(&components), "a quaternion (w, x, y, z)"))
}

/// Numbers for an error: `(0, 0.5, NaN)`.
pub(super) fn list(components: &[f64]) -> String {
    let parts: Vec<_> = components.iter().map(|v| short(*v)).collect();
    format!("({})", parts.join(", "))
}

/// Numbers for a file: `(0.0, 0.5, -1e-9)`.
pub(super) fn tuple(components: &[f64]) -> String {
    let parts: Vec<_> = components.iter().map(|v| format!("{v:?}")).collect();
    format!("({})", parts.join(", "))
}

pub(super) fn pose(pose: &Pose) -> String {
    format!(
        "(position: {}, rotation: {})",
        tuple(pose.translation.vector.as_slice()),
        tuple(&quaternion_to_array(&pose.rotation))
    )
}

/// A file in the making, four spaces a level.
#[derive(Default)]
pub(super) struct RonWriter {
    text: String,
    depth: usize,
}

impl RonWriter {
    /// A file with its version and these fields.
    pub(super) fn file(fields: impl FnOnce(&mut Self)) -> String {
        let mut out = Self::default();
        out.block("(", ")", |out| {
            out.field("version", VERSION);
            fields(out);
        });
        out.text
    }

    pub(super) fn line(&mut self, text: impl Display) {
        // Writing to a string cannot fail.
        let _ = writeln!(self.text, "{:1$}{text}", "", 4 * self.depth);
    }

    /// Lines within a first and a last one.
    fn block(&mut self, first: &str, last: &str, inside: impl FnOnce(&mut Self)) {
        self.line(first);
        self.depth += 1;
        inside(self);
        self.depth -= 1;
        self.line(last);
    }

    pub(super) fn field(&mut self, name: &str, value: impl Display) {
        self.line(format_args!("{name}: {value},"));
    }

    /// A field of text.
    pub(super) fn string(&mut self, name: &str, text: &str) {
        self.field(name, string(text));
    }

    /// A field of names or numbers as Rust writes them: `Inch`, `Factor(2.5)`, `0.5`.
    pub(super) fn plain(&mut self, name: &str, value: impl std::fmt::Debug) {
        self.field(name, format_args!("{value:?}"));
    }

    /// A field as [`Self::plain`] writes it, where there is one.
    pub(super) fn optional(&mut self, name: &str, value: Option<impl std::fmt::Debug>) {
        value.into_iter().for_each(|value| self.plain(name, value));
    }

    /// A field of text, where there is one.
    pub(super) fn optional_string(&mut self, name: &str, text: Option<&str>) {
        text.into_iter().for_each(|text| self.string(name, text));
    }

    /// A field with fields of its own, a line each.
    pub(super) fn fields(&mut self, name: &str, fields: impl FnOnce(&mut Self)) {
        self.block(&format!("{name}: ("), "),", fields);
    }

    /// A list, an item a line.
    pub(super) fn list(&mut self, name: &str, items: impl FnOnce(&mut Self)) {
        self.block(&format!("{name}: ["), "],", items);
    }

    /// A list of items that are a line each.
    pub(super) fn lines<T: Display>(&mut self, name: &str, items: impl IntoIterator<Item = T>) {
        self.list(name, |out| items.into_iter().for_each(|item| out.line(format_args!("{item},"))));
    }

    /// The same, left out where there are no items.
    pub(super) fn lines_if_any<T: Display>(
        &mut self,
        name: &str,
        items: impl ExactSizeIterator<Item = T>,
    ) {
        if items.len() > 0 {
            self.lines(name, items);
        }
    }

    /// An item of a list with fields of its own.
    pub(super) fn item(&mut self, fields: impl FnOnce(&mut Self)) {
        self.block("(", "),", fields);
    }

    /// A value as `ron` writes it, so many levels of its fields on lines of their own.
    pub(super) fn value(&mut self, name: &str, value: &impl Serialize, levels: usize) {
        let options = ron::Options::default().with_default_extension(Extensions::IMPLICIT_SOME);
        let config = PrettyConfig::new().new_line("\n").depth_limit(levels);
        // Numbers, flags and names, all of which RON can hold.
        let text = options.to_string_pretty(value, config).unwrap_or_default();
        let indent = format!("\n{:1$}", "", 4 * self.depth);
        self.field(name, text.replace('\n', &indent));
    }
}

/// Text between quotes.
pub(super) fn string(text: &str) -> String {
    let mut out = String::with_capacity(text.len() + 2);
    out.push('"');
    for c in text.chars() {
        match c {
            '"' => out.push_str("\\\""),
            '\\' => out.push_str("\\\\"),
            '\n' => out.push_str("\\n"),
            '\r' => out.push_str("\\r"),
            '\t' => out.push_str("\\t"),
            c if c.is_control() => {
                // Writing to a string cannot fail.
                let _ = write!(out, "\\u{{{:x}}}", u32::from(c));
            }
            c => out.push(c),
        }
    }
    out.push('"');
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_cases::any_text;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn any_text_survives_between_quotes(s in any_text(0..40)) {
            prop_assert_eq!(ron::from_str::<String>(&string(&s)).unwrap(), s);
        }

        #[test]
        fn any_numbers_survive(v in prop::array::uniform3(any::<f64>())) {
            prop_assume!(v.iter().all(|x| x.is_finite()));
            prop_assert_eq!(ron::from_str::<[f64; 3]>(&tuple(&v)).unwrap(), v);
        }
    }
}
