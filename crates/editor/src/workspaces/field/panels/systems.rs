//! The panels of the Field workspace as systems.

use crate::document::requests::OpenWorld;
use crate::document::state::WorldGeneration;
use crate::shell::requests::Requests;
use crate::workspaces::field::panels::fit_quality::{comparison_ui, fit_quality_ui};
use crate::workspaces::field::panels::metal::metal_ui;
use crate::workspaces::field::panels::rooms::rooms_ui;
use crate::workspaces::field::panels::selection::{selection_ui, selection_window};
use crate::workspaces::field::panels::settings::settings_ui;
use crate::workspaces::field::panels::table::tables_ui;
use crate::workspaces::field::requests::FieldRequest;
use crate::workspaces::field::samples::SampleScale;
use crate::workspaces::field::state::FieldState;
use bevy::prelude::*;
use bevy::window::RequestRedraw;
use bevy_egui::EguiContexts;
use bevy_egui::egui::{Rect, Ui};

/// The measurements that are open.
pub(crate) fn tables_panel(
    mut ui: InMut<Ui>,
    state: Res<FieldState>,
    scale: Option<Res<SampleScale>>,
    mut requests: Requests<FieldRequest>,
) {
    let scale = scale.map_or_else(SampleScale::default, |scale| *scale);
    requests.write_all(tables_ui(&mut ui, &state, scale));
}

/// The rooms that the design could be put in.
pub(crate) fn rooms_panel(
    mut ui: InMut<Ui>,
    state: Res<FieldState>,
    mut requests: Requests<FieldRequest>,
) {
    requests.write_all(rooms_ui(&mut ui, &state));
}

/// What a room is fitted with, and how well the fit describes the measurements.
pub(crate) fn fit_panel(
    mut ui: InMut<Ui>,
    state: Res<FieldState>,
    world: Res<OpenWorld>,
    generation: Res<WorldGeneration>,
    mut requests: Requests<FieldRequest>,
) {
    requests.write_all(settings_ui(&mut ui, &state));
    requests.write_all(fit_quality_ui(&mut ui, &state));
    if let Some(comparison) = &state.comparison {
        let is_current = comparison.generation == generation.0
            && comparison.revision == world.0.document.revision();
        comparison_ui(&mut ui, comparison, is_current);
    }
    if let Some(fitted) = &state.fitted {
        requests.write_all(selection_ui(&mut ui, fitted));
    }
}

/// The metal that disturbs the measurements.
pub(crate) fn metal_panel(
    mut ui: InMut<Ui>,
    state: Res<FieldState>,
    world: Res<OpenWorld>,
    mut requests: Requests<FieldRequest>,
) {
    requests.write_all(metal_ui(&mut ui, &state, world.0.generator()));
}

pub(crate) fn is_selection_open(state: Res<FieldState>) -> bool {
    state.is_selection_open
}

/// The window with Fig. 3 and its table.
pub(crate) fn selection_page(
    mut contexts: EguiContexts,
    state: Res<FieldState>,
    mut requests: Requests<FieldRequest>,
    mut commands: Commands,
    mut stood: Local<Option<Rect>>,
) -> Result {
    let Some(fitted) = state.fitted.as_ref().filter(|f| f.decided.chosen.is_some()) else {
        return Ok(());
    };
    let (selection_requests, stands) = selection_window(contexts.ctx_mut()?, fitted);
    if *stood != stands {
        commands.write_message(RequestRedraw);
    }
    *stood = stands;
    requests.write_all(selection_requests);
    Ok(())
}
