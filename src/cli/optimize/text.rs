//! What a search has found, for a person.

use crate::cli::prelude::*;
use trackwright_formats::printable::printable;
use trackwright_geometry::pose::pose_to_array;
use trackwright_optimization::{
    Binding, Constraint, Flatness, Goal, Layout, Optimized, PoseChange, Problem, RoomGain,
};
use trackwright_report::optimization_json::FoundPlaces;
use trackwright_report::text_table::{columns, lines as aligned_lines};
use trackwright_simulation::comparison::difference_words;
use trackwright_simulation::{Coil, Metric, RigidBody, Sensor};

/// What the start is called beside the best.
const START: &str = "the start";

pub fn as_text(found: &FoundPlaces) -> String {
    let optimized = &found.optimized;
    let rooms: Vec<&str> = found.rooms.iter().map(|room| room.name.as_str()).collect();
    let design = found.world.document.design();
    let mut lines = vec![output::head(&design.name, &rooms.join(", "))];
    for (room, name) in rooms.iter().enumerate() {
        if rooms.len() > 1 {
            lines.push(printable(name).into_owned());
        }
        lines.extend(figures_table(&found.problem, optimized, room));
        let gain = optimized.gain.get(room).into_iter();
        lines.extend(gain.flat_map(|gain| gain_lines(found.problem.goal, gain)));
    }
    lines.push(optimized.verdict().to_owned());
    lines.extend(optimized.gain_left_words());
    let head = match optimized.is_better {
        true => "its places",
        false => "the best that was found, which is not written",
    };
    lines.extend(layout_lines(head, &optimized.best, &optimized.start));
    lines.extend(optimized.binding.iter().map(binding_line));
    lines.extend(optimized.flatness.iter().map(flatness_line));
    lines.extend(optimized.undetermined.iter().cloned());
    lines.extend(candidate_lines(&found.problem, optimized));
    lines.extend(pareto_lines(&found.problem, optimized));
    lines.push(certainty(optimized));
    let stopped = if optimized.is_stopped { ", stopped before its end" } else { "" };
    let evaluations = with_separators(optimized.evaluations as usize);
    lines.push(format!("{evaluations} layouts judged in {:.1} s{stopped}", found.seconds));
    lines.extend(optimized.notes.iter().map(|note| format!("note: {note}")));
    lines.push(format!("written: {}", found.written.join(", ")));
    lines.join("\n")
}

/// What the search makes least, of a layout.
pub fn objective(problem: &Problem, layout: &Layout) -> String {
    match problem.goal {
        Goal::Requirement(_) => format!("{:.4} of the limit", layout.objective),
        Goal::Figure(metric) => format!("{:.4} {}", layout.objective, metric.unit()),
    }
}

/// The figures that a requirement can be about, and those that are requested.
fn shown(goal: Goal) -> Vec<Metric> {
    let is_requested = |metric: Metric| match goal {
        Goal::Figure(own) => own == metric,
        Goal::Requirement(requirement) => requirement.bound(metric).is_some(),
    };
    let bounded: Vec<Metric> = Metric::bounded().collect();
    Metric::printed().filter(|metric| bounded.contains(metric) || is_requested(*metric)).collect()
}

/// Start and best of one room beside each other.
fn figures_table(problem: &Problem, optimized: &Optimized, room: usize) -> Vec<String> {
    let layouts = [&optimized.start, &optimized.best];
    let requirement = problem.scenarios[room].requirement;
    let limit = |metric: Metric| requirement.and_then(|own| own.bound(metric));
    let header = ["", "start (95 %)", "best (95 %)", "limit", ""].map(str::to_owned).to_vec();
    let rows = shown(problem.goal).into_iter().map(|metric| {
        let value = |layout: &Layout| {
            let figure = layout.studies.get(room).and_then(|study| study.figures.get(metric));
            figure.map_or_else(String::new, |figure| {
                let interval = figure.interval_text(4);
                let interval = interval.map_or_else(String::new, |words| format!(" ({words})"));
                format!("{}{interval}", figure.value_text(4))
            })
        };
        let [start, best] = layouts.map(value);
        let limit = limit(metric).map_or_else(String::new, |limit| limit.to_string());
        vec![metric.label().to_owned(), start, best, limit, metric.unit().to_owned()]
    });
    let outside = |layout: &Layout| {
        let study = layout.studies.get(room);
        study.map_or_else(String::new, |study| with_separators(study.room_field.outside))
    };
    let [start, best] = layouts.map(outside);
    let outside = vec!["trials with a sensor outside".to_owned(), start, best];
    let table: Vec<Vec<String>> = [header].into_iter().chain(rows).chain([outside]).collect();
    let aligned = aligned_lines(&table, |column| (1..4).contains(&column));
    aligned.into_iter().map(|line| format!("  {line}")).collect()
}

/// What the best gains in fields that the search did not see, in the words of `compare`.
fn gain_lines(goal: Goal, gain: &RoomGain) -> Vec<String> {
    let shown = shown(goal);
    let own = gain.differences.iter().filter(|own| shown.contains(&own.metric));
    let width = shown.iter().map(|metric| metric.label().chars().count()).max().unwrap_or(0);
    let each = own
        .map(|own| format!("  {:<width$}  {}", own.metric.label(), difference_words(own, START)));
    let head = "in fields that the search did not see:".to_owned();
    match gain.differences.is_empty() {
        true => Vec::new(),
        false => [head].into_iter().chain(each).collect(),
    }
}

fn binding_line(binding: &Binding) -> String {
    let Binding { body, sensor, constraint } = binding;
    let subject = match constraint {
        Constraint::Determination => "another place of",
        _ => "the coil of",
    };
    format!("binding: {subject} {} ({body}) {}", printable(sensor), constraint.words())
}

fn flatness_line(flatness: &Flatness) -> String {
    let Flatness { body, sensor, within_mm } = flatness;
    let sensor = printable(sensor);
    match within_mm {
        Some(within_mm) => {
            format!("flatness: {sensor} ({body}) may be {within_mm:.2} mm off for 5 % more")
        }
        None => format!("flatness: {sensor} ({body}) makes it 5 % more nowhere in its regions"),
    }
}

fn certainty(optimized: &Optimized) -> String {
    match optimized.certain_to_mm {
        Some(certain_to_mm) => format!(
            "all layouts of a grid were judged: no allowed place is farther than {certain_to_mm:.2} mm from one of its places"
        ),
        None => "not certain: there are too many layouts to judge all of a grid".to_owned(),
    }
}

/// Distinct layouts that are about as good.
fn candidate_lines(problem: &Problem, optimized: &Optimized) -> Vec<String> {
    let mut lines = Vec::new();
    for (number, layout) in optimized.candidates.iter().enumerate().skip(1) {
        let head = format!("candidate {}, {}", number + 1, objective(problem, layout));
        lines.extend(layout_lines(&head, layout, &optimized.start));
    }
    lines
}

/// The sensors and poses that are not those of the start.
fn layout_lines(head: &str, layout: &Layout, start: &Layout) -> Vec<String> {
    let bodies = [
        ("tool", Some(&layout.tool), Some(&start.tool)),
        ("crf", layout.crf.as_ref(), start.crf.as_ref()),
    ];
    let mut table = Vec::new();
    for (key, body, before) in bodies {
        let (Some(body), Some(before)) = (body, before) else { continue };
        let is_new = |sensor: &&Sensor| !before.sensors.contains(sensor);
        table.extend(body.sensors.iter().filter(is_new).map(|sensor| sensor_row(key, sensor)));
        let is_gone = |sensor: &&Sensor| !has_name(body, &sensor.name);
        table.extend(before.sensors.iter().filter(is_gone).map(|sensor| {
            let name = printable(&sensor.name).into_owned();
            vec![format!("{name} ({key})"), "removed".to_owned()]
        }));
    }
    let poses = [
        ("CRF in the tracker frame", layout.tracker_from_crf, start.tracker_from_crf),
        ("tool", Some(layout.crf_from_tool), Some(start.crf_from_tool)),
    ];
    for (name, now, _) in poses.iter().filter(|(_, now, before)| now != before) {
        let Some(now) = now else { continue };
        let [x, y, z, qw, qx, qy, qz] = pose_to_array(now);
        table.push(vec![
            (*name).to_owned(),
            format!("({x:.2}, {y:.2}, {z:.2}) mm"),
            format!("rotation ({qw:.4}, {qx:.4}, {qy:.4}, {qz:.4})"),
        ]);
    }
    let moved = [
        ("the CRF on the patient", layout.crf_change(start)),
        ("the field generator", layout.generator_change(start)),
    ];
    table.extend(moved.into_iter().filter_map(|(name, change)| {
        let PoseChange { way_mm, turn_deg } = change?;
        let cells = [format!("moved by {way_mm:.2} mm"), format!("turned by {turn_deg:.2}°")];
        Some([name.to_owned()].into_iter().chain(cells).collect())
    }));
    match table.is_empty() {
        true => Vec::new(),
        false => {
            let aligned = columns(&table, table[0].len());
            let aligned = aligned.into_iter().map(|line| format!("  {line}"));
            [format!("{head}:")].into_iter().chain(aligned).collect()
        }
    }
}

fn has_name(body: &RigidBody, name: &str) -> bool {
    body.sensors.iter().any(|sensor| sensor.name == name)
}

fn sensor_row(key: &str, sensor: &Sensor) -> Vec<String> {
    let at = sensor.position_in_body;
    let name = printable(&sensor.name);
    let axis = sensor.axis_in_body().map_or_else(String::new, |axis| {
        let [x, y, z] = [axis.x, axis.y, axis.z].map(rounded);
        format!("axis ({x:.3}, {y:.3}, {z:.3})")
    });
    vec![format!("{name} ({key})"), format!("({:.2}, {:.2}, {:.2}) mm", at.x, at.y, at.z), axis]
}

/// A part of an axis as it is printed, without the sign of a zero.
fn rounded(part: f64) -> f64 {
    (part * 1e3).round() / 1e3 + 0.0
}

/// What each number of sensors can do.
fn pareto_lines(problem: &Problem, optimized: &Optimized) -> Vec<String> {
    if optimized.pareto.len() < 2 {
        return Vec::new();
    }
    let has_cost = optimized.pareto.iter().any(|layout| layout.cost.is_some());
    let what = match problem.goal {
        Goal::Requirement(_) => "part of the limit".to_owned(),
        Goal::Figure(metric) => format!("{} {}", metric.label(), metric.unit()),
    };
    let cost = || has_cost.then(|| "cost".to_owned());
    let header: Vec<String> = ["sensors".to_owned()]
        .into_iter()
        .chain(cost())
        .chain([what, "kinds".to_owned()])
        .collect();
    let rows = optimized.pareto.iter().map(|layout| {
        let bodies = [Some(&layout.tool), layout.crf.as_ref()];
        let sensors: Vec<&Sensor> =
            bodies.into_iter().flatten().flat_map(|body| &body.sensors).collect();
        let cost = has_cost.then(|| layout.cost.map_or_else(String::new, |own| own.to_string()));
        let mut row = vec![sensors.len().to_string()];
        row.extend(cost);
        row.extend([format!("{:.4}", layout.objective), kinds(&sensors)]);
        row
    });
    let table: Vec<Vec<String>> = [header].into_iter().chain(rows).collect();
    let aligned = columns(&table, 0).into_iter().map(|line| format!("  {line}"));
    let head = "the best of each number of sensors:".to_owned();
    [head].into_iter().chain(aligned).collect()
}

/// How many there are of each kind, in order of the first of each.
fn kinds(sensors: &[&Sensor]) -> String {
    let kind = |sensor: &Sensor| (sensor.orientation.kind_name(), sensor.coil);
    let mut counts: Vec<((&str, Option<Coil>), usize)> = Vec::new();
    for sensor in sensors {
        match counts.iter_mut().find(|(known, _)| *known == kind(sensor)) {
            Some((_, count)) => *count += 1,
            None => counts.push((kind(sensor), 1)),
        }
    }
    let each = counts.into_iter().map(|((name, coil), count)| match coil {
        Some(coil) => format!("{count} x {name} {}x{} mm", coil.diameter_mm, coil.length_mm),
        None => format!("{count} x {name}"),
    });
    each.collect::<Vec<_>>().join(", ")
}
