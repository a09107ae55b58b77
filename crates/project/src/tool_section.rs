//! A tool as a result: its definition's fields, its sensors, how they lie.

use super::tool::ReadTool;
use trackwright_design::definition::DefinitionKind;
use trackwright_formats::tool_definition::{NdiRom, ToolDefinition};
use trackwright_result::{Row, Section, Table, data, text, vector};
use trackwright_simulation::body::Sensor;
use trackwright_simulation::pairs::sensor_pairs;

/// Sensors whose distances are reported: as many as any definition has. Every pair of a thousand
/// would be half a million.
const MAX_PAIRED: usize = 20;

impl ReadTool {
    /// All that is known of the tool.
    pub fn section(&self) -> Section {
        let (rigid, carried) = (&self.body.rigid, self.body.definition.as_deref());
        let definition = ToolDefinition::carried(carried);
        let facts = definition.iter().flat_map(ToolDefinition::facts);
        let sensors = &rigid.sensors;
        let axis = |sensor: &Sensor| sensor.axis_in_body().map(|axis| <[f64; 3]>::from(*axis));
        let axes = |label| if sensors.iter().any(|s| axis(s).is_some()) { label } else { "" };
        let paired = &sensors[..sensors.len().min(MAX_PAIRED)];
        let pairs: Vec<_> = sensor_pairs(paired).collect();
        let more =
            || format!("distances of the first {} of {} sensors", paired.len(), sensors.len());
        Section::of([
            data("kind", self.kind.map_or("body", DefinitionKind::code)),
            data("definition", carried.map(|definition| definition.kind.code())),
            data("rom", definition.as_ref().and_then(ToolDefinition::rom).map(rom_section)),
            data("tip", ()),
            text("name", "name", &rigid.name),
        ])
        .with_all(facts.map(|fact| Row { unit: fact.unit, ..text("", fact.what, fact.value) }))
        .with_all(
            rigid
                .tip_in_body
                .map(|tip| vector::<3>("tip", "tip", Some(tip.coords.into()), 3, "mm")),
        )
        .with(
            Table::of("sensors", sensors)
                .text("name", "sensor", |s| s.name.clone())
                .data("degrees_of_freedom", |s| s.orientation.degrees_of_freedom())
                .number("position", "position, mm", 3, |s| {
                    <[f64; 3]>::from(s.position_in_body.coords)
                })
                .number("axis", axes("axis"), 5, axis)
                .done(),
        )
        .with(
            Table::of("pairs", &pairs)
                .text("a", "from", |pair| paired[pair.a].name.clone())
                .text("b", "to", |pair| paired[pair.b].name.clone())
                .number("distance_mm", "distance, mm", 3, |pair| pair.distance_mm)
                .number("angle_deg", axes("angle, deg"), 2, |pair| {
                    pair.angle_rad.map(f64::to_degrees)
                })
                .done(),
        )
        .with_all((paired.len() < sensors.len()).then(more))
    }
}

fn rom_section(rom: &NdiRom) -> Section {
    let (serial, sum) = (rom.serial(), rom.checksum());
    Section::of([
        data("part_number", rom.part_number()),
        data("manufacturer", rom.manufacturer()),
        data("serial", serial.to_string()),
        data("date", serial.date().map(|date| date.to_string())),
        data("unique_id", rom.unique_id()),
        data("main_type", rom.main_type()),
        data("sub_type", rom.sub_type()),
        data("revision", rom.revision()),
        data("checksum.stored", sum.stored),
        data("checksum.computed", sum.computed),
        data("checksum.matches", sum.matches()),
        data("trailing_bytes", rom.trailing().len()),
    ])
}
