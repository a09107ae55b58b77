//! What the colours of a drawn scene mean, for the page or program that shows it.

use super::drawing::Drawing;
use super::metal::look_of_metal;
use super::mounting::{CRF_PATCH_WORDS, FORBIDDEN_WORDS, MOUNTING_WORDS, forbids};
use super::palette::{self, Rgb};
use trackwright_design::BodyRole;

/// A colour on the scene's ground, and what has it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LegendKey {
    /// sRGB.
    pub color: [u8; 3],
    pub text: String,
}

impl Drawing<'_> {
    /// The colours of what is drawn: bodies and sensors, errors, lines. Maps have their own lines in
    /// [`Scene::colors`](super::Scene::colors).
    pub(super) fn legend(&self) -> Vec<LegendKey> {
        let (stage, view) = (self.stage, &self.stage.view);
        let (design, layers) = (stage.design(), view.layers);
        let mut keys: Vec<LegendKey> = Vec::new();
        let mut add = |is_drawn: bool, color: Rgb, text: String| {
            let key = LegendKey { color: color.on(stage.wish.ground), text };
            // Two layers can mean the same.
            if is_drawn && !keys.contains(&key) {
                keys.push(key);
            }
        };
        for (role, body) in design.bodies() {
            let color = match role {
                BodyRole::Tool => palette::TOOL,
                BodyRole::Crf => palette::CRF,
            };
            add(true, color, body.rigid.name.clone());
        }
        add(true, palette::SENSOR, "sensors".to_owned());
        for layer in self.shape_layers() {
            if let Some(line) = (layer.legend)(&self.shown()) {
                add(true, layer.color, line.words);
            }
        }
        let as_tracked = "the tool as the tracker reports it".to_owned();
        add(layers.ghost, palette::GHOST, as_tracked);
        let mut bodies = design.bodies();
        let forbids = bodies.any(|(_, body)| forbids(&body.mounting));
        add(layers.mounting, palette::MOUNTING, MOUNTING_WORDS.to_owned());
        add(layers.mounting && forbids, palette::FORBIDDEN, FORBIDDEN_WORDS.to_owned());
        let has_patch = design.anatomy.iter().any(|anatomy| !anatomy.crf_patch.is_empty());
        let is_patch_shown = layers.mounting && layers.anatomy && has_patch;
        add(is_patch_shown, palette::CRF, CRF_PATCH_WORDS.to_owned());
        let metal = design.room_metal.iter().flat_map(|metal| &metal.objects);
        for object in metal.filter(|object| !view.hidden.has_metal(&object.name)) {
            let text = format!("{}, {}", object.name, object.material.label());
            add(true, look_of_metal(&object.material).color, text);
        }
        let coils = stage.world.generator().map(|generator| format!("coils of {}", generator.name));
        add(layers.generator && coils.is_some(), palette::COIL, coils.unwrap_or_default());
        let volume = stage.world.environment.volume.map(|volume| volume.name().to_owned());
        add(layers.volume && volume.is_some(), palette::VOLUME, volume.unwrap_or_default());
        keys
    }
}
