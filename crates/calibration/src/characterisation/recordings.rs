//! What the frames change by where a recording is left out: a jackknife over paths.
//!
//! A path is recorded in one part of the room, and the field there shifts all its readings alike:
//! seconds of one path do not show that, another path does. Leaving out each of `J` recordings in
//! turn, the covariance is `(J − 1)/J Σ (θⱼ − θ̄)(θⱼ − θ̄)ᵀ` (Tukey 1958; for clusters: Bell &
//! McCaffrey, *Survey Methodology* 28, 2002).

use super::super::hand_eye::{HandEye, HandEyeSettings, PairedReading, hand_eye};
use crate::robust::largest_std_dev;
use crate::still_pose::Spread;
use nalgebra::{Matrix3, Point3, Vector3};
use serde::Serialize;
use std::collections::BTreeSet;
use trackwright_geometry::rotation::log_quaternion;
use trackwright_task::{Cancelled, Task};

/// Fewest recordings: two differ by one number.
const MIN_GROUPS: usize = 3;

/// Of more, neighbours are left out together.
const MAX_GROUPS: usize = 8;

/// Standard errors by what recordings differ by, along the worst direction.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RecordingErrors {
    /// Recordings, or groups of them; one more than the degrees of freedom.
    pub groups: usize,
    /// Of the reference where the readings are.
    #[serde(rename = "tracker_from_reference")]
    pub reference: Spread,
    /// By sensor.
    pub sensors: Vec<Spread>,
}

/// `None` of fewer than three recordings, and where the frames cannot be found without one of them.
pub(super) fn errors(
    readings: &[(usize, PairedReading)],
    all: &HandEye,
    middle_in_reference: &Point3<f64>,
    settings: &HandEyeSettings,
    task: &Task,
) -> Result<Option<RecordingErrors>, Cancelled> {
    let pairs: Vec<usize> =
        readings.iter().map(|(pair, _)| *pair).collect::<BTreeSet<_>>().into_iter().collect();
    if pairs.len() < MIN_GROUPS {
        return Ok(None);
    }
    let groups = pairs.len().min(MAX_GROUPS);
    let group_of = |pair: usize| {
        let place = pairs.partition_point(|p| *p < pair);
        place * groups / pairs.len()
    };
    let sensors = all.body_from_sensor.len();
    // By frame, a change of place and a turn for each group.
    let mut changes = vec![Vec::with_capacity(groups); 1 + sensors];
    for group in 0..groups {
        task.step(group, groups)?;
        let rest: Vec<PairedReading> = readings
            .iter()
            .filter(|(pair, _)| group_of(*pair) != group)
            .map(|(_, reading)| *reading)
            .collect();
        let Ok(found) = hand_eye(&rest, sensors, settings) else {
            return Ok(None);
        };
        let [now, before] = [&found, all].map(|frames| frames.tracker_from_reference);
        changes[0].push([
            now * middle_in_reference - before * middle_in_reference,
            log_quaternion(&(now.rotation * before.rotation.inverse())),
        ]);
        let frames = found.body_from_sensor.iter().zip(&all.body_from_sensor);
        for (changes, (now, before)) in changes[1..].iter_mut().zip(frames) {
            changes.push([
                now.translation.vector - before.translation.vector,
                log_quaternion(&(now.rotation * before.rotation.inverse())),
            ]);
        }
    }
    let spread = |changes: &Vec<[Vector3<f64>; 2]>| Spread {
        position_mm: worst(changes.iter().map(|change| change[0])),
        angle_rad: worst(changes.iter().map(|change| change[1])),
    };
    Ok(Some(RecordingErrors {
        groups,
        reference: spread(&changes[0]),
        sensors: changes[1..].iter().map(spread).collect(),
    }))
}

/// Of the jackknife, along the direction in which it is largest.
fn worst(changes: impl Iterator<Item = Vector3<f64>> + Clone) -> f64 {
    let count = changes.clone().count() as f64;
    let mean = changes.clone().sum::<Vector3<f64>>() / count;
    let scatter: Matrix3<f64> =
        changes.map(|change| (change - mean) * (change - mean).transpose()).sum();
    largest_std_dev(&(scatter * ((count - 1.0) / count)))
}
