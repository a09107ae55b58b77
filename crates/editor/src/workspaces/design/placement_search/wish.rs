//! What a search for better places may move and what it makes least, as a person chose it.

use crate::widgets::basic::counted;
use nalgebra::Vector3;
use std::collections::BTreeSet;
use trackwright_design::{BodyRole, Design};
use trackwright_optimization::{Goal, Moves, OverRooms, PoseBounds};
use trackwright_simulation::Metric;

/// Most sensors that a search may give a body.
pub const MOST_SENSORS: usize = 8;

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
    /// The figure that is made least; the ratio to the requirement where absent.
    pub figure: Option<Metric>,
    pub rooms: OverRooms,
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

    fn bounds(self) -> Option<PoseBounds> {
        let shift_mm = Vector3::repeat(self.shift_mm);
        self.is_free.then_some(PoseBounds { shift_mm, turn_deg: self.turn_deg })
    }
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
            crf_pose: Reach::CRF,
            counts: None,
            figure: None,
            rooms: OverRooms::default(),
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

    /// What may move of a design.
    pub fn moves(&self, design: &Design) -> Moves {
        let numbers = |role: BodyRole| {
            let sensors = design.body(role).map_or(0, |body| body.rigid.sensors.len());
            self.numbers(role).iter().copied().filter(|number| *number < sensors).collect()
        };
        let counts = self.counts.filter(|_| self.counted().is_some());
        Moves {
            tool: numbers(BodyRole::Tool),
            crf: numbers(BodyRole::Crf),
            sensors: counts.map(|[least, most]| least..=most),
            kinds: Vec::new(),
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
    pub fn refusal(&self, design: &Design) -> Option<&'static str> {
        let moves = self.moves(design);
        let has_sensors = !(moves.tool.is_empty() && moves.crf.is_empty());
        if !has_sensors && moves.generator.is_none() && moves.crf_pose.is_none() {
            return Some("Nothing may move: choose a sensor, the CRF or the field generator");
        }
        if self.goal(design).is_none() {
            return Some("The design has no requirement: state one, or choose a figure");
        }
        None
    }
}
