//! What is to be built: each body from three sides, and its sensors in a table.

use super::{Report, file_name, table_of};
use crate::drawing::{body_drawings, dimension_text};
use maud::{Markup, html};
use trackwright_design::{BodyRole, DesignBody};
use trackwright_simulation::{RigidBody, Sensor};

/// Each body with its drawings and sensors.
pub fn section(report: &Report) -> Markup {
    let design = report.world.document.design();
    html! {
        section id="geometry" {
            h2 { "Geometry" }
            @for (role, body) in design.bodies() { (of_body(report, role, body)) }
        }
    }
}

fn of_body(report: &Report, role: BodyRole, body: &DesignBody) -> Markup {
    let rigid = &body.rigid;
    let mesh = report.mesh(role);
    let missing =
        report.world.mesh_problems().into_iter().find(|problem| problem.whose == role.into());
    html! {
        div class="body" {
            h3 { (match role { BodyRole::Tool => "Tool: ", BodyRole::Crf => "Reference (CRF): " }) (rigid.name) }
            @for drawing in body_drawings(rigid, mesh) { figure class="wide" { (drawing) } }
            @if let Some(problem) = missing {
                // The whole message has folders of somebody's machine.
                p class="note" { "Drawn without its shape: " (file_name(&problem.reference.file)) " could not be read." }
            } @else if mesh.is_none() {
                p class="note" { "Drawn without its shape: the body has no mesh." }
            }
            (sensors(rigid))
            p class="note" {
                "Positions and axes are in the body's own frame"
                @match rigid.tip_in_body {
                    Some(tip) => { ", in which the tip is at " (format!("({}, {}, {})\u{2009}mm", dimension_text(tip.x), dimension_text(tip.y), dimension_text(tip.z))) },
                    None => ", whose origin is what is judged",
                }
                ". An axis is the coil's own; the turn of a 5 DOF sensor about it means nothing."
                " Views are in third-angle projection, at one scale; arrows, dots and crosses are axes across, towards and away from the reader."
            }
        }
    }
}

fn sensors(body: &RigidBody) -> Markup {
    let head =
        ["", "sensor", "kind", "x, mm", "y, mm", "z, mm", "from the tip, mm", "axis", "coil, mm"]
            .map(|cell| match (cell, body.tip_in_body) {
                ("from the tip, mm", None) => "from the origin, mm".to_owned(),
                _ => cell.to_owned(),
            });
    let rows: Vec<Vec<String>> =
        body.sensors.iter().enumerate().map(|(index, sensor)| row(body, index, sensor)).collect();
    html! {
        @if rows.is_empty() {
            p class="note" { "The body has no sensors." }
        } @else {
            (table_of(&head, &rows, "data sensors"))
        }
    }
}

fn row(body: &RigidBody, index: usize, sensor: &Sensor) -> Vec<String> {
    let at = sensor.position_in_body;
    let axis = sensor.axis_in_body().map_or_else(
        || "–".to_owned(),
        |axis| format!("({:.4}, {:.4}, {:.4})", axis.x, axis.y, axis.z).replace('-', "−"),
    );
    let coil = sensor.coil.map_or_else(
        || "–".to_owned(),
        |coil| format!("⌀ {} × {}", coil.diameter_mm, coil.length_mm),
    );
    vec![
        (index + 1).to_string(),
        sensor.name.clone(),
        sensor.orientation.kind_name().to_owned(),
        dimension_text(at.x),
        dimension_text(at.y),
        dimension_text(at.z),
        format!("{:.2}", (at - body.judged_tip_in_body()).norm()),
        axis,
        coil,
    ]
}
