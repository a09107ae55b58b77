//! Wavefront OBJ: positions, normals, faces of any number of corners, groups. Materials are in
//! another file and not read; points, lines, curves and texture coordinates are passed over.

use super::builder::Builder;
use super::error::{MAX_TRIANGLES, MeshError};
use super::polygon::Cutter;
use super::stl::{lines, point_mm, quote, vector};
use nalgebra::{Point3, Vector3};
use std::borrow::Cow;
use trackwright_geometry::mesh::SurfaceMesh;

/// How many lines are looked at for a position.
const LOOKED_AT: usize = 100;

/// Whether one of the first lines is a position.
pub(super) fn is_obj(bytes: &[u8]) -> bool {
    bytes
        .split(|&b| b == b'\n' || b == b'\r')
        .take(LOOKED_AT)
        .any(|line| line.starts_with(b"v ") && line.iter().all(u8::is_ascii))
}

/// Most corners of a face: cutting it into triangles may take the square of them. CAD programs write
/// some hundred.
const MAX_CORNERS: usize = 10_000;

/// A corner of a face: its vertex, if that is at finite numbers, and its normal, if it has one.
#[derive(Clone, Copy)]
struct Corner {
    vertex: Option<u32>,
    normal: Option<u32>,
}

#[derive(Default)]
struct Reader {
    builder: Builder,
    cutter: Cutter,
    /// The vertex of each position of the file.
    vertices: Vec<Option<u32>>,
    /// Those without a direction are none.
    normals: Vec<Option<Vector3<f64>>>,
    /// One a triangle, as long as each corner has one.
    corner_normals: Option<Vec<[Vector3<f64>; 3]>>,
    /// The face that is read.
    corners: Vec<Corner>,
    polygon_mm: Vec<Point3<f64>>,
}

pub(super) fn parse(bytes: &[u8], mm_per_unit: f64) -> Result<SurfaceMesh, MeshError> {
    // What is not UTF-8 can only be in a name or comment, or is quoted in an error.
    let text = String::from_utf8_lossy(bytes);
    let text = text.trim_start_matches('\u{feff}');
    let mut reader = Reader { corner_normals: Some(Vec::new()), ..Reader::default() };
    let mut all = lines(text).enumerate();
    while let Some((index, content)) = all.next() {
        let mut content = Cow::Borrowed(content);
        // A line may go on in the next one, and that in its next: each is copied once.
        while content.ends_with('\\') {
            let whole = content.to_mut();
            whole.pop();
            whole.push(' ');
            whole.push_str(all.next().map_or("", |(_, next)| next));
        }
        reader.read_line(&content, index + 1, mm_per_unit)?;
    }
    let Reader { builder, corner_normals, .. } = reader;
    match corner_normals {
        Some(normals) => builder.finish_with(&normals),
        None => builder.finish(),
    }
}

impl Reader {
    fn read_line(&mut self, content: &str, line: usize, mm_per_unit: f64) -> Result<(), MeshError> {
        let content = content.split('#').next().unwrap_or_default().trim();
        let (keyword, rest) = content.split_once(char::is_whitespace).unwrap_or((content, ""));
        match keyword {
            "v" => {
                // What follows (a weight, a colour) is passed over.
                let position = point_mm(&mut rest.split_whitespace(), line, mm_per_unit)?;
                check_count(self.vertices.len(), "vertices", line)?;
                let vertex = self.builder.vertex(position);
                self.vertices.push(vertex);
            }
            "vn" => {
                let normal = vector(&mut rest.split_whitespace(), line)?;
                check_count(self.normals.len(), "normals", line)?;
                let unit = normal.try_normalize(f64::MIN_POSITIVE);
                self.normals.push(unit.filter(|n| n.iter().all(|v| v.is_finite())));
            }
            "o" | "g" if !rest.trim().is_empty() => self.builder.begin_part(rest.trim()),
            "f" => self.read_face(rest, line)?,
            _ => {}
        }
        Ok(())
    }

    fn read_face(&mut self, rest: &str, line: usize) -> Result<(), MeshError> {
        self.corners.clear();
        for word in rest.split_whitespace() {
            let mut parts = word.split('/');
            let position = parts.next().unwrap_or_default();
            let vertex = index(position, self.vertices.len(), line, "position")?;
            let normal = match parts.nth(1) {
                None | Some("") => None,
                Some(normal) => Some(index(normal, self.normals.len(), line, "normal")? as u32),
            };
            if self.corners.len() == MAX_CORNERS {
                return Err(MeshError::Line {
                    line,
                    found: format!("a face of more than {MAX_CORNERS} corners"),
                    expected: "fewer",
                });
            }
            self.corners.push(Corner { vertex: self.vertices[vertex], normal });
        }
        if self.corners.len() < 3 {
            return Err(MeshError::Line {
                line,
                found: format!("a face of {} corners", self.corners.len()),
                expected: "three or more",
            });
        }
        let vertices: Option<Vec<u32>> = self.corners.iter().map(|c| c.vertex).collect();
        let Some(vertices) = vertices else {
            self.builder.leave_out(self.corners.len() - 2);
            return Ok(());
        };
        self.polygon_mm.clear();
        self.polygon_mm.extend(vertices.iter().map(|&v| self.builder.position_mm(v)));
        for triangle in self.cutter.triangles(&self.polygon_mm).chunks_exact(3) {
            let places = [0, 1, 2].map(|k| triangle[k] as usize);
            self.builder.push(places.map(|k| vertices[k]), line)?;
            let normals = places.map(|k| {
                let normal = self.corners[k].normal?;
                self.normals[normal as usize]
            });
            // One corner without, and all are made, so that they fit each other.
            match (&mut self.corner_normals, normals) {
                (Some(all), [Some(a), Some(b), Some(c)]) => all.push([a, b, c]),
                (all, _) => *all = None,
            }
        }
        Ok(())
    }
}

/// A file can have more numbers than the limit on triangles lets anything use.
fn check_count(count: usize, what: &'static str, line: usize) -> Result<(), MeshError> {
    if count < MAX_TRIANGLES { Ok(()) } else { Err(MeshError::TooLargeAt { line, what }) }
}

/// An index as OBJ has them, from 1, or from -1 backwards from the latest; as one from 0.
fn index(word: &str, count: usize, line: usize, what: &'static str) -> Result<usize, MeshError> {
    let from_zero = match word.parse::<i64>() {
        Ok(n @ 1..) => usize::try_from(n - 1).ok(),
        Ok(n @ ..=-1) => {
            usize::try_from(n.unsigned_abs()).ok().and_then(|back| count.checked_sub(back))
        }
        _ => None,
    };
    from_zero.filter(|&index| index < count).ok_or_else(|| MeshError::Line {
        line,
        found: format!("{what} {} of {count} so far", quote(word)),
        expected: "one of them",
    })
}
