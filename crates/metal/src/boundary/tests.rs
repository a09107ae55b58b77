//! Against closed forms: spheres, spheroids and discs.

use super::*;
use crate::material::Material;
use crate::shapes::{cuboid, cylinder, sphere};
use crate::sphere::rule::spherical_rule;
use crate::sphere::{SphereResponse, sphere_factor};
use std::f64::consts::{PI, TAU};
use trackwright_field::generator::dipole::Dipole;
use trackwright_geometry::mesh::{MeshPart, SurfaceMesh};

pub(super) fn shape(mesh: &SurfaceMesh) -> Arc<BoundaryShape> {
    let surface = ClosedSurface::new(mesh).unwrap();
    Arc::new(BoundaryShape::new(surface, &Task::default()).unwrap())
}

fn body(shape: &Arc<BoundaryShape>, depth_mm: f64, mu: f64) -> BoundaryBody {
    BoundaryBody::new(Arc::clone(shape), depth_mm, mu, &Task::default()).unwrap()
}

/// What a body adds at a point to a field.
fn added(
    body: &BoundaryBody,
    field: impl Fn(&Point3<f64>) -> Vector3<f64>,
    at: &[Point3<f64>],
) -> Vec<Vector3<f64>> {
    let panels = body.surface().panels();
    let mean = |panel: &Panel| {
        let points = panel.rule_mm(50.0);
        let along = points.iter().map(|p| field(p).dot(panel.normal()));
        along.sum::<f64>() / points.len() as f64
    };
    let spans = body.shape().spans();
    let right = Mat::from_fn(panels.len() + spans.len(), 1, |i, _| match panels.get(i) {
        Some(panel) => mean(panel),
        None => {
            let each = spans[i - panels.len()].iter();
            each.map(|(share, panel)| share * panel.area_mm2() * mean(panel)).sum()
        }
    });
    let sources = body.sources(&body.answer().in_phase_of(&body.without_mean(&right)));
    let each = at.iter().map(|p| {
        let mut field = [Vector3::zeros()];
        body.add_fields(&sources, p, &mut field);
        field[0]
    });
    each.collect()
}

/// In phase, along the field: the moment of a body in an even field of unit strength, in mm³.
pub(super) fn moment(
    shape: &Arc<BoundaryShape>,
    depth_mm: f64,
    mu: f64,
    direction: &Vector3<f64>,
) -> f64 {
    let [in_phase, _] = body(shape, depth_mm, mu).moments_mm3();
    direction.dot(&(in_phase * direction))
}

const RADIUS_MM: f64 = 60.0;

/// At 1.6 radii.
fn source() -> (Point3<f64>, Vector3<f64>) {
    (Point3::new(0.0, 90.0, 33.1), Vector3::new(1.0, 0.2, -0.5))
}

/// A material of a skin depth at 10 kHz.
fn material(depth_mm: f64, mu: f64) -> Material {
    let per_m = 1e3 / depth_mm;
    Material::new(2.0 * per_m * per_m / (TAU * 1e4 * 2e-7 * TAU * mu), mu).unwrap()
}

/// Error over all directions at a distance from the middle, relative to the field there.
fn error_at(shape: &Arc<BoundaryShape>, depth_mm: f64, mu: f64, radii: f64) -> f64 {
    let (at, direction) = source();
    let dipole = Dipole::new(&at, &direction);
    let exact = SphereResponse::new(RADIUS_MM, &material(depth_mm, mu), 1e4).unwrap();
    let body = body(shape, depth_mm, mu);
    let rule = spherical_rule(12);
    let places: Vec<_> =
        rule.iter().map(|(d, _)| Point3::from(d.into_inner() * (radii * RADIUS_MM))).collect();
    let found = added(&body, |p| dipole.field(p), &places);
    let (mut wrong, mut whole) = (0.0, 0.0);
    for ((p, (_, weight)), found) in places.iter().zip(&rule).zip(found) {
        let expected = exact.field_of_dipole(&at, &direction, p).unwrap().field;
        wrong += weight * (found - expected).norm_squared();
        whole += weight * expected.norm_squared();
    }
    f64::sqrt(wrong / whole)
}

#[test]
fn a_sphere_answers_an_even_field_as_its_series() {
    // 80 triangles.
    let shape = shape(&sphere(10.0, 1).unwrap());
    for mu in [1.0, 10.0, 700.0] {
        for depth_mm in [0.3, 1.0, 3.0, 5.0, 10.0, 40.0, 1e3, 1e5] {
            let expected = sphere_factor(10.0, &material(depth_mm, mu), 1e4).unwrap().re;
            let found = moment(&shape, depth_mm, mu, &Vector3::new(0.6, 0.0, 0.8));
            let off = found / (FULL_ANGLE * 1e3) - expected;
            assert!(off.abs() < 0.005, "{mu} {depth_mm}: {expected} {off:+}");
        }
    }
}

#[test]
fn a_sphere_answers_a_dipole_as_its_series() {
    let shape = shape(&sphere(RADIUS_MM, 2).unwrap());
    for (depth_mm, mu) in [(1.0, 1.0), (10.0, 1.0), (40.0, 1.0), (10.0, 100.0), (1e4, 100.0)] {
        // Triangles of 18 mm, and a source 36 mm from the surface.
        for (radii, most) in [(1.3, 0.08), (1.6, 0.04), (3.0, 0.02)] {
            let error = error_at(&shape, depth_mm, mu, radii);
            assert!(error < most, "{depth_mm} {mu} {radii}: {error}");
        }
    }
}

#[test]
fn errors_fall_with_the_square_of_size() {
    for (depth_mm, mu) in [(20.0, 1.0), (5.0, 100.0)] {
        let [coarse, fine] = [1, 2].map(|subdivisions| {
            error_at(&shape(&sphere(RADIUS_MM, subdivisions).unwrap()), depth_mm, mu, 2.0)
        });
        let order = (coarse / fine).log2();
        assert!(order > 1.7, "{depth_mm} {mu}: {coarse} {fine}");
    }
}

/// A sphere drawn out or pressed along z: `−V / (1 − N)` and `V (μ − 1) / (1 + N (μ − 1))`.
#[test]
fn spheroids_answer_in_closed_form() {
    for ratio in [0.05, 4.0, 10.0] {
        let mut mesh = sphere(50.0, 1).unwrap();
        mesh.parts[0].positions_mm.iter_mut().for_each(|p| p.z *= ratio);
        let shape = shape(&mesh);
        let along = demagnetisation(ratio);
        let volume = 4.0 / 3.0 * PI * 50.0_f64.powi(3) * ratio;
        for (axis, n) in [(2, along), (0, 0.5 * (1.0 - along))] {
            let direction = Vector3::ith(axis, 1.0);
            for mu in [5.0, 100.0] {
                let expected = (mu - 1.0) / (1.0 + n * (mu - 1.0));
                let found = moment(&shape, f64::INFINITY, mu, &direction) / volume;
                assert!((found / expected - 1.0).abs() < 0.01, "{ratio} {axis} {mu}: {found}");
            }
            let found = moment(&shape, 1e-4, 1.0, &direction) / volume;
            let error = -found * (1.0 - n) - 1.0;
            assert!(error.abs() < 0.01, "{ratio} {axis}: {error}");
        }
    }
}

/// Osborn, Physical Review 67, 1945: along the axis of a spheroid of this ratio of its axes.
fn demagnetisation(ratio: f64) -> f64 {
    let square = ratio * ratio;
    if ratio > 1.0 {
        let e = (square - 1.0).sqrt();
        (ratio / e * (ratio + e).ln() - 1.0) / (square - 1.0)
    } else {
        (1.0 - ratio / (1.0 - square).sqrt() * ratio.acos()) / (1.0 - square)
    }
}

/// A disc without thickness that no flux enters: `−8/3 a³` along its axis (Bethe, Physical Review 66, 1944).
#[test]
fn thin_discs_approach_the_closed_form() {
    let excess = |thickness_mm: f64| {
        let shape = shape(&cylinder(100.0, thickness_mm, 300).unwrap());
        moment(&shape, 1e-4, 1.0, &Vector3::z()) / (-8.0 / 3.0 * 1e6) - 1.0
    };
    let excesses = [20.0, 5.0, 0.5].map(excess);
    // What a rim of that height adds, by 1,000 triangles and more.
    for (found, expected) in excesses.iter().zip([0.377, 0.114, 0.0]) {
        assert!((found - expected).abs() < 0.015, "{excesses:?}");
    }
}

#[test]
fn source_and_receiver_can_be_exchanged() {
    let ((a, m), (b, n)) =
        (source(), (Point3::new(-60.0, -80.0, 20.0), Vector3::new(0.3, 0.9, -0.4)));
    let [from_a, from_b] = [Dipole::new(&a, &m), Dipole::new(&b, &n)];
    let solids = [cuboid(&Vector3::new(80.0, 60.0, 6.0), 200), cylinder(20.0, 100.0, 200)];
    for mesh in solids.map(Result::unwrap).into_iter().chain([plate_with_two_holes(14.0)]) {
        let shape = shape(&mesh);
        for (depth_mm, mu) in [(4.3, 1.0), (20.0, 1.0), (0.5, 700.0), (f64::INFINITY, 50.0)] {
            let body = body(&shape, depth_mm, mu);
            let there = added(&body, |p| from_a.field(p), &[b])[0].dot(&n);
            let back = added(&body, |p| from_b.field(p), &[a])[0].dot(&m);
            // To the size of the triangles, each of which takes the mean of the field.
            assert!((there / back - 1.0).abs() < 0.05, "{depth_mm} {mu}: {there} {back}");
        }
    }
}

/// A plate of 5 by 3 cubes without two of them.
fn plate_with_two_holes(side_mm: f64) -> SurfaceMesh {
    let is_in = |x: i32, y: i32, z: i32| {
        (0..5).contains(&x) && (0..3).contains(&y) && z == 0 && !(y == 1 && [1, 3].contains(&x))
    };
    let mut part = MeshPart::default();
    let cells = (0..15).map(|k| [k % 5, k / 5, 0]).filter(|[x, y, z]| is_in(*x, *y, *z));
    for cell in cells {
        for (axis, sign) in (0..3).flat_map(|axis| [(axis, 1), (axis, -1)]) {
            let mut beyond = cell;
            beyond[axis] += sign;
            if is_in(beyond[0], beyond[1], beyond[2]) {
                continue;
            }
            let corner = |u: i32, v: i32| {
                let mut at = cell.map(f64::from);
                at[axis] += f64::from((1 + sign) / 2);
                at[(axis + 1) % 3] += f64::from(u);
                at[(axis + 2) % 3] += f64::from(v);
                Point3::from(at.map(|part| side_mm * part)) - Vector3::new(2.5, 1.5, 0.5) * side_mm
            };
            let base = part.positions_mm.len() as u32;
            part.positions_mm.extend([corner(0, 0), corner(1, 0), corner(1, 1), corner(0, 1)]);
            part.normals.extend([Vector3::ith(axis, f64::from(sign)); 4]);
            let faces = match sign {
                1 => [[0, 1, 2], [0, 2, 3]],
                _ => [[0, 2, 1], [0, 3, 2]],
            };
            part.triangles.extend(faces.map(|face: [u32; 3]| face.map(|k| base + k)));
        }
    }
    SurfaceMesh { parts: vec![part], ..SurfaceMesh::default() }
}

#[test]
fn what_is_no_metal_adds_nothing() {
    let solid = cuboid(&Vector3::new(80.0, 60.0, 6.0), 100).unwrap();
    for mesh in [solid, plate_with_two_holes(20.0)] {
        let shape = shape(&mesh);
        let (at, direction) = source();
        let dipole = Dipole::new(&at, &direction);
        let near = [Point3::new(0.0, 0.0, 20.0)];
        let whole = dipole.field(&near[0]).norm();
        for (depth_mm, mu, part) in [(f64::INFINITY, 1.0, 1e-12), (1e5, 1.0, 1e-6)] {
            let found = added(&body(&shape, depth_mm, mu), |p| dipole.field(p), &near)[0].norm();
            assert!(found < part * whole, "{depth_mm} {mu}: {found:e}");
        }
    }
}

#[test]
fn a_hollow_changes_nothing_outside_a_good_conductor() {
    let solid = sphere(RADIUS_MM, 1).unwrap();
    let mut hollow = solid.clone();
    hollow.parts.extend(sphere(0.5 * RADIUS_MM, 1).unwrap().parts);
    let (at, direction) = source();
    let dipole = Dipole::new(&at, &direction);
    let place = [Point3::new(0.0, -80.0, 50.0)];
    let of = |mesh: &SurfaceMesh, depth_mm: f64| {
        added(&body(&shape(mesh), depth_mm, 1.0), |p| dipole.field(p), &place)[0]
    };
    let [one, other] = [&solid, &hollow].map(|mesh| of(mesh, 3.0));
    assert!((one - other).norm() < 1e-3 * one.norm(), "{one} {other}");
    // Where flux goes through, what is left out of the metal has no currents.
    let [one, other] = [&solid, &hollow].map(|mesh| of(mesh, 120.0).norm());
    assert!(other < 0.99 * one, "{one} {other}");
}

#[test]
fn integration_can_be_cancelled() {
    let surface = ClosedSurface::new(&sphere(1.0, 1).unwrap()).unwrap();
    let task = Task::default();
    task.cancel.cancel();
    assert_eq!(BoundaryShape::new(surface, &task).unwrap_err(), Cancelled);
    let shape = shape(&sphere(1.0, 1).unwrap());
    let error = BoundaryBody::new(shape, 1.0, 1.0, &task).unwrap_err();
    assert_eq!(error, BoundaryError::Cancelled(Cancelled));
}
