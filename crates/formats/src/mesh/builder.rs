//! A mesh in the making, from formats without material: vertices merged, normals made, parts apart.

use super::error::{MAX_TRIANGLES, MeshError};
use nalgebra::{Point3, Vector3};
use std::collections::HashMap;
use trackwright_geometry::mesh::{ANATOMY_PREFIX, MeshPart, MeshReading, SurfaceMesh};
use trackwright_geometry::normals::{Smoothed, smoothed};
use trackwright_geometry::weld::welded;

/// Linear RGBA of what has no colour of its own: a light grey, as of plastic.
const PLAIN_COLOR: [f32; 4] = [0.6, 0.6, 0.6, 1.0];

/// Between gloss and chalk.
const PLAIN_ROUGHNESS: f32 = 0.5;

/// Most parts that are kept apart: each is drawn by itself, and some programs make every face of a
/// model a group.
const MAX_PARTS: usize = 1000;

/// The parts that all others become then.
const REST: &str = "other parts";
const REST_OF_ANATOMY: &str = "anatomy, other parts";

/// A coordinate in millimetres; one that is no finite number in the file is none here.
///
/// # Errors
/// [`MeshError::TooFar`] where the unit makes a number too large to be one.
pub(super) fn in_mm(value: f64, mm_per_unit: f64) -> Result<f64, MeshError> {
    let value_mm = value * mm_per_unit;
    match value.is_finite() && value_mm.is_infinite() {
        true => Err(MeshError::TooFar(f64::MAX)),
        false => Ok(value_mm),
    }
}

/// Triangles in parts, in the order in which parts are first met.
#[derive(Default)]
pub(super) struct Builder {
    /// Of the part that triangles go to, and its place once it has some.
    name: String,
    part: Option<u32>,
    names: Vec<String>,
    by_name: HashMap<String, u32>,
    positions_mm: Vec<Point3<f64>>,
    by_position: HashMap<[u64; 3], u32>,
    triangles: Vec<[u32; 3]>,
    /// One a triangle.
    parts: Vec<u32>,
    left_out: usize,
}

impl Builder {
    /// Begins a part, or goes on with the one of that name.
    pub(super) fn begin_part(&mut self, name: &str) {
        self.name.clear();
        self.name.push_str(name);
        self.part = None;
    }

    /// The part that triangles go to; it is made when the first one comes.
    fn part(&mut self) -> u32 {
        if let Some(part) = self.part {
            return part;
        }
        let mut name = self.name.as_str();
        if name.is_empty() {
            name = "part 1";
        }
        if self.names.len() >= MAX_PARTS && !self.by_name.contains_key(name) {
            name = if name.starts_with(ANATOMY_PREFIX) { REST_OF_ANATOMY } else { REST };
        }
        let part = match self.by_name.get(name) {
            Some(&part) => part,
            None => {
                let part = self.names.len() as u32;
                self.names.push(name.to_owned());
                self.by_name.insert(name.to_owned(), part);
                part
            }
        };
        self.part = Some(part);
        part
    }

    /// The vertex at a position; the same for the same numbers. `None` where it is no position.
    pub(super) fn vertex(&mut self, position_mm: Point3<f64>) -> Option<u32> {
        if position_mm.iter().any(|v| !v.is_finite()) {
            return None;
        }
        // Adding zero turns -0 to 0, which is the same place.
        let bits = [0, 1, 2].map(|k| (position_mm[k] + 0.0).to_bits());
        let next = self.positions_mm.len() as u32;
        let vertex = *self.by_position.entry(bits).or_insert(next);
        if vertex == next {
            self.positions_mm.push(position_mm);
        }
        Some(vertex)
    }

    pub(super) fn position_mm(&self, vertex: u32) -> Point3<f64> {
        self.positions_mm[vertex as usize]
    }

    /// Adds a triangle of vertices that [`Self::vertex`] gave; `line` is where the file has it.
    pub(super) fn push(&mut self, triangle: [u32; 3], line: usize) -> Result<(), MeshError> {
        if self.triangles.len() >= MAX_TRIANGLES {
            let what = "triangles";
            return Err(MeshError::TooLargeAt { line, what });
        }
        let part = self.part();
        self.triangles.push(triangle);
        self.parts.push(part);
        Ok(())
    }

    /// Counts a triangle that cannot be drawn.
    pub(super) fn leave_out(&mut self, triangles: usize) {
        self.left_out += triangles;
    }

    /// The mesh with normals made.
    pub(super) fn finish(self) -> Result<SurfaceMesh, MeshError> {
        self.check()?;
        let Self { names, positions_mm, by_position, triangles, parts, left_out, .. } = self;
        drop(by_position);
        let (positions_mm, triangles) = as_one_vertex(&positions_mm, triangles);
        let smooth = smoothed(&positions_mm, &triangles);
        let reading = MeshReading {
            normals_made: true,
            triangles_left_out: left_out,
            ..MeshReading::default()
        };
        Ok(split(names, &parts, smooth, reading))
    }

    /// The mesh with the file's own normals, one a corner and unit length.
    pub(super) fn finish_with(
        self,
        corner_normals: &[[Vector3<f64>; 3]],
    ) -> Result<SurfaceMesh, MeshError> {
        self.check()?;
        let mut by_both: HashMap<(u32, [u64; 3]), u32> = HashMap::new();
        let mut out = Smoothed::default();
        for (triangle, normals) in self.triangles.iter().zip(corner_normals) {
            let corners = [0, 1, 2].map(|k| {
                let bits = [0, 1, 2].map(|axis| normals[k][axis].to_bits());
                let next = out.normals.len() as u32;
                let vertex = *by_both.entry((triangle[k], bits)).or_insert(next);
                if vertex == next {
                    out.positions_mm.push(self.position_mm(triangle[k]));
                    out.normals.push(normals[k]);
                }
                vertex
            });
            out.triangles.push(corners);
        }
        let reading = MeshReading {
            normals_made: false,
            triangles_left_out: self.left_out,
            ..MeshReading::default()
        };
        Ok(split(self.names, &self.parts, out, reading))
    }

    fn check(&self) -> Result<(), MeshError> {
        match (self.triangles.is_empty(), self.left_out) {
            (false, _) => Ok(()),
            (true, 0) => Err(MeshError::Empty),
            (true, left_out) => Err(MeshError::NoNumbers { left_out }),
        }
    }
}

/// Vertices that round-off parts would leave a seam between the triangles of a round shaft.
fn as_one_vertex(
    positions_mm: &[Point3<f64>],
    mut triangles: Vec<[u32; 3]>,
) -> (Vec<Point3<f64>>, Vec<[u32; 3]>) {
    let places = welded(positions_mm);
    let mut kept = Vec::with_capacity(positions_mm.len());
    for (position, &place) in positions_mm.iter().zip(&places) {
        if place as usize == kept.len() {
            kept.push(*position);
        }
    }
    for corner in triangles.iter_mut().flatten() {
        *corner = places[*corner as usize];
    }
    (kept, triangles)
}

/// Takes a mesh apart; parts without triangles are none.
fn split(names: Vec<String>, parts: &[u32], whole: Smoothed, reading: MeshReading) -> SurfaceMesh {
    let mut by_part = vec![Vec::new(); names.len()];
    for (triangle, &part) in whole.triangles.iter().zip(parts) {
        by_part[part as usize].push(*triangle);
    }
    // Where each vertex is in the part that had it last.
    let mut places = vec![(u32::MAX, 0_u32); whole.normals.len()];
    let parts = names
        .into_iter()
        .zip(by_part)
        .enumerate()
        .filter(|(_, (_, triangles))| !triangles.is_empty())
        .map(|(index, (name, mut triangles))| {
            let mut part = MeshPart {
                name,
                positions_mm: Vec::new(),
                normals: Vec::new(),
                triangles: Vec::new(),
                base_color: PLAIN_COLOR,
                metallic: 0.0,
                roughness: PLAIN_ROUGHNESS,
            };
            for corner in triangles.iter_mut().flatten() {
                let old = *corner as usize;
                let (owner, place) = &mut places[old];
                if *owner != index as u32 {
                    (*owner, *place) = (index as u32, part.normals.len() as u32);
                    part.positions_mm.push(whole.positions_mm[old]);
                    part.normals.push(whole.normals[old]);
                }
                *corner = *place;
            }
            part.triangles = triangles;
            part
        })
        .collect();
    SurfaceMesh { parts, reading }
}
