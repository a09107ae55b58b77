//! The layers' switches, each with its settings below it while it is on.

use crate::document::requests::ViewRequest;
use crate::layers::settings_ui::{LayerFigures, Settings, layer_settings_ui, switch_ui};
use crate::shell::PanelAction;
use crate::widgets::basic::section_ui;
use bevy_egui::egui::Ui;
use trackwright_design::view::{Layers, View};
use trackwright_field::Environment;

/// A layer's name, its switch, and its settings.
struct Layer {
    name: &'static str,
    switch: fn(&mut Layers) -> &mut bool,
    settings: Option<Settings>,
    /// Whether it is about places in the room rather than about bodies.
    is_of_room: bool,
}

const fn of_design(name: &'static str, switch: fn(&mut Layers) -> &mut bool) -> Layer {
    Layer { name, switch, settings: None, is_of_room: false }
}

const fn of_room(
    name: &'static str,
    switch: fn(&mut Layers) -> &mut bool,
    settings: Option<Settings>,
) -> Layer {
    Layer { name, switch, settings, is_of_room: true }
}

/// The layer that only a room which knows its own reach has.
const MODEL_SUPPORT: &str = "Model support";

const LAYERS: [Layer; 15] = [
    of_room("Volume", |l| &mut l.volume, None),
    of_design("Field generator", |l| &mut l.generator),
    of_design("Ground grid", |l| &mut l.grid),
    of_design("Anatomy", |l| &mut l.anatomy),
    of_design("Sensor errors", |l| &mut l.sensor_errors),
    of_design("Tip error", |l| &mut l.tip_error),
    of_design("Ghost", |l| &mut l.ghost),
    of_design("Range of motion", |l| &mut l.motion),
    of_design("Tip scatter", |l| &mut l.tip_scatter),
    of_room("Error slice", |l| &mut l.slice, Some(Settings::Slice)),
    of_room("Field arrows", |l| &mut l.arrows, Some(Settings::Arrows)),
    Layer {
        settings: Some(Settings::Placement),
        ..of_design("Sensor placement", |l| &mut l.placement)
    },
    of_room("Usable region", |l| &mut l.region, None),
    of_room(MODEL_SUPPORT, |l| &mut l.support, None),
    of_design("Labels", |l| &mut l.labels),
];

/// Which layers are listed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Listed {
    All,
    OfTheRoom,
}

/// What the switches stand for.
pub struct LayersView<'a> {
    pub view: &'a View,
    pub environment: &'a Environment,
    pub figures: LayerFigures,
    pub listed: Listed,
}

/// Draws the section.
pub fn layers_ui(ui: &mut Ui, panel: &LayersView) -> Vec<PanelAction> {
    section_ui(
        ui,
        match panel.listed {
            Listed::All => "Layers",
            Listed::OfTheRoom => "Layers of the room",
        },
    );
    let rows = ui.scope(|ui| {
        ui.spacing_mut().item_spacing.y = 0.0;
        rows_ui(ui, panel)
    });
    rows.inner
}

fn rows_ui(ui: &mut Ui, panel: &LayersView) -> Vec<PanelAction> {
    let mut actions = Vec::new();
    let is_listed = |layer: &&Layer| panel.listed == Listed::All || layer.is_of_room;
    for layer in LAYERS.iter().filter(is_listed) {
        let mut layers = panel.view.layers;
        let why_not = match layer.name {
            MODEL_SUPPORT if panel.environment.fit_validity.is_none() => {
                Some(crate::layers::slice_ui::NO_SUPPORT)
            }
            _ => None,
        };
        ui.horizontal(|ui| {
            ui.add_space(6.0);
            if switch_ui(ui, (layer.switch)(&mut layers), layer.name, why_not) {
                let view = View { layers, ..panel.view.clone() };
                actions.push(PanelAction::View(ViewRequest::Set(view)));
            }
        });
        if let Some(settings) = layer.settings {
            let (view, environment) = (panel.view, panel.environment);
            let figures = &panel.figures;
            actions.extend(layer_settings_ui(ui, settings, view, environment, figures));
        }
    }
    actions
}
