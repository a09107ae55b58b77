//! What a ray points at among things that are drawn thin: arrows, markers.

use super::surface::Ray;
use nalgebra::Point3;

/// Shortest part of a segment across the ray that still determines where the two come nearest.
const LEAST_ACROSS_MM2: f64 = 1e-18;

/// Something thin or small that can be pointed at.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Target<T> {
    /// Both the same for a marker.
    pub ends_mm: [Point3<f64>; 2],
    /// Half its width.
    pub radius_mm: f64,
    pub is: T,
}

impl Ray {
    /// How far along the ray a segment comes nearest to it, and how near, mm. Behind the ray's
    /// origin the first is negative.
    pub fn passes(&self, ends_mm: &[Point3<f64>; 2]) -> [f64; 2] {
        let direction = self.direction.into_inner();
        let from = ends_mm[0] - self.origin_mm;
        let along = ends_mm[1] - ends_mm[0];
        let from_across = from - direction * direction.dot(&from);
        let across = along - direction * direction.dot(&along);
        let part = match across.norm_squared() > LEAST_ACROSS_MM2 {
            true => (-from_across.dot(&across) / across.norm_squared()).clamp(0.0, 1.0),
            false => 0.0,
        };
        [direction.dot(&(from + along * part)), (from_across + across * part).norm()]
    }
}

/// The nearest of the targets that a ray meets, and how far along the ray. A target within
/// `reach_rad` of the ray, seen from its origin, counts as met: a pointer takes hold of a line.
pub fn first_pointed_at<T>(
    ray: &Ray,
    reach_rad: f64,
    targets: impl IntoIterator<Item = Target<T>>,
) -> Option<(f64, T)> {
    targets
        .into_iter()
        .filter_map(|target| {
            let [along_mm, beside_mm] = ray.passes(&target.ends_mm);
            let is_met = along_mm > 0.0 && beside_mm <= target.radius_mm.max(reach_rad * along_mm);
            is_met.then_some((along_mm, target.is))
        })
        .min_by(|a, b| a.0.total_cmp(&b.0))
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Vector3;

    const RAY: Ray = Ray {
        origin_mm: Point3::new(0.0, 0.0, 0.0),
        direction: nalgebra::Unit::new_unchecked(Vector3::new(0.0, 0.0, 1.0)),
    };

    #[test]
    fn a_segment_is_passed_where_it_comes_nearest() {
        let passes = |a: [f64; 3], b: [f64; 3]| RAY.passes(&[Point3::from(a), Point3::from(b)]);
        // Across, beyond an end, along the ray, and a point.
        assert_eq!(passes([-2.0, 3.0, 10.0], [2.0, 3.0, 14.0]), [12.0, 3.0]);
        assert_eq!(passes([3.0, 4.0, 7.0], [9.0, 12.0, 7.0]), [7.0, 5.0]);
        assert_eq!(passes([1.0, 0.0, 5.0], [1.0, 0.0, 9.0]), [5.0, 1.0]);
        assert_eq!(passes([0.0, 2.0, -4.0], [0.0, 2.0, -4.0]), [-4.0, 2.0]);
    }

    #[test]
    fn the_nearest_target_in_reach_is_pointed_at() {
        let target = |x: f64, z: f64, radius_mm: f64, is: u8| Target {
            ends_mm: [Point3::new(x, 0.0, z); 2],
            radius_mm,
            is,
        };
        let all = [
            target(0.0, -5.0, 1.0, 0),
            target(3.0, 50.0, 2.0, 1),
            target(2.0, 80.0, 2.5, 2),
            target(0.5, 100.0, 0.1, 3),
        ];
        assert_eq!(first_pointed_at(&RAY, 0.0, all), Some((80.0, 2)));
        // A hundredth of a radian is half a millimetre at 50 mm and a whole one at 100 mm.
        assert_eq!(first_pointed_at(&RAY, 0.01, [all[1], all[3]]), Some((100.0, 3)));
        assert_eq!(first_pointed_at(&RAY, 0.07, all), Some((50.0, 1)));
    }
}
