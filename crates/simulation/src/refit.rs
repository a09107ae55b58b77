//! A body whose sensors are read once and whose frame is fitted again and again: what placement
//! and tolerances share.
//!
//! A study distorts every sensor at every pose and refits the frame. A variant that changes some
//! sensors alone costs their readings and a frame fit a pose.

use super::body::{RigidBody, Sensor};
use super::frame_fit::{FrameFitter, Reading};
use super::scenario::Scenario;
use super::tracker::{BodyTracker, TrackBuffers};
use super::work::Work;
use nalgebra::{Point3, UnitQuaternion};
use rayon::prelude::*;
use std::ops::Range;
use trackwright_geometry::pose::Pose;
use trackwright_task::{CancelToken, Cancelled};

/// What the sensors of a body read at many poses.
pub struct BodyReadings<'a> {
    scenario: &'a Scenario,
    sensors: usize,
    tracker_from_body: Vec<Pose>,
    /// Poses come in runs of one orientation, each so long.
    run: usize,
    /// Pose by pose, one a sensor.
    readings: Vec<Reading>,
    /// Whether each is of a sensor in the model's box.
    are_inside: Vec<bool>,
}

/// What variants are computed in.
#[derive(Default)]
pub struct RefitBuffers {
    track: TrackBuffers,
    read: Vec<(Reading, bool)>,
    all: Vec<Reading>,
}

impl RefitBuffers {
    /// What was done since this was called last.
    pub fn take_work(&mut self) -> Work {
        std::mem::take(&mut self.track.work)
    }
}

/// Sensors that a variant has instead of those that were read, by their numbers in the body, and
/// the fitter of its frame.
pub struct Replaced<'a> {
    fitter: &'a FrameFitter,
    numbers: &'a [usize],
    tracker: BodyTracker<'a>,
}

impl<'a> BodyReadings<'a> {
    /// Reads the sensors of a body, but for one of them where it is skipped; pieces of the poses on
    /// all cores.
    ///
    /// # Errors
    /// [`Cancelled`].
    pub fn read(
        scenario: &'a Scenario,
        body: &RigidBody,
        skipped: Option<usize>,
        (tracker_from_body, run): (Vec<Pose>, usize),
        pieces: Vec<Range<usize>>,
        cancel: &CancelToken,
    ) -> Result<(Self, Work), Cancelled> {
        let read: Vec<usize> = (0..body.sensors.len()).filter(|i| Some(*i) != skipped).collect();
        let sensors: Vec<Sensor> = read.iter().map(|&i| body.sensors[i].clone()).collect();
        let tracker = tracker(scenario, body, &sensors);
        let parts: Result<Vec<_>, Cancelled> = pieces
            .into_par_iter()
            .map_init(TrackBuffers::default, |buffers, piece| {
                if cancel.is_cancelled() {
                    return Err(Cancelled);
                }
                let poses = &tracker_from_body[piece.clone()];
                let mut found = Vec::with_capacity(poses.len() * sensors.len());
                tracker.read_all(buffers, poses, run.min(poses.len()), &mut found);
                Ok((piece, found, std::mem::take(&mut buffers.work)))
            })
            .collect();
        let sensors = body.sensors.len();
        let nothing =
            Reading { position_mm: Point3::origin(), rotation: UnitQuaternion::identity() };
        let all = tracker_from_body.len() * sensors;
        let mut readings = vec![nothing; all];
        let mut are_inside = vec![true; all];
        let mut work = Work::default();
        for (piece, found, cost) in parts? {
            work += cost;
            for (index, (reading, is_inside)) in found.into_iter().enumerate() {
                let pose = piece.start + index % piece.len();
                let slot = pose * sensors + read[index / piece.len()];
                (readings[slot], are_inside[slot]) = (reading, is_inside);
            }
        }
        Ok((Self { scenario, sensors, tracker_from_body, run, readings, are_inside }, work))
    }

    /// The poses.
    pub fn tracker_from_body(&self) -> &[Pose] {
        &self.tracker_from_body
    }

    /// Whether all sensors but one are in the model's box at a pose.
    pub fn are_inside(&self, pose: usize, but: Option<usize>) -> bool {
        let of_pose = self.are_inside[pose * self.sensors..(pose + 1) * self.sensors].iter();
        of_pose.enumerate().all(|(sensor, is_inside)| *is_inside || Some(sensor) == but)
    }

    /// Sensors of the body that are replaced, in the same room.
    pub fn replaced<'b>(
        &'b self,
        body: &RigidBody,
        fitter: &'b FrameFitter,
        numbers: &'b [usize],
        sensors: &[Sensor],
    ) -> Replaced<'b> {
        Replaced { fitter, numbers, tracker: tracker(self.scenario, body, sensors) }
    }

    /// Fits the frame at every pose with the readings as they are.
    pub fn fit(&self, fitter: &FrameFitter, buffers: &mut RefitBuffers) -> Vec<Pose> {
        let poses = self.tracker_from_body.iter().zip(self.readings.chunks(self.sensors.max(1)));
        let fits = poses.map(|(pose, readings)| fitter.fit(readings, pose).tracker_from_body);
        buffers.track.work.frame_fits += self.tracker_from_body.len() as u64;
        fits.collect()
    }

    /// Fits the frame at poses with some sensors replaced. `keeps` gets the number of each pose and
    /// whether the replaced sensors are in the model's box there, and returns whether to fit it;
    /// `each` gets the number and the frame.
    ///
    /// # Errors
    /// [`Cancelled`], looked for once a piece.
    pub fn refit(
        &self,
        replaced: &Replaced,
        pieces: impl Iterator<Item = Range<usize>>,
        buffers: &mut RefitBuffers,
        cancel: &CancelToken,
        mut keeps: impl FnMut(usize, bool) -> bool,
        mut each: impl FnMut(usize, Pose),
    ) -> Result<(), Cancelled> {
        for piece in pieces {
            if cancel.is_cancelled() {
                return Err(Cancelled);
            }
            let RefitBuffers { track, read, all } = &mut *buffers;
            let poses = &self.tracker_from_body[piece.clone()];
            read.clear();
            replaced.tracker.read_all(track, poses, self.run.min(poses.len()), read);
            for (place, tracker_from_body) in poses.iter().enumerate() {
                let pose = piece.start + place;
                let of_pose = || read.iter().skip(place).step_by(poses.len());
                if !keeps(pose, of_pose().all(|(_, is_inside)| *is_inside)) {
                    continue;
                }
                all.clear();
                all.extend_from_slice(
                    &self.readings[pose * self.sensors..(pose + 1) * self.sensors],
                );
                for (&sensor, (reading, _)) in replaced.numbers.iter().zip(of_pose()) {
                    all[sensor] = *reading;
                }
                each(pose, replaced.fitter.fit(all, tracker_from_body).tracker_from_body);
                track.work.frame_fits += 1;
                track.work.reading_reuses += (self.sensors - replaced.numbers.len()) as u64;
            }
        }
        Ok(())
    }
}

fn tracker<'a>(scenario: &'a Scenario, body: &RigidBody, sensors: &[Sensor]) -> BodyTracker<'a> {
    let fitter = FrameFitter::new(body, scenario.orientation_weight_mm);
    BodyTracker::of_sensors(fitter, sensors, &scenario.environment, scenario.outside)
}
