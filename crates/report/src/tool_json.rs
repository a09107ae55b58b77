//! Tools as JSON: their definition's fields, their sensors, how they lie.

use serde_json::{Value, json};
use trackwright_design::definition::DefinitionKind;
use trackwright_formats::tool_definition::{NdiRom, ToolDefinition};
use trackwright_project::ReadTool;
use trackwright_simulation::body::Sensor;
use trackwright_simulation::pairs::{SensorPair, sensor_pairs};

/// Sensors whose distances are reported: as many as any definition has. Every pair of a thousand
/// would be half a million.
const MAX_PAIRED: usize = 20;

/// A tool as `convert --format json` prints it.
pub fn tool_json(tool: &ReadTool) -> Value {
    let kind = tool.kind.map_or("body", DefinitionKind::code);
    let rigid = &tool.body.rigid;
    let paired = paired(&rigid.sensors);
    let carried = tool.body.definition.as_ref().map(|d| d.kind);
    json!({
        "kind": kind,
        "definition": carried.map(DefinitionKind::code),
        "name": rigid.name,
        "rom": rom_of(tool).as_ref().map(rom_json),
        "tip": rigid.tip_in_body.map(|tip| [tip.x, tip.y, tip.z]),
        "sensors": rigid.sensors.iter().map(sensor_json).collect::<Vec<_>>(),
        "pairs": sensor_pairs(paired).map(|pair| pair_json(paired, &pair)).collect::<Vec<_>>(),
    })
}

fn sensor_json(sensor: &Sensor) -> Value {
    let at = sensor.position_in_body;
    let axis = sensor.axis_in_body().map(|axis| [axis.x, axis.y, axis.z]);
    json!({
        "name": sensor.name,
        "degrees_of_freedom": sensor.orientation.degrees_of_freedom(),
        "position": [at.x, at.y, at.z],
        "axis": axis,
    })
}

fn pair_json(sensors: &[Sensor], pair: &SensorPair) -> Value {
    json!({
        "a": sensors[pair.a].name,
        "b": sensors[pair.b].name,
        "distance_mm": pair.distance_mm,
        "angle_deg": pair.angle_rad.map(f64::to_degrees),
    })
}

fn rom_json(rom: &NdiRom) -> Value {
    let (serial, sum) = (rom.serial(), rom.checksum());
    json!({
        "part_number": rom.part_number(),
        "manufacturer": rom.manufacturer(),
        "serial": serial.to_string(),
        "date": serial.date().map(|date| date.to_string()),
        "unique_id": rom.unique_id(),
        "main_type": rom.main_type(),
        "sub_type": rom.sub_type(),
        "revision": rom.revision(),
        "checksum": {"stored": sum.stored, "computed": sum.computed, "matches": sum.matches()},
        "trailing_bytes": rom.trailing().len(),
    })
}

fn rom_of(tool: &ReadTool) -> Option<NdiRom> {
    ToolDefinition::carried(tool.body.definition.as_deref())?.rom().cloned()
}

/// Those of which pairs are reported.
pub fn paired(sensors: &[Sensor]) -> &[Sensor] {
    &sensors[..sensors.len().min(MAX_PAIRED)]
}
