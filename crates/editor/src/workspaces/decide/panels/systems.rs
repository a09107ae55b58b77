//! The panels of the Decide workspace as systems.

use crate::document::requests::OpenWorld;
use crate::document::state::WorldGeneration;
use crate::runner::results::Results;
use crate::shell::requests::Requests;
use crate::workspaces::decide::against::Against;
use crate::workspaces::decide::judged::Judged;
use crate::workspaces::decide::panels::DecideView;
use crate::workspaces::decide::panels::baseline_ui::baseline_ui;
use crate::workspaces::decide::panels::steps_ui::steps_ui;
use crate::workspaces::decide::panels::table_ui::table_ui;
use crate::workspaces::decide::requests::DecideRequest;
use crate::workspaces::decide::state::DecideState;
use crate::workspaces::field::state::FieldState;
use bevy::ecs::system::SystemParam;
use bevy::prelude::*;
use bevy_egui::egui::Ui;

/// What the panels show.
#[derive(SystemParam)]
pub(crate) struct Shown<'w> {
    world: Res<'w, OpenWorld>,
    generation: Res<'w, WorldGeneration>,
    results: Res<'w, Results>,
    state: Res<'w, DecideState>,
    against: Option<Res<'w, Against>>,
    judged: Option<Res<'w, Judged>>,
    field: Option<Res<'w, FieldState>>,
}

impl Shown<'_> {
    fn view(&self) -> DecideView<'_> {
        let field = self.field.as_ref();
        DecideView {
            document: &self.world.0.document,
            generation: self.generation.0,
            results: &self.results,
            state: &self.state,
            against: self.against.as_deref(),
            judged: self.judged.as_deref(),
            environment: &self.world.0.environment.name,
            rooms: field.map_or(&[], |field| &field.rooms),
            is_listing: field.is_some_and(|field| field.listing.is_some()),
        }
    }
}

/// The procedure.
pub(crate) fn steps_panel(mut ui: InMut<Ui>, shown: Shown, mut requests: Requests<DecideRequest>) {
    requests.write_all(steps_ui(&mut ui, &shown.view()));
}

/// The design beside the baseline.
pub(crate) fn baseline_panel(
    mut ui: InMut<Ui>,
    shown: Shown,
    mut requests: Requests<DecideRequest>,
) {
    requests.write_all(baseline_ui(&mut ui, &shown.view()));
}

/// Designs and rooms in one table.
pub(crate) fn table_panel(mut ui: InMut<Ui>, shown: Shown, mut requests: Requests<DecideRequest>) {
    requests.write_all(table_ui(&mut ui, &shown.view()));
}
