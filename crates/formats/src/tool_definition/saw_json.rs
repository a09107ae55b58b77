//! Marker geometries of the SAW components, `.json` with comments as in C, in mm.
//!
//! While nothing changes the text stays as it is. Otherwise it is written anew, with all that is in
//! it but its comments.

use super::super::error::{FormatError, text};
use super::geometry::Geometry;
use nalgebra::Point3;
use serde_json::{Map, Value, json};

/// A geometry as its text has it.
#[derive(Clone, Debug, PartialEq)]
pub struct SawJson {
    text: String,
    geometry: Geometry,
}

impl SawJson {
    /// Reads a geometry.
    ///
    /// # Errors
    /// What is no JSON, and fields that are missing, no number, or counted wrongly.
    pub fn parse(bytes: &[u8]) -> Result<Self, FormatError> {
        let file = text(bytes)?;
        Ok(Self {
            geometry: geometry(&value(file)?)?,
            // With its mark, if it begins with one.
            text: String::from_utf8_lossy(bytes).into_owned(),
        })
    }

    /// The whole file.
    pub fn write(&self) -> &str {
        &self.text
    }

    pub fn geometry(&self) -> &Geometry {
        &self.geometry
    }

    pub(super) fn has_comments(&self) -> bool {
        without_comments(&self.text) != self.text
    }

    /// What the file holds besides, each once: comments and other fields.
    pub(super) fn beyond_geometry(&self) -> Vec<String> {
        // It was read from this text.
        let file = value(self.text.trim_start_matches('\u{feff}')).unwrap_or(Value::Null);
        let mut found = Vec::new();
        if self.has_comments() {
            found.push("comments".to_owned());
        }
        let points = file.get("fiducials").and_then(Value::as_array);
        let points = points.into_iter().flatten().chain(file.get("pivot"));
        let own: &[&str] = &["fiducials", "count", "id", "pivot"];
        let parts =
            std::iter::once((&file, own)).chain(points.map(|at| (at, &["x", "y", "z"][..])));
        for (part, known) in parts {
            for key in part.as_object().into_iter().flat_map(Map::keys) {
                if !known.contains(&key.as_str()) && !found.contains(key) {
                    found.push(key.clone());
                }
            }
        }
        found
    }

    /// A new file of a geometry.
    pub(super) fn of(geometry: &Geometry) -> Self {
        Self::written(geometry, &Value::Null, &[])
    }

    /// The same file with another geometry, whose markers take their other fields from those
    /// at `sources` in this one.
    pub(super) fn with_geometry(&self, geometry: &Geometry, sources: &[Option<usize>]) -> Self {
        if *geometry == self.geometry {
            return self.clone();
        }
        // It was read from this text.
        let old = value(self.text.trim_start_matches('\u{feff}')).unwrap_or(Value::Null);
        Self::written(geometry, &old, sources)
    }

    fn written(geometry: &Geometry, old: &Value, sources: &[Option<usize>]) -> Self {
        let mut object = old.as_object().cloned().unwrap_or_default();
        let fiducials = geometry.fiducials.iter().enumerate().map(|(i, at)| {
            let source = sources.get(i).copied().flatten();
            point_value(at, source.and_then(|s| old.get("fiducials")?.get(s)))
        });
        object.insert("fiducials".into(), fiducials.collect());
        object.insert("count".into(), json!(geometry.fiducials.len()));
        match geometry.id {
            Some(id) => object.insert("id".into(), json!(id)),
            None => object.remove("id"),
        };
        match &geometry.pivot {
            Some(pivot) => object.insert("pivot".into(), point_value(pivot, old.get("pivot"))),
            None => object.remove("pivot"),
        };
        Self { text: format!("{:#}\n", Value::Object(object)), geometry: geometry.clone() }
    }
}

/// A point with the other fields of the old one.
fn point_value(at: &Point3<f64>, old: Option<&Value>) -> Value {
    let mut object: Map<_, _> = old.and_then(Value::as_object).cloned().unwrap_or_default();
    for (axis, value) in ["x", "y", "z"].into_iter().zip(at.iter()) {
        object.insert(axis.into(), json!(value));
    }
    Value::Object(object)
}

fn value(file: &str) -> Result<Value, FormatError> {
    serde_json::from_str(&without_comments(file)).map_err(|error| {
        let reason = error.to_string();
        let reason = reason.split(" at line ").next().unwrap_or_default();
        FormatError::Syntax {
            line: error.line(),
            column: error.column(),
            problem: format!("found no JSON ({reason}), expected an object"),
        }
    })
}

fn geometry(value: &Value) -> Result<Geometry, FormatError> {
    let Some(fiducials) = value.get("fiducials") else {
        let found = match value.get("tools") {
            Some(_) => "missing beside `tools`, which is a tracker's configuration",
            None => "missing",
        };
        return Err(FormatError::field("fiducials", found, "the markers of a tool"));
    };
    let Some(fiducials) = fiducials.as_array().filter(|list| !list.is_empty()) else {
        return Err(FormatError::field(
            "fiducials",
            "no list with something in it",
            "the markers of a tool",
        ));
    };
    let count = value.get("count").and_then(Value::as_u64);
    if count.is_none_or(|count| usize::try_from(count) != Ok(fiducials.len())) {
        return Err(FormatError::field(
            "count",
            match value.get("count") {
                None => "missing".to_owned(),
                Some(count) => format!("{}, with {} fiducials", short(count), fiducials.len()),
            },
            "the number of fiducials",
        ));
    }
    Geometry::check_count(fiducials.len())?;
    let whole = |id: &Value| {
        id.as_i64().ok_or_else(|| FormatError::field("id", short(id), "a whole number"))
    };
    let id = value.get("id").map(whole).transpose()?;
    let points = fiducials.iter().enumerate();
    Ok(Geometry {
        id,
        fiducials: points
            .map(|(i, at)| point(&format!("fiducials[{i}]"), at))
            .collect::<Result<_, _>>()?,
        pivot: value.get("pivot").map(|at| point("pivot", at)).transpose()?,
    })
}

fn point(field: &str, value: &Value) -> Result<Point3<f64>, FormatError> {
    let mut point = Point3::origin();
    for (i, axis) in ["x", "y", "z"].into_iter().enumerate() {
        let number = value.get(axis);
        // Too large a number is no JSON to the parser; there are no others without end.
        point[i] = number.and_then(Value::as_f64).ok_or_else(|| {
            FormatError::field(
                format!("{field}.{axis}"),
                number.map_or_else(|| "missing".to_owned(), short),
                "a number of mm",
            )
        })?;
    }
    Ok(point)
}

/// What is found, for an error.
fn short(value: &Value) -> String {
    value.to_string().chars().take(24).collect()
}

/// The text with spaces for comments, each letter where it was.
fn without_comments(file: &str) -> String {
    let mut out = String::with_capacity(file.len());
    let mut letters = file.chars().peekable();
    let mut is_text = false;
    while let Some(letter) = letters.next() {
        match (letter, letters.peek()) {
            ('"', _) => {
                is_text = !is_text;
                out.push('"');
            }
            ('\\', Some(_)) if is_text => {
                out.push('\\');
                out.extend(letters.next());
            }
            ('/', Some('/')) if !is_text => {
                out.push(' ');
                while let Some(inside) = letters.next_if(|c| *c != '\n') {
                    blank(&mut out, inside);
                }
            }
            ('/', Some('*')) if !is_text => {
                out.push(' ');
                let mut last = ' ';
                let mut is_opened = false;
                for inside in letters.by_ref() {
                    blank(&mut out, inside);
                    if is_opened && last == '*' && inside == '/' {
                        break;
                    }
                    // The star of the beginning is not that of the end.
                    last = if is_opened { inside } else { ' ' };
                    is_opened = true;
                }
            }
            _ => out.push(letter),
        }
    }
    out
}

/// As many spaces as the letter has bytes; lines stay.
fn blank(out: &mut String, letter: char) {
    match letter {
        '\n' => out.push('\n'),
        _ => out.extend(std::iter::repeat_n(' ', letter.len_utf8())),
    }
}
