//! Distort, then compensate.

use super::*;
use crate::field::random_models::{Seeded, random_model, room};
use crate::geometry::directions::{DirectionSet, Weighting};

fn undone(model: &DistortionModel, poses: &[Pose], outside: OutsidePolicy) -> Vec<Undistorted> {
    let measured: Vec<_> = poses.iter().map(|p| model.distort(p, outside).0).collect();
    undistort(model, &measured, outside, &Task::default()).unwrap()
}

/// How far a pose is from another, mm and radians.
fn difference(a: &Pose, b: &Pose) -> (f64, f64) {
    let turn = crate::geometry::rotation::rotation_angle_rad(&(a.rotation.inverse() * b.rotation));
    ((a.translation.vector - b.translation.vector).norm(), turn)
}

#[test]
fn distorting_then_compensating_gives_the_pose_back() {
    let sets = DirectionSet::ALL;
    let mut converged = 0;
    for (k, set) in sets.into_iter().enumerate() {
        for weighting in [Weighting::Area, Weighting::Gnomonic] {
            for order in 1..=6 {
                let model =
                    random_model(order, set, weighting, [1.0, 0.005], (10 * k + order) as u64);
                let mut seeded = Seeded::new(order as u64);
                let poses: Vec<_> = (0..60).map(|_| seeded.pose(&room(), 0.0)).collect();
                for (pose, found) in poses
                    .iter()
                    .zip(undone(&model, &poses, OutsidePolicy::Clamp))
                {
                    if found.state == InverseState::Converged {
                        converged += 1;
                        let (mm, rad) = difference(pose, &found.pose.unwrap());
                        assert!(mm < 1e-9 && rad < 1e-12, "{set:?} {order}: {mm:e} {rad:e}");
                    }
                }
            }
        }
    }
    assert_eq!(converged, 6 * 2 * 6 * 60);
}
