//! What a tracker reports of a sensor on the plate, in a room that is simulated.

use super::plate::{Plate, PlateError, PlateReading, Site};
use super::rods::{RodError, RodReading};
use nalgebra::UnitQuaternion;
use trackwright_field::environment::Jitter;
use trackwright_field::random_models::Seeded;
use trackwright_field::{Environment, OutsidePolicy};
use trackwright_geometry::pose::{Pose, pose_from_parts};

/// Readings that the paper averages at each hole.
pub const PAPER_SAMPLES: usize = 150;

/// Most readings at each site.
pub const MAX_SAMPLES: usize = 10_000;

/// How readings are drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SamplingSettings {
    /// Readings at each site; one where there is no jitter, as all would be equal.
    pub samples: usize,
    pub seed: u64,
}

impl Default for SamplingSettings {
    fn default() -> Self {
        Self { samples: PAPER_SAMPLES, seed: 1 }
    }
}

/// Why there are no readings.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ReadingsError {
    #[error(transparent)]
    Plate(#[from] PlateError),
    #[error(transparent)]
    Rods(#[from] RodError),
    #[error("{0} samples at each site, expected 1 to {MAX_SAMPLES}")]
    Samples(usize),
}

/// Readings of the plate in a room, and beside rods where there are any.
///
/// A rod's error is added to the room's own at the same site: to first order, as if the room's metal and
/// the rod did not act on each other, and as if the rod's error at the true pose were that at the
/// distorted one.
///
/// # Errors
/// A plate that is not inside the room; a number of samples that cannot be.
pub fn simulate_readings(
    environment: &Environment,
    jitter: Option<&Jitter>,
    plate: &Plate,
    rods: &[RodReading],
    settings: &SamplingSettings,
) -> Result<Vec<PlateReading>, ReadingsError> {
    plate.check_inside(environment)?;
    if !(1..=MAX_SAMPLES).contains(&settings.samples) {
        return Err(ReadingsError::Samples(settings.samples));
    }
    let mut noise = Seeded::new(settings.seed);
    let samples = if jitter.is_some() { settings.samples } else { 1 };
    let mut readings = Vec::new();
    let mut add = |site: &Site, true_pose: &Pose, reported: &Pose| {
        let local = jitter.map(|jitter| jitter.at(&true_pose.translation.vector.into()));
        for _ in 0..samples {
            let tracker_from_sensor = match &local {
                Some(local) => noise.around(reported, local.position_mm, local.angle_rad),
                None => *reported,
            };
            readings.push(PlateReading { site: site.clone(), tracker_from_sensor });
        }
    };
    let distorted = |pose: &Pose| environment.model.distort(pose, OutsidePolicy::Clamp).0;
    for site in plate.sites() {
        let true_pose = plate.tracker_from_sensor(&site);
        add(&site, &true_pose, &distorted(&true_pose));
    }
    // A plate without a disc has no reading that rods are compared with.
    let without_disc = rods.first().filter(|_| plate.steps == 0);
    if let Some(rod) = without_disc {
        let site = Site::plain(rod.site.level, rod.site.at);
        let true_pose = plate.tracker_from_sensor(&site);
        add(&site, &true_pose, &distorted(&true_pose));
    }
    for rod in rods {
        let true_pose = plate.tracker_from_sensor(&rod.site);
        let in_room = distorted(&true_pose);
        let reported = pose_from_parts(
            in_room.translation.vector + rod.position_error_mm,
            UnitQuaternion::new_normalize((rod.rotation_error * in_room.rotation).into_inner()),
        );
        add(&rod.site, &true_pose, &reported);
    }
    Ok(readings)
}
