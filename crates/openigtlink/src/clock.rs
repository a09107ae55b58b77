//! How late a sample is, measured by a sender's clock that is not ours.
//!
//! `arrival - timestamp` is the latency plus an offset between two clocks that is not known. The
//! smallest such difference is the reference: latency is counted from it, so that it is the time above
//! the fastest sample. A delay that was there from the first sample, and never less, cannot be
//! distinguished from an offset, unless both clocks are known to be one (`shared`).
//!
//! The reference becomes earlier at once. It becomes later only
//! - as fast as two honest clocks drift apart ([`DRIFT`]), and not while samples are late;
//! - by a step after a new connection, whose server may have another clock;
//! - by a step at any time where steps of the clock are to be followed (`--follow-clock`).
//!
//! By how much it has become later in all is known (`shift`): as much may be latency that is not seen.

use super::codec::Timestamp;
use std::time::{Duration, Instant};

/// How fast two clocks may drift apart and be followed: two quartz clocks of 100 ppm each. A delay
/// that grows as slowly (0.72 s an hour) looks the same.
const DRIFT: f64 = 200e-6;

/// How much the lag may vary and be the same, in seconds: packets are a few frames of 40 Hz apart.
const SAME_LAG_S: f64 = 0.1;

/// How long samples have to be late by the same amount until that is taken for a step of the clock,
/// where steps are followed. What has waited comes faster than it was sent, so its lag shrinks by then.
const LATER_STEP_S: f64 = 2.0;

/// How long samples are too early until the reference moves: one wrong timestamp moves nothing.
const EARLIER_STEP_S: f64 = 0.25;

/// How samples are judged.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ClockRules {
    /// The largest latency of a sample that is in time.
    pub bound: Duration,
    /// Whether lateness that stays the same is taken for a step of the sender's clock.
    pub follows_steps: bool,
    /// The same moment by the sender's clock and by ours, where they are known to agree.
    pub shared: Option<Moment>,
}

/// A moment by the sender's clock and by ours.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Moment {
    pub timestamp: Timestamp,
    pub at: Instant,
}

impl Moment {
    /// Now, by this machine's clock.
    pub fn now() -> Self {
        Self { timestamp: Timestamp::now(), at: Instant::now() }
    }

    /// How much longer a sample took than this one, in seconds; negative where it was faster.
    fn lag_s(&self, later: &Self) -> f64 {
        seconds_between(self.at, later.at) - later.timestamp.seconds_since(self.timestamp)
    }
}

/// What a timestamp states about its sample.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Judged {
    /// So much slower than the fastest; zero of a sample without a timestamp.
    InTime { latency_s: f64 },
    /// Slower than is allowed.
    Late { by_s: f64 },
    /// Faster than the fastest by more than is allowed: the clock may have been set.
    Early { by_s: f64 },
    /// In time by a reference that was moved by a step; later where positive.
    AfterStep { by_s: f64 },
}

/// The clock of one sender, as its timestamps show it.
#[derive(Clone, Debug)]
pub struct SenderClock {
    bound_s: f64,
    follows_steps: bool,
    is_shared: bool,
    reference: Option<Moment>,
    last_at: Option<Instant>,
    /// How much later the reference may become by drift.
    allowance_s: f64,
    shift_s: f64,
    is_late: bool,
    /// Whether nothing was in time since the connection was made anew.
    is_reconnected: bool,
    early_since: Option<Instant>,
    late_since: Option<Moment>,
}

impl SenderClock {
    /// A clock of which nothing is known yet.
    pub fn new(rules: ClockRules) -> Self {
        Self {
            bound_s: rules.bound.as_secs_f64(),
            follows_steps: rules.follows_steps,
            is_shared: rules.shared.is_some(),
            reference: rules.shared,
            last_at: None,
            allowance_s: 0.0,
            shift_s: 0.0,
            is_late: false,
            is_reconnected: false,
            early_since: None,
            late_since: None,
        }
    }

    /// By how much the reference is later than the earliest one, in seconds.
    pub fn shift_s(&self) -> f64 {
        self.shift_s
    }

    /// The connection is gone; the server that comes next may have another clock.
    pub fn reconnect(&mut self) {
        self.is_reconnected = true;
        self.is_late = false;
        self.early_since = None;
        self.late_since = None;
    }

    /// Judges a sample by its timestamp and arrival; one without a timestamp is in time.
    pub fn judge(&mut self, timestamp: Timestamp, at: Instant) -> Judged {
        if !timestamp.is_stated() {
            return Judged::InTime { latency_s: 0.0 };
        }
        let now = Moment { timestamp, at };
        self.allow_drift(at);
        let Some(reference) = self.reference else {
            self.reference = Some(now);
            self.is_reconnected = false;
            return Judged::InTime { latency_s: 0.0 };
        };
        let lag_s = reference.lag_s(&now);
        if lag_s > self.bound_s && lag_s > self.allowance_s {
            return self.late(now, lag_s);
        }
        if lag_s < -self.bound_s {
            return self.early(now, lag_s);
        }
        self.is_in_time();
        let mut latency_s = lag_s.max(0.0);
        if !self.is_shared && lag_s <= self.allowance_s {
            self.move_reference(now, lag_s);
            latency_s = 0.0;
        }
        Judged::InTime { latency_s }
    }

    /// Allows for drift, except while samples are late: the delay would be followed.
    fn allow_drift(&mut self, at: Instant) {
        let last = self.last_at.replace(at);
        if let Some(last) = last
            && !self.is_late
            && !self.is_shared
        {
            self.allowance_s += DRIFT * seconds_between(last, at).max(0.0);
        }
    }

    fn is_in_time(&mut self) {
        self.is_late = false;
        self.is_reconnected = false;
        self.early_since = None;
        self.late_since = None;
    }

    fn move_reference(&mut self, now: Moment, lag_s: f64) {
        self.reference = Some(now);
        self.allowance_s = 0.0;
        self.shift_s = (self.shift_s + lag_s).max(0.0);
    }

    fn late(&mut self, now: Moment, lag_s: f64) -> Judged {
        self.is_late = true;
        self.early_since = None;
        let may_step = (self.follows_steps || self.is_reconnected) && !self.is_shared;
        let is_same = |since: &Moment| since.lag_s(&now).abs() <= SAME_LAG_S;
        match self.late_since.filter(is_same) {
            Some(since) if may_step && seconds_between(since.at, now.at) >= LATER_STEP_S => {
                self.step(now, lag_s)
            }
            Some(_) => Judged::Late { by_s: lag_s },
            None => {
                self.late_since = Some(now);
                Judged::Late { by_s: lag_s }
            }
        }
    }

    fn early(&mut self, now: Moment, lag_s: f64) -> Judged {
        self.late_since = None;
        let since = *self.early_since.get_or_insert(now.at);
        // A clock that is known to agree with ours is not moved.
        if self.is_shared || seconds_between(since, now.at) < EARLIER_STEP_S {
            return Judged::Early { by_s: -lag_s };
        }
        self.step(now, lag_s)
    }

    fn step(&mut self, now: Moment, lag_s: f64) -> Judged {
        self.is_in_time();
        self.move_reference(now, lag_s);
        Judged::AfterStep { by_s: lag_s }
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

    const BOUND_S: f64 = 0.25;

    const RULES: ClockRules =
        ClockRules { bound: Duration::from_millis(250), follows_steps: false, shared: None };

    /// A sender whose clock is 1,000 s ahead of ours, and what is judged of its samples.
    struct Stream {
        start: Instant,
        clock: SenderClock,
    }

    impl Stream {
        fn new(rules: ClockRules) -> Self {
            Self {
                // So that there are moments before the first.
                start: Instant::now() + Duration::from_secs(1000),
                clock: SenderClock::new(rules),
            }
        }

        fn judge(&mut self, sent_s: f64, arrived_s: f64) -> Judged {
            let sent = Timestamp::from_unix(Duration::from_secs_f64(1000.0 + sent_s));
            let at = match arrived_s < 0.0 {
                true => self.start - Duration::from_secs_f64(-arrived_s),
                false => self.start + Duration::from_secs_f64(arrived_s),
            };
            self.clock.judge(sent, at)
        }

        /// Frames of 40 Hz that arrive `lag_s` after they were sent; how many were in time.
        fn in_time(&mut self, from_s: f64, frames: u32, lag_s: impl Fn(f64) -> f64) -> u32 {
            let mut count = 0;
            for frame in 0..frames {
                let at_s = from_s + f64::from(frame) / 40.0;
                let judged = self.judge(at_s, at_s + lag_s(at_s));
                count += u32::from(!matches!(judged, Judged::Late { .. } | Judged::Early { .. }));
            }
            count
        }
    }

    #[test]
    fn jitter_and_drift_are_in_time_and_counted() {
        let mut stream = Stream::new(RULES);
        // An hour, with up to 80 ms of waiting, and a clock that loses 0.1 ms a second.
        let lag = |at_s: f64| 0.08 * (at_s * 17.0).sin().abs() + 1e-4 * at_s;
        assert_eq!(stream.in_time(0.0, 144_000, lag), 144_000);
        // Of the 0.36 s, all but what the last fast frames are ago.
        let shift_s = stream.clock.shift_s();
        assert!((0.33..=0.37).contains(&shift_s), "{shift_s}");
    }

    #[test]
    fn a_burst_after_a_stall_is_late() {
        let mut stream = Stream::new(RULES);
        assert_eq!(stream.in_time(0.0, 40, |_| 0.01), 40);
        // Everything sent within three seconds arrives at once.
        let burst = stream.in_time(1.0, 120, |at_s| 4.0 - at_s);
        // Only what was sent in the last quarter of a second, and its first frame's rounding.
        assert!((10..=11).contains(&burst), "{burst}");
        assert_eq!(stream.in_time(4.1, 40, |_| 0.01), 40);
    }

    #[test]
    fn a_constant_delay_never_becomes_good() {
        let mut stream = Stream::new(RULES);
        assert_eq!(stream.in_time(0.0, 40, |_| 0.01), 40);
        // Ten hours: as long as drift would take to allow for 2 s, three times over.
        assert_eq!(stream.in_time(1.0, 1_440_000, |_| 2.01), 0);
        assert_eq!(stream.in_time(36_010.0, 40, |_| 0.01), 40);
        assert!(stream.clock.shift_s() < 1e-3);
    }

    #[test]
    fn a_growing_delay_is_late_once_beyond_the_bound() {
        let mut stream = Stream::new(RULES);
        assert_eq!(stream.in_time(0.0, 40, |_| 0.0), 40);
        // 20 ms a second: 12.5 s and what drift allows for.
        let growing = stream.in_time(1.0, 8000, |at_s| 0.02 * (at_s - 1.0));
        assert!((500..=506).contains(&growing), "{growing}");
    }

    #[test]
    fn a_jumping_delay_is_late_where_it_is_large() {
        let mut stream = Stream::new(RULES);
        assert_eq!(stream.in_time(0.0, 40, |_| 0.0), 40);
        // Every other second half a second late.
        let lag = |at_s: f64| 0.5 * f64::from(at_s as u32 % 2);
        assert_eq!(stream.in_time(1.0, 4000, lag), 2000);
    }

    #[test]
    fn a_clock_set_ahead_lowers_the_reference() {
        let mut stream = Stream::new(RULES);
        assert_eq!(stream.in_time(0.0, 40, |_| 0.0), 40);
        let late = 80 - stream.in_time(1.0, 80, |_| -500.0);
        assert!((10..=11).contains(&late), "{late}");
        // What follows is measured by it.
        assert_eq!(stream.in_time(3.1, 40, |_| -499.0), 0);
        assert!(stream.clock.shift_s() < 1e-6);
    }

    #[test]
    fn a_clock_set_back_is_followed_on_request() {
        let mut stream = Stream::new(RULES);
        assert_eq!(stream.in_time(0.0, 40, |_| 0.0), 40);
        assert_eq!(stream.in_time(1.0, 4000, |_| 500.0), 0);

        let follows_steps = true;
        let mut stream = Stream::new(ClockRules { follows_steps, ..RULES });
        assert_eq!(stream.in_time(0.0, 40, |_| 0.0), 40);
        let late = 400 - stream.in_time(1.0, 400, |_| 500.0);
        assert!((80..=81).contains(&late), "{late}");
        assert!((stream.clock.shift_s() - 500.0).abs() < 1e-3);
    }

    #[test]
    fn after_a_reconnect_only_steps_are_followed() {
        let mut stream = Stream::new(RULES);
        assert_eq!(stream.in_time(0.0, 40, |_| 0.01), 40);
        stream.clock.reconnect();
        let backlog = stream.in_time(2.0, 120, |at_s| 5.0 - at_s);
        assert!((10..=11).contains(&backlog), "{backlog}");

        stream.clock.reconnect();
        let late = 400 - stream.in_time(6.0, 400, |_| 70.0);
        assert!((80..=81).contains(&late), "{late}");
        assert!((stream.clock.shift_s() - 70.0).abs() < 0.02);
    }

    #[test]
    fn on_a_shared_clock_early_delays_are_late() {
        let mut stream = Stream::new(RULES);
        stream.clock = SenderClock::new(ClockRules {
            shared: Some(Moment {
                timestamp: Timestamp::from_unix(Duration::from_secs(1000)),
                at: stream.start,
            }),
            ..RULES
        });
        assert_eq!(stream.in_time(0.0, 4000, |_| 2.0), 0);
        assert_eq!(stream.in_time(200.0, 40, |_| 0.1), 40);
        let Judged::InTime { latency_s } = stream.judge(202.0, 202.1) else { panic!("in time") };
        assert!((latency_s - 0.1).abs() < 1e-6, "{latency_s}");
        // Ahead of our clock: it is no shared one.
        assert_eq!(stream.in_time(203.0, 400, |_| -1.0), 0);
    }

    #[test]
    fn one_wild_timestamp_moves_nothing() {
        let mut stream = Stream::new(RULES);
        assert_eq!(stream.in_time(0.0, 40, |_| 0.0), 40);
        assert!(matches!(stream.judge(9e8, 1.0), Judged::Early { .. }));
        assert!(matches!(stream.judge(-900.0, 1.0), Judged::Late { by_s } if by_s > BOUND_S));
        assert_eq!(stream.in_time(1.025, 40, |_| 0.0), 40);
        let none = stream.clock.judge(Timestamp::NONE, stream.start);
        assert_eq!(none, Judged::InTime { latency_s: 0.0 });
    }
}
