//! What is wrong with a body or a sensor, in a few words: for the scene and the panels alike.

use bevy::prelude::Resource;
use trackwright_design::BodyRole;
use trackwright_simulation::{BodyDetail, Determination, PoseDetail};

/// What keeps bodies from standing where they are now, as whoever follows a tracker knows it.
#[derive(Resource, Clone, Debug, Default, PartialEq, Eq)]
pub struct BodyTroubles(pub Vec<(BodyRole, String)>);

/// The detail of a body at the design's own pose.
pub fn detail(pose: Option<&PoseDetail>, role: BodyRole) -> Option<&BodyDetail> {
    match role {
        BodyRole::Tool => pose.map(|p| &p.tool),
        BodyRole::Crf => pose.and_then(|p| p.crf.as_ref()),
    }
}

/// What is wrong with where a sensor is, in a few words.
pub fn sensor_trouble(detail: &BodyDetail, index: usize) -> Option<&'static str> {
    let sensor = detail.sensors.get(index)?;
    match (sensor.is_inside, sensor.is_in_volume) {
        (_, false) => Some("outside the volume"),
        (false, true) => Some("outside the box"),
        (true, true) => None,
    }
}

/// What a body's sensors do not determine, in words.
pub fn determination_text(determination: &Determination) -> Option<&'static str> {
    match determination {
        Determination::Full => None,
        Determination::Poor { .. } => Some("The rotation is poorly determined: noise decides it"),
        Determination::FreeAxis { .. } => {
            Some("The rotation about one axis is not determined by the sensors")
        }
        Determination::FreeRotation => Some("No rotation is determined by the sensors"),
    }
}
