//! What a search has found, for a program.

use super::Found;
use crate::cli::compare::differences_as_json;
use crate::cli::prelude::*;
use crate::cli::study::{self, Study};
use trackwright_geometry::pose::pose_to_array;
use trackwright_optimization::{Layout, PoseChange, RoomGain};
use trackwright_project::{World, coil_findings, resolve};
use trackwright_simulation::{ErrorOf, RigidBody, Sensor, SensorOrientation};

/// # Errors
/// A study that cannot run.
pub fn as_json(found: &Found) -> anyhow::Result<Value> {
    let optimized = &found.optimized;
    let start = with_studies(found, &optimized.start, &found.world)?;
    let best = match optimized.best == optimized.start {
        true => start.clone(),
        false => with_studies(found, &optimized.best, &found.better)?,
    };
    Ok(json!({
        "start": start,
        "best": best,
        "is_better": optimized.is_better,
        "candidates": layouts(found, &optimized.candidates),
        "pareto": layouts(found, &optimized.pareto),
        "evaluations": optimized.evaluations,
        "seconds": found.seconds,
        "stopped": optimized.is_stopped,
        "certain_to_mm": optimized.certain_to_mm,
        "gain": optimized.gain.iter().map(gain_as_json).collect::<Vec<_>>(),
        "binding": optimized.binding,
        "flatness": optimized.flatness,
        "undetermined": optimized.undetermined,
        "notes": optimized.notes,
        "written": found.written,
    }))
}

/// A layout with all that `simulate` prints of its design in each room.
fn with_studies(found: &Found, layout: &Layout, world: &World) -> anyhow::Result<Value> {
    let coils = coil_findings(world);
    let each = found.rooms.iter().map(|room| {
        let scenario = resolve(world.document.design(), room);
        let of = (&scenario, &found.problem.mode);
        let mut value = Study::of(of, None)?.as_json(of);
        if !coils.is_empty() {
            value["coils"] = json!(coils);
        }
        Ok(value)
    });
    Ok(layout_as_json(found, layout, each.collect::<anyhow::Result<_>>()?))
}

fn layouts(found: &Found, layouts: &[Layout]) -> Vec<Value> {
    let figures = |layout: &Layout| {
        let each = layout.figures.iter();
        each.map(|figures| study::as_json(figures, None, None)).collect()
    };
    layouts.iter().map(|layout| layout_as_json(found, layout, figures(layout))).collect()
}

fn layout_as_json(found: &Found, layout: &Layout, figures: Vec<Value>) -> Value {
    let rooms = found.rooms.iter().zip(&figures);
    let rooms: Vec<Value> = rooms
        .map(|(room, figures)| json!({"environment": room.name, "figures": figures}))
        .collect();
    json!({
        "objective": layout.objective,
        "cost": layout.cost,
        "tool": sensors_as_json(&layout.tool),
        "crf": layout.crf.as_ref().map(sensors_as_json),
        "tracker_from_crf": layout.tracker_from_crf.as_ref().map(pose_to_array),
        "crf_from_tool": pose_to_array(&layout.crf_from_tool),
        "crf_moved": layout.crf_change(&found.optimized.start).map(change_as_json),
        "generator_moved": layout.generator_change(&found.optimized.start).map(change_as_json),
        "figures": figures.first(),
        "rooms": rooms,
    })
}

fn change_as_json(change: PoseChange) -> Value {
    json!({"way_mm": change.way_mm, "turn_deg": change.turn_deg})
}

fn sensors_as_json(body: &RigidBody) -> Vec<Value> {
    body.sensors.iter().map(sensor_as_json).collect()
}

fn sensor_as_json(sensor: &Sensor) -> Value {
    let mut value = json!({
        "sensor": sensor.name,
        "degrees_of_freedom": sensor.orientation.degrees_of_freedom(),
        "position_mm": sensor.position_in_body.coords.as_slice(),
    });
    match sensor.orientation {
        SensorOrientation::Marker => {}
        SensorOrientation::FiveDof(axis) => value["axis"] = json!(axis.as_slice()),
        SensorOrientation::SixDof(q) => value["rotation"] = json!([q.w, q.i, q.j, q.k]),
    }
    if let Some(coil) = sensor.coil {
        value["coil_mm"] = json!(coil);
    }
    value
}

fn gain_as_json(gain: &RoomGain) -> Value {
    let mut value = json!({"environment": gain.room});
    for of in ErrorOf::ALL {
        value[of.json_key()] = differences_as_json(&gain.differences, of);
    }
    value
}
