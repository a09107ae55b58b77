//! The panels of the Design workspace as systems: each reads what it shows and writes what is
//! requested in it.

use crate::document::body_files::BodyLoading;
use crate::document::meshes::MeshLoading;
use crate::document::requests::{EditRequest, OpenWorld};
use crate::document::selection::{Hovered, Selected, Selection};
use crate::document::trials::TrialChoice;
use crate::runner::results::Results;
use crate::shell::commands::{Availability, Command};
use crate::shell::requests::Requests;
use crate::shell::window::Workspace;
use crate::viewport::coil_fit::{CoilFindings, ShownFindings};
use crate::widgets::basic::THIN_SPACE;
use crate::workspaces::design::actions::{DesignRequests, HoveredRow};
use crate::workspaces::design::baseline::Baseline;
use crate::workspaces::design::body_file_ui::{BodyFileView, body_file_ui};
use crate::workspaces::design::history_ui::history_ui;
use crate::workspaces::design::inspector::{InspectorView, inspector_ui};
use crate::workspaces::design::mesh_ui::{MeshView, mesh_ui};
use crate::workspaces::design::metal_facts_ui::{MetalFacts, metal_facts_ui};
use crate::workspaces::design::missed::Missed;
use crate::workspaces::design::outliner::outliner_ui;
use crate::workspaces::design::outliner_row::OutlinerView;
use crate::workspaces::design::result::{
    self, ResultView, are_figures_old, brief_result_ui, result_ui,
};
use crate::workspaces::study::state::{Side, StudyState};
use bevy::ecs::system::SystemParam;
use bevy::prelude::*;
use bevy_egui::egui::{Panel, Ui};
use trackwright_project::MeshOwner;
use trackwright_simulation::Verdict;

/// Bodies with their sensors and tips, the anatomy, the room.
pub(crate) fn outliner_panel(
    mut ui: InMut<Ui>,
    (world, results, coils): (Res<OpenWorld>, Res<Results>, Option<Res<CoilFindings>>),
    (selection, hovered): (Res<Selection>, Res<Hovered>),
    available: Availability,
    mut row: ResMut<HoveredRow>,
    mut requests: DesignRequests,
    mut commands: Commands,
) {
    let document = &world.0.document;
    let situation = available.situation();
    let view = OutlinerView {
        design: document.design(),
        environment: &world.0.environment,
        view: document.view(),
        selection: &selection,
        hovered: hovered.0,
        is_available: &|command: &Command| situation.allows(command),
        pose: results.pose.as_ref().map(|pose| &pose.value),
        coils: ShownFindings::new(coils.as_deref()),
        metal_problem: world.0.metal_problem().map(|problem| &**problem),
    };
    let actions = outliner_ui(&mut ui, &view);
    row.bypass_change_detection().follow(&actions, &mut commands);
    requests.write(actions);
}

/// The list of steps, at the foot of its side.
pub(crate) fn history_panel(
    mut ui: InMut<Ui>,
    world: Res<OpenWorld>,
    mut requests: Requests<EditRequest>,
) {
    requests.write_all(history_ui(&mut ui, &world.0.document.history()));
}

/// The numbers of what is selected.
pub(crate) fn inspector_panel(
    mut ui: InMut<Ui>,
    (world, results, coils): (Res<OpenWorld>, Res<Results>, Option<Res<CoilFindings>>),
    selection: Res<Selection>,
    (meshes, bodies): (Option<Res<MeshLoading>>, Option<Res<BodyLoading>>),
    available: Availability,
    mut requests: DesignRequests,
) {
    let situation = available.situation();
    let view = InspectorView {
        design: world.0.document.design(),
        selection: &selection,
        is_available: &|command: &Command| situation.allows(command),
        pose: results.pose.as_ref().map(|pose| &pose.value),
        coils: ShownFindings::new(coils.as_deref()),
        derived_weight: world.0.environment.orientation_weight(None),
    };
    requests.write(inspector_ui(&mut ui, &view));
    let whose = match selection.primary() {
        Some(Selected::Body(role)) => {
            let view = bodies.as_ref().and_then(|own| BodyFileView::of(&world.0, role, own));
            requests.write(view.map_or_else(Vec::new, |view| body_file_ui(&mut ui, &view)));
            MeshOwner::Body(role)
        }
        Some(Selected::Anatomy(index)) => MeshOwner::Anatomy(Some(index)),
        Some(Selected::Metal(index)) => {
            if let Some(facts) = MetalFacts::of(&world.0, index) {
                metal_facts_ui(&mut ui, &facts);
            }
            return;
        }
        _ => return,
    };
    let view = meshes.as_ref().and_then(|own| MeshView::of(&world.0, whose, own));
    requests.write(view.map_or_else(Vec::new, |view| mesh_ui(&mut ui, &view)));
}

/// What the figures of the result are drawn from.
#[derive(SystemParam)]
pub(crate) struct ShownResult<'w> {
    world: Res<'w, OpenWorld>,
    results: Res<'w, Results>,
    baseline: Option<Res<'w, Baseline>>,
    missed: Option<Res<'w, Missed>>,
    choice: Res<'w, TrialChoice>,
    state: Option<Res<'w, StudyState>>,
    workspace: Res<'w, Workspace>,
}

impl ShownResult<'_> {
    /// What is shown at the foot of a side of this height, points.
    fn view(&self, height: f32) -> ResultView<'_> {
        let (document, results) = (&self.world.0.document, &*self.results);
        let study = results.study.as_ref();
        let now = study.and_then(|study| study.value.figures.headline());
        let change = now.zip(self.baseline.as_ref());
        let change = change.and_then(|(now, baseline)| baseline.change(&self.world.0, now));
        // While something is dragged what was found is of the design as it was.
        let sources = self.missed.as_ref().and_then(|missed| missed.sources());
        let sources = sources.filter(|_| results.is_whole());
        let requirement = study.and_then(|study| study.value.figures.requirement.as_ref());
        let bound = now.zip(requirement).and_then(|(now, own)| own.bound(now.metric));
        let reasons = bound
            .filter(|bound| bound.verdict == Verdict::Missed)
            .zip(sources)
            .map(|(bound, sources)| sources.words(bound.metric.of, &THIN_SPACE.to_string()));
        ResultView {
            results,
            change,
            reasons: reasons.unwrap_or_default(),
            is_computing: study.is_some() && are_figures_old(document, results, &self.choice),
            is_short: height < LEAST_HEIGHT
                || self.workspace.charts_trials
                    && self.state.as_ref().is_some_and(|state| state.side == Side::Trials),
        }
    }
}

/// In a lower side all figures would leave no room for what is above them, points.
const LEAST_HEIGHT: f32 = 480.0;

/// The figures, at the foot of the side.
pub(crate) fn result_panel(mut ui: InMut<Ui>, shown: ShownResult) {
    let view = shown.view(ui.available_height());
    Panel::bottom("result")
        .resizable(false)
        .frame(result::frame())
        .show(&mut ui, |ui| result_ui(ui, &view));
}

/// The few figures that decide, at the foot of a side that shows something else.
pub(crate) fn brief_result_panel(mut ui: InMut<Ui>, shown: ShownResult) {
    let view = shown.view(ui.available_height());
    Panel::bottom("result in room")
        .resizable(false)
        .frame(result::frame())
        .show(&mut ui, |ui| brief_result_ui(ui, &view));
}
