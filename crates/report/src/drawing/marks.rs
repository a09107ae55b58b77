//! Sensors, tips and axes on a drawing.

use super::paper::{Paper, line, px, text};
use maud::{Markup, html};
use nalgebra::{Point3, Unit, Vector3};
use trackwright_simulation::{Sensor, SensorOrientation};

/// An axis' arrow beyond its coil.
const ARROW_PX: f64 = 20.0;

/// A coil whose size is not known.
const UNKNOWN_COIL_PX: f64 = 14.0;

/// No coil is drawn thinner.
const LEAST_COIL_PX: f64 = 2.5;

/// An axis that is turned this far to the reader is a dot, away from him a cross.
const END_ON: f64 = 0.97;

const DOT_PX: f64 = 6.0;

/// A sensor with its coil at true size and its axis; `number` and name are its tooltip.
pub fn sensor(paper: &Paper, sensor: &Sensor, number: usize) -> Markup {
    let at = paper.at(&sensor.position_in_body);
    let axes: Vec<(&str, Vector3<f64>)> = match &sensor.orientation {
        SensorOrientation::Marker => Vec::new(),
        SensorOrientation::FiveDof(axis) => vec![("axis", axis.into_inner())],
        SensorOrientation::SixDof(rotation) => vec![
            ("axis second", rotation * Vector3::x()),
            ("axis second", rotation * Vector3::y()),
            ("axis", rotation * Vector3::z()),
        ],
    };
    html! {
        g class="sensor" {
            title { (number) " " (sensor.name) ", " (sensor.orientation.kind_name()) }
            @match sensor.axis_in_body() {
                None => { circle class="marker" cx=(px(at[0])) cy=(px(at[1])) r="5" {} },
                Some(axis) => { (coil(paper, sensor, &axis)) },
            }
            @for (class, axis) in &axes {
                (arrow(paper, at, class, axis, if *class == "axis" { ARROW_PX } else { 0.6 * ARROW_PX }))
            }
        }
    }
}

fn coil(paper: &Paper, sensor: &Sensor, axis: &Unit<Vector3<f64>>) -> Markup {
    let (half_mm, width_px) = match sensor.coil {
        Some(coil) => {
            (coil.length_mm / 2.0, (coil.diameter_mm * paper.px_per_mm).max(LEAST_COIL_PX))
        }
        None => (UNKNOWN_COIL_PX / 2.0 / paper.px_per_mm, LEAST_COIL_PX),
    };
    let ends = [-half_mm, half_mm]
        .map(|along| paper.at(&(sensor.position_in_body + axis.into_inner() * along)));
    html! {
        line class="coil" stroke-width=(px(width_px)) x1=(px(ends[0][0])) y1=(px(ends[0][1]))
            x2=(px(ends[1][0])) y2=(px(ends[1][1])) {}
    }
}

/// An axis from a place: an arrow, or a dot or cross where it is seen end on.
fn arrow(paper: &Paper, at: [f64; 2], class: &str, axis: &Vector3<f64>, length: f64) -> Markup {
    let (direction, towards) = paper.direction(axis);
    if towards.abs() > END_ON {
        let d = DOT_PX * std::f64::consts::FRAC_1_SQRT_2;
        return html! {
            circle class=(format!("{class} end-on")) cx=(px(at[0])) cy=(px(at[1])) r=(px(DOT_PX)) {}
            @if towards > 0.0 {
                circle class=(format!("{class} dot")) cx=(px(at[0])) cy=(px(at[1])) r="1.8" {}
            } @else {
                (line(class, [at[0] - d, at[1] - d], [at[0] + d, at[1] + d]))
                (line(class, [at[0] - d, at[1] + d], [at[0] + d, at[1] - d]))
            }
        };
    }
    let reach = length + DOT_PX;
    let along = |part: f64| [0, 1].map(|k| at[k] + direction[k] * reach * part);
    let tip = along(1.0);
    let norm = direction[0].hypot(direction[1]).max(1e-9);
    let unit = direction.map(|v| v / norm);
    let head = [1.0, -1.0].map(|side| {
        [
            tip[0] - unit[0] * 7.0 - unit[1] * 3.0 * side,
            tip[1] - unit[1] * 7.0 + unit[0] * 3.0 * side,
        ]
    });
    html! {
        (line(class, at, tip))
        (line(class, head[0], tip))
        (line(class, head[1], tip))
    }
}

/// A cross in a circle, with a word: the tip, or the frame's origin.
pub fn datum(paper: &Paper, point: &Point3<f64>, word: &str) -> Markup {
    let [x, y] = paper.at(point);
    html! {
        circle class="datum" cx=(px(x)) cy=(px(y)) r="5" {}
        (line("datum", [x - 9.0, y], [x + 9.0, y]))
        (line("datum", [x, y - 9.0], [x, y + 9.0]))
        (text("word", "end", [x - 10.0, y - 6.0], word))
    }
}

/// The body's axes that lie in the paper, as arrows from a corner.
pub fn axes(paper: &Paper, corner: [f64; 2]) -> Markup {
    let shown = [("x", Vector3::x()), ("y", Vector3::y()), ("z", Vector3::z())]
        .map(|(name, axis)| (name, paper.direction(&axis)))
        .into_iter()
        .filter(|(_, (_, towards))| towards.abs() < 0.5);
    html! {
        @for (name, (direction, _)) in shown {
            @let tip = [0, 1].map(|k| corner[k] + 22.0 * direction[k]);
            @let label = [0, 1].map(|k| corner[k] + 32.0 * direction[k]);
            (line("frame", corner, tip))
            (text("quiet", "middle", [label[0], label[1] + 4.0], name))
        }
    }
}

/// Numbers in circles along a line above a view, each led to its sensor.
pub fn balloons(places: &[(usize, [f64; 2])], y: f64) -> Markup {
    const APART_PX: f64 = 24.0;
    let mut order: Vec<&(usize, [f64; 2])> = places.iter().collect();
    order.sort_by(|a, b| a.1[0].total_cmp(&b.1[0]));
    let mut least = f64::NEG_INFINITY;
    html! {
        @for (number, place) in order {
            @let x = place[0].max(least);
            @let () = least = x + APART_PX;
            (line("leader", [x, y + 10.0], *place))
            circle class="balloon" cx=(px(x)) cy=(px(y)) r="10" {}
            (text("number", "middle", [x, y + 4.5], &number.to_string()))
        }
    }
}
