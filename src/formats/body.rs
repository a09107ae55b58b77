//! Bodies, `*.body.ron`: a tool or CRF with its sensors.

use super::error::FormatError;
use super::ron_text;
use crate::tracking::body::{Coil, RigidBody, Sensor, SensorOrientation};
use serde::Deserialize;
use std::collections::HashMap;
use std::fmt::Write;

/// What a body file holds.
#[derive(Clone, Debug, PartialEq)]
pub struct BodyFile {
    pub rigid: RigidBody,
    /// The mesh's file, relative to the body's.
    pub mesh: Option<String>,
}

#[derive(Deserialize)]
#[serde(rename = "Body")]
struct BodyEntry {
    #[expect(dead_code, reason = "checked before the rest is read")]
    version: u64,
    name: String,
    mesh: Option<String>,
    tip: Option<[f64; 3]>,
    sensors: Vec<SensorEntry>,
}

#[derive(Deserialize)]
#[serde(rename = "Sensor")]
struct SensorEntry {
    name: String,
    kind: SensorKind,
    position: [f64; 3],
    axis: Option<[f64; 3]>,
    rotation: Option<[f64; 4]>,
    coil: Option<Coil>,
}

#[derive(Deserialize)]
enum SensorKind {
    FiveDof,
    SixDof,
}

/// Reads a body.
///
/// # Errors
/// Anything that leaves a doubt about what the body is; see [`FormatError`].
pub fn parse(bytes: &[u8]) -> Result<BodyFile, FormatError> {
    let entry: BodyEntry = ron_text::parse(bytes)?;
    if entry.sensors.is_empty() {
        return Err(FormatError::field(
            "sensors",
            "empty",
            "at least one sensor",
        ));
    }
    let mut names = HashMap::new();
    let mut sensors = Vec::with_capacity(entry.sensors.len());
    for (index, sensor) in entry.sensors.into_iter().enumerate() {
        let sensor = read_sensor(index, sensor)?;
        if let Some(first) = names.insert(sensor.name.clone(), index) {
            return Err(FormatError::field(
                format!("sensors[{index}]: name"),
                format!("{:?}, the name of sensors[{first}]", sensor.name),
                "each name once",
            ));
        }
        sensors.push(sensor);
    }
    let tip_in_body = entry
        .tip
        .map(|tip| ron_text::point("tip", tip))
        .transpose()?;
    if entry.mesh.as_deref() == Some("") {
        return Err(FormatError::field("mesh", "empty", "a file"));
    }
    Ok(BodyFile {
        rigid: RigidBody {
            name: entry.name,
            tip_in_body,
            sensors,
        },
        mesh: entry.mesh,
    })
}

fn read_sensor(index: usize, entry: SensorEntry) -> Result<Sensor, FormatError> {
    if entry.name.trim().is_empty() {
        let field = format!("sensors[{index}]: name");
        return Err(FormatError::field(field, "empty", "a name"));
    }
    let place = format!("sensors[{index}] {:?}", entry.name);
    let orientation = match entry.kind {
        SensorKind::FiveDof => {
            let axis = entry.axis.ok_or_else(|| {
                FormatError::field(format!("{place}: axis"), "missing", "one with kind FiveDof")
            })?;
            SensorOrientation::FiveDof(ron_text::axis(&format!("{place}: axis"), axis)?)
        }
        SensorKind::SixDof => {
            let field = format!("{place}: rotation");
            let rotation = entry.rotation.ok_or_else(|| {
                FormatError::field(field.as_str(), "missing", "one with kind SixDof")
            })?;
            SensorOrientation::SixDof(ron_text::rotation(&field, rotation)?)
        }
    };
    if let Some(coil) = entry.coil {
        for (name, value) in [("diameter", coil.diameter_mm), ("length", coil.length_mm)] {
            if !(value.is_finite() && value > 0.0) {
                let field = format!("{place}: coil.{name}");
                return Err(FormatError::field(field, value, "a length above zero"));
            }
        }
    }
    Ok(Sensor {
        position_in_body: ron_text::point(&format!("{place}: position"), entry.position)?,
        name: entry.name,
        orientation,
        coil: entry.coil,
    })
}

/// Writes a body, one sensor a line.
pub fn write(body: &BodyFile) -> String {
    let mut out = String::from("(\n    version: 1,\n");
    push_field(&mut out, "name", &ron_text::string(&body.rigid.name));
    if let Some(mesh) = &body.mesh {
        push_field(&mut out, "mesh", &ron_text::string(mesh));
    }
    if let Some(tip) = &body.rigid.tip_in_body {
        push_field(&mut out, "tip", &ron_text::tuple(tip.coords.as_slice()));
    }
    out.push_str("    sensors: [\n");
    for sensor in &body.rigid.sensors {
        push_sensor(&mut out, sensor);
    }
    out.push_str("    ],\n)\n");
    out
}

fn push_field(out: &mut String, name: &str, value: &str) {
    // Writing to a string cannot fail.
    let _ = writeln!(out, "    {name}: {value},");
}

fn push_sensor(out: &mut String, sensor: &Sensor) {
    let position = ron_text::tuple(sensor.position_in_body.coords.as_slice());
    let (kind, turn) = match &sensor.orientation {
        SensorOrientation::FiveDof(axis) => (
            "FiveDof",
            format!("axis: {}", ron_text::tuple(axis.as_slice())),
        ),
        SensorOrientation::SixDof(rotation) => {
            let numbers = crate::geometry::pose::quaternion_to_array(rotation);
            ("SixDof", format!("rotation: {}", ron_text::tuple(&numbers)))
        }
    };
    let coil = sensor.coil.map_or_else(String::new, |coil| {
        format!(
            ", coil: (diameter: {:?}, length: {:?})",
            coil.diameter_mm, coil.length_mm
        )
    });
    let name = ron_text::string(&sensor.name);
    let _ = writeln!(
        out,
        "        (name: {name}, kind: {kind}, position: {position}, {turn}{coil}),"
    );
}
