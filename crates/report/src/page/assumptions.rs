//! Everything that the figures rest on: the room and its model, how the study was run, versions.

use super::{Report, file_name, table_of};
use crate::room::{MODEL_ERROR, is_simulated, map_name, method_name};
use maud::{Markup, html};
use trackwright_field::computed::{FieldSource, ModelKind};
use trackwright_field::environment::{Environment, HoldoutProvenance, Provenance};
use trackwright_field::fit::Residuals;
use trackwright_field::{DistortionModel, OutsidePolicy};
use trackwright_geometry::directions::Weighting;
use trackwright_result::with_separators;
use trackwright_simulation::{AxisRange, Mode, Motion};

/// A line of a table of two columns.
type Fact = [String; 2];

fn fact(name: &str, value: impl Into<String>) -> Fact {
    [name.to_owned(), value.into()]
}

/// Room, study, files and versions.
pub fn section(report: &Report) -> Markup {
    let room = &report.world.environment;
    html! {
        section id="assumptions" {
            h2 { "What this rests on" }
            p {
                "Every figure is computed, not measured: sensors of a virtual tool and reference are displaced by the errors that the model of a measured room gives, both are fitted again, and the tip is compared (Fischer and Taylor, MICCAI 2005). "
                "The tracker's own scatter from one reading to the next is not in them."
            }
            h3 { "Room" }
            (facts(&of_room(report, room)))
            h3 { "Study" }
            (facts(&of_study(report)))
            (motion(report))
            h3 { "Files and versions" }
            (facts(&of_files(report)))
        }
    }
}

fn facts(facts: &[Fact]) -> Markup {
    html! {
        table class="data facts" {
            tbody { @for [name, value] in facts { tr { th scope="row" { (name) } td { (value) } } } }
        }
    }
}

fn of_room(report: &Report, room: &Environment) -> Vec<Fact> {
    let model = &room.model;
    let [low, high] = [model.bounds().min_mm, model.bounds().max_mm];
    let span = |k: usize| format!("{:.0} to {:.0}", low[k], high[k]).replace('-', "−");
    let mut facts = vec![fact("room", room.name.as_str())];
    facts.extend(of_model(model));
    facts.extend([
        fact("map", map_name(model.map())),
        fact(
            "box of the model, tracker frame",
            format!("x {}, y {}, z {}\u{2009}mm", span(0), span(1), span(2)),
        ),
        fact("volume of the tracker", room.volume.map_or("not stated", |volume| volume.name())),
    ]);
    match &room.provenance {
        None if is_simulated(room) => {
            facts.push(fact("measurements", "none, the room is simulated"));
        }
        None => facts.push(fact(
            "measurements",
            "none stated: an ideal room, or one whose file does not state where it comes from",
        )),
        Some(from) => facts.extend(of_measurements(from, model.kind())),
    }
    facts.push(fact(
        "scatter of the tracker's readings",
        room.jitter.map_or("not stated".to_owned(), |jitter| {
            format!(
                "{}\u{2009}mm and {:.3}° standard deviation{}",
                jitter.position_mm,
                jitter.angle_rad.to_degrees(),
                if jitter.growth.is_some() { " at the generator, more away from it" } else { "" }
            )
        }),
    ));
    let weight = room.orientation_weight(report.world.document.design().orientation_weight_mm);
    facts.push(fact(
        "weight of an axis against a position",
        format!("{:.4}\u{2009}mm, {}", weight.value_mm, weight.source.label()),
    ));
    facts
}

/// What kind of model a room has, and what only that kind has.
fn of_model(model: &DistortionModel) -> Vec<Fact> {
    match model.computed().map(|computed| computed.source()) {
        Some(FieldSource::Kriging(kriging)) => {
            let rows = with_separators(kriging.weights().len());
            vec![fact("model", format!("kriging, of {rows} measurements"))]
        }
        Some(FieldSource::Harmonic(harmonic)) => vec![
            fact("model", "harmonic, the fields of a generator's coils"),
            fact("field generator", harmonic.generator().name.as_str()),
            fact("degree of the model", harmonic.degree().to_string()),
        ],
        Some(FieldSource::Simulated(_)) => {
            vec![fact("model", "simulated, the fields of a generator's coils among metal")]
        }
        Some(FieldSource::Of(_)) | None => vec![
            fact(
                "order of the model",
                match model.order() {
                    0 => "0, a field without distortion".to_owned(),
                    order => format!("{order}, Bernstein polynomials"),
                },
            ),
            fact("basis orientations", model.directions().len().to_string()),
            fact(
                "weights between orientations",
                match model.weighting() {
                    Weighting::Area => "areas on the sphere",
                    Weighting::Gnomonic => "gnomonic",
                },
            ),
        ],
    }
}

fn of_measurements(from: &Provenance, kind: ModelKind) -> Vec<Fact> {
    let fit = match kind {
        ModelKind::Bernstein => format!("{}, ridge {}", method_name(from.method), from.ridge),
        kind => kind.name().to_owned(),
    };
    let mut facts = vec![
        fact("measurements", from.data.as_str()),
        fact("samples", with_separators(from.samples)),
        fact("date of the measurements", "not stated by the room's file"),
        fact("fit", fit),
        fact(
            "error of the samples themselves",
            before_and_after(&from.train_before, &from.train_after),
        ),
    ];
    facts.push(match &from.holdout {
        None => fact(MODEL_ERROR, "not known: no measurements were held out"),
        Some(holdout) => fact(MODEL_ERROR, held_out(holdout)),
    });
    facts
}

fn held_out(holdout: &HoldoutProvenance) -> String {
    format!(
        "{} ({}, {} samples)",
        before_and_after(&holdout.before, &holdout.after),
        holdout.data,
        with_separators(holdout.samples)
    )
}

fn before_and_after(before: &Residuals, after: &Residuals) -> String {
    let one = |residuals: &Residuals| {
        let angle = residuals.angle_rms_rad.map(|rad| format!(" and {:.3}°", rad.to_degrees()));
        format!("{:.3}\u{2009}mm{}", residuals.position_rms_mm, angle.unwrap_or_default())
    };
    format!("{} RMS; {} without a model", one(after), one(before))
}

fn of_study(report: &Report) -> Vec<Fact> {
    let study = report.study;
    let figures = &study.study.room_field;
    let mode = match &study.mode {
        Mode::Single => "the design's own pose".to_owned(),
        Mode::Motion => "the range of motion below".to_owned(),
        Mode::Input(_) => match &report.extras.input_file {
            None => "given poses".to_owned(),
            Some(file) => format!("given poses, {file}"),
        },
    };
    let outside = match study.scenario.outside {
        OutsidePolicy::Clamp => "the nearest point of the model's box stands for it",
        OutsidePolicy::Extrapolate => "the polynomials are used as they are",
        OutsidePolicy::Reject => "its position is left out",
    };
    let pivot = pivot(report).map(|pivot| fact("turns about", pivot));
    let mut facts = vec![
        fact("poses", mode),
        fact("positions", with_separators(figures.trials)),
        fact("a sensor outside the model's box", outside),
        fact("positions with such a sensor", with_separators(figures.outside)),
        fact(
            "positions with a sensor out of the tracker's volume",
            match report.world.environment.volume {
                None => "not known, the volume is not stated".to_owned(),
                Some(_) => with_separators(figures.out_of_volume),
            },
        ),
        fact("random numbers", "none, so there is no seed: the same files give the same figures"),
    ];
    facts.splice(1..1, pivot);
    facts
}

/// The range of motion that is studied.
fn studied(report: &Report) -> Option<Motion> {
    let study = &report.study;
    study.scenario.motion.filter(|_| matches!(study.mode, Mode::Motion))
}

/// What the turns are about, if there are any.
fn pivot(report: &Report) -> Option<String> {
    let motion = studied(report).filter(Motion::has_turns)?;
    let words = motion.pivot.words("tool", report.reference());
    Some(match motion.pivot.point() {
        None => words,
        Some([x, y, z]) => format!("{words}, at ({x}, {y}, {z})\u{2009}mm").replace('-', "−"),
    })
}

fn motion(report: &Report) -> Markup {
    let Some(motion) = studied(report) else { return html! {} };
    let head = ["axis", "from", "to", "step"].map(str::to_owned);
    html! { (table_of(&head, &axes(&motion, report.reference()), "data motion")) }
}

fn axes(motion: &Motion, reference: &str) -> Vec<Vec<String>> {
    let row = |axis: &str, range: AxisRange| {
        let (name, unit) = match axis.strip_prefix('r') {
            None => (format!("along {axis} of the {reference}"), "\u{2009}mm"),
            Some(about) => (format!("about {about} of the {reference}"), "°"),
        };
        let value = |value: f64| format!("{value}{unit}").replace('-', "−");
        vec![name, value(range.min), value(range.max), value(range.step)]
    };
    motion.axes().into_iter().filter_map(|(axis, range)| Some(row(axis, range?))).collect()
}

fn of_files(report: &Report) -> Vec<Fact> {
    let design = report.world.document.design();
    let mut facts = Vec::new();
    if let Some(file) = &report.extras.design_file {
        facts.push(fact("design", file.as_str()));
    }
    facts.push(fact("room", file_name(&design.environment)));
    for (role, body) in design.bodies() {
        facts.push(fact(role.name(), file_name(&body.reference)));
    }
    facts.push(fact("program", format!("trackwright {}", env!("CARGO_PKG_VERSION"))));
    if let Some(date) = &report.extras.date {
        facts.push(fact("date of this report", date.as_str()));
    }
    facts
}
