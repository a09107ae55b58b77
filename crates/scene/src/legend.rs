//! What the colours of a drawn scene mean, for the page or program that shows it.

use super::Stage;
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

impl Stage<'_> {
    /// The colours of what is drawn: bodies and sensors, errors, lines. Maps have their own lines in
    /// [`Scene::colors`](super::Scene::colors).
    pub(super) fn legend(&self) -> Vec<LegendKey> {
        let (design, layers) = (self.design(), self.view.layers);
        let mut keys = Vec::new();
        let mut add = |is_drawn: bool, color: Rgb, text: String| {
            if is_drawn {
                keys.push(LegendKey { color: color.on(self.wish.ground), text });
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
        let of = match (layers.sensor_errors, layers.tip_error) {
            (true, true) => "sensors and tip",
            (true, false) => "sensors",
            (false, _) => "tip",
        };
        let has_errors = layers.sensor_errors || layers.tip_error;
        add(has_errors, palette::ERROR_VECTOR, format!("errors of {of}"));
        let as_tracked = "the tool as the tracker reports it".to_owned();
        add(layers.ghost, palette::GHOST, as_tracked);
        let moves = layers.motion && design.motion.is_some();
        add(moves, palette::MOTION, "range of motion".to_owned());
        let mut bodies = design.bodies();
        let forbids = bodies.any(|(_, body)| forbids(&body.mounting));
        add(layers.mounting, palette::MOUNTING, MOUNTING_WORDS.to_owned());
        add(layers.mounting && forbids, palette::FORBIDDEN, FORBIDDEN_WORDS.to_owned());
        let has_patch = design.anatomy.iter().any(|anatomy| !anatomy.crf_patch.is_empty());
        let is_patch_shown = layers.mounting && layers.anatomy && has_patch;
        add(is_patch_shown, palette::CRF, CRF_PATCH_WORDS.to_owned());
        let metal = design.room_metal.iter().flat_map(|metal| &metal.objects);
        for object in metal.filter(|object| !self.view.hidden.has_metal(&object.name)) {
            let text = format!("{}, {}", object.name, object.material.label());
            add(true, look_of_metal(&object.material).color, text);
        }
        let coils = self.world.generator().map(|generator| format!("coils of {}", generator.name));
        add(layers.generator && coils.is_some(), palette::COIL, coils.unwrap_or_default());
        let volume = self.world.environment.volume.map(|volume| volume.name().to_owned());
        add(layers.volume && volume.is_some(), palette::VOLUME, volume.unwrap_or_default());
        keys
    }
}
