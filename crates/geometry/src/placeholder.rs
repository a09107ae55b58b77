//! A shape for bodies whose mesh is missing: a rod from the tip along the sensors, with a spoke to
//! each one beside it.

use super::mesh::{MeshPart, SurfaceMesh};
use super::rotation::perpendicular;
use nalgebra::{Point3, Unit, Vector3};
use std::f64::consts::{FRAC_PI_2, TAU};

/// How its parts are named.
const NAME: &str = "stand-in";

/// Radius of the rod relative to its length, and its limits: thin enough to be taken for no
/// instrument, and thick enough to be taken hold of.
const SLENDERNESS: f64 = 0.015;
const RADIUS_LIMITS_MM: [f64; 2] = [0.8, 4.0];

/// Radius of a spoke relative to the rod's.
const SPOKE: f64 = 0.5;

/// Points nearer than this are one.
const MIN_LENGTH_MM: f64 = 1e-6;

const SIDES: u32 = 24;

/// Rings of each rounded end, from the cylinder to before the pole.
const END_RINGS: u32 = 6;

/// The placeholder for a body, body frame, millimetres; closed, with normals outward.
///
/// The rod runs from the tip through the sensors' centre, as far as sensors lie along that way on
/// either side of the tip. Where all are in one place it is a ball.
pub fn placeholder(tip_mm: &Point3<f64>, sensors_mm: &[Point3<f64>]) -> SurfaceMesh {
    let sum: Vector3<f64> = sensors_mm.iter().map(|sensor| sensor - tip_mm).sum();
    let farthest = sensors_mm
        .iter()
        .map(|sensor| sensor - tip_mm)
        .max_by(|a, b| a.norm().total_cmp(&b.norm()));
    // Sensors all around the tip have their centre there: the farthest one leads the way then.
    let axis = Unit::try_new(sum / sensors_mm.len().max(1) as f64, MIN_LENGTH_MM)
        .or_else(|| Unit::try_new(farthest?, MIN_LENGTH_MM))
        .unwrap_or_else(Vector3::z_axis);
    let along = |sensor: &Point3<f64>| (sensor - tip_mm).dot(&axis);
    let (low, high) = sensors_mm
        .iter()
        .map(along)
        .fold((0.0_f64, 0.0_f64), |(low, high), at| (low.min(at), high.max(at)));
    let at = |distance: f64| tip_mm + axis.into_inner() * distance;
    let [least, most] = RADIUS_LIMITS_MM;
    let radius_mm = (SLENDERNESS * (high - low)).clamp(least, most);
    let mut part = MeshPart { name: NAME.to_owned(), ..MeshPart::default() };
    push_capsule(&mut part, at(low), at(high), radius_mm);
    for sensor in sensors_mm {
        let foot = at(along(sensor));
        if (sensor - foot).norm() > radius_mm {
            push_capsule(&mut part, foot, *sensor, SPOKE * radius_mm);
        }
    }
    SurfaceMesh { parts: vec![part], ..SurfaceMesh::default() }
}

/// Adds a cylinder with half balls at its ends.
fn push_capsule(part: &mut MeshPart, from_mm: Point3<f64>, to_mm: Point3<f64>, radius_mm: f64) {
    let axis = Unit::try_new(to_mm - from_mm, MIN_LENGTH_MM).unwrap_or_else(Vector3::z_axis);
    let across = perpendicular(&axis).into_inner();
    let third = axis.cross(&across);
    let base = part.positions_mm.len() as u32;
    let mut push = |center: Point3<f64>, normal: Vector3<f64>| {
        part.positions_mm.push(center + normal * radius_mm);
        part.normals.push(normal);
    };
    push(from_mm, -axis.into_inner());
    // Rings from one pole to the other; the two in the middle bound the cylinder.
    let rings = 2 * END_RINGS;
    for ring in 0..rings {
        let (center, step) = if ring < END_RINGS {
            (from_mm, f64::from(ring + 1) - f64::from(END_RINGS))
        } else {
            (to_mm, f64::from(ring) - f64::from(END_RINGS))
        };
        let (height, width) = (step / f64::from(END_RINGS) * FRAC_PI_2).sin_cos();
        for side in 0..SIDES {
            let (sine, cosine) = (TAU * f64::from(side) / f64::from(SIDES)).sin_cos();
            let around = across * cosine + third * sine;
            push(center, around * width + axis.into_inner() * height);
        }
    }
    push(to_mm, axis.into_inner());
    let at = |ring: u32, side: u32| base + 1 + ring * SIDES + side % SIDES;
    let last = base + 1 + rings * SIDES;
    for side in 0..SIDES {
        part.triangles.push([base, at(0, side + 1), at(0, side)]);
        part.triangles.push([last, at(rings - 1, side), at(rings - 1, side + 1)]);
        for ring in 1..rings {
            let [a, b] = [at(ring - 1, side), at(ring - 1, side + 1)];
            let [c, d] = [at(ring, side + 1), at(ring, side)];
            part.triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::surface::Surface;
    use std::f64::consts::PI;

    fn volume_mm3(mesh: &SurfaceMesh) -> f64 {
        let part = &mesh.parts[0];
        (0..part.triangles.len())
            .map(|t| {
                let [a, b, c] = part.corners_mm(t).map(|p| p.coords);
                a.dot(&b.cross(&c)) / 6.0
            })
            .sum()
    }

    #[test]
    fn a_pointer_becomes_a_closed_rod() {
        let sensors = [Point3::new(0.0, 0.0, 60.0), Point3::new(0.0, 0.0, 100.0)];
        let mesh = placeholder(&Point3::origin(), &sensors);
        let bounds = mesh.body_bounds().unwrap();
        assert_eq!((bounds.min_mm.z, bounds.max_mm.z), (-1.5, 101.5));
        // A polygon of 24 sides has 0.989 of the circle's area; rings of 15° take as much again
        // off the ends.
        let exact = PI * 1.5_f64.powi(2) * (100.0 + 4.0 / 3.0 * 1.5);
        let ratio = volume_mm3(&mesh) / exact;
        assert!((0.985..0.99).contains(&ratio), "{ratio}");
        let part = &mesh.parts[0];
        for triangle in &part.triangles {
            let [a, b, c] = triangle.map(|i| part.positions_mm[i as usize]);
            let face = (b - a).cross(&(c - a)).normalize();
            for &i in triangle {
                assert!(part.normals[i as usize].dot(&face) > 0.9, "{triangle:?}");
            }
        }
    }

    #[test]
    fn every_sensor_is_within_reach_of_the_surface() {
        let sensors = [[20.0, 0.0, 0.0], [-20.0, 0.0, 0.0], [0.0, 30.0, 5.0], [0.0, -30.0, -5.0]];
        let sensors = sensors.map(Point3::from);
        let tip = Point3::new(3.0, 0.0, 0.0);
        for tip in [tip, Point3::origin()] {
            let surface = Surface::new(&placeholder(&tip, &sensors)).unwrap();
            for point in sensors.iter().chain([&tip]) {
                let nearest = surface.closest(point).position_mm;
                assert!((nearest - point).norm() <= RADIUS_LIMITS_MM[1], "{point}");
            }
        }
    }

    #[test]
    fn sensors_in_one_place_make_a_ball() {
        for sensors in [&[][..], &[Point3::origin(); 3]] {
            let bounds = placeholder(&Point3::origin(), sensors).body_bounds().unwrap();
            assert!((bounds.size_mm() - Vector3::repeat(1.6)).norm() < 1e-9, "{bounds:?}");
        }
    }
}
