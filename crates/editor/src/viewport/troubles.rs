//! What is wrong with a body or a sensor, in a few words: for the scene and the panels alike.

use crate::viewport::coil_fit::ShownFindings;
use bevy::prelude::Resource;
use trackwright_design::BodyRole;
use trackwright_simulation::figures::{capitalised, with_minus_signs};
use trackwright_simulation::{BodyDetail, CoilFinding, Determination, PoseDetail};

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

/// What is wrong with where a sensor is in the room, else with how its coil fits, in a few words.
pub fn sensor_trouble_text(
    detail: Option<&BodyDetail>,
    coils: ShownFindings,
    role: BodyRole,
    index: usize,
) -> Option<String> {
    let trouble = detail.and_then(|detail| sensor_trouble(detail, index));
    let misfit = || coils.of(role, index).next().map(CoilFinding::words);
    trouble.map(str::to_owned).or_else(misfit)
}

/// What a body's sensors do not determine, or barely, where the tip's error depends on it, in words.
pub fn determination_text(detail: &BodyDetail) -> Option<String> {
    if let Some(weak) = &detail.weak_rotation {
        return Some(with_minus_signs(&capitalised(&weak.statement())));
    }
    if let Some(free) = &detail.free_rotation {
        let text = || with_minus_signs(&capitalised(&free.statement()));
        return free.reaches_tip().then(text);
    }
    let is_poor = matches!(detail.determination, Determination::Poor { .. });
    is_poor.then(|| "The rotation is poorly determined: noise decides it".to_owned())
}
