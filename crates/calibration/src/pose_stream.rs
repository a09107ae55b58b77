//! A tool's poses over time, by whatever clock its recording has, and poses in between.
//!
//! A clock is trusted only as long as it goes forward. Samples out of order are left out, and after
//! a jump back the longest segment is used: the time between segments is unknown.

use trackwright_geometry::pose::{Pose, interpolated};
use trackwright_simulation::recording::{Recording, ToolTrack, TrackSample};

/// The source of a recording's time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Clock {
    Times,
    Frames { ticks_per_s: f64 },
}

/// Poses with times that go forward; `tracker_from_tool`.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PoseStream {
    samples: Vec<(f64, Pose)>,
}

/// Samples that have a good pose but no time to be trusted.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ClockFaults {
    pub without_time: usize,
    pub repeated: usize,
    pub out_of_order: usize,
    /// In segments before or after a jump back that are not used.
    pub beyond_jump: usize,
    pub jumps_back: usize,
}

/// Samples that are read to distinguish a straggler from a clock that was set back.
const LOOK_AHEAD: usize = 3;

impl Clock {
    /// Times where every good sample has one, else frames; `None` where there is neither.
    pub fn of(recording: &Recording, ticks_per_s: f64) -> Option<Self> {
        let all_have = |has: fn(&TrackSample) -> bool| {
            let mut good = recording
                .tools
                .iter()
                .flat_map(|tool| &tool.samples)
                .filter(|sample| sample.pose.is_ok())
                .peekable();
            good.peek().is_some() && good.all(has)
        };
        if all_have(|sample| sample.time_s.is_some()) {
            Some(Self::Times)
        } else if all_have(|sample| sample.frame.is_some()) {
            Some(Self::Frames { ticks_per_s })
        } else {
            None
        }
    }

    /// Seconds since `origin`, a sample of the same recording.
    fn seconds(&self, sample: &TrackSample, origin: &TrackSample) -> Option<f64> {
        let seconds = match self {
            Self::Times => sample.time_s? - origin.time_s?,
            // Counters are taken from each other as whole numbers, which loses nothing.
            Self::Frames { ticks_per_s } => {
                let (frame, first) = (sample.frame?, origin.frame?);
                let ticks = frame.abs_diff(first) as f64;
                (if frame < first { -ticks } else { ticks }) / ticks_per_s
            }
        };
        seconds.is_finite().then_some(seconds)
    }

    /// A tool's good poses, in seconds since `origin`.
    pub fn stream(&self, track: &ToolTrack, origin: &TrackSample) -> (PoseStream, ClockFaults) {
        let mut faults = ClockFaults::default();
        let mut timed = Vec::new();
        for sample in &track.samples {
            match (&sample.pose, self.seconds(sample, origin)) {
                (Ok(pose), Some(time_s)) => timed.push((time_s, *pose)),
                (Ok(_), None) => faults.without_time += 1,
                (Err(_), _) => {}
            }
        }
        let mut segments: Vec<Vec<(f64, Pose)>> = vec![Vec::new()];
        for (i, &(time_s, pose)) in timed.iter().enumerate() {
            let Some(segment) = segments.last_mut() else {
                break;
            };
            let last_s = segment.last().map(|s| s.0);
            let before_last_s = segment.len().checked_sub(2).map(|k| segment[k].0);
            match last_s {
                Some(last_s) if time_s == last_s => faults.repeated += 1,
                Some(last_s) if time_s < last_s => {
                    let next = timed.iter().skip(i + 1).take(LOOK_AHEAD);
                    if next.into_iter().any(|(next_s, _)| *next_s > last_s) {
                        faults.out_of_order += 1;
                    } else if before_last_s.is_some_and(|before_s| time_s > before_s) {
                        // The last one was ahead of all others.
                        faults.out_of_order += 1;
                        segment.pop();
                        segment.push((time_s, pose));
                    } else {
                        faults.jumps_back += 1;
                        segments.push(vec![(time_s, pose)]);
                    }
                }
                _ => segment.push((time_s, pose)),
            }
        }
        let all: usize = segments.iter().map(Vec::len).sum();
        // The first of equals.
        let longest = segments.into_iter().rev().max_by_key(Vec::len);
        let samples = longest.unwrap_or_default();
        faults.beyond_jump = all - samples.len();
        (PoseStream { samples }, faults)
    }
}

impl ClockFaults {
    /// Adds counts.
    pub fn add(&mut self, other: &Self) {
        self.without_time += other.without_time;
        self.repeated += other.repeated;
        self.out_of_order += other.out_of_order;
        self.beyond_jump += other.beyond_jump;
        self.jumps_back += other.jumps_back;
    }
}

impl PoseStream {
    /// Times in seconds, going forward.
    pub fn samples(&self) -> &[(f64, Pose)] {
        &self.samples
    }

    /// First and last time; `None` without samples.
    pub fn span_s(&self) -> Option<(f64, f64)> {
        Some((self.samples.first()?.0, self.samples.last()?.0))
    }

    /// The pose at a time: straight in position and at constant speed in rotation (slerp) between the
    /// samples around it. `None` before the first, after the last, and between two that are more than
    /// `max_gap_s` apart.
    pub fn at(&self, time_s: f64, max_gap_s: f64) -> Option<Pose> {
        let after = self.samples.partition_point(|(t, _)| *t < time_s);
        let (next_s, next) = self.samples.get(after)?;
        if *next_s == time_s {
            return Some(*next);
        }
        let (last_s, last) = self.samples.get(after.checked_sub(1)?)?;
        let gap_s = next_s - last_s;
        if gap_s > max_gap_s {
            return None;
        }
        let part = (time_s - last_s) / gap_s;
        Some(interpolated(last, next, part))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Vector3;
    use trackwright_geometry::pose::pose_from_parts;
    use trackwright_geometry::rotation::{exp_vector, log_quaternion};
    use trackwright_simulation::recording::Unusable;

    fn sample(frame: Option<u64>, time_s: Option<f64>) -> TrackSample {
        TrackSample {
            frame,
            time_s,
            pose: Ok(Pose::translation(frame.unwrap_or(0) as f64, 0.0, 0.0)),
        }
    }

    fn track(frames: &[u64]) -> ToolTrack {
        ToolTrack {
            name: "t".to_owned(),
            samples: frames.iter().map(|f| sample(Some(*f), None)).collect(),
        }
    }

    const TENTHS: Clock = Clock::Frames { ticks_per_s: 10.0 };

    /// Frames that are left, and what is reported about the others.
    fn left(frames: &[u64]) -> (Vec<f64>, ClockFaults) {
        let track = track(frames);
        let (stream, faults) = TENTHS.stream(&track, &track.samples[0]);
        let at = |(_, pose): &(f64, Pose)| pose.translation.x;
        (stream.samples().iter().map(at).collect(), faults)
    }

    #[test]
    fn unordered_and_repeated_frames_are_left_out() {
        let (frames, faults) = left(&[10, 20, 40, 30, 50, 50, 60]);
        assert_eq!(frames, [10.0, 20.0, 40.0, 50.0, 60.0]);
        assert_eq!((faults.out_of_order, faults.repeated), (1, 1));
        // One far ahead of all others is the one that is wrong.
        let (frames, faults) = left(&[10, 20, 9000, 30, 40, 50]);
        assert_eq!(frames, [10.0, 20.0, 30.0, 40.0, 50.0]);
        assert_eq!((faults.out_of_order, faults.jumps_back), (1, 0));
    }

    #[test]
    fn after_a_jump_back_the_longest_segment_is_used() {
        let (frames, faults) = left(&[100, 110, 120, 5, 15, 25, 35, 45]);
        assert_eq!(frames, [5.0, 15.0, 25.0, 35.0, 45.0]);
        assert_eq!((faults.jumps_back, faults.beyond_jump), (1, 3));
    }

    #[test]
    fn a_clock_is_the_files_own_or_its_counter_or_none() {
        let with = |samples: Vec<TrackSample>| Recording {
            tools: vec![ToolTrack { name: "t".to_owned(), samples }],
        };
        let bad = TrackSample { pose: Err(Unusable::Missing), ..sample(None, None) };
        let both = with(vec![bad.clone(), sample(Some(1), Some(0.5))]);
        assert_eq!(Clock::of(&both, 40.0), Some(Clock::Times));
        let one_without = with(vec![sample(Some(1), Some(0.5)), sample(Some(2), None)]);
        let frames = Clock::Frames { ticks_per_s: 40.0 };
        assert_eq!(Clock::of(&one_without, 40.0), Some(frames));
        assert_eq!(Clock::of(&with(vec![sample(None, None)]), 40.0), None);
        assert_eq!(Clock::of(&with(vec![bad]), 40.0), None);
    }

    #[test]
    fn poses_are_interpolated_within_gaps_only() {
        let turn = Vector3::new(0.0, 1.2, 0.4);
        let end = pose_from_parts(Vector3::new(10.0, -4.0, 2.0), exp_vector(&turn));
        let stream = PoseStream { samples: vec![(1.0, Pose::identity()), (3.0, end), (9.0, end)] };
        let between = stream.at(1.5, 2.0).unwrap();
        assert!((between.translation.vector - Vector3::new(2.5, -1.0, 0.5)).norm() < 1e-14);
        assert!((log_quaternion(&between.rotation) - turn / 4.0).norm() < 1e-15);
        assert_eq!(stream.at(3.0, 2.0), Some(end));
        assert_eq!(stream.at(1.0, 0.0), Some(Pose::identity()));
        for (time_s, max_gap_s) in [(0.9, 9.0), (9.1, 9.0), (5.0, 2.0), (1.5, 1.9)] {
            assert_eq!(stream.at(time_s, max_gap_s), None, "{time_s}");
        }
        assert_eq!(PoseStream::default().at(0.0, 1.0), None);
    }
}
