//! How far a tool was turned at all.

use trackwright_geometry::pose::Pose;
use trackwright_geometry::rotation::rotation_angle_rad;

/// Of more poses than this a choice is compared: a recording of minutes has tens of thousands.
const ALL_PAIRS: usize = 2_000;

/// The largest angle between any two poses. Of very many, it begins with the largest between evenly
/// chosen ones, and goes to the one farthest from either end.
pub(super) fn orientation_range_rad(poses: &[Pose]) -> f64 {
    let angle = |a: &Pose, b: &Pose| rotation_angle_rad(&a.rotation.rotation_to(&b.rotation));
    let farther =
        |best: (f64, usize), next: (f64, usize)| if next.0 > best.0 { next } else { best };
    let chosen: Vec<usize> =
        (0..poses.len()).step_by(poses.len().div_ceil(ALL_PAIRS).max(1)).collect();
    let mut range = (0.0, 0);
    for (k, &a) in chosen.iter().enumerate() {
        let others = chosen[k + 1..].iter();
        range = others.fold(range, |best, &b| farther(best, (angle(&poses[a], &poses[b]), b)));
    }
    if chosen.len() < poses.len() {
        for _ in 0..2 {
            let end = &poses[range.1];
            let all = poses.iter().enumerate();
            range = all.fold(range, |best, (b, pose)| farther(best, (angle(end, pose), b)));
        }
    }
    range.0
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Vector3;
    use trackwright_geometry::pose::pose_from_parts;
    use trackwright_geometry::rotation::exp_vector;

    fn turned(turn_rad: Vector3<f64>) -> Pose {
        pose_from_parts(Vector3::zeros(), exp_vector(&turn_rad))
    }

    #[test]
    fn the_largest_angle_of_many_poses_is_found() {
        let around = |i: usize| {
            let (s, c) = (i as f64 * 2.4).sin_cos();
            turned(Vector3::new(c, 0.3, s).normalize() * 0.2)
        };
        let mut poses: Vec<Pose> = (0..3 * ALL_PAIRS).map(around).collect();
        // Between those that are chosen.
        poses[4] = turned(Vector3::x() * 0.5);
        poses[ALL_PAIRS + 1] = turned(Vector3::x() * -0.5);
        let range_rad = orientation_range_rad(&poses);
        assert!((range_rad - 1.0).abs() < 1e-12, "{range_rad}");
    }
}
