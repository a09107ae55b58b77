//! What every mesh file must fulfil; shared by the tests of the instruments.

use std::collections::BTreeMap;

use trackwright_formats::mesh;
use trackwright_metal::surface::ClosedSurface;

use crate::glb;
use crate::model::Model;
use crate::shape::{Shape, ShapeBuilder, bounds_mm};
use crate::vector::{Vec3, VecExt};

/// Smaller faces than this are slivers: a square of 3 micrometres.
const MIN_FACE_MM2: f64 = 1e-5;

/// Asserts closed parts, outward unit normals, bounds within `tolerance_mm` and sane numbers.
pub fn assert_sound(model: &Model, low_mm: Vec3, high_mm: Vec3, tolerance_mm: f64) {
    for part in &model.parts {
        assert_closed(part.name, &part.shape);
    }
    assert_drawn_well(model, low_mm, high_mm, tolerance_mm);
    let triangles: usize = model.parts.iter().map(|part| part.shape.triangles.len()).sum();
    assert!((1_000..=25_000).contains(&triangles), "{triangles} triangles");
}

/// As many triangles as metal bodies are coarsened to: an instrument, a table.
const METAL_TRIANGLES: [usize; 2] = [400, 1000];

/// The part of a volume that coarsening may cost: an octagon has 10 % less than its circle.
const MAX_VOLUME_LOSS: f64 = 0.1;

/// Asserts what metal needs besides the rest of [`assert_sound`]: all parts together are one closed
/// surface, which does not cut itself when it is coarsened, and stays as large.
pub fn assert_sound_metal(model: &Model, low_mm: Vec3, high_mm: Vec3, tolerance_mm: f64) {
    let mut builder = ShapeBuilder::default();
    for part in &model.parts {
        assert!(!part.shape.triangles.is_empty(), "{} is empty", part.name);
        for triangle in &part.shape.triangles {
            builder.triangle(triangle.map(|index| part.shape.points[index as usize]));
        }
    }
    let whole = builder.finish();
    assert_closed(model.name, &whole);
    // Euler's formula of one surface without holes.
    assert_eq!(whole.points.len(), whole.triangles.len() / 2 + 2, "{}", model.name);
    assert_drawn_well(model, low_mm, high_mm, tolerance_mm);
    let triangles = whole.triangles.len();
    assert!((1_000..=5_000).contains(&triangles), "{triangles} triangles");
    let file = mesh::read(&glb::to_bytes(model), "glb", None).unwrap();
    for most in METAL_TRIANGLES {
        let coarse =
            ClosedSurface::remeshed(&file, most, &trackwright_task::Task::default()).unwrap();
        assert_eq!(coarse.shells().len(), 1);
        let loss = 1.0 - coarse.volume_mm3() / volume_mm3(&whole);
        assert!(loss.abs() < MAX_VOLUME_LOSS, "{} of {most} loses {loss}", model.name);
    }
}

fn assert_closed(name: &str, shape: &Shape) {
    assert_eq!(open_edge_count(shape), 0, "{name} has open edges");
    assert!(volume_mm3(shape) > 0.0, "{name} is inside out");
}

fn assert_drawn_well(model: &Model, low_mm: Vec3, high_mm: Vec3, tolerance_mm: f64) {
    let mut points = Vec::new();
    for part in &model.parts {
        let (name, shape) = (part.name, &part.shape);
        for triangle in &shape.triangles {
            let area_mm2 = shape.area_vector(triangle).norm();
            assert!(area_mm2 > MIN_FACE_MM2, "{name} has a sliver of {area_mm2} mm2");
        }
        let shaded = shape.shaded();
        for normal in &shaded.normals {
            assert!((normal.norm() - 1.0).abs() < 1e-9, "{name} has a normal that is not unit");
        }
        for triangle in &shaded.triangles {
            let [a, b, c] = triangle.map(|index| shaded.positions[index as usize]);
            let face = (b - a).cross(&(c - a));
            for index in triangle {
                let normal = shaded.normals[*index as usize];
                assert!(
                    face.dot(&normal) > 0.0,
                    "{name} has a normal that looks inwards near {a:?}"
                );
            }
        }
        points.extend_from_slice(&shape.points);
    }
    let (low, high) = bounds_mm(&points);
    let miss = [(low - low_mm).to_array(), (high - high_mm).to_array()].concat();
    assert!(miss.iter().all(|d| d.abs() <= tolerance_mm), "bounds are {low:?} to {high:?}");
}

/// How many edges are not shared by exactly two faces that run along them in opposite ways.
pub fn open_edge_count(shape: &Shape) -> usize {
    let mut uses_of_edge: BTreeMap<(u32, u32), (u32, i32)> = BTreeMap::new();
    for &[a, b, c] in &shape.triangles {
        for (from, to) in [(a, b), (b, c), (c, a)] {
            let (count, balance) = uses_of_edge.entry((from.min(to), from.max(to))).or_default();
            *count += 1;
            *balance += if from < to { 1 } else { -1 };
        }
    }
    uses_of_edge.values().filter(|&&uses| uses != (2, 0)).count()
}

/// Enclosed volume, positive when the faces look outwards.
pub fn volume_mm3(shape: &Shape) -> f64 {
    let six_volumes = shape.triangles.iter().map(|triangle| {
        let [a, b, c] = triangle.map(|index| shape.points[index as usize]);
        a.dot(&b.cross(&c))
    });
    six_volumes.sum::<f64>() / 6.0
}
