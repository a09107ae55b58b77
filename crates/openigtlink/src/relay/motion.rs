//! Where tools were a moment ago, which states to which of two poses one has come.

use std::collections::BTreeMap;
use std::f64::consts::PI;
use std::time::{Duration, Instant};
use trackwright_field::compensation::Compensated;
use trackwright_geometry::pose::{Pose, distances};

/// Hands move and turn tools more slowly than this.
const FASTEST_MM_S: f64 = 500.0;
const FASTEST_RAD_S: f64 = PI;

/// A tool that is still is read so far off.
const JITTER_MM: f64 = 1.0;
const JITTER_RAD: f64 = PI / 180.0;

/// A pose that was seen longer ago states nothing.
const OLDEST: Duration = Duration::from_millis(250);

/// The last pose of each tool.
#[derive(Debug, Default)]
pub(super) struct Motion(BTreeMap<String, (Pose, Instant)>);

impl Motion {
    pub fn saw(&mut self, tool: &str, pose: &Pose, at: Instant) {
        self.0.insert(tool.to_owned(), (*pose, at));
    }

    /// The one pose of an ambiguous answer that a tool can have come to; nothing where it can have come to several or to
    /// none.
    pub fn only(&self, tool: &str, found: &Compensated, at: Instant) -> Option<Pose> {
        let (last, seen) = self.0.get(tool)?;
        let passed = at.checked_duration_since(*seen).filter(|passed| *passed <= OLDEST)?;
        let is_reached = |pose: &Pose| {
            let (mm, rad) = distances(last, pose);
            let seconds = passed.as_secs_f64();
            mm <= JITTER_MM + FASTEST_MM_S * seconds && rad <= JITTER_RAD + FASTEST_RAD_S * seconds
        };
        // Without others it is not known what they are.
        found.others[0]?;
        let all = [found.pose, found.others[0], found.others[1]].into_iter().flatten();
        let mut reached = all.filter(is_reached);
        reached.next().filter(|_| reached.next().is_none())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use trackwright_field::inverse::{Ambiguity, InverseState};

    #[test]
    fn a_tool_goes_no_farther_than_a_hand_moves_it() {
        let start = Instant::now();
        let after = |ms: u64| start + Duration::from_millis(ms);
        let at = |x_mm: f64| Pose::translation(x_mm, 0.0, -300.0);
        let ambiguity = Ambiguity::SecondPreimage { distance_mm: 0.0, angle_rad: 0.0 };
        let found = |one: f64, other: f64| Compensated {
            pose: Some(at(one)),
            others: [Some(at(other)), Some(at(500.0))],
            state: InverseState::Ambiguous(ambiguity),
            is_inside: true,
        };
        let mut motion = Motion::default();
        assert_eq!(motion.only("tool", &found(0.0, 30.0), after(0)), None);
        motion.saw("tool", &at(2.0), after(0));
        assert_eq!(motion.only("tool", &found(3.0, 30.0), after(25)), Some(at(3.0)));
        assert_eq!(motion.only("tool", &found(30.0, 3.0), after(25)), Some(at(3.0)));
        // Both are near enough, neither is, it was seen too long ago, and it is another tool.
        assert_eq!(motion.only("tool", &found(3.0, 12.0), after(25)), None);
        assert_eq!(motion.only("tool", &found(-60.0, 30.0), after(25)), None);
        assert_eq!(motion.only("tool", &found(3.0, 300.0), after(251)), None);
        assert_eq!(motion.only("other", &found(3.0, 30.0), after(25)), None);
    }
}
