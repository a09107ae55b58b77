//! The position error of each sensor, from where it is to where the tracker reports it.

use crate::layers::arrow_glyphs::{
    Arrow, ArrowStyle, DrawnArrows, ERROR_STROKE, ShineThrough, arrows_mesh,
};
use crate::layers::magnification::ShownErrors;
use crate::layers::registry::{AddLayer, LayerInfo};
use crate::schedule::EditorSystems;
use bevy::prelude::*;
use trackwright_design::{BodyRole, Document};
use trackwright_simulation::PoseDetail;
use trackwright_simulation::Sensor;

const HIDDEN: ShineThrough = ShineThrough { alpha: 0.5, order_mm: 15_000.0 };

/// The layer.
const LAYER: LayerInfo = LayerInfo {
    stroke: Some(ERROR_STROKE),
    ..LayerInfo::new("Sensor errors", 50, |layers| &mut layers.sensor_errors)
};

/// Draws sensors' error vectors while their layer is on.
pub struct SensorErrorsPlugin;

#[derive(Component, Default)]
struct SensorErrors;

/// What it shows.
const ABOUT: &str = "The position error of each sensor as an arrow, magnified";

impl Plugin for SensorErrorsPlugin {
    fn build(&self, app: &mut App) {
        app.add_layer(LAYER, ABOUT).add_systems(
            Update,
            show.run_if(crate::layers::tip_error::anything_moved).in_set(EditorSystems::Draw),
        );
    }
}

fn show(errors: ShownErrors, mut drawn: DrawnArrows<SensorErrors>) {
    let mesh = errors.pose().filter(|_| errors.layers().sensor_errors).and_then(|pose| {
        let arrows = arrows(&errors.world.0.document, pose, errors.times());
        arrows_mesh(&arrows, ArrowStyle::OF_SENSOR, &errors.rig)
    });
    drawn.show("sensor errors", mesh, HIDDEN);
}

/// Of what is shown of tool and CRF, magnified.
fn arrows(document: &Document, detail: &PoseDetail, times: f64) -> Vec<Arrow> {
    let hidden = &document.view().hidden;
    let is_shown = |role, index| {
        let body = document.design().body(role);
        let sensor = body.and_then(|body| body.rigid.sensors.get(index));
        // A result can be of a design with more sensors; it is about to be replaced.
        sensor.is_none_or(|sensor: &Sensor| !hidden.has_sensor(role, &sensor.name))
    };
    let tool = (BodyRole::Tool, &detail.tool);
    let crf = detail.crf.iter().map(|crf| (BodyRole::Crf, crf));
    std::iter::once(tool)
        .chain(crf)
        .flat_map(|(role, body)| body.sensors.iter().enumerate().map(move |s| (role, s)))
        .filter(|(role, (index, _))| is_shown(*role, *index))
        .map(|(_, (_, sensor))| {
            let from = sensor.tracker_from_sensor.translation.vector;
            let to = sensor.tracker_from_measured.translation.vector;
            Arrow { start_mm: from.into(), vector_mm: (to - from) * times }
        })
        .collect()
}
