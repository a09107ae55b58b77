//! Against coupled rings and cylinders without ends, computed here by themselves.

use super::*;
use crate::body::{MetalBody, MetalShape, ResponseModel};
use crate::boundary::BoundaryShape;
use crate::exchange::Answer;
use crate::material::Material;
use crate::shapes::{cuboid, cylinder, sphere};
use crate::sphere::sphere_factor;
use faer::linalg::solvers::Solve;
use std::f64::consts::{FRAC_PI_2, PI, TAU};
use trackwright_field::generator::dipole::Dipole;
use trackwright_geometry::mesh::SurfaceMesh;

const MATERIALS: [&str; 5] = ["copper", "aluminium", "bronze", "steel-304", "titanium"];
const FREQUENCIES_HZ: [f64; 4] = [0.5e3, 3e3, 10e3, 30e3];

/// Where a body's field is that of its moment.
const FAR_MM: f64 = 2e4;

/// In phase, along the field: the moment of a body in an even field of unit strength, in mm³.
fn moment(body: &MetalBody, direction: &Vector3<f64>) -> f64 {
    moment_of(&Answer::new(body.solver(), FAR_MM), direction)
}

fn moment_of(answer: &Answer, direction: &Vector3<f64>) -> f64 {
    let panels = answer.panels();
    let right = Mat::from_fn(panels.len(), 1, |i, _| panels[i].normal().dot(direction));
    let mut field = [Vector3::zeros()];
    let sources = answer.sources(answer.answer(&right));
    answer.add_fields(&sources, &Point3::from(direction * FAR_MM), &mut field);
    field[0].dot(direction) * FULL_ANGLE * FAR_MM.powi(3) / 2.0
}

fn body(mesh: &SurfaceMesh, material: &str, frequency_hz: f64) -> MetalBody {
    let task = Task::default();
    let surface = ClosedSurface::new(mesh).unwrap();
    let shape = MetalShape::Surface(Arc::new(BoundaryShape::new(surface, &task).unwrap()));
    MetalBody::new(shape, Material::named(material).unwrap(), frequency_hz, &task).unwrap()
}

/// The upper half of a cylinder as coupled rings, with what the lower half induces in them.
struct Rings {
    /// Radius, height, and the two widths of each ring, mm.
    each: Vec<[f64; 4]>,
    mutual: Mat<f64>,
}

impl Rings {
    /// Finer towards the surface.
    fn of_disc(radius_mm: f64, length_mm: f64, across: usize, along: usize) -> Self {
        let edge = |k: usize, count: usize| (FRAC_PI_2 * k as f64 / count as f64).sin();
        Self::new(
            |k| radius_mm * edge(k, across),
            |k| 0.5 * length_mm * edge(k, along),
            across,
            along,
        )
    }

    /// All of a size.
    fn of_rod(radius_mm: f64, length_mm: f64, across: usize, along: usize) -> Self {
        let even = |k: usize, count: usize| k as f64 / count as f64;
        Self::new(
            |k| radius_mm * even(k, across),
            |k| 0.5 * length_mm * even(k, along),
            across,
            along,
        )
    }

    fn new(
        edge_mm: impl Fn(usize) -> f64,
        level_mm: impl Fn(usize) -> f64,
        across: usize,
        along: usize,
    ) -> Self {
        let at = |k: usize| (k % across, k / across);
        let each: Vec<[f64; 4]> = (0..across * along)
            .map(|k| {
                let (i, j) = at(k);
                let ([inner, outer], [low, high]) =
                    ([edge_mm(i), edge_mm(i + 1)], [level_mm(j), level_mm(j + 1)]);
                [0.5 * (inner + outer), 0.5 * (low + high), outer - inner, high - low]
            })
            .collect();
        let mutual = Mat::from_fn(each.len(), each.len(), |i, j| {
            let ([a, z, w, h], [b, y, ..]) = (each[i], each[j]);
            let own = match i == j {
                // The geometric mean distance of a rectangle from itself (Grover, Inductance Calculations, 1946).
                true => a * ((8.0 * a / (0.2235 * (w + h))).ln() - 2.0),
                false => maxwell(a, b, z - y),
            };
            own + maxwell(a, b, z + y)
        });
        Self { each, mutual }
    }

    /// The moment in phase at a skin depth, in an even field along the axis.
    fn moment(&self, skin_depth_mm: f64) -> f64 {
        let count = self.each.len();
        let matrix = Mat::from_fn(count, count, |i, j| {
            let [a, _, w, h] = self.each[i];
            let lost = if i == j { PI * skin_depth_mm.powi(2) * a / (w * h) } else { 0.0 };
            c64::new(self.mutual[(i, j)], -lost)
        });
        let area = |i: usize| PI * self.each[i][0].powi(2);
        let flux = Mat::from_fn(count, 1, |i, _| c64::new(-area(i), 0.0));
        let currents = matrix.partial_piv_lu().solve(&flux);
        (0..count).map(|i| 2.0 * currents[(i, 0)].re * area(i)).sum()
    }
}

/// Mutual inductance of two rings over µ₀ (Maxwell, Treatise, art. 701), mm.
fn maxwell(a: f64, b: f64, apart: f64) -> f64 {
    let m = 4.0 * a * b / ((a + b).powi(2) + apart.powi(2));
    // Complete elliptic integrals by the arithmetic and geometric mean.
    let (mut mean, mut root, mut weight, mut sum) = (1.0, (1.0 - m).sqrt(), 1.0, 0.5 * m);
    let mut difference: f64 = 1.0;
    while difference.abs() > 1e-15 {
        difference = 0.5 * (mean - root);
        (mean, root) = (0.5 * (mean + root), (mean * root).sqrt());
        sum += weight * difference * difference;
        weight *= 2.0;
    }
    let first = FRAC_PI_2 / mean;
    let second = first * (1.0 - sum);
    let k = m.sqrt();
    (a * b).sqrt() * ((2.0 / k - k) * first - 2.0 / k * second)
}

/// Cylinder functions by their series, of arguments below 20.
fn bessel(order: i32, z: c64) -> c64 {
    let mut term = (1..=order).fold(c64::new(1.0, 0.0), |term, k| term * z / (2.0 * f64::from(k)));
    let mut sum = term;
    for k in 1..80 {
        term = term * z * z * (-0.25 / f64::from(k * (k + order)));
        sum += term;
    }
    sum
}

#[test]
fn rings_are_those_of_books() {
    // Far apart rings are dipoles; a thin disc that no flux enters has the moment 8/3 a³.
    let dipoles = FRAC_PI_2 * 1e4 / 1e9;
    assert!((maxwell(10.0, 10.0, 1e3) / dipoles - 1.0).abs() < 1e-3);
    let disc = Rings::of_disc(100.0, 0.2, 60, 1).moment(1e-6);
    assert!((disc / (-8.0 / 3.0 * 1e6) - 1.0).abs() < 0.02, "{disc}");
}

#[test]
fn discs_answer_as_rings() {
    assert_alike(&[
        (100.0, 0.3, Rings::of_disc(100.0, 0.3, 40, 2), 0.0),
        (100.0, 1.0, Rings::of_disc(100.0, 1.0, 40, 3), 0.0),
        (100.0, 3.0, Rings::of_disc(100.0, 3.0, 36, 4), 0.0),
        (100.0, 10.0, Rings::of_disc(100.0, 10.0, 32, 6), 0.0),
        (100.0, 20.0, Rings::of_disc(100.0, 20.0, 28, 8), 0.0),
    ]);
}

#[test]
fn rods_along_the_field_answer_as_rings() {
    // Where a skin depth has a ring and a half at least.
    assert_alike(&[
        (10.0, 100.0, Rings::of_rod(10.0, 100.0, 10, 40), 1.5),
        (5.0, 50.0, Rings::of_rod(5.0, 50.0, 10, 40), 0.75),
    ]);
}

/// Every material at every frequency, of skin depths above the last number: within 2 % of the moment of the same
/// body that no flux enters.
fn assert_alike(bodies: &[(f64, f64, Rings, f64)]) {
    let mut wrong = Vec::new();
    for (radius_mm, length_mm, rings, least_mm) in bodies {
        let mesh = cylinder(*radius_mm, *length_mm, 300).unwrap();
        let whole = rings.moment(1e-3);
        let mut made = body(&mesh, "copper", 1e3);
        for material in MATERIALS {
            for frequency_hz in FREQUENCIES_HZ {
                let task = Task::default();
                let material = Material::named(material).unwrap();
                made = made.of(material, frequency_hz, &task).unwrap();
                assert!(matches!(made.model(), ResponseModel::Currents { .. }));
                let skin_depth_mm = material.skin_depth_mm(frequency_hz);
                if skin_depth_mm < *least_mm {
                    continue;
                }
                let expected = rings.moment(skin_depth_mm) / whole;
                let off = moment(&made, &Vector3::z()) / whole - expected;
                if off.abs() > 0.02 {
                    wrong.push(format!(
                        "{radius_mm} by {length_mm}, {skin_depth_mm}: {expected:.4} {off:+.4}"
                    ));
                }
            }
        }
    }
    assert_eq!(wrong, [""; 0]);
}

#[test]
fn rods_across_the_field_answer_as_cylinders() {
    for radius_mm in [5.0, 10.0] {
        let mesh = cylinder(radius_mm, 30.0 * radius_mm, 400).unwrap();
        let mut made = body(&mesh, "copper", 1e3);
        let task = Task::default();
        let mut of = |material: Material, frequency_hz: f64| {
            made = made.of(material, frequency_hz, &task).unwrap();
            moment(&made, &Vector3::x())
        };
        let whole = of(Material::named("copper").unwrap(), 1e7);
        for material in ["aluminium", "bronze", "steel-304", "titanium"] {
            for frequency_hz in FREQUENCIES_HZ {
                let material = Material::named(material).unwrap();
                let part = radius_mm / material.skin_depth_mm(frequency_hz);
                if part > 12.0 {
                    continue;
                }
                let z = c64::new(part, -part);
                let expected = (-bessel(2, z) / bessel(0, z)).re;
                let off = of(material, frequency_hz) / whole - expected;
                assert!(off.abs() < 0.02, "{radius_mm} {part}: {expected} {off:+}");
            }
        }
    }
}

#[test]
fn a_sphere_answers_an_even_field_as_its_series() {
    let surface = ClosedSurface::new(&sphere(30.0, 3).unwrap()).unwrap();
    let shape = Arc::new(CurrentShape::new(&surface, &Task::default()).unwrap().unwrap());
    for skin_depth_mm in [3.0, 6.0, 15.0, 30.0, 60.0] {
        let body = CurrentBody::new(Arc::clone(&shape), skin_depth_mm, &Task::default()).unwrap();
        let conductivity = 2.0 / (TAU * 1e4 * 2e-7 * TAU * (skin_depth_mm * 1e-3_f64).powi(2));
        let material = Material::new(conductivity, 1.0).unwrap();
        let expected = sphere_factor(30.0, &material, 1e4).unwrap().re;
        let samples = body.samples().into();
        let answer = Answer::Currents { body: Arc::new(body), samples };
        let moment = moment_of(&answer, &Vector3::new(0.6, 0.0, 0.8));
        let off = moment / (FULL_ANGLE * 30.0_f64.powi(3)) - expected;
        // Layers have upright sides.
        assert!(off.abs() < 0.02, "{skin_depth_mm}: {expected} {off}");
    }
}

#[test]
fn currents_are_reciprocal() {
    // What a field from one place induces at another is the same the other way round.
    let surface =
        ClosedSurface::new(&cuboid(&Vector3::new(120.0, 80.0, 6.0), 200).unwrap()).unwrap();
    let shape = Arc::new(CurrentShape::new(&surface, &Task::default()).unwrap().unwrap());
    let body = CurrentBody::new(shape, 4.0, &Task::default()).unwrap();
    let samples = body.samples();
    let [one, other] = [
        (Point3::new(40.0, 30.0, 90.0), Vector3::new(0.0, 1.0, 1.0)),
        (Point3::new(-70.0, 20.0, 60.0), Vector3::new(1.0, 0.0, 2.0)),
    ];
    let read = |from: &(Point3<f64>, Vector3<f64>), at: &(Point3<f64>, Vector3<f64>)| {
        let dipole = Dipole::new(&from.0, &from.1);
        let right = Mat::from_fn(samples.len(), 1, |i, _| {
            let points = samples[i].rule_mm(1.0);
            let all = points.iter().map(|p| dipole.field(p).dot(samples[i].normal()));
            all.sum::<f64>() / points.len() as f64
        });
        let mut field = [Vector3::zeros()];
        body.add_fields(&body.currents(&body.answer(&right)), &at.0, &mut field);
        field[0].dot(&at.1)
    };
    let (there, back) = (read(&one, &other), read(&other, &one));
    // To the size of the triangles, each of which takes the mean of the field.
    assert!((there / back - 1.0).abs() < 0.02, "{there} {back}");
}

#[test]
fn hollow_and_bent_bodies_have_none() {
    let none = |mesh: &SurfaceMesh| {
        let surface = ClosedSurface::new(mesh).unwrap();
        CurrentShape::new(&surface, &Task::default()).unwrap().is_none()
    };
    let mut two = cuboid(&Vector3::new(100.0, 100.0, 2.0), 100).unwrap();
    let other = cuboid(&Vector3::new(100.0, 100.0, 2.0), 100).unwrap();
    two.parts.extend(other.parts.into_iter().map(|mut part| {
        part.positions_mm.iter_mut().for_each(|p| p[2] += 50.0);
        part
    }));
    assert!(none(&two));
    assert!(!none(&cuboid(&Vector3::new(100.0, 100.0, 2.0), 100).unwrap()));
}
