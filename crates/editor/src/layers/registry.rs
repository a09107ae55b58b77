//! Layers register: each file of a layer adds its name, its switch, its settings, what it writes
//! into the legend and its value under the pointer. The list of switches, the legend and the probe
//! iterate over what was registered.

use crate::document::requests::OpenWorld;
use crate::layers::legend::StrokeKey;
use bevy::prelude::{App, Resource, World};
use bevy_egui::egui::Ui;
use trackwright_design::Design;
use trackwright_design::view::{Layers, View};
use trackwright_field::environment::Environment;
use trackwright_geometry::orbit::OrbitCamera;
use trackwright_geometry::surface::Ray;

/// A layer as the list of switches and the legend know it.
#[derive(Clone, Copy, Debug)]
pub struct LayerInfo {
    pub name: &'static str,
    /// Where it stands in the list, and in the legend.
    pub order: u32,
    pub switch: fn(&mut Layers) -> &mut bool,
    /// Whether it is about places in the room rather than about bodies.
    pub is_of_room: bool,
    /// Why it cannot be turned on in a room; `None` where it can.
    pub why_not: fn(&Environment) -> Option<&'static str>,
    /// Draws what can be set of it, below its switch while it is on.
    pub settings: Option<fn(&mut Ui, &mut View, &SettingsContext)>,
    /// A colour that the legend explains while it is on.
    pub stroke: Option<StrokeKey>,
    /// Whether it has nothing left to compute.
    pub is_idle: fn(&World) -> bool,
}

impl LayerInfo {
    pub const fn new(name: &'static str, order: u32, switch: fn(&mut Layers) -> &mut bool) -> Self {
        Self {
            name,
            order,
            switch,
            is_of_room: false,
            why_not: |_| None,
            settings: None,
            stroke: None,
            is_idle: |_| true,
        }
    }

    pub fn is_on(&self, mut layers: Layers) -> bool {
        *(self.switch)(&mut layers)
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
    fn add_layer(&mut self, layer: LayerInfo) -> &mut Self;
    fn add_probe(&mut self, probe: ProbeInfo) -> &mut Self;
}

impl AddLayer for App {
    fn add_layer(&mut self, layer: LayerInfo) -> &mut Self {
        let layers = &mut self.world_mut().get_resource_or_init::<LayerRegistry>().layers;
        let at = layers.partition_point(|other| other.order <= layer.order);
        layers.insert(at, layer);
        self
    }

    fn add_probe(&mut self, probe: ProbeInfo) -> &mut Self {
        self.world_mut().get_resource_or_init::<LayerRegistry>().probes.push(probe);
        self
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
        for (name, order) in [("b", 20), ("c", 30), ("a", 10), ("also b", 20)] {
            app.add_layer(LayerInfo::new(name, order, |layers| &mut layers.grid));
        }
        let layers = &app.world().resource::<LayerRegistry>().layers;
        let names: Vec<_> = layers.iter().map(|layer| layer.name).collect();
        assert_eq!(names, ["a", "b", "also b", "c"]);
    }
}
