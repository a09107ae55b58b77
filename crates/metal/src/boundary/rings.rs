//! Cylinders against coupled rings and cylinders without ends, computed here by themselves.

use super::tests::{moment, shape};
use super::*;
use crate::material::Material;
use crate::shapes::cylinder;
use std::f64::consts::{FRAC_PI_2, PI, TAU};
use trackwright_geometry::mesh::{MeshPart, SurfaceMesh};

/// Those of copper, aluminium, bronze, steel 304 and titanium at 0.5 to 30 kHz.
pub(super) const DEPTHS_MM: [f64; 8] = [0.38, 0.82, 1.5, 2.46, 3.2, 4.27, 6.71, 12.2];

/// Rings nearer to each other than so many of their widths are taken in parts.
const NEAR_WIDTHS: f64 = 4.0;

/// The upper half of a cylinder as coupled rings, with what the lower half induces in them.
pub(super) struct Rings {
    /// Radius, height, and the two widths of each ring, mm.
    each: Vec<[f64; 4]>,
    mutual: Mat<f64>,
}

impl Rings {
    /// Finer towards the surface.
    pub fn of_disc(radius_mm: f64, length_mm: f64, across: usize, along: usize) -> Self {
        let edge = |k: usize, count: usize| (FRAC_PI_2 * k as f64 / count as f64).sin();
        Self::new(
            |k| radius_mm * edge(k, across),
            |k| 0.5 * length_mm * edge(k, along),
            across,
            along,
        )
    }

    /// Finer towards both edges of a ring with a hole.
    fn of_ring([inner_mm, outer_mm, height_mm]: [f64; 3], across: usize, along: usize) -> Self {
        let part = |k: usize| 0.5 - 0.5 * (PI * k as f64 / across as f64).cos();
        let edge = |k: usize| (FRAC_PI_2 * k as f64 / along as f64).sin();
        Self::new(
            |k| inner_mm + (outer_mm - inner_mm) * part(k),
            |k| 0.5 * height_mm * edge(k),
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
            let ([a, z, w, _], [b, y, v, _]) = (each[i], each[j]);
            let between = |apart: f64| match (a - b).hypot(apart) > NEAR_WIDTHS * w.max(v) {
                true => maxwell(a, b, apart),
                false => wide(&each[i], &each[j], apart),
            };
            between(z - y) + between(z + y)
        });
        Self { each, mutual }
    }

    /// The moment at a skin depth, in an even field along the axis that goes as `e^(iωt)`.
    pub fn moment(&self, skin_depth_mm: f64) -> c64 {
        let count = self.each.len();
        let matrix = Mat::from_fn(count, count, |i, j| {
            let [a, _, w, h] = self.each[i];
            let lost = if i == j { PI * skin_depth_mm.powi(2) * a / (w * h) } else { 0.0 };
            c64::new(self.mutual[(i, j)], -lost)
        });
        let area = |i: usize| PI * self.each[i][0].powi(2);
        let flux = Mat::from_fn(count, 1, |i, _| c64::new(-area(i), 0.0));
        let currents = matrix.partial_piv_lu().solve(&flux);
        (0..count).map(|i| currents[(i, 0)] * (2.0 * area(i))).sum()
    }
}

/// Of two rings that are wider than high: the mean over parts of them that are not.
fn wide(one: &[f64; 4], other: &[f64; 4], apart: f64) -> f64 {
    let parts = |ring: &[f64; 4]| {
        let [a, _, w, h] = *ring;
        let count = (w / h).round().clamp(1.0, 16.0);
        (0..count as usize).map(move |k| (a + w * ((k as f64 + 0.5) / count - 0.5), w / count))
    };
    let (mut sum, mut count) = (0.0, 0.0);
    for (a, w) in parts(one) {
        for (b, _) in parts(other) {
            sum += match a == b && apart == 0.0 {
                // The geometric mean distance of a rectangle from itself (Grover, Inductance Calculations, 1946).
                true => a * ((8.0 * a / (0.2235 * (w + one[3]))).ln() - 2.0),
                false => maxwell(a, b, apart),
            };
            count += 1.0;
        }
    }
    sum / count
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
    let disc = Rings::of_disc(100.0, 0.2, 60, 1).moment(1e-6).re;
    assert!((disc / (-8.0 / 3.0 * 1e6) - 1.0).abs() < 0.02, "{disc}");
}

#[test]
fn discs_and_rods_answer_as_rings() {
    // Where a skin depth of a rod has a ring and a half at least.
    let mut wrong: Vec<String> = Vec::new();
    let mut cases = 0;
    for (radius_mm, length_mm, triangles, rings, least_mm) in [
        (100.0, 0.3, 200, Rings::of_disc(100.0, 0.3, 40, 2), 0.0),
        (100.0, 1.0, 200, Rings::of_disc(100.0, 1.0, 40, 3), 0.0),
        (100.0, 3.0, 200, Rings::of_disc(100.0, 3.0, 36, 4), 0.0),
        (100.0, 10.0, 200, Rings::of_disc(100.0, 10.0, 32, 6), 0.0),
        (100.0, 20.0, 200, Rings::of_disc(100.0, 20.0, 28, 8), 0.0),
        (50.0, 5.0, 200, Rings::of_disc(50.0, 5.0, 32, 6), 0.0),
        (10.0, 20.0, 150, Rings::of_rod(10.0, 20.0, 14, 14), 1.5),
        (10.0, 100.0, 200, Rings::of_rod(10.0, 100.0, 10, 40), 1.5),
        (5.0, 50.0, 200, Rings::of_rod(5.0, 50.0, 10, 40), 0.75),
    ] {
        let shape = shape(&cylinder(radius_mm, length_mm, triangles).unwrap());
        let whole = rings.moment(1e-3).re;
        for depth_mm in DEPTHS_MM.into_iter().filter(|depth_mm| *depth_mm >= least_mm) {
            let expected = rings.moment(depth_mm) / whole;
            let off = moment_along_z(&shape, depth_mm) / whole - expected;
            // What lags is not measured, but loses energy: it has the sign of a loss, and the rings' size.
            let is_loss = expected.im * whole < 0.0 && (off + expected).im * whole < 0.0;
            if off.re.abs() > 0.02 || off.im.abs() > 0.03 || !is_loss {
                let case = format!("{radius_mm} by {length_mm}, {depth_mm}");
                wrong.push(format!("{case}: {expected:.4} {off:+.4}"));
            }
            cases += 1;
        }
    }
    assert_eq!((wrong, cases), (Vec::new(), 67));
}

/// Radius and length, triangles, and rings along the length.
type RefinedDisc = (f64, f64, usize, usize);

#[test]
fn refined_discs_answer_as_rings() {
    assert_answer_as_rings(&[(100.0, 1.0, 700, 4), (50.0, 5.0, 400, 8)]);
}

#[test]
#[ignore = "long: a minute of larger discs"]
fn long_more_refined_discs_answer_as_rings() {
    assert_answer_as_rings(&[(100.0, 0.3, 700, 3), (100.0, 3.0, 400, 6), (100.0, 10.0, 400, 8)]);
}

fn assert_answer_as_rings(discs: &[RefinedDisc]) {
    for &(radius_mm, length_mm, triangles, along) in discs {
        let shape = shape(&cylinder(radius_mm, length_mm, triangles).unwrap());
        let rings = Rings::of_disc(radius_mm, length_mm, 50, along);
        let whole = rings.moment(1e-3).re;
        for depth_mm in [0.38, 1.5, 4.27] {
            let off = (moment_along_z(&shape, depth_mm) - rings.moment(depth_mm)) / whole;
            assert!(off.re.abs() < 0.005 && off.im.abs() < 0.005, "{length_mm} {depth_mm}: {off}");
        }
    }
}

/// The moment that a body of no permeability has along the field, in phase and what lags.
pub(super) fn moment_along_z(shape: &Arc<BoundaryShape>, depth_mm: f64) -> c64 {
    let body = BoundaryBody::new(Arc::clone(shape), depth_mm, 1.0, &Task::default()).unwrap();
    let [in_phase, lag] = body.moments_mm3();
    c64::new(in_phase[(2, 2)], lag[(2, 2)])
}

/// `(μ − f)/(μ + f)`, `f = z J₁′/J₁`: what a cylinder without ends adds across the field, −1 where no flux enters.
#[test]
fn rods_across_the_field_answer_as_cylinders() {
    let radius_mm = 10.0;
    let shape = shape(&cylinder(radius_mm, 300.0, 300).unwrap());
    let whole = moment(&shape, 1e-3, 1.0, &Vector3::x());
    // Where more flux enters, the ends count.
    for (mu, most) in [(1.0, 0.02), (3.0, 0.04)] {
        for part in [0.3, 0.7, 1.2, 2.3, 6.0, 12.0] {
            let z = c64::new(part, -part);
            let f = z * bessel(0, z) / bessel(1, z) - 1.0;
            let expected = ((c64::new(mu, 0.0) - f) / (f + mu)).re;
            let found = -moment(&shape, radius_mm / part, mu, &Vector3::x()) / whole;
            let off = found - expected;
            assert!(off.abs() < most, "{mu} {part}: {expected} {off:+}");
        }
    }
}

/// A long rod has inside `μ 2 J₁(z)/(z J₀(z))` of the field within it, and the demagnetisation of a spheroid.
#[test]
fn a_rod_of_steel_416_answers_along_its_axis() {
    let shape = shape(&cylinder(5.0, 100.0, 300).unwrap());
    let volume = PI * 25.0 * 100.0;
    let mu = 700.0;
    let depth_mm = Material::named("steel-416").unwrap().skin_depth_mm(1e4);
    let found = moment(&shape, depth_mm, mu, &Vector3::z()) / volume;
    let z = c64::new(5.0 / depth_mm, -5.0 / depth_mm);
    // J₁/J₀ of a large argument with a negative imaginary part is −i.
    let effective = c64::new(0.0, -2.0 * mu) / z;
    let demagnetisation = 0.0203;
    let expected = ((effective - 1.0) / ((effective - 1.0) * demagnetisation + 1.0)).re;
    // The ends of a cylinder are not those of a spheroid.
    assert!((found / expected - 1.0).abs() < 0.08, "{found} {expected}");
}

/// A ring about z of so many sides, and of parts along its width and its height.
pub(crate) fn ring(
    [inner_mm, outer_mm, height_mm]: [f64; 3],
    sides: u32,
    parts: [u32; 2],
) -> SurfaceMesh {
    let part = |k: u32, of: u32| 0.5 - 0.5 * (PI * f64::from(k) / f64::from(of)).cos();
    let radius = |k: u32| inner_mm + (outer_mm - inner_mm) * part(k, parts[0]);
    let level = |k: u32| height_mm * (part(k, parts[1]) - 0.5);
    // Once around its section.
    let [width, height] = parts;
    let mut section: Vec<[f64; 2]> = (0..width).map(|k| [radius(k), level(0)]).collect();
    section.extend((0..height).map(|k| [radius(width), level(k)]));
    section.extend((0..width).map(|k| [radius(width - k), level(height)]));
    section.extend((0..height).map(|k| [radius(0), level(height - k)]));
    let turn = TAU / f64::from(sides);
    let out = (turn / turn.sin()).sqrt();
    let place = |side: u32, [radius_mm, z_mm]: &[f64; 2]| {
        let (y, x) = (turn * f64::from(side)).sin_cos();
        Point3::new(out * radius_mm * x, out * radius_mm * y, *z_mm)
    };
    let around = section.len() as u32;
    let at = |side: u32, k: u32| side % sides * around + k % around;
    let cells = || (0..sides).flat_map(move |side| (0..around).map(move |k| (side, k)));
    let part = MeshPart {
        positions_mm: (0..sides)
            .flat_map(|side| section.iter().map(move |of| place(side, of)))
            .collect(),
        normals: cells().map(|_| Vector3::z()).collect(),
        triangles: cells()
            .flat_map(|(side, k)| {
                let [a, b] = [at(side, k), at(side + 1, k)];
                let [c, d] = [at(side + 1, k + 1), at(side, k + 1)];
                [[a, b, c], [a, c, d]]
            })
            .collect(),
        ..MeshPart::default()
    };
    SurfaceMesh { parts: vec![part], ..SurfaceMesh::default() }
}

#[test]
fn rings_with_holes_answer_as_coupled_ones() {
    let sizes_mm = [70.0, 100.0, 15.0];
    let shape = shape(&ring(sizes_mm, 20, [3, 2]));
    assert_eq!(shape.spans().len(), 1);
    let rings = Rings::of_ring(sizes_mm, 20, 8);
    let whole = rings.moment(1e-3).re;
    for depth_mm in DEPTHS_MM.into_iter().chain([40.0]) {
        let expected = rings.moment(depth_mm) / whole;
        let off = moment_along_z(&shape, depth_mm) / whole - expected;
        assert!(off.re.abs() < 0.02 && off.im.abs() < 0.02, "{depth_mm}: {expected} {off}");
    }
}
