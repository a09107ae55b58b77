//! The range of motion with its count of poses, and the requirement.

use crate::widgets::basic::{NumberField, counted, number_ui, quiet_ui, section_ui, warning_ui};
use crate::widgets::tooltip::checkbox_ui;
use crate::workspaces::design::actions::{DesignAction, number_edits};
use crate::workspaces::design::pivot_ui::pivot_ui;
use bevy_egui::egui::{self, Ui, vec2};
use trackwright_design::{BodyRole, Edit};
use trackwright_simulation::{AxisRange, ErrorOf, Metric, Motion, Pivot, Requirement, RigidBody};

/// Width of a field; three stand in a row.
pub(crate) const NARROW: f32 = 66.0;
/// Width of an axis's checkbox with its name.
pub(crate) const AXIS_WIDTH: f32 = 44.0;

/// Where an axis of a motion is.
type AxisOf = fn(&mut Motion) -> &mut Option<AxisRange>;

const AXES: [(&str, bool, AxisOf); 6] = [
    ("x", true, |m| &mut m.x),
    ("y", true, |m| &mut m.y),
    ("z", true, |m| &mut m.z),
    ("rx", false, |m| &mut m.rx),
    ("ry", false, |m| &mut m.ry),
    ("rz", false, |m| &mut m.rz),
];

/// What an axis moves through when it is switched on: mm, and degrees.
const NEW_SHIFT: AxisRange = AxisRange { min: -50.0, max: 50.0, step: 50.0 };
const NEW_TURN: AxisRange = AxisRange { min: -45.0, max: 45.0, step: 45.0 };

/// What a range of motion is of: the design's tool, or the CRF in its own study.
pub(crate) struct MotionOf<'a> {
    pub role: BodyRole,
    pub body: &'a RigidBody,
    /// What the body moves in, in a word.
    pub reference_word: &'static str,
}

impl MotionOf<'_> {
    pub(crate) fn body_word(&self) -> &'static str {
        match self.role {
            BodyRole::Tool => "tool",
            BodyRole::Crf => "CRF",
        }
    }

    pub(crate) fn edit(&self, motion: Motion) -> Edit {
        let motion = (!motion.is_still()).then_some(motion);
        match self.role {
            BodyRole::Tool => Edit::SetMotion(motion),
            BodyRole::Crf => Edit::SetCrfMotion(motion),
        }
    }
}

/// Draws the six axes of a motion, how many poses they make, and what turns are about.
pub(crate) fn motion_ui(ui: &mut Ui, of: &MotionOf, motion: Option<&Motion>) -> Vec<DesignAction> {
    let mut actions = Vec::new();
    section_ui(ui, "Range of motion");
    // A new one turns about the tip: about an origin in its grip the tip would sweep aside.
    let new = Motion { pivot: Pivot::Tip, ..Motion::default() };
    let motion_before = motion.copied().unwrap_or(new);
    ui.horizontal(|ui| {
        ui.spacing_mut().item_spacing.x = 4.0;
        ui.allocate_space(vec2(AXIS_WIDTH, 1.0));
        for head in ["from", "to", "step"] {
            ui.allocate_ui_with_layout(
                vec2(NARROW, 12.0),
                egui::Layout::centered_and_justified(egui::Direction::LeftToRight),
                |ui| quiet_ui(ui, head),
            );
        }
    });
    for (name, is_shift, axis_of) in AXES {
        axis_ui(ui, (of, motion_before), name, is_shift, axis_of, &mut actions);
    }
    if let Some(motion) = motion.filter(|motion| motion.has_turns()) {
        pivot_ui(ui, of, motion, &mut actions);
    }
    match motion.map(Motion::trials) {
        None => quiet_ui(ui, "Does not move: judged at its own pose"),
        Some(Ok(trials)) => quiet_ui(ui, counted(trials, "pose", "poses")),
        Some(Err(error)) => warning_ui(ui, &error.to_string()),
    };
    actions
}

fn axis_ui(
    ui: &mut Ui,
    (of, motion): (&MotionOf, Motion),
    name: &str,
    is_shift: bool,
    axis_of: AxisOf,
    actions: &mut Vec<DesignAction>,
) {
    let with = |range: Option<AxisRange>| {
        let mut after = motion;
        *axis_of(&mut after) = range;
        of.edit(after)
    };
    let mut before = motion;
    let range = *axis_of(&mut before);
    ui.horizontal(|ui| {
        ui.spacing_mut().item_spacing.x = 4.0;
        let mut is_on = range.is_some();
        let size = vec2(AXIS_WIDTH, ui.spacing().interact_size.y);
        ui.allocate_ui_with_layout(size, egui::Layout::left_to_right(egui::Align::Center), |ui| {
            ui.set_min_width(AXIS_WIDTH);
            let about = match is_shift {
                true => "Shifts along the axis, from, to, and in steps of so many mm",
                false => "Turns about the axis, from, to, and in steps of so many degrees",
            };
            if checkbox_ui(ui, &mut is_on, name, about).changed() {
                let new = if is_shift { NEW_SHIFT } else { NEW_TURN };
                actions.push(DesignAction::apply(with(is_on.then_some(new))));
            }
        });
        let Some(range) = range else { return };
        type Part = fn(&mut AxisRange) -> &mut f64;
        let parts: [(&str, Part); 3] =
            [("from", |r| &mut r.min), ("to", |r| &mut r.max), ("step", |r| &mut r.step)];
        for (part, value_of) in parts {
            let unit_name = if is_shift { "mm" } else { "degrees" };
            let field_name = format!("{name} {part} in {unit_name}");
            let field = if is_shift {
                NumberField::length(&field_name)
            } else {
                NumberField::angle(&field_name)
            };
            // The ends of a range never pass each other.
            let (min, max) = match part {
                "from" => (field.min, range.max),
                "to" => (range.min, field.max),
                _ => (0.0, field.max),
            };
            let field = NumberField { decimals: 1, speed: 0.5, min, max, ..field.width(NARROW) };
            let mut before = range;
            let changes = number_ui(ui, &field, *value_of(&mut before));
            number_edits(&changes, actions, "Change range of motion", |v| {
                let mut range = range;
                *value_of(&mut range) = v;
                Some(with(Some(range)))
            });
        }
    });
}

/// Draws the bounds that a design, or its CRF alone, can be held against.
pub fn requirement_ui(
    ui: &mut Ui,
    of: BodyRole,
    requirement: Option<&Requirement>,
) -> Vec<DesignAction> {
    let mut actions = Vec::new();
    section_ui(ui, "Requirement: at most");
    let before = requirement.copied().unwrap_or_default();
    for metric in Metric::bounded() {
        let name = metric.label();
        let with = |bound: Option<f64>| {
            let after = before.with(metric, bound);
            let after = (!after.is_empty()).then_some(after);
            match of {
                BodyRole::Tool => Edit::SetRequirement(after),
                BodyRole::Crf => Edit::SetCrfRequirement(after),
            }
        };
        let bound = before.bound(metric);
        ui.horizontal(|ui| {
            let mut is_on = bound.is_some();
            if checkbox_ui(ui, &mut is_on, name, metric.about()).changed() {
                let new = metric.first_bound().filter(|_| is_on);
                actions.push(DesignAction::apply(with(new)));
            }
            let Some(bound) = bound else { return };
            ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
                let field_name = format!("{name} at most");
                let field = match metric.of {
                    ErrorOf::Position => NumberField::length(&field_name),
                    ErrorOf::Angle => NumberField::angle(&field_name),
                };
                let field = NumberField { speed: 0.01, ..field.positive() };
                let changes = number_ui(ui, &field, bound);
                number_edits(&changes, &mut actions, "Change requirement", |v| Some(with(Some(v))));
            });
        });
    }
    actions
}
