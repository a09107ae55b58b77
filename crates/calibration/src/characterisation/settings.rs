//! What is characterised, and how recordings are read and matched.

use crate::hand_eye::HandEyeSettings;
use crate::still_pose::Spread;
use crate::time_alignment::AlignmentSettings;
use trackwright_simulation::recording::Recording;

/// Two recordings that belong together.
#[derive(Clone, Debug, PartialEq)]
pub struct RecordedPair {
    /// `tracker_from_sensor`, of any number of sensors.
    pub tracker: Recording,
    /// `reference_from_body`.
    pub reference: Recording,
}

/// What a pair of recordings is of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PairKind {
    Still,
    Path,
}

/// How recordings are read and matched.
#[derive(Clone, Debug, PartialEq)]
pub struct CharacterisationSettings {
    pub hand_eye: HandEyeSettings,
    /// What the pairs are of; by whether the reference stood still where `None`.
    pub kind: Option<PairKind>,
    /// Parts of the names of the sensors that count; all where empty.
    pub sensors: Vec<String>,
    /// A part of the name of the reference's tool, where it has several.
    pub reference_tool: Option<String>,
    /// Ticks a second of the frame counters, for recordings without times.
    pub tracker_ticks_per_s: f64,
    pub reference_ticks_per_s: f64,
    pub alignment: AlignmentSettings,
    /// Readings that are farther from where they should be are left out.
    pub max_error: Spread,
    /// Pairs that frames are found without.
    pub held_out: Option<HeldOut>,
}

/// Every so many-th pair: what of a room can be judged by, because nothing was found from it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct HeldOut {
    /// Which of the parts, from 0.
    pub part: usize,
    /// How many parts there are.
    pub of: usize,
}

impl HeldOut {
    pub(super) fn has(self, pair: usize) -> bool {
        pair % self.of.max(1) == self.part
    }
}

impl CharacterisationSettings {
    /// An Aurora counts 320 ticks a second, a Polaris 60, as recordings of both show.
    pub const TRACKER_TICKS_PER_S: f64 = 320.0;
    pub const REFERENCE_TICKS_PER_S: f64 = 60.0;
    /// Beyond the errors of a field that can be corrected: files that do not belong together, a
    /// body that was touched. The strongly distorted room in docs/methods/characterisation.md has
    /// up to 19 mm and 9°.
    pub const MAX_ERROR_MM: f64 = 50.0;
    pub const MAX_ERROR_DEG: f64 = 30.0;
}

impl Default for CharacterisationSettings {
    fn default() -> Self {
        Self {
            hand_eye: HandEyeSettings::default(),
            kind: None,
            sensors: Vec::new(),
            reference_tool: None,
            tracker_ticks_per_s: Self::TRACKER_TICKS_PER_S,
            reference_ticks_per_s: Self::REFERENCE_TICKS_PER_S,
            alignment: AlignmentSettings::default(),
            max_error: Spread {
                position_mm: Self::MAX_ERROR_MM,
                angle_rad: Self::MAX_ERROR_DEG.to_radians(),
            },
            held_out: None,
        }
    }
}
