//! Points as 3D Slicer's markups (`*.mrk.json`).

use super::patient_axes::PatientAxes;
use serde_json::{Value, json};
use std::io::{self, Write};
use trackwright_geometry::pose::Pose;

/// What Slicer recognises the version of the file by.
const SCHEMA: &str = "https://raw.githubusercontent.com/slicer/slicer/master/Modules/Loadable/Markups/Resources/Schema/markups-schema-v1.0.3.json#";

/// A control point.
#[derive(Clone, Debug, PartialEq)]
pub struct MarkupPoint {
    pub label: String,
    pub tracker_from_point: Pose,
}

/// Points that are shown alike.
#[derive(Clone, Debug, PartialEq)]
pub struct MarkupList {
    pub name: String,
    /// Red, green, blue, sRGB.
    pub color: [u8; 3],
    pub points: Vec<MarkupPoint>,
}

/// Writes a list of points in LPS, mm, with their axes.
pub fn write(out: &mut dyn Write, points: &[MarkupPoint], axes: PatientAxes) -> io::Result<()> {
    write_markups(out, vec![fiducials(points, axes)])
}

/// Writes several lists, of which Slicer makes a node each.
pub fn write_lists(out: &mut dyn Write, lists: &[MarkupList], axes: PatientAxes) -> io::Result<()> {
    let of_list = |list: &MarkupList| {
        let color = list.color.map(|part| f64::from(part) / 255.0);
        let mut value = fiducials(&list.points, axes);
        value["name"] = json!(list.name);
        // Points are shown as selected ones, which all of them are.
        value["display"] = json!({"visibility": true, "color": color, "selectedColor": color});
        value
    };
    write_markups(out, lists.iter().map(of_list).collect())
}

fn write_markups(out: &mut dyn Write, markups: Vec<Value>) -> io::Result<()> {
    let file = json!({"@schema": SCHEMA, "markups": markups});
    serde_json::to_writer_pretty(&mut *out, &file)?;
    writeln!(out)
}

fn fiducials(points: &[MarkupPoint], axes: PatientAxes) -> Value {
    let controls: Vec<Value> =
        (1..).zip(points).map(|(id, point)| control_point(id, point, axes)).collect();
    json!({
        "type": "Fiducial",
        "coordinateSystem": "LPS",
        "coordinateUnits": "mm",
        "controlPoints": controls,
    })
}

fn control_point(id: usize, point: &MarkupPoint, axes: PatientAxes) -> Value {
    let at = point.tracker_from_point.translation.vector;
    // Row by row, its columns the point's own axes.
    let turn = axes.lps_axes(&point.tracker_from_point).transpose();
    let orientation: Vec<f64> = turn.iter().map(|v| v + 0.0).collect();
    json!({
        "id": id.to_string(),
        "label": point.label,
        "position": axes.lps(&at),
        "orientation": orientation,
        "selected": true,
        "locked": false,
        "visibility": true,
        "positionStatus": "defined",
    })
}
