//! Layers that a view requests and that have nothing to show.

use super::content::Design;
use super::document::Document;
use super::view::View;
use trackwright_field::Environment;
use trackwright_simulation::requirement::Requirement;

/// A layer that is on and not seen. Those that are on by default show whatever there is and are
/// never missed.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum MissingLayer {
    /// The file has a name that no layer has.
    #[error("layer {0:?}, which this version of the program does not have")]
    Unknown(String),
    #[error("usable region, as the design has no requirement")]
    Region,
    #[error("model support, as the room has no model validity")]
    Support,
    #[error("sensor placement, as no sensor is selected")]
    Placement,
}

impl View {
    /// What the view requests and does not show of a design in its room.
    pub fn missing_layers(
        &self,
        design: &Design,
        environment: &Environment,
        is_sensor_selected: bool,
    ) -> Vec<MissingLayer> {
        let layers = &self.layers;
        let has_requirement = design.requirement.is_some_and(|r| r != Requirement::default());
        let missing = [
            (layers.region && !has_requirement, MissingLayer::Region),
            (layers.support && !environment.has_validity(), MissingLayer::Support),
            (layers.placement && !is_sensor_selected, MissingLayer::Placement),
        ];
        let unknown = self.unknown_layers.iter().cloned();
        let missing = missing.into_iter().filter(|(is_missing, _)| *is_missing);
        (unknown.map(MissingLayer::Unknown)).chain(missing.map(|(_, layer)| layer)).collect()
    }
}

impl Document {
    /// What the design's own view and its slides request and cannot show, a sentence each, for
    /// whoever opens or draws them. On a slide placements are those of the tool's first sensor.
    pub fn missing_layers(&self, environment: &Environment) -> Vec<String> {
        let design = self.design();
        let unknown = self.own_view().unknown_layers.iter().cloned();
        let of_view = unknown.map(|name| {
            let layer = MissingLayer::Unknown(name);
            format!("the design is shown without the {layer}")
        });
        let of_slides = design.slides.iter().enumerate().flat_map(|(index, slide)| {
            let missing = slide.view.missing_layers(design, environment, true);
            let number = index + 1;
            (missing.into_iter())
                .map(move |layer| format!("slide {number} is shown without the {layer}"))
        });
        of_view.chain(of_slides).collect()
    }
}
