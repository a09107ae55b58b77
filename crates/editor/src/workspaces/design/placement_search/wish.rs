//! What a search for better places may move and what it makes least, as a person chose it.

use crate::widgets::basic::{count, counted};
use nalgebra::Vector3;
use std::collections::BTreeSet;
use trackwright_design::{BodyRole, Design};
use trackwright_optimization::{BuiltError, Goal, Moves, OverRooms, PoseBounds, SensorChoice};
use trackwright_project::{MOST_SETS, sets_of_sensors};
use trackwright_simulation::{Metric, Sensor};

/// Most sensors that a search may give a body.
pub const MOST_SENSORS: usize = 8;

/// Most kinds that they may be of.
pub const MOST_KINDS: usize = 6;

/// Most that a sensor may cost.
pub const MOST_COST: f64 = 1e6;

const NEW_KIND: SensorChoice = SensorChoice { degrees_of_freedom: 5, coil: None, cost: 1.0 };

/// What is searched for.
#[derive(Clone, Debug, PartialEq)]
pub struct Wish {
    /// Numbers of the sensors that may move.
    pub tool: BTreeSet<usize>,
    pub crf: BTreeSet<usize>,
    pub generator: Reach,
    /// Of the CRF on the patient.
    pub crf_pose: Reach,
    /// Fewest and most sensors; as many as there are where absent.
    pub counts: Option<[usize; 2]>,
    /// Kinds that those may be of whose number may be another one; as they are where there are none.
    pub kinds: Vec<SensorChoice>,
    /// The figure that is made least; the ratio to the requirement where absent.
    pub figure: Option<Metric>,
    pub rooms: OverRooms,
    /// What built sensors are off by.
    pub built: BuiltError,
}

/// Whether a pose may move, and how far to either side.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reach {
    pub is_free: bool,
    pub shift_mm: f64,
    pub turn_deg: f64,
}

impl Reach {
    const GENERATOR: Self = Self { is_free: false, shift_mm: 50.0, turn_deg: 10.0 };
    const CRF: Self = Self { is_free: false, shift_mm: 10.0, turn_deg: 5.0 };
    /// Over a patch, which bounds the way by itself.
    const CRF_ON_PATCH: Self = Self { shift_mm: 200.0, turn_deg: 10.0, ..Self::CRF };

    fn bounds(self) -> Option<PoseBounds> {
        let shift_mm = Vector3::repeat(self.shift_mm);
        self.is_free.then_some(PoseBounds { shift_mm, turn_deg: self.turn_deg })
    }
}

/// Whether the design states where on the patient the CRF may stand.
pub fn has_crf_patch(design: &Design) -> bool {
    design.anatomy.iter().any(|anatomy| !anatomy.crf_patch.is_empty())
}

impl Wish {
    /// All sensors of a design's tool, by its requirement.
    pub fn of(design: &Design) -> Self {
        Self::of_body(design, BodyRole::Tool)
    }

    /// All sensors of one body, by the design's requirement.
    pub fn of_body(design: &Design, role: BodyRole) -> Self {
        let sensors = design.body(role).map_or(0, |body| body.rigid.sensors.len());
        let mut wish = Self {
            tool: BTreeSet::new(),
            crf: BTreeSet::new(),
            generator: Reach::GENERATOR,
            crf_pose: match has_crf_patch(design) {
                true => Reach::CRF_ON_PATCH,
                false => Reach::CRF,
            },
            counts: None,
            kinds: Vec::new(),
            figure: None,
            rooms: OverRooms::default(),
            built: BuiltError::default(),
        };
        *wish.numbers_mut(role) = (0..sensors).collect();
        wish
    }

    pub fn numbers(&self, role: BodyRole) -> &BTreeSet<usize> {
        match role {
            BodyRole::Tool => &self.tool,
            BodyRole::Crf => &self.crf,
        }
    }

    pub fn numbers_mut(&mut self, role: BodyRole) -> &mut BTreeSet<usize> {
        match role {
            BodyRole::Tool => &mut self.tool,
            BodyRole::Crf => &mut self.crf,
        }
    }

    /// Whose number of sensors may be another one: the tool's, or the CRF's where none of the tool's
    /// move.
    pub fn counted(&self) -> Option<BodyRole> {
        [BodyRole::Tool, BodyRole::Crf].into_iter().find(|role| !self.numbers(*role).is_empty())
    }

    /// The first of them, which those are like that are added.
    pub fn first_moving<'d>(&self, design: &'d Design) -> Option<&'d Sensor> {
        let role = self.counted()?;
        let number = self.numbers(role).first()?;
        design.body(role)?.rigid.sensors.get(*number)
    }

    /// Adds a kind with other degrees of freedom than the last, at the same cost.
    pub fn add_kind(&mut self, design: &Design) {
        let first = self.first_moving(design);
        let new = match (self.kinds.last(), first.map(|own| own.orientation.degrees_of_freedom())) {
            (Some(last), _) => SensorChoice {
                degrees_of_freedom: if last.degrees_of_freedom == 5 { 6 } else { 5 },
                ..*last
            },
            (None, Some(6)) => SensorChoice { degrees_of_freedom: 6, ..NEW_KIND },
            (None, _) => NEW_KIND,
        };
        self.kinds.push(new);
    }

    /// What may move of a design.
    pub fn moves(&self, design: &Design) -> Moves {
        let numbers = |role: BodyRole| {
            let sensors = design.body(role).map_or(0, |body| body.rigid.sensors.len());
            self.numbers(role).iter().copied().filter(|number| *number < sensors).collect()
        };
        let has_counted = self.counted().is_some();
        let counts = self.counts.filter(|_| has_counted);
        Moves {
            tool: numbers(BodyRole::Tool),
            crf: numbers(BodyRole::Crf),
            sensors: counts.map(|[least, most]| least..=most),
            kinds: if has_counted { self.kinds.clone() } else { Vec::new() },
            generator: self.generator.bounds(),
            crf_pose: self.crf_pose.bounds().filter(|_| design.crf.is_some()),
        }
    }

    /// What is made least; `None` where that is the ratio to a requirement that the design lacks.
    pub fn goal(&self, design: &Design) -> Option<Goal> {
        match self.figure {
            Some(metric) => Some(Goal::Figure(metric)),
            None => design.requirement.filter(|own| !own.is_empty()).map(Goal::Requirement),
        }
    }

    /// What moves, what is made least and over which rooms, in a line:
    /// `2 sensors of the tool, field generator · tip RMS · worst room`.
    pub fn summary(&self, design: &Design) -> String {
        let moves = self.moves(design);
        let sensors = |numbers: &[usize], of: &str| {
            (!numbers.is_empty())
                .then(|| format!("{} of the {of}", counted(numbers.len(), "sensor", "sensors")))
        };
        let moved: Vec<String> = [
            sensors(&moves.tool, "tool"),
            sensors(&moves.crf, "CRF"),
            moves.crf_pose.map(|_| "CRF on the patient".to_owned()),
            moves.generator.map(|_| "field generator".to_owned()),
        ]
        .into_iter()
        .flatten()
        .collect();
        let moved = match moved.is_empty() {
            true => "nothing moves".to_owned(),
            false => moved.join(", "),
        };
        let figure = self.figure.map_or("ratio to the requirement", |metric| metric.label());
        let rooms = match (design.procedure.further_rooms.is_empty(), self.rooms) {
            (true, _) => "",
            (false, OverRooms::Worst) => " · worst room",
            (false, OverRooms::Mean) => " · mean over the rooms",
        };
        format!("{moved} · {figure}{rooms}")
    }

    /// Why nothing can be searched, in a sentence.
    pub fn refusal(&self, design: &Design) -> Option<String> {
        let moves = self.moves(design);
        let has_sensors = !(moves.tool.is_empty() && moves.crf.is_empty());
        if !has_sensors && moves.generator.is_none() && moves.crf_pose.is_none() {
            let why = "Nothing may move: choose a sensor, the CRF or the field generator";
            return Some(why.to_owned());
        }
        if self.goal(design).is_none() {
            let why = "The design has no requirement: state one, or choose a figure";
            return Some(why.to_owned());
        }
        let sets = sets_of_sensors(design, &moves);
        (sets > MOST_SETS).then(|| {
            let sets = count(usize::try_from(sets).unwrap_or(usize::MAX));
            format!(
                "These kinds and numbers make {sets} sets of sensors, expected at most {MOST_SETS}: \
                 choose fewer kinds or numbers"
            )
        })
    }
}
