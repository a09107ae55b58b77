//! Closed meshes of simple solids whose triangles suit boundary elements: small at edges, where charge
//! gathers, and of the solid's own volume.

use nalgebra::{Point3, Vector3};
use std::collections::HashMap;
use std::f64::consts::{PI, TAU};
use trackwright_geometry::limits::{length_above_zero_problem, short};
use trackwright_geometry::mesh::{MeshPart, SurfaceMesh};

/// Fewest triangles of a box or a cylinder.
pub const MIN_TRIANGLES: usize = 48;

/// Most triangles that a shape is cut into.
pub const MAX_TRIANGLES: usize = 20_000;

/// Finest sphere: 81,920 triangles.
const MAX_SUBDIVISIONS: u32 = 6;

/// Fewest sides of a cylinder.
const MIN_SIDES: usize = 12;

/// Why there is no such shape.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ShapeError {
    #[error("{name} is {found} mm, expected {expected}")]
    Length { name: &'static str, found: String, expected: &'static str },
    #[error("{0} triangles, expected {MIN_TRIANGLES} to {MAX_TRIANGLES}")]
    Triangles(usize),
    #[error("{0} subdivisions, expected at most {MAX_SUBDIVISIONS}")]
    Subdivisions(u32),
}

/// An icosahedron cut `subdivisions` times: `20 · 4^subdivisions` triangles (1,280 for 3), about the
/// origin. Its corners are a little outside the sphere, so that it encloses the sphere's volume, which
/// the induced dipole is proportional to.
///
/// # Errors
/// A radius or number that cannot be.
pub fn sphere(radius_mm: f64, subdivisions: u32) -> Result<SurfaceMesh, ShapeError> {
    check_length("radius", radius_mm)?;
    if subdivisions > MAX_SUBDIVISIONS {
        return Err(ShapeError::Subdivisions(subdivisions));
    }
    let (mut corners, mut triangles) = icosahedron();
    for _ in 0..subdivisions {
        let mut middles: HashMap<[u32; 2], u32> = HashMap::new();
        let mut middle = |a: u32, b: u32| {
            *middles.entry([a.min(b), a.max(b)]).or_insert_with(|| {
                corners.push((corners[a as usize] + corners[b as usize]).normalize());
                corners.len() as u32 - 1
            })
        };
        let quarters = triangles.iter().flat_map(|&[a, b, c]| {
            let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
            [[a, ab, ca], [ab, b, bc], [ca, bc, c], [bc, ca, ab]]
        });
        triangles = quarters.collect();
    }
    let volume: f64 = triangles
        .iter()
        .map(|t| {
            let [a, b, c] = t.map(|i| corners[i as usize]);
            a.dot(&b.cross(&c)) / 6.0
        })
        .sum();
    let scale_mm = radius_mm * (4.0 * PI / 3.0 / volume).cbrt();
    Ok(mesh(MeshPart {
        name: "sphere".to_owned(),
        positions_mm: corners.iter().map(|corner| Point3::from(corner * scale_mm)).collect(),
        normals: corners,
        triangles,
        ..MeshPart::default()
    }))
}

/// A box about the origin of at most `most_triangles`, which get smaller towards its edges. A plate is a
/// box that is flat.
///
/// # Errors
/// Lengths or a number that cannot be.
pub fn cuboid(size_mm: &Vector3<f64>, most_triangles: usize) -> Result<SurfaceMesh, ShapeError> {
    for (name, length_mm) in ["width", "depth", "height"].into_iter().zip(size_mm.iter()) {
        check_length(name, *length_mm)?;
    }
    let cells = |step_mm: f64| size_mm.map(|length| divisions(length, step_mm, 1));
    let count =
        |cells: &Vector3<usize>| 4 * (cells.x * cells.y + cells.y * cells.z + cells.z * cells.x);
    let step_mm = finest(size_mm.amax(), most_triangles, |step_mm| count(&cells(step_mm)))?;
    let cells = cells(step_mm);
    let mut part = MeshPart { name: "box".to_owned(), ..MeshPart::default() };
    for axis in 0..3 {
        let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
        for side in [-1.0, 1.0] {
            let point = |s: f64, t: f64| {
                let mut p = Point3::origin();
                p[axis] = 0.5 * side * size_mm[axis];
                p[u] = 0.5 * size_mm[u] * s;
                p[v] = 0.5 * size_mm[v] * t;
                p
            };
            let normal = Vector3::ith(axis, side);
            push_grid(&mut part, [cells[u], cells[v]], side > 0.0, |[i, j]| {
                (point(graded(i, cells[u]), graded(j, cells[v])), normal)
            });
        }
    }
    Ok(mesh(part))
}

/// A cylinder along z about the origin of at most `most_triangles`, which get smaller towards its rims.
/// Its cross-section is a polygon of the circle's area.
///
/// # Errors
/// Lengths or a number that cannot be.
pub fn cylinder(
    radius_mm: f64,
    length_mm: f64,
    most_triangles: usize,
) -> Result<SurfaceMesh, ShapeError> {
    check_length("radius", radius_mm)?;
    check_length("length", length_mm)?;
    let cells = |step_mm: f64| {
        let sides = divisions(TAU * radius_mm, step_mm, MIN_SIDES);
        (sides, divisions(radius_mm, step_mm, 1), divisions(length_mm, step_mm, 1))
    };
    let count = |(sides, rings, along): (usize, usize, usize)| {
        2 * sides * (2 * rings - 1) + 2 * sides * along
    };
    let largest_mm = length_mm.max(TAU * radius_mm);
    let step_mm = finest(largest_mm, most_triangles, |step_mm| count(cells(step_mm)))?;
    let (sides, rings, along) = cells(step_mm);
    let turn = TAU / sides as f64;
    // A polygon of n sides has n/2 sin(2π/n) of its circumcircle's square radius.
    let corner_mm = radius_mm * (turn / turn.sin()).sqrt();
    let ray = |side: usize| {
        let (y, x) = (turn * (side % sides) as f64).sin_cos();
        Vector3::new(x, y, 0.0)
    };
    let mut part = MeshPart { name: "cylinder".to_owned(), ..MeshPart::default() };
    push_grid(&mut part, [sides, along], true, |[side, at]| {
        let z = Vector3::z() * (0.5 * length_mm * graded(at, along));
        (Point3::from(ray(side) * corner_mm + z), ray(side))
    });
    for end in [-1.0, 1.0] {
        let middle = Vector3::z() * (0.5 * length_mm * end);
        let radius = |ring: usize| corner_mm * rim_graded(ring, rings);
        if rings > 1 {
            push_grid(&mut part, [rings - 1, sides], end > 0.0, |[ring, side]| {
                (Point3::from(middle + ray(side) * radius(ring + 1)), Vector3::z() * end)
            });
        }
        let base = part.positions_mm.len() as u32;
        part.positions_mm.push(middle.into());
        let inner = (0..sides).map(|side| Point3::from(middle + ray(side) * radius(1)));
        part.positions_mm.extend(inner);
        part.normals.extend(vec![Vector3::z() * end; sides + 1]);
        part.triangles.extend((0..sides as u32).map(|side| {
            let (a, b) = (base + 1 + side, base + 1 + (side + 1) % sides as u32);
            if end > 0.0 { [base, a, b] } else { [base, b, a] }
        }));
    }
    Ok(mesh(part))
}

fn mesh(part: MeshPart) -> SurfaceMesh {
    SurfaceMesh { parts: vec![part], ..SurfaceMesh::default() }
}

pub(crate) fn check_length(name: &'static str, length_mm: f64) -> Result<(), ShapeError> {
    match length_above_zero_problem(length_mm) {
        None => Ok(()),
        Some(expected) => Err(ShapeError::Length { name, found: short(length_mm), expected }),
    }
}

fn divisions(length_mm: f64, step_mm: f64, fewest: usize) -> usize {
    ((length_mm / step_mm).round() as usize).max(fewest)
}

/// The finest step whose triangles are no more than `most`.
fn finest(largest_mm: f64, most: usize, count: impl Fn(f64) -> usize) -> Result<f64, ShapeError> {
    if !(MIN_TRIANGLES..=MAX_TRIANGLES).contains(&most) {
        return Err(ShapeError::Triangles(most));
    }
    // At the coarse end there are the fewest triangles that a shape can have, which is below `most`.
    let (mut fine, mut coarse) = (largest_mm / most as f64, largest_mm);
    for _ in 0..60 {
        let middle = (fine * coarse).sqrt();
        if count(middle) <= most { coarse = middle } else { fine = middle }
    }
    Ok(coarse)
}

/// Position `at` of `count` along −1 to 1, nearer to each other towards both ends.
fn graded(at: usize, count: usize) -> f64 {
    let even = 2.0 * at as f64 / count as f64 - 1.0;
    if at == 0 || at == count {
        return even;
    }
    (0.5 * PI * even).sin()
}

/// Position `at` of `count` along 0 to 1, nearer to each other towards 1.
fn rim_graded(at: usize, count: usize) -> f64 {
    let even = at as f64 / count as f64;
    if at == count {
        return 1.0;
    }
    (0.5 * PI * even).sin()
}

/// Adds a grid of cells, two triangles each, that face along `u × v` where `is_forward`. Diagonals run
/// the same way on opposite faces.
fn push_grid(
    part: &mut MeshPart,
    cells: [usize; 2],
    is_forward: bool,
    corner: impl Fn([usize; 2]) -> (Point3<f64>, Vector3<f64>),
) {
    let base = part.positions_mm.len() as u32;
    for i in 0..=cells[0] {
        for j in 0..=cells[1] {
            let (position_mm, normal) = corner([i, j]);
            part.positions_mm.push(position_mm);
            part.normals.push(normal);
        }
    }
    let row = cells[1] as u32 + 1;
    for i in 0..cells[0] as u32 {
        for j in 0..cells[1] as u32 {
            let a = base + i * row + j;
            let (b, c, d) = (a + row, a + row + 1, a + 1);
            let pair = match is_forward {
                true => [[a, b, c], [a, c, d]],
                false => [[a, c, b], [a, d, c]],
            };
            part.triangles.extend(pair);
        }
    }
}

fn icosahedron() -> (Vec<Vector3<f64>>, Vec<[u32; 3]>) {
    let golden = 0.5 * (1.0 + 5.0_f64.sqrt());
    let corners = [
        [-1.0, golden, 0.0],
        [1.0, golden, 0.0],
        [-1.0, -golden, 0.0],
        [1.0, -golden, 0.0],
        [0.0, -1.0, golden],
        [0.0, 1.0, golden],
        [0.0, -1.0, -golden],
        [0.0, 1.0, -golden],
        [golden, 0.0, -1.0],
        [golden, 0.0, 1.0],
        [-golden, 0.0, -1.0],
        [-golden, 0.0, 1.0],
    ];
    let triangles = [
        [0, 11, 5],
        [0, 5, 1],
        [0, 1, 7],
        [0, 7, 10],
        [0, 10, 11],
        [1, 5, 9],
        [5, 11, 4],
        [11, 10, 2],
        [10, 7, 6],
        [7, 1, 8],
        [3, 9, 4],
        [3, 4, 2],
        [3, 2, 6],
        [3, 6, 8],
        [3, 8, 9],
        [4, 9, 5],
        [2, 4, 11],
        [6, 2, 10],
        [8, 6, 7],
        [9, 8, 1],
    ];
    (corners.map(|corner| Vector3::from(corner).normalize()).to_vec(), triangles.to_vec())
}

#[cfg(test)]
mod tests {
    use super::*;
    use trackwright_geometry::mesh_report::MeshReport;

    fn volume_mm3(mesh: &SurfaceMesh) -> f64 {
        let part = &mesh.parts[0];
        let six: f64 = (0..part.triangles.len())
            .map(|t| {
                let [a, b, c] = part.corners_mm(t).map(|p| p.coords);
                a.dot(&b.cross(&c))
            })
            .sum();
        six / 6.0
    }

    #[test]
    fn shapes_are_closed_and_have_their_volume() {
        let plate = Vector3::new(200.0, 120.0, 5.0);
        for (mesh, volume) in [
            (sphere(60.0, 3).unwrap(), 4.0 / 3.0 * PI * 60.0_f64.powi(3)),
            (cuboid(&plate, 1000).unwrap(), 200.0 * 120.0 * 5.0),
            (cuboid(&Vector3::repeat(50.0), 600).unwrap(), 50.0_f64.powi(3)),
            (cuboid(&Vector3::new(1.0, 1.0, 1e4), 48).unwrap(), 1e4),
            (cylinder(5.0, 150.0, 1000).unwrap(), PI * 25.0 * 150.0),
            (cylinder(100.0, 2.0, 1000).unwrap(), PI * 1e4 * 2.0),
            (cylinder(100.0, 2.0, MIN_TRIANGLES).unwrap(), PI * 1e4 * 2.0),
        ] {
            let report = MeshReport::of(&mesh);
            assert!(report.is_closed() && !report.is_inside_out, "{report:?}");
            let faults = (report.turned_edges, report.non_manifold_edges, report.without_area);
            assert_eq!((faults, report.components), ((0, 0, 0), 1));
            assert!((volume_mm3(&mesh) / volume - 1.0).abs() < 1e-12);
        }
    }

    #[test]
    fn shapes_use_the_triangles_they_may() {
        assert_eq!(sphere(1.0, 3).unwrap().parts[0].triangles.len(), 1280);
        for most in [48, 100, 500, 1000, 4000] {
            for mesh in [
                cuboid(&Vector3::new(200.0, 200.0, 10.0), most).unwrap(),
                cylinder(20.0, 100.0, most).unwrap(),
            ] {
                let count = mesh.parts[0].triangles.len();
                assert!(count <= most && 2 * count > most, "{most}: {count}");
            }
        }
    }

    #[test]
    fn shapes_that_cannot_be_are_refused() {
        let message = |result: Result<SurfaceMesh, ShapeError>| result.unwrap_err().to_string();
        assert_eq!(message(sphere(-1.0, 2)), "radius is -1 mm, expected a length above zero");
        assert_eq!(message(sphere(1.0, 7)), "7 subdivisions, expected at most 6");
        let flat = Vector3::new(1.0, f64::NAN, 1.0);
        assert_eq!(message(cuboid(&flat, 100)), "depth is NaN mm, expected a length above zero");
        assert_eq!(message(cylinder(1.0, 1.0, 9)), "9 triangles, expected 48 to 20000");
    }
}
