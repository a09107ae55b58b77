//! Whether a sample is late, told from a sender's clock that is not ours.
//!
//! The two clocks are apart by an unknown amount, so a single timestamp says nothing. The sample
//! that got here fastest does: what comes later than it by more than is allowed has waited
//! somewhere, in a buffer or behind a stall, and is not where the tool is now.

use super::codec::Timestamp;
use std::time::{Duration, Instant};

/// How fast the sender's clock may run away from ours and still be followed: 1 ms a second is ten
/// times what a quartz does.
const DRIFT: f64 = 1e-3;

/// How much the lag may vary for it to count as the same, in seconds: frames of 40 Hz come in
/// packets that are a few of them apart at most.
const SAME_LAG_S: f64 = 0.1;

/// How long timestamps have to be off by the same amount until the clock is believed to have been
/// set, in seconds. What has waited comes faster than it was sent, so its lag shrinks by then.
const SETTLING_S: f64 = 1.0;

/// The clock of one sender, as its timestamps show it.
#[derive(Clone, Debug)]
pub struct SenderClock {
    late_after_s: f64,
    reference: Option<Reference>,
    /// An offset that a jump would explain, and since when.
    candidate: Option<Reference>,
}

#[derive(Clone, Copy, Debug)]
struct Reference {
    timestamp: Timestamp,
    at: Instant,
}

impl Reference {
    /// How much longer a sample took than this one, in seconds; negative where it was faster.
    fn lag_s(&self, timestamp: Timestamp, at: Instant) -> f64 {
        seconds_between(self.at, at) - timestamp.seconds_since(self.timestamp)
    }
}

/// What a timestamp says of its sample.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Judged {
    InTime,
    /// It took longer to arrive than is allowed, or the clock was set and it is too early to say.
    Late,
    /// In time, by a clock that has been set since the last ones that were.
    AfterJump,
}

impl SenderClock {
    pub fn new(late_after: Duration) -> Self {
        Self {
            late_after_s: late_after.as_secs_f64(),
            reference: None,
            candidate: None,
        }
    }

    /// Judges a sample by its timestamp and the moment it arrived at; one without a timestamp is
    /// taken as it comes.
    pub fn judge(&mut self, timestamp: Timestamp, at: Instant) -> Judged {
        if !timestamp.is_stated() {
            return Judged::InTime;
        }
        let now = Reference { timestamp, at };
        let Some(reference) = self.reference else {
            self.reference = Some(now);
            return Judged::InTime;
        };
        let lag_s = reference.lag_s(timestamp, at);
        let drift_s = DRIFT * seconds_between(reference.at, at).max(0.0);
        if (-self.late_after_s..=self.late_after_s + drift_s).contains(&lag_s) {
            if lag_s <= drift_s {
                self.reference = Some(now);
            }
            self.candidate = None;
            return Judged::InTime;
        }
        match self.candidate {
            Some(candidate) if candidate.lag_s(timestamp, at).abs() <= SAME_LAG_S => {
                if seconds_between(candidate.at, at) < SETTLING_S {
                    return Judged::Late;
                }
                self.reference = Some(now);
                self.candidate = None;
                Judged::AfterJump
            }
            _ => {
                self.candidate = Some(now);
                Judged::Late
            }
        }
    }
}

fn seconds_between(earlier: Instant, later: Instant) -> f64 {
    match later.checked_duration_since(earlier) {
        Some(duration) => duration.as_secs_f64(),
        None => -earlier.duration_since(later).as_secs_f64(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const ALLOWED: Duration = Duration::from_millis(250);

    /// A sender whose clock is 1,000 s ahead of ours, and what is judged of its samples.
    struct Stream {
        start: Instant,
        clock: SenderClock,
    }

    impl Stream {
        fn new() -> Self {
            Self {
                start: Instant::now(),
                clock: SenderClock::new(ALLOWED),
            }
        }

        fn judge(&mut self, sent_s: f64, arrived_s: f64) -> Judged {
            let sent = Timestamp::from_unix(Duration::from_secs_f64(1000.0 + sent_s));
            let at = self.start + Duration::from_secs_f64(arrived_s);
            self.clock.judge(sent, at)
        }

        /// Frames of 40 Hz that arrive `lag_s` after they were sent; how many were in time.
        fn in_time(&mut self, from_s: f64, frames: u32, lag_s: impl Fn(f64) -> f64) -> u32 {
            let mut count = 0;
            for frame in 0..frames {
                let at_s = from_s + f64::from(frame) / 40.0;
                count += u32::from(self.judge(at_s, at_s + lag_s(at_s)) == Judged::InTime);
            }
            count
        }
    }

    #[test]
    fn frames_in_packets_and_a_clock_that_drifts_are_in_time() {
        let mut stream = Stream::new();
        // An hour, with up to 80 ms of waiting, and a clock that loses 0.2 ms a second.
        let lag = |at_s: f64| 0.08 * (at_s * 17.0).sin().abs() + 2e-4 * at_s;
        assert_eq!(stream.in_time(0.0, 144_000, lag), 144_000);
    }

    #[test]
    fn what_has_waited_is_late_and_what_follows_it_is_not() {
        let mut stream = Stream::new();
        assert_eq!(stream.in_time(0.0, 40, |_| 0.01), 40);
        // Everything sent within three seconds arrives at once.
        let burst = stream.in_time(1.0, 120, |at_s| 4.0 - at_s);
        // Only what was sent in the last quarter of a second, and its first frame's rounding.
        assert!((10..=11).contains(&burst), "{burst}");
        assert_eq!(stream.in_time(4.1, 40, |_| 0.01), 40);
    }

    #[test]
    fn a_clock_that_was_set_is_believed_after_a_second() {
        for step_s in [-500.0, 500.0] {
            let mut stream = Stream::new();
            assert_eq!(stream.in_time(0.0, 40, |_| 0.0), 40);
            let mut judged = Vec::new();
            for frame in 0..80 {
                let at_s = 1.0 + f64::from(frame) / 40.0;
                judged.push(stream.judge(at_s + step_s, at_s));
            }
            let late = judged.iter().filter(|j| **j == Judged::Late).count();
            assert_eq!(
                judged.iter().filter(|j| **j == Judged::AfterJump).count(),
                1
            );
            assert!((40..=41).contains(&late), "{late}");
            assert_eq!(judged[judged.len() - 1], Judged::InTime);
        }
    }

    #[test]
    fn one_wild_timestamp_moves_nothing_and_none_is_no_reason() {
        let mut stream = Stream::new();
        assert_eq!(stream.in_time(0.0, 40, |_| 0.0), 40);
        assert_eq!(stream.judge(9e8, 1.0), Judged::Late);
        assert_eq!(stream.in_time(1.025, 40, |_| 0.0), 40);
        assert_eq!(
            stream.clock.judge(Timestamp::NONE, stream.start),
            Judged::InTime
        );
    }
}
