//! Chosen models of rooms, and what they were chosen from, as results.

use crate::kinds::{kind_items, kind_reason};
use crate::room::{map_name, method_name};
use crate::room_section::fit_section;
use crate::selection::{
    SENSOR_INTERVAL, grouped_line, head, hold_out_lines, hold_out_name, hold_out_text, notes,
    reason, rows, sensors_line,
};
use std::collections::BTreeSet;
use trackwright_calibration::kind_choice::{Decided, KindChoice, KindScored};
use trackwright_calibration::learning_curve::LearningPoint;
use trackwright_calibration::room_choice::Chosen;
use trackwright_calibration::room_fit::FittedRoom;
use trackwright_calibration::room_model::RoomModel;
use trackwright_field::selection::places::Places;
use trackwright_field::selection::sensors::SensorSpread;
use trackwright_field::selection::{Candidate, Scores, Selection};
use trackwright_result::{Item, Row, Section, Table, data, deg, with_separators};

/// What `select` chose among polynomials, and among kinds of models where several were tried; `name` is
/// that of the measurements.
pub fn selection_section(
    name: &str,
    samples: usize,
    chosen: &Chosen,
    kinds: Option<&KindChoice>,
) -> Section {
    let (tried, found, by) = (&chosen.tried, &chosen.selection, chosen.by.as_deref());
    let (method, map) = (method_name(tried.method), map_name(tried.map));
    let title = format!(
        "{name}: {} samples, {}, {method}, {map} map",
        with_separators(samples),
        hold_out_text(found, found.decided_by, by).unwrap_or_default(),
    );
    let left_out = Table::of("left_out", &found.left_out)
        .data("order", |(order, _)| *order)
        .data("directions", |(_, directions)| directions.len());
    let mut section = Section::of([
        data("samples", samples),
        data("best", Section::of(candidate_rows(&found.best().candidate))),
        data("least", Section::of(candidate_rows(&found.least().candidate))),
        data("seed", tried.seed),
        data("method", method),
        data("map", map),
    ])
    .with(choice_section(chosen))
    .with(left_out.done())
    .with(tried_table(found))
    .with(title);
    // Where no kind is named, only the kinds are shown.
    if !tried.only_contenders {
        section = section.with(system_table(found)).with_all(notes(found)).with_all(lines(chosen));
    }
    match kinds {
        Some(kinds) => {
            section.with(data("models", kinds_section(kinds))).with_all(kind_items(kinds, by))
        }
        None => section,
    }
}

/// A fitted room, and how its model was decided; `name` is that of the measurements.
pub fn decided_section(name: &str, decided: &Decided, room: &FittedRoom) -> Section {
    let section = fit_section(name, &decided.settings, room);
    match (&decided.kinds, &decided.chosen) {
        (Some(kinds), chosen) => {
            let places = chosen.as_ref().and_then(|chosen| chosen.places.as_ref());
            section
                .with(data("models", kinds_section(kinds)))
                .noting(places.map(grouped_line).into_iter().chain([kind_reason(kinds)]))
        }
        (None, Some(chosen)) => {
            let best = chosen.selection.best();
            let selection = Section::of(candidate_rows(&best.candidate))
                .with(data("cv", scores_section(best.deciding())))
                .with(choice_section(chosen));
            section.with(data("selection", selection)).noting(lines(chosen))
        }
        (None, None) => section,
    }
}

/// What each kind of model leaves, by the number of measurements.
pub fn curve_items(points: &[LearningPoint]) -> [Item; 3] {
    let each: Vec<Section> = points
        .iter()
        .map(|point| kinds_section(&point.choice).with(data("rows", point.rows)))
        .collect();
    let kinds = points.iter().flat_map(|point| &point.choice.kinds);
    let names: BTreeSet<String> = kinds.map(KindScored::label).collect();
    let mut table = Table::of("", points).number("", "measurements", 0, |point| point.rows);
    for name in names {
        table = table.number("", name.clone(), 4, |point| {
            let kind = point.choice.kinds.iter().find(|kind| kind.label() == name);
            kind.map(|kind| kind.deciding().overall.position_rms_mm)
        });
    }
    let title = "position RMS of rows held out, mm, by number of measurements:";
    [data("learning_curve", each).into(), title.to_owned().into(), table.done().into()]
}

/// What was found of the rows, the chosen model in each hold-out, and why it was chosen.
fn lines(chosen: &Chosen) -> Vec<String> {
    let (found, by) = (&chosen.selection, chosen.by.as_deref());
    let mut lines: Vec<String> = chosen.places.as_ref().map(grouped_line).into_iter().collect();
    lines.extend(hold_out_lines(found, by));
    lines.extend(found.sensors.as_ref().map(sensors_line));
    lines.push(reason(found, by, chosen.tried.folds));
    lines
}

/// What was held out, how the chosen model did in each hold-out, and what was found of rows and
/// sensors.
fn choice_section(chosen: &Chosen) -> Section {
    let (found, by) = (&chosen.selection, chosen.by.as_deref());
    let groups = by.map(|by| Section::of([data("by", by), data("count", found.groups)]));
    let hold_outs = Table::of("hold_outs", &found.hold_outs)
        .data("by", |hold_out| hold_out_name(hold_out.by))
        .data("folds", |hold_out| hold_out.folds)
        .data("count", |hold_out| hold_out.count)
        .data("decides", |hold_out| hold_out.by == found.decided_by)
        .data("cv", |hold_out| found.best().held_out_by(hold_out.by).map(scores_section));
    Section::of([
        data("folds", chosen.tried.folds),
        data("reason", reason(found, by, chosen.tried.folds)),
        data("groups", groups),
        data("hold_out", hold_out_name(found.decided_by)),
        data("sensors", found.sensors.as_ref().map(sensors_section)),
        data("grouped", chosen.places.as_ref().map(places_section)),
    ])
    .with(hold_outs.done())
}

/// All that was tried, for programs.
fn tried_table(found: &Selection) -> Table {
    Table::of("table", &found.table)
        .data("order", |row| row.candidate.order)
        .data("directions", |row| row.candidate.directions.len())
        .data("ridge", |row| row.candidate.ridge)
        .data("coefficients", |row| row.candidate.coefficients())
        .data("is_determined", |row| row.is_determined)
        .data("cv", |row| scores_section(row.deciding()))
        .data("cv_by_row", |row| row.by_row.as_ref().map(scores_section))
        .data("cv_by_group", |row| row.by_group.as_ref().map(scores_section))
        .data("cv_by_sensor", |row| row.by_sensor.as_ref().map(scores_section))
        .data("under_sampled_directions", |row| row.under_sampled)
        .data("is_admissible", |row| row.is_admissible())
        .done()
}

/// For people a row a system of polynomials, with the ridge that serves it best; the choice is marked.
fn system_table(found: &Selection) -> Table {
    let rows = rows(found);
    // The mark is before the order.
    let mut table = Table::of("", &rows).text("", "  order", |row| {
        format!("{} {:>5}", if row.is_chosen { '*' } else { ' ' }, row.cells[0])
    });
    for (k, name) in head(found).into_iter().enumerate().skip(1) {
        table = table.number("", name, 0, move |row| row.cells[k].clone());
    }
    table.done()
}

/// Kinds of models, each with what it leaves.
fn kinds_section(choice: &KindChoice) -> Section {
    let kinds: Vec<Section> = choice
        .kinds
        .iter()
        .enumerate()
        .map(|(place, kind)| kind_section(kind).with(data("is_chosen", place == choice.best)))
        .collect();
    let left_out = Table::of("left_out", &choice.left_out)
        .data("model", |(kind, _)| kind.clone())
        .data("reason", |(_, why)| why.clone());
    Section::of([data("kinds", kinds), data("reason", kind_reason(choice))]).with(left_out.done())
}

fn kind_section(kind: &KindScored) -> Section {
    let hold_outs = kind.scores.hold_outs.iter().map(|(by, scores)| {
        let of_one = hold_out_name(*by).trim_end_matches('s');
        data(format!("cv_by_{of_one}"), scores_section(&scores.overall))
    });
    let section = Section::of([
        data("model", kind.name()),
        data("cv", scores_section(&kind.deciding().overall)),
    ])
    .with_all(hold_outs);
    match (&kind.model, &kind.candidate) {
        (RoomModel::Harmonic(order), _) => section.with_all([
            data("generator", order.generator.name()),
            data("degree", order.degree),
            data("ridge", order.ridge),
        ]),
        (_, Some(candidate)) => section.with_all(candidate_rows(candidate)),
        (_, None) => section,
    }
}

fn candidate_rows(candidate: &Candidate) -> [Row; 3] {
    [
        data("order", candidate.order),
        data("directions", candidate.directions.len()),
        data("ridge", candidate.ridge),
    ]
}

/// What is left of rows held out.
fn scores_section(scores: &Scores) -> Section {
    Section::of([
        data("position_rms_mm", scores.position_rms_mm),
        data("position_max_mm", scores.position_max_mm),
        deg("angle_rms_deg", "", scores.angle_rms_rad),
    ])
}

fn sensors_section(spread: &SensorSpread) -> Section {
    let angles = spread.angle_interval_rad(SENSOR_INTERVAL);
    Section::of([
        data("count", spread.sensors),
        data("degrees_of_freedom", spread.degrees_of_freedom),
        data("position_mm", spread.position_std_dev_mm()),
        data("position_rms_mm", spread.position_rms_mm()),
        deg("angle_rms_deg", "", spread.angle_rms_rad()),
        data("intervals.position_rms_mm", spread.position_interval_mm(SENSOR_INTERVAL)),
        data("intervals.angle_rms_deg", angles.map(|ends| ends.map(f64::to_degrees))),
    ])
}

fn places_section(places: &Places) -> Section {
    let variogram = Table::of("variogram", &places.variogram)
        .data("distance_mm", |point| point.distance_mm)
        .data("semivariance_mm2", |point| point.semivariance_mm2)
        .data("pairs", |point| point.pairs);
    Section::of([
        data("places", places.count),
        data("width_mm", places.width_mm),
        data("dependence", places.dependence),
        data("correlation_length_mm", places.correlation_length_mm),
        data("nugget_mm2", places.nugget_mm2),
        data("sill_mm2", places.sill_mm2),
    ])
    .with(variogram.done())
}
