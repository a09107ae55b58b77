//! Rays and closest points on a mesh of a million triangles, beside trying every triangle.

use divan::counter::ItemsCount;
use divan::{Bencher, black_box};
use nalgebra::{Point3, Unit, Vector3};
use std::f64::consts::TAU;
use trackwright_field::random_models::Seeded;
use trackwright_geometry::mesh::{MeshPart, SurfaceMesh};
use trackwright_geometry::surface::{Ray, Surface};

/// Steps around a torus and around its tube; two triangles each.
const STEPS: [u32; 2] = [1000, 500];
const TRIANGLES: usize = 1_000_000;

/// Queries a run; of a plain loop, which takes as long for each, so many fewer.
const QUERIES: usize = 1000;
const PLAIN_QUERIES: usize = 4;

fn torus() -> SurfaceMesh {
    let mut part = MeshPart::default();
    let [around, across] = STEPS;
    for i in 0..around {
        let (sine, cosine) = (f64::from(i) / f64::from(around) * TAU).sin_cos();
        let outward = Vector3::new(cosine, sine, 0.0);
        for j in 0..across {
            let (sine, cosine) = (f64::from(j) / f64::from(across) * TAU).sin_cos();
            let normal = outward * cosine + Vector3::z() * sine;
            part.positions_mm.push(Point3::from(outward * 60.0 + normal * 15.0));
            part.normals.push(normal);
            let at = |i: u32, j: u32| i % around * across + j % across;
            let [a, b] = [at(i, j), at(i + 1, j)];
            let [c, d] = [at(i + 1, j + 1), at(i, j + 1)];
            part.triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
    SurfaceMesh { parts: vec![part], ..SurfaceMesh::default() }
}

/// From around the torus to places in its box: two in three meet it.
fn rays(count: usize) -> Vec<Ray> {
    let mut seeded = Seeded::new(3);
    let mut within =
        |edges: [f64; 3]| Point3::from(edges.map(|edge| edge * (seeded.uniform() - 0.5)));
    (0..count)
        .map(|_| {
            let origin_mm = within([400.0; 3]);
            let direction = within([150.0, 150.0, 30.0]) - origin_mm;
            Ray { origin_mm, direction: Unit::new_normalize(direction) }
        })
        .collect()
}

/// Points up to a millimetre off the surface, as a pointer beside a shaft gives.
fn points(count: usize) -> Vec<Point3<f64>> {
    let mut seeded = Seeded::new(9);
    (0..count)
        .map(|_| {
            let (sine, cosine) = (TAU * seeded.uniform()).sin_cos();
            let outward = Vector3::new(cosine, sine, 0.0);
            let (sine, cosine) = (TAU * seeded.uniform()).sin_cos();
            let radius_mm = 14.0 + 2.0 * seeded.uniform();
            Point3::from(outward * (60.0 + radius_mm * cosine) + Vector3::z() * radius_mm * sine)
        })
        .collect()
}

#[divan::bench(sample_count = 10)]
fn build(bencher: Bencher) {
    let mesh = torus();
    bencher.counter(ItemsCount::new(TRIANGLES)).bench_local(|| Surface::new(black_box(&mesh)));
}

#[divan::bench]
fn ray_by_tree(bencher: Bencher) {
    let surface = Surface::new(&torus()).expect("a surface");
    let rays = rays(QUERIES);
    bencher.counter(ItemsCount::new(QUERIES)).bench_local(|| {
        for ray in &rays {
            black_box(surface.cast(black_box(ray)));
        }
    });
}

#[divan::bench]
fn closest_point_by_tree(bencher: Bencher) {
    let surface = Surface::new(&torus()).expect("a surface");
    let points = points(QUERIES);
    bencher.counter(ItemsCount::new(QUERIES)).bench_local(|| {
        for point in &points {
            black_box(surface.closest(black_box(point)));
        }
    });
}

/// Möller & Trumbore's test of every triangle.
#[divan::bench(sample_count = 5)]
fn ray_plain_loop(bencher: Bencher) {
    let mesh = torus();
    let part = &mesh.parts[0];
    let rays = rays(PLAIN_QUERIES);
    bencher.counter(ItemsCount::new(PLAIN_QUERIES)).bench_local(|| {
        for ray in &rays {
            let mut nearest_mm = f64::INFINITY;
            for triangle in 0..TRIANGLES {
                let [a, b, c] = part.corners_mm(triangle);
                let (ab, ac) = (b - a, c - a);
                let p = ray.direction.cross(&ac);
                let determinant = ab.dot(&p);
                if determinant <= 0.0 {
                    continue;
                }
                let from_a = ray.origin_mm - a;
                let q = from_a.cross(&ab);
                let v = from_a.dot(&p) / determinant;
                let w = ray.direction.dot(&q) / determinant;
                let distance_mm = ac.dot(&q) / determinant;
                if v >= 0.0 && w >= 0.0 && v + w <= 1.0 && distance_mm >= 0.0 {
                    nearest_mm = nearest_mm.min(distance_mm);
                }
            }
            black_box(nearest_mm);
        }
    });
}
