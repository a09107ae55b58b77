//! The position error of each sensor, from where it is to where the tracker says it is.

use super::arrows::{Arrow, ArrowStyle, DrawnArrows, ShineThrough, arrows_mesh};
use super::magnify::ShownErrors;
use crate::editor::state::EditorSystems;
use crate::study::PoseDetail;
use bevy::prelude::*;

const STYLE: ArrowStyle = ArrowStyle {
    shaft_px: 2.6,
    head_width_px: 9.0,
    head_length_px: 11.0,
};

const HIDDEN: ShineThrough = ShineThrough {
    alpha: 0.5,
    order_mm: 15_000.0,
};

/// Draws sensors' error vectors while their layer is on.
pub struct SensorErrorsPlugin;

#[derive(Component, Default)]
struct SensorErrors;

impl Plugin for SensorErrorsPlugin {
    fn build(&self, app: &mut App) {
        app.add_systems(
            Update,
            show.run_if(super::tip_error::anything_moved)
                .in_set(EditorSystems::Draw),
        );
    }
}

fn show(errors: ShownErrors, mut drawn: DrawnArrows<SensorErrors>) {
    let mesh = errors
        .pose()
        .filter(|_| errors.layers().sensor_errors)
        .and_then(|pose| arrows_mesh(&arrows(pose, errors.times()), STYLE, &errors.rig));
    drawn.show("sensor errors", mesh, HIDDEN);
}

/// Of tool and CRF, magnified.
fn arrows(detail: &PoseDetail, times: f64) -> Vec<Arrow> {
    let bodies = std::iter::once(&detail.tool).chain(&detail.crf);
    bodies
        .flat_map(|body| &body.sensors)
        .map(|sensor| {
            let from = sensor.tracker_from_sensor.translation.vector;
            let to = sensor.tracker_from_measured.translation.vector;
            Arrow {
                start_mm: from.into(),
                vector_mm: (to - from) * times,
            }
        })
        .collect()
}
