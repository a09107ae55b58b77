//! STL, binary and as text: triangles without unit, colour or shared vertices.
//!
//! A file whose length is what its count of triangles makes it is binary, whatever it begins with:
//! many programs write `solid` into the header of binary files. The normals in a file belong to
//! its triangles and add nothing to the corners; they are not read.

use super::builder::{Builder, in_mm};
use super::error::{MAX_TRIANGLES, MeshError};
use nalgebra::{Point3, Vector3};
use trackwright_geometry::mesh::SurfaceMesh;

/// A binary file's header, before the count of triangles.
const HEADER: usize = 80;

/// Header and count.
const START: usize = HEADER + 4;

/// A binary triangle: normal, three corners, two bytes without meaning.
const TRIANGLE: usize = 50;

/// How much of a file is read to distinguish text from numbers.
const LOOKED_AT: usize = 1024;

/// Longest piece of a file that an error quotes.
const MAX_QUOTE: usize = 24;

/// Whether the file looks like an STL where its name does not decide.
pub(super) fn is_stl(bytes: &[u8]) -> bool {
    announced(bytes).is_some_and(|count| bytes.len() as u64 == binary_len(count)) || is_text(bytes)
}

pub(super) fn parse(bytes: &[u8], mm_per_unit: f64) -> Result<SurfaceMesh, MeshError> {
    if bytes.trim_ascii().is_empty() {
        return Err(MeshError::Empty);
    }
    match announced(bytes) {
        Some(count) if bytes.len() as u64 == binary_len(count) => {
            parse_binary(bytes, count, mm_per_unit)
        }
        _ if is_text(bytes) => parse_text(bytes, mm_per_unit),
        count => Err(MeshError::Length {
            found: bytes.len(),
            expected: count.map_or(START as u64, binary_len),
            triangles: count.unwrap_or(0),
        }),
    }
}

/// How many triangles a binary file announces.
fn announced(bytes: &[u8]) -> Option<u32> {
    let count = bytes.get(HEADER..START)?;
    Some(u32::from_le_bytes(count.try_into().ok()?))
}

fn binary_len(count: u32) -> u64 {
    START as u64 + TRIANGLE as u64 * u64::from(count)
}

/// Whether the file begins with `solid`, in any case, and then has no control characters, which
/// the numbers of a binary file would be.
fn is_text(bytes: &[u8]) -> bool {
    let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    let start = bytes.trim_ascii_start();
    let start = &start[..start.len().min(LOOKED_AT)];
    start.len() >= 5
        && start[..5].eq_ignore_ascii_case(b"solid")
        && !start.iter().any(|&b| b < b' ' && !b.is_ascii_whitespace())
}

fn parse_binary(bytes: &[u8], count: u32, mm_per_unit: f64) -> Result<SurfaceMesh, MeshError> {
    if count as usize > MAX_TRIANGLES {
        return Err(MeshError::TooLarge(count as usize));
    }
    let mut builder = Builder::default();
    if let Some(name) = header_name(&bytes[..HEADER]) {
        builder.begin_part(&name);
    }
    for triangle in bytes[START..].chunks_exact(TRIANGLE) {
        let number = |at: usize| {
            let four = [0, 1, 2, 3].map(|k| triangle[at + k]);
            in_mm(f64::from(f32::from_le_bytes(four)), mm_per_unit)
        };
        let corner = |k: usize| -> Result<_, MeshError> {
            let at = 12 * (k + 1);
            Ok(Point3::new(number(at)?, number(at + 4)?, number(at + 8)?))
        };
        push(&mut builder, [corner(0)?, corner(1)?, corner(2)?], 0)?;
    }
    builder.finish()
}

/// The text in a header, up to what no person wrote.
fn header_name(header: &[u8]) -> Option<String> {
    let end = header.iter().position(|&b| b == 0).unwrap_or(header.len());
    let text = std::str::from_utf8(&header[..end]).ok()?;
    let text = text.strip_prefix("solid").unwrap_or(text).trim();
    let is_name = !text.is_empty() && !text.chars().any(char::is_control);
    is_name.then(|| text.to_owned())
}

fn push(builder: &mut Builder, corners_mm: [Point3<f64>; 3], line: usize) -> Result<(), MeshError> {
    match corners_mm.map(|corner| builder.vertex(corner)) {
        [Some(a), Some(b), Some(c)] => builder.push([a, b, c], line),
        _ => {
            builder.leave_out(1);
            Ok(())
        }
    }
}

/// What of a text the reader is within.
#[derive(Clone, Copy, PartialEq)]
enum Within {
    Outside,
    Facet,
    Loop,
}

fn parse_text(bytes: &[u8], mm_per_unit: f64) -> Result<SurfaceMesh, MeshError> {
    // What is not UTF-8 can only be in a name, or is quoted in an error.
    let text = String::from_utf8_lossy(bytes);
    let text = text.trim_start_matches('\u{feff}');
    let mut builder = Builder::default();
    let mut within = Within::Outside;
    let mut corners = Vec::with_capacity(3);
    let mut solids = 0;
    let mut is_ended = true;
    let mut last_line = 0;
    for (index, content) in lines(text).enumerate() {
        let line = index + 1;
        last_line = line;
        let mut words = content.split_whitespace();
        while let Some(word) = words.next() {
            let error = |found: &str, expected| {
                Err(MeshError::Line { line, found: found.to_owned(), expected })
            };
            match (word.to_ascii_lowercase().as_str(), within) {
                ("solid", Within::Outside) => {
                    solids += 1;
                    is_ended = false;
                    let name = content.trim_start()[word.len()..].trim();
                    if name.is_empty() {
                        builder.begin_part(&format!("part {solids}"));
                    } else {
                        builder.begin_part(name);
                    }
                    break;
                }
                ("endsolid", Within::Outside) => {
                    is_ended = true;
                    break;
                }
                ("facet", Within::Outside) if !is_ended => {
                    within = Within::Facet;
                    // The normal, or whatever stands there.
                    while words.clone().next().is_some_and(|w| !is_word(w, "outer")) {
                        words.next();
                    }
                }
                ("outer", Within::Facet) => {}
                ("loop", Within::Facet) => {
                    within = Within::Loop;
                    corners.clear();
                }
                ("vertex", Within::Loop) => corners.push(point_mm(&mut words, line, mm_per_unit)?),
                ("endloop", Within::Loop) => {
                    let &[a, b, c] = corners.as_slice() else {
                        return error(&format!("{} corners", corners.len()), "three");
                    };
                    push(&mut builder, [a, b, c], line)?;
                    within = Within::Facet;
                }
                ("endfacet", Within::Facet) => within = Within::Outside,
                (_, within) => {
                    let expected = match within {
                        Within::Outside if is_ended => "`solid`",
                        Within::Outside => "`facet` or `endsolid`",
                        Within::Facet => "`outer loop` or `endfacet`",
                        Within::Loop => "`vertex` or `endloop`",
                    };
                    return error(&quote(word), expected);
                }
            }
        }
    }
    if !is_ended || within != Within::Outside {
        return Err(MeshError::Line {
            line: last_line,
            found: "the end of the file".to_owned(),
            expected: "`endsolid`: it is cut short",
        });
    }
    builder.finish()
}

fn is_word(found: &str, word: &str) -> bool {
    found.eq_ignore_ascii_case(word)
}

/// The next three words as numbers in millimetres.
pub(super) fn point_mm<'a>(
    words: &mut impl Iterator<Item = &'a str>,
    line: usize,
    mm_per_unit: f64,
) -> Result<Point3<f64>, MeshError> {
    let mut point = Point3::from(vector(words, line)?);
    for value in point.iter_mut() {
        *value = in_mm(*value, mm_per_unit)?;
    }
    Ok(point)
}

/// The next three words as numbers.
pub(super) fn vector<'a>(
    words: &mut impl Iterator<Item = &'a str>,
    line: usize,
) -> Result<Vector3<f64>, MeshError> {
    let mut vector = Vector3::zeros();
    for value in vector.iter_mut() {
        let word = words.next();
        *value = word.and_then(|word| word.parse().ok()).ok_or_else(|| MeshError::Line {
            line,
            found: word.map_or_else(|| "the end of the line".to_owned(), quote),
            expected: "a number",
        })?;
    }
    Ok(vector)
}

/// The lines of a text that ends them as Unix, Windows or old Macs do, or as each in places.
pub(super) fn lines(text: &str) -> impl Iterator<Item = &str> {
    text.split('\n').flat_map(|line| {
        let line = line.strip_suffix('\r').unwrap_or(line);
        line.split('\r')
    })
}

/// A word for an error, its beginning if it is long.
pub(super) fn quote(word: &str) -> String {
    let start: String = word.chars().take(MAX_QUOTE).collect();
    format!("`{}`", start.escape_debug())
}
