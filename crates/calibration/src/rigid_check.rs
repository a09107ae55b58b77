//! Whether sensors on one rigid body keep their distances: the one check of a room that needs no
//! reference at all.

use trackwright_geometry::pose::{Pose, distances};

/// Mean, population standard deviation, least and largest.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Range {
    pub mean: f64,
    pub std: f64,
    pub min: f64,
    pub max: f64,
}

/// How two sensors of one body lay to each other, as the tracker read it. On a rigid body in a field
/// that is not distorted nothing of it changes but by jitter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RigidCheck {
    /// Moments in which both were read.
    pub moments: usize,
    pub distance_mm: Range,
    pub angle_rad: Range,
}

/// From what the tracker read of both at the same moments; `None` without any.
///
/// ```
/// use trackwright_calibration::rigid_check::rigid_check;
/// use trackwright_geometry::pose::Pose;
///
/// let at = |x: f64| (Pose::identity(), Pose::translation(x, 0.0, 0.0));
/// let found = rigid_check(&[at(20.0), at(20.2)]).unwrap();
/// assert!((found.distance_mm.mean - 20.1).abs() < 1e-12);
/// assert!((found.distance_mm.std - 0.1).abs() < 1e-12);
/// assert!(rigid_check(&[]).is_none());
/// ```
pub fn rigid_check(moments: &[(Pose, Pose)]) -> Option<RigidCheck> {
    let (mm, rad): (Vec<_>, Vec<_>) = moments.iter().map(|(a, b)| distances(a, b)).unzip();
    Some(RigidCheck { moments: moments.len(), distance_mm: range(&mm)?, angle_rad: range(&rad)? })
}

fn range(values: &[f64]) -> Option<Range> {
    if values.is_empty() {
        return None;
    }
    let count = values.len() as f64;
    let mean = values.iter().sum::<f64>() / count;
    let squares: f64 = values.iter().map(|v| (v - mean).powi(2)).sum();
    Some(Range {
        mean,
        std: (squares / count).sqrt(),
        min: values.iter().copied().fold(f64::INFINITY, f64::min),
        max: values.iter().copied().fold(f64::NEG_INFINITY, f64::max),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use trackwright_field::random_models::Seeded;

    #[test]
    fn a_rigid_body_keeps_its_distances_wherever_it_is() {
        let mut noise = Seeded::new(1);
        let between = noise.pose_within(20.0);
        let moments: Vec<_> =
            (0..50).map(|_| noise.pose_within(400.0)).map(|a| (a, a * between)).collect();
        let found = rigid_check(&moments).unwrap();
        let distance_mm = between.translation.vector.norm();
        assert!((found.distance_mm.mean - distance_mm).abs() < 1e-11);
        assert!(found.distance_mm.max - found.distance_mm.min < 1e-11);
        assert!(found.angle_rad.std < 1e-12);
        assert_eq!(found.moments, 50);
        assert!(rigid_check(&[]).is_none());
    }
}
