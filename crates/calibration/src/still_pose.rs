//! One pose from many readings of a tool that stood still, and how far they scatter.
//!
//! Start: the reading that is nearest to all others. Then the geometric median (Weiszfeld 1937) of
//! positions, and of rotations in the tangent space (Hartley, Aftab & Trumpf, *L1 rotation averaging
//! using the Weiszfeld algorithm*, CVPR 2011). What is far from it, measured by the median distance,
//! is left out, and the means of the rest are the pose.

use super::robust::{median, scale_of_lengths};
use nalgebra::{UnitQuaternion, Vector3};
use serde::ser::{Serialize, SerializeStruct, Serializer};
use trackwright_geometry::pose::{Pose, distances, pose_from_parts};
use trackwright_geometry::rotation::{exp_vector, log_quaternion};

/// Standard deviations of a component: of a position along an axis, of a rotation vector.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Spread {
    pub position_mm: f64,
    pub angle_rad: f64,
}

impl Serialize for Spread {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut spread = serializer.serialize_struct("Spread", 2)?;
        spread.serialize_field("position_mm", &self.position_mm)?;
        spread.serialize_field("angle_deg", &self.angle_rad.to_degrees())?;
        spread.end()
    }
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StillPose {
    pub pose: Pose,
    pub used: usize,
    pub outliers: usize,
    /// Jitter of a single reading, of those used.
    pub jitter: Spread,
    /// How far half of all readings are from the pose: what distinguishes a pose from a path.
    pub half_within: Spread,
}

impl StillPose {
    /// Standard error of the mean, for readings that are independent of each other.
    pub fn mean_error(&self) -> Spread {
        let root = (self.used.max(1) as f64).sqrt();
        Spread {
            position_mm: self.jitter.position_mm / root,
            angle_rad: self.jitter.angle_rad / root,
        }
    }
}

/// Standard deviations beyond which a reading is left out: one of 70,000 normal ones.
const OUTLIER: f64 = 5.0;

/// Least scales: the last digits that trackers write.
const RESOLUTION: Spread = Spread { position_mm: 1e-3, angle_rad: 1e-6 };

/// Readings that the start is looked for among; evenly spread.
const STARTS: usize = 32;

/// Far more than is needed, for an answer that only has to identify outliers.
const STEPS: usize = 30;

/// The pose of a still tool; `None` without readings.
pub fn still_pose(readings: &[Pose]) -> Option<StillPose> {
    let start = nearest_to_all(readings)?;
    let centre = geometric_median(readings, start);
    let off: Vec<(f64, f64)> = readings.iter().map(|p| distances(&centre, p)).collect();
    let scale = Spread {
        position_mm: scale_of_lengths(&mut off.iter().map(|d| d.0).collect::<Vec<_>>())
            .max(RESOLUTION.position_mm),
        angle_rad: scale_of_lengths(&mut off.iter().map(|d| d.1).collect::<Vec<_>>())
            .max(RESOLUTION.angle_rad),
    };
    let is_good = |(mm, rad): &(f64, f64)| {
        *mm <= OUTLIER * scale.position_mm && *rad <= OUTLIER * scale.angle_rad
    };
    let kept: Vec<Pose> =
        readings.iter().zip(&off).filter(|(_, off)| is_good(off)).map(|(pose, _)| *pose).collect();
    // The median is on nobody's side: where positions and rotations name different outliers, none
    // may be left.
    let kept = if kept.is_empty() { readings } else { &kept };
    let pose = mean(kept, &centre);
    let (mut mm2, mut rad2) = (0.0, 0.0);
    for reading in kept {
        let (mm, rad) = distances(&pose, reading);
        mm2 += mm * mm;
        rad2 += rad * rad;
    }
    let degrees = (3 * kept.len().saturating_sub(1).max(1)) as f64;
    let middle = |values: Vec<f64>| median(&mut { values }).unwrap_or(0.0);
    Some(StillPose {
        pose,
        used: kept.len(),
        outliers: readings.len() - kept.len(),
        jitter: Spread { position_mm: (mm2 / degrees).sqrt(), angle_rad: (rad2 / degrees).sqrt() },
        half_within: Spread {
            position_mm: middle(off.iter().map(|d| d.0).collect()),
            angle_rad: middle(off.iter().map(|d| d.1).collect()),
        },
    })
}

/// Position and rotation, each of the reading whose distances to the others sum to the least.
fn nearest_to_all(readings: &[Pose]) -> Option<Pose> {
    let step = readings.len().div_ceil(STARTS).max(1);
    let candidates: Vec<&Pose> = readings.iter().step_by(step).collect();
    let least = |distance: fn((f64, f64)) -> f64| {
        let sum = |a: &Pose| -> f64 {
            let others = candidates.iter();
            others.map(|b| distance(distances(a, b))).sum()
        };
        candidates.iter().copied().min_by(|a, b| sum(a).total_cmp(&sum(b)))
    };
    let at = least(|d| d.0)?.translation.vector;
    let rotation = least(|d| d.1)?.rotation;
    Some(pose_from_parts(at, rotation))
}

fn geometric_median(readings: &[Pose], start: Pose) -> Pose {
    let (mut at, mut rotation) = (start.translation.vector, start.rotation);
    for _ in 0..STEPS {
        let step_mm = weiszfeld_step(
            readings.iter().map(|p| p.translation.vector - at),
            RESOLUTION.position_mm,
        );
        let step_rad =
            weiszfeld_step(readings.iter().map(|p| tangent(&rotation, p)), RESOLUTION.angle_rad);
        at += step_mm;
        rotation *= exp_vector(&step_rad);
        if step_mm.norm() <= RESOLUTION.position_mm && step_rad.norm() <= RESOLUTION.angle_rad {
            break;
        }
    }
    pose_from_parts(at, rotation)
}

/// The mean of the ways to all readings, each weighted by the inverse of its length.
fn weiszfeld_step(ways: impl Iterator<Item = Vector3<f64>>, least: f64) -> Vector3<f64> {
    let (mut sum, mut weights) = (Vector3::zeros(), 0.0);
    for way in ways {
        let weight = 1.0 / way.norm().max(least);
        sum += way * weight;
        weights += weight;
    }
    if weights > 0.0 { sum / weights } else { sum }
}

/// Arithmetic mean of positions; mean of rotations on the sphere (Karcher), from near it.
fn mean(readings: &[Pose], near: &Pose) -> Pose {
    let count = readings.len().max(1) as f64;
    let at = readings.iter().map(|p| p.translation.vector).sum::<Vector3<f64>>() / count;
    let mut rotation = near.rotation;
    // Converges with the square of the scatter, which is far below a radian.
    for _ in 0..5 {
        let ways = readings.iter().map(|p| tangent(&rotation, p));
        rotation *= exp_vector(&(ways.sum::<Vector3<f64>>() / count));
    }
    pose_from_parts(at, UnitQuaternion::new_normalize(rotation.into_inner()))
}

fn tangent(from: &UnitQuaternion<f64>, to: &Pose) -> Vector3<f64> {
    log_quaternion(&(from.inverse() * to.rotation))
}

#[cfg(test)]
mod tests {
    use super::*;
    use trackwright_field::random_models::Seeded;

    fn truth() -> Pose {
        pose_from_parts(
            Vector3::new(-80.0, 190.0, -308.0),
            exp_vector(&Vector3::new(2.0, -1.5, 1.0)),
        )
    }

    #[test]
    fn jitter_and_error_of_the_mean_are_what_was_put_in() {
        let mut noise = Seeded::new(3);
        let readings: Vec<_> = (0..400).map(|_| noise.around(&truth(), 0.05, 0.002)).collect();
        let found = still_pose(&readings).unwrap();
        // A standard deviation from 1200 normal numbers is within 1 / √2400 of the truth; four of
        // those. One of 70,000 normal readings is an outlier.
        assert!((found.jitter.position_mm / 0.05 - 1.0).abs() < 0.082, "{found:?}");
        assert!((found.jitter.angle_rad / 0.002 - 1.0).abs() < 0.082, "{found:?}");
        assert!(found.outliers <= 1);
        let (mm, rad) = distances(&found.pose, &truth());
        let error = found.mean_error();
        assert!(mm < 4.0 * error.position_mm && rad < 4.0 * error.angle_rad);
    }

    #[test]
    fn four_of_ten_outliers_do_not_move_the_pose() {
        let mut noise = Seeded::new(4);
        let elsewhere = truth() * Pose::translation(40.0, 5.0, 0.0);
        let turned = pose_from_parts(
            truth().translation.vector,
            truth().rotation * exp_vector(&Vector3::new(0.0, 0.0, 2.8)),
        );
        let readings: Vec<_> = (0..200)
            .map(|i| match i % 10 {
                0..=1 => noise.around(&elsewhere, 0.05, 0.002),
                2..=3 => noise.around(&turned, 0.05, 0.002),
                _ => noise.around(&truth(), 0.05, 0.002),
            })
            .collect();
        let found = still_pose(&readings).unwrap();
        assert_eq!((found.used, found.outliers), (120, 80));
        let (mm, rad) = distances(&found.pose, &truth());
        assert!(mm < 4.0 * 0.05 / 120.0_f64.sqrt() * 3.0_f64.sqrt(), "{mm}");
        assert!(rad < 4.0 * 0.002 / 120.0_f64.sqrt() * 3.0_f64.sqrt(), "{rad}");
    }

    #[test]
    fn equal_readings_are_their_own_pose() {
        assert!(still_pose(&[]).is_none());
        for count in [1, 2, 100] {
            let found = still_pose(&vec![truth(); count]).unwrap();
            let (mm, rad) = distances(&found.pose, &truth());
            assert!(mm < 1e-12 && rad < 1e-14);
            assert_eq!((found.used, found.outliers), (count, 0));
            assert!(found.jitter.position_mm < 1e-12);
        }
    }

    #[test]
    fn another_frame_gives_the_same_pose_in_it() {
        let mut noise = Seeded::new(5);
        let readings: Vec<_> = (0..50).map(|_| noise.around(&truth(), 0.3, 0.01)).collect();
        let other_from_tracker = pose_from_parts(
            Vector3::new(900.0, -3.0, 50.0),
            exp_vector(&Vector3::new(-1.0, 2.0, 0.2)),
        );
        let moved: Vec<_> = readings.iter().map(|p| other_from_tracker * p).collect();
        let [a, b] = [readings, moved].map(|all| still_pose(&all).unwrap());
        assert_eq!(a.used, b.used);
        let (mm, rad) = distances(&(other_from_tracker * a.pose), &b.pose);
        // Weiszfeld stops at the resolution, but the means do not depend on where.
        assert!(mm < 1e-10 && rad < 1e-12, "{mm} {rad}");
    }
}
