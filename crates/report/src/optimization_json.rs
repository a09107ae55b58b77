//! A search for the best places of sensors, and what came of it; as JSON.

use crate::comparison::differences_json;
use crate::study::StudyReport;
use serde_json::{Value, json};
use std::sync::Arc;
use trackwright_design::{BodyRole, EditError};
use trackwright_field::Environment;
use trackwright_geometry::pose::pose_to_array;
use trackwright_optimization::{Layout, Optimized, PoseChange, Problem, RoomGain};
use trackwright_project::{World, coil_findings, layout_edits, resolve};
use trackwright_simulation::{
    CancelToken, ErrorOf, RigidBody, Sensor, SensorOrientation, StudyError, coil_section,
};

/// What was searched, and what came of it.
#[derive(Debug)]
pub struct FoundPlaces {
    pub world: World,
    /// The design with the best layout.
    pub better: World,
    pub rooms: Vec<Arc<Environment>>,
    pub problem: Problem,
    pub optimized: Optimized,
    pub seconds: f64,
    /// Names of files.
    pub written: Vec<String>,
}

/// The design with another layout of its own.
///
/// # Errors
/// A layout that no design may have.
pub fn with_layout(world: &World, layout: &Layout) -> Result<World, EditError> {
    let mut better = world.clone();
    better.document.begin("Place sensors");
    for edit in layout_edits(world.document.design(), layout) {
        better.document.apply(edit)?;
    }
    better.document.commit();
    Ok(better)
}

/// What was found as `optimize --format json` prints it.
///
/// # Errors
/// A study that cannot run.
pub fn optimization_json(found: &FoundPlaces, cancel: &CancelToken) -> Result<Value, StudyError> {
    let optimized = &found.optimized;
    let start = with_studies(found, (&optimized.start, &found.world), cancel)?;
    let best = match optimized.best == optimized.start {
        true => start.clone(),
        false => with_studies(found, (&optimized.best, &found.better), cancel)?,
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
        "gain": optimized.gain.iter().map(gain_json).collect::<Vec<_>>(),
        "gain_left": optimized.gain_left,
        "binding": optimized.binding,
        "flatness": optimized.flatness,
        "undetermined": optimized.undetermined,
        "notes": optimized.notes,
        "written": found.written,
    }))
}

/// A layout with all that `simulate` prints of its design in each room.
fn with_studies(
    found: &FoundPlaces,
    (layout, world): (&Layout, &World),
    cancel: &CancelToken,
) -> Result<Value, StudyError> {
    let coils = coil_findings(world);
    let mode = &found.problem.mode;
    let each = found.rooms.iter().map(|room| {
        let scenario = resolve(world.document.design(), room);
        let study = StudyReport::run(BodyRole::Tool, (&scenario, mode), cancel)?;
        Ok(study.section((&scenario, mode), false).with(coil_section(&coils)).to_json())
    });
    Ok(layout_json(found, layout, each.collect::<Result<_, StudyError>>()?))
}

fn layouts(found: &FoundPlaces, layouts: &[Layout]) -> Vec<Value> {
    let studies = |layout: &Layout| {
        layout.studies.iter().map(|study| study.section(None).to_json()).collect()
    };
    layouts.iter().map(|layout| layout_json(found, layout, studies(layout))).collect()
}

fn layout_json(found: &FoundPlaces, layout: &Layout, studies: Vec<Value>) -> Value {
    let rooms = found.rooms.iter().zip(&studies);
    let rooms: Vec<Value> =
        rooms.map(|(room, study)| json!({"environment": room.name, "figures": study})).collect();
    json!({
        "objective": layout.objective,
        "cost": layout.cost,
        "tool": sensors_json(&layout.tool),
        "crf": layout.crf.as_ref().map(sensors_json),
        "tracker_from_crf": layout.tracker_from_crf.as_ref().map(pose_to_array),
        "crf_from_tool": pose_to_array(&layout.crf_from_tool),
        "crf_moved": layout.crf_change(&found.optimized.start).map(change_json),
        "generator_moved": layout.generator_change(&found.optimized.start).map(change_json),
        "figures": studies.first(),
        "rooms": rooms,
    })
}

fn change_json(change: PoseChange) -> Value {
    json!({"way_mm": change.way_mm, "turn_deg": change.turn_deg})
}

fn sensors_json(body: &RigidBody) -> Vec<Value> {
    body.sensors.iter().map(sensor_json).collect()
}

fn sensor_json(sensor: &Sensor) -> Value {
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

fn gain_json(gain: &RoomGain) -> Value {
    let mut value = json!({"environment": gain.room});
    for of in ErrorOf::ALL {
        value[of.json_key()] = differences_json(&gain.differences, of);
    }
    value
}
