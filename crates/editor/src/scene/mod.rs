//! What is there: bodies, sensors, the room. A projection of the document that carries ids.

pub mod anatomy;
pub mod axes;
pub mod bodies;
pub mod body_meshes;
pub mod extent;
pub mod generator;
pub mod materials;
pub mod metal;
pub mod screen_size;
pub mod sensors;
pub mod shapes;
pub mod volume;

use bevy::prelude::*;
use trackwright_design::BodyRole;

/// Draws the bodies, their sensors and the room around them.
///
/// | plugin | what it draws |
/// | --- | --- |
/// | [`bodies::BodiesPlugin`] | meshes of tool and CRF, with the anatomy in them |
/// | [`anatomy::AnatomyPlugin`] | the design's own anatomy |
/// | [`metal::MetalScenePlugin`] | the metal of the room |
/// | [`sensors::SensorsPlugin`] | coils, their axes, outlines and marks |
/// | [`volume::VolumePlugin`] | measurement volume and the model's box |
/// | [`generator::GeneratorPlugin`] | the field generator, and its coils where they are known |
/// | [`axes::AxesPlugin`] | the tracker's axes and the ground grid |
pub struct ScenePlugin;

impl Plugin for ScenePlugin {
    fn build(&self, app: &mut App) {
        app.add_plugins((
            shapes::ShapesPlugin,
            screen_size::ScreenSizePlugin,
            bodies::BodiesPlugin,
            anatomy::AnatomyPlugin,
            metal::MetalScenePlugin,
            sensors::SensorsPlugin,
            volume::VolumePlugin,
            generator::GeneratorPlugin,
            axes::AxesPlugin,
        ));
    }
}

/// The entity of a body: its transform is the body's pose in the tracker frame.
#[derive(Component, Clone, Copy, Debug, PartialEq, Eq)]
#[require(Transform, Visibility)]
pub struct BodyRoot(pub BodyRole);

/// The entity of a sensor, child of its body's.
#[derive(Component, Clone, Copy, Debug, PartialEq, Eq)]
#[require(Transform, Visibility)]
pub struct SensorMark {
    pub body: BodyRole,
    pub index: usize,
}
