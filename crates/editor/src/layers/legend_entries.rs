//! Everything that the legend names now: what layers that are on draw, what they wrote themselves,
//! and the bodies with their sensors.

use crate::layers::legend::{ColorBar, LegendKey, Legends, StrokeKey, Swatch, merged};
use crate::layers::registry::LayerInfo;
use crate::palette;
use trackwright_design::{BodyRole, Document};
use trackwright_formats::printable::printable;
use trackwright_project::World as OpenDesign;
use trackwright_scene::look_of_metal;

/// What the legend names, in the order in which it stands there.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LegendEntries {
    /// What is magnified, each meaning once.
    pub strokes: Vec<StrokeKey>,
    /// What is not.
    pub keys: Vec<LegendKey>,
    /// One a scale.
    pub bars: Vec<ColorBar>,
    /// What each of these is, in a sentence: strokes, keys, bars.
    pub abouts: Vec<&'static str>,
}

/// What stands beside the layers that draw it.
const BODIES: &str = "Tool and CRF with their sensors, and metal, where the design has them";
const BODIES_ORDER: u32 = 0;
const OTHER: &str = "What the open workspace adds to the scene";

impl LegendEntries {
    /// Of the open design; on a slide without what stands beside the things by name.
    pub fn new(open: &OpenDesign, layers: &[LayerInfo], legends: &Legends, is_slide: bool) -> Self {
        let on = open.document.view().layers;
        let on: Vec<&LayerInfo> = layers.iter().filter(|layer| layer.is_on(on)).collect();
        let mut strokes: Vec<_> = legends.strokes().collect();
        strokes.dedup_by_key(|(_, stroke)| *stroke);
        let of_layers = on
            .iter()
            .flat_map(|layer| (layer.keys)(open).into_iter().map(|key| (layer.row.order, key)));
        let mut keys: Vec<_> =
            of_bodies(&open.document).into_iter().map(|key| (BODIES_ORDER, key)).collect();
        keys.extend(of_layers);
        keys.extend(legends.keys().map(|(order, key)| (order, key.clone())));
        keys.sort_by_key(|(order, _)| *order);
        let mut once: Vec<(u32, LegendKey)> = Vec::new();
        for (order, key) in keys.into_iter().filter(|(_, key)| key.is_shown(is_slide)) {
            if !once.iter().any(|(_, other)| *other == key) {
                once.push((order, key));
            }
        }
        let bars = merged(legends.bars().map(|(_, bar)| bar.clone()));
        // Of several on one scale that of the first.
        let of_bar = |bar: &ColorBar| {
            let mut all = legends.bars();
            all.find(|(_, other)| bar.has_scale_of(other)).map_or(0, |(order, _)| order)
        };
        let orders = strokes.iter().map(|(order, _)| *order);
        let orders = orders.chain(once.iter().map(|(order, _)| *order));
        let about = |order: u32| match layers.iter().find(|layer| layer.row.order == order) {
            Some(layer) => layer.row.about,
            None if order == BODIES_ORDER => BODIES,
            None => OTHER,
        };
        Self {
            abouts: orders.chain(bars.iter().map(of_bar)).map(about).collect(),
            strokes: strokes.into_iter().map(|(_, stroke)| stroke.clone()).collect(),
            keys: once.into_iter().map(|(_, key)| key).collect(),
            bars,
        }
    }
}

/// Tool, CRF, sensors and metal are always there, but for what is hidden.
fn of_bodies(document: &Document) -> Vec<LegendKey> {
    let (design, hidden) = (document.design(), &document.view().hidden);
    let is_shown = |role: BodyRole| design.body(role).is_some() && !hidden.has_body(role);
    let mut keys = Vec::new();
    for (role, name, color) in
        [(BodyRole::Tool, "tool", palette::TOOL), (BodyRole::Crf, "CRF", palette::CRF)]
    {
        if is_shown(role) {
            keys.push(LegendKey::new(Swatch::Line(color), name).for_designers());
        }
    }
    let has_sensors = design.bodies().any(|(_, body)| !body.rigid.sensors.is_empty());
    if has_sensors {
        keys.push(LegendKey::new(Swatch::Line(palette::SENSOR), "sensors").for_designers());
    }
    let metal = design.room_metal.iter().flat_map(|metal| &metal.objects);
    keys.extend(metal.filter(|object| !hidden.has_metal(&object.name)).map(|object| {
        let text = format!("metal: {}", printable(&object.material.label()));
        LegendKey::new(Swatch::Line(look_of_metal(&object.material).color), text)
    }));
    keys
}
