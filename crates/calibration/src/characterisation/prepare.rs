//! From two recordings to readings of still poses, or to streams that can be laid over each other.

use super::error::{CharacterisationError, PairProblem};
use super::path::PathPair;
use super::settings::{CharacterisationSettings, PairKind, RecordedPair};
use crate::hand_eye::{PairedReading, ReadingNoise};
use crate::pose_stream::{Clock, ClockFaults};
use crate::still_pose::{Spread, StillPose, still_pose};
use crate::time_alignment::align;
use std::collections::{BTreeMap, BTreeSet};
use trackwright_geometry::pose::Pose;
use trackwright_simulation::recording::{Recording, ToolTrack, Unusable};

/// Half of the reference's readings within this of their median are of a still pose: far above its
/// jitter (0.01 mm, 0.02°), and a hand's tremor; a path leaves it within a fraction of a second.
const STILL: Spread = Spread { position_mm: 2.0, angle_rad: 0.02 };

/// Half of a sensor's readings beyond this of their median are of no still pose: ten times the
/// jitter of the worst pose of the strongly distorted room in docs/methods/characterisation.md.
const MOVED: Spread = Spread { position_mm: 5.0, angle_rad: 0.05 };

/// How a still pose was averaged.
#[derive(Clone, Debug, PartialEq)]
pub struct StillReport {
    pub reference: StillPose,
    /// By sensor, of those that were read.
    pub sensors: Vec<(usize, StillPose)>,
}

/// What a pair comes to before anything is known of where anything is.
pub(super) enum Prepared {
    Still { readings: Vec<PairedReading>, report: StillReport },
    Path(PathPair),
}

pub(super) struct PreparedPair {
    pub content: Result<Prepared, PairProblem>,
    pub unusable: BTreeMap<Unusable, usize>,
}

/// Names of all sensors, in order of appearance, of those that are wanted.
pub(super) fn sensor_names(
    pairs: &[RecordedPair],
    wanted: &[String],
) -> Result<Vec<String>, CharacterisationError> {
    let mut names: Vec<String> = Vec::new();
    for tool in pairs.iter().flat_map(|pair| &pair.tracker.tools) {
        // A port that nothing good ever came from is no sensor.
        if !names.contains(&tool.name) && tool.good().next().is_some() {
            names.push(tool.name.clone());
        }
    }
    let missing = wanted.iter().find(|part| !names.iter().any(|name| name.contains(part.as_str())));
    if let Some(missing) = missing {
        return Err(CharacterisationError::NoSuchSensor { wanted: missing.clone(), names });
    }
    let is_wanted =
        |name: &String| wanted.is_empty() || wanted.iter().any(|part| name.contains(part.as_str()));
    names.retain(is_wanted);
    match names.iter().find(|name| is_five_dof(pairs, name)) {
        Some(name) => Err(CharacterisationError::FiveDof(name.clone())),
        None => Ok(names),
    }
}

/// Trackers write the turn of a 5-DOF sensor as one without a part about its own z.
fn is_five_dof(pairs: &[RecordedPair], name: &str) -> bool {
    let tracks = pairs.iter().flat_map(|pair| &pair.tracker.tools);
    let mut turns = tracks
        .filter(|track| track.name == name)
        .flat_map(ToolTrack::good)
        .map(|pose| pose.rotation.coords)
        .filter(|turn| turn.x != 0.0 || turn.y != 0.0 || turn.z != 0.0)
        .peekable();
    turns.peek().is_some() && turns.all(|turn| turn.z == 0.0)
}

pub(super) fn prepare(
    index: usize,
    pair: &RecordedPair,
    sensors: &[String],
    settings: &CharacterisationSettings,
    next_pose: &mut usize,
) -> Result<PreparedPair, CharacterisationError> {
    let reference = pair
        .reference
        .tool(settings.reference_tool.as_deref())
        .map_err(|cause| CharacterisationError::ReferenceTool { pair: index, cause })?;
    let tracks = tracks(&pair.tracker, sensors);
    let mut unusable = BTreeMap::new();
    for track in tracks.iter().map(|(_, track)| *track).chain([reference]) {
        for (reason, count) in track.unusable() {
            *unusable.entry(reason.clone()).or_default() += count;
        }
    }
    let content = content(pair, reference, &tracks, settings, next_pose);
    Ok(PreparedPair { content, unusable })
}

/// The tracks of the sensors that count, by their numbers.
fn tracks<'a>(recording: &'a Recording, sensors: &[String]) -> Vec<(usize, &'a ToolTrack)> {
    let number = |tool: &'a ToolTrack| {
        let place = sensors.iter().position(|name| *name == tool.name)?;
        Some((place, tool))
    };
    recording.tools.iter().filter_map(number).collect()
}

fn good(track: &ToolTrack) -> Vec<Pose> {
    track.good().copied().collect()
}

/// What a pair is of; `None` where the reference has no good sample.
fn kind_of(reference: &ToolTrack, settings: &CharacterisationSettings) -> Option<PairKind> {
    let still = still_pose(&good(reference))?;
    let is_still = still.half_within.position_mm <= STILL.position_mm
        && still.half_within.angle_rad <= STILL.angle_rad;
    let found = if is_still { PairKind::Still } else { PairKind::Path };
    Some(settings.kind.unwrap_or(found))
}

fn content(
    pair: &RecordedPair,
    reference: &ToolTrack,
    tracks: &[(usize, &ToolTrack)],
    settings: &CharacterisationSettings,
    next_pose: &mut usize,
) -> Result<Prepared, PairProblem> {
    let kind = kind_of(reference, settings).ok_or(PairProblem::NoReference)?;
    let seen: Vec<(usize, &ToolTrack)> =
        tracks.iter().copied().filter(|(_, track)| track.good().next().is_some()).collect();
    if seen.is_empty() {
        return Err(PairProblem::NoSensor);
    }
    match kind {
        PairKind::Still => still(reference, &seen, next_pose),
        PairKind::Path => path(pair, reference, &seen, settings, next_pose).map(Prepared::Path),
    }
}

fn still(
    reference: &ToolTrack,
    tracks: &[(usize, &ToolTrack)],
    next_pose: &mut usize,
) -> Result<Prepared, PairProblem> {
    let body = still_pose(&good(reference)).ok_or(PairProblem::NoReference)?;
    let sensors: Vec<(usize, StillPose)> = tracks
        .iter()
        .filter_map(|(sensor, track)| Some((*sensor, still_pose(&good(track))?)))
        .collect();
    let has_moved = |pose: &StillPose| {
        pose.half_within.position_mm > MOVED.position_mm
            || pose.half_within.angle_rad > MOVED.angle_rad
    };
    if sensors.iter().map(|(_, pose)| pose).chain([&body]).any(has_moved) {
        return Err(PairProblem::Moved);
    }
    let pose = *next_pose;
    *next_pose += 1;
    let readings = sensors
        .iter()
        .map(|(sensor, read)| PairedReading {
            pose,
            sensor: *sensor,
            reference_from_body: body.pose,
            tracker_from_sensor: read.pose,
            noise: ReadingNoise { tracker: read.mean_error(), reference: body.mean_error() },
        })
        .collect();
    Ok(Prepared::Still { readings, report: StillReport { reference: body, sensors } })
}

fn path(
    pair: &RecordedPair,
    reference: &ToolTrack,
    tracks: &[(usize, &ToolTrack)],
    settings: &CharacterisationSettings,
    next_pose: &mut usize,
) -> Result<PathPair, PairProblem> {
    let tracker_clock = Clock::of(&pair.tracker, settings.tracker_ticks_per_s)
        .ok_or(PairProblem::NoClock("EM recording"))?;
    let reference_clock = Clock::of(&pair.reference, settings.reference_ticks_per_s)
        .ok_or(PairProblem::NoClock("reference's recording"))?;
    // All sensors count from the same moment: the first good sample of the first of them.
    let first_good = |track: &ToolTrack| track.samples.iter().find(|s| s.pose.is_ok()).cloned();
    let origin =
        tracks.first().and_then(|(_, track)| first_good(track)).ok_or(PairProblem::NoSensor)?;
    let reference_origin = first_good(reference).ok_or(PairProblem::NoReference)?;
    let (reference, mut reference_faults) = reference_clock.stream(reference, &reference_origin);
    let mut faults = ClockFaults::default();
    let mut streams = Vec::new();
    for (sensor, track) in tracks {
        let (stream, of_track) = tracker_clock.stream(track, &origin);
        faults.add(&of_track);
        streams.push((*sensor, stream));
    }
    let sensors: Vec<_> = streams.iter().map(|(_, stream)| stream.clone()).collect();
    let alignment = align(&sensors, &reference, &settings.alignment)?;
    reference_faults.add(&faults);
    let path = PathPair {
        streams,
        reference,
        clocks: [tracker_clock, reference_clock],
        faults: reference_faults,
        offset_s: alignment.offset_s,
        alignment,
        first_pose: *next_pose,
        max_gap_s: settings.alignment.max_gap_s,
    };
    *next_pose += path.segments();
    if path.readings(path.offset_s).is_empty() {
        return Err(PairProblem::NoOverlap);
    }
    Ok(path)
}

/// What the EM tracker read at the same moments, by sensor: averages, or sample by sample.
pub(super) fn tracker_moments(
    pair: &RecordedPair,
    sensors: &[String],
    settings: &CharacterisationSettings,
) -> Vec<Vec<(usize, Pose)>> {
    let tracks = tracks(&pair.tracker, sensors);
    // Without a reference, the motion of the first sensor decides.
    let reference = pair.reference.tool(settings.reference_tool.as_deref()).ok();
    let by = reference.into_iter().chain(tracks.iter().map(|(_, track)| *track));
    match by.filter_map(|track| kind_of(track, settings)).next() {
        Some(PairKind::Still) => {
            let average = |(sensor, track): &(usize, &ToolTrack)| {
                Some((*sensor, still_pose(&good(track))?.pose))
            };
            vec![tracks.iter().filter_map(average).collect()]
        }
        Some(PairKind::Path) => path_moments(&tracks),
        None => Vec::new(),
    }
}

/// Sample by sample where all sensors have as many, for they were written together; else what has the
/// same frame number, or the same time.
fn path_moments(tracks: &[(usize, &ToolTrack)]) -> Vec<Vec<(usize, Pose)>> {
    let lengths: BTreeSet<usize> = tracks.iter().map(|(_, t)| t.samples.len()).collect();
    let is_together = lengths.len() <= 1;
    let mut moments: BTreeMap<(u64, usize), Vec<(usize, Pose)>> = BTreeMap::new();
    for (sensor, track) in tracks {
        let mut last = None;
        let mut repeats = 0;
        for (k, sample) in track.samples.iter().enumerate() {
            let counted = sample.frame.or(sample.time_s.map(f64::to_bits));
            let moment = match (is_together, counted) {
                (true, _) => (0, k),
                (false, Some(at)) => {
                    repeats = if last == Some(at) { repeats + 1 } else { 0 };
                    last = Some(at);
                    (at, repeats)
                }
                (false, None) => continue,
            };
            if let Ok(pose) = &sample.pose {
                moments.entry(moment).or_default().push((*sensor, *pose));
            }
        }
    }
    moments.into_values().collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use trackwright_simulation::recording::TrackSample;

    fn track(frames: &[Option<u64>]) -> ToolTrack {
        let sample = |frame: &Option<u64>| TrackSample {
            frame: *frame,
            time_s: None,
            pose: Ok(Pose::translation(frame.unwrap_or(0) as f64, 0.0, 0.0)),
        };
        ToolTrack { name: String::new(), samples: frames.iter().map(sample).collect() }
    }

    #[test]
    fn sensors_are_matched_by_rows_else_by_frames() {
        let moments = |a: &[Option<u64>], b: &[Option<u64>]| -> Vec<Vec<f64>> {
            let (a, b) = (track(a), track(b));
            let moments = path_moments(&[(0, &a), (1, &b)]);
            let frame = |(_, pose): &(usize, Pose)| pose.translation.x;
            moments.iter().map(|m| m.iter().map(frame).collect()).collect()
        };
        let some = |frames: &[u64]| frames.iter().map(|f| Some(*f)).collect::<Vec<_>>();
        // Trackers may count the frames of different kinds of tools apart.
        assert_eq!(moments(&some(&[1, 2]), &some(&[11, 12])), [[1.0, 11.0], [2.0, 12.0]]);
        assert_eq!(
            moments(&some(&[1, 2, 2, 3]), &some(&[2, 3])),
            [vec![1.0], vec![2.0, 2.0], vec![2.0], vec![3.0, 3.0]]
        );
        assert_eq!(moments(&[None, None], &[None]), Vec::<Vec<f64>>::new());
    }
}
