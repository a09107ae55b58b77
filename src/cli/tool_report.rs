//! What a tool is, in words: its definition's fields, its sensors, how they lie.

use super::output::{self, mm, number, row};
use trackwright_formats::tool_definition::ToolDefinition;
use trackwright_project::ReadTool;
use trackwright_report::tool_json::paired;
use trackwright_simulation::pairs::sensor_pairs;

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

fn triple(values: &[f64], digits: usize) -> String {
    let parts: Vec<_> = values.iter().map(|v| format!("{v:.digits$}")).collect();
    parts.join(" ")
}
