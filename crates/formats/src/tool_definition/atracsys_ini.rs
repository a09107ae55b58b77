//! Atracsys geometries, `.ini`: a section a marker, in mm.
//!
//! Lines that hold no positions (comments, versions, normals, divots) stay as they are; the
//! lines of a marker stay with it when others are added or removed.

use super::super::error::{FormatError, text};
use super::geometry::Geometry;
use nalgebra::Point3;
use std::collections::HashMap;
use trackwright_geometry::number::shortest;

const AXES: [&str; 3] = ["x", "y", "z"];

/// A geometry as its text has it.
#[derive(Clone, Debug, PartialEq)]
pub struct AtracsysIni {
    text: String,
    geometry: Geometry,
}

/// Lines with their ends, the first one its header; none before the first header.
type Section<'a> = Vec<&'a str>;

impl AtracsysIni {
    /// Reads a geometry.
    ///
    /// # Errors
    /// What is no section or `key=value`, stated twice, missing, no number, or counted wrongly.
    pub fn parse(bytes: &[u8]) -> Result<Self, FormatError> {
        let file = text(bytes)?;
        let geometry = Values::of(file)?.geometry()?;
        Ok(Self {
            // With its mark, if it begins with one.
            text: String::from_utf8_lossy(bytes).into_owned(),
            geometry,
        })
    }

    /// The whole file.
    pub fn write(&self) -> &str {
        &self.text
    }

    pub fn geometry(&self) -> &Geometry {
        &self.geometry
    }

    /// What the file holds besides, each once: comments, other sections, other keys.
    pub(super) fn beyond_geometry(&self) -> Vec<String> {
        let file = self.text.trim_start_matches('\u{feff}');
        let mut found = Vec::new();
        let mut add = |what: String| {
            if !found.contains(&what) {
                found.push(what);
            }
        };
        if file.contains([';', '#']) {
            add("comments".to_owned());
        }
        for section in sections(file) {
            let known: &[&str] = match part_of(&section) {
                Part::Geometry => &["count", "id"],
                Part::Fiducial(_) | Part::Pivot => &AXES,
                Part::Other => {
                    let name = section.first().and_then(|line| header(line));
                    name.into_iter().for_each(|name| add(format!("[{name}]")));
                    continue;
                }
            };
            let keys = section.iter().filter_map(|line| Some(entry(line)?.0));
            keys.filter(|key| !known.contains(&key.as_str())).for_each(&mut add);
        }
        found
    }

    /// A new file of a geometry.
    pub(super) fn of(geometry: &Geometry) -> Self {
        let empty = Self {
            text: String::new(),
            geometry: Geometry { id: None, fiducials: Vec::new(), pivot: None },
        };
        empty.with_geometry(geometry, &vec![None; geometry.fiducials.len()])
    }

    /// The same file with another geometry, whose markers take their other lines from those at
    /// `sources` in this one.
    pub(super) fn with_geometry(&self, geometry: &Geometry, sources: &[Option<usize>]) -> Self {
        if *geometry == self.geometry {
            return self.clone();
        }
        let sections = sections(self.text.trim_start_matches('\u{feff}'));
        let mut out = String::with_capacity(self.text.len());
        let mut is_written = false;
        for section in &sections {
            match part_of(section) {
                Part::Fiducial(_) if is_written => {}
                // All of them where the first one was.
                Part::Fiducial(_) => {
                    push_fiducials(&mut out, geometry, sources, &sections);
                    is_written = true;
                }
                Part::Pivot => push_pivot(&mut out, geometry, section),
                Part::Geometry => push_head(&mut out, geometry, section),
                Part::Other => out.extend(section.iter().copied()),
            }
        }
        let has = |part: Part| sections.iter().any(|section| part_of(section) == part);
        if !has(Part::Geometry) {
            push_head(&mut out, geometry, &["[geometry]\n"]);
        }
        if !is_written {
            push_fiducials(&mut out, geometry, sources, &sections);
        }
        if !has(Part::Pivot) {
            push_pivot(&mut out, geometry, &["[pivot]\n"]);
        }
        Self { text: out, geometry: geometry.clone() }
    }
}

#[derive(Clone, Copy, PartialEq)]
enum Part {
    Geometry,
    Fiducial(usize),
    Pivot,
    Other,
}

fn part_of(section: &[&str]) -> Part {
    match section.first().and_then(|line| header(line)) {
        Some(name) if name == "geometry" => Part::Geometry,
        Some(name) if name == "pivot" => Part::Pivot,
        Some(name) => fiducial_index(&name).map_or(Part::Other, Part::Fiducial),
        None => Part::Other,
    }
}

fn fiducial_index(section: &str) -> Option<usize> {
    let digits = section.strip_prefix("fiducial")?;
    let index = digits.parse().ok()?;
    // Not `fiducial+1` nor `fiducial01`.
    (format!("{index}") == digits).then_some(index)
}

fn push_head(out: &mut String, geometry: &Geometry, section: &[&str]) {
    let count = Some(geometry.fiducials.len().to_string());
    let id = geometry.id.map(|id| id.to_string());
    push_section(out, section, &[("count", count), ("id", id)]);
}

fn push_pivot(out: &mut String, geometry: &Geometry, section: &[&str]) {
    if let Some(pivot) = &geometry.pivot {
        push_section(out, section, &coordinates(pivot));
    }
}

fn push_fiducials(
    out: &mut String,
    geometry: &Geometry,
    sources: &[Option<usize>],
    sections: &[Section<'_>],
) {
    // Other sections may be many.
    let own: HashMap<usize, &Section<'_>> = sections
        .iter()
        .filter_map(|section| match part_of(section) {
            Part::Fiducial(index) => Some((index, section)),
            _ => None,
        })
        .collect();
    for (i, at) in geometry.fiducials.iter().enumerate() {
        let source = sources.get(i).copied().flatten();
        let source = source.and_then(|index| own.get(&index).copied());
        let new_header = format!("[fiducial{i}]\n");
        let mut section = source.cloned().unwrap_or_else(|| vec![&new_header]);
        if part_of(&section) != Part::Fiducial(i) {
            section[0] = &new_header;
        }
        push_section(out, &section, &coordinates(at));
    }
}

fn coordinates(at: &Point3<f64>) -> [(&'static str, Option<String>); 3] {
    std::array::from_fn(|i| (AXES[i], Some(shortest(at[i]))))
}

/// A section with these values: a line whose value means the same stays as it is, one that is
/// missing is added at the end, one without value is left out.
fn push_section(out: &mut String, section: &[&str], values: &[(&str, Option<String>)]) {
    if !out.is_empty() && !out.ends_with('\n') {
        out.push('\n');
    }
    let mut is_there = vec![false; values.len()];
    for line in section {
        let own = entry(line).and_then(|(key, old)| {
            let index = values.iter().position(|(name, _)| *name == key)?;
            Some((index, old))
        });
        let Some((index, old)) = own else {
            out.push_str(line);
            continue;
        };
        is_there[index] = true;
        match &values[index].1 {
            None => {}
            Some(new) if new.parse::<f64>().ok() == old.parse::<f64>().ok() => out.push_str(line),
            Some(new) => out.push_str(&line.replacen(old, new, 1)),
        }
    }
    for ((key, value), is_there) in values.iter().zip(is_there) {
        if let (Some(value), false) = (value, is_there) {
            if !out.is_empty() && !out.ends_with('\n') {
                out.push('\n');
            }
            out.extend([*key, "=", value, "\n"]);
        }
    }
}

/// The text in sections, what comes before the first header as one of its own.
fn sections(file: &str) -> Vec<Section<'_>> {
    let mut sections: Vec<Section<'_>> = Vec::new();
    for line in file.split_inclusive('\n') {
        match sections.last_mut() {
            Some(section) if header(line).is_none() => section.push(line),
            _ => sections.push(vec![line]),
        }
    }
    sections
}

/// A line without its comment and the spaces around it.
fn bare(line: &str) -> &str {
    line.split([';', '#']).next().unwrap_or_default().trim()
}

/// The section that a line begins, in small letters.
fn header(line: &str) -> Option<String> {
    let name = bare(line).strip_prefix('[')?.strip_suffix(']')?;
    Some(name.trim().to_ascii_lowercase())
}

/// The key of a line, in small letters, and its value.
fn entry(line: &str) -> Option<(String, &str)> {
    let (key, value) = bare(line).split_once('=')?;
    let key = key.trim().to_ascii_lowercase();
    (!key.is_empty()).then_some((key, value.trim()))
}

/// Which line holds what.
struct Values<'a> {
    of: HashMap<(String, String), (u64, &'a str)>,
    fiducials: usize,
    has_pivot: bool,
}

impl<'a> Values<'a> {
    fn of(file: &'a str) -> Result<Self, FormatError> {
        let mut values = Self { of: HashMap::new(), fiducials: 0, has_pivot: false };
        let mut section: Option<String> = None;
        for (number, line) in (1..).zip(file.lines()) {
            let wrong = |found: String, expected: &str| FormatError::line(number, found, expected);
            if let Some(name) = header(line) {
                values.fiducials += usize::from(fiducial_index(&name).is_some());
                values.has_pivot |= name == "pivot";
                let key = (name.clone(), String::new());
                if values.of.insert(key, (number, "")).is_some() {
                    return Err(wrong(format!("[{name}] again"), "each section once"));
                }
                section = Some(name);
            } else if let (Some((key, value)), Some(section)) = (entry(line), &section) {
                let place = (section.clone(), key.clone());
                if values.of.insert(place, (number, value)).is_some() {
                    return Err(wrong(format!("{key} again"), "each key of a section once"));
                }
            } else if !bare(line).is_empty() {
                let found: String = bare(line).chars().take(24).collect();
                return Err(wrong(format!("{found:?}"), "a [section] or a key=value within one"));
            }
        }
        Ok(values)
    }

    fn geometry(&self) -> Result<Geometry, FormatError> {
        let count = self.number::<usize>("geometry", "count", "a count")?;
        if count == 0 || count != self.fiducials {
            return Err(FormatError::field(
                "geometry.count",
                format!("{count}, with {} [fiducial…] sections", self.fiducials),
                "the number of these, one at least",
            ));
        }
        Geometry::check_count(count)?;
        let id = match self.get("geometry", "id") {
            None => None,
            Some(_) => Some(self.number("geometry", "id", "a whole number")?),
        };
        let fiducials = (0..count).map(|i| self.point(&format!("fiducial{i}")));
        Ok(Geometry {
            id,
            fiducials: fiducials.collect::<Result<_, _>>()?,
            pivot: self.has_pivot.then(|| self.point("pivot")).transpose()?,
        })
    }

    fn get(&self, section: &str, key: &str) -> Option<(u64, &'a str)> {
        self.of.get(&(section.to_owned(), key.to_owned())).copied()
    }

    fn point(&self, section: &str) -> Result<Point3<f64>, FormatError> {
        let mut point = Point3::origin();
        for (i, axis) in AXES.iter().enumerate() {
            let value: f64 = self.number(section, axis, "a number of mm")?;
            if !value.is_finite() {
                return Err(FormatError::field(
                    format!("{section}.{axis}"),
                    value,
                    "a number of mm",
                ));
            }
            point[i] = value;
        }
        Ok(point)
    }

    fn number<T: std::str::FromStr>(
        &self,
        section: &str,
        key: &str,
        expected: &'static str,
    ) -> Result<T, FormatError> {
        let field = format!("{section}.{key}");
        let Some((line, value)) = self.get(section, key) else {
            return Err(FormatError::field(field, "missing", expected));
        };
        value.parse().map_err(|_| {
            let found = format!("{:?}", value.chars().take(24).collect::<String>());
            FormatError::cell(line, field, found, expected)
        })
    }
}
