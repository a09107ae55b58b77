//! Holds the search while frames follow each other, so that it never slows the hand.
//!
//! A search uses all processors, as does software that draws. Frames that follow each other mean that
//! somebody drags or orbits; a single frame, such as the one that shows a better layout, holds nothing.

use crate::workspaces::design::placement_search::state::PlacementSearch;
use bevy::prelude::*;
use std::time::{Duration, Instant};

/// A frame that comes so soon after another follows it, also where the search slowed it down.
const FOLLOWING: Duration = Duration::from_millis(400);

/// How long a frame holds the search: until the next one, at 5 frames a second or more.
const HELD: Duration = Duration::from_millis(200);

/// Where frames never end, as with live poses, the search has a twentieth of the time.
const LONGEST_HELD: Duration = Duration::from_millis(1_900);
const BETWEEN: Duration = Duration::from_millis(100);

/// Frames as the search has to give way to them.
#[derive(Default)]
pub(super) struct Frames {
    last: Option<Instant>,
    /// Since when the search is held without a break, or when its break began.
    held_since: Option<Instant>,
}

impl Frames {
    /// How long the search is held from this frame on.
    fn hold(&mut self, now: Instant) -> Duration {
        let is_following = self.last.is_some_and(|last| now.duration_since(last) < FOLLOWING);
        self.last = Some(now);
        if !is_following {
            self.held_since = None;
            return Duration::ZERO;
        }
        let since = *self.held_since.get_or_insert(now);
        let held = now.duration_since(since);
        if held < LONGEST_HELD {
            return HELD;
        }
        if held >= LONGEST_HELD + BETWEEN {
            self.held_since = Some(now);
        }
        Duration::ZERO
    }
}

pub(super) fn give_way(search: Res<PlacementSearch>, mut frames: Local<Frames>) {
    search.hold.hold_for(frames.hold(Instant::now()));
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What frames at these times, ms, hold the search for, ms.
    fn held(times_ms: impl Iterator<Item = u64>) -> Vec<u128> {
        let (mut frames, start) = (Frames::default(), Instant::now());
        times_ms.map(|ms| frames.hold(start + Duration::from_millis(ms)).as_millis()).collect()
    }

    #[test]
    fn a_single_frame_holds_nothing() {
        assert_eq!(held([0, 1_000, 2_000].into_iter()), [0, 0, 0]);
    }

    #[test]
    fn frames_that_follow_each_other_hold() {
        assert_eq!(held([0, 40, 80, 1_000, 1_040].into_iter()), [0, 200, 200, 0, 200]);
    }

    #[test]
    fn endless_frames_leave_a_twentieth_of_the_time() {
        // Ten seconds of frames of 20 ms.
        let all = held((0..500).map(|k| 20 * k));
        let free = all.iter().filter(|ms| **ms == 0).count();
        assert!((20..=30).contains(&free), "{free}");
    }
}
