//! The manufacturing sheet as a section of the page.

use super::TableSection;
use crate::manufacturing::{
    WORST_ALLOWED, caution_words, checks_words, frame_words, requirement_words, role_name,
    tolerance_value, tolerance_words,
};
use trackwright_simulation::figures::{capitalised, with_minus_signs};
use trackwright_simulation::tolerance::{
    ManufacturingSheet, SheetBody, SheetSensor, Tolerance, Tolerances,
};

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
        let frame = with_minus_signs(&frame_words(body).join(" "));
        lead.push(format!("{}. {frame}", body.name));
    }
    TableSection {
        title: "For the workshop".to_owned(),
        lead,
        head: head.map(str::to_owned).to_vec(),
        rows: sheet.bodies.iter().flat_map(of_body).collect(),
        notes: notes(sheet),
    }
}

fn row(body: &SheetBody, sensor: &SheetSensor) -> Vec<String> {
    let place = |[x, y, z]: [f64; 3], decimals: usize| {
        with_minus_signs(&format!("{x:.decimals$}, {y:.decimals$}, {z:.decimals$}"))
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
    let together: Vec<String> = (sheet.bodies.iter())
        .filter_map(|body| {
            let together = body.together.as_ref()?;
            let value = |tolerance: &Tolerance, unit: &str| match tolerance {
                Tolerance::Within(_) => format!("{}{unit}", tolerance_value(tolerance)),
                Tolerance::None { .. } => format!("– ({})", tolerance_words(tolerance)),
            };
            Some(format!(
                "each of the {}'s {} from its place and {} from its direction",
                role_name(body.role),
                value(&together.position_mm, " mm"),
                value(&together.angle_deg, "°"),
            ))
        })
        .collect();
    if !together.is_empty() {
        notes.push(format!("All sensors may be off at once: {}.", together.join(", ")));
    }
    if !sheet.together_worst.is_empty() {
        notes.push(format!("{WORST_ALLOWED}: {}.", checks_words(&sheet.together_worst)));
    }
    if !sheet.as_drawn.is_empty() {
        notes.push(format!("By the room's model alone: {}.", checks_words(&sheet.as_drawn)));
    }
    for words in requirement_words(sheet).into_iter().chain(caution_words(sheet)) {
        notes.push(format!("{}.", capitalised(&words)));
    }
    notes
}
