//! RON as this program reads and writes it: errors with a place, numbers that read back exactly.

use super::error::{FormatError, text};
use super::number;
use crate::geometry::pose::{Pose, pose_from_parts, quaternion_to_array};
use nalgebra::{Point3, Unit, UnitQuaternion, Vector3};
use ron::error::SpannedError;
use ron::extensions::Extensions;
use serde::Deserialize;
use serde::de::DeserializeOwned;
use std::fmt::Write;

/// The only version of the program's own files so far.
pub(super) const VERSION: u64 = 1;

/// Longest piece of a file that an error quotes.
const MAX_QUOTE: usize = 24;

/// What every file of the program's own begins with.
pub(super) trait Versioned {
    fn version(&self) -> u64;
}

/// A file's version, whatever else it holds.
#[derive(Deserialize)]
struct VersionAlone {
    version: u64,
}

/// Reads a versioned file; `Some(…)` may be left out. Unknown fields are skipped.
pub(super) fn parse<T: DeserializeOwned + Versioned>(bytes: &[u8]) -> Result<T, FormatError> {
    let text = text(bytes)?;
    let options = ron::Options::default().with_default_extension(Extensions::IMPLICIT_SOME);
    let parsed = options.from_str::<T>(text);
    let version = match &parsed {
        Ok(entry) => Some(entry.version()),
        // Another version may have other fields; it is the version that is wrong then.
        Err(_) => options.from_str(text).ok().map(|v: VersionAlone| v.version),
    };
    match version {
        Some(version) if version != VERSION => Err(FormatError::field("version", version, "1")),
        _ => parsed.map_err(|error| located(text, &error)),
    }
}

/// A RON error in this program's words.
fn located(text: &str, error: &SpannedError) -> FormatError {
    use ron::Error as E;
    // Values of the wrong kind are found where they begin, broken syntax where it ends.
    let at = match error.code {
        E::InvalidValueForType { .. } | E::Message(_) => error.span.start,
        _ => error.span.end,
    };
    let found = || quote(text, at.line, at.col);
    let problem = match &error.code {
        E::Message(message) => message.clone(),
        E::Eof => "found the end of the file, expected more: it is cut short".to_owned(),
        E::InvalidValueForType { expected, found } => format!("found {found}, expected {expected}"),
        E::ExpectedDifferentLength {
            expected,
            found: count,
        } => format!("found {count} elements, expected {expected}"),
        E::NoSuchEnumVariant {
            expected, found, ..
        } => format!("found `{found}`, expected {}", one_of(expected)),
        E::NoSuchStructField {
            expected, found, ..
        } => format!("found field `{found}`, expected {}", one_of(expected)),
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
    FormatError::Syntax {
        line: at.line,
        column: at.col,
        problem,
    }
}

fn one_of(names: &[&str]) -> String {
    names
        .iter()
        .map(|name| format!("`{name}`"))
        .collect::<Vec<_>>()
        .join(" or ")
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

/// A finite position.
pub(super) fn point(field: &str, components: [f64; 3]) -> Result<Point3<f64>, FormatError> {
    if components.iter().all(|v| v.is_finite()) {
        Ok(components.into())
    } else {
        Err(FormatError::field(
            field,
            list(&components),
            "finite numbers",
        ))
    }
}

/// A direction, normalised.
pub(super) fn axis(field: &str, components: [f64; 3]) -> Result<Unit<Vector3<f64>>, FormatError> {
    number::direction(components)
        .ok_or_else(|| FormatError::field(field, list(&components), "a direction"))
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
fn list(components: &[f64]) -> String {
    let parts: Vec<_> = components.iter().map(f64::to_string).collect();
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
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn any_text_survives_between_quotes(chars in prop::collection::vec(any::<char>(), 0..40)) {
            let s = String::from_iter(chars);
            prop_assert_eq!(ron::from_str::<String>(&string(&s)).unwrap(), s);
        }

        #[test]
        fn any_numbers_survive(v in prop::array::uniform3(any::<f64>())) {
            prop_assume!(v.iter().all(|x| x.is_finite()));
            prop_assert_eq!(ron::from_str::<[f64; 3]>(&tuple(&v)).unwrap(), v);
        }
    }
}
