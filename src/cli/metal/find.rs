//! `metal find`: the metal that disturbs a room.

use crate::cli::fit::{HAS_ROLLS, read};
use crate::cli::prelude::*;
use clap::ArgAction;
use trackwright_field::generator::Generator;
use trackwright_field::samples::{MeasurementContent, MeasurementSet};
use trackwright_field::selection::{DEFAULT_FOLDS, DEFAULT_SEED};
use trackwright_formats::signature::ENVIRONMENT;
use trackwright_metal::identify::compare::{Compared, ComparedModel, compare};
use trackwright_metal::identify::{
    FoundBody, Identification, IdentifySettings, Interval, MAX_BODIES, SourceModel, Verdict,
    identify, room_of_found,
};
use trackwright_project::SampleReading;
use trackwright_report::found_metal::{compared_rows, kind_name, misfit_line, verdict_line};
use trackwright_report::text_table::columns;

#[derive(Debug, Args)]
pub struct FindArgs {
    /// Measurement table (CSV): ideal_x … ideal_qz, measured_x … measured_qz; mm, unit quaternions
    data: PathBuf,

    /// The tracker's field generator: planar-nine, anser, or a file (*.generator.ron)
    #[arg(long, value_name = "NAME|FILE")]
    generator: Option<String>,

    /// Environment to write (*.env.ron): a room of the bodies found, as spheres, to be looked at in the
    /// editor and simulated in
    #[arg(short, long, value_name = "ENV")]
    output: Option<PathBuf>,

    /// Bodies to look for at most, 1 to 3
    #[arg(long, value_name = "N", default_value_t = MAX_BODIES)]
    most: usize,

    /// What the table's quaternions mean
    #[arg(long = "sensors", value_name = "SENSORS", value_parser = HAS_ROLLS, default_value = "5dof",
        action = ArgAction::Set)]
    has_rolls: bool,

    /// Parts that the rows are split into, each held out once
    #[arg(long, value_name = "K", default_value_t = DEFAULT_FOLDS)]
    folds: usize,

    /// Seed of the random folds
    #[arg(long, value_name = "N", default_value_t = DEFAULT_SEED)]
    seed: u64,

    /// Leave out the comparison with other models
    #[arg(long)]
    no_comparison: bool,

    #[command(flatten)]
    common: TableArgs,
}

/// Finds metal and prints it.
///
/// # Errors
/// Files that can't be used, no generator, tables without orientations or with too few rows.
pub fn run(args: &FindArgs, files: &Files) -> anyhow::Result<()> {
    let output = files.optional_output(args.output.as_deref())?;
    if let Some(output) = &output {
        output.expect_kind(ENVIRONMENT)?;
    }
    let generator = generator(files, args.generator.as_deref())?;
    let named = || args.data.display().to_string();
    // What is suspected of the table is reported as `fit` does.
    read(files, &args.data, SampleReading::of_distortion(args.has_rolls), args.common.as_is)?;
    let mut set = files.read_measurements(&args.data)?;
    if args.has_rolls {
        set.content = MeasurementContent::SixDof;
    }
    let settings = IdentifySettings { most: args.most, folds: args.folds, seed: args.seed };
    let shown = Shown::new("looking for metal");
    let part = if args.no_comparison { 1.0 } else { 0.6 };
    let found = identify(&shown.task.subtask(0.0, part), &generator, &set, &settings)
        .with_context(named)?;
    let compared = match args.no_comparison {
        true => Vec::new(),
        false => compare(&shown.task.subtask(part, 1.0), &generator, &set, &settings, &found)
            .with_context(named)?,
    };
    drop(shown);
    if let Some(output) = &output {
        match room_of_found(&file_name(&args.data), &generator, &set, &found) {
            Some((bare, metal)) => output.write_room(&bare, &metal)?,
            None => output::note("note: no body is determined, no environment was written"),
        }
    }
    args.common.format.print(
        || as_json(&generator, &settings, &found, &compared),
        || as_text(args, &generator, &set, &found, &compared),
    )
}

fn generator(files: &Files, name: Option<&str>) -> anyhow::Result<Generator> {
    let expected = "expected planar-nine, anser, or a file (*.generator.ron)";
    match name {
        None => bail!("found no --generator, {expected}"),
        Some("learn") => bail!(
            "--generator: found \"learn\", {expected}: a generator that is learned from the same table has the metal's part in it"
        ),
        Some(name) => match Generator::built_in(name) {
            Some(generator) => Ok(generator),
            None => files.read_generator(Path::new(name)),
        }
        .map_err(Into::into),
    }
}

fn verdict_name(verdict: Verdict) -> &'static str {
    match verdict {
        Verdict::Found => "found",
        Verdict::NothingFound => "nothing_found",
        Verdict::CannotTell => "cannot_tell",
        Verdict::NotCompact => "not_compact",
    }
}

fn model_name(model: SourceModel) -> &'static str {
    match model {
        SourceModel::Dipoles => "dipoles",
        SourceModel::Spheres => "spheres",
    }
}

fn compared_key(model: ComparedModel) -> &'static str {
    match model {
        ComparedModel::None => "none",
        ComparedModel::Bodies => "bodies",
        ComparedModel::Harmonic { .. } => "harmonic",
        ComparedModel::PerDirection(_) => "bernstein",
    }
}

fn as_json(
    generator: &Generator,
    settings: &IdentifySettings,
    found: &Identification,
    compared: &[Compared],
) -> Value {
    let ends = |interval: &Interval| json!([finite(interval.low), finite(interval.high)]);
    let body = |body: &FoundBody| {
        let center = body.source.center_mm;
        let cov = body.center_cov_mm2;
        let row = |i: usize| (0..3).map(|j| finite(cov[(i, j)])).collect::<Vec<_>>();
        json!({
            "kind": kind_name(body.kind),
            "is_determined": body.doubt.is_none(),
            "doubt": body.doubt.map(|doubt| doubt.to_string()),
            "center_mm": [center.x, center.y, center.z],
            "center_within95_mm": body.center_mm.iter().map(ends).collect::<Vec<_>>(),
            "center_cov_mm2": (0..3).map(row).collect::<Vec<_>>(),
            "half_length_mm": finite(body.half_length_mm),
            "strength_mm3": body.source.strength_mm3,
            "strength_within95_mm3": ends(&body.strength_mm3),
            "radius_mm": body.source.radius_mm(),
            "radius_within95_mm": ends(&body.radius_mm),
            "nearest_sample_mm": body.nearest_mm,
        })
    };
    let tried = found.tried.iter().map(|tried| {
        json!({"bodies": tried.bodies, "held_out_loss": tried.held_out_loss, "left": tried.left})
    });
    let held_out = compared.iter().map(|compared| {
        let overall = &compared.scores.overall;
        let mut value = json!({
            "model": compared_key(compared.model),
            "position_rms_mm": overall.position_rms_mm,
            "angle_rms_deg": overall.angle_rms_rad.map(f64::to_degrees),
        });
        match compared.model {
            ComparedModel::Harmonic { degree } => value["degree"] = json!(degree),
            ComparedModel::PerDirection(candidate) => {
                value["order"] = json!(candidate.order);
                value["directions"] = json!(candidate.directions.len());
                value["ridge"] = json!(candidate.ridge);
            }
            ComparedModel::None | ComparedModel::Bodies => {}
        }
        value
    });
    json!({
        "verdict": verdict_name(found.verdict),
        "generator": generator.name,
        "samples": found.measurements,
        "down_weighted": found.down_weighted,
        "noise_mm": found.noise.position_mm,
        "noise_deg": found.noise.rotation_rad.to_degrees(),
        "disturbance_rms_mm": found.disturbance.position_mm,
        "disturbance_rms_deg": found.disturbance.rotation_rad.to_degrees(),
        "unexplained": found.unexplained,
        "model": model_name(found.model),
        "bodies": found.bodies.iter().map(body).collect::<Vec<_>>(),
        "tried": tried.collect::<Vec<_>>(),
        "folds": settings.folds,
        "held_out": held_out.collect::<Vec<_>>(),
    })
}

/// `null` for what is not known at all.
fn finite(value: f64) -> Value {
    if value.is_finite() { json!(value) } else { Value::Null }
}

fn as_text(
    args: &FindArgs,
    generator: &Generator,
    set: &MeasurementSet,
    found: &Identification,
    compared: &[Compared],
) -> String {
    let sensors = if set.content == MeasurementContent::SixDof { "6-DOF" } else { "5-DOF" };
    let mut lines = vec![
        format!(
            "{}: {} samples, {sensors}, generator {}",
            file_name(&args.data),
            with_separators(found.measurements),
            generator.name
        ),
        format!(
            "noise {:.3} mm and {:.3}° a component; disturbance {:.3} mm and {:.3}° RMS",
            found.noise.position_mm,
            found.noise.rotation_rad.to_degrees(),
            found.disturbance.position_mm,
            found.disturbance.rotation_rad.to_degrees(),
        ),
    ];
    if found.down_weighted > 0 {
        lines.push(format!(
            "{} samples contradict the others and count for less",
            with_separators(found.down_weighted)
        ));
    }
    lines.push(String::new());
    lines.push(verdict_line(found));
    for (k, body) in found.bodies.iter().enumerate() {
        lines.extend(body_lines(k + 1, body));
    }
    lines.extend(misfit_line(found));
    if !compared.is_empty() {
        lines.push(String::new());
        lines.push(format!("held out by row, {} folds:", args.folds));
        let head = ["model", "position RMS, mm", "angle RMS, °"].map(str::to_owned).to_vec();
        let rows = compared_rows(compared).into_iter().map(Vec::from);
        let rows: Vec<_> = std::iter::once(head).chain(rows).collect();
        lines.extend(columns(&rows, 1));
    }
    lines.join("\n")
}

fn body_lines(number: usize, body: &FoundBody) -> Vec<String> {
    let center = body.source.center_mm;
    // Plus zero makes of a rounded -0 a 0.
    let tenths = |value_mm: f64| (10.0 * value_mm).round() / 10.0 + 0.0;
    let axis =
        |k: usize| format!("{:.1} ± {:.1}", tenths(center[k]), body.center_mm[k].half_length());
    let mut lines = vec![
        format!(
            "{number}  {}, like a sphere of {:.1} mm radius ({:.1} to {:.1})",
            kind_name(body.kind),
            body.source.radius_mm(),
            body.radius_mm.low,
            body.radius_mm.high
        ),
        format!("   at x {}, y {}, z {} mm (95 %)", axis(0), axis(1), axis(2)),
        format!(
            "   strength {:.0} mm³ ({:.0} to {:.0}), nearest sample {:.0} mm away",
            body.source.strength_mm3,
            body.strength_mm3.low,
            body.strength_mm3.high,
            body.nearest_mm
        ),
    ];
    if let Some(doubt) = &body.doubt {
        lines.push(format!("   cannot tell: {doubt}"));
    }
    lines
}
