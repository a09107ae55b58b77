//! The manufacturing sheet as a section of the page.

use super::TableSection;
use crate::report::manufacturing::{
    check_words, frame_words, role_name, tolerance_value, tolerance_words,
};
use crate::study::tolerance::{ManufacturingSheet, SheetBody, SheetSensor, Tolerances};

/// What a workshop builds by: a row a sensor, and what holds for all at once.
pub fn workshop_section(sheet: &ManufacturingSheet) -> TableSection {
    let head = [
        "body",
        "sensor",
        "kind",
        "x, y, z in the body, mm",
        "axis in the body",
        "from the tip, mm",
        "may be off alone, mm",
        "may be turned alone, °",
    ];
    let of_body = |body: &SheetBody| {
        let rows = body.sensors.iter().map(|sensor| row(body, sensor));
        rows.collect::<Vec<_>>()
    };
    let mut lead = vec![
        "Where each sensor is built, and how far off it may be before the requirement fails: its magnetic centre in any direction from its place, its axis to any side."
            .to_owned(),
    ];
    for body in &sheet.bodies {
        lead.push(format!("{}. {}", body.name, frame_words(body).join(" ")));
    }
    TableSection {
        title: "Built by a workshop".to_owned(),
        lead,
        head: head.map(str::to_owned).to_vec(),
        rows: sheet.bodies.iter().flat_map(of_body).collect(),
        notes: notes(sheet),
    }
}

fn row(body: &SheetBody, sensor: &SheetSensor) -> Vec<String> {
    let place = |[x, y, z]: [f64; 3], decimals: usize| {
        format!("{x:.decimals$}, {y:.decimals$}, {z:.decimals$}")
    };
    let dash = || "–".to_owned();
    let alone = |of: fn(&Tolerances) -> String| sensor.alone.as_ref().map_or_else(dash, of);
    vec![
        format!("{} ({})", body.name, role_name(body.role)),
        sensor.name.clone(),
        sensor.kind.to_owned(),
        place(sensor.position_in_body_mm, 3),
        (sensor.axis.as_ref()).map_or_else(dash, |axis| place(axis.direction, 4)),
        (sensor.distance_from_tip_mm).map_or_else(dash, |distance| format!("{distance:.3}")),
        alone(|of| tolerance_value(&of.position_mm)),
        alone(|of| tolerance_value(&of.angle_deg)),
    ]
}

fn notes(sheet: &ManufacturingSheet) -> Vec<String> {
    let mut notes = Vec::new();
    if let Some(why) = &sheet.no_tolerances {
        notes.push(format!("No tolerances are stated: {why}."));
    }
    for body in &sheet.bodies {
        let Some(together) = &body.together else {
            continue;
        };
        notes.push(format!(
            "All sensors of all bodies off at once: those of the {} by {} mm and {}° ({}; {}).",
            role_name(body.role),
            tolerance_value(&together.position_mm),
            tolerance_value(&together.angle_deg),
            tolerance_words(&together.position_mm),
            tolerance_words(&together.angle_deg),
        ));
    }
    if !sheet.as_drawn.is_empty() {
        let checks: Vec<String> = sheet.as_drawn.iter().map(check_words).collect();
        notes.push(format!("As drawn: {}.", checks.join(", ")));
    }
    notes
}
