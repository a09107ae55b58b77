//! Designs held against each other, as a result.

use serde_json::{Map, Value, json};
use std::collections::BTreeMap;
use trackwright_formats::comparison_table::Names;
use trackwright_geometry::pose::pose_to_array;
use trackwright_result::{Section, Table, data};
use trackwright_simulation::comparison::{
    Comparison, Difference, Row, difference_words, met_words, notes, worst_words,
};
use trackwright_simulation::{ErrorOf, Figure, Metric};

/// Longest name that a table shows whole.
const MAX_NAME: usize = 36;

/// A comparison as `compare` prints it.
pub fn comparison_section(found: &Comparison, names: &Names) -> Section {
    let designs: Vec<usize> = (0..names.designs.len()).collect();
    let designs = Table::of("designs", &designs)
        .data("name", |&k| Names::of(&names.designs, k))
        .data("file", |&k| Names::of(&names.design_files, k));
    let rooms: Vec<usize> = (0..names.rooms.len()).collect();
    let rooms = Table::of("environments", &rooms)
        .data("name", |&k| Names::of(&names.rooms, k))
        .data("file", |&k| Names::of(&names.room_files, k))
        .data("uncertainty_unknown", |&k| found.rooms_unknown[k].map(|why| why.to_string()));
    let rows: Vec<Section> = found.rows.iter().map(|row| row_section(row, names)).collect();
    let mut of_rooms: BTreeMap<usize, Vec<&Row>> = BTreeMap::new();
    for row in &found.rows {
        of_rooms.entry(row.room).or_default().push(row);
    }
    let labels = short(&names.designs);
    let in_room = |(room, rows): (usize, Vec<&Row>)| {
        let about = rows.iter().map(|row| about(row, &labels, found.baseline));
        let unknown = found.rooms_unknown[room]
            .map(|why| format!("the uncertainty of the room's field is unknown: {why}"));
        let below = Section::default()
            .with(table(&rows, &labels, found.baseline))
            .with_all(about)
            .with_all(unknown)
            .below(2);
        Section::default().with(one_line(Names::of(&names.rooms, room))).with(below)
    };
    Section::of([data("baseline", Names::of(&names.designs, found.baseline)), data("rows", rows)])
        .with_all([designs.done(), rooms.done()])
        .with_all(of_rooms.into_iter().map(in_room))
}

/// A design in a room, as programs read it.
fn row_section(row: &Row, names: &Names) -> Section {
    let section = Section::of([
        data("design", Names::of(&names.designs, row.design)),
        data("design_file", Names::of(&names.design_files, row.design)),
        data("environment", Names::of(&names.rooms, row.room)),
        data("environment_file", Names::of(&names.room_files, row.room)),
        data("no_figures", row.measured.as_ref().err().map(ToString::to_string)),
    ]);
    let Ok(measured) = &row.measured else {
        return section;
    };
    let worst = &measured.worst_pose;
    let offsets: BTreeMap<String, f64> = worst
        .offsets
        .iter()
        .map(|(axis, value)| {
            let unit = if axis.starts_with('r') { "deg" } else { "mm" };
            (format!("{axis}_{unit}"), *value)
        })
        .collect();
    let against = row.against_baseline.as_ref().map(|against| {
        Section::of([
            data("position_mm", differences_json(&against.differences, ErrorOf::Position)),
            data("angle_deg", differences_json(&against.differences, ErrorOf::Angle)),
            data("motion_differs", against.motion_differs),
            data("requirement_differs", against.requirement_differs),
            data("environment_differs", against.room_differs),
        ])
    });
    section.with(measured.study.section(None)).with_all([
        data("worst.pose", pose_to_array(&worst.crf_from_tool)),
        data("worst.offsets", offsets),
        data("against_baseline", against),
    ])
}

/// Differences of one kind of error, by their summaries.
pub fn differences_json(differences: &[Difference], of: ErrorOf) -> Value {
    let each = differences.iter().filter(|d| d.metric.of == of);
    let named: Map<String, Value> =
        each.map(|d| (d.metric.summary.key().to_owned(), json!(d))).collect();
    Value::Object(named)
}

/// The figures, a line a design.
fn table(rows: &[&Row], labels: &[String], baseline: usize) -> Table {
    let mut table =
        Table::of("", rows).text("", "design", |row| Names::of(labels, row.design).to_owned());
    for metric in Metric::bounded() {
        let head = format!("{} {}", metric.summary.short(), metric.unit());
        table = table.number("", head, 4, |row| {
            Some(row.measured.as_ref().ok()?.study.figures.get(metric)?.value)
        });
    }
    table = table.number("", "required", 0, |row| row.measured.as_ref().ok().map(met_words));
    for metric in [Metric::TIP_RMS, Metric::ANGLE_RMS] {
        table = table.number("", format!("ΔRMS {}", metric.unit()), 0, |row| {
            if row.design == baseline && row.measured.is_ok() {
                let is_first = metric == Metric::TIP_RMS;
                return Some(if is_first { "baseline" } else { "" }.to_owned());
            }
            let difference = row.against_baseline.as_ref()?.differences.get(metric.index())?;
            Some(format!("{:+.4}", difference.difference))
        });
    }
    table.done()
}

/// What a line of the table leaves out.
fn about(row: &Row, labels: &[String], baseline: usize) -> Section {
    let details = match &row.measured {
        Err(why) => Section::default().with(format!("no figures: {why}")),
        Ok(measured) => {
            let figures = &measured.study.figures;
            let width = Metric::bounded().map(|m| m.label().chars().count()).max().unwrap_or(0);
            let differences = row.against_baseline.iter().flat_map(|against| {
                Metric::bounded().map(|metric| {
                    let difference = &against.differences[metric.index()];
                    let words = difference_words(difference, Names::of(labels, baseline));
                    format!("{:<width$}  {words}", metric.label())
                })
            });
            let notes = notes(measured, row.against_baseline.as_ref());
            Section::default()
                .with_all(differences)
                .with_all(figures.bounded().map(Figure::row))
                .with_all(figures.no_interval_statement())
                .with(worst_words(measured))
                .with_all(notes.into_iter().map(|note| format!("note: {note}")))
        }
    };
    let name = Names::of(labels, row.design).to_owned();
    Section::default().with(name).with(details.below(2)).below(0)
}

/// Names for a table: on one line, and cut where that leaves them different.
fn short(names: &[String]) -> Vec<String> {
    let whole: Vec<String> = names.iter().map(|name| one_line(name)).collect();
    let cut: Vec<String> = whole
        .iter()
        .map(|name| match name.chars().count() > MAX_NAME {
            false => name.clone(),
            true => {
                let kept: String = name.chars().take(MAX_NAME - 1).collect();
                format!("{}…", kept.trim_end())
            }
        })
        .collect();
    let is_own = |name: &String| cut.iter().filter(|other| *other == name).count() == 1;
    whole
        .into_iter()
        .zip(&cut)
        .map(|(whole, cut)| if is_own(cut) { cut.clone() } else { whole })
        .collect()
}

/// A name as a terminal can show it.
fn one_line(name: &str) -> String {
    let plain = |c: char| if c.is_control() { ' ' } else { c };
    name.chars().map(plain).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn long_names_are_cut_where_they_stay_different() {
        let name = |end: &str| format!("A shaver with three sensors along its shaft, {end}");
        let one = short(&[name("a"), "b".to_owned()]);
        assert_eq!(one[0], "A shaver with three sensors along i…");
        assert_eq!(one[0].chars().count(), MAX_NAME);
        assert_eq!(short(&[name("a"), name("b")]), [name("a"), name("b")]);
        assert_eq!(short(&["a\tb\n\u{1b}[31m".to_owned()]), ["a b  [31m"]);
    }
}
