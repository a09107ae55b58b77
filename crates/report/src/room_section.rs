//! Fitted rooms and learned generators as results.

use crate::room::{harmonic_text, map_name, method_name};
use serde_json::Value;
use trackwright_calibration::room_fit::FittedRoom;
use trackwright_calibration::room_model::HarmonicReport;
use trackwright_field::computed::ModelKind;
use trackwright_field::fit::{FitMethod, FitSettings, Residuals, SystemReport};
use trackwright_field::harmonic::LearnedGenerator;
use trackwright_field::harmonic::learn::Start;
use trackwright_result::{Row, Section, Table, count, data, with_separators};

/// A fit: its settings, its systems, and what it leaves; `name` is that of the measurements.
pub fn fit_section(name: &str, settings: &FitSettings, room: &FittedRoom) -> Section {
    let (fitted, map) = (&room.fit, map_name(settings.map));
    let (kind, systems) = (fitted.model.kind(), fitted.systems.as_slice());
    let process = room.environment.process.as_ref();
    // Only polynomials have these.
    let own = (kind == ModelKind::Bernstein).then_some(settings);
    let of_systems = |value: fn(&SystemReport) -> Value| match (own.map(|own| own.method), systems)
    {
        (None, _) => Value::Null,
        (Some(FitMethod::Joint), [one]) => value(one),
        (Some(_), all) => all.iter().map(value).collect(),
    };
    let samples = with_separators(fitted.samples);
    let title = format!("{name}: {samples} samples, {}, {map} map", model_text(settings, room));
    let section = Section::of([
        data("samples", fitted.samples),
        data("model", kind.name()),
        data("order", own.map(|own| own.order)),
        data("directions", own.map(|own| own.directions.len())),
        data("method", own.map(|own| method_name(own.method))),
        data("map", map),
        data("rank", of_systems(|system| system.rank.into())),
        data("condition", of_systems(|system| system.condition.into())),
        data("system_samples", of_systems(|system| system.samples.into())),
        data("ambiguous", fitted.ambiguous),
        data("process_samples", process.map(|process| process.rows.len())),
    ])
    .with_all(room.harmonic.as_ref().map(|own| data("harmonic", harmonic_section(own))))
    .with(title);
    with_residuals(section, room).with_all(systems_line(systems)).with_all(subset_line(room))
}

fn model_text(settings: &FitSettings, room: &FittedRoom) -> String {
    match (room.fit.model.kind(), &room.harmonic) {
        (ModelKind::Kriging, _) => "kriging".to_owned(),
        (_, Some(harmonic)) => harmonic_text(harmonic),
        _ => format!(
            "order {}, {} orientation{}, {}",
            settings.order,
            settings.directions.len(),
            if settings.directions.len() == 1 { "" } else { "s" },
            method_name(settings.method),
        ),
    }
}

/// A figure of what is left of measurements, before and after the fit.
struct Left {
    keys: [String; 2],
    label: String,
    values: [Option<f64>; 2],
}

impl Left {
    fn of([key, name]: [&str; 2], both: [&Residuals; 2]) -> [Self; 2] {
        let figure = |figure: &str, label: &str, values| Self {
            keys: ["before", "after"].map(|when| format!("{key}.{when}.{figure}")),
            label: format!("{name} {label}"),
            values,
        };
        let positions = both.map(|residuals| Some(residuals.position_rms_mm));
        let angles = both.map(|residuals| residuals.angle_rms_rad.map(f64::to_degrees));
        [
            figure("position_rms_mm", "position RMS, mm", positions),
            figure("angle_rms_deg", "angle RMS, °", angles),
        ]
    }
}

/// Adds what is left of the measurements, and of those that were not fitted.
fn with_residuals(section: Section, room: &FittedRoom) -> Section {
    let fitted = &room.fit;
    let mut figures = Vec::from(Left::of(["train", "trained"], [&fitted.before, &fitted.after]));
    let provenance = room.environment.provenance.as_ref();
    if let Some(own) = provenance.and_then(|provenance| provenance.holdout.as_ref()) {
        figures.extend(Left::of(["holdout", "held out"], [&own.before, &own.after]));
    }
    let each = figures.iter().flat_map(|figure| figure.keys.iter().zip(figure.values));
    let each: Vec<Row> = each.map(|(key, value)| data(key.clone(), value)).collect();
    // Orientations may not have been measured.
    figures.retain(|figure| figure.values.iter().all(Option::is_some));
    let table = Table::of("", &figures)
        .text("", " ", |figure| figure.label.clone())
        .number("", "before", 4, |figure| figure.values[0])
        .number("", "after", 4, |figure| figure.values[1]);
    section.with(data("holdout", ())).with_all(each).with(table.done())
}

/// How well the measurements determine polynomials.
fn systems_line(systems: &[SystemReport]) -> Option<String> {
    let by_condition = |a: &&SystemReport, b: &&SystemReport| a.condition.total_cmp(&b.condition);
    let (least, most) =
        (systems.iter().min_by(by_condition)?, systems.iter().max_by(by_condition)?);
    Some(format!(
        "independent equations {} of {} at least, samples {} at least, condition number {:.1} to {:.1}",
        systems.iter().map(|system| system.rank).min()?,
        least.unknowns,
        with_separators(systems.iter().map(|system| system.samples).min()?),
        least.condition,
        most.condition
    ))
}

/// What only a part of the samples is used for, where they are too many.
fn subset_line(room: &FittedRoom) -> Option<String> {
    let process = room.environment.process.as_ref()?;
    let (used, all) = (process.rows.len(), process.measured_rows);
    let what = match room.fit.model.kind() {
        ModelKind::Kriging => "model and expected figures",
        _ => "expected figures",
    };
    (used < all).then(|| {
        format!(
            "{what}: from {} of the {} samples, chosen at random",
            with_separators(used),
            with_separators(all)
        )
    })
}

fn harmonic_section(harmonic: &HarmonicReport) -> Section {
    Section::of([
        data("generator", &harmonic.generator.name),
        data("coils", harmonic.generator.coils.len()),
        data("degree", harmonic.settings.degree),
        data("ridge", harmonic.settings.ridge),
        data("noise_mm", harmonic.noise_mm),
        data("down_weighted", harmonic.down_weighted),
        data("learned", harmonic.learned.as_ref().map(learned_section)),
    ])
}

/// What was learned of a generator.
pub fn learned_section(learned: &LearnedGenerator) -> Section {
    let starts = Table::of("starts", &learned.starts)
        .text("", " ", |report| if report.start == learned.start { "*" } else { "" })
        .text("start", "start", |report| start_name(report.start))
        .number("held_out.position_rms_mm", "held out: RMS, mm", 4, |report| {
            report.held_out.position_rms_mm
        })
        .number("held_out.angle_rms_deg", "RMS, °", 4, |report| {
            report.held_out.angle_rms_rad.map(f64::to_degrees)
        })
        .data("coils", |report| report.coils)
        .data("steps", |report| report.steps)
        .data("has_converged", |report| report.has_converged);
    Section::of([
        data("name", &learned.generator.name),
        count("samples", "samples", learned.measurements),
        count("used", "learned from", learned.used).part(),
        count("held_out_samples", "held out to choose the start", learned.held_out).part(),
        count("degree", "degree of the room's harmonics", learned.degree),
        count("coils", "coils, learned again from all", learned.generator.coils.len()),
        data("start", start_name(learned.start)),
        data("has_converged", learned.has_converged),
    ])
    .with(starts.done())
}

/// What learning began with, in words.
fn start_name(start: Start) -> &'static str {
    match start {
        Start::Triads => "three triads of dipoles",
        Start::Circle => "twelve dipoles on a circle",
    }
}
