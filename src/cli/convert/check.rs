//! `convert --check`: whether an optical tracker can tell tools apart.

use super::{ConvertArgs, read};
use crate::cli::Ending;
use crate::cli::output::{self, Format};
use nalgebra::Point3;
use serde_json::{Value, json};
use std::path::Path;
use trackwright_project::Files;
use trackwright_simulation::SensorOrientation;
use trackwright_simulation::distinct::{
    Comparison, Distinction, compare_tools, compare_with_itself,
};

/// A tool that has been read.
struct CheckedTool<'a> {
    file: &'a Path,
    sensors: Vec<String>,
    markers: Vec<Point3<f64>>,
}

/// Two tools, or one twice.
struct Pair {
    tools: [usize; 2],
    found: Comparison,
}

/// Compares every tool with itself and with every other, and prints what is found.
///
/// # Errors
/// Files that can't be used.
pub(super) fn run(args: &ConvertArgs, files: &Files) -> anyhow::Result<Ending> {
    let mut tools = Vec::with_capacity(args.check.len());
    for file in &args.check {
        tools.push(checked_tool(args, files, file)?);
    }
    for tool in tools.iter().filter(|tool| tool.markers.len() < 3) {
        output::note(&format!(
            "note: {}: {} markers, expected three at least; a tool of coils is known by its port and serial number, \
             not by where they are",
            tool.file.display(),
            tool.markers.len()
        ));
    }
    let pairs = compared(&tools, args.least_mm);
    match args.format {
        Format::Json => output::print_json(&as_json(&tools, &pairs, args.least_mm))?,
        Format::Text => output::print(&as_text(&tools, &pairs))?,
    }
    let is_apart = |pair: &Pair| pair.found.distinction == Distinction::Apart;
    Ok(match pairs.iter().all(is_apart) {
        true => Ending::Done,
        false => Ending::DoesNotHold,
    })
}

fn checked_tool<'a>(
    args: &ConvertArgs,
    files: &Files,
    file: &'a Path,
) -> anyhow::Result<CheckedTool<'a>> {
    let body = read(args, files, file)?.body.rigid;
    let markers = body.sensors.into_iter();
    let markers = markers.filter(|sensor| sensor.orientation == SensorOrientation::Marker);
    let (sensors, markers) = markers.map(|sensor| (sensor.name, sensor.position_in_body)).unzip();
    Ok(CheckedTool { file, sensors, markers })
}

fn compared(tools: &[CheckedTool], least_mm: f64) -> Vec<Pair> {
    let mut pairs = Vec::new();
    for (i, first) in tools.iter().enumerate() {
        for (j, second) in tools.iter().enumerate().skip(i) {
            let found = match i == j {
                true => compare_with_itself(&first.markers, least_mm),
                false => compare_tools(&first.markers, &second.markers, least_mm),
            };
            pairs.extend(found.map(|found| Pair { tools: [i, j], found }));
        }
    }
    pairs
}

fn as_text(tools: &[CheckedTool], pairs: &[Pair]) -> String {
    let lines = pairs.iter().map(|pair| {
        let [a, b] = pair.tools.map(|tool| &tools[tool]);
        let Comparison {
            distinction,
            markers: [own, other],
            distance_mm,
            angle_deg,
        } = &pair.found;
        let names = |tool: &CheckedTool, of: &[usize; 3]| of.map(|k| tool.sensors[k].clone()).join(", ");
        let is_one = pair.tools[0] == pair.tools[1];
        let who = match is_one {
            true => format!("{} with itself", a.file.display()),
            false => format!("{} and {}", a.file.display(), b.file.display()),
        };
        let verdict = match (distinction, is_one) {
            (Distinction::Apart, true) => "looks different from every side",
            (Distinction::Apart, false) => "told apart",
            (Distinction::ThreeMarkersAlike, _) => "may be confused where only three markers are seen",
            (Distinction::Alike, true) => "looks the same from two sides",
            (Distinction::Alike, false) => "cannot be told apart",
        };
        format!(
            "{who}: {verdict}; markers {} and {} differ by {distance_mm:.2} mm and {angle_deg:.1}° at most",
            names(a, own),
            names(b, other)
        )
    });
    lines.collect::<Vec<_>>().join("\n")
}

fn as_json(tools: &[CheckedTool], pairs: &[Pair], least_mm: f64) -> Value {
    let pairs = pairs.iter().map(|pair| {
        let [a, b] = pair.tools.map(|tool| tools[tool].file.display().to_string());
        json!({ "tools": [a, b], "found": pair.found })
    });
    json!({ "least_mm": least_mm, "pairs": pairs.collect::<Vec<_>>() })
}
