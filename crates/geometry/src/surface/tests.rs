//! Rays and closest points held against every triangle, and shapes for other tests.

use super::*;
use crate::mesh::MeshPart;
use std::f64::consts::TAU;

/// A closed cylinder along z with smooth sides and flat caps.
pub(crate) fn cylinder(radius_mm: f64, length_mm: f64, sides: u32) -> SurfaceMesh {
    let mut part = MeshPart { name: "shaft".to_owned(), ..MeshPart::default() };
    let rim = |i: u32| {
        // The last corner is the first to the bit, so that nothing gapes.
        let (sine, cosine) = (f64::from(i % sides) / f64::from(sides) * TAU).sin_cos();
        Vector3::new(cosine, sine, 0.0)
    };
    for i in 0..sides {
        let base = part.positions_mm.len() as u32;
        for (corner, z) in [(i, 0.0), (i + 1, 0.0), (i + 1, length_mm), (i, length_mm)] {
            part.positions_mm.push(Point3::from(rim(corner) * radius_mm + Vector3::z() * z));
            part.normals.push(rim(corner));
        }
        part.triangles.extend([[base, base + 1, base + 2], [base, base + 2, base + 3]]);
        for (z, normal, order) in
            [(0.0, -Vector3::z(), [0, 2, 1]), (length_mm, Vector3::z(), [0, 1, 2])]
        {
            let base = part.positions_mm.len() as u32;
            for offset in [Vector3::zeros(), rim(i) * radius_mm, rim(i + 1) * radius_mm] {
                part.positions_mm.push(Point3::from(offset + Vector3::z() * z));
                part.normals.push(normal);
            }
            part.triangles.push(order.map(|k: u32| base + k));
        }
    }
    SurfaceMesh { parts: vec![part], ..SurfaceMesh::default() }
}

fn ray(origin: [f64; 3], direction: [f64; 3]) -> Ray {
    Ray { origin_mm: origin.into(), direction: Unit::new_normalize(direction.into()) }
}

#[test]
fn a_ray_hits_the_near_side_with_the_smooth_normal() {
    let surface = Surface::new(&cylinder(2.0, 100.0, 64)).unwrap();
    let hit = surface.cast(&ray([50.0, 0.7, 40.0], [-1.0, 0.0, 0.0])).unwrap();
    // A chord of 64 sides is 2 (1 - cos(pi / 64)) = 0.0024 mm inside the circle.
    assert!((hit.position_mm - Point3::new((4.0f64 - 0.49).sqrt(), 0.7, 40.0)).norm() < 0.003);
    let radial = Vector3::new(hit.position_mm.x, hit.position_mm.y, 0.0).normalize();
    assert!(hit.normal.angle(&radial) < 0.005);
}

#[test]
fn rays_from_inside_or_past_the_body_miss() {
    let surface = Surface::new(&cylinder(2.0, 100.0, 32)).unwrap();
    assert!(surface.cast(&ray([0.0, 0.0, 50.0], [1.0, 0.0, 0.0])).is_none());
    assert!(surface.cast(&ray([50.0, 3.0, 50.0], [-1.0, 0.0, 0.0])).is_none());
    assert!(surface.cast(&ray([50.0, 0.0, 50.0], [1.0, 0.0, 0.0])).is_none());
}

/// Numbers from -1/2 to 1/2, the same each time.
pub(crate) fn random(mut state: u64) -> impl FnMut() -> f64 {
    move || {
        state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (state >> 11) as f64 / (1u64 << 53) as f64 - 0.5
    }
}

#[test]
fn the_tree_agrees_with_trying_every_triangle() {
    let surface = Surface::new(&cylinder(5.0, 80.0, 48)).unwrap();
    let mut random = random(1);
    for _ in 0..300 {
        let from = [random() * 60.0, random() * 60.0, random() * 200.0];
        let to = Point3::new(random() * 12.0, random() * 12.0, 40.0 + random() * 100.0);
        let ray = ray(from, (to - Point3::from(from)).into());
        let all = surface.triangles.iter().filter_map(|t| t.meets(&ray));
        let nearest = all.map(|m| m.0).min_by(f64::total_cmp).map(|d| ray.at(d));
        let found = surface.cast(&ray).map(|hit| hit.position_mm);
        assert_eq!(nearest.is_some(), found.is_some());
        if let (Some(a), Some(b)) = (nearest, found) {
            assert!((a - b).norm() < 1e-9);
        }
        let closest = surface.closest(&Point3::from(from));
        let least = surface
            .triangles
            .iter()
            .map(|t| (t.position(t.closest(&from.into())) - Point3::from(from)).norm())
            .min_by(f64::total_cmp)
            .unwrap();
        assert!(((closest.position_mm - Point3::from(from)).norm() - least).abs() < 1e-12);
    }
}

/// A ring along x and y, thick as `radius_mm`; two triangles a step around it and around its
/// tube.
fn torus(steps: [u32; 2], ring_mm: f64, radius_mm: f64) -> SurfaceMesh {
    let mut mesh = cylinder(1.0, 1.0, 3);
    let part = &mut mesh.parts[0];
    part.positions_mm.clear();
    part.normals.clear();
    part.triangles.clear();
    let [around, across] = steps;
    for i in 0..around {
        let (sine, cosine) = (f64::from(i) / f64::from(around) * TAU).sin_cos();
        let outward = Vector3::new(cosine, sine, 0.0);
        for j in 0..across {
            let (sine, cosine) = (f64::from(j) / f64::from(across) * TAU).sin_cos();
            let normal = outward * cosine + Vector3::z() * sine;
            part.positions_mm.push(Point3::from(outward * ring_mm + normal * radius_mm));
            part.normals.push(normal);
            let at = |i: u32, j: u32| i % around * across + j % across;
            let [a, b] = [at(i, j), at(i + 1, j)];
            let [c, d] = [at(i + 1, j + 1), at(i, j + 1)];
            part.triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
    mesh
}

#[test]
fn a_tree_does_not_depend_on_threads() {
    let mesh = torus([300, 150], 60.0, 15.0);
    assert!(mesh.parts[0].triangles.len() > 4 * LEAST_SHARED);
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build();
    let alone = pool.unwrap().install(|| Surface::new(&mesh)).unwrap();
    let surface = Surface::new(&mesh).unwrap();
    assert_eq!(format!("{:?}", surface.nodes), format!("{:?}", alone.nodes));
    let mut random = random(5);
    for i in 0..60 {
        // Some along an axis, where boxes are met on their faces.
        let from = Point3::new(random() * 400.0, random() * 400.0, random() * 400.0);
        let to = Point3::new(random() * 150.0, random() * 150.0, random() * 30.0);
        let direction = if i % 6 == 0 { -Vector3::z() } else { to - from };
        let origin = if i % 6 == 0 { to + Vector3::z() * 99.0 } else { from };
        let ray = ray(origin.coords.into(), direction.into());
        let all = surface.triangles.iter().filter_map(|t| t.meets(&ray));
        let nearest = all.map(|m| m.0).min_by(f64::total_cmp);
        let found = surface.cast(&ray).map(|hit| hit.position_mm);
        assert_eq!(nearest.is_some(), found.is_some());
        if let (Some(distance), Some(found)) = (nearest, found) {
            assert!((ray.at(distance) - found).norm() < 1e-9);
        }
        // On a torus it is known: toward the nearest point of the ring.
        let on_ring = Vector3::new(from.x, from.y, 0.0).normalize() * 60.0;
        let exact = ((from.coords - on_ring).norm() - 15.0).abs();
        let closest = surface.closest(&from);
        // A chord of 150 sides is 15 (1 - cos(pi / 150)) = 0.0033 mm inside, one of 300 around
        // the outer rim 75 (1 - cos(pi / 300)) = 0.0041 mm.
        let distance = (closest.position_mm - from).norm();
        assert!((distance - exact).abs() < 0.0075, "{distance} {exact}");
    }
}

#[test]
fn a_surface_is_shared_between_threads() {
    fn is_shared<T: Send + Sync>() {}
    is_shared::<Surface>();
}

#[test]
fn the_axis_is_a_radius_from_the_surface() {
    let surface = Surface::new(&cylinder(2.0, 100.0, 64)).unwrap();
    let closest = surface.closest(&Point3::new(0.0, 0.0, 40.0));
    assert!((closest.position_mm - Point3::new(0.0, 0.0, 40.0)).norm() < 2.0);
    assert!((closest.position_mm.z - 40.0).abs() < 1e-9);
}

#[test]
fn the_gap_to_a_line_is_perpendicular() {
    let ray = ray([10.0, 3.0, 0.0], [-1.0, 0.2, 0.1]);
    let line = Unit::new_normalize(Vector3::new(0.1, 0.3, 1.0));
    let start = Point3::new(1.0, 2.0, 3.0);
    let place = start + line.into_inner() * ray.nearest_on_line(&start, &line).unwrap();
    let along_ray = (place - ray.origin_mm).dot(&ray.direction);
    let gap = place - ray.at(along_ray);
    assert!(gap.dot(&line).abs() < 1e-9 && gap.dot(&ray.direction).abs() < 1e-9);
    assert!(ray.nearest_on_line(&start, &ray.direction).is_none());
}

#[test]
fn a_ray_beside_a_shaft_slides_along_it() {
    let surface = Surface::new(&cylinder(1.0, 100.0, 32)).unwrap();
    let beside = ray([50.0, 6.0, 40.0], [-1.0, 0.0, 0.0]);
    let point = surface.under(&beside, &Point3::new(0.0, 0.0, 20.0));
    assert!((point.position_mm.z - 40.0).abs() < 1e-9);
    assert!((point.position_mm.y - 1.0).abs() < 0.01);
}

#[test]
fn anatomy_and_empty_meshes_are_no_surface() {
    let mut mesh = cylinder(1.0, 10.0, 8);
    mesh.parts[0].name = "anatomy-head".to_owned();
    assert!(Surface::new(&mesh).is_none());
    assert!(Surface::new(&SurfaceMesh::default()).is_none());
}
