//! The line and the ends of a long body, such as a needle or a pointer with a handle.

use crate::mesh::SurfaceMesh;
use crate::surface::Surface;
use nalgebra::{Point3, Unit, Vector3};

/// Where the ends are compared, as a part of the length from each.
const NEAR_END: f64 = 0.02;

/// A cut has a centre only where the surface crosses it at so many places.
const LEAST_CROSSINGS: usize = 3;

/// A body along a line, body frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LongBody {
    /// The middle of the thinner end, which is taken for the tip.
    pub tip_mm: Point3<f64>,
    /// From the tip to the other end.
    pub back: Unit<Vector3<f64>>,
    pub length_mm: f64,
}

/// A cut across a long body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cut {
    /// The mean of where the surface crosses it.
    pub center_mm: Point3<f64>,
    /// From there to the nearest crossing, and the mean of all.
    pub least_radius_mm: f64,
    pub mean_radius_mm: f64,
}

impl LongBody {
    /// The line is the axis of revolution where there is one, else parallel to the longest side of the box;
    /// `None` of a mesh that is flat along it.
    pub fn of(mesh: &SurfaceMesh) -> Option<Self> {
        let along = mesh.long_axis();
        let round = Surface::new(mesh).and_then(|surface| surface.revolution_axis(&along));
        let direction = round.map_or_else(|| Unit::new_normalize(along), |axis| axis.direction);
        let points = || mesh.body_parts().flat_map(|part| part.positions_mm.iter());
        let reach = |axis: &Vector3<f64>| {
            points().map(|p| p.coords.dot(axis)).fold(f64::NEG_INFINITY, f64::max)
        };
        let length_mm = reach(&direction) + reach(&-*direction);
        if !(length_mm.is_finite() && length_mm > 0.0) {
            return None;
        }
        let ends = [direction, -direction].map(|back| {
            let start_mm = -reach(&-*back);
            let cut = cut(mesh, &back, start_mm + NEAR_END * length_mm)?;
            let center_mm = round.map_or(cut.center_mm, |axis| axis.point_mm);
            let tip_mm = center_mm + *back * (start_mm - center_mm.coords.dot(&back));
            Some((cut.mean_radius_mm, Self { tip_mm, back, length_mm }))
        });
        let [one, other] = ends;
        let (one, other) = (one?, other?);
        Some(if one.0 <= other.0 { one.1 } else { other.1 })
    }

    /// The same body with its tip at the other end.
    #[must_use]
    pub fn flipped(self) -> Self {
        let tip_mm = self.tip_mm + *self.back * self.length_mm;
        Self { tip_mm, back: -self.back, ..self }
    }

    /// The cut at a distance from the tip; `None` where the surface does not go around it.
    pub fn cut(&self, mesh: &SurfaceMesh, from_tip_mm: f64) -> Option<Cut> {
        cut(mesh, &self.back, self.tip_mm.coords.dot(&self.back) + from_tip_mm)
    }
}

/// Across a direction, where a point's component along it is `at_mm`.
fn cut(mesh: &SurfaceMesh, direction: &Vector3<f64>, at_mm: f64) -> Option<Cut> {
    let mut crossings = Vec::new();
    for part in mesh.body_parts() {
        for triangle in 0..part.triangles.len() {
            let corners = part.corners_mm(triangle);
            for k in 0..3 {
                let ends = [corners[k], corners[(k + 1) % 3]];
                let [from, to] = ends.map(|end| end.coords.dot(direction) - at_mm);
                // Of an edge that two triangles share each counts once.
                if from < 0.0 && to >= 0.0 {
                    crossings.push(ends[0] + (ends[1] - ends[0]) * (from / (from - to)));
                }
            }
        }
    }
    if crossings.len() < LEAST_CROSSINGS {
        return None;
    }
    let count = crossings.len() as f64;
    let center = crossings.iter().map(|p| p.coords).sum::<Vector3<f64>>() / count;
    let radii = || crossings.iter().map(|p| (p.coords - center).norm());
    Some(Cut {
        center_mm: center.into(),
        least_radius_mm: radii().fold(f64::INFINITY, f64::min),
        mean_radius_mm: radii().sum::<f64>() / count,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::MeshPart;
    use crate::pose::{Pose, pose_from_parts};
    use nalgebra::UnitQuaternion;
    use proptest::prelude::*;

    /// Rings of vertices around z, as radius and height, closed by a point at both ends.
    fn turned(profile: &[(f64, f64)], sides: u32, body_from_own: &Pose) -> SurfaceMesh {
        let mut part = MeshPart::default();
        let mut add = |x: f64, y: f64, z: f64| {
            part.positions_mm.push(body_from_own * Point3::new(x, y, z));
        };
        for &(radius, z) in profile {
            for k in 0..sides {
                let (sine, cosine) =
                    (std::f64::consts::TAU * f64::from(k) / f64::from(sides)).sin_cos();
                add(radius * cosine, radius * sine, z);
            }
        }
        add(0.0, 0.0, profile[0].1);
        add(0.0, 0.0, profile[profile.len() - 1].1);
        let rings = profile.len() as u32;
        let (first, last) = (rings * sides, rings * sides + 1);
        for k in 0..sides {
            let next = (k + 1) % sides;
            for ring in 0..rings - 1 {
                let (a, b) = (ring * sides, (ring + 1) * sides);
                part.triangles.push([a + k, a + next, b + k]);
                part.triangles.push([a + next, b + next, b + k]);
            }
            part.triangles.push([first, next, k]);
            part.triangles.push([last, (rings - 1) * sides + k, (rings - 1) * sides + next]);
        }
        part.normals = vec![Vector3::z(); part.positions_mm.len()];
        SurfaceMesh { parts: vec![part], ..SurfaceMesh::default() }
    }

    /// A needle of 1 mm and a hub of 5 mm, 150 mm long, its tip at the origin of its own frame.
    fn needle(body_from_own: &Pose) -> SurfaceMesh {
        let profile = [(0.5, 0.0), (0.5, 120.0), (2.5, 121.0), (2.5, 150.0)];
        turned(&profile, 24, body_from_own)
    }

    proptest! {
        #[test]
        fn a_needles_tip_is_its_thin_end(
            at in prop::array::uniform3(-300.0..300.0_f64),
            turn in 0..6_usize,
        ) {
            use std::f64::consts::{FRAC_PI_2, PI};
            // Meshes lie along an axis of their frame, either way.
            let (axis, angle) = [
                (Vector3::x_axis(), 0.0),
                (Vector3::x_axis(), PI),
                (Vector3::x_axis(), FRAC_PI_2),
                (Vector3::x_axis(), -FRAC_PI_2),
                (Vector3::y_axis(), FRAC_PI_2),
                (Vector3::y_axis(), -FRAC_PI_2),
            ][turn];
            let rotation = UnitQuaternion::from_axis_angle(&axis, angle);
            let body_from_own = pose_from_parts(at.into(), rotation);
            let mesh = needle(&body_from_own);
            let found = LongBody::of(&mesh).unwrap();
            prop_assert!((found.tip_mm - Point3::from(Vector3::from(at))).norm() < 1e-6, "{found:?}");
            prop_assert!((*found.back - rotation * Vector3::z()).norm() < 1e-9);
            prop_assert!((found.length_mm - 150.0).abs() < 1e-9);
            let shaft = found.cut(&mesh, 60.0).unwrap();
            prop_assert!((shaft.mean_radius_mm - 0.5).abs() < 0.01, "{shaft:?}");
            let hub = found.flipped();
            prop_assert!((hub.cut(&mesh, 10.0).unwrap().mean_radius_mm - 2.5).abs() < 0.05);
            prop_assert_eq!(hub.flipped().back, found.back);
        }
    }

    #[test]
    fn a_handle_to_one_side_leaves_the_tip_on_the_shaft() {
        let mut mesh = needle(&Pose::identity());
        let handle = turned(&[(6.0, 122.0), (6.0, 148.0)], 12, &Pose::translation(30.0, 0.0, 0.0));
        mesh.parts.extend(handle.parts);
        let found = LongBody::of(&mesh).unwrap();
        assert!(found.tip_mm.coords.norm() < 0.05, "{found:?}");
        assert_eq!(*found.back, Vector3::z());
    }

    #[test]
    fn what_is_flat_has_no_line() {
        let part = MeshPart { positions_mm: vec![Point3::origin(); 3], ..MeshPart::default() };
        let mesh = SurfaceMesh { parts: vec![part], ..SurfaceMesh::default() };
        assert_eq!(LongBody::of(&mesh), None);
        assert_eq!(LongBody::of(&SurfaceMesh::default()), None);
    }
}
