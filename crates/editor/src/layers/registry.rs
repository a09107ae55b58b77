//! Layers register: each file of a layer adds its row in the table of layers, its settings, what it writes
//! into the legend and its value under the pointer. The list of switches, the legend and the probe
//! iterate over what was registered.

use crate::document::requests::{OpenWorld, ViewRequest};
use crate::document::state::Notice;
use crate::layers::legend::LegendKey;
use crate::shell::commands::{AddCommand, Command, Group};
use bevy::prelude::{App, MessageWriter, Res, ResMut, Resource, World};
use bevy_egui::egui::Ui;
use trackwright_design::Design;
use trackwright_design::view::{Layer, Layers, View};
use trackwright_field::environment::Environment;
use trackwright_geometry::orbit::OrbitCamera;
use trackwright_geometry::surface::Ray;
use trackwright_project::World as OpenDesign;

/// The layers, in lists of commands.
pub const LAYERS: Group = Group { order: 3, name: "Layers", workspace: None };

/// From here on commands are in lists only.
const LIST_ONLY: u16 = 100;

/// A layer as the list of switches and the legend know it.
#[derive(Clone, Copy, Debug)]
pub struct LayerInfo {
    /// Its row in the table of layers.
    pub row: &'static Layer,
    /// Whether it is about places in the room rather than about bodies.
    pub is_of_room: bool,
    /// Why it cannot be turned on in a room; `None` where it can.
    pub why_not: fn(&Environment) -> Option<&'static str>,
    /// Draws what can be set of it, below its switch while it is on.
    pub settings: Option<fn(&mut Ui, &mut View, &SettingsContext)>,
    /// What it draws, which the legend explains while it is on.
    pub keys: fn(&OpenDesign) -> Vec<LegendKey>,
    /// Whether it has nothing left to compute.
    pub is_idle: fn(&World) -> bool,
}

impl LayerInfo {
    pub const fn new(row: &'static Layer) -> Self {
        Self {
            row,
            is_of_room: false,
            why_not: |_| None,
            settings: None,
            keys: |_| Vec::new(),
            is_idle: |_| true,
        }
    }

    pub fn is_on(&self, layers: Layers) -> bool {
        self.row.is_on(layers)
    }

    /// What it shows, and why it cannot be turned on in a room.
    pub fn tooltip(&self, environment: &Environment) -> String {
        match (self.why_not)(environment) {
            Some(why_not) => format!("{}. Not now: {why_not}", self.row.about),
            None => self.row.about.to_owned(),
        }
    }

    /// The command that switches it.
    fn command(&self) -> Command {
        // Names of commands live as long as the program, and so do these.
        let name = format!("Show layer: {}", self.row.label).leak();
        let order = LIST_ONLY + u16::try_from(self.row.order).unwrap_or(u16::MAX - LIST_ONLY);
        Command::new(LAYERS, order, name, self.row.about).available_if(|now| now.world.is_some())
    }

    /// Turns it on or off; why it cannot be turned on.
    fn toggle(&self, view: &mut View, environment: &Environment) -> Result<(), &'static str> {
        let is_on = (self.row.switch)(&mut view.layers);
        match (self.why_not)(environment) {
            Some(why_not) if !*is_on => Err(why_not),
            _ => {
                *is_on = !*is_on;
                Ok(())
            }
        }
    }
}

/// What a layer's settings need to know beside the view.
#[derive(Clone, Copy, Debug)]
pub struct SettingsContext<'a> {
    pub environment: &'a Environment,
    /// Where the scene is seen from; `None` before there is a scene.
    pub camera: Option<OrbitCamera>,
    /// The largest value that the layer shows now, in its unit.
    pub largest: Option<f64>,
    /// Whether a sensor is selected, of which placement could report.
    pub is_sensor_selected: bool,
}

/// What has a value under the pointer.
#[derive(Clone, Copy, Debug)]
pub struct ProbeInfo {
    /// Whether it shows anything: while nothing does, the probe rests.
    pub is_on: fn(&World) -> bool,
    pub value: fn(&World, &ProbeRay) -> Option<Probed>,
}

/// The ray under the pointer, tracker frame.
#[derive(Clone, Copy, Debug)]
pub struct ProbeRay<'a> {
    pub ray: Ray,
    /// How far from the ray small things are still met.
    pub reach_rad: f64,
    /// The design as it is shown.
    pub design: &'a Design,
}

/// Something that a ray meets.
#[derive(Clone, Debug, PartialEq)]
pub struct Probed {
    pub distance_mm: f64,
    /// Its value in words; `None` where it only hides what is behind it.
    pub words: Option<String>,
}

/// What was registered, in the order of the list.
#[derive(Resource, Clone, Debug, Default)]
pub struct LayerRegistry {
    pub layers: Vec<LayerInfo>,
    pub probes: Vec<ProbeInfo>,
}

/// Registers layers with an [`App`].
pub trait AddLayer {
    /// Adds a layer, and the command that switches it.
    fn add_layer(&mut self, layer: LayerInfo) -> &mut Self;
    fn add_probe(&mut self, probe: ProbeInfo) -> &mut Self;
}

impl AddLayer for App {
    fn add_layer(&mut self, layer: LayerInfo) -> &mut Self {
        self.add_command(layer.command(), switch(layer));
        let layers = &mut self.world_mut().get_resource_or_init::<LayerRegistry>().layers;
        let at = layers.partition_point(|other| other.row.order <= layer.row.order);
        layers.insert(at, layer);
        self
    }

    fn add_probe(&mut self, probe: ProbeInfo) -> &mut Self {
        self.world_mut().get_resource_or_init::<LayerRegistry>().probes.push(probe);
        self
    }
}

/// Carries out the command of a layer.
fn switch(
    layer: LayerInfo,
) -> impl FnMut(Option<Res<OpenWorld>>, MessageWriter<ViewRequest>, ResMut<Notice>) {
    move |world: Option<Res<OpenWorld>>,
          mut views: MessageWriter<ViewRequest>,
          mut notice: ResMut<Notice>| {
        let Some(world) = world else { return };
        let mut view = world.0.document.view().clone();
        match layer.toggle(&mut view, &world.0.environment) {
            Ok(()) => {
                views.write(ViewRequest::Set(view));
            }
            Err(why_not) => *notice = Notice::Refused(format!("{}: {why_not}", layer.row.label)),
        }
    }
}

/// Whether a layer of the open design is on.
pub fn is_layer_on(world: &World, layer: &LayerInfo) -> bool {
    let open = world.get_resource::<OpenWorld>();
    open.is_some_and(|open| layer.is_on(open.0.document.view().layers))
}

/// Whether no layer has anything left to compute.
pub fn are_idle(world: &World) -> bool {
    let registry = world.get_resource::<LayerRegistry>();
    registry.is_none_or(|registry| registry.layers.iter().all(|layer| (layer.is_idle)(world)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn layers_are_listed_by_their_order() {
        let mut app = App::new();
        for layer in Layer::ALL.iter().rev() {
            app.add_layer(LayerInfo::new(layer));
        }
        let layers = &app.world().resource::<LayerRegistry>().layers;
        assert!(
            layers.iter().map(|layer| layer.row.label).eq(Layer::ALL.iter().map(|own| own.label))
        );
    }
}
