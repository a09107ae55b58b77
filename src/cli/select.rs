//! `select`: cross-validates model sizes and regularisation, names the best, and fits it.

use super::as_is::AsIsArgs;
use super::choose::{self, HoldOutArg};
use super::fit::{DEFAULT_RCOND, MapArg, MethodArg, SensorsArg, Target, VolumeArg, WeightsArg};
use super::fit::{as_json as fit_json, file_name, fit_and_write, read};
use super::jitter::JitterArgs;
use super::kinds;
use super::model_kind::{LossArg, tried_kinds};
use super::output::{self, Format, Shown};
use anyhow::{Context, bail};
use clap::Args;
use serde_json::{Value, json};
use std::path::PathBuf;
use trackwright_calibration::kind_choice::{TriedKind, choose_kind};
use trackwright_calibration::learning_curve::{LEAST_ROWS, LearningPoint, doubled, learning_curve};
use trackwright_calibration::room_choice::{Chosen, RowLabels};
use trackwright_calibration::room_model::RoomModel;
use trackwright_field::samples::SampleSet;
use trackwright_field::selection::{
    DEFAULT_FOLDS, DEFAULT_RIDGES, DEFAULT_SEED, Scored, Scores, SelectSettings,
};
use trackwright_formats::signature::ENVIRONMENT;
use trackwright_geometry::directions::DirectionSet;
use trackwright_project::Files;
use trackwright_report::room::{map_name, method_name};
use trackwright_report::{learning_chart, selection, selection_chart};
use trackwright_simulation::figures::with_separators;

/// Orders that are tried where none are named.
const DEFAULT_ORDERS: &str = "1-6";

/// Size of the chart in pixels.
const CHART_SIZE: (u32, u32) = (960, 640);

#[derive(Debug, Args)]
pub struct SelectArgs {
    /// Measurement table (CSV): ideal_x … ideal_qz, measured_x … measured_qz; mm, unit quaternions
    data: PathBuf,

    /// Kinds of models to try on the same rows held out, of bernstein, symmetric (Bernstein with an
    /// axis turned round having the same error), kriging and harmonic
    #[arg(long, value_name = "LIST", default_value = "bernstein")]
    models: String,

    /// Field generators of harmonic models, each of them tried: planar-nine, anser, a file
    /// (*.generator.ron), or learn
    #[arg(long, value_name = "NAME|FILE|learn,…")]
    generator: Option<String>,

    /// Degree of harmonic models, 1 to 10; 2 to 8 are tried where left out
    #[arg(long, value_name = "L")]
    degree: Option<usize>,

    /// How the measurements of harmonic models count
    #[arg(long, value_enum, default_value_t)]
    loss: LossArg,

    /// Orders to try, as 1-6 or 1,2,4; 0, no correction, is tried always
    #[arg(long, value_name = "LIST", default_value = DEFAULT_ORDERS)]
    orders: String,

    /// Numbers of basis orientations to try, of 1, 6, 12, 14, 26 and 42; all that the table has
    /// orientations for where left out
    #[arg(long, value_name = "LIST")]
    directions: Option<String>,

    /// Ridges to try, each a part of the largest singular value; 0 and half decades from 1e-6 to
    /// 1 where left out
    #[arg(long, value_name = "LIST")]
    ridges: Option<String>,

    /// Parts that the rows are split into, each held out once
    #[arg(long, value_name = "K", default_value_t = DEFAULT_FOLDS)]
    folds: usize,

    /// Column that says which rows belong together; cluster, frame or pose where the table has one,
    /// else the clusters or places that the data show, if any
    #[arg(long, value_name = "COLUMN")]
    group: Option<String>,

    /// What is held out to choose by: rows, groups (as --group says), sensors (by the column
    /// sensor), or a column whose rows with equal text belong together; groups where there are any,
    /// else rows, where left out. The others are reported
    #[arg(long, value_name = "rows|groups|sensors|COLUMN")]
    hold_out: Option<HoldOutArg>,

    /// Seed of the random folds
    #[arg(long, value_name = "N", default_value_t = DEFAULT_SEED)]
    seed: u64,

    /// Environment to write (*.env.ron): the chosen model, fitted to all rows
    #[arg(short, long, value_name = "ENV")]
    output: Option<PathBuf>,

    /// Chart to write: what is left of held-out rows against order, one line a set of orientations
    #[arg(long, value_name = "FILE.svg")]
    plot: Option<PathBuf>,

    /// Chart to write: what each kind of model leaves of held-out rows against how many there are. The
    /// kinds are tried once for each number, on rows taken by chance
    #[arg(long, value_name = "FILE.svg")]
    learning_curve: Option<PathBuf>,

    /// Numbers of rows of the learning curve, as 250,500,1000; all, a half, a quarter and so on where
    /// left out
    #[arg(long, value_name = "LIST", requires = "learning_curve")]
    rows: Option<String>,

    /// How the orientations share the samples
    #[arg(long, value_enum, default_value_t)]
    method: MethodArg,

    /// Which pose the error is a function of: the ideal one to simulate, the measured one to compensate
    #[arg(long, value_enum, default_value_t)]
    map: MapArg,

    /// What the table's quaternions mean
    #[arg(long, value_enum, default_value_t)]
    sensors: SensorsArg,

    /// How an axis is shared among the three orientations around it
    #[arg(long, value_enum, default_value_t)]
    weights: WeightsArg,

    /// Singular values below this part of the largest count as zero
    #[arg(long, default_value = "1e-10", value_name = "R")]
    rcond: f64,

    /// The tracker's measurement volume, where it is known, for the environment
    #[arg(long, value_enum, default_value_t, requires = "output")]
    volume: VolumeArg,

    #[command(flatten)]
    jitter: JitterArgs,

    #[command(flatten)]
    as_is: AsIsArgs,

    /// How to print the figures
    #[arg(long, value_enum, default_value_t)]
    format: Format,
}

/// Cross-validates, prints the table, and writes what was asked for.
///
/// # Errors
/// Files that can't be used, lists that name nothing to try, rows that can't be folded.
pub fn run(args: &SelectArgs, files: &Files) -> anyhow::Result<()> {
    let environment = files.optional_output(args.output.as_deref())?;
    if let Some(environment) = &environment {
        environment.expect_kind(ENVIRONMENT)?;
    }
    let plot = files.optional_output(args.plot.as_deref())?;
    let curve_output = files.optional_output(args.learning_curve.as_deref())?;
    let mut settings = settings(args)?;
    let samples = read(files, &args.data, args.sensors, settings.map, args.as_is)?;
    if args.directions.is_none() && !samples.has_rotations {
        settings.direction_sets = vec![DirectionSet::One];
    }
    let labels = choose::row_labels(
        files,
        &args.data,
        &samples,
        args.group.as_deref(),
        args.hold_out.as_ref(),
    )?;
    let kinds =
        tried_kinds(files, &args.models, args.generator.as_deref(), args.degree, args.loss)?;
    refuse_unused(args, &kinds)?;
    let curve = learning_points(args, &samples, &labels, &settings, &kinds)?;
    let (chosen, choice) = if kinds == [TriedKind::Bernstein] {
        let chosen = choose::cross_validate(&args.data, &samples, labels, settings)?;
        (chosen, None)
    } else {
        let shown = Shown::new("cross-validating");
        let (chosen, choice) = choose_kind(&samples, labels, &settings, &kinds, &shown.task)
            .with_context(|| args.data.display().to_string())?;
        (chosen, Some(choice))
    };
    let mut value = as_json(&chosen, samples.samples.len());
    let mut text = as_text(args, &chosen, samples.samples.len());
    if let Some(choice) = &choice {
        value["models"] = kinds::as_json(choice);
        text.push('\n');
        text.push_str(&kinds::lines(choice, chosen.by.as_deref()).join("\n"));
    }
    if let Some(output) = &environment {
        let target = Target {
            data: &args.data,
            output,
            volume: args.volume,
            jitter: args.jitter.jitter(),
            with_support: true,
            sensors: chosen.selection.sensors,
        };
        let best = choice.as_ref().map(|choice| &choice.kinds[choice.best]);
        let fit_settings = match best {
            Some(kind) => kind.settings(&chosen.tried),
            None => chosen.settings(),
        };
        let model = best.map_or(RoomModel::PAPER, |kind| kind.model.clone());
        let room = fit_and_write(&target, &model, &fit_settings, &samples, None)?;
        value["fit"] = fit_json(&fit_settings, &room);
        text.push_str(&format!("\nwritten to {}", output.file().display()));
    }
    if let Some(plot) = &plot {
        let chart = selection_chart::chart(&file_name(&args.data), &chosen.selection);
        let svg = chart.to_svg(CHART_SIZE);
        plot.write_bytes(svg.as_bytes())?;
        text.push_str(&format!("\ndrawn to {}", plot.file().display()));
    }
    if let (Some(output), Some(points)) = (&curve_output, &curve) {
        value["learning_curve"] = kinds::curve_json(points);
        let chart = learning_chart::chart(&file_name(&args.data), points);
        let svg = chart.to_svg(CHART_SIZE);
        output.write_bytes(svg.as_bytes())?;
        text.push('\n');
        text.push_str(&kinds::curve_lines(points).join("\n"));
        text.push_str(&format!("\ndrawn to {}", output.file().display()));
    }
    match args.format {
        Format::Json => output::print_json(&value),
        Format::Text => output::print(&text),
    }
}

/// Refuses what none of the kinds that are tried would look at.
fn refuse_unused(args: &SelectArgs, kinds: &[TriedKind]) -> anyhow::Result<()> {
    let is_bernstein =
        |kind: &TriedKind| matches!(kind, TriedKind::Bernstein | TriedKind::Symmetric);
    let of_polynomials = [
        ("--orders", args.orders != DEFAULT_ORDERS),
        ("--directions", args.directions.is_some()),
        ("--ridges", args.ridges.is_some()),
        ("--method", args.method != MethodArg::default()),
        ("--weights", args.weights != WeightsArg::default()),
        ("--rcond", args.rcond.to_bits() != DEFAULT_RCOND.to_bits()),
    ];
    let given = of_polynomials.into_iter().find(|(_, is_given)| *is_given);
    if let (Some((name, _)), false) = (given, kinds.iter().any(is_bernstein)) {
        bail!("{name} belongs to Bernstein polynomials, which --models does not name");
    }
    if args.jitter.jitter().is_some() && args.output.is_none() {
        bail!("--jitter-position-mm is for the environment, expected --output with it");
    }
    Ok(())
}

/// The kinds on some of the rows, where a learning curve is asked for.
fn learning_points(
    args: &SelectArgs,
    samples: &SampleSet,
    labels: &RowLabels,
    settings: &SelectSettings,
    kinds: &[TriedKind],
) -> anyhow::Result<Option<Vec<LearningPoint>>> {
    if args.learning_curve.is_none() {
        return Ok(None);
    }
    let all = samples.samples.len();
    let expected = "numbers of rows, 50 and more, no more than the table has";
    let sizes = match &args.rows {
        None => doubled(all),
        Some(list) => numbers::<usize>("--rows", list, expected)?,
    };
    if let Some(size) = sizes.iter().find(|s| !(LEAST_ROWS..=all).contains(s)) {
        bail!("--rows: found {size}, expected {expected} ({all})");
    }
    if sizes.is_empty() {
        bail!("--learning-curve: found {all} rows, expected {LEAST_ROWS} at least");
    }
    let shown = Shown::new("cross-validating some of the rows");
    let points = learning_curve(samples, labels, settings, kinds, &sizes, &shown.task)
        .with_context(|| args.data.display().to_string())?;
    Ok(Some(points))
}

fn settings(args: &SelectArgs) -> anyhow::Result<SelectSettings> {
    let mut orders = orders(&args.orders)?;
    orders.push(0);
    let direction_sets = match &args.directions {
        None => DirectionSet::ALL.to_vec(),
        Some(list) => numbers::<usize>("--directions", list, "1, 6, 12, 14, 26 or 42")?
            .into_iter()
            .map(|m| DirectionSet::try_from(m).context("--directions"))
            .collect::<Result<_, _>>()?,
    };
    let ridges = match &args.ridges {
        None => DEFAULT_RIDGES.to_vec(),
        Some(list) => numbers("--ridges", list, "numbers of zero or more")?,
    };
    Ok(SelectSettings {
        orders,
        direction_sets,
        ridges,
        folds: args.folds,
        seed: args.seed,
        method: args.method.into(),
        map: args.map.into(),
        weighting: args.weights.into(),
        rcond: args.rcond,
    })
}

/// `1-3,6` as 1, 2, 3, 6.
fn orders(list: &str) -> anyhow::Result<Vec<usize>> {
    let mut orders = Vec::new();
    for item in list.split(',').map(str::trim) {
        let (first, last) = item.split_once('-').unwrap_or((item, item));
        match (first.trim().parse::<usize>(), last.trim().parse::<usize>()) {
            // A range up to a number beyond any order is refused by its ends, not by its length.
            (Ok(first), Ok(last)) if first <= last => {
                orders.extend([first, last]);
                orders.extend(first..=last.min(trackwright_field::bernstein::MAX_ORDER));
            }
            _ => bail!("--orders: found {list:?}, expected orders as in 1-6 or 1,2,4"),
        }
    }
    Ok(orders)
}

fn numbers<T: std::str::FromStr>(
    option: &str,
    list: &str,
    expected: &str,
) -> anyhow::Result<Vec<T>> {
    list.split(',')
        .map(|item| item.trim().parse().ok())
        .collect::<Option<Vec<T>>>()
        .with_context(|| format!("{option}: found {list:?}, expected a list of {expected}"))
}

pub(super) fn scores_json(scores: &Scores) -> Value {
    json!({
        "position_rms_mm": scores.position_rms_mm,
        "position_max_mm": scores.position_max_mm,
        "angle_rms_deg": scores.angle_rms_rad.map(f64::to_degrees),
    })
}

fn as_json(chosen: &Chosen, samples: usize) -> Value {
    let (settings, selection) = (&chosen.tried, &chosen.selection);
    let model = |row: &Scored| {
        json!({
            "order": row.candidate.order,
            "directions": row.candidate.directions.len(),
            "ridge": row.candidate.ridge,
        })
    };
    let table: Vec<_> = selection
        .table
        .iter()
        .map(|row| {
            let mut value = model(row);
            value["coefficients"] = json!(row.candidate.coefficients());
            value["is_determined"] = json!(row.is_determined);
            value["cv"] = scores_json(row.deciding());
            value["cv_by_row"] = scores_json(&row.by_row);
            value["cv_by_group"] = json!(row.by_group.as_ref().map(scores_json));
            value["cv_by_sensor"] = json!(row.by_sensor.as_ref().map(scores_json));
            value["under_sampled_directions"] = json!(row.under_sampled);
            value["is_admissible"] = json!(row.is_admissible());
            value
        })
        .collect();
    let mut value = json!({
        "best": model(selection.best()),
        "least": model(selection.least()),
        "reason": choose::reason_of(chosen),
        "samples": samples,
        "folds": settings.folds,
        "seed": settings.seed,
        "method": method_name(settings.method),
        "map": map_name(settings.map),
        "left_out": selection
            .left_out
            .iter()
            .map(|(order, directions)| json!({"order": order, "directions": directions.len()}))
            .collect::<Vec<_>>(),
        "table": table,
    });
    choose::add_hold_outs(&mut value, chosen);
    value
}

/// One line a system, with the ridge that serves it best; the choice is marked.
fn as_text(args: &SelectArgs, chosen: &Chosen, samples: usize) -> String {
    let (settings, found) = (&chosen.tried, &chosen.selection);
    let by = chosen.by.as_deref();
    let held_out = selection::hold_out_text(found, found.decided_by, by).unwrap_or_default();
    let mut lines = vec![format!(
        "{}: {} samples, {held_out}, {}, {} map",
        file_name(&args.data),
        with_separators(samples),
        method_name(settings.method),
        map_name(settings.map),
    )];
    let head = selection::head(found).into_iter().map(str::to_owned);
    let mut rows = vec![(false, head.collect())];
    rows.extend(selection::rows(found).into_iter().map(|row| (row.is_chosen, row.cells)));
    lines.push(right_aligned(&rows));
    lines.extend(selection::notes(found));
    lines.extend(choose::lines(chosen));
    lines.join("\n")
}

/// Columns wide enough for their widest cell; marked rows begin with a star.
fn right_aligned(rows: &[(bool, Vec<String>)]) -> String {
    let columns = rows.iter().map(|(_, cells)| cells.len()).max().unwrap_or(0);
    let widths: Vec<usize> = (0..columns)
        .map(|k| {
            let cells = rows.iter().filter_map(|(_, cells)| cells.get(k));
            cells.map(|cell| cell.chars().count()).max().unwrap_or(0)
        })
        .collect();
    let line = |(is_marked, cells): &(bool, Vec<String>)| {
        let cells = cells.iter().zip(&widths);
        let cells: Vec<_> = cells.map(|(cell, &w)| format!("{cell:>w$}")).collect();
        format!("{} {}", if *is_marked { '*' } else { ' ' }, cells.join("  "))
    };
    rows.iter().map(line).collect::<Vec<_>>().join("\n")
}
