//! How answers settle with the triangles, and what they take.

use super::rings::{DEPTHS_MM, Rings, moment_along_z};
use super::tests::shape;
use super::*;
use crate::shapes::{cuboid, cylinder};
use std::time::Instant;
use trackwright_geometry::mesh::SurfaceMesh;

const TRIANGLES: [usize; 5] = [100, 200, 400, 800, 1000];

/// A body of about so many triangles, the skin depth in mm and the permeability of its material, and its moment along
/// z in 10⁵ mm³ by others: a sheet of bars of current (Hoer and Love, J. Research NBS 69C, 1965), and coupled rings.
type Case = (&'static str, fn(usize) -> SurfaceMesh, [f64; 2], Option<f64>);

fn disc(size_mm: [f64; 2], triangles: usize) -> SurfaceMesh {
    cylinder(0.5 * size_mm[0], size_mm[1], triangles).unwrap()
}

fn block(size_mm: [f64; 3], triangles: usize) -> SurfaceMesh {
    cuboid(&Vector3::from(size_mm), triangles).unwrap()
}

/// Steel 304, titanium and steel 416 at 10 kHz, bronze at 13 kHz.
const CASES: [Case; 6] = [
    (
        "plate, steel 304, 200 by 200 by 1 mm",
        |n| block([200.0, 200.0, 1.0], n),
        [4.267, 1.0],
        Some(-24.375),
    ),
    ("disc, steel 304, 200 by 20 mm", |n| disc([200.0, 20.0], n), [4.267, 1.0], Some(-33.04)),
    ("disc, bronze, 200 by 1 mm", |n| disc([200.0, 1.0], n), [1.5, 1.0], Some(-25.975)),
    ("block, steel 304, 60 by 50 by 40 mm", |n| block([60.0, 50.0, 40.0], n), [4.267, 1.0], None),
    ("rod, titanium, 20 by 100 mm", |n| disc([20.0, 100.0], n), [6.71, 1.0], None),
    ("rod, steel 416, 10 by 100 mm", |n| disc([10.0, 100.0], n), [0.14, 700.0], None),
];

/// A table in the file `PAGE`: moments along z in 10⁵ mm³, and times of a shape and a material in s.
#[test]
#[ignore = "minutes; writes the table of the documentation"]
fn page_convergence() {
    let mut page = String::new();
    for (name, mesh, [depth_mm, mu], known) in CASES {
        page += &format!("| {name} | {known:?} |");
        for triangles in TRIANGLES {
            let start = Instant::now();
            let shape = shape(&mesh(triangles));
            let of_shape = start.elapsed().as_secs_f64();
            let start = Instant::now();
            let body = BoundaryBody::new(Arc::clone(&shape), depth_mm, mu, &Task::default());
            let of_body = start.elapsed().as_secs_f64();
            let [in_phase, lag] = body.unwrap().moments_mm3();
            page += &format!(
                " {}: {:.4} ({:.4}) {of_shape:.2} + {of_body:.2} |",
                shape.surface().panels().len(),
                in_phase[(2, 2)] / 1e5,
                lag[(2, 2)] / 1e5,
            );
        }
        page.push('\n');
    }
    std::fs::write(std::env::var_os("PAGE").expect("a file of the name PAGE"), page).unwrap();
}

/// A table in the file `PAGE`: the largest difference in phase, and of what lags, over eight skin depths of discs from
/// coupled rings, in parts of the moment where no flux enters. `MOST=1600` adds finer meshes.
#[test]
#[ignore = "minutes; writes the table of the documentation"]
fn page_discs() {
    let most = std::env::var("MOST").ok().and_then(|text| text.parse().ok()).unwrap_or(800);
    let mut page = String::new();
    for (radius_mm, length_mm, along) in
        [(100.0, 0.3, 3), (100.0, 1.0, 5), (100.0, 3.0, 6), (100.0, 10.0, 10), (50.0, 5.0, 8)]
    {
        let rings = Rings::of_disc(radius_mm, length_mm, 60, along);
        let whole = rings.moment(1e-3).re;
        page += &format!("| {} by {length_mm} mm |", 2.0 * radius_mm);
        for triangles in [200, 400, 800, 1600, 2000].into_iter().filter(|count| *count <= most) {
            let shape = shape(&cylinder(radius_mm, length_mm, triangles).unwrap());
            let off = DEPTHS_MM.map(|depth_mm| {
                (moment_along_z(&shape, depth_mm) - rings.moment(depth_mm)) / whole
            });
            let worst =
                |of: fn(&c64) -> f64| off.iter().map(of).fold(0.0_f64, |a, b| a.max(b.abs()));
            let [in_phase, lag] = [worst(|off| off.re), worst(|off| off.im)];
            let count = shape.surface().panels().len();
            page += &format!(" {count}: {in_phase:.4} ({lag:.4}) |");
        }
        page.push('\n');
    }
    std::fs::write(std::env::var_os("PAGE").expect("a file of the name PAGE"), page).unwrap();
}
