//! A room from paired recordings of an EM tracker and a reference tracker (the paper's section 2.1):
//! what each sensor read, beside what it should have read.
//!
//! Recordings of still poses become one robust pose each (`calibration/still_pose.rs`), paths are
//! laid over each other in time and interpolated (`path.rs`); then `calibration/hand_eye` finds how
//! the trackers and sensors lie, and every reading gets its ideal pose.

mod error;
mod path;
mod prepare;
mod recordings;
mod section;
mod settings;
#[cfg(test)]
mod tests;

pub use error::{CharacterisationError, PairProblem};
pub use path::PathReport;
pub use prepare::StillReport;
pub use recordings::RecordingErrors;
pub use settings::{CharacterisationSettings, HeldOut, PairKind, RecordedPair};

use super::hand_eye::{HandEye, HandEyeError, PairedReading, hand_eye};
use super::rigid_check::{RigidCheck, rigid_check};
use super::still_pose::Spread;
use nalgebra::{Point3, Vector3};
use prepare::Prepared;
use std::collections::BTreeMap;
use trackwright_field::samples::Measurement;
use trackwright_geometry::pose::Pose;
use trackwright_simulation::recording::Unusable;
use trackwright_task::Task;

/// One reading that counts, with where it should have been.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CharacterisedReading {
    /// Number of the pair of recordings.
    pub pair: usize,
    /// Rows that belong together: a still pose, or a second of a path.
    pub pose: usize,
    pub sensor: usize,
    pub measurement: Measurement,
    /// How far off it is.
    pub error: Spread,
}

/// What became of a pair.
#[derive(Clone, Debug, PartialEq)]
pub struct PairReport {
    pub outcome: Result<PairOutcome, PairProblem>,
    /// Samples of all tools that the trackers do not stand by, by reason.
    pub unusable: BTreeMap<Unusable, usize>,
    pub readings: usize,
    /// Readings that were beyond [`CharacterisationSettings::max_error`].
    pub too_far: usize,
}

#[derive(Clone, Debug, PartialEq)]
pub enum PairOutcome {
    Still(StillReport),
    Path(PathReport),
}

/// A characterised room.
#[derive(Clone, Debug, PartialEq)]
pub struct Characterisation {
    /// Names as the recordings have them.
    pub sensors: Vec<String>,
    pub hand_eye: HandEye,
    pub readings: Vec<CharacterisedReading>,
    /// Readings of the pairs that the frames were found without, judged by them.
    pub held_out: Vec<CharacterisedReading>,
    /// One a pair.
    pub pairs: Vec<PairReport>,
    pub distances: Vec<SensorDistance>,
    /// What recordings of paths differ by; `None` where there are fewer than three, or still poses.
    pub recordings: Option<RecordingErrors>,
}

impl Characterisation {
    /// Standard errors of where the reference tracker is, along the worst direction, taken in the
    /// middle of all readings: the larger of what seconds or poses, and what recordings differ by.
    pub fn reference_error(&self) -> Spread {
        let middle = middle(self.readings.iter().map(|r| &r.measurement.tracker_from_measured));
        let at = self.hand_eye.tracker_from_reference.inverse() * middle;
        let of_poses = self.hand_eye.reference_error(&at.coords);
        larger(of_poses, self.recordings.as_ref().map(|r| r.reference))
    }

    /// The same of a sensor's place on the body.
    pub fn sensor_error(&self, sensor: usize) -> Spread {
        let of_recordings = self.recordings.as_ref().map(|r| r.sensors[sensor]);
        larger(self.hand_eye.sensor_error(sensor), of_recordings)
    }
}

fn larger(a: Spread, b: Option<Spread>) -> Spread {
    let b = b.unwrap_or_default();
    Spread {
        position_mm: a.position_mm.max(b.position_mm),
        angle_rad: a.angle_rad.max(b.angle_rad),
    }
}

fn middle<'a>(poses: impl Iterator<Item = &'a Pose>) -> Point3<f64> {
    let (mut sum, mut count) = (Vector3::zeros(), 0);
    for pose in poses {
        sum += pose.translation.vector;
        count += 1;
    }
    Point3::from(sum / f64::from(count.max(1)))
}

/// The rigid check of two sensors.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SensorDistance {
    pub sensors: [usize; 2],
    pub check: RigidCheck,
}

/// Rounds of leaving out what is too far, and of refining offsets by the frames found.
const ROUNDS: usize = 6;

/// Characterises a room.
pub fn characterise(
    pairs: &[RecordedPair],
    settings: &CharacterisationSettings,
    task: &Task,
) -> Result<Characterisation, CharacterisationError> {
    let sensors = prepare::sensor_names(pairs, &settings.sensors)?;
    let mut next_pose = 0;
    let mut prepared = Vec::with_capacity(pairs.len());
    for (index, pair) in pairs.iter().enumerate() {
        task.step(index, pairs.len() + ROUNDS)?;
        prepared.push(prepare::prepare(index, pair, &sensors, settings, &mut next_pose)?);
    }
    let usable: Vec<&Result<Prepared, PairProblem>> = prepared.iter().map(|p| &p.content).collect();
    if let (false, Some(Err(first))) = (usable.iter().any(|p| p.is_ok()), usable.first()) {
        return Err(CharacterisationError::NoPairs { pairs: pairs.len(), first: first.clone() });
    }
    let is_held_out = |pair: usize| settings.held_out.is_some_and(|held| held.has(pair));
    let mut found: Option<(HandEye, Vec<(usize, PairedReading)>)> = None;
    let mut kept: Vec<bool> = Vec::new();
    for round in 0..ROUNDS {
        task.step(pairs.len() + round, pairs.len() + ROUNDS)?;
        let all = all_readings(&prepared);
        let near = |solved: &HandEye| -> Vec<bool> {
            let near = all.iter().map(|(_, reading)| is_near(solved, reading, &settings.max_error));
            near.collect()
        };
        kept = match &found {
            Some((before, _)) => near(before),
            None => vec![true; all.len()],
        };
        let used: Vec<PairedReading> = all
            .iter()
            .zip(&kept)
            .filter(|((pair, _), kept)| **kept && !is_held_out(*pair))
            .map(|((_, reading), _)| *reading)
            .collect();
        let solved = hand_eye(&used, sensors.len(), &settings.hand_eye)?;
        let now = near(&solved);
        let mut has_moved = false;
        for content in prepared.iter_mut().map(|p| &mut p.content) {
            // The last frames are those of the last offsets.
            if let (true, Ok(Prepared::Path(path))) = (round + 1 < ROUNDS, content) {
                has_moved |= path.refine(&solved, settings);
            }
        }
        for (sensor, name) in sensors.iter().enumerate() {
            let has_some = all
                .iter()
                .zip(&now)
                .any(|((pair, r), near)| *near && r.sensor == sensor && !is_held_out(*pair));
            if !has_some {
                return Err(CharacterisationError::AllTooFar {
                    name: name.clone(),
                    max_mm: settings.max_error.position_mm,
                    max_deg: settings.max_error.angle_rad.to_degrees(),
                });
            }
        }
        let is_settled = now == kept && !has_moved;
        kept = now;
        found = Some((solved, all));
        if is_settled {
            break;
        }
    }
    let Some((hand_eye, all)) = found else {
        return Err(HandEyeError::NoAnswer.into());
    };
    let is_path = |pair: usize| matches!(prepared[pair].content, Ok(Prepared::Path(_)));
    let used: Vec<(usize, PairedReading)> = all
        .iter()
        .zip(&kept)
        .filter(|((pair, _), kept)| **kept && !is_held_out(*pair))
        .map(|(reading, _)| *reading)
        .collect();
    let recordings = match used.iter().all(|(pair, _)| is_path(*pair)) {
        true => {
            let read = used.iter().map(|(_, reading)| &reading.tracker_from_sensor);
            let middle = hand_eye.tracker_from_reference.inverse() * middle(read);
            recordings::errors(&used, &hand_eye, &middle, &settings.hand_eye, task)?
        }
        false => None,
    };
    let (held_out, readings) = characterised(&hand_eye, &all, &kept)
        .into_iter()
        .partition(|reading| is_held_out(reading.pair));
    Ok(Characterisation {
        readings,
        held_out,
        pairs: reports(prepared, &hand_eye, &all, &kept, settings),
        distances: distances(pairs, &sensors, settings),
        recordings,
        sensors,
        hand_eye,
    })
}

fn all_readings(prepared: &[prepare::PreparedPair]) -> Vec<(usize, PairedReading)> {
    let mut all = Vec::new();
    for (pair, prepared) in prepared.iter().enumerate() {
        match &prepared.content {
            Ok(Prepared::Still { readings, .. }) => all.extend(readings.iter().map(|r| (pair, *r))),
            Ok(Prepared::Path(path)) => {
                all.extend(path.readings(path.offset_s).into_iter().map(|r| (pair, r)));
            }
            Err(_) => {}
        }
    }
    all
}

fn is_near(solved: &HandEye, reading: &PairedReading, most: &Spread) -> bool {
    let (mm, rad) = solved.error(reading);
    mm <= most.position_mm && rad <= most.angle_rad
}

fn characterised(
    hand_eye: &HandEye,
    all: &[(usize, PairedReading)],
    kept: &[bool],
) -> Vec<CharacterisedReading> {
    all.iter()
        .zip(kept)
        .filter(|(_, kept)| **kept)
        .map(|((pair, reading), _)| {
            let (position_mm, angle_rad) = hand_eye.error(reading);
            CharacterisedReading {
                pair: *pair,
                pose: reading.pose,
                sensor: reading.sensor,
                measurement: Measurement {
                    tracker_from_ideal: hand_eye.expected(reading),
                    tracker_from_measured: reading.tracker_from_sensor,
                },
                error: Spread { position_mm, angle_rad },
            }
        })
        .collect()
}

fn reports(
    prepared: Vec<prepare::PreparedPair>,
    hand_eye: &HandEye,
    all: &[(usize, PairedReading)],
    kept: &[bool],
    settings: &CharacterisationSettings,
) -> Vec<PairReport> {
    let mut counts = vec![(0, 0); prepared.len()];
    for ((pair, _), kept) in all.iter().zip(kept) {
        let (readings, too_far) = &mut counts[*pair];
        *(if *kept { readings } else { too_far }) += 1;
    }
    prepared
        .into_iter()
        .zip(counts)
        .map(|(pair, (readings, too_far))| PairReport {
            outcome: match pair.content {
                _ if readings == 0 && too_far > 0 => Err(PairProblem::AllTooFar),
                Ok(Prepared::Still { report, .. }) => Ok(PairOutcome::Still(report)),
                Ok(Prepared::Path(path)) => Ok(PairOutcome::Path(path.report(hand_eye, settings))),
                Err(problem) => Err(problem),
            },
            unusable: pair.unusable,
            readings,
            too_far,
        })
        .collect()
}

/// Of every two sensors, from what the EM tracker read, whatever the reference saw.
fn distances(
    pairs: &[RecordedPair],
    sensors: &[String],
    settings: &CharacterisationSettings,
) -> Vec<SensorDistance> {
    let mut moments: BTreeMap<[usize; 2], Vec<(Pose, Pose)>> = BTreeMap::new();
    for pair in pairs {
        for moment in prepare::tracker_moments(pair, sensors, settings) {
            for (i, (a, pose_a)) in moment.iter().enumerate() {
                for (b, pose_b) in &moment[i + 1..] {
                    moments.entry([*a, *b]).or_default().push((*pose_a, *pose_b));
                }
            }
        }
    }
    moments
        .into_iter()
        .filter_map(|(sensors, moments)| {
            rigid_check(&moments).map(|check| SensorDistance { sensors, check })
        })
        .collect()
}
