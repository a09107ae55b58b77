//! A search for the best places of sensors, and what came of it, as a result.

use crate::comparison::differences_json;
use crate::study::StudyReport;
use std::sync::Arc;
use trackwright_design::{BodyRole, EditError};
use trackwright_field::Environment;
use trackwright_formats::printable::printable;
use trackwright_geometry::pose::pose_to_array;
use trackwright_optimization::{
    Binding, Constraint, Flatness, Goal, Layout, Optimized, PoseChange, Problem, RoomGain,
};
use trackwright_project::{World, coil_findings, layout_edits, resolve};
use trackwright_result::{Row, Section, Table, data, with_separators};
use trackwright_simulation::comparison::difference_words;
use trackwright_simulation::{
    CancelToken, Coil, ErrorOf, Metric, RigidBody, Sensor, SensorOrientation, Study, StudyError,
    coil_section,
};

/// What the start is called beside the best.
const START: &str = "the start";

/// What was searched, and what came of it.
#[derive(Debug)]
pub struct FoundPlaces {
    pub world: World,
    /// The design with the best layout.
    pub better: World,
    pub rooms: Vec<Arc<Environment>>,
    pub problem: Problem,
    pub optimized: Optimized,
    pub seconds: f64,
    /// Names of files.
    pub written: Vec<String>,
}

/// The design with another layout of its own.
///
/// # Errors
/// A layout that no design may have.
pub fn with_layout(world: &World, layout: &Layout) -> Result<World, EditError> {
    let mut better = world.clone();
    better.document.begin("Place sensors");
    for edit in layout_edits(world.document.design(), layout) {
        better.document.apply(edit)?;
    }
    better.document.commit();
    Ok(better)
}

/// What the search makes least.
pub fn objective_text(goal: Goal, objective: f64) -> String {
    match goal {
        Goal::Requirement(_) => format!("{objective:.4} of the limit"),
        Goal::Figure(metric) => format!("{objective:.4} {}", metric.unit()),
    }
}

impl FoundPlaces {
    /// All that was found, but for [`Self::studies`].
    pub fn section(&self) -> Section {
        let (found, goal) = (&self.optimized, self.problem.goal);
        let rooms: Vec<&str> = self.rooms.iter().map(|room| room.name.as_str()).collect();
        let title = format!("{} in {}", self.world.document.design().name, rooms.join(", "));
        let mut section = Section::default();
        if rooms.len() > 1 {
            section = section.with(printable(&title).into_owned());
        }
        for (room, name) in rooms.iter().enumerate() {
            let heading = if rooms.len() > 1 { *name } else { &title };
            section = section
                .with(Section::default().with(self.figures_table(room)).headed(heading))
                .with_all(found.gain.get(room).map(|gain| gain_section(goal, gain)));
        }
        let gain: Vec<Section> = found.gain.iter().map(gain_data).collect();
        let places = match found.is_better {
            true => "its places:",
            false => "the best that was found, which is not written:",
        };
        let candidates = found.candidates.iter().enumerate().skip(1).map(|(k, layout)| {
            let objective = objective_text(goal, layout.objective);
            layout_section(layout, &found.start)
                .headed(format!("candidate {}, {objective}:", k + 1))
        });
        let stopped = if found.is_stopped { ", stopped before its end" } else { "" };
        let judged = with_separators(found.evaluations as usize);
        section
            .with(data("gain", gain))
            .with(data("is_better", found.is_better))
            .with(found.verdict().to_owned())
            .with(data("roughly_built", found.roughly_built))
            .with_all(found.roughly_built_words(|value| objective_text(goal, value)))
            .with(data("crowded", &found.crowded))
            .with_all(found.crowded.iter().map(|own| format!("close together: {}", own.words())))
            .with(layout_section(&found.best, &found.start).headed(places))
            .with(data("binding", &found.binding))
            .with_all(found.binding.iter().map(binding_line))
            .with(data("flatness", &found.flatness))
            .with_all(found.flatness.iter().map(flatness_line))
            .with(data("undetermined", &found.undetermined))
            .with_all(found.undetermined.iter().cloned())
            .with(data("candidates", self.layouts(&found.candidates)))
            .with_all(candidates)
            .with(data("pareto", self.layouts(&found.pareto)))
            .with(pareto_section(goal, &found.pareto))
            .with(data("certain_to_mm", found.certain_to_mm))
            .with(certainty(found))
            .with_all([
                data("evaluations", found.evaluations),
                data("seconds", self.seconds),
                data("stopped", found.is_stopped),
            ])
            .with(format!("{judged} layouts judged in {:.1} s{stopped}", self.seconds))
            .with(data("notes", &found.notes))
            .with_all(found.notes.iter().map(|note| format!("note: {note}")))
            .with(data("written", &self.written))
    }

    /// Start and best with all that `simulate` prints of their designs in each room.
    ///
    /// # Errors
    /// A study that cannot run.
    pub fn studies(&self, cancel: &CancelToken) -> Result<[Row; 2], StudyError> {
        let Optimized { start, best, .. } = &self.optimized;
        let start_data = self.with_studies((start, &self.world), cancel)?;
        let best_data = match best == start {
            true => start_data.clone(),
            false => self.with_studies((best, &self.better), cancel)?,
        };
        Ok([data("start", start_data), data("best", best_data)])
    }

    fn with_studies(
        &self,
        (layout, world): (&Layout, &World),
        cancel: &CancelToken,
    ) -> Result<Section, StudyError> {
        let coils = coil_findings(world);
        let mode = &self.problem.mode;
        let each = self.rooms.iter().map(|room| {
            let scenario = resolve(world.document.design(), room);
            let study = StudyReport::run(BodyRole::Tool, (&scenario, mode), cancel)?;
            Ok(study.section((&scenario, mode), false).with(coil_section(&coils)))
        });
        Ok(self.layout_data(layout, &each.collect::<Result<Vec<_>, StudyError>>()?))
    }

    fn layouts(&self, layouts: &[Layout]) -> Vec<Section> {
        let data_of = |layout: &Layout| {
            let studies: Vec<Section> =
                layout.studies.iter().map(|study| study.section(None)).collect();
            self.layout_data(layout, &studies)
        };
        layouts.iter().map(data_of).collect()
    }

    fn layout_data(&self, layout: &Layout, studies: &[Section]) -> Section {
        let start = &self.optimized.start;
        let rooms: Vec<_> = self.rooms.iter().zip(studies).collect();
        let rooms = Table::of("rooms", &rooms)
            .data("environment", |(room, _)| room.name.clone())
            .data("figures", |(_, study)| (*study).clone());
        let sensors = |body: &RigidBody| body.sensors.iter().map(sensor_data).collect::<Vec<_>>();
        let change = |change: PoseChange| {
            Section::of([data("way_mm", change.way_mm), data("turn_deg", change.turn_deg)])
        };
        Section::of([
            data("objective", layout.objective),
            data("cost", layout.cost),
            data("tool", sensors(&layout.tool)),
            data("crf", layout.crf.as_ref().map(sensors)),
            data("tracker_from_crf", layout.tracker_from_crf.as_ref().map(pose_to_array)),
            data("crf_from_tool", pose_to_array(&layout.crf_from_tool)),
            data("crf_moved", layout.crf_change(start).map(change)),
            data("generator_moved", layout.generator_change(start).map(change)),
            data("figures", studies.first()),
        ])
        .with(rooms.done())
    }

    /// Start and best of one room beside each other.
    fn figures_table(&self, room: usize) -> Table {
        let [start, best] = [&self.optimized.start, &self.optimized.best].map(|layout| {
            move |metric: &Option<Metric>| value_text(layout.studies.get(room), *metric)
        });
        let requirement = self.problem.scenarios[room].requirement;
        let limit = |metric: Metric| requirement.and_then(|own| own.bound(metric));
        let figures = shown(self.problem.goal).into_iter().map(Some);
        let outside = "trials with a sensor outside";
        Table::of("", &figures.chain([None]).collect::<Vec<_>>())
            .text("", " ", |metric| metric.map_or(outside, |metric| metric.label()))
            .number("", "start (95 %)", 0, start)
            .number("", "best (95 %)", 0, best)
            .number("", "limit", 0, |metric| {
                metric.and_then(limit).map_or_else(String::new, |limit| limit.to_string())
            })
            .text("", " ", |metric| metric.map_or("", |metric| metric.unit()))
            .done()
    }
}

/// A figure with its interval, or the number of trials outside.
fn value_text(study: Option<&Study>, metric: Option<Metric>) -> String {
    let Some(study) = study else { return String::new() };
    let Some(metric) = metric else { return with_separators(study.room_field.outside) };
    study.figures.get(metric).map_or_else(String::new, |figure| {
        let interval = figure.interval_text(4).map_or_else(String::new, |own| format!(" ({own})"));
        format!("{}{interval}", figure.value_text(4))
    })
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

fn gain_data(gain: &RoomGain) -> Section {
    let each = ErrorOf::ALL.map(|of| data(of.json_key(), differences_json(&gain.differences, of)));
    Section::of([data("environment", &gain.room)]).with_all(each)
}

/// What the best gains in fields that the search did not see, in the words of `compare`.
fn gain_section(goal: Goal, gain: &RoomGain) -> Section {
    let shown = shown(goal);
    let own: Vec<_> = gain.differences.iter().filter(|own| shown.contains(&own.metric)).collect();
    let table = Table::of("", &own)
        .text("", " ", |own| own.metric.label())
        .text("", " ", |own| difference_words(own, START));
    Section::default().with(table.done()).headed("in fields that the search did not see:")
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

/// The sensors and poses that are not those of the start.
fn layout_section(layout: &Layout, start: &Layout) -> Section {
    let bodies = [
        ("tool", Some(&layout.tool), Some(&start.tool)),
        ("crf", layout.crf.as_ref(), start.crf.as_ref()),
    ];
    let mut rows: Vec<[String; 3]> = Vec::new();
    for (key, body, before) in bodies {
        let (Some(body), Some(before)) = (body, before) else { continue };
        let is_new = |sensor: &&Sensor| !before.sensors.contains(sensor);
        rows.extend(body.sensors.iter().filter(is_new).map(|sensor| sensor_cells(key, sensor)));
        let is_gone = |sensor: &&Sensor| body.sensors.iter().all(|own| own.name != sensor.name);
        rows.extend(before.sensors.iter().filter(is_gone).map(|sensor| {
            [format!("{} ({key})", sensor.name), "removed".to_owned(), String::new()]
        }));
    }
    let poses = [
        ("CRF in the tracker frame", layout.tracker_from_crf, start.tracker_from_crf),
        ("tool", Some(layout.crf_from_tool), Some(start.crf_from_tool)),
    ];
    for (name, now, _) in poses.iter().filter(|(_, now, before)| now != before) {
        let Some(now) = now else { continue };
        let [x, y, z, qw, qx, qy, qz] = pose_to_array(now);
        rows.push([
            (*name).to_owned(),
            format!("({x:.2}, {y:.2}, {z:.2}) mm"),
            format!("rotation ({qw:.4}, {qx:.4}, {qy:.4}, {qz:.4})"),
        ]);
    }
    let moved = [
        ("the CRF on the patient", layout.crf_change(start)),
        ("the field generator", layout.generator_change(start)),
    ];
    rows.extend(moved.into_iter().filter_map(|(name, change)| {
        let PoseChange { way_mm, turn_deg } = change?;
        let turned = format!("turned by {turn_deg:.2}°");
        Some([name.to_owned(), format!("moved by {way_mm:.2} mm"), turned])
    }));
    let table = (0..3).fold(Table::of("", &rows), |table, column| {
        table.text("", " ", move |row| row[column].clone())
    });
    Section::default().with(table.done())
}

fn sensor_cells(key: &str, sensor: &Sensor) -> [String; 3] {
    let at = sensor.position_in_body;
    let axis = sensor.axis_in_body().map_or_else(String::new, |axis| {
        let [x, y, z] = [axis.x, axis.y, axis.z].map(rounded);
        format!("axis ({x:.3}, {y:.3}, {z:.3})")
    });
    let position = format!("({:.2}, {:.2}, {:.2}) mm", at.x, at.y, at.z);
    [format!("{} ({key})", sensor.name), position, axis]
}

fn sensor_data(sensor: &Sensor) -> Section {
    let turned = match sensor.orientation {
        SensorOrientation::Marker => None,
        SensorOrientation::FiveDof(axis) => Some(data("axis", axis.as_slice())),
        SensorOrientation::SixDof(q) => Some(data("rotation", [q.w, q.i, q.j, q.k])),
    };
    Section::of([
        data("sensor", &sensor.name),
        data("degrees_of_freedom", sensor.orientation.degrees_of_freedom()),
        data("position_mm", sensor.position_in_body.coords.as_slice()),
    ])
    .with_all(turned)
    .with_all(sensor.coil.map(|coil| data("coil_mm", coil)))
}

/// A part of an axis as it is printed, without the sign of a zero.
fn rounded(part: f64) -> f64 {
    (part * 1e3).round() / 1e3 + 0.0
}

/// What each number of sensors can do.
fn pareto_section(goal: Goal, pareto: &[Layout]) -> Section {
    if pareto.len() < 2 {
        return Section::default();
    }
    let what = match goal {
        Goal::Requirement(_) => "part of the limit".to_owned(),
        Goal::Figure(metric) => format!("{} {}", metric.label(), metric.unit()),
    };
    let sensors = |layout: &Layout| {
        let bodies = [Some(&layout.tool), layout.crf.as_ref()].into_iter().flatten();
        bodies.flat_map(|body| &body.sensors).cloned().collect::<Vec<_>>()
    };
    let mut table = Table::of("", pareto).number("", "sensors", 0, |own| sensors(own).len());
    if pareto.iter().any(|layout| layout.cost.is_some()) {
        let cost = |cost: f64| cost.to_string();
        table = table.number("", "cost", 0, |own| own.cost.map_or_else(String::new, cost));
    }
    let table = table
        .number("", what, 4, |own| own.objective)
        .number("", "kinds", 0, |own| kinds(&sensors(own)))
        .done();
    Section::default().with(table).headed("the best of each number of sensors:")
}

/// How many there are of each kind, in order of the first of each.
fn kinds(sensors: &[Sensor]) -> String {
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
