//! How the selected metal object is simulated: skin depth, triangles, the model that answers for it.

use crate::widgets::basic::{count, counted, decimal, fact_ui, length, quiet_ui, section_ui};
use crate::widgets::basic::{warning_ui, with_unit};
use crate::workspaces::design::metal_ui::HZ_PER_KHZ;
use bevy_egui::egui::Ui;
use trackwright_metal::furnished::ObjectReport;
use trackwright_metal::setup::{MetalObject, ObjectShape, RoomMetal};
use trackwright_project::World;
use trackwright_report::words::model_words;
use trackwright_simulation::figures::capitalised;

/// What is known of an object beside its fields.
#[derive(Clone, Debug, PartialEq)]
pub struct MetalFacts {
    /// At the room's frequency; infinite where no currents flow.
    pub skin_depth_mm: f64,
    pub frequency_hz: f64,
    pub is_sphere: bool,
    /// `None` until it is solved for.
    pub report: Option<ObjectReport>,
    /// Why the room's metal cannot be simulated as it is.
    pub problem: Option<String>,
    /// Whether the room was measured, and the metal's errors are added to those it has.
    pub is_added_to_errors: bool,
}

impl MetalFacts {
    /// `None` where there is no such object.
    pub fn of(world: &World, index: usize) -> Option<Self> {
        let design = world.document.design();
        let (metal, object) = (design.room_metal.as_ref()?, design.metal_object(index)?);
        let problem = world.metal_problem().map(ToString::to_string);
        let solved = world.solved_metal().filter(|_| problem.is_none());
        let solved = solved.filter(|(_, solved)| is_of(solved, index, metal, object));
        let report = solved.map(|(furnished, _)| &furnished.report);
        Some(Self {
            skin_depth_mm: object.material.material().skin_depth_mm(metal.frequency_hz),
            frequency_hz: metal.frequency_hz,
            is_sphere: matches!(object.shape, ObjectShape::Sphere { .. }),
            report: report.and_then(|report| report.objects.get(index).cloned()),
            problem,
            is_added_to_errors: report.is_some_and(|report| report.is_added_to_errors),
        })
    }
}

/// Whether what was solved has this object, wherever it was then.
fn is_of(solved: &RoomMetal, index: usize, metal: &RoomMetal, object: &MetalObject) -> bool {
    let tracker_from_object = object.tracker_from_object;
    let there = solved.objects.get(index).cloned();
    let there = there.map(|there| MetalObject { tracker_from_object, ..there });
    solved.frequency_hz == metal.frequency_hz && there.as_ref() == Some(object)
}

/// Draws the section.
pub fn metal_facts_ui(ui: &mut Ui, facts: &MetalFacts) {
    section_ui(ui, "How it is simulated");
    if let Some(problem) = &facts.problem {
        warning_ui(ui, &capitalised(problem));
        quiet_ui(ui, "There are no figures until it is moved or changed");
    }
    let frequency = with_unit(&decimal(facts.frequency_hz / HZ_PER_KHZ, 3), "kHz");
    let depth = match facts.skin_depth_mm.is_finite() {
        true => length(facts.skin_depth_mm),
        false => "no currents flow".to_owned(),
    };
    fact_ui(ui, &format!("skin depth at {frequency}"), &depth);
    let Some(report) = &facts.report else {
        if facts.problem.is_none() {
            quiet_ui(ui, "Being solved for");
        }
        return;
    };
    if !facts.is_sphere {
        quiet_ui(ui, triangles_words(report));
    }
    quiet_ui(ui, capitalised(&model_words(&report.model)));
    if facts.is_added_to_errors {
        quiet_ui(
            ui,
            "The room was measured: the metal's errors are added to its own, and what it does to the \
             metal that was there is left out",
        );
    }
}

/// `992 triangles, coarsened from 20,480`.
fn triangles_words(report: &ObjectReport) -> String {
    let own = counted(report.triangles, "triangle", "triangles");
    match report.coarsened_from {
        Some(before) => format!("{own}, coarsened from {}", count(before)),
        None => own,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use trackwright_metal::body::ResponseModel;

    #[test]
    fn triangles_are_counted_with_those_of_the_file() {
        let report = ObjectReport {
            name: "table".to_owned(),
            triangles: 992,
            coarsened_from: Some(20_480),
            model: ResponseModel::SphereSeries,
        };
        assert_eq!(triangles_words(&report), "992 triangles, coarsened from 20,480");
    }
}
