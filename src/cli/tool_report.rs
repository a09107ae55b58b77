//! What a tool is, in words and as JSON: its definition's fields, its sensors, how they lie.

use super::output::{self, mm, number, row};
use serde_json::{Value, json};
use trackwright_design::definition::DefinitionKind;
use trackwright_formats::tool_definition::{NdiRom, ToolDefinition};
use trackwright_project::ReadTool;
use trackwright_simulation::body::Sensor;
use trackwright_simulation::pairs::{SensorPair, sensor_pairs};

/// Sensors whose distances are reported: as many as any definition has. Every pair of a thousand
/// would be half a million.
const MAX_PAIRED: usize = 20;

/// What the file was, with its article.
pub fn kind_name(tool: &ReadTool) -> String {
    let carried = tool.body.definition.as_ref().map(|d| d.kind.name());
    match (tool.kind, carried) {
        (Some(kind), _) => kind.name().to_owned(),
        (None, Some(carried)) => format!("a body from {carried}"),
        (None, None) => "a body".to_owned(),
    }
}

pub fn as_text(tool: &ReadTool) -> String {
    let rigid = &tool.body.rigid;
    let mut rows = vec![row("name", &rigid.name, "")];
    if let Some(definition) = ToolDefinition::carried(tool.body.definition.as_deref()) {
        let facts = definition.facts().into_iter();
        rows.extend(facts.map(|fact| row(fact.what, fact.value, fact.unit)));
    }
    for sensor in &rigid.sensors {
        rows.push(row(
            sensor.name.as_str(),
            triple(sensor.position_in_body.coords.as_slice(), 3),
            "mm",
        ));
        if let Some(axis) = sensor.axis_in_body() {
            rows.push(row("  axis", triple(axis.as_slice(), 5), ""));
        }
    }
    if let Some(tip) = &rigid.tip_in_body {
        rows.push(row("tip", triple(tip.coords.as_slice(), 3), "mm"));
    }
    let paired = paired(&rigid.sensors);
    for pair in sensor_pairs(paired) {
        let label = format!("{} to {}", paired[pair.a].name, paired[pair.b].name);
        rows.push(mm(label, pair.distance_mm));
        if let Some(angle) = pair.angle_rad {
            rows.push(number("  angle", angle.to_degrees(), 2, "deg"));
        }
    }
    if paired.len() < rigid.sensors.len() {
        let label = format!("distances of the first {} of", paired.len());
        rows.push(row(label, rigid.sensors.len(), "sensors"));
    }
    output::aligned(&rows)
}

fn rom_of(tool: &ReadTool) -> Option<NdiRom> {
    ToolDefinition::carried(tool.body.definition.as_deref())?.rom().cloned()
}

fn paired(sensors: &[Sensor]) -> &[Sensor] {
    &sensors[..sensors.len().min(MAX_PAIRED)]
}

fn triple(values: &[f64], digits: usize) -> String {
    let parts: Vec<_> = values.iter().map(|v| format!("{v:.digits$}")).collect();
    parts.join(" ")
}

pub fn as_json(tool: &ReadTool, kind: &str) -> Value {
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
