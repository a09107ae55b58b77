//! The layers' switches, each with its settings below it while it is on.

use crate::document::requests::OpenWorld;
use crate::document::selection::Selection;
use crate::layers::legend::Legends;
use crate::layers::magnification::{MagnificationFit, ShownMagnification, magnification_ui};
use crate::layers::registry::{LayerInfo, LayerRegistry, SettingsContext};
use crate::viewport::camera::OrbitRig;
use crate::widgets::basic::section_ui;
use crate::widgets::tooltip::Explain;

use bevy::ecs::system::SystemParam;
use bevy::prelude::Res;
use bevy_egui::egui::{Checkbox, Ui};
use trackwright_design::view::View;
use trackwright_field::environment::Environment;
use trackwright_geometry::orbit::OrbitCamera;

/// Which layers are listed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Listed {
    All,
    OfTheRoom,
}

/// What the switches need to know beside the view and the room.
#[derive(Clone, Copy, Debug, Default)]
pub struct LayerFigures<'a> {
    pub layers: &'a [LayerInfo],
    pub legends: Option<&'a Legends>,
    pub camera: Option<OrbitCamera>,
    pub is_sensor_selected: bool,
    /// How much larger errors are drawn, and what fitting would make of it.
    pub magnification: Option<(ShownMagnification, MagnificationFit)>,
}

/// What the switches stand for.
pub struct LayersView<'a> {
    pub view: &'a View,
    pub environment: &'a Environment,
    pub figures: LayerFigures<'a>,
    pub listed: Listed,
}

/// What a panel with the section reads.
#[derive(SystemParam)]
pub struct LayersPanel<'w> {
    registry: Res<'w, LayerRegistry>,
    legends: Res<'w, Legends>,
    rig: Option<Res<'w, OrbitRig>>,
    selection: Res<'w, Selection>,
    magnification: Option<Res<'w, ShownMagnification>>,
    fit: Option<Res<'w, MagnificationFit>>,
}

impl LayersPanel<'_> {
    pub fn figures(&self) -> LayerFigures<'_> {
        LayerFigures {
            layers: &self.registry.layers,
            legends: Some(&self.legends),
            camera: self.rig.as_ref().map(|rig| rig.camera),
            is_sensor_selected: self.selection.sensors().is_some(),
            magnification: self.magnification.as_deref().copied().zip(self.fit.as_deref().copied()),
        }
    }

    /// Draws the section; the view that it makes, where that is another one.
    pub fn ui(&self, ui: &mut Ui, world: &OpenWorld, listed: Listed) -> Option<View> {
        let (view, environment) = (world.0.document.view(), &world.0.environment);
        layers_ui(ui, &LayersView { view, environment, figures: self.figures(), listed })
    }
}

/// Draws the section; the view that it makes, where that is another one.
pub fn layers_ui(ui: &mut Ui, panel: &LayersView) -> Option<View> {
    section_ui(
        ui,
        match panel.listed {
            Listed::All => "Layers",
            Listed::OfTheRoom => "Layers of the room",
        },
    );
    let mut view = panel.view.clone();
    let is_listed = |layer: &&LayerInfo| panel.listed == Listed::All || layer.is_of_room;
    ui.scope(|ui| {
        ui.spacing_mut().item_spacing.y = 0.0;
        for layer in panel.figures.layers.iter().filter(is_listed) {
            layer_ui(ui, layer, panel, &mut view);
        }
    });
    let of_all = panel.figures.magnification.filter(|_| panel.listed == Listed::All);
    if let Some((shown, fit)) = of_all {
        magnification_ui(ui, &mut view, shown, fit);
    }
    (view != *panel.view).then_some(view)
}

/// A layer's switch, with the reason where it cannot be turned on, and its settings.
fn layer_ui(ui: &mut Ui, layer: &LayerInfo, panel: &LayersView, view: &mut View) {
    let LayerFigures { legends, camera, is_sensor_selected, .. } = panel.figures;
    let why_not = (layer.why_not)(panel.environment);
    let is_on = layer.is_on(view.layers);
    ui.horizontal(|ui| {
        ui.add_space(6.0);
        let switch = Checkbox::new((layer.row.switch)(&mut view.layers), layer.row.label);
        let switch = ui.add_enabled(why_not.is_none(), switch);
        let _ = switch.explained(layer.tooltip(panel.environment));
    });
    let Some(settings) = layer.settings.filter(|_| is_on) else {
        return;
    };
    let context = SettingsContext {
        environment: panel.environment,
        camera,
        largest: legends.and_then(|legends| Some(legends.bar(layer.row.order)?.largest)),
        is_sensor_selected,
    };
    // Each has its own colours, of one map.
    ui.push_id(layer.row.label, |ui| {
        settings(ui, view, &context);
        ui.add_space(4.0);
    });
}
