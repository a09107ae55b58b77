//! How answers settle with the triangles, and what they take.

use super::rings::{DEPTHS_MM, Rings, moment_along_z};
use super::tests::shape;
use super::*;
use crate::shapes::{cuboid, cylinder};
use std::time::Instant;
use trackwright_geometry::mesh::SurfaceMesh;

const TRIANGLES: [usize; 5] = [100, 200, 400, 800, 1000];

/// A body of about so many triangles, the skin depth and the permeability of its material, and its moment along z in
/// mm³ as known from elsewhere.
struct Case {
    name: &'static str,
    mesh: fn(usize) -> SurfaceMesh,
    depth_mm: f64,
    mu: f64,
    known_mm3: Option<f64>,
}

fn plate(triangles: usize) -> SurfaceMesh {
    cuboid(&Vector3::new(200.0, 200.0, 1.0), triangles).unwrap()
}

fn cases() -> Vec<Case> {
    let case = |name, mesh: fn(usize) -> SurfaceMesh, depth_mm, mu, known_mm3| Case {
        name,
        mesh,
        depth_mm,
        mu,
        known_mm3,
    };
    // Steel 304, aluminium, titanium and steel 416 at 10 kHz.
    vec![
        // A sheet of bars of current (Hoer and Love, J. Research NBS 69C, 1965).
        case("plate of steel 304, 200 by 200 by 1 mm", plate, 4.267, 1.008, Some(-24.375e5)),
        case(
            "disc of steel 304, 200 by 20 mm",
            |n| cylinder(100.0, 20.0, n).unwrap(),
            4.267,
            1.008,
            Some(-33.04e5),
        ),
        case(
            "disc of bronze, 200 by 1 mm, 13 kHz",
            |n| cylinder(100.0, 1.0, n).unwrap(),
            1.5,
            1.0,
            None,
        ),
        case(
            "block of steel 304, 60 by 50 by 40 mm",
            |n| cuboid(&Vector3::new(60.0, 50.0, 40.0), n).unwrap(),
            4.267,
            1.008,
            None,
        ),
        case(
            "rod of titanium, 20 by 100 mm",
            |n| cylinder(10.0, 100.0, n).unwrap(),
            6.71,
            1.0,
            None,
        ),
        case(
            "rod of steel 416, 10 by 100 mm",
            |n| cylinder(5.0, 100.0, n).unwrap(),
            0.14,
            700.0,
            None,
        ),
    ]
}

/// A table in the file `PAGE`: moments along z in 10⁵ mm³, and times of a shape and a material in s.
#[test]
#[ignore = "minutes; writes the table of the documentation"]
fn page_convergence() {
    let mut page = String::new();
    for case in cases() {
        page += &format!("| {} |", case.name);
        for triangles in TRIANGLES {
            let start = Instant::now();
            let shape = shape(&(case.mesh)(triangles));
            let of_shape = start.elapsed().as_secs_f64();
            let start = Instant::now();
            let body =
                BoundaryBody::new(Arc::clone(&shape), case.depth_mm, case.mu, &Task::default());
            let of_body = start.elapsed().as_secs_f64();
            let [in_phase, lag] = body.unwrap().moments_mm3();
            page += &format!(
                " {}: {:.4} ({:.4}) {of_shape:.2} + {of_body:.2} |",
                shape.surface().panels().len(),
                in_phase[(2, 2)] / 1e5,
                lag[(2, 2)] / 1e5,
            );
        }
        page += &format!(" {:?}\n", case.known_mm3.map(|known| known / 1e5));
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
