//! Faces of a box that are dragged along their normals.

use super::bounds::Bounds;
use super::surface::Ray;
use nalgebra::{Point3, Vector3};

/// Opposite faces stay at least this far apart, or as far as they are.
const LEAST_EDGE_MM: f64 = 0.1;

/// How far a face can be dragged: where the pointer's ray is nearly along the normal, a pixel is a
/// long way.
const FARTHEST_MM: f64 = 2000.0;

/// One of the six faces of a box.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct BoxFace {
    /// 0, 1, 2 for x, y, z.
    pub axis: usize,
    /// Whether it is where the box ends along the axis, not where it begins.
    pub is_max: bool,
}

/// A face that is held.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HeldFace {
    face: BoxFace,
    start: Bounds,
    /// Where on the normal it was taken hold of, from the face.
    grabbed_mm: f64,
}

impl BoxFace {
    pub fn all() -> impl Iterator<Item = Self> {
        (0..3).flat_map(|axis| [false, true].map(|is_max| Self { axis, is_max }))
    }

    /// Where it is along its axis.
    pub fn value_mm(self, bounds: &Bounds) -> f64 {
        match self.is_max {
            true => bounds.max_mm[self.axis],
            false => bounds.min_mm[self.axis],
        }
    }

    pub fn middle_mm(self, bounds: &Bounds) -> Point3<f64> {
        let mut middle = bounds.center_mm();
        middle[self.axis] = self.value_mm(bounds);
        middle
    }

    /// The box with this face elsewhere along its axis, on its side of the opposite one.
    pub fn moved_to(self, bounds: &Bounds, value_mm: f64) -> Bounds {
        let mut moved = *bounds;
        let (low, high) = (bounds.min_mm[self.axis], bounds.max_mm[self.axis]);
        let least_mm = LEAST_EDGE_MM.min(high - low);
        match self.is_max {
            true => moved.max_mm[self.axis] = value_mm.max(low + least_mm),
            false => moved.min_mm[self.axis] = value_mm.min(high - least_mm),
        }
        moved
    }

    /// Takes hold of it with the pointer's ray there, in the frame of the box; `None` where the ray
    /// runs along the normal.
    pub fn take(self, bounds: &Bounds, ray: &Ray) -> Option<HeldFace> {
        let grabbed_mm = self.under_mm(bounds, ray)?;
        Some(HeldFace { face: self, start: *bounds, grabbed_mm })
    }

    /// Where along the axis, from the face's middle, the ray passes nearest to the normal.
    fn under_mm(self, bounds: &Bounds, ray: &Ray) -> Option<f64> {
        ray.nearest_on_line(&self.middle_mm(bounds), &Vector3::ith_axis(self.axis))
    }
}

impl HeldFace {
    pub fn face(&self) -> BoxFace {
        self.face
    }

    /// The box with the pointer's ray there, its face at a whole multiple of `round_to_mm` where that
    /// is given; `None` where the ray runs along the normal.
    pub fn bounds_at(&self, ray: &Ray, round_to_mm: Option<f64>) -> Option<Bounds> {
        let moved_mm = self.face.under_mm(&self.start, ray)? - self.grabbed_mm;
        let value_mm = self.face.value_mm(&self.start) + moved_mm.clamp(-FARTHEST_MM, FARTHEST_MM);
        let value_mm = match round_to_mm {
            Some(unit_mm) => (value_mm / unit_mm).round() * unit_mm,
            None => value_mm,
        };
        Some(self.face.moved_to(&self.start, value_mm))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Unit;

    const BOX: ([f64; 3], [f64; 3]) = ([0.0, 10.0, 20.0], [4.0, 20.0, 60.0]);

    /// Straight at a point, from where every normal is seen.
    fn ray_at(point: Point3<f64>) -> Ray {
        let origin_mm = point + Vector3::new(100.0, -300.0, 200.0);
        Ray { origin_mm, direction: Unit::new_normalize(point - origin_mm) }
    }

    #[test]
    fn a_held_face_follows_the_pointer() {
        let own = Bounds::from(BOX);
        for face in BoxFace::all() {
            let along = Vector3::ith_axis(face.axis).into_inner();
            let out = if face.is_max { 7.25 } else { -7.25 };
            // Taken hold of beside its middle.
            let grabbed = face.middle_mm(&own) + along * 0.5;
            let held = face.take(&own, &ray_at(grabbed)).unwrap();
            let moved = held.bounds_at(&ray_at(grabbed + along * out), None).unwrap();
            let value_mm = face.value_mm(&own) + out;
            assert!((face.value_mm(&moved) - value_mm).abs() < 1e-9, "{face:?} {moved:?}");
            // The other five stay where they are.
            let others = BoxFace::all().filter(|other| *other != face);
            for other in others {
                assert_eq!(other.value_mm(&moved), other.value_mm(&own));
            }
            let rounded = held.bounds_at(&ray_at(grabbed + along * out), Some(1.0)).unwrap();
            assert_eq!(face.value_mm(&rounded), value_mm.round());
        }
    }

    #[test]
    fn opposite_faces_stay_apart() {
        let own = Bounds::from(BOX);
        for face in BoxFace::all() {
            let along = Vector3::ith_axis(face.axis).into_inner();
            let inward = if face.is_max { -90.0 } else { 90.0 };
            let middle = face.middle_mm(&own);
            let held = face.take(&own, &ray_at(middle)).unwrap();
            let moved = held.bounds_at(&ray_at(middle + along * inward), None).unwrap();
            assert!((moved.size_mm()[face.axis] - LEAST_EDGE_MM).abs() < 1e-9, "{moved:?}");
        }
        // One that is thinner already does not grow by itself.
        let thin = Bounds::from(([0.0; 3], [0.01, 1.0, 1.0]));
        let end = BoxFace { axis: 0, is_max: true };
        assert_eq!(end.moved_to(&thin, 0.01), thin);
    }

    #[test]
    fn a_ray_along_the_normal_holds_nothing() {
        let ray = Ray { origin_mm: Point3::new(2.0, 15.0, 500.0), direction: -Vector3::z_axis() };
        let own = Bounds::from(BOX);
        assert!(BoxFace { axis: 2, is_max: true }.take(&own, &ray).is_none());
        assert!(BoxFace { axis: 0, is_max: true }.take(&own, &ray).is_some());
    }
}
