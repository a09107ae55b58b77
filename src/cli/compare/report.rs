//! What `compare` prints.

use crate::cli::expected;
use serde_json::{Map, Value, json};
use trackwright_formats::comparison_table::Names;
use trackwright_geometry::pose::pose_to_array;
use trackwright_simulation::ErrorOf;
use trackwright_simulation::Metric;
use trackwright_simulation::Summary;
use trackwright_simulation::comparison::{
    Comparison, Difference, Row, WorstPose, difference_words, met_words, notes, worst_words,
};
use trackwright_simulation::expected::{judged, requirement_figures};

/// Longest name that a table shows whole.
const MAX_NAME: usize = 36;

pub(super) fn as_json(found: &Comparison, names: &Names) -> Value {
    let room = |number: usize| {
        json!({
            "name": Names::of(&names.rooms, number),
            "file": Names::of(&names.room_files, number),
            "uncertainty_unknown": found.rooms_unknown[number].map(|why| why.to_string()),
        })
    };
    let design = |number: usize| {
        json!({
            "name": Names::of(&names.designs, number),
            "file": Names::of(&names.design_files, number),
        })
    };
    json!({
        "baseline": Names::of(&names.designs, found.baseline),
        "designs": (0..names.designs.len()).map(design).collect::<Vec<_>>(),
        "environments": (0..names.rooms.len()).map(room).collect::<Vec<_>>(),
        "rows": found.rows.iter().map(|row| row_as_json(row, names)).collect::<Vec<_>>(),
    })
}

fn row_as_json(row: &Row, names: &Names) -> Value {
    let mut value = json!({
        "design": Names::of(&names.designs, row.design),
        "design_file": Names::of(&names.design_files, row.design),
        "environment": Names::of(&names.rooms, row.room),
        "environment_file": Names::of(&names.room_files, row.room),
        "no_figures": row.measured.as_ref().err().map(ToString::to_string),
    });
    let Ok(measured) = &row.measured else {
        return value;
    };
    let figures = &measured.figures;
    value["trials"] = json!(figures.trials);
    value["outside"] = json!(figures.outside);
    value["out_of_volume"] = json!(figures.out_of_volume);
    value["without_field"] = json!(measured.without_field);
    value["rejected"] = json!(figures.rejected);
    value["position_mm"] = json!(figures.position_mm);
    value["angle_deg"] = json!(figures.angle_deg);
    value["worst"] = json!(figures.worst);
    value["worst"]["pose"] = json!(pose_to_array(&measured.worst_pose.crf_from_tool));
    value["worst"]["offsets"] = offsets_as_json(&measured.worst_pose);
    value["requirement"] = json!(requirement_figures(figures));
    if let Some(expected) = &measured.expected {
        expected::add_json(&mut value, expected, &judged(figures, Some(expected)));
    }
    value["poorly_determined"] = json!(figures.poorly_determined);
    if let Some(free) = &figures.free_axis {
        value["free_axis"] = json!(free);
        value["position_mm_determined"] = json!(figures.position_mm_determined);
    }
    value["against_baseline"] = match &row.against_baseline {
        None => Value::Null,
        Some(against) => json!({
            "position_mm": differences_as_json(&against.differences, ErrorOf::Position),
            "angle_deg": differences_as_json(&against.differences, ErrorOf::Angle),
            "motion_differs": against.motion_differs,
            "requirement_differs": against.requirement_differs,
            "environment_differs": against.room_differs,
        }),
    };
    value
}

/// `x_mm`, `rz_deg`.
fn offsets_as_json(worst: &WorstPose) -> Value {
    let each = worst.offsets.iter();
    let named = each.map(|(axis, value)| {
        let unit = if axis.starts_with('r') { "deg" } else { "mm" };
        (format!("{axis}_{unit}"), json!(value))
    });
    Value::Object(named.collect())
}

fn differences_as_json(differences: &[Difference], of: ErrorOf) -> Value {
    let each = differences.iter().filter(|d| d.metric.of == of);
    let named: Map<String, Value> =
        each.map(|d| (d.metric.summary.key().to_owned(), json!(d))).collect();
    Value::Object(named)
}

pub(super) fn as_text(found: &Comparison, names: &Names) -> String {
    let labels = short(&names.designs);
    let mut rooms: Vec<usize> = found.rows.iter().map(|row| row.room).collect();
    rooms.sort_unstable();
    rooms.dedup();
    let mut parts = Vec::new();
    for room in rooms {
        let rows: Vec<&Row> = found.rows.iter().filter(|row| row.room == room).collect();
        parts.push(one_line(Names::of(&names.rooms, room)));
        parts.push(table(&rows, &labels, found.baseline));
        for row in rows {
            parts.extend(about(row, &labels, found.baseline));
        }
        if let Some(why) = found.rooms_unknown[room] {
            parts.push(format!("  the room does not say how far its field may be off: {why}"));
        }
        parts.push(String::new());
    }
    parts.pop();
    parts.join("\n")
}

/// The figures, a line a design.
fn table(rows: &[&Row], labels: &[String], baseline: usize) -> String {
    let figures = Metric::bounded().map(|m| format!("{} {}", m.summary.short(), m.unit()));
    let last = ["required", "ΔRMS mm", "ΔRMS °"].map(str::to_owned);
    let header: Vec<String> = std::iter::once(String::new()).chain(figures).chain(last).collect();
    let columns = header.len();
    let mut lines = vec![header];
    for row in rows {
        let mut cells = vec![Names::of(labels, row.design).to_owned()];
        match &row.measured {
            Err(_) => cells.extend((1..columns).map(|_| "–".to_owned())),
            Ok(measured) => {
                let value = |metric| measured.figures.value(metric);
                cells.extend(Metric::bounded().map(|metric| format!("{:.4}", value(metric))));
                cells.push(met_words(measured).to_owned());
                cells.extend(changes(row, baseline));
            }
        }
        lines.push(cells);
    }
    let width = |column: usize| {
        let cells = lines.iter().filter_map(|line| line.get(column));
        cells.map(|cell| cell.chars().count()).max().unwrap_or(0)
    };
    let widths: Vec<usize> = (0..columns).map(width).collect();
    let aligned = lines.iter().map(|line| {
        let cells = line.iter().zip(&widths).enumerate();
        let padded = cells.map(|(column, (cell, &width))| match column {
            0 => format!("{cell:<width$}"),
            _ => format!("{cell:>width$}"),
        });
        format!("  {}", padded.collect::<Vec<_>>().join("  ")).trim_end().to_owned()
    });
    aligned.collect::<Vec<_>>().join("\n")
}

/// The differences of the RMS of tip and angle.
fn changes(row: &Row, baseline: usize) -> [String; 2] {
    if row.design == baseline {
        return ["baseline".to_owned(), String::new()];
    }
    let Some(against) = &row.against_baseline else {
        return ["–", "–"].map(str::to_owned);
    };
    [ErrorOf::Position, ErrorOf::Angle].map(|of| {
        let found = against
            .differences
            .iter()
            .find(|d| d.metric.of == of && d.metric.summary == Summary::Rms);
        found.map_or_else(String::new, |d| format!("{:+.4}", d.difference))
    })
}

/// What a line of the table leaves out.
fn about(row: &Row, labels: &[String], baseline: usize) -> Vec<String> {
    let name = Names::of(labels, row.design);
    let mut lines = vec![format!("  {name}")];
    match &row.measured {
        Err(why) => lines.push(format!("    no figures: {why}")),
        Ok(measured) => {
            if let Some(against) = &row.against_baseline {
                let shown = Metric::bounded();
                let width = shown.clone().map(|m| m.label().chars().count()).max().unwrap_or(0);
                lines.extend(shown.map(|metric| {
                    let difference = &against.differences[metric.index()];
                    let words = difference_words(difference, Names::of(labels, baseline));
                    format!("    {:<width$}  {words}", metric.label())
                }));
            }
            let expected = measured.expected.iter().flat_map(expected::rows);
            lines.extend(
                expected.map(|(label, value, unit)| format!("    {label}  {value} {unit}")),
            );
            lines.push(format!("    {}", worst_words(measured)));
            let notes = notes(measured, row.against_baseline.as_ref());
            lines.extend(notes.into_iter().map(|note| format!("    note: {note}")));
        }
    }
    lines
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
    fn long_names_are_cut_unless_that_makes_two_the_same() {
        let name = |end: &str| format!("A shaver with three sensors along its shaft, {end}");
        let one = short(&[name("a"), "b".to_owned()]);
        assert_eq!(one[0], "A shaver with three sensors along i…");
        assert_eq!(one[0].chars().count(), MAX_NAME);
        assert_eq!(short(&[name("a"), name("b")]), [name("a"), name("b")]);
        assert_eq!(short(&["a\tb\n\u{1b}[31m".to_owned()]), ["a b  [31m"]);
    }
}
