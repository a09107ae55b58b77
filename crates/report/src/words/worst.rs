//! How the tool is held in one trial, compared with its pose in the design and with the field
//! generator: measured first, then put into words that hold for these numbers.

use trackwright_simulation::scenario::InputTrial;
use trackwright_simulation::{Mode, Scenario, shaft_in_body};

/// Turns and tilts below this are no more than a hand's own unrest.
const LEAST_TURN_DEG: f64 = 5.0;

/// Shifts below this are not mentioned.
const LEAST_SHIFT_MM: f64 = 1.0;

/// A shaft this close to parallel with the generator's front is called flat to it, and one this
/// close to upright on it points at it.
const FLAT_DEG: f64 = 15.0;

/// Where the tool is in a trial.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WorstPose {
    /// Angle of the shaft with the plane of the generator's front, 0 to 90; `None` of a body
    /// without a shaft.
    pub shaft_elevation_deg: Option<f64>,
    /// Whether the tip is the end of the shaft that is nearer to the generator.
    pub tip_is_nearer: bool,
    /// Between the shaft and that of the design, in the CRF; of a body without a shaft the whole
    /// turn.
    pub tilt_deg: f64,
    /// About the shaft, in the CRF, -180 to 180; 0 of a body without a shaft.
    pub twist_deg: f64,
    /// How much farther than in the design the tip is from the plane of the generator's front.
    pub farther_mm: f64,
    /// How far the tip is from its place in the design, along that plane.
    pub aside_mm: f64,
    /// Whether the study turns and moves the tool at all.
    pub has_turns: bool,
    pub has_shifts: bool,
}

/// Measures a trial against the design.
pub fn worst_pose(scenario: &Scenario, mode: &Mode, trial: &InputTrial) -> WorstPose {
    let own_crf = scenario.tracker_from_crf();
    let trial_crf = match &scenario.crf {
        None => own_crf,
        Some(_) => trial.tracker_from_crf.unwrap_or(own_crf),
    };
    let tip = scenario.tool.judged_tip_in_body();
    let design_tip = own_crf * scenario.crf_from_tool * tip;
    let trial_tip = trial_crf * trial.crf_from_tool * tip;
    let shift = trial_tip - design_tip;
    let turn = trial.crf_from_tool.rotation * scenario.crf_from_tool.rotation.inverse();
    let shaft = shaft_in_body(&scenario.tool);
    let (tilt_rad, twist_rad) = match &shaft {
        None => (turn.angle(), 0.0),
        Some(shaft) => {
            let before = scenario.crf_from_tool.rotation * shaft;
            let after = trial.crf_from_tool.rotation * shaft;
            // Swing and twist: the turn's part about the shaft as the design has it.
            let along = turn.imag().dot(&before);
            let twist = 2.0 * along.atan2(turn.w);
            (before.angle(&after), wrapped(twist))
        }
    };
    let in_tracker = shaft.map(|shaft| trial_crf.rotation * trial.crf_from_tool.rotation * shaft);
    let (has_shifts, has_turns) = match mode {
        Mode::Single => (false, false),
        Mode::Input(_) => (true, true),
        Mode::Motion => axes_that_move(scenario),
    };
    WorstPose {
        shaft_elevation_deg: in_tracker
            .map(|shaft| shaft.z.abs().clamp(0.0, 1.0).asin().to_degrees()),
        // The shaft leads away from the tip, the volume is at negative z.
        tip_is_nearer: in_tracker.is_some_and(|shaft| shaft.z < 0.0),
        tilt_deg: tilt_rad.to_degrees(),
        twist_deg: twist_rad.to_degrees(),
        farther_mm: -shift.z,
        aside_mm: shift.xy().norm(),
        has_turns,
        has_shifts,
    }
}

/// Whether the range of motion has more than one position, and more than one orientation.
fn axes_that_move(scenario: &Scenario) -> (bool, bool) {
    let grid = scenario.motion_grid().ok().flatten();
    grid.map_or((false, false), |grid| {
        let orientations = grid.orientations();
        (grid.trials() > orientations, orientations > 1)
    })
}

/// An angle as one from minus to plus half a turn.
fn wrapped(angle_rad: f64) -> f64 {
    use std::f64::consts::{PI, TAU};
    (angle_rad + PI).rem_euclid(TAU) - PI
}

impl WorstPose {
    /// How the tool is held, to follow "the tool"; `None` where the study neither turns nor moves
    /// it far enough.
    pub fn in_short(&self) -> Option<String> {
        self.posture().or_else(|| self.shift_words().into_iter().next())
    }

    /// How the tool is held and where, to follow "the worst is".
    pub fn in_full(&self) -> String {
        let posture = self.posture().filter(|_| self.is_flat() || self.is_upright());
        let parts: Vec<String> =
            posture.into_iter().chain(self.turn_words()).chain(self.shift_words()).collect();
        match parts.split_last() {
            None => "with the tool held likewise".to_owned(),
            Some((last, [])) => format!("with the tool {last}"),
            Some((last, others)) => format!("with the tool {} and {last}", others.join(", ")),
        }
    }

    fn is_flat(&self) -> bool {
        self.shaft_elevation_deg.is_some_and(|elevation| elevation <= FLAT_DEG)
    }

    fn is_upright(&self) -> bool {
        self.shaft_elevation_deg.is_some_and(|elevation| elevation >= 90.0 - FLAT_DEG)
    }

    fn posture(&self) -> Option<String> {
        if !self.has_turns {
            return None;
        }
        if self.is_flat() {
            return Some("held flat to the field generator".to_owned());
        }
        if self.is_upright() {
            let word = if self.tip_is_nearer { "at" } else { "away from" };
            return Some(format!("pointing straight {word} the field generator"));
        }
        let turns = self.turn_words().join(" and ");
        Some(match turns.is_empty() {
            true => "held as in the design".to_owned(),
            false => turns,
        })
    }

    fn turn_words(&self) -> Vec<String> {
        let mut words = Vec::new();
        if !self.has_turns {
            return words;
        }
        if self.tilt_deg >= LEAST_TURN_DEG {
            let verb = match self.shaft_elevation_deg {
                Some(_) => "tilted",
                None => "turned",
            };
            words.push(format!("{verb} by {:.0}°", self.tilt_deg));
        }
        if self.twist_deg.abs() >= LEAST_TURN_DEG {
            words.push(format!("turned by {:.0}° about its shaft", self.twist_deg.abs()));
        }
        words
    }

    fn shift_words(&self) -> Vec<String> {
        let mut words = Vec::new();
        if !self.has_shifts {
            return words;
        }
        if self.farther_mm.abs() >= LEAST_SHIFT_MM {
            let word = match self.farther_mm > 0.0 {
                true => "farther from",
                false => "nearer to",
            };
            let by_mm = self.farther_mm.abs();
            words.push(format!("{by_mm:.0}\u{2009}mm {word} the field generator"));
        }
        if self.aside_mm >= LEAST_SHIFT_MM {
            words.push(format!("{:.0}\u{2009}mm aside", self.aside_mm));
        }
        words
    }
}
