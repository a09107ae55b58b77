//! The position error of each sensor, from where it is to where the tracker reports it.

use super::tip_error::error_vectors;
use super::{Arrow, Form, Shape, ShapeLayer, Shown};
use crate::arrow_style::ArrowStyle;
use crate::palette::ERROR_VECTOR;
use trackwright_design::BodyRole;
use trackwright_design::view::Layer;

pub const LAYER: ShapeLayer = ShapeLayer {
    row: &Layer::SENSOR_ERRORS,
    color: ERROR_VECTOR,
    shapes,
    legend: |_| Some(error_vectors()),
};

/// Of what is shown of tool and CRF.
fn shapes(shown: &Shown) -> Vec<Shape> {
    let Some(pose) = shown.pose else { return Vec::new() };
    let crf = pose.crf.iter().map(|crf| (BodyRole::Crf, crf));
    let bodies = std::iter::once((BodyRole::Tool, &pose.tool)).chain(crf);
    let sensors = bodies.flat_map(|(role, found)| {
        // A result can be of a design with more sensors; it is about to be replaced.
        let own = shown.design.body(role).map_or(&[][..], |body| &body.rigid.sensors);
        own.iter().zip(&found.sensors).map(move |(own, found)| (role, own, found))
    });
    let is_shown = |(role, sensor, _): &(BodyRole, &trackwright_simulation::Sensor, _)| {
        !shown.hidden.has_sensor(*role, &sensor.name)
    };
    let arrows = sensors.filter(is_shown).map(|(role, sensor, found)| {
        let from = found.tracker_from_sensor.translation.vector;
        let arrow = Arrow {
            from_mm: from.into(),
            error_mm: found.tracker_from_measured.translation.vector - from,
            times: shown.times,
            style: ArrowStyle::OF_SENSOR,
        };
        Shape::new(format!("error of the {role}'s sensor {}", sensor.name), Form::Arrow(arrow))
    });
    arrows.collect()
}
